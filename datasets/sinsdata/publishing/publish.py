"""Publishing: a bundle of datasets, each with card, citation, licence and checksums, and one archive a tier."""

from __future__ import annotations

import hashlib
import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from sinsdata.format.manifest import own_files, read_manifest
from sinsdata.format.schema import DATASETS
from sinsdata.format.storage import Kind, file_hash, json_text, replacing
from sinsdata.publishing.archives import check_files, listed_files, pack
from sinsdata.publishing.registry import SHIPPED, Entry, Registry, RegistryError, read_registry, registry_json
from sinsdata.tiers import tiers_of
from sinsdata.verification.stored_cases import find_datasets
from sinsdata.verification.verify import Check, verify

#: ``progress(done, total, what)``.
Progress: TypeAlias = Callable[[int, int, str], None]

REGISTRY, SUMS = "registry.json", "SHA256SUMS"
#: Name in a bundle -> name beside the package.
_DOCUMENTS = {"CITATION.cff": "CITATION.cff", "LICENSE": "LICENSE-DATA"}
_CARD = "README.md"
#: Rows of the longest table, as the cards of Hugging Face sort them.
_SIZES = (
    (10**3, "n<1K"), (10**4, "1K<n<10K"), (10**5, "10K<n<100K"), (10**6, "100K<n<1M"), (10**7, "1M<n<10M"),
    (10**8, "10M<n<100M"), (10**9, "100M<n<1B"),
)  # fmt: skip


class PublishError(ValueError):
    """Something cannot be published; the message says what and why."""


class NotSoundError(PublishError):
    """A dataset does not hold what its manifest says.

    Attributes
    ----------
    failed : list of Check
        What does not hold.
    """

    def __init__(self, failed: list[Check]) -> None:
        first = failed[0]
        super().__init__(f"{len(failed)} checks do not hold, the first: {first.where}: {first.what}: {first.detail}")
        self.failed = failed


@dataclass(frozen=True)
class Published:
    """What `publish` wrote.

    Attributes
    ----------
    folder : Path
        The bundle.
    registry : Registry
        Its entries.
    """

    folder: Path
    registry: Registry


def publish(
    folder: Path,
    out: Path,
    *,
    registry: Path = SHIPPED,
    progress: Progress = lambda done, total, what: None,
) -> Published:
    """Verify datasets and write them as a bundle, whole or not at all, in place of an earlier bundle.

    Parameters
    ----------
    folder : Path
        A dataset, or a folder of datasets.
    out : Path
        The bundle: a new or empty folder, or an earlier bundle.
    registry : Path, optional
        What is published already; that of the package by default. What it lists never changes.
    progress : callable, optional
        Called with datasets done, datasets in all, and what is at work.

    Returns
    -------
    Published

    Raises
    ------
    NotSoundError
        If a dataset does not verify.
    PublishError
        If two folders hold the same tier, one of the package's own tiers lacks tables, or the content of what is
        published already would change.
    sinsdata.format.storage.OccupiedError
        If `out` is something else than a bundle, or holds more than that.
    sinsdata.format.manifest.DatasetError
        If the folder holds no dataset of this version.
    """
    _BUNDLE.check(out)
    found = find_datasets(folder)
    manifests = {place: read_manifest(place) for place in found}
    named = [(about["dataset"], about["tier"]) for about in manifests.values()]
    if twice := [pair for pair in named if named.count(pair) > 1]:
        raise PublishError(f"{folder}: {'/'.join(twice[0])} is there more than once")
    earlier = read_registry(registry)
    planned = {place: _planned(place, about) for place, about in manifests.items()}
    for number, (place, about) in enumerate(manifests.items()):
        progress(number, len(found), f"verifying {place}")
        _check_unchanged(about, earlier)
        if failed := [check for check in verify(place) if not check.holds]:
            raise NotSoundError(failed)
    entries = []
    with replacing(out, _BUNDLE) as bundle:
        for number, (place, about) in enumerate(sorted(manifests.items(), key=lambda item: _key(item[1]))):
            progress(number, len(found), f"packing {place}")
            entries.append(_add(bundle, place, about, planned[place]))
        for dataset in sorted({about["dataset"] for about in manifests.values()}):
            _add_documents(bundle / dataset, [about for about in manifests.values() if about["dataset"] == dataset])
        made = Registry(tuple(entries), earlier.mirrors)
        (bundle / REGISTRY).write_text(json_text(registry_json(made)), encoding="utf-8", newline="\n")
        _write_sums(bundle, [REGISTRY, *(entry.archive for entry in entries)])
    progress(len(found), len(found), "done")
    return Published(out, made)


def _key(manifest: Mapping[str, Any]) -> tuple[str, str]:
    return manifest["dataset"], manifest["tier"]


def _contents(manifest: Mapping[str, Any]) -> dict[str, str]:
    return {table: entry["content_sha256"] for table, entry in manifest["tables"].items()}


def _check_unchanged(manifest: Mapping[str, Any], earlier: Registry) -> None:
    entry = earlier.find(*_key(manifest))
    if entry is None or entry.version != manifest["version"] or dict(entry.content_sha256) == _contents(manifest):
        return
    raise PublishError(
        f"{'/'.join(_key(manifest))} {entry.version} is published with other content: other data, other version"
    )


