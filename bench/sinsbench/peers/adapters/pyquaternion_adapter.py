"""Pyquaternion: its step with a constant angular velocity."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pyquaternion import Quaternion

Array = NDArray[np.float64]


def integrated(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Step with the mean rates; the method multiplies from the right, so it takes them in body axes."""
    attitude = Quaternion(attitude0)
    made = [attitude.elements.copy()]
    for mean in rate:
        attitude.integrate(mean, interval)
        made.append(attitude.elements.copy())
    return np.array(made)
