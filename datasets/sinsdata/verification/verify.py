"""Verification of a dataset on disk: bytes, content, schema, rows, relations, and values computed by the other path."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sinsdata.format.manifest import NAME, all_files, is_sealed, makers, read_manifest, table_files
from sinsdata.format.schema import DATASETS, arrow_schema, without_provenance
from sinsdata.format.storage import file_hash
from sinsdata.generation import digits
from sinsdata.generation.specification import Specification
from sinsdata.generation.tables import ANY_ROW
from sinsdata.verification.recompute import Wanted, Worst
from sinsdata.verification.stored_cases import load_cases
from sinsdata.verification.stored_pass import SpotLines, StoredPass, UnreadableError, read_lines

#: ``progress(done, total, what)``: bytes while files are hashed, rows after that.
_Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Check:
    """One thing that was checked.

    Attributes
    ----------
    where : str
        Folder, and table or file.
    what : str
        The property.
    holds : bool
    detail : str
        What was found, where it does not hold.
    """

    where: str
    what: str
    holds: bool
    detail: str = ""

    def __post_init__(self) -> None:
        if self.holds:
            object.__setattr__(self, "detail", "")


def _silent(done: int, total: int, what: str) -> None:
    pass


def verify(folder: Path, recompute: Wanted = "few", progress: _Progress = _silent, workers: int = 1) -> Iterator[Check]:
    """Check a dataset: bytes, content, schema, rows, relations between them, and some computed again.

    A table is read once, and only if its files are those of the manifest; memory does not grow with it.

    Parameters
    ----------
    folder : Path
        The dataset.
    recompute : int, "all" or "few", default "few"
        Rows of each case and table that are computed again by mpmath, from the case alone: first, last and evenly
        between. Few are three; in tables where a row costs all before it, three of the first (the check says so).
    progress : callable, optional
        ``progress(done, total, what)``.
    workers : int, default 1
        Processes that compute rows again.

    Yields
    ------
    Check

    Raises
    ------
    sinsdata.format.manifest.DatasetError
        If there is no manifest that this version reads, or the cases are none.
    """
    manifest = read_manifest(folder)
    yield from _check_manifest(folder, manifest)
    damaged: set[str] = set()
    for check, name in _check_files(folder, manifest, progress):
        if not check.holds:
            damaged.add(name)
        yield check
    sound: list[str] = []
    for table in manifest["tables"]:
        if not damaged & {entry["file"] for entry in manifest["tables"][table]["files"]}:
            checks = list(_check_table(folder, manifest, table))
            yield from checks
            if all(check.holds for check in checks):
                sound.append(table)
    if "cases" in sound:
        yield from _check_rows(folder, manifest, sound, digits.NAME in damaged, recompute, progress, workers)


def _check_manifest(folder: Path, manifest: Mapping[str, Any]) -> Iterator[Check]:
    where = f"{folder}: {NAME}"
    text = (folder / NAME).read_bytes().decode()
    yield Check(where, "own hash", is_sealed(text), "it has been changed")
    about = DATASETS[manifest["dataset"]]
    expected = {"title": about.title, "source": about.source, "doi": about.doi, "license": "CC0-1.0"}
    wrong = [key for key, value in expected.items() if manifest.get(key) != value]
    yield Check(where, "title, source and license", not wrong, f"{', '.join(wrong)}: not those of this version")


def _check_files(folder: Path, manifest: Mapping[str, Any], progress: _Progress) -> Iterator[tuple[Check, str]]:
    """Compare the files with the manifest; with each check the name of its file."""
    entries = list(all_files(manifest))
    total, done = sum(_size(entry) for entry in entries), 0
    for entry in entries:
        name = entry["file"]
        progress(done, total, name)
        done += _size(entry)
        yield Check(f"{folder}: {name}", "size and SHA-256 of the file", *_same_bytes(folder / name, entry)), name
    # Hidden files are none of the dataset's: those of desktops, of runs that were killed.
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    more = sorted(names - {NAME, *(entry["file"] for entry in entries)})
    detail = f"not in the manifest: {', '.join(more[:5])}"
    yield Check(f"{folder}: {NAME}", "no other files", not more, detail), ""


def _size(entry: Mapping[str, Any]) -> int:
    size = entry.get("bytes")
    return size if isinstance(size, int) else 0


def _same_bytes(path: Path, entry: Mapping[str, Any]) -> tuple[bool, str]:
    try:
        size = path.stat().st_size
        if size != entry.get("bytes"):
            return False, f"{path.name} has {size} bytes instead of {entry.get('bytes')}"
        digest = file_hash(path)
    except FileNotFoundError:
        return False, f"{path.name} is missing"
    except OSError as error:
        return False, f"{path.name}: {error.strerror}"
    return digest == entry.get("sha256"), f"{path.name} has {digest} instead of {entry.get('sha256')}"


def _check_table(folder: Path, manifest: Mapping[str, Any], table: str) -> Iterator[Check]:
    """Check what the files of a table say of themselves."""
    where, entry = f"{folder}: {table}", manifest["tables"][table]
    expected = without_provenance(arrow_schema(manifest["dataset"], table))
    rows, schemas, wrong_rows = 0, [], []
    for path, about in zip(table_files(folder, manifest, table), entry["files"], strict=True):
        try:
            with pq.ParquetFile(path) as file:
                schema, count = file.schema_arrow, file.metadata.num_rows
        except (OSError, ValueError, pa.ArrowException) as error:  # ValueError: texts that are not UTF-8
            detail = f"{path.name}: {(str(error) or type(error).__name__).splitlines()[0]}"
            yield Check(where, "readable as Parquet", False, detail)
            return
        rows += count
        if not without_provenance(schema).equals(expected, check_metadata=True):
            schemas.append(path.name)
        if count != about.get("rows"):
            wrong_rows.append(f"{path.name} has {count} instead of {about.get('rows')}")
    if rows != entry.get("rows"):
        wrong_rows.append(f"{rows} in all instead of {entry.get('rows')}")
    yield Check(where, "schema, units and metadata", not schemas, f"not those of this version: {', '.join(schemas)}")
    yield Check(where, "number of rows", not wrong_rows, "; ".join(wrong_rows))


def _check_rows(
    folder: Path,
    manifest: Mapping[str, Any],
    sound: list[str],
    digits_damaged: bool,
    recompute: Wanted,
    progress: _Progress,
    workers: int,
) -> Iterator[Check]:
    dataset, cases = load_cases(folder)
    given = manifest.get("cases")
    yield Check(f"{folder}: {NAME}", "number of cases", given == len(cases), f"{given} instead of {len(cases)}")
    specification = Specification(dataset, str(manifest.get("tier")), cases, tuple(manifest["tables"]))
    if _same_versions(manifest):
        same = specification.key == manifest.get("specification")
        detail = "cases and tables are not those that the dataset was made for"
        yield Check(f"{folder}: {NAME}", "specification", same, detail)
    whole = {}
    for number, group in enumerate(specification.groups):
        for table in set(group.tables) & set(sound):
            stored, expected = manifest["tables"][table]["rows"], specification.rows(number)
            detail = f"{stored} instead of {expected}"
            yield Check(f"{folder}: {table}", "rows of the cases", stored == expected, detail)
            if stored == expected:
                whole[table] = table_files(folder, manifest, table)
    if "cases" not in whole:
        return
    lines: SpotLines = {}
    if not digits_damaged:
        text = (folder / digits.NAME).read_bytes().decode()
        right = text == digits.digits_text(specification)
        yield Check(f"{folder}: {digits.NAME}", "digits computed again", right, "they differ")
        lines = read_lines(text) if right else {}
    looked = StoredPass(specification, whole, recompute, lines, progress, workers)
    try:
        looked.run()
    except UnreadableError as error:
        yield Check(f"{folder}: {str(error).partition(':')[0]}", "readable as Parquet", False, str(error))
        return
    yield from _results(folder, manifest, looked, recompute)


def _results(folder: Path, manifest: Mapping[str, Any], looked: StoredPass, recompute: Wanted) -> Iterator[Check]:
    for name, table in looked.tables.items():
        digest, stated = table.digest.hexdigest(), manifest["tables"][name].get("content_sha256")
        yield Check(f"{folder}: {name}", "content hash", digest == stated, f"{digest} instead of {stated}")
    for (where, what), worst in looked.findings.items():
        yield Check(f"{folder}: {where}", what, worst.size <= 1, _times(worst))
    for table_name, worst in looked.recomputed.items():
        limit = looked.tables[table_name].spot_limit
        among = f", of the first {limit} rows of each case" if recompute == "few" and limit < ANY_ROW else ""
        what = f"{worst.count} values computed again by mpmath{among}"
        detail = f"{worst.size:.1e} times the accuracy that is stated, at {worst.where}"
        yield Check(f"{folder}: {table_name}", what, worst.size <= 1, detail)
    for table_name, worst in looked.spots.items():
        what = f"{worst.count} of its values are those of {digits.NAME}"
        yield Check(f"{folder}: {table_name}", what, worst.size <= 1, worst.where)


def _times(worst: Worst) -> str:
    return f"{worst.where}: {worst.size:.1e} times what it may be"


def _same_versions(manifest: Mapping[str, Any]) -> bool:
    """Return whether the packages installed here made a dataset: they are part of what it was made for."""
    return bool(manifest.get("generator") == makers())
