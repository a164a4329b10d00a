"""Verification of a dataset on disk: bytes, content, schema, and values computed again by the other path."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, inf, isnan, log10
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sinsdata.cases import CASE_CLASSES, Case, EquatorCase
from sinsdata.generate import case_table
from sinsdata.schema import DATASETS, FORMAT, arrow_schema, without_generator
from sinsdata.storage import content_hash, file_hash
from sinsdata.tiers import CaseFileError, checked_cases
from sinsdata.truth import TRANSITION_ELEMENTS, equator_state
from sinsref.arithmetic import MpArithmetic
from sinsref.equator import EquatorModel, guard_bits, transition
from sinsref.equator_modes import Modes, NoRealModesError, modes
from sinsref.precession import increments
from sinsref.precession import solution as precession_solution

#: Relative error that a pair may have at most.
PAIR_TOLERANCE = 1e-30


class DatasetError(ValueError):
    """A folder is not a dataset that this version reads; the message says which and why."""


@dataclass(frozen=True)
class Check:
    """One thing that was checked.

    Attributes
    ----------
    where : str
        Folder and table.
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


def find_datasets(folder: Path) -> list[Path]:
    """Return the dataset folders at or below a folder.

    Raises
    ------
    DatasetError
        If there is none.
    """
    if not folder.is_dir():
        raise DatasetError(f"{folder}: {'a file, not a folder' if folder.exists() else 'no such folder'}")
    patterns = ("manifest.json", "*/manifest.json", "*/*/manifest.json")
    found = sorted({path.parent for pattern in patterns for path in folder.glob(pattern)})
    found = [path for path in found if not any(part.startswith(".") for part in path.relative_to(folder).parts)]
    if not found:
        raise DatasetError(f"{folder}: not a dataset: no manifest.json here or in DATASET/TIER below")
    return found


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a dataset folder.

    Raises
    ------
    DatasetError
        If it cannot be read, or is of a dataset, format or version that this version does not know.
    """
    path = folder / "manifest.json"
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        about = manifest["format"], manifest["dataset"], manifest["version"]
        tables = {name: entry["file"] for name, entry in manifest["tables"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise DatasetError(f"{path}: not a manifest: {type(error).__name__}: {error}") from None
    layout, dataset, version = about
    if layout != FORMAT:
        raise DatasetError(f"{path}: format {layout!r}; this version reads format {FORMAT}")
    if not isinstance(dataset, str) or dataset not in DATASETS:
        raise DatasetError(f"{path}: unknown dataset {dataset!r}; admissible: {', '.join(DATASETS)}")
    if version != DATASETS[dataset].version:
        raise DatasetError(
            f"{path}: {dataset} version {version}; this version of sinsbench reads {DATASETS[dataset].version}"
        )
    if missing := set(DATASETS[dataset].tables) - set(tables):
        raise DatasetError(f"{path}: no entry for table {min(missing)!r}")
    return dict(manifest)


def load_cases(folder: Path) -> tuple[str, tuple[Case, ...]]:
    """Return name and cases of the dataset in a folder.

    Raises
    ------
    DatasetError
        If the folder is not a dataset that this version reads.
    """
    dataset = read_manifest(folder)["dataset"]
    try:
        rows = pq.read_table(folder / "cases.parquet").to_pylist()
        return dataset, checked_cases(dataset, [_mapping(dataset, row) for row in rows], str(folder / "cases.parquet"))
    except (OSError, pa.ArrowException, KeyError, CaseFileError) as error:
        raise DatasetError(f"{folder / 'cases.parquet'}: {error}") from None


def _mapping(dataset: str, row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table ``cases`` as the keys of a case file."""

    def texts(*names: str) -> list[str] | None:
        values = [row[f"{name}_exact"] for name in names]
        return None if None in values else values

    scalars = {key: row[f"{key}_exact"] for key in CASE_CLASSES[dataset].__dataclass_fields__ if f"{key}_exact" in row}
    given: dict[str, Any] = {"name": row["case"], **scalars}
    if dataset == "equator_errors":
        names = [column.name for column in DATASETS[dataset].tables["truth"][2:]]
        given["initial_errors"] = texts(*(f"{name}_initial" for name in names))
        given["misalignment"] = [texts(*(f"misalignment_{i}{j}" for j in "123")) for i in "123"]
        if None in given["misalignment"]:
            given["misalignment"] = None
    else:
        given["initial_attitude"] = texts(*(f"q_{c}_initial" for c in "wxyz"))
        given["initial_velocity"] = texts(*(f"w_inertial_{c}_initial" for c in "xyz"))
    return given


def verify(folder: Path, rows_per_case: int = 3) -> Iterator[Check]:
    """Check a dataset: bytes, content, schema, rows, and some rows of each case and table computed again.

    Parameters
    ----------
    folder : Path
        The dataset.
    rows_per_case : int, default 3
        Rows of each case that are computed again by mpmath, from the case alone: first, last and evenly
        between.

    Yields
    ------
    Check
    """
    manifest = read_manifest(folder)
    dataset = manifest["dataset"]
    sound = True
    for table in DATASETS[dataset].tables:
        for check in _check_table(folder, dataset, table, manifest["tables"][table]):
            sound = sound and check.holds
            yield check
    if sound:
        yield from _recompute(folder, rows_per_case)


