"""Estimates of the mast's antenna whose errors are given, in the order of the covariance."""

import numpy as np
from numpy.typing import NDArray

from sinsdata.truth.mast import MastMotion
from sinsref.quaternion import product

Array = NDArray[np.float64]

#: Sizes of errors that are small in every quantity: rad, rad, m/s, m, rad, rad, rad/s.
SIZES = np.repeat([1e-5, 1e-6, 0.1, 10.0, 1e-5, 1e-5, 0.01], [3, 2, 3, 1, 3, 3, 2])
_INVERSE = np.array([1.0, -1.0, -1.0, -1.0])


def _after(a: Array, b: Array) -> Array:
    return np.stack(product(list(a.T), list(b.T)), axis=1)


def _turns(vectors: Array) -> Array:
    """Return the quaternions of rotation vectors."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    # sinc(x) = sin(pi x)/(pi x)
    return np.hstack([np.cos(angle / 2), vectors / 2 * np.sinc(angle / (2 * np.pi))])


def shifted(truth: MastMotion, rows: NDArray[np.int64], errors: Array) -> dict[str, Array]:
    """Return what an estimator returns where the truth is its estimate [+] the errors, shape (m, 17)."""
    lam = _after(truth.lam[rows], _turns(-errors[:, 12:15]))
    nu = _after(truth.nu[rows], _turns(-errors[:, 9:12]))
    return {
        "time": truth.time[rows],
        "mu": _after(truth.mu[rows], _turns(-errors[:, :3])),
        "longitude": truth.longitude[rows] - errors[:, 3],
        "latitude": truth.latitude[rows] - errors[:, 4],
        "velocity": truth.velocity[rows] - errors[:, 5:8],
        "height": truth.height[rows] - errors[:, 8],
        "eta": _after(lam * _INVERSE, nu),
        "lambda": lam,
        "mast_rate": truth.mast_rate[rows] - errors[:, 15:],
    }
