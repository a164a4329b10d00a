"""Errors of gyroscopic systems: of the vertical, of position and attitude read out from it, of the speed.

Every error is computed minus true. Metres are R times an angle.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.errors import difference
from sinsbench.subjects.gyroscopic.contract import Inputs, Start
from sinsbench.subjects.gyroscopic.read_out import ANGLES, read_out
from sinsbench.subjects.gyroscopic.start_rules import rotated
from sinsdata.truth.gyroscopic import GyroMotion

__all__ = ["ARCSECOND", "KINDS", "VerticalError", "angle_errors", "angles_between", "inputs_of", "known_kind",
           "law_of_gyropendulum", "rows_at", "start_of", "vertical_error"]  # fmt: skip

Array = NDArray[np.float64]

ARCSECOND = float(np.pi / 648000)
"""Radians in one second of arc."""

KINDS = ("points", "increments")
"""What a gyroscopic system may be fed; the first is what one is fed that declares nothing."""


def known_kind(name: str) -> str:
    """Return a name of `KINDS` as it is.

    Raises
    ------
    ValueError
        For any other.
    """
    if name not in KINDS:
        raise ValueError(f"unknown input convention {name!r} of gyroscopic systems; admissible: {', '.join(KINDS)}")
    return name


def inputs_of(truth: GyroMotion, *, increments: bool = False) -> Inputs:
    """Return what a subject is given of a motion: points or increments, with the aids radius, its rate and speed.

    The arrays are copies: a subject may write into them.
    """
    aids = {name: getattr(truth, name).copy() for name in ("radius", "radius_rate", "speed")}
    if increments:
        return Inputs(
            truth.time.copy(), truth.angle_increment.copy(), truth.velocity_increment.copy(), aids, "increments"
        )
    return Inputs(truth.time.copy(), truth.rate.copy(), truth.specific_force.copy(), aids)


def start_of(truth: GyroMotion, radius: float, gravity: float) -> Start:
    """Return the start of a motion over a sphere of radius R, m, with attraction g on it, m/s^2."""
    start = Start(
        truth.attitude[0], truth.vertical[0], truth.velocity[0], radius, gravity, distance=float(truth.radius[0])
    )
    if not start.speed > 0:
        return start
    left = rotated(truth.attitude[0], truth.specific_force[0]) @ start.axes()[1]
    return replace(start, turn_rate=float(left / start.speed))  # a_2 = v w3


def angles_between(first: Array, second: Array) -> Array:
    """Return the angles between unit vectors (n, 3), rad, accurate for small angles and for those near pi."""
    apart, together = (np.linalg.norm(x, axis=1) for x in (first - second, first + second))
    return np.asarray(2 * np.arctan2(apart, together))


@dataclass(frozen=True)
class VerticalError:
    """Error of a modelled vertical.

    Attributes
    ----------
    along, left : ndarray, shape (n,)
        Its components along the absolute velocity and to the left of it.
    angle : ndarray, shape (n,)
        The angle between the two verticals, rad.
    """

    along: Array
    left: Array
    angle: Array


def rows_at(values: Array, count: int) -> Array:
    """Return the rows of the truth, n + 1, at which a subject has a state, count = m + 1 with m a divisor of n."""
    return values[:: (len(values) - 1) // (count - 1)]


def vertical_error(vertical: Array, truth: GyroMotion) -> VerticalError:
    """Return the error of a vertical.

    Parameters
    ----------
    vertical : ndarray, shape (m + 1, 3)
        Unit vectors in X, at every (n/m)-th time of the truth.
    truth : GyroMotion

    Returns
    -------
    VerticalError
        Components are NaN where the vehicle does not move.
    """
    count = len(vertical)
    true = rows_at(truth.vertical, count)
    error = difference(vertical, true, rows_at(truth.vertical_lo, count))
    velocity = rows_at(truth.velocity, count)
    horizontal = velocity - true * np.sum(velocity * true, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        y1 = horizontal / np.linalg.norm(horizontal, axis=1, keepdims=True)
    y2 = np.cross(true, y1)
    angle = 2 * np.arctan2(np.linalg.norm(error, axis=1), np.linalg.norm(vertical + true, axis=1))
    return VerticalError(np.sum(error * y1, axis=1), np.sum(error * y2, axis=1), angle)


def law_of_gyropendulum(truth: GyroMotion, count: int, schuler_speed: float) -> Array:
    """Return the axis of a gyropendulum by section 2.1 of Chelnokov 1991: alpha = -v/V from the vertical, about y1.

    Parameters
    ----------
    truth : GyroMotion
    count : int
        Number of rows, as for `rows_at`.
    schuler_speed : float
        V = sqrt(g R), m/s.

    Returns
    -------
    ndarray, shape (count, 3)
        Unit vectors in X: the vertical, inclined to the left of the velocity.
    """
    alpha = -rows_at(truth.speed, count)[:, None] / schuler_speed
    axes = [rotated(rows_at(truth.trihedron, count), axis) for axis in np.eye(3)[1:]]
    return np.asarray(np.cos(alpha) * axes[1] - np.sin(alpha) * axes[0])


def angle_errors(result: Mapping[str, Array], truth: GyroMotion) -> dict[str, Array]:
    """Return the errors of the angles (2.9)-(2.11), rad, each within half a turn.

    Parameters
    ----------
    result : mapping
        ``trihedron`` and ``attitude``, shape (m + 1, 4) each.
    truth : GyroMotion

    Returns
    -------
    dict of str to ndarray, shape (m + 1,)
        latitude, longitude_absolute, heading, pitch, roll.

    Raises
    ------
    BrokenConditionError
        At a pole or at a pitch of 90 deg.
    """
    count = len(result["trihedron"])
    angles = read_out(result["trihedron"], result["attitude"], rows_at(truth.time, count))
    return {
        name: np.asarray((angles[name] - rows_at(getattr(truth, name), count) + np.pi) % (2 * np.pi) - np.pi)
        for name in ANGLES
    }
