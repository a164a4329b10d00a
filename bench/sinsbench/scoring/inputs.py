"""The input floor: the error that the rounding of the inputs to binary64 alone causes, computed.

Exact inputs are ``x + x_lo``, a subject gets ``x``: its inputs err by ``-x_lo``. What that means for the increments of
each sample depends on the convention; to first order these errors of increments, turned into inertial axes by the true
attitude, add up to an error of attitude and of apparent velocity that no algorithm can avoid.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.errors import attitude_error_vectors
from sinsdata.truth.sampling import SampledMotion

__all__ = ["InputErrors", "increment_errors", "input_errors"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InputErrors:
    """What the rounded inputs cause at the checkpoints, and how constant biases would accumulate there.

    Attributes
    ----------
    attitude : ndarray, shape (m, 3)
        Attitude error alpha in inertial axes, rad.
    velocity : ndarray, shape (m, 3)
        Error of the apparent velocity in inertial axes, m/s.
    velocity_body : ndarray, shape (m, 3)
        Error of its components in body axes, turned into inertial axes, m/s.
    bias_response : ndarray, shape (m, 3, 3)
        Integral of the rotation matrix from body to inertial axes, s: a constant gyro bias b in body axes causes
        alpha = bias_response @ b.
    """

    attitude: Array
    velocity: Array
    velocity_body: Array
    bias_response: Array


def _rotation_matrices(q: Array) -> Array:
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _turned(q: Array, angle: Array) -> Array:
    """Return attitudes after a rotation by an angle increment in body axes."""
    size = np.linalg.norm(angle, axis=1, keepdims=True)
    vector = angle * (0.5 * np.sinc(size / (2 * np.pi)))
    scalar, axis = q[:, :1], q[:, 1:]
    cosine = np.cos(size / 2)
    return np.hstack(
        [
            scalar * cosine - np.sum(axis * vector, axis=1, keepdims=True),
            scalar * vector + cosine * axis + np.cross(axis, vector),
        ]
    )


def _rounded(motion: SampledMotion, low: Array, exact: Array) -> Array:
    """Return the error of increments that are given as such."""
    return -low


def _means(motion: SampledMotion, low: Array, exact: Array) -> Array:
    """Return that of means over the samples: the interval they are multiplied by is rounded too."""
    return -low * motion.interval - exact * (motion.interval_lo / motion.interval)


def _instants(motion: SampledMotion, low: Array, exact: Array) -> Array:
    """Return that of values at instants, by the trapezoidal rule: other rules weight the same errors otherwise."""
    return _means(motion, (low[:-1] + low[1:]) / 2, exact)


def _differences(motion: SampledMotion, low: Array, exact: Array) -> Array:
    """Return that of integrals since the start, of which an algorithm takes differences."""
    return -np.diff(low, axis=0)


def _arrived(motion: SampledMotion, low: Array, exact: Array) -> Array:
    """Return that of the increments that arrive: no bound is known of what the others cost, and none is claimed."""
    errors = np.zeros_like(exact)
    errors[motion.ends[1:] - 1] = -low
    return errors


#: Convention -> error of its increments, ``(motion, rests of the inputs, increments)``.
_INCREMENT_ERRORS: Mapping[str, Callable[[SampledMotion, Array, Array], Array]] = {
    "rates": _instants,
    "mean_rates": _means,
    "accumulated": _differences,
    "dropped": _arrived,
}
#: Where in the sample the velocity increment is resolved, as a part of the sample; in the other conventions in the axes
#: of every instant, which to first order are those of the middle.
_RESOLVED_AT = {"resolved_start": 0.0, "resolved_end": 1.0}


def increment_errors(motion: SampledMotion) -> tuple[Array, Array]:
    """Return what the inputs of a motion make of its increments: given less exact.

    Parameters
    ----------
    motion : SampledMotion

    Returns
    -------
    angle, velocity : ndarray, shape (n, 3)
        Errors of angle increments, rad, and velocity increments, m/s.
    """
    name = motion.convention.name
    if name == "quantised":  # exact numbers, but of other integrals
        return motion.first - motion.angle - motion.angle_lo, motion.second - motion.velocity - motion.velocity_lo
    rule = _INCREMENT_ERRORS.get(name, _rounded)
    return (
        rule(motion, motion.first_lo, motion.angle),
        rule(motion, motion.second_lo, motion.velocity),
    )


def input_errors(motion: SampledMotion) -> InputErrors:
    """Transport the rounding errors of inputs and initial values to the checkpoints.

    Parameters
    ----------
    motion : SampledMotion

    Returns
    -------
    InputErrors
        To first order in the rounding errors. The attitude inside a sample is taken at its middle, from the
        truth at the checkpoint before and the angle increments since: it matters to the per cent, not to the
        ulp.
    """
    every = int(motion.checkpoints[1] - motion.checkpoints[0])
    segments = len(motion.checkpoints) - 1
    # All segments between checkpoints go side by side; the loop is over the samples inside one.
    shape = (segments, every, 3)
    angle, velocity, angle_error, velocity_error = (
        x.reshape(shape) for x in (motion.angle, motion.velocity, *increment_errors(motion))
    )
    # Dropped samples leave gaps between the ends, but not in the motion.
    ends = (
        motion.end_times if len(motion.end_times) > motion.samples else np.arange(motion.samples + 1) * motion.interval
    )
    length = np.diff(ends).reshape(segments, every)
    at = _RESOLVED_AT.get(motion.convention.name, 0.5)
    q = motion.attitude[:-1]
    alpha, gain, drift = (np.zeros((segments, 3)) for _ in range(3))
    response = np.zeros((segments, 3, 3))
    for j in range(every):
        middle = _rotation_matrices(_turned(q, angle[:, j] / 2))
        resolving = middle if at == 0.5 else _rotation_matrices(_turned(q, angle[:, j] * at))
        specific, tilt = (np.einsum("nij,nj->ni", middle, x[:, j]) for x in (velocity, angle_error))
        rounding = np.einsum("nij,nj->ni", resolving, velocity_error[:, j])
        drift += rounding + np.cross(alpha + tilt * at, specific)
        gain += specific
        alpha += tilt
        response += middle * length[:, j, None, None]
        q = _turned(q, angle[:, j])
    first = attitude_error_vectors(motion.attitude[:1], motion.attitude[:1], motion.attitude_lo[:1])
    attitude = np.cumsum(np.vstack([first, alpha]), axis=0)
    start = -motion.velocity_inertial_lo[:1]
    inertial = np.cumsum(np.vstack([start, drift + np.cross(attitude[:-1], gain)]), axis=0)
    return InputErrors(
        attitude=attitude,
        velocity=inertial,
        velocity_body=inertial - np.cross(attitude, motion.velocity_inertial),
        bias_response=np.cumsum(np.concatenate([np.zeros((1, 3, 3)), response]), axis=0),
    )
