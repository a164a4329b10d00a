"""Position and attitude from the gyro frame and the vehicle attitude: (2.8)-(2.11) of Chelnokov 1991."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sinsbench.subjects.gyroscopic.contract import BrokenConditionError
from sinsbench.subjects.integrators import checked_array
from sinsbench.subjects.kernels import compiled, conjugate, quaternion_product

__all__ = ["ANGLES", "read_out"]

Array = NDArray[np.float64]

ANGLES = ("latitude", "longitude_absolute", "heading", "pitch", "roll")
"""What (2.9)-(2.11) give, rad."""

SINGULAR = 1e-7
"""Least cosine of latitude and pitch: below, rounding alone turns longitude, heading and roll by 1e-9 rad."""


@compiled
def _angles(e: Array, s: Array, result: Array) -> None:
    """Write the angles (2.9)-(2.11) of unit quaternions e and s, and the cosines of latitude and pitch, row by row."""
    for k in range(len(e)):
        e0, e1, e2, e3 = e[k, 0], e[k, 1], e[k, 2], e[k, 3]
        attitude = s[k, 0], s[k, 1], s[k, 2], s[k, 3]
        m0, m1, m2, m3 = quaternion_product(conjugate((e0, e1, e2, e3)), attitude)  # (2.10)
        # The sines of (2.9) and (2.11) lose half of the digits near 90 deg as arcsines: the cosines are at hand.
        across_position, along_position = e1 * e3 + e0 * e2, e0 * e0 + e3 * e3 - 0.5
        across_roll, along_roll = m1 * m3 - m0 * m2, m0 * m0 + m3 * m3 - 0.5
        cosine_latitude = 2.0 * math.sqrt(across_position * across_position + along_position * along_position)
        cosine_pitch = 2.0 * math.sqrt(across_roll * across_roll + along_roll * along_roll)
        result[k, 0] = math.atan2(2.0 * (e2 * e3 - e0 * e1), cosine_latitude)
        result[k, 1] = math.atan2(across_position, along_position)
        first = math.atan2(-(e1 * e2 + e0 * e3), e0 * e0 + e2 * e2 - 0.5)
        second = math.atan2(m1 * m2 - m0 * m3, m0 * m0 + m2 * m2 - 0.5)
        result[k, 2] = (first + second) % (2.0 * math.pi)
        result[k, 3] = math.atan2(2.0 * (m2 * m3 + m0 * m1), cosine_pitch)
        result[k, 4] = math.atan2(-across_roll, along_roll)
        result[k, 5] = cosine_latitude
        result[k, 6] = cosine_pitch


def read_out(trihedron: ArrayLike, attitude: ArrayLike, time: ArrayLike) -> dict[str, Array]:
    """Return position and attitude.

    Parameters
    ----------
    trihedron : array_like, shape (n, 4)
        e: X -> eta, of any azimuth of eta about its third axis. Its norm does not matter.
    attitude : array_like, shape (n, 4)
        s: X -> xi, the attitude of the vehicle. Its norm does not matter.
    time : array_like, shape (n,)
        Times, s, for the messages.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        ``latitude``, ``longitude_absolute``, ``heading`` (0 to 2 pi), ``pitch``, ``roll``, rad: (2.9)-(2.11), the
        last with the sum of squares that its print lost.

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite or a quaternion is zero.
    BrokenConditionError
        At a pole or at a pitch of 90 deg, where these angles do not exist.
    """
    e = checked_array("trihedron", trihedron, (None, 4))
    s = checked_array("attitude", attitude, (len(e), 4))
    times = checked_array("time", time, (len(e),))
    norms = [np.linalg.norm(q, axis=1, keepdims=True) for q in (e, s)]
    if any((norm == 0).any() for norm in norms):
        raise ValueError("a quaternion is zero, no rotation")
    result = np.full((len(e), len(ANGLES) + 2), np.nan)
    _angles(e / norms[0], s / norms[1], result)
    for column, condition in ((5, "latitude away from the poles"), (6, "pitch away from 90 deg")):
        broken = result[:, column] < SINGULAR
        if broken.any():
            raise BrokenConditionError(condition, float(times[int(np.argmax(broken))]))
    return {name: result[:, column].copy() for column, name in enumerate(ANGLES)}
