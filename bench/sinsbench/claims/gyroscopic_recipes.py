"""How the statements and equations of Chelnokov 1991 are recomputed.

The paper prints equations and says what holds of them; it prints no motion. Statements are judged on the motions of the
tier ``paper`` of the dataset ``gyro_systems``.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from sinsbench.claims import gyroscopic_runs as runs
from sinsbench.claims.gyroscopic_form_data import AS_PRINTED
from sinsbench.claims.gyroscopic_forms import holding, residuals
from sinsbench.claims.gyroscopic_states import case, residual_of_state
from sinsbench.claims.quantities import Enclosure, Quantity, hull
from sinsref.arithmetic import BallArithmetic

RATIO_DIGITS = 5
"""Decimals of a ratio of responses that the step of the runs leaves."""


def equation(*, place: str) -> Quantity:
    """Return the form of an equation that its definitions give, and what each form leaves of it, relative to it."""
    left = residuals(place)
    return Quantity(holding(left), "", findings={text: f"residual {size_of(value)}" for text, value in left.items()})


def equation_residual(*, place: str) -> Quantity:
    """Return what an equation leaves as it is printed, relative to it."""
    return Quantity(residuals(place)[AS_PRINTED], "")


def size_of(value: Enclosure) -> str:
    """Write a residual, or the bound within which it vanishes."""
    if not value.lower:
        return f"below {float(value.upper):.1e}"
    return " to ".join(dict.fromkeys(f"{float(end):.2g}" for end in (value.lower, value.upper)))


def residual(*, state: str, motions: Sequence[str]) -> Quantity:
    """Return what a state leaves of the equation of its system on motions, relative to it."""
    return Quantity(hull(*(residual_of_state(state, motion) for motion in motions)), "")


# Gyropendulums of constant momentum H = m l sqrt(g R), proved


def _after_an_hour(motion: str, start: str) -> runs.Pendulums:
    return runs.pendulums(motion, start, runs.HOUR, 2)[0]


def _metres(angle: Enclosure, motion: str) -> Quantity:
    radius = case(motion).radius.fraction
    if radius is None:
        raise ValueError(f"the radius of {motion} is not rational")
    return Quantity(angle * Enclosure.exact(radius), "m")


def axis_along_velocity(*, motion: str, start: str) -> Quantity:
    """Component along the velocity of a gyropendulum's axis after an hour, rad.

    Parameters
    ----------
    motion : str
        Name of a case.
    start : {"paper", "rest"}
        At alpha = -(l m/H) v, or where the axis would rest if v and w3 were constant.
    """
    with BallArithmetic(runs.BITS):
        return Quantity(Enclosure.of(_after_an_hour(motion, start).axis[0]), "rad")


def inclination_over_law(*, motion: str, start: str) -> Quantity:
    """Inclination of a gyropendulum after an hour in the plane across the velocity, over -(l m/H) v."""
    with BallArithmetic(runs.BITS):
        at = _after_an_hour(motion, start)
        return Quantity(Enclosure.of((-at.axis[1] / at.axis[2]).atan() / at.law), "")


def bisector_error(*, motion: str, start: str) -> Quantity:
    """Angle between bisector and vertical of a bi-gyro after an hour, m."""
    with BallArithmetic(runs.BITS):
        return _metres(runs.horizontal(_after_an_hour(motion, start).bisector), motion)


def speed_from_angle(*, motion: str, start: str) -> Quantity:
    """Error of the speed from half the angle between the axes times sqrt(g R), after an hour, m/s."""
    with BallArithmetic(runs.BITS):
        return Quantity(Enclosure.of(_after_an_hour(motion, start).speed_error), "m/s")


def order_in_speed(*, family: str, error: str) -> Quantity:
    """Order in q = v/sqrt(g R) with which the largest error of two hours vanishes, by the two slowest motions.

    Parameters
    ----------
    family : {"TE", "TP"}
    error : {"law", "bisector", "bisector from rest"}
        Distance of the axis from the paper's law, or of the bisector from the vertical.
    """
    with BallArithmetic(runs.BITS) as balls:
        faster, slower = (runs.largest_error(f"{family}_{scale}", error) for scale in runs.FAMILY_SCALES[-2:])
        return Quantity(Enclosure.of((faster / slower).log() / balls.number(2).log()), "")


# Subjects on sampled motions


def vertical_error(*, system: str, motion: str) -> Quantity:
    """Largest error of the vertical of a system within an hour of a motion, m; what the run itself errs is enclosed."""
    error, own = runs.error_of_the_vertical(system, motion), runs.error_of_the_run(system, motion)
    lower = max(Fraction(error) - Fraction(own), Fraction(0))
    return _metres(Enclosure(lower, Fraction(error) + Fraction(own)), motion)


def speed_error(*, system: str, motion: str) -> Quantity:
    """Largest error of the speed that a system tells within an hour of a motion, m/s."""
    return Quantity(Enclosure.exact(runs.error_of_the_speed(system, motion)), "m/s")


def distance_under_errors(*, system: str, other: str, motion: str) -> Quantity:
    """Largest distance within an hour between the verticals of two systems whose sensors err alike, m.

    The gyros by 0.01 deg/h, the accelerometers by 50e-6 * 9.81 m/s^2 on every axis; what the runs err is enclosed.
    """
    error = "both_biases"
    angle = Fraction(runs.distance_under_errors(system, other, motion, error))
    own = Fraction(sum(runs.error_of_the_run(name, motion, error) for name in (system, other)))
    return _metres(Enclosure(max(angle - own, Fraction(0)), angle + own), motion)


def response_ratio(*, system: str, errors: Sequence[str]) -> Quantity:
    """Largest response on full minutes of four hours to errors of the instruments, over the traditional system's.

    The value is the interval that holds the ratios for all of the errors on the motions T0 and T3.

    Parameters
    ----------
    system : str
        Name in `sinsbench.subjects.gyroscopic.systems.SYSTEMS`.
    errors : sequence of str
        Of "gyro_bias", "accelerometer_bias", "both_biases".
    """
    ratios = [
        runs.largest_response(system, motion, error) / runs.largest_response("trad", motion, error)
        for motion in ("T0", "T3")
        for error in errors
    ]
    return Quantity(hull(*(Enclosure.exact(round(Fraction(ratio), RATIO_DIGITS)) for ratio in ratios)), "")


RECIPES: Mapping[str, Callable[..., Quantity]] = {
    recipe.__name__: recipe
    for recipe in (
        equation,
        equation_residual,
        residual,
        axis_along_velocity,
        inclination_over_law,
        bisector_error,
        speed_from_angle,
        order_in_speed,
        vertical_error,
        speed_error,
        distance_under_errors,
        response_ratio,
    )
}
"""The recipes by name."""
