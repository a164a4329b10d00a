"""What an estimator of the mast's antenna is given, what it returns, what it refuses, and how either is checked.

An estimator is ``f(inputs, start)``. It returns a mapping of arrays with one row for every `STRIDE` seconds, the first
of them the start: ``time`` (s), ``mu``, ``longitude``, ``latitude``, ``velocity``, ``height``, ``eta``, ``lambda``,
``mast_rate``; and, if it has them, ``covariance`` of shape (m, 17, 17) and ``nis``, ``nis_freedom``: sums of the
normalised innovations squared from the start on, and their degrees of freedom. The row of a time holds the estimate
from what was measured before it.

The covariance is that of the 17 errors

    theta_mu[3], longitude, latitude, V[3], H, theta_nu[3], theta_lambda[3], w[2]

with true = estimate [+] error: mu o exp(theta_mu), nu o exp(theta_nu) for nu = lambda o eta, lambda o
exp(theta_lambda), the numbers additive.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.increments import checked_array, finite_over_time
from sinsbench.subjects.mast.model import Constants as MastConstants
from sinsbench.subjects.outcome import OutcomeError

__all__ = [
    "ERRORS",
    "STRIDE",
    "BreakdownError",
    "MastConstants",
    "MastInputs",
    "MastNoise",
    "MastStart",
    "StabilityError",
]

Array = NDArray[np.float64]
Result = dict[str, Array]

ERRORS = 17
"""Number of errors that a covariance is about."""
STRIDE = 1.0
"""Distance of the rows of a result, s."""

_UNEVEN = 1e-6  # of a step: times printed to a microsecond pass, a missing sample does not
_UNIT = 1e-9  # far above rounding, far below any other meaning


class BreakdownError(OutcomeError):
    """An estimator broke down on its way.

    Parameters
    ----------
    reason : str
        What no longer holds.
    time : float
        When that was first seen, s.
    partial : mapping of str to ndarray
        The rows of the result until then.
    """

    def __init__(self, reason: str, time: float, partial: Mapping[str, Array]) -> None:
        super().__init__("not finite", f"{reason}, first at t = {time:.9g} s")
        self.time = time
        self.partial = partial


class StabilityError(OutcomeError):
    """The step of an explicit method is beyond what is stable with the initial covariance.

    Parameters
    ----------
    product : float
        Step times the largest eigenvalue of P H^T S^-1 H.
    bound : float
        What it must stay below.
    step : float
        s.
    """

    def __init__(self, product: float, bound: float, step: float) -> None:
        super().__init__(
            "not applicable",
            f"the step of {step:.6g} s times the largest eigenvalue of P H^T S^-1 H is {product:.3g} at the start, "
            f"stable below {bound}: that needs initial variances {bound / product:.3g} times as large, or a step below "
            f"{step * bound / product:.3g} s at the same intensities of noise",
        )
        self.product = product


@dataclass(frozen=True)
class MastNoise:
    """Standard deviations of the noise, per sample.

    Attributes
    ----------
    rate1, specific_force1, rate2, specific_force2 : float
        Of the sensors, rad/s and m/s^2.
    antenna_rate : float
        Of the rate w_J of the antenna on the mast, rad/s.
    range_rate, range : float
        Of the satellites' measurements, m/s and m.
    """

    rate1: float
    specific_force1: float
    rate2: float
    specific_force2: float
    antenna_rate: float
    range_rate: float
    range: float


@dataclass(frozen=True)
class MastInputs:
    """Sensors and satellites over n steps, with N satellites.

    Sensors are given at start, middle and end of each step, the noise of a step held over it.

    Attributes
    ----------
    time : ndarray, shape (n + 1,)
        Ends of the steps, s.
    rate1, specific_force1 : ndarray, shape (n, 3, 3)
        Step, point, axis: of the vehicle in J1, rad/s and m/s^2.
    rate2, specific_force2 : ndarray, shape (n, 3, 3)
        Of the antenna in J2.
    satellite_position, satellite_velocity : ndarray, shape (2 n + 1, N, 3)
        At ends and middles of the steps, Earth-fixed axes with the spin axis second, m and m/s.
    range_rate, range : ndarray, shape (n, 3, N)
        Step, point, satellite: m/s and m.
    noise : MastNoise
    constants : MastConstants
    """

    time: Array
    rate1: Array
    specific_force1: Array
    rate2: Array
    specific_force2: Array
    satellite_position: Array
    satellite_velocity: Array
    range_rate: Array
    range: Array
    noise: MastNoise
    constants: MastConstants

    @property
    def step(self) -> float:
        """Length of a step, s."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))

    def checked(self) -> "MastInputs":
        """Return the inputs as contiguous float64 arrays.

        Raises
        ------
        ValueError
            If a shape is wrong, a value is not finite (which says when), times are not equidistant, a standard
            deviation is not positive or a constant of the scenario not admissible.
        """
        time = checked_array("time", self.time, (None,))
        n = len(time) - 1
        if n < 1 or not time[-1] > time[0]:
            raise ValueError("time does not increase: at least one step of positive length is needed")
        steps = np.diff(time)
        mean = (time[-1] - time[0]) / n
        worst = int(np.argmax(np.abs(steps - mean)))
        if abs(steps[worst] - mean) > max(_UNEVEN * mean, 4 * float(np.spacing(np.abs(time).max()))):
            raise ValueError(
                f"time: a step of {steps[worst]:.9g} s at t = {time[worst]:.9g} s, {mean:.9g} s on average"
            )
        satellites = np.shape(self.range)[-1] if np.ndim(self.range) else 0
        if satellites < 1:
            raise ValueError("range holds no satellite, expected at least one")
        for which, part in (("noise", self.noise), ("constants", self.constants)):
            names = part._fields if isinstance(part, tuple) else [field.name for field in fields(part)]
            for name in names:
                if not (np.isfinite(getattr(part, name)) and (getattr(part, name) > 0 or name == "earth_rate")):
                    raise ValueError(f"{which}.{name} = {getattr(part, name)}: a positive number is needed")
        middles = np.linspace(time[0], time[-1], 2 * n + 1)
        shapes = {
            **dict.fromkeys(("rate1", "specific_force1", "rate2", "specific_force2"), (n, 3, 3)),
            **dict.fromkeys(("satellite_position", "satellite_velocity"), (2 * n + 1, satellites, 3)),
            **dict.fromkeys(("range_rate", "range"), (n, 3, satellites)),
        }
        arrays = {
            name: finite_over_time(name, getattr(self, name), shape, time if len(shape) and shape[0] == n else middles)
            for name, shape in shapes.items()
        }
        return MastInputs(time, **arrays, noise=self.noise, constants=self.constants)


