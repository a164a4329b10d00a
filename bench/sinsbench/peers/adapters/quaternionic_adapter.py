"""Quaternionic: exponentials, and its integration of tabulated rates."""

from itertools import accumulate
from operator import mul
from typing import Any

import numpy as np
import quaternionic
from numpy.typing import NDArray

Array = NDArray[np.float64]


def exponential(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the exponentials of half the angle increments."""
    steps = np.exp(quaternionic.array.from_vector_part(angle / 2))
    return np.array([one.ndarray for one in accumulate(steps, mul, initial=quaternionic.array(attitude0))])


def integrated(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate tabulated rates.

    The package wants the rate in the axes of the reference. The inverse attitude turns at minus the body rate, which
    stands in the axes that are its reference: that one is integrated.
    """
    times = interval * np.arange(len(rate))
    start = quaternionic.array(attitude0).conjugate()
    inverse = quaternionic.array.from_angular_velocity(-rate, times, R0=start)
    return inverse.conjugate().ndarray
