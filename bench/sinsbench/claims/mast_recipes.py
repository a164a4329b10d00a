"""How the numbers, statements and equations of Sokolov, Pogorelov, Reshetnikova 2024 are recomputed."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sinsbench.claims import mast_runs as runs
from sinsbench.claims.gyroscopic_forms import holding
from sinsbench.claims.gyroscopic_recipes import size_of
from sinsbench.claims.mast_forms import residuals
from sinsbench.claims.quantities import Enclosure, Quantity
from sinsbench.scoring.mast_errors import QUANTITIES

__all__ = ["RECIPES"]

Array = NDArray[np.float64]

_UNCHANGED = "seed_1000"
"""A case of the tier ``standard`` with the paper's motion."""
_DIGITS = 6
"""Significant digits of a figure that a run leaves: compilers differ in the last ones of binary64."""


def _figure(value: float, unit: str, otherwise: str) -> Quantity:
    """Return a number as a quantity, or a word in place of infinity."""
    if not np.isfinite(value):
        return Quantity(otherwise, unit)
    return Quantity(Enclosure.exact(Fraction(f"{value:.{_DIGITS - 1}e}")), unit)


def _largest(time: Array, values: Array, after: float) -> float:
    return float(np.abs(values[time >= after]).max())


def equation(*, place: str) -> Quantity:
    """Return the form of an equation that its definitions give, and what each form leaves of it, relative to it."""
    left = residuals(place)
    return Quantity(holding(left), "", findings={text: f"residual {size_of(value)}" for text, value in left.items()})


def component_error(*, turn: str, estimator: str, case: str, after: float) -> Quantity:
    """Largest error of the four numbers of a quaternion from a time on.

    Parameters
    ----------
    turn : {"mu", "eta", "lambda"}
    estimator : str
        Name in `sinsbench.subjects.mast.catalogue.SUBJECTS`.
    case : str
        Name of a case; they are run as long as `sinsbench.claims.mast_runs.DURATIONS` says.
    after : float
        s.
    """
    run = runs.run(estimator, case)
    return _figure(_largest(run.time, run.components(turn), after), "", "breaks down")


def settling_time(*, turn: str, limit: str, estimator: str, case: str) -> Quantity:
    """Time from which on the errors of a quaternion's numbers stay below a limit, s, or ``never``."""
    run = runs.run(estimator, case)
    return _figure(runs.settled(run.time, run.components(turn), float(limit)), "s", "never")


def angle_error(*, turn: str, angle: str, end: str, after: float, estimator: str, case: str) -> Quantity:
    """Least or greatest error of an angle from a time on, rad.

    Parameters
    ----------
    turn : {"mu", "eta", "lambda"}
    angle : str
        One of `sinsbench.claims.mast_runs.ANGLES`.
    end : {"least", "greatest"}
    after, estimator, case
        As for `component_error`.
    """
    error = _angle_errors(turn, estimator, case)[angle][runs.run(estimator, case).time >= after]
    return _figure(float(error.min() if end == "least" else error.max()), "rad", "breaks down")


@cache
def _angle_errors(turn: str, estimator: str, case: str) -> Mapping[str, Array]:
    run = runs.run(estimator, case)
    given, true = (runs.angles(values[turn]) for values in (run.estimated, run.true))
    return {name: (given[name] - true[name] + np.pi) % (2 * np.pi) - np.pi for name in runs.ANGLES}


def error(*, of: str, estimator: str, case: str, after: float) -> Quantity:
    """Largest error from a time on: of a name in `sinsbench.scoring.mast_errors.QUANTITIES`, in its unit."""
    run = runs.run(estimator, case)
    return _figure(_largest(run.time, run.errors[of], after), QUANTITIES[of][0], "breaks down")


def increase(*, of: str, changes: Sequence[str], estimator: str) -> Quantity:
    """Median over seeds of the increase of an error with another motion of the mast, per cent: the largest of several.

    Parameters
    ----------
    of : str
        As for `error`; root mean squares of `sinsbench.claims.mast_runs.changed_sizes`, each relative to that of the
        paper's motion with the same noise and initial errors.
    changes : sequence of str
        Cases of the strata ``mast_amplitude`` and ``mast_frequency`` of the tier ``standard``.
    estimator : str
    """
    same = runs.changed_sizes(estimator, _UNCHANGED)[of]
    increases = {change: 100 * (runs.changed_sizes(estimator, change)[of] / same - 1) for change in changes}
    told = {
        change: f"{np.median(values):.2g} %, {values.min():.2g} to {values.max():.2g} with single seeds"
        for change, values in increases.items()
    }
    largest = max(float(np.median(values)) for values in increases.values())
    return Quantity(_figure(largest, "%", "breaks down").value, "%", findings=told)


def convergence(*, estimator: str, case: str, duration: str) -> Quantity:
    """Return whether the errors of the attitudes of vehicle and antenna become less than those of the start.

    The word is ``converges``, ``breaks down`` where the filter stops, or ``diverges`` where in the second half of the
    run an error exceeds that of the start.
    """
    run = runs.run(estimator, case, duration)
    late = run.time >= float(duration) / 2
    if run.stopped:
        return Quantity("breaks down", "", findings={"filter": run.stopped})
    grown = {name: float(run.errors[name][late].max()) for name in ("mu", "nu")}
    told = ", ".join(f"{name} within {value:.2g} rad" for name, value in grown.items())
    small = all(value < run.errors[name][0] for name, value in grown.items())
    return Quantity("converges" if small else "diverges", "", findings={"second half": told})


def nis_over_freedom(*, estimator: str) -> Quantity:
    """Normalised innovations squared over their degrees of freedom in the first 100 s of N4_G3; about 1 if all is well.

    ``beyond binary64`` where they leave its range.
    """
    return _figure(runs.nis_ratio(estimator, "N4_G3"), "", "beyond binary64")


RECIPES: Mapping[str, Callable[..., Quantity]] = {
    recipe.__name__: recipe
    for recipe in (
        equation,
        component_error,
        settling_time,
        angle_error,
        error,
        increase,
        convergence,
        nis_over_freedom,
    )
}
"""The recipes by name."""