@dataclass(frozen=True)
class MastStart:
    """Initial estimate and how well it is known.

    Attributes
    ----------
    mu, eta, lambda_ : ndarray, shape (4,)
        Unit quaternions: inertial axes to J1, Q to J2, J1 to Q.
    longitude, latitude, height : float
        rad, rad, m.
    velocity : ndarray, shape (3,)
        East, north, up, m/s.
    mast_rate : ndarray, shape (2,)
        Absolute rates w_X, w_Y of the mast in Q, rad/s.
    deviations : ndarray, shape (17,)
        Standard deviations of the errors in the order of the covariance; zero where something is known exactly.
    covariance : ndarray, shape (17, 17), optional
        In place of independent errors with `deviations`.
    """

    mu: Array
    longitude: float
    latitude: float
    velocity: Array
    height: float
    eta: Array
    lambda_: Array
    mast_rate: Array
    deviations: Array
    covariance: Array | None = None

    def checked(self) -> tuple[Array, Array]:
        """Return state (20,) and covariance (17, 17).

        Raises
        ------
        ValueError
            If a shape is wrong, a value is not finite, a norm is not 1, the latitude is at a pole or the covariance is
            not symmetric and positive semidefinite.
        """
        shapes = {
            "mu": (4,),
            "velocity": (3,),
            "eta": (4,),
            "lambda_": (4,),
            "mast_rate": (2,),
            "deviations": (ERRORS,),
        }
        part = {name: checked_array(name, getattr(self, name), shape) for name, shape in shapes.items()}
        for name in ("mu", "eta", "lambda_"):
            if abs(np.linalg.norm(part[name]) - 1) > _UNIT:
                raise ValueError(f"{name} has the norm {np.linalg.norm(part[name])}, expected 1")
        for name in ("longitude", "latitude", "height"):
            if not np.isfinite(getattr(self, name)):
                raise ValueError(f"{name} = {getattr(self, name)}: a finite number is needed")
        if not abs(self.latitude) < np.pi / 2:
            raise ValueError(f"latitude = {self.latitude} rad: less than pi/2 in size is needed")
        if (part["deviations"] < 0).any():
            raise ValueError(
                f"deviations[{int(np.argmin(part['deviations']))}] is negative, expected standard deviations"
            )
        covariance = np.diag(part["deviations"] ** 2)
        if self.covariance is not None:
            covariance = checked_array("covariance", self.covariance, (ERRORS, ERRORS))
            _check_positive(covariance)
        place = np.array([self.longitude, self.latitude, *part["velocity"], self.height])
        state = np.concatenate([part["mu"], place, part["eta"], part["lambda_"], part["mast_rate"]])
        return state, covariance


def _check_positive(covariance: Array) -> None:
    """Refuse what is no covariance; radians and metres are made comparable by the diagonal first."""
    variances = np.diag(covariance)
    if (variances < 0).any():
        raise ValueError(f"covariance[{(k := int(np.argmin(variances)))}, {k}] = {variances[k]:.3g}: negative variance")
    scale = np.sqrt(np.where(variances > 0, variances, 1.0))
    correlation = covariance / np.outer(scale, scale)
    if np.abs(correlation - correlation.T).max() > _UNIT:
        raise ValueError("covariance is not symmetric")
    least = float(np.linalg.eigvalsh(correlation)[0])
    if least < -_UNIT:
        raise ValueError(f"covariance is not positive: least eigenvalue of the correlations {least:.3g}")
