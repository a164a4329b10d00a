"""Rows of a stored dataset computed again, by mpmath and from the case alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isnan
from typing import Any, Literal, TypeAlias

import pyarrow as pa

from sinsdata.cases import Case
from sinsdata.format.columns import SHARE, Column
from sinsdata.format.schema import DATASETS
from sinsdata.generation.tables import TableGroup, groups_of
from sinsref.arithmetic import Number

#: Relative error that a pair may have at most: the accuracy that the columns state.
PAIR_TOLERANCE = 1e-30
#: How many rows of each case and table to compute again: a number, all, or `FEW` that cost little.
Wanted: TypeAlias = int | Literal["all", "few"]
FEW = 3


@dataclass
class Worst:
    """The largest of some errors.

    Attributes
    ----------
    size : float
    where : str
    count : int
        Of what was compared.
    """

    size: float = 0.0
    where: str = ""
    count: int = 0

    def take(self, size: float, where: str, count: int = 1) -> None:
        """Count something that was compared, of which `size` is the largest error; NaN counts as infinite."""
        size = inf if isnan(size) else size
        self.count += count
        if size > self.size:
            self.size, self.where = size, where


def rows_to_recompute(group: TableGroup, case: Case, wanted: Wanted, first: int, end: int) -> Sequence[int]:
    """Return which of some rows of a case to compute again: first and last of the case and evenly between.

    Parameters
    ----------
    group : TableGroup
    case : Case
    wanted : int, "all" or "few"
        How many rows of the case, at most. A `FEW` are looked for where they cost little, in the first
        `TableGroup.spot_limit` rows; any other number reaches to the last row.
    first, end : int
        Only rows from `first` on and before `end`.
    """
    if group.exact_rows is None:
        return ()
    rows = group.rows(case)
    if wanted == "few":
        wanted, rows = FEW, min(rows, group.spot_limit)
    if wanted == "all" or wanted >= rows:
        return range(first, min(end, rows))
    chosen = {round(i * (rows - 1) / max(wanted - 1, 1)) for i in range(wanted)}
    return sorted(row for row in chosen if first <= row < end)


def pair_columns(dataset: str, table: str) -> list[str]:
    """Return the names of the pair columns of a table."""
    return [column.name for column in DATASETS[dataset].tables[table] if column.kind == "pair"]


def computed_columns(dataset: str, table: str) -> list[Column]:
    """Return the columns of a table whose values a second path computes again."""
    return [column for column in DATASETS[dataset].tables[table] if column.kind in ("pair", "value")]


def errors(
    dataset: str, group: TableGroup, case: Case, rows: Sequence[int], stored: Iterable[Sequence[dict[str, Any]]]
) -> Iterator[tuple[int, str, str, float]]:
    """Compute rows of a group again, and yield row, table, column and relative error of each pair.

    Parameters
    ----------
    dataset : str
    group : TableGroup
    case : Case
    rows : sequence of int
        Increasing.
    stored : iterable of sequence of dict
        For each row that of each table of the group, as pyarrow gives it to Python; a table may be left out by an
        empty dict.
    """
    assert group.exact_rows is not None
    for row, exact, of_tables in zip(rows, group.exact_rows(case, rows), stored, strict=True):
        place = 0
        for table, values in zip(group.tables, of_tables, strict=True):
            columns = computed_columns(dataset, table)
            timed = columns[0].name == "time"
            width = len(columns) - timed
            if exact is None:
                wanted: Sequence[Number | None] = [None] * len(columns)
            else:
                own = exact[timed + place : timed + place + width]
                wanted = [exact[0], *own] if timed else own
            place += width
            if values:
                for column, error in zip(columns, row_errors(values, columns, wanted), strict=True):
                    yield row, table, column.name, error


def largest_errors(
    dataset: str, case: Case, rows: Sequence[int], batches: Mapping[str, pa.RecordBatch]
) -> dict[str, Worst]:
    """Compute rows of a case again and return the largest error of each table, in units of `PAIR_TOLERANCE`.

    Parameters
    ----------
    dataset : str
    case : Case
    rows : sequence of int
        Increasing.
    batches : mapping of str to RecordBatch
        The stored rows, of tables of one group.
    """
    group = groups_of(dataset, list(batches))[-1]
    stored = (
        [python_row(batches[name], place) if name in batches else {} for name in group.tables]
        for place in range(len(rows))
    )
    worst = {table: Worst() for table in batches}
    for row, table, column, error in errors(dataset, group, case, rows, stored):
        worst[table].take(error / PAIR_TOLERANCE, f"{case.name}, row {row}, {column}")
    return worst


def row_errors(stored: Mapping[str, Any], columns: Sequence[Column], exact: Sequence[Number | None]) -> Iterator[float]:
    """Yield the relative error of each pair of a row; infinite where a number is missing or is none.

    That of a value is given in units of its accuracy, times `PAIR_TOLERANCE`.

    Parameters
    ----------
    stored : mapping of str to float
        By name of the column, and with ``_lo`` for the second of a pair.
    columns : sequence of Column
        Those of `computed_columns`.
    exact : sequence of Number
        A value a column; None where the row has none.
    """
    # mpmath leaves 1e-75 or so of the largest value where the exact one is 0.
    smallest = max((abs(value) for value in exact if value is not None), default=0) * PAIR_TOLERANCE
    largest: dict[str, float] = defaultdict(float)
    for column, value in zip(columns, exact, strict=True):
        if column.kind == "value" and value is not None:
            largest[column.unit] = max(largest[column.unit], float(abs(value)))
    for column, value in zip(columns, exact, strict=True):
        name = column.name
        if column.kind == "value":
            error = _excess(stored[name], value, column, largest[column.unit])
            yield (inf if isnan(error) else error) * PAIR_TOLERANCE
            continue
        pair = (stored[name], stored[f"{name}_lo"])
        if value is None or None in pair:
            yield 0.0 if value is None and pair == (None, None) else inf
        else:
            difference, scale = abs(value - pair[0] - pair[1]), max(abs(value), smallest)
            # In a row of zeros nothing but zero will do.
            error = float(difference / scale) if scale else inf if difference else 0.0
            yield inf if isnan(error) else error


def _excess(stored: float | None, exact: Number | None, column: Column, largest: float) -> float:
    """Return the error of a value in units of what its column allows."""
    if stored is None or exact is None:
        return inf
    allowed = column.within * float(abs(exact)) if column.relative else max(column.within, SHARE * largest)
    error = float(abs(exact - stored))
    return error / allowed if allowed else inf if error else 0.0


def python_row(batch: pa.RecordBatch, row: int) -> dict[str, Any]:
    """Return a row of a batch as a dict of Python values."""
    values: dict[str, Any] = batch.slice(row, 1).to_pylist()[0]
    return values
