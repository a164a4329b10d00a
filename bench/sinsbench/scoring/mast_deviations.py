"""What an estimator's covariance predicts of the errors that are scored: of norms and angles, not of coordinates.

Every quantity of `sinsbench.scoring.mast_errors.QUANTITIES` is, to first order, the norm of a linear map J of the 17
errors that a covariance P is about. Its deviation is sqrt(trace(J P J^T)), the root mean square that P predicts of the
norm. It does not depend on axes, is the standard deviation where J has one row, and its threefold keeps the meaning
that three sigma have there: of all normal errors with the same trace those along one direction exceed it most often,
0.27 per cent of the time.

References
----------
G. J. Szekely, N. K. Bakirov, "Extremal probabilities for Gaussian quadratic forms", Probability Theory and Related
Fields 126 (2003), 184-202.
"""

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.mast_errors import Estimates, attitudes
from sinsbench.scoring.running import RunError
from sinsbench.subjects.mast.contract import ERRORS
from sinsdata.truth.mast import MastMotion
from sinsref.quaternion import rotate

__all__ = ["deviations", "error_maps"]

Array = NDArray[np.float64]

# Places of the errors in the order of the covariance.
_MU, _VELOCITY, _NU, _TILT = slice(0, 3), slice(5, 8), slice(9, 12), slice(12, 14)
_LONGITUDE, _LATITUDE, _HEIGHT = 3, 4, 8


def _matrices(attitude: Array) -> Array:
    """Return the matrices of q o v o conj(q), shape (m, 3, 3)."""
    images = (rotate(list(attitude.T), list(axis)) for axis in np.eye(3))
    return np.stack([np.stack(image, axis=1) for image in images], axis=2)


def error_maps(estimates: Estimates, truth: MastMotion) -> dict[str, Array]:
    """Return the derivatives of what is scored by the errors that a covariance is about.

    Parameters
    ----------
    estimates : Estimates
        About which the derivatives are taken.
    truth : MastMotion
        For the constants of the scenario.

    Returns
    -------
    dict of str to ndarray, shape (m, k, 17)
        The names of `QUANTITIES`. With R the rotation matrix of an attitude, the angles are the norms of

            mu       theta_mu
            nu       theta_nu
            chi      theta_chi = R(nu)^T theta_mu + theta_nu
            antenna  theta_chi - R(antenna)^T (-dlat, dlon cos(lat), dlon sin(lat))
            mast     the components of theta_lambda across the mast
    """
    count = len(estimates.rows)
    latitude = estimates.values["latitude"]
    known = attitudes(estimates.values, truth.rotation_rate * truth.time[estimates.rows])
    sizes = {"mu": 3, "nu": 3, "chi": 3, "mast": 2, "position": 3, "velocity": 3, "longitude": 1, "latitude": 1}
    maps = {name: np.zeros((count, rows, ERRORS)) for name, rows in sizes.items()}
    maps["mu"][:, :, _MU] = maps["velocity"][:, :, _VELOCITY] = np.eye(3)
    maps["nu"][:, :, _NU] = maps["chi"][:, :, _NU] = np.eye(3)
    maps["chi"][:, :, _MU] = _matrices(known["nu"]).transpose(0, 2, 1)
    maps["mast"][:, :, _TILT] = np.eye(2)
    maps["longitude"][:, 0, _LONGITUDE] = maps["latitude"][:, 0, _LATITUDE] = 1
    # East, north, up.
    maps["position"][:, 0, _LONGITUDE] = truth.radius * np.cos(latitude)
    maps["position"][:, 1, _LATITUDE] = truth.radius
    maps["position"][:, 2, _HEIGHT] = 1
    # How local level turns with the place, about its own axes.
    level = np.zeros((count, 3, ERRORS))
    level[:, 1, _LONGITUDE], level[:, 2, _LONGITUDE] = np.cos(latitude), np.sin(latitude)
    level[:, 0, _LATITUDE] = -1
    maps["antenna"] = maps["chi"] - _matrices(known["antenna"]).transpose(0, 2, 1) @ level
    return maps


def deviations(estimates: Estimates, truth: MastMotion) -> dict[str, Array]:
    """Return the root mean squares of errors that an estimator's own covariance predicts, over time.

    Parameters
    ----------
    estimates : Estimates
        With a covariance.
    truth : MastMotion
        For the constants of the scenario.

    Returns
    -------
    dict of str to ndarray, shape (m,)
        The names of `QUANTITIES`, in their units.

    Raises
    ------
    RunError
        If there is no covariance.
    """
    if estimates.covariance is None:
        raise RunError("wrong shape", "the result holds no covariance")
    found = {}
    for name, derivative in error_maps(estimates, truth).items():
        squares = np.sum((derivative @ estimates.covariance) * derivative, axis=(1, 2))
        # A variance of zero may round to less.
        found[name] = np.sqrt(np.maximum(squares, 0.0))
    return found
