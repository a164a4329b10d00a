"""smsfusion: its strapdown navigation in axes that do not turn."""

from typing import Any

import numpy as np
import smsfusion
from numpy.typing import NDArray

Array = NDArray[np.float64]


def strapdown(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Navigate with mean rates, without gravity."""
    state = np.concatenate([np.zeros(3), velocity0, attitude0, np.zeros(6)])
    navigator = smsfusion.StrapdownINS(1 / interval, state, g=0.0)
    attitude, velocity = [attitude0], [velocity0]
    for mean_rate, mean_force in zip(rate, force, strict=True):
        navigator.update(mean_force, mean_rate)
        attitude.append(navigator.quaternion())
        velocity.append(navigator.velocity())
    return {"attitude": np.array(attitude), "velocity_inertial": np.array(velocity)}
