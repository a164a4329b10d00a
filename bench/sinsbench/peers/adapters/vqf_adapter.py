"""VQF: the strapdown part of the filter."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vqf import VQF

Array = NDArray[np.float64]


def gyroscope_only(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Filter mean rates without estimates of bias; samples of acceleration that are zero are ignored by the filter."""
    settings = {"motionBiasEstEnabled": False, "restBiasEstEnabled": False, "magDistRejectionEnabled": False}
    estimator = VQF(interval, **settings)
    estimator.state = {**estimator.state, "gyrQuat": attitude0}
    made = estimator.updateBatch(np.ascontiguousarray(rate), np.zeros_like(rate))["quat6D"]
    return np.vstack([attitude0, made])
