"""Taylor-series integration of ordinary differential equations, of any order, in any arithmetic.

This is the path to truth that knows no closed form: it is given the differential equation alone. Its steps
carry a truncation error that balls do not enclose; `integrate` therefore takes order and number of steps
from the caller, and a result counts only if two settings agree (`doubled`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from sinsref.arithmetic import Arithmetic, Number
from sinsref.series import Series, SeriesArithmetic

#: ``field(arithmetic, time, state)`` returns the derivative of the state.
Field: TypeAlias = Callable[[SeriesArithmetic, Series, list[Series]], Sequence[Number]]


def integrate(
    ar: Arithmetic,
    field: Field,
    initial: Sequence[Number],
    start: Number,
    end: Number,
    *,
    steps: int,
    order: int,
) -> list[Number]:
    """Integrate an initial value problem.

    Parameters
    ----------
    ar : Arithmetic
        Where the numbers live.
    field : callable
        Right-hand side ``field(arithmetic, time, state)``, written with operations of series.
    initial : sequence of n Number
        State at `start`.
    start, end : Number
        Independent variable.
    steps : int
        Number of equal steps.
    order : int
        Highest power of the step that is kept.

    Returns
    -------
    list of n Number
        State at `end`.
    """
    series = SeriesArithmetic(ar)
    step = (end - start) / steps
    state = list(initial)
    for n in range(steps):
        unknowns = [series.unknown(x) for x in state]
        rates = field(series, series.variable(start + step * n), unknowns)
        for unknown, rate in zip(unknowns, rates, strict=True):
            series.define(unknown, rate if isinstance(rate, Series) else series.constant(rate))
        state = [unknown.evaluate(step, order) for unknown in unknowns]
    return state


def doubled(
    ar: Arithmetic,
    field: Field,
    initial: Sequence[Number],
    start: Number,
    end: Number,
    *,
    steps: int,
    order: int,
) -> tuple[list[Number], float]:
    """Integrate twice, the second time with half the step, and return the second result and the largest difference.

    Parameters
    ----------
    ar, field, initial, start, end, steps, order
        As for `integrate`.

    Returns
    -------
    state : list of Number
    difference : float
        Largest absolute difference of the two results. With order k the second is better by about 2**k.
    """
    coarse = integrate(ar, field, initial, start, end, steps=steps, order=order)
    fine = integrate(ar, field, initial, start, end, steps=2 * steps, order=order)
    return fine, max(ar.magnitude(x - y) for x, y in zip(coarse, fine, strict=True))
