r"""Exponential sums at epochs off a uniform grid: still products of ball matrices.

With :math:`t = h (k + m / M)` a term :math:`c\,t^p e^{z t}` is a polynomial times :math:`e^{z h k}` whose constants
depend on the shift m alone. The functions of the grid are tabulated once (`sinsref.exponential_sums`), the constants
are shifted once for each m, and the epochs of one shift are one matrix product.
"""

from __future__ import annotations

from math import comb

import numpy as np
from flint import acb, arb, arb_mat
from numpy.typing import NDArray

from sinsdata.certified import RowFormula
from sinsref.arithmetic import Number
from sinsref.exact import ExactNumber
from sinsref.exponential_sums import ExponentialSum, ExponentialSumArithmetic, Key, NotAnExponentialSumError, Table


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
            self._part = step / parts
            self._values = [ExponentialSum.of(value).terms for value in formula(ar, ar.time)]
            if any(not rate.real.is_zero() for rate in ar.rates):
                raise NotAnExponentialSumError("epochs off the grid need oscillations that neither grow nor decay")
            # A shift of time feeds the lower powers too. Of conjugate keys one stands for both.
            self._powers: dict[Key, int] = {}
            for power, key in (term for terms in self._values for term in terms):
                if next((n for n in key if n), 1) > 0:
                    self._powers[key] = max(power, self._powers.get(key, 0))
            functions = [
                part for key, most in self._powers.items() for p in range(most + 1) for part in _cosine_and_sine(p, key)
            ]
            self._table = Table(ar, functions, step)
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
            rows: list[list[arb]] = [[]] * len(shifts)
            order = np.argsort(shifts, kind="stable")
            for group in np.split(order, np.flatnonzero(np.diff(shifts[order])) + 1):
                places = group.tolist()
                product = arb_mat([functions[place] for place in places]) * self._matrix(int(shifts[places[0]]))
                entries = product.entries()
                for number, place in enumerate(places):
                    rows[place] = entries[number * width : (number + 1) * width]
            return rows

    def _matrix(self, shift: int) -> arb_mat:
        """Return the constants of the values, a column each, at one shift."""
        if shift not in self._constants:
            t, rates = self._part * shift, self._arithmetic.rates
            columns: list[list[arb]] = [[] for _ in self._values]
            for key, most in self._powers.items():
                turn = (sum((rates[j] * n for j, n in enumerate(key)), acb(0)) * t).exp()
                powers = [t**p for p in range(most + 1)]
                for column, terms in zip(columns, self._values, strict=True):
                    given = [terms.get((p, key), acb(0)) for p in range(most + 1)]
                    for q in range(most + 1):
                        # (s + t)^p holds s^q with the factor C(p, q) t^(p - q).
                        parts = (given[p] * (comb(p, q) * powers[p - q]) for p in range(q, most + 1))
                        constant = sum(parts, acb(0)) * turn
                        # c e^(ix) + conj(c) e^(-ix) = 2 Re(c) cos x - 2 Im(c) sin x
                        column += [2 * constant.real, -2 * constant.imag] if key else [constant.real]
            self._constants[shift] = arb_mat([list(row) for row in zip(*columns, strict=True)])
        return self._constants[shift]


def _cosine_and_sine(power: int, key: Key) -> list[Number]:
    """Return t^power times cosine and sine of the phase of a key; for no phase t^power alone."""
    forth = ExponentialSum({(power, key): acb(1)})
    if not key:
        return [forth]
    back = ExponentialSum({(power, tuple(-n for n in key)): acb(1)})
    return [(forth + back) / 2, (forth - back) * acb(0, -1) / 2]
