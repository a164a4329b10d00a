"""Errors of estimates of an antenna on a mast, none of which depends on how the mast's own axes are twisted about it.

A twist psi of the axes Q about the mast, lambda o q_z(psi) and q_z(-psi) o eta, changes nothing that is measured.
Angles are therefore those of mu, nu = lambda o eta, chi = mu o nu, of the antenna relative to local level, and of the
mast's direction.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.running import RunError
from sinsbench.subjects.mast.contract import ERRORS, MastConstants, MastInputs, MastNoise, MastStart
from sinsdata.truth.mast import MastMotion, StartEstimate
from sinsref.quaternion import conjugate, product

__all__ = [
    "BLOCKS",
    "COLUMNS",
    "QUANTITIES",
    "Estimates",
    "FailedEstimateError",
    "attitudes",
    "checked_estimates",
    "error_vectors",
    "gauge_free_errors",
    "inputs_of",
    "nees",
    "start_of",
]

Array = NDArray[np.float64]

_QUATERNIONS = ("mu", "eta", "lambda")
COLUMNS: Mapping[str, int] = {
    **dict.fromkeys(_QUATERNIONS, 4),
    **dict.fromkeys(("longitude", "latitude", "height"), 0),
    "velocity": 3,
    "mast_rate": 2,
}
"""What an estimator returns beside the times, and its number of columns; 0 for a plain number."""

QUANTITIES: Mapping[str, tuple[str, str]] = {
    "mu": ("rad", "rotation angle of the error of the vehicle's attitude, J1 to inertial axes"),
    "nu": ("rad", "rotation angle of the error of the antenna's attitude relative to the vehicle, J2 to J1"),
    "chi": ("rad", "rotation angle of the error of the antenna's attitude, J2 to inertial axes"),
    "antenna": ("rad", "rotation angle of the error of the antenna's attitude to local level at the estimated place"),
    "mast": ("rad", "angle between estimated and true direction of the mast, in J1"),
    "position": ("m", "norm of the error of position"),
    "velocity": ("m/s", "norm of the error of velocity"),
    "longitude": ("rad", "error of longitude"),
    "latitude": ("rad", "error of latitude"),
}
"""Errors by name: unit, and what each is."""

BLOCKS: Mapping[str, tuple[int, ...]] = {
    "joint": (*range(14), 15, 16),
    "navigation": tuple(range(9)),
    "antenna": (9, 10, 11),
    "mast": (12, 13, 15, 16),
}
"""Errors, in the order of the covariance, scored together for consistency: all but the twist, and parts of them."""

_UNIT = 1e-6  # how far the norm of a quaternion may be from 1: a slip is seen, drift of an unnormalised one passes
_ON_TIME = 1e-6  # of a step


@dataclass(frozen=True)
class Estimates:
    """Checked result of an estimator.

    Attributes
    ----------
    rows : ndarray of int, shape (m,)
        Rows of the truth that the estimates are of.
    values : mapping of str to ndarray
        The names of `COLUMNS`.
    covariance : ndarray, shape (m, 17, 17), or None
    nis, nis_freedom : ndarray, shape (m,), or None
        Sums from the start on of the normalised innovations squared, and their degrees of freedom.
    """

    rows: NDArray[np.int64]
    values: Mapping[str, Array]
    covariance: Array | None
    nis: Array | None
    nis_freedom: Array | None


def inputs_of(truth: MastMotion) -> MastInputs:
    """Return what an estimator is given of a motion; the arrays are copies: it may write into them."""
    seen = truth.readings()
    return MastInputs(
        seen.time.copy(),
        seen.rate1,
        seen.specific_force1,
        seen.rate2,
        seen.specific_force2,
        truth.satellite_position.copy(),
        truth.satellite_velocity.copy(),
        seen.range_rate,
        seen.range,
        MastNoise(
            truth.gyro_sd,
            truth.accelerometer_sd,
            truth.gyro_sd,
            truth.accelerometer_sd,
            truth.antenna_rate_sd,
            truth.range_rate_sd,
            truth.range_sd,
        ),
        MastConstants(truth.mast_length, truth.radius, truth.rotation_rate, truth.gravity),
    )


def start_of(start: StartEstimate) -> MastStart:
    """Return the initial estimate as an estimator is given it; the arrays are copies."""
    return MastStart(
        start.mu.copy(),
        start.longitude,
        start.latitude,
        start.velocity.copy(),
        start.height,
        start.eta.copy(),
        start.lam.copy(),
        start.mast_rate.copy(),
        start.sds.copy(),
    )


def checked_estimates(result: object, truth: MastMotion) -> Estimates:
    """Check what an estimator returned.

    Raises
    ------
    RunError
        If something is missing or has another shape, a time is not the end of a step, or the rows do not span the
        motion.
    FailedEstimateError
        If a value is not finite or a quaternion has not the norm 1, which says at which second.
    """
    if not isinstance(result, Mapping):
        raise RunError("wrong shape", f"the result is {type(result).__name__}; a mapping of arrays is needed")
    time = _array(result, "time", ())
    ends = truth.time[::2]
    steps = np.rint((time - ends[0]) / truth.interval)
    if not np.isfinite(time).all() or len(time) < 2 or (np.diff(steps) < 1).any():
        raise RunError("wrong shape", "time does not increase from row to row, over two rows at least")
    off = np.abs(time - ends[0] - steps * truth.interval) > _ON_TIME * truth.interval
    if off.any() or steps[0] < 0 or steps[-1] >= len(ends):
        first = int(np.argmax(off)) if off.any() else (0 if steps[0] < 0 else -1)
        raise RunError("wrong shape", f"time {time[first]:.9g} s is not the end of a step of {truth.interval:g} s")
    rows = 2 * steps.astype(np.int64)
    values = {name: _array(result, name, (columns,) if columns else (), len(time)) for name, columns in COLUMNS.items()}
    covariance, nis, freedom = (
        None if result.get(name) is None else _array(result, name, shape, len(time))
        for name, shape in (("covariance", (ERRORS, ERRORS)), ("nis", ()), ("nis_freedom", ()))
    )
    given = {**values, "covariance": covariance, "nis": nis, "nis_freedom": freedom}
    _check_finite({name: array for name, array in given.items() if array is not None}, time)
    for name in _QUATERNIONS:
        wrong = np.abs(np.linalg.norm(values[name], axis=1) - 1) > _UNIT
        if wrong.any():
            raise FailedEstimateError("error", f"{name} is no unit quaternion", float(time[int(np.argmax(wrong))]))
    # Rows of whole seconds may end up to a second early.
    if steps[0] != 0 or time[-1] < ends[-1] - 1.0 + _ON_TIME:
        span = f"{time[0]:.9g} ... {time[-1]:.9g} s"
        raise RunError("wrong shape", f"rows of {span} do not span the motion of {ends[0]:g} ... {ends[-1]:.9g} s")
    return Estimates(rows, values, covariance, nis, freedom)


def _array(result: Mapping[str, object], name: str, shape: tuple[int, ...], count: int | None = None) -> Array:
    if result.get(name) is None:
        raise RunError("wrong shape", f"the result holds no {name}")
    try:
        array = np.asarray(result[name]).astype(np.float64, casting="same_kind")
    except Exception as error:  # a stranger's object may raise anything when it is asked for its numbers
        raise RunError("wrong shape", f"{name} is not an array of real numbers") from error
    if array.ndim != 1 + len(shape) or array.shape[1:] != shape or count not in (None, len(array)):
        wanted = ", ".join(map(str, ("m" if count is None else count, *shape)))
        raise RunError("wrong shape", f"{name} has shape {array.shape}; ({wanted}{'' if shape else ','}) is needed")
    return array


def _check_finite(arrays: Mapping[str, Array], time: Array) -> None:
    firsts = {}
    for name, array in arrays.items():
        finite = np.isfinite(array.reshape(len(array), -1)).all(axis=1)
        if not finite.all():
            firsts[name] = int(np.argmin(finite))
    if firsts:
        name = min(firsts, key=lambda one: firsts[one])
        raise FailedEstimateError("not finite", f"{name} holds NaN or infinity", float(time[firsts[name]]))


class FailedEstimateError(RunError):
    """An estimate, or its covariance, is none from some time on.

    Parameters
    ----------
    status : str
        One of `sinsbench.scoring.rows.STATUSES`.
    reason : str
        What is wrong.
    time : float
        Since when, s.
    """

    def __init__(self, status: str, reason: str, time: float) -> None:
        super().__init__(status, f"{reason}, first at t = {time:.9g} s")
        self.time = time


def _after(*quaternions: Array) -> Array:
    """Return the product of arrays of quaternions, shape (m, 4)."""
    columns = list(quaternions[0].T)
    for other in quaternions[1:]:
        columns = product(columns, list(other.T))
    return np.stack(columns, axis=1)


def _inverse(quaternion: Array) -> Array:
    return np.stack(conjugate(list(quaternion.T)), axis=1)


def _vectors(computed: Array, true: Array) -> Array:
    """Return the rotation vectors v of true = computed o exp(v), shape (m, 3), of length at most pi, rad."""
    q = _after(_inverse(computed), true)
    q = np.where(q[:, :1] < 0, -q, q)
    sine = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    # From the vector part: the scalar part of a small rotation is 1, whatever its angle.
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(q[:, 1:] * np.where(sine > 0, 2 * np.arctan2(sine, q[:, :1]) / sine, 2.0))


def _level(longitude: Array, latitude: Array) -> Array:
    """Return the quaternions of local level by longitude and latitude."""
    zero = np.zeros_like(latitude)
    about_the_pole = np.stack([np.cos(longitude / 2), zero, np.sin(longitude / 2), zero], axis=1)
    return _after(about_the_pole, np.stack([np.cos(latitude / 2), -np.sin(latitude / 2), zero, zero], axis=1))


def _mast_direction(lam: Array) -> Array:
    """Return the direction of the mast in J1: the third row of D(lambda)."""
    a, b, c, d = lam.T
    return np.stack([2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d], axis=1)


def _true_values(truth: MastMotion, rows: NDArray[np.int64]) -> dict[str, Array]:
    names = {name: "lam" if name == "lambda" else name for name in COLUMNS}
    return {name: getattr(truth, attribute)[rows] for name, attribute in names.items()}


def attitudes(values: Mapping[str, Array], turned: Array) -> dict[str, Array]:
    """Return the attitudes that are scored, none of which depends on the twist of the mast's axes.

    Parameters
    ----------
    values : mapping of str to ndarray
        The names of `COLUMNS`.
    turned : ndarray, shape (m,)
        Angle by which the Earth has turned, rad.

    Returns
    -------
    dict of str to ndarray, shape (m, 4)
        ``mu``, ``nu``, ``chi`` and ``antenna`` of `QUANTITIES`.
    """
    nu = _after(values["lambda"], values["eta"])
    chi = _after(values["mu"], nu)
    level = _level(values["longitude"] + turned, values["latitude"])
    return {"mu": values["mu"], "nu": nu, "chi": chi, "antenna": _after(_inverse(level), chi)}


def gauge_free_errors(estimates: Estimates, truth: MastMotion) -> dict[str, Array]:
    """Return the absolute values of errors over time.

    Parameters
    ----------
    estimates : Estimates
    truth : MastMotion

    Returns
    -------
    dict of str to ndarray, shape (m,)
        The names of `QUANTITIES`.
    """
    true = _true_values(truth, estimates.rows)
    turned = truth.rotation_rate * truth.time[estimates.rows]
    computed, right = (attitudes(values, turned) for values in (estimates.values, true))
    errors = {name: np.linalg.norm(_vectors(computed[name], right[name]), axis=1) for name in computed}
    masts = [_mast_direction(given["lambda"]) for given in (estimates.values, true)]
    apart, together = (np.linalg.norm(x, axis=1) for x in (masts[0] - masts[1], masts[0] + masts[1]))
    east, north, up = (estimates.values[name] - true[name] for name in ("longitude", "latitude", "height"))
    metres = np.stack([truth.radius * np.cos(true["latitude"]) * east, truth.radius * north, up], axis=1)
    return errors | {
        "mast": 2 * np.arctan2(apart, together),
        "position": np.linalg.norm(metres, axis=1),
        "velocity": np.linalg.norm(estimates.values["velocity"] - true["velocity"], axis=1),
        "longitude": np.abs(east),
        "latitude": np.abs(north),
    }


def error_vectors(estimates: Estimates, truth: MastMotion) -> Array:
    """Return the errors that a covariance is about, in its order, shape (m, 17): true = estimate [+] error."""
    true = _true_values(truth, estimates.rows)
    given = estimates.values
    nu = [_after(values["lambda"], values["eta"]) for values in (given, true)]
    return np.column_stack(
        [
            _vectors(given["mu"], true["mu"]),
            *(true[name] - given[name] for name in ("longitude", "latitude", "velocity", "height")),
            _vectors(*nu),
            _vectors(given["lambda"], true["lambda"]),
            true["mast_rate"] - given["mast_rate"],
        ]
    )


def nees(estimates: Estimates, truth: MastMotion) -> dict[str, Array]:
    """Return the normalised estimation errors squared e^T P^-1 e over time.

    Parameters
    ----------
    estimates : Estimates
        With a covariance.
    truth : MastMotion

    Returns
    -------
    dict of str to ndarray, shape (m,)
        The names of `BLOCKS`; each of as many degrees of freedom as the block has errors.

    Raises
    ------
    RunError
        If there is no covariance.
    FailedEstimateError
        If it is not positive, which says at which second.
    """
    if estimates.covariance is None:
        raise RunError("wrong shape", "the result holds no covariance")
    errors, found = error_vectors(estimates, truth), {}
    for name, places in BLOCKS.items():
        block = estimates.covariance[:, places][:, :, places]
        # Radians and metres are made comparable first: the conditions of P are otherwise those of its units.
        scale = np.sqrt(np.maximum(np.diagonal(block, axis1=1, axis2=2), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            correlation = block / (scale[:, :, None] * scale[:, None, :])
            scaled = errors[:, places] / scale
        positive = [np.isfinite(one).all() and np.linalg.eigvalsh(one)[0] > 0 for one in correlation]
        if not all(positive):
            when = float(truth.time[estimates.rows[positive.index(False)]])
            raise FailedEstimateError("error", "covariance is not positive", when)
        found[name] = np.sum(scaled * np.linalg.solve(correlation, scaled[:, :, None])[:, :, 0], axis=1)
    return found
