"""How gyroscopic systems answer to errors of the sensors and of the start."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring import gyroscopic as scores
from sinsbench.scoring.gyroscopic_errors import angles_between, inputs_of, rows_at
from sinsbench.scoring.gyroscopic_growth import expected_periods, oscillation
from sinsbench.scoring.rows import Field, plain_row
from sinsbench.scoring.running import RunError, run
from sinsbench.subjects.gyroscopic.contract import Inputs, Start
from sinsbench.subjects.gyroscopic.drivers import GyroscopicSubject
from sinsbench.subjects.gyroscopic.start_rules import rotated
from sinsbench.subjects.loading import LoadedSubject
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.gyroscopic import GyroMotion

__all__ = ["PERTURBATIONS", "RESPONSE_FIELDS", "Perturbation", "response", "score_responses"]

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


_SWINGS = 0.05
"""A period is told where no more is left beside the oscillation, relative to it, and it is no less of the response."""

RESPONSE_FIELDS = (
    *scores.FIELDS[:4],
    Field("status", "", "as in the scores"),
    Field("message", "", "as in the scores"),
    Field("error", "", "what is wrong: a name of `sinsbench.scoring.gyroscopic_responses.PERTURBATIONS`"),
    Field("size", "", "by how much, in `unit`"),
    Field("unit", "", "unit of the size"),
    *(
        Field(f"response_{name}_m", "m", f"R times the angle between the verticals, {text}")
        for name, text in scores.TIMES
    ),
    *(
        field
        for name, axis in (("along", "along the velocity at the start, kept in azimuth"), ("left", "to the left of it"))
        for field in (
            Field(f"period_{name}", "s", f"period of the response to an error of the start, {axis}, where it swings"),
            Field(f"expected_period_{name}", "s", "by theory (built-in systems at constant speed on a great circle)"),
        )
    ),
    Field("schuler_period", "s", "2 pi sqrt(R/g)"),
)


def score_responses(loaded: LoadedSubject, case: GyroCase, truth: GyroMotion) -> list[dict[str, Any]]:
    """Tell how a subject answers to errors of the instruments and of the start: one row an error.

    Parameters
    ----------
    loaded : LoadedSubject
        As for `sinsbench.scoring.gyroscopic.score_gyroscopic`.
    case : GyroCase
    truth : GyroMotion
        The case at one interval.

    Returns
    -------
    list of dict
        Rows with the fields `RESPONSE_FIELDS`: distances between the verticals with the error and without.
    """
    start = scores.start(case, truth)
    kept = {field.name for field in RESPONSE_FIELDS}
    common = {name: value for name, value in scores.identity(loaded, case, truth).items() if name in kept}
    common["schuler_period"] = scores.period_of(case)

    def vertical(perturbation: Perturbation) -> Array:
        inputs = perturbation.inputs(inputs_of(truth, increments=loaded.subject.takes == "increments"))
        result = run(loaded.function, (inputs, perturbation.start(start)), repetitions=0).result
        return scores.checked(result, len(truth.time) - 1)["vertical"]

    rows, undisturbed = [], None
    for perturbation in PERTURBATIONS.values():
        told = {**common, "error": perturbation.name, "size": perturbation.size, "unit": perturbation.unit}
        try:
            undisturbed = vertical(_NONE) if undisturbed is None else undisturbed
            disturbed = vertical(perturbation)
        except RunError as error:
            told |= {"status": error.status, "message": str(error)}
        else:
            time, angles = rows_at(truth.time, len(disturbed)), angles_between(disturbed, undisturbed)
            told |= {"status": "ok", **scores.at_hours("response", "m", time, angles, float(case.radius))}
            if not (perturbation.gyro or perturbation.accelerometer):  # a bias drives what it sets swinging
                told |= _periods(disturbed - undisturbed, truth, case)
                told |= expected_periods(loaded.subject.name, case)
        rows.append(plain_row(RESPONSE_FIELDS, told))
    return rows


_NONE = Perturbation("none", 0.0, "")


def _periods(difference: Array, truth: GyroMotion, case: GyroCase) -> dict[str, float]:
    """Return the periods of the parts of a response along the velocity at the start, and to the left of it."""
    count = len(difference)
    time, speed = rows_at(truth.time, count), rows_at(truth.speed, count)
    y1, y2 = (rotated(rows_at(truth.trihedron, count), axis) for axis in np.eye(3)[:2])
    force = rotated(rows_at(truth.attitude, count), rows_at(truth.specific_force, count))
    turn_rate = np.sum(force * y2, axis=1) / speed  # a_2 = v w3
    # Axes that turn with the velocity would mix the two oscillations.
    turned = np.append(0.0, np.cumsum((turn_rate[1:] + turn_rate[:-1]) / 2 * np.diff(time)))
    along, left = np.sum(difference * y1, axis=1), np.sum(difference * y2, axis=1)
    cosine, sine = np.cos(turned), np.sin(turned)
    periods, size = {}, np.linalg.norm(difference, axis=1).max()
    for name, values in (("along", cosine * along - sine * left), ("left", sine * along + cosine * left)):
        try:
            swing = oscillation(time, values, scores.period_of(case))
        except ValueError:  # a short motion
            continue
        if swing.residual < _SWINGS and swing.amplitude > _SWINGS * size:
            periods[f"period_{name}"] = swing.period
    return periods
