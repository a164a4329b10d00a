"""Files and folders that are either whole or not there."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import uuid
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

#: Beginning of the names of files that are being written.
WRITING = ".writing-"
#: Beginnings of the names of what runs that were killed leave.
_LEFT = (WRITING, ".partial-", ".old-", ".download-", ".receipts-")


class OccupiedError(ValueError):
    """A folder that would be replaced holds something else; the message names a file that would be lost."""


@dataclass(frozen=True)
class Kind:
    """A kind of folder that may be replaced by another of its kind, where it holds nothing else.

    Attributes
    ----------
    name : str
        Such as ``"dataset"``, for messages.
    own : callable
        Folder -> paths below it, apart by ``/``, of the files that belong to this kind of folder.
    """

    name: str
    own: Callable[[Path], Collection[str]]

    def check(self, folder: Path, place: Path | None = None) -> None:
        """Refuse a folder with files of anybody else's; one that is not there, or is empty, may be replaced.

        Parameters
        ----------
        folder : Path
        place : Path, optional
            The name of the folder in messages, where it has stepped aside.

        Raises
        ------
        OccupiedError
            If a file would be lost.
        NotADirectoryError
            If a file stands in the place.
        """
        place = place or folder
        if folder.exists() and not folder.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, "is there and is no folder", str(place))
        # Twice: between list and manifest another writer may have put a new folder into the place.
        if self._foreign(folder) is not None and (lost := self._foreign(folder)) is not None:
            raise OccupiedError(
                f"{place}: is no {self.name}, or not that alone: {lost!r} would be lost; name another folder"
            )

    def _foreign(self, folder: Path) -> str | None:
        """Return a file that does not belong to this kind of folder."""
        with suppress(FileNotFoundError):
            own = self.own(folder)
            for path in folder.rglob("*"):
                inside = path.relative_to(folder)
                ours = inside.as_posix() in own or any(part.startswith(_LEFT) for part in inside.parts)
                if not ours and (path.is_symlink() or not path.is_dir()):
                    return inside.as_posix()
        return None


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def text_entry(name: str, text: str) -> dict[str, Any]:
    """Return name, size and SHA-256 of a text that will be a file, as manifests list them."""
    content = text.encode()
    return {"file": name, "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}


def json_text(value: Mapping[str, Any] | list[Any]) -> str:
    """Return JSON, keys in the order given, with a newline at the end."""
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


@contextmanager
def writing(target: Path, beside: Path, run: str) -> Iterator[Path]:
    """Give a temporary path that takes the place of `target` when the block ends without an error.

    Parameters
    ----------
    target : Path
    beside : Path
        Folder of the temporary path, of the same file system.
    run : str
        Stands in the temporary name: what a run has left can be told from what others write.

    Yields
    ------
    Path
        Where to write the file. After an error or an interrupt nothing is left of it.
    """
    temporary = beside / f"{WRITING}{run}-{uuid.uuid4().hex[:8]}-{target.name}"
    try:
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        temporary.replace(target)
    finally:
        with suppress(OSError):
            temporary.unlink()


def take_place(made: Path, target: Path, kind: Kind | None = None) -> None:
    """Rename a folder to `target`, in place of one that is there.

    Whoever looks for `target` finds the old folder, the new one, or for the instant between two renames none;
    never a part of one. After an error or an interrupt the old one is there. So it is after a kill, but for
    a kill in that instant: then both stand whole beside the target, the old one under a name that begins with
    ``.old-``. Of several writers the last to finish stays.

    Parameters
    ----------
    made, target : Path
    kind : Kind, optional
        What alone may be replaced; anything by default.

    Raises
    ------
    OccupiedError
        If the target holds something else.
    FileNotFoundError
        If `made` is not there (any more).
    """
    old = target.parent / f".old-{target.name}.{os.getpid()}.{uuid.uuid4().hex[:8]}"
    try:
        while True:
            try:
                made.rename(target)
                break
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
            # The target exists: it steps aside, and the place is tried again. Another writer may be faster
            # each time.
            shutil.rmtree(old, ignore_errors=True)
            with suppress(FileNotFoundError):
                target.rename(old)
                if kind is not None:
                    # Now that it stands aside, nobody changes what is looked at.
                    kind.check(old, target)
    except BaseException as error:
        # Between the two renames nothing is in the place: the old folder returns, unless another writer was faster.
        with suppress(OSError):
            old.rename(target)
        if not isinstance(error, OccupiedError):
            shutil.rmtree(old, ignore_errors=True)
        raise
    shutil.rmtree(old, ignore_errors=True)


@contextmanager
def replacing(target: Path, kind: Kind | None = None) -> Iterator[Path]:
    """Give a temporary folder that takes the place of `target` (`take_place`) when the block ends without an error.

    Parameters
    ----------
    target : Path
    kind : Kind, optional
        What alone may be replaced; anything by default.

    Yields
    ------
    Path
        The temporary folder, beside the target. A kill leaves it there, under a name that begins with ``.partial-``.

    Raises
    ------
    OccupiedError
        If the target holds something else, before the block or at its end.
    """
    if kind is not None:
        kind.check(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.parent / f".partial-{target.name}.{os.getpid()}.{uuid.uuid4().hex[:8]}"
    partial.mkdir()
    try:
        yield partial
        for path in partial.rglob("*"):
            if path.is_file():
                with path.open("rb") as file:
                    os.fsync(file.fileno())
        take_place(partial, target, kind)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
