"""AHRS: its integration of angular rates."""

from typing import Any

import numpy as np
from ahrs.filters import AngularRate
from numpy.typing import NDArray

Array = NDArray[np.float64]


def _integrated(rates: Array, interval: float, attitude0: Array, **options: Any) -> Array:
    """Integrate n+1 rates; the class ignores the first row, whose attitude is the initial one."""
    return np.asarray(AngularRate(gyr=rates, q0=attitude0, Dt=interval, **options).Q)


def instantaneous(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate rates at the ends of the samples, each taken for its whole sample: the method ``closed``."""
    return _integrated(rate, interval, attitude0, method="closed")


def closed(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate mean rates by the method ``closed``."""
    return _integrated(np.vstack([rate[:1], rate]), interval, attitude0, method="closed")


def series(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate mean rates by the method ``series`` with terms up to the third."""
    return _integrated(np.vstack([rate[:1], rate]), interval, attitude0, method="series", order=3)
