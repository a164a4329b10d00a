"""Order of convergence from a ladder of sampling intervals, and the floor on which the ladder stands."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["FEWEST_POINTS", "FLOOR_MARGIN", "Convergence", "convergence"]

Array = NDArray[np.float64]

FLOOR_MARGIN = 10.0
"""Points count towards the order only above this multiple of the floor."""

FEWEST_POINTS = 3
"""An order is fitted to no fewer points."""

_LEAST_SLOPE = 0.5  # between no convergence and first order
# A last point off by this part of itself shifts the slope fitted to four halvings by 0.3 log2(1 + 1/20) = 0.02.
_CONTAMINATION = 1 / 20


@dataclass(frozen=True)
class Convergence:
    """What a ladder shows.

    Attributes
    ----------
    order : float or None
        Least-squares slope of log error over log interval; None with fewer than three points.
    residual : float or None
        Root mean square deviation from that line, in powers of two.
    points : int
        Number of points used.
    note : str
        Why there is no order; empty where there is one.
    local_orders : tuple of float or None
        Slope between each interval and the next coarser one.
    floors : ndarray, shape (n,)
        Floor of each rung: that of the inputs or, where larger, that of rounding as the ladder shows it.
    at_floor : ndarray of bool, shape (n,)
        Whether at least half of the error is the floor's.
    """

    order: float | None
    residual: float | None
    points: int
    note: str
    local_orders: tuple[float | None, ...]
    floors: Array
    at_floor: NDArray[np.bool_]


def convergence(
    intervals: Sequence[float],
    errors: Sequence[float],
    input_floors: Sequence[float],
    rounding_bounds: Sequence[float],
    left_out: int = 0,
) -> Convergence:
    """Fit the order of a method to its errors on a ladder, and measure the floor of rounding.

    Going to finer intervals, each error is compared with the one extrapolated from the last good rung. Where they
    differ by more than a twentieth, and by no more than rounding can do, rounding has taken over; the difference
    is its size there. A difference larger than that is the method's own and stays in the fit.

    Parameters
    ----------
    intervals : sequence of float, length n
        Sampling intervals, s, descending.
    errors : sequence of float, length n
        Errors; NaN where there is none.
    input_floors : sequence of float, length n
        Floors of the inputs, in the unit of the errors.
    rounding_bounds : sequence of float, length n
        The most that rounding can amount to, in the unit of the errors.
    left_out : int, default 0
        How many of the coarsest intervals do not count towards the order: the power law is a limit for small ones.

    Returns
    -------
    Convergence
    """
    h, error, bounds = (np.asarray(x, np.float64) for x in (intervals, errors, rounding_bounds))
    valid = np.isfinite(error) & (error > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        log_h, log_error = np.log2(h), np.log2(np.where(valid, error, np.nan))
        slopes = np.diff(log_error) / np.diff(log_h)
    rounding = _rounding(log_h, np.where(valid, error, np.nan), bounds, _reference_order(slopes, error, bounds))
    contaminated = np.isfinite(rounding)
    floors = np.asarray(input_floors, np.float64).copy()
    if contaminated.any():
        # Before it takes over, rounding is at most what it is when it does.
        floors = np.maximum(floors, np.where(contaminated, rounding, rounding[contaminated][0]))
    used = valid & ~contaminated & (error > FLOOR_MARGIN * floors) & (np.arange(h.size) >= left_out)
    order, residual, points = None, None, int(np.count_nonzero(used))
    note = f"errors at {points} of {h.size} intervals are above the floor; an order takes {FEWEST_POINTS}"
    if points >= FEWEST_POINTS:
        note = ""
        slope, offset = np.polyfit(log_h[used], log_error[used], 1)
        deviation = log_error[used] - (slope * log_h[used] + offset)
        order, residual = float(slope), float(np.sqrt(np.mean(deviation**2)))
    local = (None, *(float(slope) if np.isfinite(slope) else None for slope in slopes))
    return Convergence(order, residual, points, note, local, floors, np.isfinite(error) & (error <= 2 * floors))


def _reference_order(slopes: Array, error: Array, bounds: Array) -> float | None:
    """Return the finest slope that rounding cannot have made, or else the median of those that show convergence."""
    converging = slopes > _LEAST_SLOPE
    certain = converging & (error[1:] > bounds[1:])
    if certain.any():
        return float(slopes[certain][-1])
    return float(np.median(slopes[converging])) if converging.any() else None


@np.errstate(over="ignore")  # a steep slope may extrapolate to infinity, which nothing is mistaken for
def _rounding(log_h: Array, error: Array, bounds: Array, order: float | None) -> Array:
    """Return the size of rounding on each rung where it has taken over, NaN on the others."""
    size = np.full(error.size, np.nan)
    good: int | None = None
    for i in np.flatnonzero(np.isfinite(error)):
        if order is None or good is None:
            expected = 0.0 if order is None else error[i]
        else:
            expected = error[good] * 2.0 ** (order * (log_h[i] - log_h[good]))
        excess = abs(error[i] - expected)
        taken_over = bool(np.isfinite(size).any())
        if taken_over or _CONTAMINATION * expected < excess <= bounds[i]:
            size[i] = excess
        else:
            good = int(i)
    return size
