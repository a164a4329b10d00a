"""Where on a ladder of sampling intervals an error falls below a level, for good."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, log

import numpy as np

__all__ = ["Crossing", "crossing", "interpolated"]

_LEAST_ORDER = 0.5  # between no convergence and first order: along less, an interval found would mean nothing


@dataclass(frozen=True)
class Crossing:
    """The coarsest interval at which an error is at most a level, there and at every finer one.

    Attributes
    ----------
    interval : float or None
        s; None where the ladder does not tell.
    note : str
        How it was extrapolated, or why there is none; empty where it is interpolated.
    """

    interval: float | None
    note: str = ""


def interpolated(x: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return y at x on the straight line through two points in logarithms; all numbers are positive."""
    return exp(log(y0) + (log(y1) - log(y0)) * (log(x) - log(x0)) / (log(x1) - log(x0)))


def crossing(
    intervals: Sequence[float],
    errors: Sequence[float],
    level: float,
    order: float | None = None,
    floor: float = 0.0,
) -> Crossing:
    """Find where errors on a ladder fall below a level, by interpolation in logarithms.

    An error that dips below the level and rises above it again at a finer interval has not fallen: the interval found
    is bracketed by the last error above the level and the first of an unbroken run of errors below it.

    Parameters
    ----------
    intervals : sequence of float, length n
        Sampling intervals, s, descending.
    errors : sequence of float, length n
        Errors; NaN where there is none.
    level : float
        Positive, in the unit of the errors.
    order : float, optional
        Fitted order, along which the finest error is extrapolated where all are above the level; at least 1/2, or the
        errors do not converge.
    floor : float, default 0
        Below this no interval leads.

    Returns
    -------
    Crossing
    """
    known = [(h, e) for h, e in zip(intervals, errors, strict=True) if np.isfinite(e)]
    if not known:
        return Crossing(None, "no errors")
    finest, last = known[-1]
    if last > level:
        if order is None or order < _LEAST_ORDER:
            return Crossing(None, f"above {level:g} at every interval, and no order to extrapolate along")
        if floor >= level:
            return Crossing(None, f"the floor is above {level:g}")
        note = f"extrapolated from {finest:g} s along order {order:.2f}"
        return Crossing(finest * (level / last) ** (1 / order), note)
    below = next((i for i in range(len(known) - 1, -1, -1) if known[i][1] > level), None)
    if below is None:
        return Crossing(None, f"at most {level:g} at every interval up to {known[0][0]:g} s")
    (coarse, above), (fine, under) = known[below], known[below + 1]
    if under <= 0:
        return Crossing(fine, "")
    return Crossing(interpolated(level, above, coarse, under, fine))
