"""Scikit-kinematics: its integration of rates."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from skinematics import quat

Array = NDArray[np.float64]


def calc_quat(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate body-fixed rates at the ends of the samples; the sign of the first attitude is made positive."""
    start = attitude0 if attitude0[0] >= 0 else -attitude0  # known by its vector part alone
    return quat.calc_quat(rate, start[1:], 1 / interval, "bf")