def _check_table(folder: Path, dataset: str, table: str, entry: dict[str, Any]) -> Iterator[Check]:
    path, where = folder / f"{table}.parquet", f"{folder}: {table}"
    if not path.is_file():
        yield Check(where, "file", False, f"{path.name} is missing")
        return
    digest = file_hash(path)
    yield Check(
        where,
        "SHA-256 of the file",
        digest == entry.get("sha256"),
        f"{digest} instead of {entry.get('sha256')}",
    )
    try:
        with pq.ParquetFile(path) as file:
            schema, rows = file.schema_arrow, file.metadata.num_rows
        content = content_hash(path)
    except (OSError, ValueError, pa.ArrowException) as error:  # ValueError: texts that are not UTF-8
        yield Check(where, "readable as Parquet", False, (str(error) or type(error).__name__).splitlines()[0])
        return
    yield Check(
        where,
        "content hash",
        content == entry.get("content_sha256"),
        f"{content} instead of {entry.get('content_sha256')}",
    )
    same = without_generator(schema).equals(without_generator(arrow_schema(dataset, table)), check_metadata=True)
    yield Check(where, "schema, units and metadata", same, "differs from that of this version")
    yield Check(where, "number of rows", rows == entry.get("rows"), f"{rows} instead of {entry.get('rows')}")


def _recompute(folder: Path, rows_per_case: int) -> Iterator[Check]:
    dataset, cases = load_cases(folder)
    named = [case.name for case in cases]
    yield Check(
        f"{folder}: manifest", "names of the cases", read_manifest(folder).get("cases") == named, f"not {named}"
    )
    same = pq.read_table(folder / "cases.parquet").equals(pa.Table.from_batches([case_table(dataset, cases)]))
    yield Check(f"{folder}: cases", "binary64 nearest to the exact texts", same, "a number is not that of its text")
    for table, about in DATASETS[dataset].tables.items():
        if table == "cases":
            continue
        names = [column.name for column in about if column.kind == "pair"]
        for case in cases:
            where = f"{folder}: {table}: {case.name}"
            data = pq.read_table(folder / f"{table}.parquet", filters=[("case", "=", case.name)])
            expected = 1 if table == "modes" else case.samples + (table != "increments")
            yield Check(where, "rows of the case", len(data) == expected, f"{len(data)} instead of {expected}")
            if len(data) != expected:
                continue
            count = min(rows_per_case, len(data))
            wanted = sorted({round(i * (len(data) - 1) / max(count - 1, 1)) for i in range(count)})
            worst, place = 0.0, ""
            for row in wanted:
                index = row + (table == "increments")
                stored = data.slice(row, 1).to_pylist()[0]
                errors = _errors(stored, names, _exact_row(case, table, index))
                errors["sample"] = 0.0 if stored.get("sample", index) == index else inf
                name = max(errors, key=errors.__getitem__)
                if errors[name] > worst:
                    worst, place = errors[name], f"row {row}, {name}"
            detail = f"relative difference {worst:.1e} at {place}"
            yield Check(where, f"{len(wanted)} rows recomputed by mpmath", worst <= PAIR_TOLERANCE, detail)


def _errors(stored: dict[str, Any], names: list[str], exact: list[Any] | None) -> dict[str, float]:
    """Return the relative error of each pair of a row; infinite where a number is missing or is none."""
    pairs = {name: (stored[name], stored[f"{name}_lo"]) for name in names}
    if exact is None:
        return {name: 0.0 if pair == (None, None) else inf for name, pair in pairs.items()}
    # mpmath leaves 1e-75 or so of the largest value where the exact one is 0.
    smallest = max(abs(value) for value in exact) * PAIR_TOLERANCE
    errors = {}
    for (name, pair), value in zip(pairs.items(), exact, strict=True):
        error = inf if None in pair else abs(value - pair[0] - pair[1]) / (max(abs(value), smallest) or 1)
        errors[name] = inf if isnan(error) else float(error)
    return errors


def _exact_row(case: Case, table: str, index: int) -> list[Any] | None:
    """Return the values of a row in mpmath, None for modes that do not exist."""
    # 80 digits leave 1e-30 of the smallest value; on top comes what phases of many turns and cancelling series lose.
    if isinstance(case, EquatorCase):
        ar = MpArithmetic(30)
        model = EquatorModel.at(ar, case.v_east, case.height)
        ar = MpArithmetic(80 + ceil(guard_bits(ar, model, ar.number(case.duration)) * log10(2)))
        model = EquatorModel.at(ar, case.v_east, case.height)
        time = ar.number(case.interval) * index
        if table == "truth":
            return [time, *equator_state(case)(ar, time)]
        if table == "transition":
            matrix = transition(ar, model, time)
            return [time, *(matrix[i - 1][j - 1] for i, j in TRANSITION_ELEMENTS)]
        try:
            constants = modes(ar, model)
        except NoRealModesError:
            return None
        return [getattr(constants, name) for name in Modes.__dataclass_fields__]
    turns = abs(float(case.spin_rate) * float(case.duration)) * (1 + abs(float(case.precession_ratio)))
    ar = MpArithmetic(80 + ceil(log10(1 + turns)))
    time = ar.number(case.interval) * index
    if table == "increments":
        angle, velocity = increments(ar, case.motion, time, ar.number(case.interval))
        return [time, *angle, *velocity]
    attitude, inertial, body = precession_solution(ar, case.motion, time)
    return [time, *attitude, *inertial, *body]
