"""Sophuspy: exponentials."""

from itertools import accumulate
from operator import mul
from typing import Any

import numpy as np
import sophuspy
from numpy.typing import NDArray

Array = NDArray[np.float64]


def exponential(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the exponentials of the angle increments; the logarithm of a rotation tells its quaternion."""
    size = np.linalg.norm(attitude0[1:])
    vector = 2 * np.arctan2(size, attitude0[0]) * attitude0[1:] / (size or 1.0)
    attitudes = accumulate(map(sophuspy.SO3.exp, angle), mul, initial=sophuspy.SO3.exp(vector))
    turned = np.array([one.log() for one in attitudes]).reshape(-1, 3)
    half = np.linalg.norm(turned, axis=1, keepdims=True) / 2
    return np.hstack([np.cos(half), np.sinc(half / np.pi) * turned / 2])
