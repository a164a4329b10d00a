"""Rowan: its step with a constant angular velocity."""

from typing import Any

import numpy as np
import rowan
from numpy.typing import NDArray

Array = NDArray[np.float64]


def integrated(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Step with the mean rates.

    The package multiplies from the left, by rates in the axes of the reference: the inverse attitude is integrated,
    which turns at minus the body rate.
    """
    inverse = [rowan.conjugate(attitude0)]
    for mean in -rate:
        inverse.append(rowan.calculus.integrate(inverse[-1], mean, interval))
    return rowan.conjugate(np.array(inverse))
