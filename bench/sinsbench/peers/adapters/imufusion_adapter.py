"""Imufusion: the filter without corrections."""

from typing import Any

import imufusion
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def gain_zero(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Filter mean rates with gain zero; the filter takes degrees per second."""
    filter_ = imufusion.Ahrs()
    filter_.set_settings(imufusion.AhrsSettings(sample_rate=1 / interval, gain=0.0, gyroscope_range=0.0))
    filter_.skip_startup()
    filter_.set_quaternion(attitude0)
    made = [attitude0]
    no_acceleration = np.zeros(3)
    for mean in np.degrees(rate):
        filter_.update_no_magnetometer(mean, no_acceleration)
        made.append(filter_.get_quaternion())
    return np.array(made, dtype=np.float64)
