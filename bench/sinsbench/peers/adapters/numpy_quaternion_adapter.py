"""Numpy-quaternion: exponentials, and its integration of tabulated rates."""

from typing import Any

import numpy as np
import quaternion
from numpy.typing import NDArray

Array = NDArray[np.float64]


def exponential(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Accumulate the product of the exponentials of half the angle increments."""
    steps = np.exp(quaternion.from_vector_part(angle / 2))
    factors = np.concatenate([[quaternion.quaternion(*attitude0)], steps])
    return quaternion.as_float_array(np.multiply.accumulate(factors))


def integrated(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate tabulated rates.

    The package wants the rate in the axes of the reference. The inverse attitude turns at minus the body rate, which
    stands in the axes that are its reference: that one is integrated.
    """
    times = interval * np.arange(len(rate))
    start = quaternion.quaternion(*attitude0).conjugate()
    _, inverse = quaternion.integrate_angular_velocity((times, -rate), times[0], times[-1], R0=start)
    return quaternion.as_float_array(np.conjugate(inverse))