def _planned(place: Path, manifest: Mapping[str, Any]) -> Entry:
    """Return the entry of a dataset, its archive still empty, so that what cannot be published stops the run early.

    Raises
    ------
    PublishError
        If a name does not stay in its folder, or a tier of the package lacks tables.
    """
    dataset, tier = _key(manifest)
    if tier in tiers_of(dataset) and (lacking := [t for t in DATASETS[dataset].tables if t not in manifest["tables"]]):
        raise PublishError(f"{place}: tier {tier} lacks {', '.join(lacking)}: it is published with all of its tables")
    archive, nothing = f"{dataset}-{tier}-{manifest['version']}.zip", hashlib.sha256().hexdigest()
    try:
        return Entry(dataset, tier, manifest["version"], archive, 0, nothing, 0, nothing, _contents(manifest))
    except ValueError as error:
        raise PublishError(f"{place}: {error}") from None


def _add(bundle: Path, place: Path, manifest: Mapping[str, Any], planned: Entry) -> Entry:
    """Copy a dataset into the bundle and pack its archive."""
    dataset, tier = _key(manifest)
    names = ["manifest.json", *listed_files(manifest)]
    folder, archive = bundle / dataset / tier, bundle / planned.archive
    folder.mkdir(parents=True)
    for name in names:
        shutil.copyfile(place / name, folder / name)
    check_files(folder, manifest)  # what is packed is what was verified, whatever has happened to it meanwhile
    pack(folder, f"{dataset}/{tier}", names, archive)
    return replace(
        planned,
        bytes=archive.stat().st_size,
        sha256=file_hash(archive),
        unpacked_bytes=sum((folder / name).stat().st_size for name in names),
        manifest_sha256=file_hash(folder / "manifest.json"),
    )


def _own_files(folder: Path) -> set[str]:
    """Return the files of a bundle, by its registry and the manifests of its datasets."""
    try:
        entries = read_registry(folder / REGISTRY).entries
    except RegistryError:
        return set()
    own = {REGISTRY, SUMS, *(entry.archive for entry in entries)}
    for entry in entries:
        own |= {f"{entry.dataset}/{name}" for name in (_CARD, SUMS, *_DOCUMENTS)}
        prefix = f"{entry.dataset}/{entry.tier}"
        own |= {f"{prefix}/{name}" for name in own_files(folder / prefix)}
    return own


_BUNDLE = Kind("bundle", _own_files)


def _add_documents(folder: Path, manifests: Sequence[Mapping[str, Any]]) -> None:
    """Write card, citation, licence and checksums of a dataset."""
    card = document(f"{manifests[0]['dataset']}.md").read_text(encoding="utf-8")
    (folder / _CARD).write_text(card_with_header(card, manifests), encoding="utf-8", newline="\n")
    for name, source in _DOCUMENTS.items():
        shutil.copyfile(document(source), folder / name)
    _write_sums(folder, [path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()])


def _write_sums(folder: Path, names: Sequence[str]) -> None:
    lines = [f"{file_hash(folder / name)}  {name}\n" for name in sorted(names)]
    (folder / SUMS).write_text("".join(lines), encoding="utf-8", newline="\n")


def document(name: str) -> Path:
    """Return a text that goes into bundles: a card, the citation, the licence.

    Parameters
    ----------
    name : str

    Raises
    ------
    PublishError
        If it is neither in the package nor in the checkout that the package is used from.
    """
    package = Path(__file__).parents[1]
    # An installed package has copies; a checkout has the originals beside the package.
    for folder in (package / "cards", package.parent / "cards", package.parents[1]):
        if (folder / name).is_file():
            return folder / name
    raise PublishError(f"{name} is not installed with the package")


def card_with_header(card: str, manifests: Sequence[Mapping[str, Any]]) -> str:
    """Return a dataset card whose header lists the tiers and files that are there, as Hugging Face reads it.

    Parameters
    ----------
    card : str
        Markdown behind a header in YAML. Its ``configs`` and ``size_categories`` are written anew; all else stays.
    manifests : sequence of mapping
        Of the tiers.
    """
    _, header, text = card.split("---\n", 2)
    default = re.search(r"config_name: (\w+)\n +default: true", header)
    tables = dict.fromkeys(table for about in manifests for table in about["tables"])
    chosen = default[1] if default is not None and default[1] in tables else next(iter(tables))
    # One key with all that is indented or listed below it.
    kept = re.sub(r"^(configs|size_categories):.*\n(?:[ -].*\n)*", "", header, flags=re.MULTILINE)
    rows = max(
        sum(about["tables"][table]["rows"] for about in manifests if table in about["tables"]) for table in tables
    )
    size = next((name for limit, name in _SIZES if rows < limit), "n>1B")
    lines = ["size_categories:", f"  - {size}", "configs:"]
    for table in sorted(tables, key=lambda name: name != chosen):
        lines += [f"  - config_name: {table}", *(["    default: true"] if table == chosen else []), "    data_files:"]
        for tier, path in _data_files(table, manifests):
            lines += [f"      - split: {tier}", f"        path: {path}"]
    return f"---\n{kept}{chr(10).join(lines)}\n---\n{text}"


def _data_files(table: str, manifests: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    for about in sorted(manifests, key=_key):
        if table in about["tables"]:
            files = about["tables"][table]["files"]
            name = files[0]["file"] if len(files) == 1 else f"{table}-*.parquet"
            yield about["tier"], f"{about['tier']}/{name}"
