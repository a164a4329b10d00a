"""Pinocchio: the integration of a spherical joint."""

from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

Array = NDArray[np.float64]


def spherical_joint(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate the configuration, a scalar-last quaternion, by angle increments in the axes of the body."""
    model = pinocchio.Model()
    model.addJoint(0, pinocchio.JointModelSpherical(), pinocchio.SE3.Identity(), "body")
    made = [attitude0[[1, 2, 3, 0]]]
    for increment in angle:
        made.append(pinocchio.integrate(model, made[-1], increment))
    return np.array(made)[:, [3, 0, 1, 2]]
