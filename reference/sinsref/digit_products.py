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

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from sinsref.rounding import decide, round_balls

_Array = NDArray[np.float64]
#: High parts, low parts, and whether they are decided.
Pairs: TypeAlias = tuple[_Array, _Array, NDArray[np.bool_]]

#: Bits of a digit; two digits are five bytes.
_BITS = 20
#: Digits of a number, an even count: 200 bits. A pair of binary64 needs 106, and 160 prove a rest negligible
#: (`sinsref.rounding.NEGLIGIBLE`); the others are for cancellation.
ALL_DIGITS = 10
#: Digits that decide nearly all pairs, at half the cost: 140 bits, of which the bound takes eight or so.
FEW_DIGITS = 7
_SHIFT = _BITS * ALL_DIGITS
#: As many terms of a sum keep it below 2^53: products below 2^40, at most `ALL_DIGITS` of them a term.
_MAXIMUM_TERMS = 2 ** (53 - 2 * _BITS) // ALL_DIGITS
#: Values of the places, the least significant first.
_PLACES = 2.0 ** (-_BITS * np.arange(ALL_DIGITS, 0, -1.0))
#: Elements that are rounded together: what the second cache of a processor holds, with all their parts.
_CHUNK = 8192
#: More undecided elements than one in so many are not decided one by one, but all again in more digits.
_MANY = 64
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
        d_10 2^-200 ... d_1 2^-20: the least significant first. The d_i are integers, d_1 from -2^19 to 2^19, the
        others from 0 to 2^20.
    exponents : ndarray of int, shape (...)
        e.
    errors : ndarray, shape (...)
        Bounds of delta, radii included.
    """

    digits: _Array
    exponents: NDArray[np.int64]
    errors: _Array


def exponents_of(balls: Sequence[arb], radii: _Array) -> NDArray[np.int64]:
    """Return for each ball an exponent e such that the ball lies within 2^e, certainly.

    Raises
    ------
    OutOfRangeError
        If a ball is not finite in binary64.
    """
    # Rounded up by far more than their few roundings; zero, and what underflows, counts as 1e-120.
    middles = np.abs(np.array(list(map(float, balls))))
    magnitude = (middles + radii) * (1 + 2.0**-50) + 1e-120
    if not np.isfinite(magnitude).all():
        raise OutOfRangeError("a ball is not finite in binary64")
    exponents: NDArray[np.int64] = np.frexp(magnitude)[1].astype(np.int64)
    return exponents


def radii_of(balls: Sequence[arb]) -> _Array:
    """Return bounds of the radii."""
    return np.array(list(map(float, map(arb.rad, balls)))) * (1 + 2.0**-50) + 1e-300


def cut(balls: Sequence[arb], radii: _Array, exponents: NDArray[np.int64]) -> Digits:
    """Cut balls into digits.

    Parameters
    ----------
    balls : sequence of arb
        n balls.
    radii : ndarray, shape (n,)
        As `radii_of` returns them.
    exponents : ndarray of int, shape (n,)
        Each at least one more than that of `exponents_of`.

    Raises
    ------
    OutOfRangeError
        If an exponent is beyond 500 in magnitude.
    """
    if np.abs(exponents).max(initial=0) > _MAXIMUM_EXPONENT:
        raise OutOfRangeError("a ball is too large or too small to be cut into digits")
    half = 1 << (_SHIFT - 1)
    # The midpoints times 2^(200 - e), rounded down.
    parts = list(map(arb.man_exp, map(arb.mid, balls)))
    mantissas = [int(mantissa) for mantissa, _ in parts]
    places = [int(exponent) + _SHIFT - e for (_, exponent), e in zip(parts, exponents.tolist(), strict=True)]
    packed = b"".join(
        ((mantissa >> -place if place < 0 else mantissa << place) + half).to_bytes(_SHIFT // 8, "little")
        for mantissa, place in zip(mantissas, places, strict=True)
    )
    b = np.frombuffer(packed, np.uint8).reshape(len(balls), ALL_DIGITS // 2, 5).astype(np.float64)
    high_nibble = np.floor(b[..., 2] / 16)
    low = b[..., 0] + 256 * b[..., 1] + 65536 * (b[..., 2] - 16 * high_nibble)
    high = high_nibble + 16 * b[..., 3] + 4096 * b[..., 4]
    digits = np.stack([low, high], axis=-1).reshape(len(balls), ALL_DIGITS).T.copy()
    digits[-1] -= 2 ** (_BITS - 1)
    digits *= _PLACES[:, None]
    # Rounding down to an integer costs less than one unit of the last digit.
    return Digits(digits, exponents, 2.0**-_SHIFT + np.ldexp(radii, -exponents))


def cut_row(balls: Sequence[arb]) -> Digits:
    """Cut balls into digits with the smallest exponent and error that serve all of them."""
    radii = radii_of(balls)
    exponent = exponents_of(balls, radii).max() + 1
    row = cut(balls, radii, np.full(len(balls), exponent))
    return Digits(row.digits, exponent, row.errors.max())


def stacked(rows: Sequence[Digits]) -> Digits:
    """Return k rows of n numbers as a matrix: digits of shape (10, k, n), exponents and errors of shape (k,)."""
    return Digits(
        np.stack([row.digits for row in rows], axis=1),
        np.array([row.exponents for row in rows]),
        np.array([row.errors for row in rows]),
    )


class Product:
    """The product of an m x k matrix of balls and a k x n matrix of digits.

    Parameters
    ----------
    left : m sequences of k arb
    right : Digits
        ``digits`` of shape (10, k, n), one exponent and one error a row: shape (k,).

    Raises
    ------
    OutOfRangeError
        If the product cannot be formed exactly; `cut` says when, and k is at most 819.
    """

    def __init__(self, left: Sequence[Sequence[arb]], right: Digits) -> None:
        rows, terms = len(left), len(right.exponents)
        if terms > _MAXIMUM_TERMS:
            raise OutOfRangeError(f"a sum of {terms} products of digits is not exact")
        flat = [ball for row in left for ball in row]
        radii = radii_of(flat)
        own = exponents_of(flat, radii).reshape(rows, terms)
        # Products that are zero, or nearly, are cut at the same place as the smallest admissible ones.
        common = np.maximum((own + right.exponents).max(axis=1) + 1, -_MAXIMUM_EXPONENT)
        if common.max() > _MAXIMUM_EXPONENT:
            raise OutOfRangeError("a product of balls is too large for digits")
        left_digits = cut(flat, radii, (common[:, None] - right.exponents).ravel())
        # The most significant digits come first on the left and last on the right: the pairs of digits whose places
        # add up to the same weight are then a leading part of one and a trailing part of the other.
        self._left = left_digits.digits[::-1].reshape(ALL_DIGITS, rows, terms).swapaxes(0, 1).reshape(rows, -1)
        self._right = right.digits.reshape(ALL_DIGITS * terms, -1)
        self._terms = terms
        self._size = np.ldexp(1.0, own + right.exponents - common[:, None])
        self._left_errors, self._right_errors = left_digits.errors.reshape(rows, terms), right.errors
        self._scale = np.ldexp(1.0, common)[:, None]

    def rows(self, which: slice, places: int = ALL_DIGITS) -> tuple[_Array, _Array, _Array]:
        """Return rows of the product.

        Parameters
        ----------
        which : slice
        places : int
            Digits of each factor that count, from 3 to 10.

        Returns
        -------
        head, rest, bound : ndarray, shape (rows, n)
            The exact value is within `bound` of head + rest.
        """
        left, scale = self._left[which], self._scale[which]
        parts = np.empty((places, len(left), self._right.shape[1]))
        for pairs, part in enumerate(parts, start=1):
            # All pairs of digits whose places add up to the weight pairs + 1, as one product.
            np.matmul(left[:, : pairs * self._terms], self._right[-pairs * self._terms :], out=part)
        head, rest, remainder = _gather(list(parts))
        # Powers of two within 2^500, on multiples of 2^-220: exact.
        return head * scale, rest * scale, (remainder + self._error(which, places)) * scale

    def round(self, out: Pairs, neglected: float, ball_at: Callable[[int], arb], few: bool = True) -> bool:
        """Round the product, row after row, to pairs: in few digits, what these leave in all or as balls.

        Parameters
        ----------
        out : tuple of ndarray, shape (count,)
            High and low parts of the first `count` elements, and whether both are proved; overwritten.
        neglected : float
            What the exact values may differ by from the product.
        ball_at : callable
            Returns an element, with what is neglected, as a ball.
        few : bool
            Whether to try few digits first.

        Returns
        -------
        bool
            Whether few digits decided nearly all.
        """
        width = self._right.shape[1]
        step = max(_CHUNK // width, 1)
        for start in range(0, len(self._left), step):
            here = [part[start * width : (start + step) * width] for part in out]
            count = len(here[0])
            for places in (FEW_DIGITS, ALL_DIGITS) if few else (ALL_DIGITS,):
                head, rest, bound = (part.ravel()[:count] for part in self.rows(slice(start, start + step), places))
                if neglected:
                    bound = bound * (1 + 2.0**-50) + neglected * (1 + 2.0**-40)
                pairs = decide(head, rest, bound)
                undecided = np.flatnonzero(~pairs[2])
                if len(undecided) * _MANY <= count:
                    break
                few = False
            for part, values in zip(here, pairs, strict=True):
                part[:] = values
            # Many that 200 bits do not decide are left to exact arithmetic.
            if 0 < len(undecided) * _MANY <= count:
                balls = [ball_at(start * width + place) for place in undecided.tolist()]
                for part, values in zip(here, round_balls(balls), strict=True):
                    part[undecided] = values
        return few

    def _error(self, which: slice, places: int) -> _Array:
        """Return, row by row, what digits and radii leave, in units of the scale of the row."""
        # Digits from 0 to 2^20 that do not count are worth one unit of the last that does.
        unit = 2.0 ** (-_BITS * places)
        ignored = unit if places < ALL_DIGITS else 0.0
        left_errors, right_errors = self._left_errors[which] + ignored, self._right_errors + ignored
        # What a term a b leaves is at most |a| times the error of b, and |b| < 1/2, with its error, times that of a.
        # Pairs of digits beyond the last weight, at most `places` a weight, are below places + 1 units a term.
        error: _Array = (self._size[which] * right_errors + left_errors * (0.5 + right_errors)).sum(
            axis=1, keepdims=True
        )
        error += self._terms * (places + 1) * unit
        # Rounded up by far more than the few roundings, also of what it is added to.
        error *= 1 + 2.0**-40
        return error


def _gather(parts: list[_Array]) -> tuple[_Array, _Array, _Array]:
    """Return head, rest and a bound of what is left of a sum, the largest parts first; the parts are overwritten.

    A pass over neighbours, from the smallest to the largest, replaces the parts by others of the same exact sum, in
    which the first takes all it can hold.
    """
    spare = np.empty((2, *parts[0].shape))
    scratch = [spare[0], spare[1]]
    whole = range(len(parts) - 2, -1, -1)
    # Few digits serve sums that hardly cancel: one pass gives the head, one the rest, and both are made to fit. What
    # that leaves undecided gets all digits, and three passes.
    for place in (*whole, *whole[:-1], 0, 1, 0) if len(parts) < ALL_DIGITS else (*whole, *whole, *whole):
        _add_exactly(parts, place, scratch)
    left = np.zeros_like(parts[0])
    for part in parts[2:]:
        left += np.abs(part, out=part)
    left *= 1 + 2.0**-48
    return parts[0], parts[1], left


def _add_exactly(parts: list[_Array], place: int, scratch: list[_Array]) -> None:
    """Replace a part and the next by their rounded sum and its rounding error (Knuth's two-sum)."""
    a, b = parts[place], parts[place + 1]
    total, part = scratch
    np.add(a, b, out=total)
    np.subtract(total, a, out=part)
    np.subtract(b, part, out=b)
    np.subtract(total, part, out=part)
    np.subtract(a, part, out=part)
    np.add(part, b, out=b)
    parts[place], scratch[0] = total, a
