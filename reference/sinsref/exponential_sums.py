r"""Whole blocks of epochs at once: time as a symbol first, then products of ball matrices.

The solutions of this package are sums of terms :math:`c\,t^p e^{z t}` with complex constants.
`ExponentialSumArithmetic` evaluates a formula once, with time as a symbol, and obtains those constants as
balls. `Table` then computes the sum at equidistant epochs :math:`t_k = k h`: with :math:`k = k_c + k_f`
angle addition splits every term into a factor of the coarse epoch and one of the fine epoch, so that a
block of epochs is the product of two small matrices. Transcendental functions are needed for the coarse and
the fine epochs only, the products run compiled, and every digit stays enclosed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import zip_longest
from typing import Any, TypeAlias

import numpy as np
from flint import acb, arb, arb_mat
from numpy.typing import NDArray

from sinsref import digit_products
from sinsref.arithmetic import BallArithmetic, Number
from sinsref.rounding import TINY, round_balls

#: Integer multiples of the rates met so far, trailing zeros dropped.
Key: TypeAlias = tuple[int, ...]

#: Most fine epochs of a block; the coarse ones are as many as the block needs.
FINE = 512
#: Consecutive exponentials of one rate that are computed as such.
_NEAR = 16


class NotAnExponentialSumError(ValueError):
    """A formula needs more than sums, products and exponentials of arguments linear in time."""


class ExponentialSum:
    """A sum of terms ``coefficient * t**power * exp(rate * t)``; the rate is a combination of registered rates.

    Parameters
    ----------
    terms : dict
        ``{(power, key): acb}``.
    """

    __slots__ = ("terms",)

    def __init__(self, terms: dict[tuple[int, Key], acb]) -> None:
        self.terms = {index: c for index, c in terms.items() if not c.is_zero()}

    @staticmethod
    def of(value: Number) -> ExponentialSum:
        """Return a constant as a sum."""
        if isinstance(value, ExponentialSum):
            return value
        return ExponentialSum({(0, ()): acb(value)})

    def __neg__(self) -> ExponentialSum:
        return ExponentialSum({index: -c for index, c in self.terms.items()})

    def __add__(self, other: Number) -> ExponentialSum:
        terms = dict(self.terms)
        for index, c in ExponentialSum.of(other).terms.items():
            terms[index] = terms[index] + c if index in terms else c
        return ExponentialSum(terms)

    __radd__ = __add__

    def __sub__(self, other: Number) -> ExponentialSum:
        return self + (-ExponentialSum.of(other))

    def __rsub__(self, other: Number) -> ExponentialSum:
        return (-self).__add__(other)

    def __mul__(self, other: Number) -> ExponentialSum:
        if not isinstance(other, ExponentialSum):
            return ExponentialSum({index: c * other for index, c in self.terms.items()})
        terms: dict[tuple[int, Key], acb] = {}
        for (p, key), c in self.terms.items():
            for (q, other_key), d in other.terms.items():
                index = (p + q, _sum_of_keys(key, other_key))
                terms[index] = terms[index] + c * d if index in terms else c * d
        return ExponentialSum(terms)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> ExponentialSum:
        divisor = _constant(other) if isinstance(other, ExponentialSum) else other
        return ExponentialSum({index: c / divisor for index, c in self.terms.items()})

    def __rtruediv__(self, other: Number) -> ExponentialSum:
        return ExponentialSum.of(other) / self


def _sum_of_keys(a: Key, b: Key) -> Key:
    total = [x + y for x, y in zip_longest(a, b, fillvalue=0)]
    while total and not total[-1]:
        total.pop()
    return tuple(total)


def _constant(x: Number) -> Number:
    if not isinstance(x, ExponentialSum):
        return x
    if set(x.terms) - {(0, ())}:
        raise NotAnExponentialSumError("the operation needs a number that does not depend on time")
    return x.terms.get((0, ()), acb(0)).real


def _same_up_to_sign(a: acb, b: acb) -> int:
    """Return the sign that makes two rates the same ball part by part, else 0.

    Midpoints and radii that agree show that two balls were computed alike, hence that they stand for the same number:
    the parameters of a motion, apart by 1e-30 at least, cannot make two different rates of one formula so close.
    """
    pairs = ((a.real, b.real), (a.imag, b.imag))
    for sign in (1, -1):
        if all(x.mid() == y.mid() * sign and x.rad() == y.rad() for x, y in pairs):
            return sign
    return 0


class ExponentialSumArithmetic(BallArithmetic):
    """Arithmetic in which time is a symbol; numbers are balls or exponential sums.

    Elementary functions take arguments that are linear in time, divisions constants: what the closed forms
    of this package need.
    """

    def __init__(self, bits: int = 192) -> None:
        super().__init__(bits)
        #: Rates of the exponentials met so far, each purely real or purely imaginary.
        self.rates: list[acb] = []

    @property
    def time(self) -> ExponentialSum:
        """The symbol t."""
        return ExponentialSum({(1, ()): acb(1)})

    def _exponential(self, x: Number, unit: acb) -> ExponentialSum:
        """Return exp(unit * x) for x linear in time."""
        terms = ExponentialSum.of(x).terms
        if set(terms) - {(0, ()), (1, ())}:
            raise NotAnExponentialSumError("the argument of an elementary function must be linear in time")
        amplitude = (unit * terms.get((0, ()), acb(0)).real).exp()
        rate = unit * terms.get((1, ()), acb(0)).real
        if rate.is_zero():
            return ExponentialSum({(0, ()): amplitude})
        for position, known in enumerate(self.rates):
            if sign := _same_up_to_sign(known, rate):
                return ExponentialSum({(0, (0,) * position + (sign,)): amplitude})
        self.rates.append(rate)
        return ExponentialSum({(0, (0,) * (len(self.rates) - 1) + (1,)): amplitude})

    def sqrt(self, x: Number) -> Number:
        return _constant(x).sqrt()

    def exp(self, x: Number) -> Number:
        return self._exponential(x, acb(1))

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        forth, back = self._exponential(x, acb(0, 1)), self._exponential(x, acb(0, -1))
        return (forth - back) * acb(0, -1) / 2, (forth + back) / 2

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        forth, back = self._exponential(x, acb(1)), self._exponential(x, acb(-1))
        return (forth - back) / 2, (forth + back) / 2

    def sign(self, x: Number) -> int:
        return super().sign(_constant(x))

    def magnitude(self, x: Number) -> float:
        return super().magnitude(_constant(x))

    def widen(self, x: Number, bound: Number) -> Number:
        return x + arb(0, _constant(bound).abs_upper())


#: Key, power, bound of the coefficient.
Neglected: TypeAlias = list[tuple[Key, int, arb]]


def real_half(column: ExponentialSum, rates: Sequence[acb]) -> tuple[dict[Key, list[acb]], Neglected]:
    """Return the coefficients of a real sum by key and power, one of each conjugate pair of keys, doubled.

    The sum is the real part of what they make. Terms that cancel leave a coefficient that contains zero: they are
    returned apart, and count by their size alone.
    """
    half: dict[Key, list[acb]] = {}
    for (power, key), coefficient in column.terms.items():
        imaginary = [n if rates[j].real.is_zero() else 0 for j, n in enumerate(key)]
        leading = next((n for n in imaginary if n), 0)
        if leading < 0:
            continue
        coefficients = half.setdefault(key, [])
        coefficients.extend([acb(0)] * (power + 1 - len(coefficients)))
        coefficients[power] = coefficient * (2 if leading else 1)
    neglected = []
    for key, coefficients in half.items():
        while coefficients and coefficients[-1].contains(0):
            bound = coefficients.pop().abs_upper()
            if bound:
                neglected.append((key, len(coefficients), bound))
    return {key: coefficients for key, coefficients in half.items() if coefficients}, neglected


def ball_of_neglected(neglected: Neglected, rates: Sequence[acb], start: arb, end: arb) -> arb:
    """Return a ball around zero that holds neglected terms at all times between two."""
    farthest, total = abs(start).max(abs(end)), arb(0)
    for key, power, bound in neglected:
        growth = sum((rates[j].real * n for j, n in enumerate(key)), arb(0))
        total += bound * farthest**power * (growth * start).exp().max((growth * end).exp())
    return arb(0, total.abs_upper())


class Table:
    """Values of real exponential sums at equidistant epochs.

    Parameters
    ----------
    arithmetic : ExponentialSumArithmetic
        Entered; holds the rates.
    columns : sequence of Number
        The sums, real for real time.
    interval : arb
        Distance h of the epochs, s.
    fine : int, optional
        Fine epochs of a block. The square root of the number of epochs that will be asked for, or somewhat more, costs
        least.
    """

    def __init__(
        self, arithmetic: ExponentialSumArithmetic, columns: Sequence[Number], interval: arb, fine: int | None = None
    ) -> None:
        self._arithmetic = arithmetic
        self._interval = interval
        self._fine_epochs = min(fine or FINE, FINE)
        # A real sum holds each oscillating term with its conjugate: one of the two is kept, doubled, and
        # the real part taken.
        halves = [real_half(ExponentialSum.of(column), arithmetic.rates) for column in columns]
        self._columns, self._neglected = [kept for kept, _ in halves], [left for _, left in halves]
        self._keys = sorted({key for column in self._columns for key in column})
        self._rates = {
            key: sum((arithmetic.rates[j] * n for j, n in enumerate(key) if n), acb(0)) for key in self._keys
        }
        powers = {key: max(len(column.get(key, ())) for column in self._columns) for key in self._keys}
        self._fine: dict[Key, list[list[arb]]] = {}
        for key in self._keys:
            exponentials = self._exponentials(key, interval, self._fine_epochs)
            rows: list[list[arb]] = []
            for power in range(powers[key]):
                values = [z * (interval * k) ** power if power else z for k, z in enumerate(exponentials)]
                rows.append([z.real for z in values])
                if key:
                    rows.append([-z.imag for z in values])
            self._fine[key] = rows
        self._steps: dict[Key, list[acb]] = {key: [] for key in self._keys}
        self._cut: dict[tuple[Key, int], digit_products.Digits] = {}
        self._stacked: dict[int, digit_products.Digits] = {}
        # Columns that few digits do not decide, met so far.
        self._hard: set[int] = set()

    def _ball_of_neglected(self, column: int, first: int, count: int) -> arb:
        """Return a ball around zero that holds the neglected terms of a column at all these epochs."""
        start, end = self._interval * first, self._interval * (first + count)
        return ball_of_neglected(self._neglected[column], self._arithmetic.rates, start, end)

    def negligible_columns(self, first: int, count: int) -> NDArray[np.bool_]:
        """Return which columns are proved smaller than `sinsref.rounding.TINY` at the given epochs, as zeros are."""
        return np.array(
            [
                not kept and bool(self._ball_of_neglected(column, first, count).rad() < TINY)
                for column, kept in enumerate(self._columns)
            ]
        )

    def _exponentials(self, key: Key, interval: arb, count: int) -> list[acb]:
        """Return the exponential of a key at the first `count` multiples of an interval."""
        # Angle addition once more: a product costs a twentieth of an exponential.
        step = self._rates[key] * interval
        near = [(step * k).exp() for k in range(min(count, _NEAR))]
        far = [(step * k).exp() for k in range(0, count, _NEAR)]
        return [z * w for z in far for w in near][:count]

    def _products(self, first: int, count: int) -> Iterator[tuple[list[list[arb]], list[tuple[Key, int]]]]:
        """Yield, column by column, the factors of the coarse epochs, and which rows of the fine ones they multiply."""
        starts = range(first, first + count, self._fine_epochs)
        exponentials: dict[Key, list[acb]] = {}
        for key in self._keys:
            if len(self._steps[key]) < len(starts):
                self._steps[key] = self._exponentials(key, self._interval * self._fine_epochs, len(starts))
            origin = (self._rates[key] * (self._interval * first)).exp()
            exponentials[key] = [origin * z for z in self._steps[key][: len(starts)]]
        times = [self._interval * k for k in starts]
        for column in self._columns:
            coarse: list[list[arb]] = [[] for _ in starts]
            rows: list[tuple[Key, int]] = []
            for key, coefficients in column.items():
                rows.extend((key, n) for n in range(len(coefficients) * (2 if key else 1)))
                for place, (t, z) in enumerate(zip(times, exponentials[key], strict=True)):
                    for factor in shifted(coefficients, t):
                        value: Any = factor * z
                        coarse[place].append(value.real)
                        if key:
                            coarse[place].append(value.imag)
            yield coarse, rows

    def balls(self, first: int, count: int) -> list[list[arb]]:
        """Return the columns at the epochs ``first .. first + count - 1``.

        Parameters
        ----------
        first, count : int
            Index of the first epoch, number of epochs.

        Returns
        -------
        list of list of arb
            One list a column.
        """
        return [
            self._balls_of(column, coarse, rows, first, count)
            for column, (coarse, rows) in enumerate(self._products(first, count))
        ]

    def _balls_of(
        self, column: int, coarse: list[list[arb]], rows: Sequence[tuple[Key, int]], first: int, count: int
    ) -> list[arb]:
        fine = [self._fine[key][n] for key, n in rows]
        values = (arb_mat(coarse) * arb_mat(fine)).entries()[:count] if fine else [arb(0)] * count
        neglected = self._ball_of_neglected(column, first, count)
        return [value + neglected for value in values]

    def pairs(self, first: int, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return the columns rounded to pairs of binary64, by products of digits where these are exact.

        Parameters
        ----------
        first, count : int
            Index of the first epoch, number of epochs.

        Returns
        -------
        high, low : ndarray, shape (count, columns)
            Nearest binary64, and nearest binary64 to the rest.
        decided : ndarray of bool, shape (count, columns)
            Whether both are proved.
        """
        # Column by column in memory: that is how tables are read and written.
        high, low = (np.empty((len(self._columns), count)) for _ in range(2))
        decided = np.empty((len(self._columns), count), np.bool_)
        for column, (coarse, rows) in enumerate(self._products(first, count)):
            out = high[column], low[column], decided[column]
            neglected = self._ball_of_neglected(column, first, count)
            if not rows or rows == [((), 0)]:
                # Zero, or a constant.
                _assign(out, round_balls([sum(coarse[0], arb(0)) + neglected]))
                continue
            try:
                product = digit_products.Product(coarse, self._digits(column, rows))
            except digit_products.OutOfRangeError:
                _assign(out, round_balls(self._balls_of(column, coarse, rows, first, count)))
                continue
            left = float(neglected.rad()) + 1e-300 if self._neglected[column] else 0.0
            ball_at = partial(self._ball_at, coarse, rows, neglected)
            if not product.round(out, left, ball_at, few=column not in self._hard):
                # Exact values, as a rule: the next block of this column will have them too.
                self._hard.add(column)
        return high.T, low.T, decided.T

    def _ball_at(self, coarse: list[list[arb]], rows: Sequence[tuple[Key, int]], neglected: arb, place: int) -> arb:
        """Return the value of one epoch of a block."""
        row, column = divmod(place, self._fine_epochs)
        return sum((x * self._fine[key][n][column] for x, (key, n) in zip(coarse[row], rows, strict=True)), neglected)

    def _digits(self, column: int, rows: Sequence[tuple[Key, int]]) -> digit_products.Digits:
        """Return the rows of fine factors of a column as digits, each row cut once."""
        if column not in self._stacked:
            for key, n in rows:
                if (key, n) not in self._cut:
                    self._cut[key, n] = digit_products.cut_row(self._fine[key][n])
            self._stacked[column] = digit_products.stacked([self._cut[row] for row in rows])
        return self._stacked[column]


def _assign(out: digit_products.Pairs, values: digit_products.Pairs) -> None:
    for part, given in zip(out, values, strict=True):
        part[:] = given


def shifted(coefficients: Sequence[acb], t: arb) -> list[acb]:
    """Return the coefficients of a polynomial in time as one in s = time - t, by synthetic division."""
    moved = list(coefficients)
    for first in range(len(moved) - 1):
        for p in range(len(moved) - 2, first - 1, -1):
            moved[p] = moved[p] + moved[p + 1] * t
    return moved
