"""The input floor: the error that the rounding of the inputs to binary64 alone causes, computed.

Exact increments are ``x + x_lo``, a subject gets ``x``: its inputs err by ``-x_lo``. To first order these
errors, turned into inertial axes by the true attitude, add up to an error of attitude and of apparent
velocity that no algorithm can avoid.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.errors import attitude_error_vectors
from sinsdata.sampling import SampledMotion

__all__ = ["InputErrors", "input_errors"]

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


def input_errors(motion: SampledMotion) -> InputErrors:
    """Transport the rounding errors of increments and initial values to the checkpoints.

    Parameters
    ----------
    motion : SampledMotion
        Its checkpoints are equidistant.

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
    angle, angle_lo, velocity, velocity_lo = (
        x[: segments * every].reshape(shape)
        for x in (motion.angle, motion.angle_lo, motion.velocity, motion.velocity_lo)
    )
    q = motion.attitude[:-1]
    alpha, gain, drift = (np.zeros((segments, 3)) for _ in range(3))
    response = np.zeros((segments, 3, 3))
    for j in range(every):
        rotation = _rotation_matrices(_turned(q, angle[:, j] / 2))
        specific, rounding, tilt = (
            np.einsum("nij,nj->ni", rotation, x[:, j]) for x in (velocity, -velocity_lo, -angle_lo)
        )
        drift += rounding + np.cross(alpha + tilt / 2, specific)
        gain += specific
        alpha += tilt
        response += rotation * motion.interval
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
