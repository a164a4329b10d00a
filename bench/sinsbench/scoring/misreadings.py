"""Attitudes that are right in another convention: a wrong one is told by the error that the right one would have."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.errors import attitude_error_vectors

__all__ = ["misreading"]

Array = NDArray[np.float64]

_SUSPICIOUS = 1e-2  # rad: more than sampling leaves of the errors of a method that is right
_MUCH_NEARER = 1e-2  # part of the error that remains in the right convention
_SCALAR_LAST = [3, 0, 1, 2]
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def misreading(computed: Array, truth: Array, truth_lo: Array) -> str:
    """Return the convention in which computed attitudes are a hundred times nearer to the truth, as a hint in one line.

    Parameters
    ----------
    computed : ndarray, shape (n, 4)
        Quaternions, taken as scalar first and body to inertial.
    truth, truth_lo : ndarray, shape (n, 4)
        True unit quaternions, as ``truth + truth_lo``.

    Returns
    -------
    str
        Empty where the errors are below 0.01 rad, or no other convention explains them.
    """

    def largest(attitude: Array) -> float:
        with np.errstate(over="ignore", invalid="ignore"):
            return float(np.linalg.norm(attitude_error_vectors(attitude, truth, truth_lo), axis=1).max())

    found = largest(computed)
    if not found > _SUSPICIOUS:
        return ""
    last = computed[:, _SCALAR_LAST]
    readings: Mapping[str, Array] = {
        "scalar last": last,
        "inertial to body": computed * _CONJUGATE,
        "scalar last and inertial to body": last * _CONJUGATE,
    }
    for convention, attitude in readings.items():
        error = largest(attitude)
        if error < _MUCH_NEARER * found:
            needed = "scalar first, body to inertial"
            return f"the quaternions look {convention} (the error would be {error:.1e} rad); needed are {needed}"
    return ""
