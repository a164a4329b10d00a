"""Rows of a stored dataset computed again, by mpmath and from the case alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf, isnan
from typing import Any

import pyarrow as pa

from sinsdata.cases import Case
from sinsdata.format.schema import DATASETS
from sinsdata.generation.tables import TableGroup
from sinsref.arithmetic import Number

#: Relative error that a pair may have at most: the accuracy that the columns state.
PAIR_TOLERANCE = 1e-30


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


def rows_to_recompute(group: TableGroup, case: Case, wanted: int | None, first: int, end: int) -> Iterable[int]:
    """Return which of some rows of a case to compute again: first and last of the case and evenly between.

    Parameters
    ----------
    group : TableGroup
    case : Case
    wanted : int or None
        How many rows of the case, at most; None for all.
    first, end : int
        Only rows from `first` on and before `end`.
    """
    if group.exact_row is None:
        return ()
    rows = min(group.rows(case), group.spot_limit)
    if wanted is None or wanted >= rows:
        return range(first, min(end, rows))
    chosen = {round(i * (rows - 1) / max(wanted - 1, 1)) for i in range(wanted)}
    return sorted(row for row in chosen if first <= row < end)


def pair_columns(dataset: str, table: str) -> list[str]:
    """Return the names of the pair columns of a table."""
    return [column.name for column in DATASETS[dataset].tables[table] if column.kind == "pair"]


def errors(
    dataset: str, group: TableGroup, case: Case, row: int, stored: Sequence[dict[str, Any]]
) -> Iterator[tuple[str, str, float]]:
    """Compute a row of the tables of a group again, and yield table, column and relative error of each pair.

    Parameters
    ----------
    dataset : str
    group : TableGroup
    case : Case
    row : int
    stored : sequence of dict
        The row of each table of the group, as pyarrow gives it to Python; a table may be left out by an empty dict.
    """
    assert group.exact_row is not None
    exact = group.exact_row(case, row)
    place = 0
    for table, values in zip(group.tables, stored, strict=True):
        names = pair_columns(dataset, table)
        timed = names[0] == "time"
        width = len(names) - timed
        if exact is None:
            wanted: Sequence[Number | None] = [None] * len(names)
        else:
            own = exact[timed + place : timed + place + width]
            wanted = [exact[0], *own] if timed else own
        place += width
        if values:
            for name, error in zip(names, _errors(values, names, wanted), strict=True):
                yield table, name, error


def _errors(stored: dict[str, Any], names: Sequence[str], exact: Sequence[Number | None]) -> Iterator[float]:
    """Yield the relative error of each pair of a row; infinite where a number is missing or is none."""
    # mpmath leaves 1e-75 or so of the largest value where the exact one is 0.
    smallest = max((abs(value) for value in exact if value is not None), default=0) * PAIR_TOLERANCE
    for name, value in zip(names, exact, strict=True):
        pair = (stored[name], stored[f"{name}_lo"])
        if value is None or None in pair:
            yield 0.0 if value is None and pair == (None, None) else inf
        else:
            difference, scale = abs(value - pair[0] - pair[1]), max(abs(value), smallest)
            # In a row of zeros nothing but zero will do.
            error = float(difference / scale) if scale else inf if difference else 0.0
            yield inf if isnan(error) else error


def python_row(batch: pa.RecordBatch, row: int) -> dict[str, Any]:
    """Return a row of a batch as a dict of Python values."""
    values: dict[str, Any] = batch.slice(row, 1).to_pylist()[0]
    return values
