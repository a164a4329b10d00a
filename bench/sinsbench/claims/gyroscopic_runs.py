"""Runs on which the claims of Chelnokov 1991 are judged: proved axes of pendulums, and subjects on sampled motions.

Motions are cases of the tier ``paper`` of `gyro_systems`. Gyropendulum and bi-gyro of constant momentum are enclosed in
balls; every other system is run as a subject of `sinsbench.subjects.gyroscopic`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.claims.gyroscopic_states import case
from sinsbench.claims.quantities import Enclosure
from sinsbench.scoring.gyroscopic_errors import angles_between, inputs_of, rows_at, start_of, vertical_error
from sinsbench.scoring.gyroscopic_responses import PERTURBATIONS
from sinsbench.subjects.gyroscopic.contract import Inputs, Start
from sinsbench.subjects.gyroscopic.drivers import subject
from sinsbench.subjects.gyroscopic.systems import SYSTEMS
from sinsdata.truth.gyroscopic import GyroMotion, sampled
from sinsref.arithmetic import BallArithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.gyroscopic import Kinematics
from sinsref.gyroscopic_systems import bisector, enclosed_axes, usual_tuning
from sinsref.quaternion import conjugate, dot, rotate

Array = NDArray[np.float64]

HOUR, MINUTE = 3600, 60
BITS, ORDER, TOLERANCE = 128, 24, 1e-20
"""Of the enclosures: the axes stay within 1e-16, of which the smallest error of a family, 8e-9, keeps 7 digits."""
FAMILY_SCALES = ("1", "0.5", "0.25", "0.125")
"""Of the families TE and TP: the two slowest are where the next order adds least to an order of growth."""
SAMPLE, SAMPLES = 120, 60
"""Distance, s, and number of the instants at which their errors are looked at."""
SAMPLING: Mapping[str, tuple[str, str]] = {
    "T0": ("14400", "10"),
    "T3": ("14400", "5"),
    "T3_altitude": ("3600", "5"),
}
"""Duration and sampling interval of the motions that subjects run on, s: as long as errors are watched."""


# Proved


@dataclass(frozen=True)
class Pendulums:
    """A bi-gyro of the usual tuning at a time; the first of its axes is that of a single gyropendulum.

    Attributes
    ----------
    axis : list of 3 Number
        First axis along the velocity, to the left, up.
    bisector : list of 3 Number
        Resolved alike.
    speed : Number
        v, m/s.
    law : Number
        -(l m/H) v, rad.
    speed_error : Number
        Of the read-out V asin(|p - n|/2), m/s.
    """

    axis: list[Number]
    bisector: list[Number]
    speed: Number
    law: Number
    speed_error: Number


@cache
def pendulums(motion: str, start: str, interval: int, count: int) -> tuple[Pendulums, ...]:
    """Return enclosures of a bi-gyro at multiples 1 ... count of an interval, s.

    Parameters
    ----------
    motion : str
        Name of a case.
    start : {"paper", "rest"}
        At alpha = -(l m/H) v, or each axis where it would rest if v and w3 were constant.
    interval, count : int
    """
    with BallArithmetic(BITS) as balls:
        kinematics, found = Kinematics(balls, case(motion).model), []
        for k, row in enumerate(_axes(motion, interval, count), start=1):
            axes = row[:6] if start == "paper" else row[6:]
            place = kinematics.place(balls.number(interval * k))
            back = conjugate(kinematics.darboux(place))
            difference = [x - y for x, y in zip(axes[:3], axes[3:], strict=True)]
            scale, kappa = usual_tuning(balls, case(motion).model)
            speed = kinematics.speed(place)
            found.append(
                Pendulums(
                    rotate(back, axes[:3]),
                    rotate(back, bisector(balls, axes[:3], axes[3:])),
                    speed,
                    -kappa * speed,
                    scale * (balls.sqrt(dot(difference, difference)) / 2).asin() - speed,
                )
            )
    return tuple(found)


@cache
def _axes(motion: str, interval: int, count: int) -> list[list[Number]]:
    with BallArithmetic(BITS) as balls:
        model, unit = case(motion).model, balls.number(interval)
        return list(enclosed_axes(balls, model, unit, 1, count, order=ORDER, tolerance=TOLERANCE))


@cache
def largest_error(motion: str, error: str) -> Number:
    """Return the largest distance, a chord, at `SAMPLES` instants of two hours; call it at the precision of the balls.

    Parameters
    ----------
    motion : str
        Name of a case.
    error : {"law", "bisector", "bisector from rest"}
        Of the axis from the paper's law, or of the bisector from the vertical.
    """
    squares = []
    for at in pendulums(motion, "rest" if error == "bisector from rest" else "paper", SAMPLE, SAMPLES):
        x, y, z = at.axis if error == "law" else at.bisector
        sine, cosine = at.law.sin_cos() if error == "law" else (0, 1)
        chord = [x, y + sine, z - cosine]
        squares.append(dot(chord, chord))  # not by **, which knows no square of a ball centred at zero
    return reduce(lambda first, second: first.max(second), squares).sqrt()


def horizontal(vector: Sequence[Number]) -> Enclosure:
    """Return the angle between the vertical and a unit vector close to it, rad; call it at the precision of the balls.

    Where the balls contain zero it is bounded from both sides, as a square root of such a ball is none.
    """
    bounds = ([x.abs_lower() for x in vector[:2]], [x.abs_upper() for x in vector[:2]])
    lower, upper = (Enclosure.of((x[0] * x[0] + x[1] * x[1]).sqrt().asin()) for x in bounds)
    return Enclosure(lower.lower, upper.upper)


# Run


@cache
def truth(motion: str) -> GyroMotion:
    """Return a motion, sampled as `SAMPLING` says."""
    duration, interval = map(ExactNumber, SAMPLING[motion])
    return sampled(replace(case(motion), duration=duration, interval=interval))


@cache
def first_hour(motion: str) -> GyroMotion:
    """Return the first hour of a motion."""
    whole = truth(motion)
    left_out = len(whole.time) - 1 - round(HOUR / whole.interval)
    arrays: dict[str, Any] = {name: values for name, values in vars(whole).items() if isinstance(values, np.ndarray)}
    return replace(whole, **{name: values[: len(values) - left_out] for name, values in arrays.items()})


def run(system: str, motion: str, error: str = "", every: int = 1) -> dict[str, Array]:
    """Run a system for an hour through the points of a motion, with DOP853; what was run is kept.

    Parameters
    ----------
    system : str
        Name in `sinsbench.subjects.gyroscopic.systems.SYSTEMS`.
    motion : str
        Name in `SAMPLING`.
    error : str
        Name in `sinsbench.scoring.gyroscopic_responses.PERTURBATIONS`; none by default.
    every : int
        Of the points only every such one is given.
    """
    return _run(system, motion, error, every)


@cache
def _run(system: str, motion: str, error: str, every: int) -> dict[str, Array]:
    inputs, start = _given(first_hour(motion), motion, error)
    fewer = replace(
        inputs,
        time=inputs.time[::every],
        rate=inputs.rate[::every],
        specific_force=inputs.specific_force[::every],
        aids={name: values[::every] for name, values in inputs.aids.items()},
    )
    return subject(SYSTEMS[system], "dop853")(fewer, start)


def _given(known: GyroMotion, motion: str, error: str) -> tuple[Inputs, Start]:
    """Return sensors, with an error if one is named, and start of a motion."""
    model = case(motion)
    inputs, start = inputs_of(known), start_of(known, float(model.radius), float(model.gravity))
    return (PERTURBATIONS[error].inputs(inputs) if error else inputs), start


def error_of_the_vertical(system: str, motion: str) -> float:
    """Return the largest error of the vertical within an hour, rad."""
    return float(vertical_error(run(system, motion)["vertical"], first_hour(motion)).angle.max())


def error_of_the_speed(system: str, motion: str) -> float:
    """Return the largest error of the speed that a system tells within an hour, m/s."""
    speed = run(system, motion)["speed"]
    return float(np.abs(speed - rows_at(first_hour(motion).speed, len(speed))).max())


def error_of_the_run(system: str, motion: str, error: str = "") -> float:
    """Return a bound of what points at intervals change in the vertical within an hour, rad.

    A spline of degree 7 through points twice as far apart is 2^8 times farther off, and so is the run on it; half of
    that factor is left as a margin.
    """
    fine, coarse = (run(system, motion, error, every)["vertical"] for every in (1, 2))
    return float(angles_between(fine[::2], coarse).max()) / 2**7


def distance_under_errors(first: str, second: str, motion: str, error: str) -> float:
    """Return the largest angle within an hour between the verticals of two systems whose sensors err alike, rad."""
    return float(angles_between(*(run(system, motion, error)["vertical"] for system in (first, second))).max())


@cache
def largest_response(system: str, motion: str, error: str) -> float:
    """Return the largest angle, on full minutes of four hours, between verticals with an error and without it, rad."""
    angles = angles_between(_long_run(system, motion, error), _long_run(system, motion, ""))
    minutes = round((truth(motion).time[-1] - truth(motion).time[0]) / MINUTE)
    return float(rows_at(angles, minutes + 1).max())


@cache
def _long_run(system: str, motion: str, error: str) -> Array:
    # What a step of this length errs is the same with the error of an instrument and without it, to a part in 1e6.
    return subject(SYSTEMS[system])(*_given(truth(motion), motion, error))["vertical"]
