r"""Secular and periodic parts of an error that is known at instants of a run.

An error on a periodic motion is, to leading order, a polynomial of time plus oscillations at the frequencies of the
motion. Over a run that is no whole number of periods, the error at its end, and a straight line fitted to it, hold a
piece of a period; a fit of both parts at once does not:

.. math:: e(t) = \sum_k a_k t^k + \sum_j \sum_k t^k (b_{jk}\cos\omega_j t + c_{jk}\sin\omega_j t).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sinsref.arithmetic import MpArithmetic
from sinsref.precession import DualPrecession

__all__ = ["SecularParts", "frequencies_of", "secular_parts"]

Array = NDArray[np.float64]

#: Oscillations that grow are told from steady ones and from a trend once this many periods have passed.
_PERIODS_OF_GROWTH = 4.0
#: More instants than unknowns by this factor, or the fit would follow every point.
_INSTANTS_AN_UNKNOWN = 2


@dataclass(frozen=True)
class SecularParts:
    """The two parts of an error.

    Attributes
    ----------
    rate : ndarray, shape (3,)
        What the secular part gains over the run, divided by its duration; unit of the error over s.
    periodic : ndarray, shape (n, 3)
        What is left when the secular part, its constant included, is taken off.
    """

    rate: Array
    periodic: Array


@cache
def frequencies_of(motion: DualPrecession) -> tuple[float, ...]:
    """Return the frequencies at which errors oscillate on a regular precession, rad/s.

    Errors that are steady in body axes, such as constant biases, appear in inertial axes at nu, eps nu and
    (1 +- eps) nu; errors that are steady in the axes that precess but do not spin, such as those of a method,
    at eps nu alone.
    """
    ar = MpArithmetic(30)
    spin, ratio, _ = (float(x) for x in motion.principal(ar))
    return tuple(sorted({abs(k * spin) for k in (1.0, ratio, 1 + ratio, 1 - ratio)} - {0.0}))


def _resolved(frequencies: Sequence[float], duration: float) -> list[float]:
    """Return the frequencies that a run tells apart: a whole period away from zero and from each other."""
    least = 2 * np.pi / duration
    kept: list[float] = []
    for frequency in sorted(frequencies):
        if frequency - (kept[-1] if kept else 0.0) >= least * (1 - 1e-9):
            kept.append(frequency)
    return kept


def secular_parts(
    time: ArrayLike, error: ArrayLike, frequencies: Sequence[float], growth: int = 0
) -> SecularParts | None:
    """Fit secular and periodic parts to an error, both at once.

    Parameters
    ----------
    time : array_like, shape (n,)
        Ascending instants, s.
    error : array_like, shape (n, 3)
    frequencies : sequence of float
        Positive frequencies, rad/s. Those that the run does not tell apart, or whose period it does not complete, are
        left out: what they do counts as secular.
    growth : int, default 0
        Highest power of time by which oscillations grow, where the run is long enough to see it; the secular part is
        of degree ``max(1, growth)`` then, else 1. The transport of an attitude error by the specific force makes
        errors of velocity grow as t^2 (Lebedev, Panov 1989, section 5).

    Returns
    -------
    SecularParts or None
        None with fewer instants than twice the unknowns of a straight line.
    """
    t, e = np.asarray(time, np.float64), np.asarray(error, np.float64)
    if t.size < 2 * _INSTANTS_AN_UNKNOWN:
        return None
    trend, solver = _fit(t.tobytes(), tuple(frequencies), growth)
    secular = trend @ (solver @ e)
    return SecularParts((secular[-1] - secular[0]) / float(t[-1] - t[0]), e - secular)


@lru_cache(maxsize=64)  # the errors of all methods, and the floors, are fitted at the same instants
def _fit(instants: bytes, frequencies: tuple[float, ...], growth: int) -> tuple[Array, Array]:
    """Return the columns of the secular part, and the matrix that takes errors to their coefficients."""
    t = np.frombuffer(instants)
    duration = float(t[-1] - t[0])
    kept = _resolved(frequencies, duration)
    periods = min((kept[0], *(b - a for a, b in pairwise(kept)))) * duration / (2 * np.pi) if kept else 0.0
    power = growth if periods >= _PERIODS_OF_GROWTH else 0
    while kept and _INSTANTS_AN_UNKNOWN * (max(1, power) + 1 + 2 * len(kept) * (power + 1)) > t.size:
        power, kept = (power - 1, kept) if power else (0, kept[:-1])
    # Time from -1 to 1, and powers of it: no column is nearly a multiple of another.
    tau = 2 * (t - t[0]) / duration - 1
    trend = tau[:, None] ** np.arange(max(1, power) + 1)
    powers = tau[:, None] ** np.arange(power + 1)
    oscillations = [powers * wave(w * t)[:, None] for w in kept for wave in (np.cos, np.sin)]
    return trend, np.linalg.pinv(np.hstack([trend, *oscillations]))[: trend.shape[1]]
