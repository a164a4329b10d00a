"""Where a dataset is written: a local folder, or a place that `pyarrow.fs` reaches, such as a bucket.

Files appear under their names only when they are whole. On a local disk they gather in a folder of their own, which
takes the dataset's place at the end; an object store has no renaming, so there the manifest, which comes last,
makes the files a dataset. Receipts, which say what is finished, never stand among the files of a dataset.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import tempfile
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from errno import ENOENT
from pathlib import Path
from typing import Any, Protocol, TypeAlias
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pyarrow.fs as pafs

from sinsdata.format.manifest import DATASET_FOLDER, NAME, DatasetError, all_files, is_sealed, read_manifest
from sinsdata.format.storage import WRITING, file_hash, take_place, writing

_URI = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")
_RECEIPTS = ".receipts-"


class Destination(Protocol):
    """A place for the files of one dataset. Workers get it by pickling."""

    def begin(self) -> None:
        """Get ready for files."""
        ...

    def write(self, name: str) -> AbstractContextManager[Path]:
        """Return a context that gives a local path; when it ends without an error, the file is there."""
        ...

    def digest(self, name: str) -> str | None:
        """Return the SHA-256 of a file that has gathered, None where it cannot be read."""
        ...

    def receipts(self) -> set[str]:
        """Return the names of the receipts of runs of this specification."""
        ...

    def receipt(self, name: str) -> str | None:
        """Return the text of a receipt, None where there is none."""
        ...

    def put_receipt(self, name: str, text: str) -> None:
        """Keep a receipt until the dataset is finished."""
        ...

    def finished(self) -> dict[str, Any] | None:
        """Return the manifest of a dataset that is in the place, None where there is none."""
        ...

    def intact(self, manifest: Mapping[str, Any]) -> bool:
        """Return whether the files of the dataset in the place are, byte by byte, those of its manifest."""
        ...

    def finish(self, texts: Mapping[str, str], files: Sequence[str]) -> None:
        """Write text files, the manifest last, and make the whole the dataset."""
        ...

    def taken(self) -> bool:
        """Return whether another run has finished the dataset and taken along what has gathered."""
        ...

    def leave(self) -> None:
        """Remove what this run has not finished; what is whole stays for another run."""
        ...

    def tidy(self) -> None:
        """Remove what runs of this specification have left beside the dataset."""
        ...


@dataclass(frozen=True)
class LocalFolder:
    """A folder on a disk that this machine sees.

    Attributes
    ----------
    target : Path
        The folder of the dataset, absolute: workers may have another working directory.
    key : str
        Of the specification: runs of the same specification share what they have finished.
    run : str
        Marks what this run is writing.
    """

    target: Path
    key: str
    run: str = field(default_factory=lambda: uuid.uuid4().hex[:8])

    @property
    def staging(self) -> Path:
        """The folder of receipts, of files that are being written, and of `gathered`."""
        return self.target.parent / f".partial-{self.target.name}-{self.key[:16]}"

    @property
    def gathered(self) -> Path:
        """The folder of whole files that becomes the dataset."""
        return self.staging / "files"

    def begin(self) -> None:
        """Make the folder in which the files gather.

        Raises
        ------
        sinsdata.format.storage.OccupiedError
            If the target holds something else than a dataset.
        """
        DATASET_FOLDER.check(self.target)
        self.gathered.mkdir(parents=True, exist_ok=True)

    def write(self, name: str) -> AbstractContextManager[Path]:
        """Give a path; whole or not at all.

        Raises
        ------
        FileNotFoundError
            When the block is entered or ends, if another run has finished the dataset.
        """
        return writing(self.gathered / name, self.staging, self.run)

    def digest(self, name: str) -> str | None:
        """Return the SHA-256 of a file that has gathered, None where it cannot be read."""
        with suppress(OSError):
            return file_hash(self.gathered / name)
        return None

    def receipts(self) -> set[str]:
        """Return the names of the receipts."""
        with suppress(OSError):
            return {path.name for path in self.staging.glob("[!.]*") if path.is_file()}
        return set()

    def receipt(self, name: str) -> str | None:
        """Return the text of a receipt, None where there is none that can be read."""
        with suppress(OSError, UnicodeDecodeError):
            return (self.staging / name).read_text(encoding="utf-8")
        return None

    def put_receipt(self, name: str, text: str) -> None:
        """Keep a receipt until the dataset is finished."""
        with writing(self.staging / name, self.staging, self.run) as path:
            path.write_text(text, encoding="utf-8", newline="\n")

    def finished(self) -> dict[str, Any] | None:
        """Return the manifest of the dataset that is in the place."""
        with suppress(DatasetError):
            return read_manifest(self.target)
        return None

    def intact(self, manifest: Mapping[str, Any]) -> bool:
        """Return whether the files of the dataset in the place are, byte by byte, those of its manifest."""
        with suppress(OSError, ValueError):
            return is_sealed((self.target / NAME).read_text(encoding="utf-8")) and all(
                file_hash(self.target / entry["file"]) == entry["sha256"] for entry in all_files(manifest)
            )
        return False

    def finish(self, texts: Mapping[str, str], files: Sequence[str]) -> None:
        """Write the texts and move the folder of files into its place.

        Raises
        ------
        sinsdata.format.storage.OccupiedError
            If something else than a dataset has come there meanwhile.
        """
        for name, text in texts.items():
            with self.write(name) as path:
                path.write_text(text, encoding="utf-8", newline="\n")
        if missing := {*files, *texts} - {path.name for path in self.gathered.iterdir()}:
            raise FileNotFoundError(ENOENT, "a file that was finished is gone", str(self.gathered / min(missing)))
        take_place(self.gathered, self.target, DATASET_FOLDER)
        self.tidy()

    def taken(self) -> bool:
        """Return whether another run has finished the dataset and taken along what has gathered."""
        return not self.gathered.is_dir()

    def leave(self) -> None:
        """Remove what this run was writing, and the folder if nothing else is in it."""
        with suppress(FileNotFoundError):  # another run may finish, and tidy up, at this very moment
            for path in list(self.staging.glob(f"{WRITING}{self.run}-*")):
                path.unlink(missing_ok=True)
        for folder in (self.gathered, self.staging):
            with suppress(OSError):
                folder.rmdir()

    def tidy(self) -> None:
        """Remove receipts and what other runs, killed or beaten, were writing."""
        # At one stroke out of the way, then file by file: a run that begins anew meanwhile has a folder of its own, and
        # one that was writing here finds all of it gone, not some.
        away = self.staging.with_name(f".old-{self.staging.name.lstrip('.')}.{self.run}")
        with suppress(FileNotFoundError):
            self.staging.rename(away)
        shutil.rmtree(away, ignore_errors=True)


@dataclass(frozen=True)
class RemoteFolder:
    """A folder in a file system of pyarrow.

    Attributes
    ----------
    uri : str
        Of the folder of the dataset, such as ``s3://bucket/data/dual_precession/paper``.
    key : str
        Of the specification.
    """

    uri: str
    key: str
    _opened: list[tuple[pafs.FileSystem, str]] = field(default_factory=list, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        return {"uri": self.uri, "key": self.key, "_opened": []}

    def _place(self, name: str = "") -> tuple[pafs.FileSystem, str]:
        if not self._opened:
            self._opened.append(pafs.FileSystem.from_uri(self.uri))
        system, base = self._opened[0]
        return system, f"{base}/{name}" if name else base

    def _entries(self, name: str = "") -> list[pafs.FileInfo]:
        system, place = self._place(name)
        entries: list[pafs.FileInfo] = system.get_file_info(pafs.FileSelector(place, allow_not_found=True))
        return entries

    @property
    def _receipts(self) -> str:
        return f"{_RECEIPTS}{self.key[:16]}"

    def begin(self) -> None:
        """Make the folders, where the file system has folders."""
        system, place = self._place(self._receipts)
        system.create_dir(place, recursive=True)

    @contextmanager
    def write(self, name: str) -> Iterator[Path]:
        """Give a local path; the whole file is sent when the block ends."""
        with tempfile.TemporaryDirectory(prefix="sinsbench-") as folder:
            path = Path(folder, Path(name).name)
            yield path
            system, place = self._place(name)
            # Not through a stream of Python's: an interrupt would close it, and a part would stand for the whole.
            pafs.copy_files(str(path), place, pafs.LocalFileSystem(), system)

    def digest(self, name: str) -> str | None:
        """Return the SHA-256 of a file, None where it cannot be read."""
        system, place = self._place(name)
        digest = hashlib.sha256()
        with suppress(OSError), system.open_input_stream(place) as stream:
            while part := stream.read(2**20):
                digest.update(part)
            return digest.hexdigest()
        return None

    def _text(self, name: str) -> str | None:
        system, place = self._place(name)
        with suppress(OSError, UnicodeDecodeError), system.open_input_stream(place) as stream:
            return str(stream.read().decode())
        return None

    def receipts(self) -> set[str]:
        """Return the names of the receipts."""
        return {info.base_name for info in self._entries(self._receipts) if info.type == pafs.FileType.File}

    def receipt(self, name: str) -> str | None:
        """Return the text of a receipt, None where there is none."""
        return self._text(f"{self._receipts}/{name}")

    def put_receipt(self, name: str, text: str) -> None:
        """Keep a receipt until the dataset is finished."""
        with self.write(f"{self._receipts}/{name}") as path:
            path.write_text(text, encoding="utf-8", newline="\n")

    def finished(self) -> dict[str, Any] | None:
        """Return the manifest of the dataset that is in the place.

        Raises
        ------
        DatasetError
            If a manifest is there that this version cannot read.
        """
        if NAME not in {info.base_name for info in self._entries()}:
            return None
        with tempfile.TemporaryDirectory(prefix="sinsbench-") as folder:
            Path(folder, NAME).write_text(self._text(NAME) or "", encoding="utf-8", newline="\n")
            return read_manifest(Path(folder))

    def intact(self, manifest: Mapping[str, Any]) -> bool:
        """Return whether the files are, byte by byte, those of the manifest: they are fetched to see it."""
        with suppress(ValueError):
            return is_sealed(self._text(NAME) or "") and all(
                self.digest(entry["file"]) == entry["sha256"] for entry in all_files(manifest)
            )
        return False

    def finish(self, texts: Mapping[str, str], files: Sequence[str]) -> None:
        """Send the texts, the manifest last, after removing tables that are none of this dataset's."""
        system, _ = self._place()
        for name in {info.base_name for info in self._entries()} - {*files, *texts}:
            if name.endswith(".parquet"):
                system.delete_file(self._place(name)[1])
        for name in sorted(texts, key=lambda name: name == NAME):
            with self.write(name) as path:
                path.write_text(texts[name], encoding="utf-8", newline="\n")
        self.tidy()

    def taken(self) -> bool:
        """Return False: files do not move here."""
        return False

    def leave(self) -> None:
        """Leave what is there for another run."""

    def tidy(self) -> None:
        """Remove receipts."""
        for info in self._entries():
            if info.type == pafs.FileType.Directory and info.base_name == self._receipts:
                self._place()[0].delete_dir(info.path)


