"""Fetching published data: from mirrors or a folder, checked against the registry, into a cache.

A name in the cache stands for a whole, checked dataset or for nothing: whatever fails, is cut off or is killed on the
way leaves at most a folder whose name begins with a dot.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

from sinsdata.format.names import UnsafeNameError, safe_name
from sinsdata.format.storage import Kind, file_hash, replacing
from sinsdata.publishing.archives import ArchiveError, check_files, listed_files, unpack
from sinsdata.publishing.registry import SHIPPED, Entry, Registry, read_registry
from sinsdata.publishing.soundness import is_published, is_sound, stated_contents, stored_contents

#: ``progress(bytes done, bytes in all, what)``.
Progress: TypeAlias = Callable[[int, int, str], None]

#: Folder that takes the place of the user's cache, and more mirrors, apart by blanks.
CACHE_VARIABLE, MIRRORS_VARIABLE = "SINSBENCH_DATA", "SINSBENCH_MIRRORS"
#: Seconds that a mirror may stay silent.
TIMEOUT = 30.0
_INSTALL = "pip install pooch"
_DOWNLOADING = ".download-"
_ABANDONED = 86400.0


class FetchError(ValueError):
    """Data cannot be fetched; the message says which and why."""


class UnavailableError(FetchError):
    """There is no place that the data can be had from; they can still be generated."""


class _FasterError(Exception):
    """Another process has put the same data into their place meanwhile."""


@dataclass(frozen=True)
class Fetched:
    """Where a dataset is and how it came there.

    Attributes
    ----------
    folder : Path
        The dataset.
    origin : str
        ``"cache"``, ``"generated"``, or the URL, archive or folder it was taken from.
    entry : Entry or None
        Of the registry; None where the registry has none.
    """

    folder: Path
    origin: str
    entry: Entry | None


def cache_folder() -> Path:
    """Return the folder of fetched data: `SINSBENCH_DATA`, or the one that pooch uses for caches of this user.

    Raises
    ------
    FetchError
        If the variable is not set and pooch is not installed.
    """
    if given := os.environ.get(CACHE_VARIABLE):
        return Path(given)
    try:
        # What pooch.os_cache calls; pooch itself takes as long to import as everything else here together.
        import platformdirs
    except ModuleNotFoundError:
        raise FetchError(f"a cache needs pooch: {_INSTALL}; or set {CACHE_VARIABLE} to a folder") from None
    return Path(platformdirs.user_cache_dir("sinsbench"))


def place_of(dataset: str, tier: str, entry: Entry | None, out: Path | None) -> Path:
    """Return the folder of a dataset: in `out`, or in the part of the cache that belongs to its version.

    Raises
    ------
    FetchError
        If there is no such dataset.
    """
    if entry is None:
        from sinsdata.format.schema import DATASETS

        if dataset not in DATASETS:
            raise FetchError(f"unknown dataset {dataset!r}; admissible: {', '.join(DATASETS)}")
    version = entry.version if entry is not None else DATASETS[dataset].version
    return (cache_folder() / version if out is None else out) / safe_name(dataset) / safe_name(tier)


def can_be_generated(dataset: str, tier: str) -> bool:
    """Return whether a tier is declared, so that its cases are known here."""
    from sinsdata.cases import CASE_CLASSES
    from sinsdata.tiers import tiers_of

    return dataset in CASE_CLASSES and tier in tiers_of(dataset)


def fetch(
    dataset: str,
    tier: str = "paper",
    *,
    out: Path | None = None,
    source: Path | None = None,
    mirrors: Sequence[str] = (),
    registry: Path = SHIPPED,
    timeout: float = TIMEOUT,
    progress: Progress = lambda done, total, what: None,
) -> Fetched:
    """Get a published dataset, unless it is there already.

    Parameters
    ----------
    dataset, tier : str
    out : Path, optional
        The dataset goes to ``out/dataset/tier``; into the cache by default.
    source : Path, optional
        A bundle, or a folder of archives: taken from there, nothing is downloaded.
    mirrors : sequence of str
        Base URLs to ask before those of `SINSBENCH_MIRRORS` and the registry.
    registry : Path, optional
        That of the package by default.
    timeout : float
        Seconds that a mirror may stay silent.
    progress : callable, optional
        Called with bytes done, bytes in all, and the URL.

    Returns
    -------
    Fetched

    Raises
    ------
    UnavailableError
        If there is no place to get it from, or none that has it; the message has the reason of each.
    FetchError, sinsdata.publishing.archives.ArchiveError
        If what is there is not what was published, if there is no such folder, or no such dataset or tier.
    sinsdata.publishing.registry.RegistryError
        If the registry cannot be used.
    sinsdata.format.storage.OccupiedError
        If something else than a dataset is in its place.
    """
    known = read_registry(registry)
    entry = known.find(dataset, tier)
    if entry is None and source is not None and (source / "registry.json").is_file():
        # What the package does not know of, such as a tier of one's own, the bundle itself vouches for.
        entry = read_registry(source / "registry.json").find(dataset, tier)
    target = place_of(dataset, tier, entry, out)
    if is_sound(target, entry):
        return Fetched(target, "cache" if out is None else str(target), entry)
    if source is not None and not source.is_dir():
        raise FetchError(f"{source}: {'a file, not a folder' if source.exists() else 'no such folder'}")
    if entry is None:
        _refuse(dataset, tier, registry, source)
    _dataset_folder().check(target)
    try:
        with _no_empty_folders(target):
            if source is not None:
                return Fetched(target, str(_from_folder(entry, source, target)), entry)
            return Fetched(target, _from_mirrors(entry, known, mirrors, timeout, target, progress), entry)
    except UnsafeNameError as error:
        raise ArchiveError(f"{dataset}, tier {tier}: {error}") from None


def _refuse(dataset: str, tier: str, registry: Path, source: Path | None) -> NoReturn:
    """Say that no registry has the data, or that there are none of this name."""
    from sinsdata.tiers import tiers_of

    if not can_be_generated(dataset, tier):
        published = [known.tier for known in read_registry(registry).entries if known.dataset == dataset]
        admissible = dict.fromkeys([*tiers_of(dataset), *published])
        raise FetchError(f"unknown tier {tier!r} of {dataset}; admissible: {', '.join(admissible)}")
    read = [registry] if source is None else [registry, source / "registry.json"]
    missing = [f"{path} has no such data" if path.is_file() else f"{path} is not there" for path in read]
    raise UnavailableError(f"{dataset}, tier {tier}: {', '.join(missing)}")


@contextmanager
def _no_empty_folders(target: Path) -> Iterator[None]:
    """Remove, if the block fails, the folders above `target` that it has made and left empty."""
    absent = [folder for folder in target.parents if not folder.exists()]
    try:
        yield
    except BaseException:
        for folder in absent:  # the innermost comes first
            with suppress(OSError):
                folder.rmdir()
        raise


def generate_instead(
    dataset: str,
    tier: str = "paper",
    *,
    out: Path | None = None,
    registry: Path = SHIPPED,
    progress: Progress = lambda done, total, what: None,
) -> Fetched:
    """Generate what could not be fetched, and compare it with what was published.

    Parameters
    ----------
    dataset, tier, out, registry
        As for `fetch`.
    progress : callable, optional
        Called with rows done, rows in all, and what is at work.

    Returns
    -------
    Fetched

    Raises
    ------
    FetchError
        If a content hash is not that of the registry.
    sinsdata.tiers.CaseFileError
        If there is no such dataset or tier.
    """
    from sinsdata.generation.generate import generate
    from sinsdata.tiers import cases_of

    entry = read_registry(registry).find(dataset, tier)
    cases = cases_of(dataset, tier)
    target = place_of(dataset, tier, entry, out)
    made = generate(dataset, tier, cases, target.parents[1], progress)
    if entry is not None and made.manifest["version"] != entry.version:
        raise FetchError(f"{target}: version {made.manifest['version']}; that of the registry is {entry.version}")
    # What this call has computed, its manifest states; what an earlier one has left there is read.
    found = stored_contents(target, made.manifest) if made.reused else stated_contents(made.manifest)
    if entry is not None and found != dict(entry.content_sha256):
        differing = sorted(t for t in {*found, *entry.content_sha256} if found.get(t) != entry.content_sha256.get(t))
        raise FetchError(f"{target}: generated, but the content of {', '.join(differing)} is not that of the registry")
    return Fetched(target, "generated", entry)


def _from_folder(entry: Entry, source: Path, target: Path) -> Path:
    archive, folder = source / entry.archive, source / entry.dataset / entry.tier
    if archive.is_file():
        if archive.stat().st_size != entry.bytes or file_hash(archive) != entry.sha256:
            raise FetchError(f"{archive}: its length or SHA-256 is not that of the registry")
        _install_archive(entry, archive, target)
        return archive
    manifest = folder / "manifest.json"
    if not manifest.is_file():
        raise UnavailableError(f"{source}: neither {entry.archive} nor {entry.dataset}/{entry.tier}/ is there")
    if file_hash(manifest) != entry.manifest_sha256:
        raise FetchError(f"{manifest}: its SHA-256 is not that of the registry")
    _install(entry, target, lambda partial: _copy(folder, partial))
    return folder


def _copy(folder: Path, target: Path) -> None:
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    for name in ("manifest.json", *listed_files(manifest)):
        shutil.copyfile(folder / name, target / name)
    check_files(target, manifest)


def _prefix(entry: Entry) -> str:
    return f"{entry.dataset}/{entry.tier}"


def _dataset_folder() -> Kind:
    # Here: it imports the schema with all that truth is computed by, which what is cached does not need.
    from sinsdata.format.manifest import DATASET_FOLDER

    return DATASET_FOLDER


def _install(entry: Entry, target: Path, fill: Callable[[Path], None]) -> None:
    """Fill a folder, compare it with the registry, and put it into its place in one stroke."""
    with suppress(_FasterError), replacing(target, _dataset_folder()) as partial:
        fill(partial)
        if not is_published(partial, entry):
            raise FetchError(f"{_prefix(entry)}: its manifest or its content hashes are not those of the registry")
        if is_sound(target, entry):
            # Whoever reads the folder that another process has put there is not disturbed.
            raise _FasterError


def _install_archive(entry: Entry, archive: Path, target: Path) -> None:
    _install(entry, target, lambda partial: unpack(archive, _prefix(entry), entry.unpacked_bytes, partial))


def _from_mirrors(
    entry: Entry, known: Registry, mirrors: Sequence[str], timeout: float, target: Path, progress: Progress
) -> str:
    bases = dict.fromkeys([*mirrors, *os.environ.get(MIRRORS_VARIABLE, "").split(), *known.mirrors])
    if not bases:
        raise UnavailableError(f"{_prefix(entry)}: no mirror is known; name one by --mirror or {MIRRORS_VARIABLE}")
    reasons = []
    for base in bases:
        url = f"{base.rstrip('/')}/{entry.archive}"
        with _download_folder(target) as folder:
            try:
                archive = _download(url, entry, folder, timeout, progress)
            except _MirrorError as error:
                reasons.append(f"{url}: {error}")
                continue
            # The archive is the published one by its hash: if it does not hold what the registry says, none does.
            _install_archive(entry, archive, target)
            return url
    raise UnavailableError(f"{_prefix(entry)}: no mirror has it: {'; '.join(reasons)}")


@contextmanager
def _download_folder(target: Path) -> Iterator[Path]:
    """Give a folder of this download alone, and clear away what killed processes left a day ago or before."""
    target.parent.mkdir(parents=True, exist_ok=True)
    for left in target.parent.glob(f"{_DOWNLOADING}*"):
        with suppress(OSError):
            if time.time() - left.stat().st_mtime > _ABANDONED:
                shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=_DOWNLOADING, dir=target.parent) as folder:
        yield Path(folder)


class _MirrorError(Exception):
    """A mirror does not give the archive; the message says why."""


def _download(url: str, entry: Entry, folder: Path, timeout: float, progress: Progress) -> Path:
    """Download an archive and check its length and hash.

    Raises
    ------
    _MirrorError
        If the mirror does not give these bytes.
    FetchError
        If pooch is not installed.
    """
    try:
        import pooch
        import requests
    except ModuleNotFoundError:
        raise FetchError(f"downloading needs pooch: {_INSTALL}") from None

    def bounded(url: str, output_file: str, _: Any) -> None:
        # pooch's own downloader takes whatever comes, without an end; the registry knows how much there is.
        done = 0
        with requests.get(url, stream=True, timeout=timeout) as response, Path(output_file).open("wb") as file:
            if not response.ok:
                raise _MirrorError(f"HTTP {response.status_code} {response.reason}")
            for chunk in response.iter_content(2**18):
                done += len(chunk)
                if done > entry.bytes:
                    raise _MirrorError(f"sends more than the {entry.bytes} bytes of the registry")
                file.write(chunk)
                progress(done, entry.bytes, url)
        if done < entry.bytes:
            raise _MirrorError(f"sends {done} of {entry.bytes} bytes")

    logger = pooch.get_logger()
    level = logger.level
    logger.setLevel(logging.WARNING)  # of its messages, standard error gets what goes wrong
    try:
        path = pooch.retrieve(url, f"sha256:{entry.sha256}", entry.archive, folder, downloader=bounded)
    except requests.Timeout:
        raise _MirrorError(f"silent for {timeout:g} s") from None
    except requests.exceptions.ChunkedEncodingError:
        raise _MirrorError("the connection was cut") from None
    except requests.ConnectionError:
        raise _MirrorError("no connection") from None
    except requests.RequestException as error:
        raise _MirrorError(str(error) or type(error).__name__) from None
    except ValueError as error:  # pooch, of a hash
        if isinstance(error, FetchError):
            raise
        raise _MirrorError("its SHA-256 is not that of the registry") from None
    finally:
        logger.setLevel(level)
    return Path(path)
