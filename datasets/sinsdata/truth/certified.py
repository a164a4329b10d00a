"""Certified tables: rows of exact values as pairs of binary64, proved by balls, block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.exponential_sums import ExponentialSumArithmetic, NotAnExponentialSumError, Table
from sinsref.rounding import ESCALATION, RoundingTally, pairs_at, settle

#: ``formula(arithmetic, time)`` returns the values of a row.
RowFormula: TypeAlias = Callable[[Arithmetic, Number], Sequence[Number]]

#: Rows that are computed, and later written, together: what bounds the memory.
BLOCK = 65536
#: Formulas that are no sums of exponentials keep a ball for each of their values.
ROWS_OF_BALLS = 4096


@dataclass(frozen=True)
class Block:
    """Consecutive rows of a table.

    Attributes
    ----------
    index : ndarray of int, shape (n,)
        Epoch numbers k.
    time, time_lo : ndarray, shape (n,)
        k * interval as a pair, s.
    high, low : ndarray, shape (n, w)
        Nearest binary64 of each value, and of what is left.
    """

    index: NDArray[np.int64]
    time: NDArray[np.float64]
    time_lo: NDArray[np.float64]
    high: NDArray[np.float64]
    low: NDArray[np.float64]


def blocks(
    formula: RowFormula, interval: ExactNumber, first: int, count: int, bits: int, tally: RoundingTally
) -> Iterator[Block]:
    """Tabulate a formula at equidistant epochs.

    Sums of exponentials in time are tabulated by products of ball matrices (`sinsref.exponential_sums`),
    any other formula epoch by epoch. Both ways give the same pairs: these are correct roundings of the same
    exact values.

    Parameters
    ----------
    formula : callable
        ``formula(arithmetic, time)``.
    interval : ExactNumber
        Distance of the epochs, s.
    first, count : int
        First epoch number and number of epochs.
    bits : int
        Working precision of the first attempt.
    tally : RoundingTally
        Counts how values were decided.

    Yields
    ------
    Block
    """

    def at(arithmetic: Arithmetic, index: int) -> Sequence[Number]:
        time = arithmetic.number(interval) * index
        return [time, *formula(arithmetic, time)]

    table = _table(formula, interval, bits, count)
    negligible: NDArray[np.bool_] | None = None
    block = BLOCK if table else min(BLOCK, ROWS_OF_BALLS)
    for start in range(first, first + count, block):
        index = np.arange(start, min(start + block, first + count))
        if table is None:
            high, low = pairs_at(at, index.tolist(), bits, tally)
        else:
            with BallArithmetic(bits):
                high, low, decided = table.pairs(start, len(index))
            if not decided.any(axis=0).all():
                # A column without a decided value is zero, as a rule. That is proved once, not row by row.
                if negligible is None:
                    negligible = _negligible_columns(formula, interval, first, count)
                columns = negligible & ~decided.any(axis=0)
                high[:, columns], low[:, columns], decided[:, columns] = 0.0, 0.0, True
                tally.raised += int(columns.sum()) * len(index)
                tally.bounded_zeros += int(columns.sum()) * len(index)
            settle(at, index.tolist(), high, low, decided, tally)
        yield Block(index, high[:, 0], low[:, 0], high[:, 1:], low[:, 1:])


def _table(formula: RowFormula, interval: ExactNumber, bits: int, count: int) -> Table | None:
    """Return the formula as a table of exponential sums for so many epochs, None where it is none."""
    with ExponentialSumArithmetic(bits) as arithmetic:
        try:
            values = formula(arithmetic, arithmetic.time)
        except NotAnExponentialSumError:
            return None
        # A power of two near the root of twice the count.
        fine = 1 << ((2 * count).bit_length() // 2)
        return Table(arithmetic, [arithmetic.time, *values], arithmetic.number(interval), fine)


def _negligible_columns(formula: RowFormula, interval: ExactNumber, first: int, count: int) -> NDArray[np.bool_]:
    """Return which columns of a table of exponential sums, time in front, the highest precision takes for zero."""
    table = _table(formula, interval, ESCALATION[-1], 1)
    assert table is not None
    with BallArithmetic(ESCALATION[-1]):
        return table.negligible_columns(first, count)