#: A folder as users give it: a path or a URI.
Place: TypeAlias = Path | str


def _is_uri(out: Place) -> bool:
    return isinstance(out, str) and bool(_URI.match(out))


def shown(out: Place, dataset: str, tier: str) -> Path | str:
    """Return the path or URI of a dataset as people may see it: without credentials and options."""
    if not _is_uri(out):
        return Path(out) / dataset / tier
    parts = urlsplit(str(out))
    return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}{parts.path.rstrip('/')}/{dataset}/{tier}"


def destination(out: Place, dataset: str, tier: str, key: str) -> Destination:
    """Return the place ``out/dataset/tier``.

    Raises
    ------
    DatasetError
        If a URI is none that `pyarrow.fs` knows, or another dataset is there: it could not be replaced at one stroke.
    """
    if not _is_uri(out):
        return LocalFolder(Path(out).absolute() / dataset / tier, key)
    text, _, query = str(out).partition("?")
    if text.lower().startswith("file://"):
        return LocalFolder(Path(url2pathname(urlsplit(text).path)) / dataset / tier, key)
    remote = RemoteFolder(f"{text.rstrip('/')}/{dataset}/{tier}" + (f"?{query}" if query else ""), key)
    where = shown(out, dataset, tier)
    try:
        there = remote.finished()
    except DatasetError as error:
        raise DatasetError(f"{where}: another dataset is there: {str(error).partition(': ')[2]}") from None
    except (OSError, ValueError) as error:
        raise DatasetError(f"{where}: {str(error).splitlines()[0]}") from None
    if there is not None and there["specification"] != key:
        raise DatasetError(f"{where}: another dataset is there; remove it, or choose another place")
    return remote
