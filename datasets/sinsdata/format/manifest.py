"""The manifest of a dataset: what its folder holds, with the hashes that prove it."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, fields
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sinsdata.format.names import safe_name, safe_names
from sinsdata.format.schema import DATASETS, FORMAT
from sinsdata.format.storage import Kind, file_hash, json_text
from sinsdata.truth import error_equations, formulas, gyroscopic
from sinsref.rounding import RoundingTally

NAME = "manifest.json"
#: Working precision of the first attempt, where it is not that of closed formulas.
_FIRST_BITS = {"error_equations": error_equations.WORKING_BITS, "gyro_systems": gyroscopic.WORKING_BITS}
#: Packages whose versions decide on the bytes of a dataset.
_MAKERS = ("sinsbench", "pyarrow", "python-flint")
#: What a dataset holds beside tables and manifest.
_TEXTS = ("digits.csv", "croissant.json")
_SHA256 = re.compile(r"[0-9a-f]{64}")


class DatasetError(ValueError):
    """A folder is not a dataset that this version reads; the message says which and why."""


@cache
def makers() -> dict[str, str]:
    """Return the versions of the packages that decide what the files are."""
    return {name: version(name) for name in _MAKERS}


def compose(
    dataset: str,
    tier: str,
    specification: str,
    cases: int,
    tables: Mapping[str, Mapping[str, Any]],
    tally: RoundingTally,
) -> dict[str, Any]:
    """Return the manifest of a dataset, its other files and its own hash still missing.

    Parameters
    ----------
    dataset, tier : str
    specification : str
        Hash of what was asked for.
    cases : int
        How many.
    tables : mapping
        Table -> rows, content hash, files.
    tally : RoundingTally
        How the values were decided.
    """
    about = DATASETS[dataset]
    return {
        "format": FORMAT,
        "dataset": dataset,
        "tier": tier,
        "version": about.version,
        "title": about.title,
        "source": about.source,
        "doi": about.doi,
        "license": "CC0-1.0",
        "generator": makers(),
        "specification": specification,
        "certification": {
            "method": about.method,
            "first_working_bits": _FIRST_BITS.get(dataset, formulas.WORKING_BITS),
            **asdict(tally),
        },
        "cases": cases,
        "tables": tables,
    }


def sealed(manifest: Mapping[str, Any], files: Sequence[Mapping[str, Any]]) -> str:
    """Return the text of a manifest with the other files of the dataset and its own hash."""
    whole = {**manifest, "files": list(files)}
    return json_text({**whole, "sha256": _own_hash(whole)})


def _own_hash(manifest: Mapping[str, Any]) -> str:
    return hashlib.sha256(json_text(manifest).encode()).hexdigest()


def is_sealed(text: str) -> bool:
    """Return whether the text of a manifest is, byte by byte, what was sealed."""
    # What JSON can be read from but not written to, such as 1e999, was never sealed.
    with suppress(ValueError, RecursionError):
        manifest = json.loads(text)
        seal = manifest.pop("sha256", None)
        return bool(seal == _own_hash(manifest) and text == json_text({**manifest, "sha256": seal}))
    return False


def _text(value: object) -> None:
    if not isinstance(value, str):
        raise ValueError(f"{value!r:.80} is not a text")


def _count(value: object) -> None:
    # Not isinstance: true and false are integers too.
    if type(value) is not int or value < 0:
        raise ValueError(f"{value!r:.80} is not a number of things")


def _digest(value: object) -> None:
    if not isinstance(value, str) or not _SHA256.fullmatch(value):
        raise ValueError(f"{value!r:.80} is not a SHA-256")


def _object(form: Mapping[str, Callable[[object], object]]) -> Callable[[object], None]:
    """Return a check of the entries of an object; others may stand beside them."""

    def check(value: object) -> None:
        if not isinstance(value, dict):
            raise ValueError(f"{value!r:.80} is not an object")
        for key, check_entry in form.items():
            if key not in value:
                raise ValueError(f"{key} is missing")
            try:
                check_entry(value[key])
            except ValueError as error:
                raise ValueError(f"{key}: {error}") from None

    return check


def _files(form: Mapping[str, Callable[[object], object]]) -> Callable[[object], None]:
    """Return a check of a list of objects."""

    def check(value: object) -> None:
        if not isinstance(value, list):
            raise ValueError(f"{value!r:.80} is not a list")
        for entry in value:
            _object(form)(entry)

    return check


_FILE: Mapping[str, Callable[[object], object]] = {"file": safe_name, "bytes": _count, "sha256": _digest}
_TABLE = _object({"files": _files({**_FILE, "rows": _count}), "rows": _count, "content_sha256": _digest})
#: What readers rely on, beside format, dataset and version.
_MANIFEST = _object({
    "tier": safe_name,
    **dict.fromkeys(("title", "source", "doi", "license"), _text),
    "generator": _object(dict.fromkeys(_MAKERS, _text)),
    "specification": _digest,
    "certification": _object({"method": _text, **{tallied.name: _count for tallied in fields(RoundingTally)}}),
    "cases": _count,
    "tables": _object({}),
    "files": _files(_FILE),
})  # fmt: skip


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a dataset folder.

    Raises
    ------
    DatasetError
        If it cannot be read, is of a dataset, format or version that this version does not know, lacks an entry or has
        one of another type, or has a name, of its tier or a file, that does not stay in its folder.
    """
    path = folder / NAME
    try:
        manifest: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        layout, dataset, data_version = manifest["format"], manifest["dataset"], manifest["version"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise DatasetError(f"{path}: not a manifest: {type(error).__name__}: {error}") from None
    if layout != FORMAT:
        raise DatasetError(f"{path}: format {layout!r}; this version reads format {FORMAT}")
    if not isinstance(dataset, str) or dataset not in DATASETS:
        raise DatasetError(f"{path}: unknown dataset {dataset!r}; admissible: {', '.join(DATASETS)}")
    if data_version != DATASETS[dataset].version:
        raise DatasetError(
            f"{path}: version {data_version!r} of the data; this version reads {DATASETS[dataset].version}"
        )
    try:
        _MANIFEST(manifest)
        for table, entry in manifest["tables"].items():
            if table not in DATASETS[dataset].tables:
                raise ValueError(f"unknown table {table[:80]!r}; admissible: {', '.join(DATASETS[dataset].tables)}")
            _TABLE(entry)
            if not entry["files"]:
                raise ValueError(f"table {table} has no file")
        if "cases" not in manifest["tables"]:
            raise ValueError("the table of the cases is missing")
        safe_names(entry["file"] for entry in all_files(manifest))
    except ValueError as error:
        raise DatasetError(f"{path}: not a manifest: {error}") from None
    return manifest


def table_files(folder: Path, manifest: Mapping[str, Any], table: str) -> list[Path]:
    """Return the files of a table, in the order of the rows."""
    return [folder / entry["file"] for entry in manifest["tables"][table]["files"]]


def all_files(manifest: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the entries, with ``file``, ``bytes`` and ``sha256``, of all files but the manifest."""
    for entry in manifest["tables"].values():
        yield from entry["files"]
    yield from manifest["files"]


def _values(entry: object, key: str) -> Iterator[str]:
    """Yield the texts under a key, at whatever depth."""
    if isinstance(entry, dict):
        if isinstance(entry.get(key), str):
            yield entry[key]
        entry = list(entry.values())
    if isinstance(entry, list):
        for value in entry:
            yield from _values(value, key)


def _is_table(path: Path) -> bool:
    """Return whether a file has the name of a table and says in its schema that it is one."""
    with suppress(OSError, pa.ArrowException):
        dataset = (pq.read_schema(path).metadata or {}).get(b"dataset", b"").decode(errors="replace")
        table = re.sub(r"-\d{5,}-of-\d{5,}$", "", path.stem)
        return dataset in DATASETS and table in DATASETS[dataset].tables
    return False


def own_files(folder: Path) -> set[str]:
    """Return the names of the files in a folder that belong to a dataset, of whatever version and however damaged.

    These are the files that its manifest lists, by name or by content; and, where the manifest is damaged, the tables
    that are known by name and schema, with what stands beside tables.

    Parameters
    ----------
    folder : Path
        Need not be there.
    """
    names: set[str] = set()
    digests: set[str] = set()
    with suppress(OSError, ValueError, RecursionError):
        manifest = json.loads((folder / NAME).read_text(encoding="utf-8"))
        if isinstance(manifest, dict) and manifest.get("dataset") in list(DATASETS) and "tables" in manifest:
            names, digests = {NAME, *_values(manifest, "file")}, set(_values(manifest, "sha256"))
    for path in folder.glob("*.parquet"):
        if path.name not in names and (_is_table(path) or (path.is_file() and file_hash(path) in digests)):
            names.add(path.name)
    return names | {NAME, *_TEXTS} if names else names


#: What a dataset may take the place of.
DATASET_FOLDER = Kind("dataset", own_files)
