"""Pytransform3d: rotations composed one after the other, and its integration of rates."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pytransform3d import rotations

Array = NDArray[np.float64]


def exponential(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the rotations by the angle increments."""
    made = [attitude0]
    for increment in angle:
        step = rotations.quaternion_from_compact_axis_angle(increment)
        made.append(rotations.concatenate_quaternions(made[-1], step))
    return np.array(made)


def integrated(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate rates at the ends of the samples.

    The package wants them in the axes of the reference: the inverse attitude is integrated, which turns at minus the
    body rate.
    """
    inverse = rotations.quaternion_integrate(-rate, rotations.q_conj(attitude0), interval)
    return inverse * [1, -1, -1, -1]
