"""How gyroscopic systems answer to errors of the sensors and of the start; how their own errors grow and swing."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.gyroscopic_errors import angles_between
from sinsbench.subjects.gyroscopic.contract import Inputs, Start
from sinsbench.subjects.gyroscopic.drivers import GyroscopicSubject
from sinsbench.subjects.gyroscopic.start_rules import rotated

__all__ = ["PERTURBATIONS", "Oscillation", "Perturbation", "growth_order", "oscillation", "response"]

Array = NDArray[np.float64]

GYRO_BIAS = float(np.radians(0.01) / 3600)
"""0.01 deg/h on each axis, rad/s."""
ACCELEROMETER_BIAS = 50e-6 * 9.81
"""50 millionths of 9.81 m/s^2 on each axis, m/s^2."""
TILT = 1e-4
"""Turn of the whole start, vertical and velocity, about the axis to the left of the velocity, rad."""
SPEED_ERROR = 1.0
"""Error of the start speed, m/s."""
COURSE_ERROR = 1e-3
"""Turn of the start velocity about the vertical, rad."""


@dataclass(frozen=True)
class Perturbation:
    """An error of the instruments or of the start.

    Attributes
    ----------
    name, unit : str
    size : float
        In `unit`.
    gyro, accelerometer : float
        Bias on each vehicle axis, rad/s and m/s^2.
    start : callable
        Takes the start and returns the one in error.
    """

    name: str
    size: float
    unit: str
    gyro: float = 0.0
    accelerometer: float = 0.0
    start: Callable[[Start], Start] = lambda start: start

    def inputs(self, inputs: Inputs) -> Inputs:
        """Return the sensors with the biases; an increment grows by a bias times the sampling interval."""
        scale = inputs.interval if inputs.kind == "increments" else 1.0
        return replace(
            inputs,
            rate=np.asarray(inputs.rate) + scale * self.gyro,
            specific_force=np.asarray(inputs.specific_force) + scale * self.accelerometer,
        )


def _turned(start: Start, axis: Array, angle: float, *, vertical: bool) -> Start:
    quaternion = np.append(np.cos(angle / 2), np.sin(angle / 2) * axis)
    up = rotated(quaternion, start.vertical) if vertical else start.vertical
    return replace(start, vertical=up, velocity=rotated(quaternion, start.velocity))


def _tilted(start: Start) -> Start:
    return _turned(start, start.axes()[1], TILT, vertical=True)


def _faster(start: Start) -> Start:
    return replace(start, velocity=start.velocity + SPEED_ERROR * start.axes()[0])


def _off_course(start: Start) -> Start:
    return _turned(start, start.vertical, COURSE_ERROR, vertical=False)


PERTURBATIONS: Mapping[str, Perturbation] = {
    perturbation.name: perturbation
    for perturbation in (
        Perturbation("gyro_bias", 0.01, "deg/h", gyro=GYRO_BIAS),
        Perturbation("accelerometer_bias", 50.0, "ug", accelerometer=ACCELEROMETER_BIAS),
        Perturbation("both_biases", 1.0, "", gyro=GYRO_BIAS, accelerometer=ACCELEROMETER_BIAS),
        Perturbation("tilt", TILT, "rad", start=_tilted),
        Perturbation("speed", SPEED_ERROR, "m/s", start=_faster),
        Perturbation("course", COURSE_ERROR, "rad", start=_off_course),
    )
}
"""The errors whose effect is reported, by name."""


def response(subject: GyroscopicSubject, inputs: Inputs, start: Start, perturbation: Perturbation) -> Array:
    """Return the angle between the verticals of a subject with an error and without.

    Parameters
    ----------
    subject : callable
        ``f(inputs, start)``, a mapping with ``vertical``.
    inputs : Inputs
        Sensors without errors.
    start : Start
        Start without errors.
    perturbation : Perturbation

    Returns
    -------
    ndarray, shape (m + 1,)
        Angles, rad; R times as many metres.
    """
    undisturbed = subject(inputs, start)["vertical"]
    return angles_between(subject(perturbation.inputs(inputs), perturbation.start(start))["vertical"], undisturbed)


def growth_order(scales: Sequence[float], errors: Sequence[float]) -> float:
    """Return the power of the scale with which errors grow: the least-squares slope of their logarithms.

    Parameters
    ----------
    scales, errors : sequence of float
        Positive numbers, such as q = v/V and the largest error at that speed; two at least.

    Raises
    ------
    ValueError
        If there are fewer than two, or one is not positive.
    """
    x, y = np.asarray(scales, np.float64), np.asarray(errors, np.float64)
    if x.size < 2 or x.shape != y.shape or not ((x > 0).all() and (y > 0).all()):
        raise ValueError("two or more positive scales, and as many positive errors, are needed for an order of growth")
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


@dataclass(frozen=True)
class Oscillation:
    """An oscillation about a straight line, fitted to an error.

    Attributes
    ----------
    period : float
        s.
    amplitude : float
        In the unit of the error.
    residual : float
        Root mean square of what is left, relative to the amplitude.
    """

    period: float
    amplitude: float
    residual: float


def oscillation(time: Array, error: Array, shortest: float = 3000.0, longest: float = 8000.0) -> Oscillation:
    """Measure the period of an error: that with which b + c t + A cos wt + B sin wt fits best.

    Parameters
    ----------
    time, error : ndarray, shape (n,)
        s, any unit.
    shortest, longest : float
        Periods searched, s.

    Returns
    -------
    Oscillation

    Raises
    ------
    ValueError
        If the times span less than the longest period, which leaves a period undetermined.
    """
    from scipy.optimize import minimize_scalar

    span = float(time[-1] - time[0])
    if span < longest:
        raise ValueError(f"an error over {span:.9g} s cannot tell a period of up to {longest:.9g} s")
    scale = float(np.abs(error).max()) or 1.0
    x, y = (time - time[0]) / span, error / scale

    def fit(period: float) -> tuple[Array, Array]:
        angle = 2 * np.pi * span / period * x
        basis = np.column_stack([np.ones_like(x), x, np.cos(angle), np.sin(angle)])
        weights = np.linalg.lstsq(basis, y, rcond=None)[0]
        return weights, y - basis @ weights

    def misfit(period: float) -> float:
        return float(np.mean(fit(period)[1] ** 2))

    # The frequency resolution of the record is 1/span: several trial frequencies within each leave no valley unseen.
    trials = 1 / np.linspace(1 / longest, 1 / shortest, 2 + 8 * int(np.ceil(span * (1 / shortest - 1 / longest))))
    best = int(np.argmin([misfit(period) for period in trials]))
    bounds = trials[min(best + 1, len(trials) - 1)], trials[max(best - 1, 0)]
    # A misfit is flat at its minimum: a parabola through it is found to the square root of the rounding of its value.
    period = float(minimize_scalar(misfit, bounds=bounds, method="bounded", options={"xatol": 1e-7 * longest}).x)
    weights, left = fit(period)
    amplitude = float(np.hypot(weights[2], weights[3]))
    return Oscillation(period, amplitude * scale, float(np.sqrt(np.mean(left**2)) / amplitude))
