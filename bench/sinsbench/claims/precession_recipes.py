"""How the numbers of Lebedev, Panov 1989 are recomputed: the algorithms run in binary64 on certified increments.

Variants that share a printed number are all run; the value is the interval that holds their results.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from sinsbench.claims.precession_runs import FinalErrors, case, errors, scaled_errors
from sinsbench.claims.quantities import Enclosure, Quantity, hull
from sinsbench.scoring.asymptotics import predicted_error

#: What binary64 may change in a final error on these motions, against a run in 50 digits: deg/h and m/s.
DRIFT_ROUNDING, VELOCITY_ROUNDING = "3e-10", "5e-10"


def _enclosed(values: Sequence[float], rounding: str) -> Enclosure:
    margin = Enclosure.exact(rounding).upper
    parts = [Enclosure.exact(value) for value in values]
    return hull(*(Enclosure(part.lower - margin, part.upper + margin) for part in parts))


def _deg_per_h(angle: float, duration: float) -> float:
    return float(np.rad2deg(angle) * 3600 / duration)


def _drift(run: Callable[..., FinalErrors], order: str, motion: str, variants: Sequence[str]) -> Quantity:
    values = [
        _deg_per_h(float(np.linalg.norm(run(order, variant, motion).attitude)), float(case(variant, motion).duration))
        for variant in variants
    ]
    return Quantity(_enclosed(values, DRIFT_ROUNDING), "deg/h")


def drift(*, order: str, motion: str, variants: Sequence[str]) -> Quantity:
    """Angle between the computed and the true attitude at the end, over the time, deg/h.

    The end is a whole number of periods, so that the constant part of the drift rate alone is left.
    """
    return _drift(errors, order, motion, variants)


def drift_with_scaled_rotation(*, order: str, motion: str, variants: Sequence[str]) -> Quantity:
    """Drift as in `drift` with the scale error that the velocities suggest."""
    return _drift(scaled_errors, order, motion, variants)


def asymptotic_drift(*, order: str, motion: str, variants: Sequence[str]) -> Quantity:
    """Drift by the leading term of the accumulated error, section 5, corrected, deg/h."""
    values = []
    for variant in variants:
        given = case(variant, motion)
        duration = float(given.duration)
        predicted = predicted_error(given.motion, int(order), float(given.interval), [duration])
        values.append(_deg_per_h(float(np.linalg.norm(predicted.attitude[0])), duration))
    return Quantity(_enclosed(values, DRIFT_ROUNDING), "deg/h")


def velocity_error(*, order: str, motion: str, variants: Sequence[str], axes: str) -> Quantity:
    """Euclidean norm of the error of the apparent velocity in body or inertial axes at the end, m/s."""
    values = [errors(order, variant, motion).velocity(axes) for variant in variants]
    return Quantity(_enclosed(values, VELOCITY_ROUNDING), "m/s")


def velocity_error_with_scaled_rotation(*, order: str, motion: str, variants: Sequence[str], axes: str) -> Quantity:
    """`velocity_error` if every rotation vector is scaled by the one factor that fits the table best."""
    values = [scaled_errors(order, variant, motion).velocity(axes) for variant in variants]
    return Quantity(_enclosed(values, VELOCITY_ROUNDING), "m/s")


RECIPES: Mapping[str, Callable[..., Quantity]] = {
    recipe.__name__: recipe
    for recipe in (
        drift,
        drift_with_scaled_rotation,
        asymptotic_drift,
        velocity_error,
        velocity_error_with_scaled_rotation,
    )
}
"""The recipes by name."""
