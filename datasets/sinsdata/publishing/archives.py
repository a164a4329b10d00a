"""Archives of a dataset: packed to the same bytes on every run, unpacked into their folder and nowhere else."""

from __future__ import annotations

import errno
import json
import shutil
import stat
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sinsdata.format.names import UnsafeNameError, safe_names
from sinsdata.format.storage import file_hash

#: A manifest lists cases and files; one of this size would list hundreds of thousands.
_LARGEST_MANIFEST = 64 * 2**20
#: The earliest time a ZIP archive can state: that of no file, so that archives do not depend on the day.
_NO_TIME = (1980, 1, 1, 0, 0, 0)


class ArchiveError(ValueError):
    """An archive or folder is not a dataset as it was published; the message says which and why."""


def listed_files(manifest: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of all files that a manifest lists, by name: those of the tables first.

    Raises
    ------
    sinsdata.format.names.UnsafeNameError
        If a name does not stay in its folder, or two are the same.
    ArchiveError
        If the manifest lists no files.
    """
    try:
        entries = [entry for table in manifest["tables"].values() for entry in table["files"]] + manifest["files"]
        names = safe_names(["manifest.json", *(entry["file"] for entry in entries)])[1:]
    except (KeyError, TypeError, AttributeError) as error:
        raise ArchiveError(f"not a manifest: {type(error).__name__}: {error}") from None
    return dict(zip(names, entries, strict=True))


def pack(folder: Path, prefix: str, names: list[str], archive: Path) -> None:
    """Write files of a folder to a ZIP archive: stored, sorted, without times or owners.

    Parquet is compressed already; the archive only holds together what belongs together.

    Parameters
    ----------
    folder : Path
    prefix : str
        Folder inside the archive, such as ``dual_precession/paper``.
    names : list of str
    archive : Path
        The file to write.
    """
    with zipfile.ZipFile(archive, "x", zipfile.ZIP_STORED) as zipped:
        for name in sorted(names):
            info = zipfile.ZipInfo(f"{prefix}/{name}", _NO_TIME)
            info.create_system, info.external_attr = 3, (stat.S_IFREG | 0o644) << 16
            info.file_size = (folder / name).stat().st_size
            with (folder / name).open("rb") as source, zipped.open(info, "w") as target:
                shutil.copyfileobj(source, target, 2**20)


@contextmanager
def _readable(archive: Path) -> Iterator[zipfile.ZipFile]:
    """Open an archive; whatever is wrong with it is an `ArchiveError`."""
    try:
        with zipfile.ZipFile(archive) as zipped:
            yield zipped
    except UnsafeNameError as error:
        raise ArchiveError(f"{archive}: {error}") from None
    # zipfile: RuntimeError for encrypted files, NotImplementedError for methods it does not know.
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, UnicodeError) as error:
        raise ArchiveError(f"{archive}: not a sound ZIP archive: {error}") from None
    except OSError as error:
        if error.errno != errno.EINVAL:
            raise
        # Of all reasons this one is the archive's: it sends its reader to a place before its beginning.
        raise ArchiveError(f"{archive}: not a sound ZIP archive: {error.strerror}") from None


def unpack(archive: Path, prefix: str, limit: int, target: Path) -> None:
    """Unpack a dataset from an archive into an empty folder.

    The archive may hold nothing but the manifest and the files that it lists, each a plain file named
    ``prefix/name``. All names and sizes are checked before the first byte is written; then the bytes are hashed.

    Parameters
    ----------
    archive : Path
    prefix : str
        Such as ``dual_precession/paper``.
    limit : int
        Most bytes that may come out.
    target : Path
        The folder.

    Raises
    ------
    ArchiveError
        If it holds anything else: absolute names, ``..``, links, devices, folders, names twice or differing by
        case alone, more bytes than the limit, other files than the manifest lists, or other bytes.
    """
    with _readable(archive) as zipped:
        members = _members(zipped, prefix, limit)
        if "manifest.json" not in members or members["manifest.json"].file_size > _LARGEST_MANIFEST:
            raise ArchiveError(f"{archive}: no manifest.json of a sensible size in {prefix}/")
        try:
            manifest = json.loads(zipped.read(members["manifest.json"]))
        except (ValueError, RecursionError) as error:
            raise ArchiveError(f"{archive}: manifest.json: {error}") from None
        listed = {"manifest.json", *listed_files(manifest)}
        if odd := sorted(listed ^ set(members)):
            what = "is listed by the manifest, and missing" if odd[0] in listed else "is not listed by the manifest"
            raise ArchiveError(f"{archive}: {odd[0]!r} {what}")
        for name, info in members.items():
            with zipped.open(info) as source, (target / name).open("xb") as file:
                shutil.copyfileobj(source, file, 2**20)
    check_files(target, manifest)


def _members(zipped: zipfile.ZipFile, prefix: str, limit: int) -> dict[str, zipfile.ZipInfo]:
    """Return the members of an archive by plain name, after all checks that need no data."""
    infos = zipped.infolist()
    inside = []
    for info in infos:
        # zipfile cuts `filename` at a null byte and turns separators: the name as it stands decides.
        folder, _, name = info.orig_filename.rpartition("/")
        if folder != prefix:
            raise UnsafeNameError(f"{info.orig_filename[:200]!r} is not a file in {prefix}/")
        inside.append(name)
        kind = stat.S_IFMT(info.external_attr >> 16)
        if kind not in (0, stat.S_IFREG) or info.is_dir():
            raise UnsafeNameError(f"{info.orig_filename!r} is not a plain file")
    if (total := sum(info.file_size for info in infos)) > limit:
        raise ArchiveError(f"{zipped.filename}: would unpack to {total} bytes, not to at most {limit}")
    return dict(zip(safe_names(inside), infos, strict=True))


def check_files(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Compare the files of a dataset with the lengths and SHA-256 of its manifest.

    Raises
    ------
    ArchiveError
        For the first file that is missing or differs.
    """
    for name, entry in listed_files(manifest).items():
        check_file(folder / name, entry)


def check_file(path: Path, entry: Mapping[str, Any]) -> None:
    """Compare a file with its entry in the manifest.

    Raises
    ------
    ArchiveError
        If it is missing or differs.
    """
    try:
        # The length first: a file cut short is found without reading it.
        sound = path.stat().st_size == entry.get("bytes") and file_hash(path) == entry.get("sha256")
    except OSError as error:
        raise ArchiveError(f"{path}: {error.strerror or error}") from None
    if not sound:
        raise ArchiveError(f"{path}: its length or SHA-256 is not that of the manifest")
