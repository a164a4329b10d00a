"""Sine, cosine and logarithm by fixed sequences of IEEE 754 operations: the same bits on every machine.

Libraries of elementary functions differ in the last bit from version to version. Here nothing is used but integers,
and ``+ - * /`` of binary64, elementwise, which the standard defines to the bit; no fused operations, and nothing that
depends on the order of a sum. Arrays in, arrays of the same shape out.

Errors, confirmed by mpmath in the tests: below 0.8 units in the last place of the result.

Sources: T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971)
224-242; W. J. Cody, W. Waite, "Software manual for the elementary functions", Prentice-Hall 1980 (reduction of the
argument in parts).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Words: TypeAlias = NDArray[np.uint64]

#: Splits a binary64 into halves of 26 bits.
_SPLITTER = 2.0**27 + 1
#: 2 pi 2^-64, rad in a unit of `sin_cos_of_turns`, and what is left.
_UNIT, _UNIT_REST = 6.283185307179586 * 2.0**-64, 2.4492935982947064e-16 * 2.0**-64
#: pi/2 in parts of 33 bits: products with whole numbers up to 2^20 are exact.
_QUARTERS = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
#: ln 2: the first 32 bits, and what is left.
_LN2, _LN2_REST = 0.6931471803691238, 1.9082149292705877e-10
#: Coefficients of sin(x)/x - 1 and of cos(x) - 1 + x^2/2 by powers of x^2, from x^2 and x^4 on; below 2^-64 beyond.
_SINE = [(-1.0) ** k / factorial(2 * k + 1) for k in range(1, 9)]
_COSINE = [(-1.0) ** k / factorial(2 * k) for k in range(2, 10)]
#: Coefficients of ln((1+s)/(1-s))/s - 2 by powers of s^2.
_LOGARITHM = [2.0 / (2 * k + 1) for k in range(1, 13)]
_ROOT_HALF = 0.7071067811865476


def two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Return the rounded sum and its error, exactly."""
    total = a + b
    other = total - a
    return total, (a - (total - other)) + (b - other)


def two_product(a: Floats, b: Floats | float) -> tuple[Floats, Floats]:
    """Return the rounded product and its error, exactly but for underflow."""
    product = a * b
    (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def _split(a: Floats | float) -> tuple[Floats | float, Floats | float]:
    scaled = a * _SPLITTER
    high = scaled - (scaled - a)
    return high, a - high


def polynomial(coefficients: Sequence[float], x: Floats) -> Floats:
    """Return the sum of coefficients times powers 0, 1, ... of x, by Horner's rule."""
    total = np.full_like(x, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total


def sin_cos_of_turns(turns: Words) -> tuple[Floats, Floats]:
    """Return sine and cosine of an angle in units of 2^-64 turn: whole turns are nothing, so the unit wraps around."""
    quadrant = (turns + np.uint64(2**61)) >> np.uint64(62)
    rest = (turns - (quadrant << np.uint64(62))).view(np.int64)
    high = rest.astype(np.float64)
    low = (rest - high.astype(np.int64)).astype(np.float64)
    x, error = two_product(high, _UNIT)
    return _in_quadrant(quadrant, x, error + (high * _UNIT_REST + low * _UNIT))


def sin_cos(angle: Floats, rest: Floats | float = 0.0) -> tuple[Floats, Floats]:
    """Return sine and cosine of ``angle + rest``, rad: an angle up to 10^6, and a rest below its last place."""
    quarters = np.rint(angle * 0.6366197723675814)
    # The first difference is exact: both are multiples of the last bit of the angle, and they nearly agree.
    high, low = two_sum(angle - quarters * _QUARTERS[0], -(quarters * _QUARTERS[1]))
    x, error = two_sum(high, (low + rest) - quarters * _QUARTERS[2])
    return _in_quadrant(quarters.astype(np.int64).view(np.uint64), x, error)


def _in_quadrant(quadrant: Words, x: Floats, rest: Floats) -> tuple[Floats, Floats]:
    """Return sine and cosine of ``quadrant * pi/2 + x + rest``, where |x| is at most pi/4 and a little."""
    square = x * x
    half = 0.5 * square
    sine = x + (x * (square * polynomial(_SINE, square)) + rest * (1.0 - half))
    whole = 1.0 - half
    cosine = whole + (((1.0 - whole) - half) + (square * square * polynomial(_COSINE, square) - x * rest))
    odd = (quadrant & np.uint64(1)).astype(bool)
    sine, cosine = np.where(odd, cosine, sine), np.where(odd, sine, cosine)
    return (
        np.where((quadrant & np.uint64(2)).astype(bool), -sine, sine),
        np.where(((quadrant + np.uint64(1)) & np.uint64(2)).astype(bool), -cosine, cosine),
    )


def logarithm(x: Floats) -> Floats:
    """Return the natural logarithm of positive normal numbers."""
    bits = x.view(np.uint64)
    exponent = (bits >> np.uint64(52)).astype(np.int64) - 1022
    fraction = ((bits & np.uint64(2**52 - 1)) | np.uint64(1022 << 52)).view(np.float64)
    small = fraction < _ROOT_HALF
    fraction = np.where(small, 2.0 * fraction, fraction)
    power = np.where(small, exponent - 1, exponent).astype(np.float64)
    f = fraction - 1.0
    # ln(1+f) = 2 s + 2 s^3/3 + ... with s = f/(2+f); the rounding of s itself would cost a unit in the last place.
    divisor = 2.0 + f
    s = f / divisor
    back, error = two_product(s, divisor)
    rest = (((f - back) - error) - s * (f - (divisor - 2.0))) / divisor
    square = s * s
    tail = s * (square * polynomial(_LOGARITHM, square)) + 2.0 * rest
    large, doubled = power * _LN2, 2.0 * s
    total = large + doubled
    return total + ((doubled - (total - large)) + (tail + power * _LN2_REST))
