"""Arrays of pairs of binary64 with arithmetic of twice the precision, and a bound of what its roundings may do.

Sums and products of two binary64 are a pair exactly (error-free transformations), without fused operations and in
any order of vectorisation. Beside the value runs a majorant: what the formula would give with all terms positive. The
error of a result is a small multiple of 2^-104 times that, whatever cancels: a formula brings its own tolerance.

Sources: T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971)
224-242; D. E. Knuth, "The Art of Computer Programming", volume 2, 4.2.2.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from sinsref.arithmetic import Number

Floats: TypeAlias = NDArray[np.float64]

#: Splits a binary64 into halves of 26 bits.
_SPLITTER = 2.0**27 + 1


def _two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    total = a + b
    other = total - a
    return total, (a - (total - other)) + (b - other)


def _fast_two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Return sum and error where |a| >= |b|."""
    total = a + b
    return total, b - (total - a)


def _split(a: Floats) -> tuple[Floats, Floats]:
    scaled = a * _SPLITTER
    high = scaled - (scaled - a)
    return high, a - high


def _two_product(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    product = a * b
    a_high, a_low = _split(a)
    b_high, b_low = (a_high, a_low) if b is a else _split(b)
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


class DoubleDouble:
    """Values high + low, one for each row.

    Parameters
    ----------
    high, low : ndarray
        Binary64 and what is left, at most half a unit in the last place of `high`; below 1e290 in magnitude.
    majorant : ndarray, optional
        The magnitude of `high` by default.
    """

    __slots__ = ("high", "low", "majorant")

    def __init__(self, high: Floats, low: Floats, majorant: Floats | None = None) -> None:
        self.high, self.low = high, low
        self.majorant = np.abs(high) if majorant is None else majorant

    def __getitem__(self, rows: NDArray[np.int64] | NDArray[np.bool_]) -> DoubleDouble:
        return DoubleDouble(self.high[rows], self.low[rows], self.majorant[rows])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low, self.majorant)

    def __add__(self, other: DoubleDouble | int) -> DoubleDouble:
        b = _pair(other)
        high, rest = _two_sum(self.high, b.high)
        low, lowest = _two_sum(self.low, b.low)
        high, rest = _fast_two_sum(high, rest + low)
        return DoubleDouble(*_fast_two_sum(high, rest + lowest), self.majorant + b.majorant)

    __radd__ = __add__

    def __sub__(self, other: DoubleDouble | int) -> DoubleDouble:
        return self + (-other)

    def __rsub__(self, other: int) -> DoubleDouble:
        return -self + other

    def __mul__(self, other: DoubleDouble | int) -> DoubleDouble:
        b = _pair(other)
        high, rest = _two_product(self.high, b.high)
        return DoubleDouble(
            *_fast_two_sum(high, rest + (self.high * b.low + self.low * b.high)), self.majorant * b.majorant
        )

    __rmul__ = __mul__

    def __truediv__(self, power_of_two: int) -> DoubleDouble:
        scale = 1 / power_of_two
        return DoubleDouble(self.high * scale, self.low * scale, self.majorant * scale)


def _pair(value: DoubleDouble | int) -> DoubleDouble:
    return value if isinstance(value, DoubleDouble) else DoubleDouble(np.array([float(value)]), np.zeros(1))


def nearest(values: list[Number]) -> DoubleDouble:
    """Return numbers of mpmath as an array of pairs."""
    high = [float(value) for value in values]
    low = [float(value - x) for value, x in zip(values, high, strict=True)]
    return DoubleDouble(np.array(high), np.array(low))
