r"""Products of matrices of balls by exact products of binary64 matrices.

A ball is cut into digits to the base 2^20. Products of digits, and sums of some thousands of them, are integers
below 2^53: binary64 matrix products of digits are exact, in any order of summation, and run as fast as the
machine multiplies. Their sum is then gathered into a head and a rest by additions whose rounding errors are
kept. What is cut off, and the radii of the balls, are bounded; the bound goes with the result.

References
----------
K. Ozaki, T. Ogita, S. Oishi, S. M. Rump, "Error-free transformations of matrix multiplication by using fast
routines of matrix multiplication and its applications", Numer. Algorithms 59 (2012) 95-118.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb
from numpy.typing import NDArray

_Array = NDArray[np.float64]

#: Bits of a digit; two digits are five bytes.
_BITS = 20
#: Digits of a number, an even count: 200 bits. A pair of binary64 needs 106, and 160 prove a rest negligible
#: (`sinsref.rounding.NEGLIGIBLE`); the others are for cancellation.
_DIGITS = 10
_SHIFT = _BITS * _DIGITS
#: As many terms of a sum keep it below 2^53: products below 2^40, at most `_DIGITS` of them a term.
_MAXIMUM_TERMS = 2 ** (53 - 2 * _BITS) // _DIGITS
#: Exponents up to this keep every step clear of overflow and underflow.
_MAXIMUM_EXPONENT = 500


class OutOfRangeError(ArithmeticError):
    """Numbers too large, or sums too long, for products of digits."""


@dataclass(frozen=True)
class Digits:
    r"""Numbers :math:`x = 2^{e} (\sum_i d_i 2^{-20 i} + \delta)`, smaller than 2^(e-1).

    Attributes
    ----------
    digits : ndarray, shape (10, ...)
        Integers d_1 ... d_10, d_1 from -2^19 to 2^19, the others from 0 to 2^20.
    exponents : ndarray of int, shape (...)
        e.
    errors : ndarray, shape (...)
        Bounds of delta, radii included.
    """

    digits: _Array
    exponents: NDArray[np.int64]
    errors: _Array


def exponents_of(balls: Sequence[arb]) -> NDArray[np.int64]:
    """Return for each ball an exponent e such that the ball lies within 2^e, certainly.

    Raises
    ------
    OutOfRangeError
        If a ball is not finite in binary64.
    """
    # Rounded up by far more than their few roundings; zero, and what underflows, counts as 1e-120.
    middles = np.abs(np.array(list(map(float, balls))))
    magnitude = (middles + radii_of(balls)) * (1 + 2.0**-50) + 1e-120
    if not np.isfinite(magnitude).all():
        raise OutOfRangeError("a ball is not finite in binary64")
    exponents: NDArray[np.int64] = np.frexp(magnitude)[1].astype(np.int64)
    return exponents


def radii_of(balls: Sequence[arb]) -> _Array:
    """Return bounds of the radii."""
    return np.array(list(map(float, map(arb.rad, balls)))) * (1 + 2.0**-50) + 1e-300


def cut(balls: Sequence[arb], exponents: NDArray[np.int64]) -> Digits:
    """Cut balls into digits.

    Parameters
    ----------
    balls : sequence of arb
        n balls.
    exponents : ndarray of int, shape (n,)
        Each at least one more than that of `exponents_of`.

    Raises
    ------
    OutOfRangeError
        If an exponent is beyond 500 in magnitude.
    """
    radii = radii_of(balls)
    if np.abs(exponents).max(initial=0) > _MAXIMUM_EXPONENT:
        raise OutOfRangeError("a ball is too large or too small to be cut into digits")
    half = 1 << (_SHIFT - 1)
    packed = b"".join(
        (_scaled(ball, _SHIFT - e) + half).to_bytes(_SHIFT // 8, "little")
        for ball, e in zip(balls, exponents.tolist(), strict=True)
    )
    b = np.frombuffer(packed, np.uint8).reshape(len(balls), _DIGITS // 2, 5).astype(np.float64)
    high_nibble = np.floor(b[..., 2] / 16)
    low = b[..., 0] + 256 * b[..., 1] + 65536 * (b[..., 2] - 16 * high_nibble)
    high = high_nibble + 16 * b[..., 3] + 4096 * b[..., 4]
    digits = np.stack([low, high], axis=-1).reshape(len(balls), _DIGITS).T[::-1].copy()
    digits[0] -= 2 ** (_BITS - 1)
    # Rounding down to an integer costs less than one unit of the last digit.
    return Digits(digits, exponents, 2.0**-_SHIFT + np.ldexp(radii, -exponents))


def _scaled(ball: arb, shift: int) -> int:
    """Return the midpoint times 2^shift, rounded down."""
    mantissa, exponent = ball.mid().man_exp()
    places = int(exponent) + shift
    return int(mantissa) << places if places >= 0 else int(mantissa) >> -places


def product(left: Sequence[Sequence[arb]], right: Digits) -> tuple[_Array, _Array, _Array]:
    """Return the product of an m x k matrix of balls and a k x n matrix of digits.

    Parameters
    ----------
    left : m sequences of k arb
    right : Digits
        ``digits`` of shape (10, k, n), one exponent and one error a row: shape (k,).

    Returns
    -------
    head, rest, bound : ndarray, shape (m, n)
        The exact value is within `bound` of head + rest.

    Raises
    ------
    OutOfRangeError
        If the product cannot be formed exactly; `cut` says when, and k is at most 819.
    """
    rows, terms = len(left), len(right.exponents)
    if terms > _MAXIMUM_TERMS:
        raise OutOfRangeError(f"a sum of {terms} products of digits is not exact")
    flat = [ball for row in left for ball in row]
    own = exponents_of(flat).reshape(rows, terms)
    # Products that are zero, or nearly, are cut at the same place as the smallest admissible ones.
    common = np.maximum((own + right.exponents).max(axis=1) + 1, -_MAXIMUM_EXPONENT)
    if common.max() > _MAXIMUM_EXPONENT:
        raise OutOfRangeError("a product of balls is too large for digits")
    cut_left = cut(flat, (common[:, None] - right.exponents).ravel())
    a = cut_left.digits.reshape(_DIGITS, rows, terms)
    parts = []
    for weight in range(2, _DIGITS + 2):
        # All pairs of digits whose places add up to the weight, as one product.
        first = np.concatenate([a[i - 1] for i in range(1, weight)], axis=1)
        second = np.concatenate([right.digits[weight - i - 1] for i in range(1, weight)], axis=0)
        parts.append(np.ldexp(first @ second, (common - _BITS * weight)[:, None]))
    # What a term a b leaves is at most |a| times the error of b, and |b| < 1/2, with its error, times that of a.
    # Pairs of digits beyond the last weight, at most ten a weight, are below eleven units of 2^-200 a term.
    size = np.ldexp(1.0, own + right.exponents - common[:, None])
    left_errors = cut_left.errors.reshape(rows, terms)
    error = (size * right.errors + left_errors * (0.5 + right.errors)).sum(axis=1)
    error = (error + terms * (_DIGITS + 1) * 2.0**-_SHIFT) * (1 + 2.0**-40)
    head, rest, remainder = _gather(parts)
    return head, rest, (remainder + np.ldexp(error, common)[:, None]) * (1 + 2.0**-50)


def _gather(parts: list[_Array]) -> tuple[_Array, _Array, _Array]:
    """Return head, rest and a bound of what is left of a sum, the largest parts first.

    Each pass replaces the parts by others of the same exact sum, in which the first takes all it can hold.
    """
    for _ in range(3):
        total = parts[-1]
        for i in range(len(parts) - 2, -1, -1):
            total, parts[i + 1] = _exact_sum(parts[i], total)
        parts[0] = total
    left = np.abs(parts[2])
    for part in parts[3:]:
        left = left + np.abs(part)
    return parts[0], parts[1], left * (1 + 2.0**-48)


def _exact_sum(a: _Array, b: _Array) -> tuple[_Array, _Array]:
    """Return the rounded sum and its rounding error (Knuth's two-sum)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)
