"""Pyins (python-ins): increments with coning and sculling terms, and navigation over the turning Earth."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pyins import earth, strapdown, transform, util
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def _imu(gyro: Array, accelerometer: Array, interval: float) -> Any:
    return pd.DataFrame(
        np.hstack([gyro, accelerometer]),
        index=interval * np.arange(len(gyro)),
        columns=util.GYRO_COLS + util.ACCEL_COLS,
    )


def _with_sample_before(increments: Array) -> Array:
    """Put a sample before the first, by a parabola through three: the package asks for one, no input has it."""
    first, second, third = increments[:3]
    return np.vstack([3 * first - 3 * second + third, increments])


def _navigated(increments: Any, interval: float, attitude0: Array) -> Array:
    """Navigate, from rest at 45 degrees north, and take Earth's rotation and the travel out of the attitude.

    Both frames, north-east-down at the start and inertial, coincide at time zero. The altitude is held: else the body,
    which no ground carries, would fall out of the range of the package's gravity.
    """
    start = Rotation.from_quat(attitude0[[1, 2, 3, 0]])
    place = [45.0, 0.0, 0.0]
    pva = pd.Series(
        [*place, 0.0, 0.0, 0.0, *transform.mat_to_rph(start.as_matrix())], index=util.TRAJECTORY_COLS, name=0.0
    )
    trajectory = strapdown.Integrator(pva, with_altitude=False).integrate(increments)
    body = Rotation.from_matrix(transform.mat_from_rph(trajectory[util.RPH_COLS]))
    turned = trajectory.lon + np.degrees(earth.RATE) * interval * np.arange(len(trajectory))
    local = Rotation.from_matrix(transform.mat_en_from_ll(trajectory.lat, turned))
    attitude: Array = (local[0].inv() * local * body).as_quat()[:, [3, 0, 1, 2]]
    return attitude


def integrator(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Navigate with angle and velocity increments."""
    imu = _imu(_with_sample_before(angle), _with_sample_before(velocity), interval)
    return _navigated(strapdown.compute_increments_from_imu(imu, "increment"), interval, attitude0)


def integrator_of_rates(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Navigate with angular rate and specific force at the ends of the samples."""
    increments = strapdown.compute_increments_from_imu(_imu(rate, force, interval), "rate")
    return _navigated(increments, interval, attitude0)


def _composed(increments: Any, attitude0: Array, velocity0: Array) -> dict[str, Array]:
    """Compose rotation vectors in one sweep, products of pairs, of fours and so on, and sum up the velocity."""
    columns = util.THETA_COLS + util.DV_COLS
    theta, gained = np.split(increments[columns].to_numpy(copy=True), 2, axis=1)
    body = Rotation.concatenate([Rotation.from_quat(attitude0[[1, 2, 3, 0]]), Rotation.from_rotvec(theta)])
    reach = 1
    while reach < len(body):
        body = Rotation.concatenate([body[:reach], body[:-reach] * body[reach:]])
        reach *= 2
    return {
        "attitude": body.as_quat()[:, [3, 0, 1, 2]],
        "velocity_inertial": np.cumsum(np.vstack([velocity0, body[:-1].apply(gained)]), axis=0),
    }


def increments(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the rotation vectors and velocity increments that the package makes of increments."""
    imu = _imu(_with_sample_before(angle), _with_sample_before(velocity), interval)
    return _composed(strapdown.compute_increments_from_imu(imu, "increment"), attitude0, velocity0)


def increments_of_rates(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the rotation vectors and velocity increments that the package makes of rates."""
    made = strapdown.compute_increments_from_imu(_imu(rate, force, interval), "rate")
    return _composed(made, attitude0, velocity0)
