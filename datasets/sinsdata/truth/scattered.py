r"""Exponential sums at epochs off a uniform grid: still products of ball matrices.

With :math:`t = h (k + m / M)` a term :math:`c\,t^p e^{z t}` is a polynomial times :math:`e^{z h k}` whose constants
depend on the shift m alone. The functions of the grid are tabulated once (`sinsref.exponential_sums`), the constants
are shifted once for each m, and the epochs of one shift are one matrix product.
"""

from __future__ import annotations

from itertools import accumulate, chain
from operator import add

import numpy as np
from flint import acb, arb, arb_mat
from numpy.typing import NDArray

from sinsdata.truth.certified import RowFormula
from sinsref.arithmetic import Number
from sinsref.exact import ExactNumber
from sinsref.exponential_sums import (
    ExponentialSum,
    ExponentialSumArithmetic,
    Key,
    NotAnExponentialSumError,
    Table,
    ball_of_neglected,
    real_half,
    shifted,
)


class ScatteredTable:
    """Values of a formula at the epochs h (k + m / parts).

    Parameters
    ----------
    formula : callable
        ``formula(arithmetic, time)`` returns trigonometric sums, with powers of time as factors.
    interval : ExactNumber
        Distance h of the grid, s.
    parts : int
        Parts of the interval in which shifts are counted.
    bits : int
        Working precision.

    Raises
    ------
    NotAnExponentialSumError
        If the formula is anything else.
    """

    def __init__(self, formula: RowFormula, interval: ExactNumber, parts: int, bits: int) -> None:
        self._arithmetic = ExponentialSumArithmetic(bits)
        with self._arithmetic as ar:
            step = ar.number(interval)
            self._interval, self._part = step, step / parts
            halves = [real_half(ExponentialSum.of(value), ar.rates) for value in formula(ar, ar.time)]
            if any(not rate.real.is_zero() for rate in ar.rates):
                raise NotAnExponentialSumError("epochs off the grid need oscillations that neither grow nor decay")
            self._values, self._neglected = [kept for kept, _ in halves], [left for _, left in halves]
            # A shift of time feeds the lower powers too.
            powers = {
                key: max(len(value.get(key, ())) for value in self._values) for value in self._values for key in value
            }
            functions = [
                part for key, count in powers.items() for p in range(count) for part in _cosine_and_sine(p, key)
            ]
            self._table = Table(ar, functions, step)
            #: Of each key its rate, and the place of its first function.
            self._rates = {key: sum((ar.rates[j] * n for j, n in enumerate(key)), acb(0)) for key in powers}
            widths = [count * (2 if key else 1) for key, count in powers.items()]
            self._places = dict(zip(powers, accumulate(widths, initial=0), strict=False))
            self._functions = len(functions)
        self._constants: dict[int, arb_mat] = {}

    def balls(self, first: int, shifts: NDArray[np.int64]) -> list[list[arb]]:
        """Return the values at consecutive epochs, row by row.

        Parameters
        ----------
        first : int
            Number k of the first epoch.
        shifts : ndarray of int, shape (n,)
            Shifts m of the n epochs.
        """
        width = len(self._values)
        with self._arithmetic:
            functions = list(zip(*self._table.balls(first, len(shifts)), strict=True))
            start, end = self._interval * (first - 1), self._interval * (first + len(shifts))
            neglected = [ball_of_neglected(terms, self._arithmetic.rates, start, end) for terms in self._neglected]
            rows: list[list[arb]] = [[]] * len(shifts)
            order = np.argsort(shifts, kind="stable")
            for group in np.split(order, np.flatnonzero(np.diff(shifts[order])) + 1):
                places = group.tolist()
                values = list(chain.from_iterable(functions[place] for place in places))
                constants = self._matrix(int(shifts[places[0]]))
                entries = (arb_mat(len(places), self._functions, values) * constants).entries()
                for number, place in enumerate(places):
                    row = entries[number * width : (number + 1) * width]
                    rows[place] = list(map(add, row, neglected))
            return rows

    def _matrix(self, shift: int) -> arb_mat:
        """Return the constants of the values, a column each, at one shift."""
        if shift not in self._constants:
            t, zero = self._part * shift, arb(0)
            turns = {key: (rate * t).exp() for key, rate in self._rates.items()}
            width = len(self._values)
            entries = [zero] * (self._functions * width)
            for column, value in enumerate(self._values):
                for key, coefficients in value.items():
                    place = self._places[key] * width + column
                    for coefficient in shifted(coefficients, t):
                        constant = coefficient * turns[key]
                        entries[place] = constant.real
                        place += width
                        if key:
                            # Re(c e^(ix)) = Re(c) cos x - Im(c) sin x
                            entries[place] = -constant.imag
                            place += width
            self._constants[shift] = arb_mat(self._functions, width, entries)
        return self._constants[shift]


def _cosine_and_sine(power: int, key: Key) -> list[Number]:
    """Return t^power times cosine and sine of the phase of a key; for no phase t^power alone."""
    forth = ExponentialSum({(power, key): acb(1)})
    if not key:
        return [forth]
    back = ExponentialSum({(power, tuple(-n for n in key)): acb(1)})
    return [(forth + back) / 2, (forth - back) * acb(0, -1) / 2]
