"""Relations between stored rows, written as residuals that are zero for exact values.

The pairs are within 2^-106 of those. A sum adds at most 3, a product 7 times as much of its majorant
(`sinsdata.verification.double_double`): three quaternion products one after the other, the longest chain there is,
stay within 70 x 2^-106 = 9e-31 of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases import Case
from sinsdata.format.schema import DATASETS
from sinsdata.verification.double_double import DoubleDouble, nearest
from sinsdata.verification.stored_rows import Places, Window
from sinsref.arithmetic import MpArithmetic

#: Largest residual, as a part of its majorant.
TOLERANCE = 1e-30
#: What may stand as zero is below 1e-300; its multiples are taken for nothing.
_NOTHING = 1e-260
#: Digits of constants: those of a pair, and of what cancels in them.
DIGITS = 60
#: Cases whose constants are kept.
CACHED_CASES = 4096


@dataclass(frozen=True)
class Residual:
    """Rows of something that is zero.

    Attributes
    ----------
    places : Places
        Of its rows.
    value : DoubleDouble
    bound : ndarray, optional
        What its magnitude may be, where that is not `TOLERANCE` times the majorant.
    """

    places: Places
    value: DoubleDouble
    bound: NDArray[np.float64] | None = None

    @property
    def excess(self) -> NDArray[np.float64]:
        """Magnitude in units of the bound, row by row: at most 1; NaN counts as infinite."""
        allowed = self.value.majorant * TOLERANCE if self.bound is None else self.bound
        excess: NDArray[np.float64] = np.abs(self.value.high + self.value.low) / (allowed + _NOTHING)
        return np.where(np.isnan(excess), np.inf, excess)


Residuals: TypeAlias = Iterator[Residual]


@dataclass(frozen=True)
class Invariant:
    """A relation.

    Attributes
    ----------
    tables : tuple of str
        What it needs.
    name : str
    residuals : callable
        ``residuals(window)`` yields them.
    """

    tables: tuple[str, ...]
    name: str
    residuals: Callable[[Window], Residuals]


def differences(places: Places, left: Sequence[DoubleDouble], right: Sequence[Any]) -> Residuals:
    """Yield what two vectors differ by."""
    for x, y in zip(left, right, strict=True):
        yield Residual(places, x - y)


@cache
def pair_names(dataset: str, table: str) -> tuple[str, ...]:
    """Return the names of the value columns."""
    columns = DATASETS[dataset].tables[table]
    return tuple(column.name for column in columns if column.kind == "pair" and column.name != "time")


def values(window: Window, dataset: str, table: str) -> list[DoubleDouble]:
    """Return the value columns of a table."""
    return [window.column(table, name) for name in pair_names(dataset, table)]


@lru_cache(CACHED_CASES)
def interval_of(case: Case) -> DoubleDouble:
    """Return the interval of a case, s."""
    ar = MpArithmetic(DIGITS)
    return nearest([ar.number(case.interval)])
