"""The manifest of a dataset: what its folder holds, with the hashes that prove it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from sinsdata.format.names import safe_names
from sinsdata.format.schema import DATASETS, FORMAT
from sinsdata.format.storage import json_text
from sinsdata.truth.formulas import WORKING_BITS
from sinsref.rounding import RoundingTally

NAME = "manifest.json"
#: Packages whose versions decide on the bytes of a dataset.
_MAKERS = ("sinsbench", "pyarrow", "python-flint")


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
            "method": "ball arithmetic; x nearest binary64, x + x_lo within 1e-30 relative, both proved",
            "first_working_bits": WORKING_BITS,
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
    manifest = json.loads(text)
    seal = manifest.pop("sha256", None)
    return bool(seal == _own_hash(manifest) and text == json_text({**manifest, "sha256": seal}))


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a dataset folder.

    Raises
    ------
    DatasetError
        If it cannot be read, is of a dataset, format or version that this version does not know, or names files
        outside its folder.
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
        for table, entry in manifest["tables"].items():
            if table not in DATASETS[dataset].tables:
                raise ValueError(f"unknown table {table[:80]!r}; admissible: {', '.join(DATASETS[dataset].tables)}")
            if not entry["files"]:
                raise ValueError(f"table {table} has no file")
        if "cases" not in manifest["tables"]:
            raise ValueError("the table of the cases is missing")
        safe_names(entry["file"] for entry in all_files(manifest))
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DatasetError(f"{path}: not a manifest: {type(error).__name__}: {error}") from None
    return manifest


def table_files(folder: Path, manifest: Mapping[str, Any], table: str) -> list[Path]:
    """Return the files of a table, in the order of the rows."""
    return [folder / entry["file"] for entry in manifest["tables"][table]["files"]]


def all_files(manifest: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the entries, with ``file``, ``bytes`` and ``sha256``, of all files but the manifest."""
    for entry in manifest["tables"].values():
        yield from entry["files"]
    yield from manifest["files"]
