"""GTSAM: exponentials, and its preintegration of inertial measurements."""

from typing import Any

import gtsam
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_KEY_FRAMES = 0.2  # s between key frames: preintegration is for such times, not for a whole run


def _components(rotation: Any) -> Array:
    q = rotation.toQuaternion()
    return np.array([q.w(), q.x(), q.y(), q.z()])


def exponential(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the exponentials of the angle increments."""
    attitude = gtsam.Rot3(*attitude0)
    made = [_components(attitude)]
    for increment in angle:
        attitude = attitude.compose(gtsam.Rot3.Expmap(increment))
        made.append(_components(attitude))
    return np.array(made)


def _preintegrated(kind: Any, rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Preintegrate between key frames, without gravity, and predict the state after each sample."""
    measurements = kind(gtsam.PreintegrationParams.MakeSharedU(0.0))
    no_bias = gtsam.imuBias.ConstantBias()
    state = start = gtsam.NavState(gtsam.Rot3(*attitude0), np.zeros(3), velocity0)
    between = max(1, round(_KEY_FRAMES / interval))
    attitude, velocity = [attitude0], [velocity0]
    for number, (mean_rate, mean_force) in enumerate(zip(rate, force, strict=True)):
        if number % between == 0:
            start = state
            measurements.resetIntegration()
        measurements.integrateMeasurement(mean_force, mean_rate, interval)
        state = measurements.predict(start, no_bias)
        attitude.append(_components(state.attitude()))
        velocity.append(state.velocity())
    return {"attitude": np.array(attitude), "velocity_inertial": np.array(velocity)}


def preintegrated(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Preintegrate mean rates with the class that is the default: in the tangent space, as the wheels are built."""
    return _preintegrated(gtsam.PreintegratedImuMeasurements, rate, force, interval, attitude0, velocity0)


def preintegrated_manifold(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Preintegrate mean rates on the manifold."""
    return _preintegrated(gtsam.PreintegratedImuMeasurementsManifold, rate, force, interval, attitude0, velocity0)


def preintegrated_lie_group(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Preintegrate mean rates in the Lie group."""
    return _preintegrated(gtsam.PreintegratedImuMeasurementsLieGroup, rate, force, interval, attitude0, velocity0)
