"""Generation of a dataset: cases to certified tables, Parquet and a manifest."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pyarrow as pa

from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.certified import Block
from sinsdata.schema import DATASETS, FORMAT, arrow_schema
from sinsdata.storage import replacing, write_json, write_table
from sinsdata.truth import (
    WORKING_BITS,
    equator_blocks,
    equator_modes,
    increment_blocks,
    precession_blocks,
    transition_blocks,
)
from sinsref.exact import ExactNumber
from sinsref.rounding import RoundingTally

#: ``progress(rows done, rows in all, table)``.
Progress: TypeAlias = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Generated:
    """What `generate` wrote.

    Attributes
    ----------
    folder : Path
        The dataset.
    manifest : dict
        Its manifest.
    """

    folder: Path
    manifest: dict[str, Any]


#: Table name -> certified blocks of one case, and the first sample number (None: the table has no samples).
_SERIES: dict[str, dict[str, tuple[Callable[[Any, RoundingTally], Iterator[Block]], int | None]]] = {
    "equator_errors": {"truth": (equator_blocks, None), "transition": (transition_blocks, None)},
    "dual_precession": {"increments": (increment_blocks, 1), "truth": (precession_blocks, 0)},
}


def generate(
    dataset: str,
    tier: str,
    cases: Sequence[Case],
    out: Path,
    progress: Progress = lambda done, total, table: None,
) -> Generated:
    """Write a dataset to the folder ``out/dataset/tier``, in place of one that is there.

    Parameters
    ----------
    dataset, tier : str
    cases : sequence of Case
    out : Path
    progress : callable, optional
        Called with rows done, rows in all, and the table at work.

    Returns
    -------
    Generated
    """
    tally = RoundingTally()
    total = sum(case.samples + 1 for case in cases) * len(_SERIES[dataset])
    done = 0

    def counted(table: str, batches: Iterable[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        nonlocal done
        progress(done, total, table)
        for batch in batches:
            yield batch
            done += batch.num_rows
            progress(min(done, total), total, table)

    folder = out / dataset / tier
    with replacing(folder) as partial:
        tables = {"cases": _write(partial, dataset, "cases", [case_table(dataset, cases)])}
        if dataset == "equator_errors":
            tables["modes"] = _write(partial, dataset, "modes", [_modes_table(cases, tally)])
        for table in _SERIES[dataset]:
            batches = counted(table, _series_batches(dataset, table, cases, tally))
            tables[table] = _write(partial, dataset, table, batches)
        manifest = _manifest(dataset, tier, cases, tables, tally)
        # The manifest comes last: a folder without one is no dataset.
        write_json(partial / "manifest.json", manifest)
    progress(total, total, "done")
    return Generated(folder, manifest)


def _write(folder: Path, dataset: str, table: str, batches: Iterable[pa.RecordBatch]) -> dict[str, Any]:
    return write_table(folder / f"{table}.parquet", arrow_schema(dataset, table), batches)


def _manifest(
    dataset: str, tier: str, cases: Sequence[Case], tables: dict[str, dict[str, Any]], tally: RoundingTally
) -> dict[str, Any]:
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
        "generator": {"sinsbench": version("sinsbench")},
        "certification": {
            "method": "ball arithmetic; x nearest binary64, x + x_lo within 1e-30 relative, both proved",
            "first_working_bits": WORKING_BITS,
            **asdict(tally),
        },
        "cases": [case.name for case in cases],
        "tables": tables,
    }


def _batch(dataset: str, table: str, columns: Iterable[Any]) -> pa.RecordBatch:
    schema = arrow_schema(dataset, table)
    arrays = [pa.array(column, type=field.type) for field, column in zip(schema, columns, strict=True)]
    return pa.RecordBatch.from_arrays(arrays, schema=schema)


def _series_batches(dataset: str, table: str, cases: Sequence[Case], tally: RoundingTally) -> Iterator[pa.RecordBatch]:
    blocks_of, first_sample = _SERIES[dataset][table]
    for case in cases:
        for block in blocks_of(case, tally):
            head: list[Any] = [[case.name] * len(block.index)]
            if first_sample is not None:
                head.append(block.index)
            pairs = [values for pair in zip(block.high.T, block.low.T, strict=True) for values in pair]
            yield _batch(dataset, table, [*head, block.time, block.time_lo, *map(np.ascontiguousarray, pairs)])


def _modes_table(cases: Sequence[Case], tally: RoundingTally) -> pa.RecordBatch:
    rows = []
    for case in cases:
        assert isinstance(case, EquatorCase)
        pairs = equator_modes(case, tally).values()
        rows.append([case.name, *(part for pair in pairs for part in (pair or (None, None)))])
    return _batch("equator_errors", "modes", zip(*rows, strict=True))


def case_parameters(case: Case) -> list[ExactNumber | None]:
    """Return the parameters of a case in the order of the columns of the table ``cases``."""
    if isinstance(case, DualPrecessionCase):
        return [
            case.spin_rate, case.precession_ratio, case.nutation, case.spin_rate_dual, case.nutation_dual,
            *(case.initial_attitude or (None,) * 4), *case.initial_velocity, case.duration, case.interval,
        ]  # fmt: skip
    matrix = case.misalignment or ((None,) * 3,) * 3
    return [
        case.v_east, case.height, case.duration, case.interval, *case.initial_errors,
        *(element for row in matrix for element in row), case.inertial_longitude,
    ]  # fmt: skip


def case_table(dataset: str, cases: Sequence[Case]) -> pa.RecordBatch:
    """Return the table ``cases``: of every parameter the nearest binary64 and the exact text."""
    rows = []
    for case in cases:
        cells = [(None, None) if x is None else (float(x), x.text) for x in case_parameters(case)]
        rows.append([case.name, *(part for cell in cells for part in cell)])
    return _batch(dataset, "cases", zip(*rows, strict=True))
