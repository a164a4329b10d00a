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
from sinsref.rounding import RoundingTally, pairs_at, settle

#: ``formula(arithmetic, time)`` returns the values of a row.
RowFormula: TypeAlias = Callable[[Arithmetic, Number], Sequence[Number]]

#: Rows that are computed, and later written, together: what bounds the memory.
BLOCK = 16384


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

    table = _table(formula, interval, bits)
    for start in range(first, first + count, BLOCK):
        index = np.arange(start, min(start + BLOCK, first + count))
        if table is None:
            high, low = pairs_at(at, index.tolist(), bits, tally)
        else:
            with BallArithmetic(bits):
                high, low, decided = table.pairs(start, len(index))
            settle(at, index.tolist(), high, low, decided, tally)
        yield Block(index, high[:, 0], low[:, 0], high[:, 1:], low[:, 1:])


def _table(formula: RowFormula, interval: ExactNumber, bits: int) -> Table | None:
    """Return the formula as a table of exponential sums, None where it is none."""
    with ExponentialSumArithmetic(bits) as arithmetic:
        try:
            values = formula(arithmetic, arithmetic.time)
        except NotAnExponentialSumError:
            return None
        return Table(arithmetic, [arithmetic.time, *values], arithmetic.number(interval))
