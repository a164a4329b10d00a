"""sidereon: its mechanisation in axes that turn with the Earth."""

from typing import Any

import numpy as np
import sidereon
from numpy.typing import NDArray

Array = NDArray[np.float64]

_EARTH_RATE = 7.2921151467e-5  # rad/s; the package does not export its own, an increment of zero shows this one


def mechanised(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Navigate with increments, from rest on the equator, and take Earth's rotation out of the attitude.

    The axes that turn with the Earth and the inertial ones coincide at time zero.
    """
    start = sidereon.quaternion_to_dcm(sidereon.AttitudeQuaternion(*attitude0))
    state = sidereon.NavState(0.0, [6378137.0, 0.0, 0.0], [0.0, 0.0, 0.0], start)
    mechanizer = sidereon.StrapdownMechanizer(state)
    made = [attitude0]
    for number, (turned, gained) in enumerate(zip(angle.tolist(), velocity.tolist(), strict=True), start=1):
        sample = sidereon.ImuSample.increment(number * interval, gained, turned, interval)
        made.append(mechanizer.propagate(sample).attitude_quaternion_body_to_ecef)
    w, x, y, z = np.array(made).T
    half = _EARTH_RATE * interval * np.arange(len(made)) / 2
    cosine, sine = np.cos(half), np.sin(half)
    return np.column_stack([cosine * w - sine * z, cosine * x - sine * y, cosine * y + sine * x, cosine * z + sine * w])
