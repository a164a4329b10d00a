"""The paper's check of its solution against a numerical one, done again with known truth.

The paper integrates the error equations numerically under the initial errors (24) for two hours, and finds its
formulas (20)-(22) to differ by 5e-4 m/s in dv_H at 7200 s and far less elsewhere. Here every computation is measured
against the certified solution, so that each error is that of one computation.

Source: Loginov, Tkachenko, Chelnokov 2013, section 4.
"""

from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.errors import difference
from sinsbench.subjects import equator_formulas, equator_numerical, ode45
from sinsdata.cases import EquatorCase
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import EquatorTruth, equator_truth

Array = NDArray[np.float64]

#: Place of dv_H and dH in the state.
UP, HEIGHT = 1, 3

#: Significant digits to which the constants (17) are rounded, to see what rounded constants would do.
ROUNDED_CONSTANTS = (5, 6, 7, 8)

SOLVERS: dict[str, Callable[..., Array]] = {
    "equator_corrected": equator_formulas.corrected,
    "equator_printed": equator_formulas.printed,
    "ode45_1e-3": ode45.ode45_1e3,
    "ode45_1e-6": ode45.ode45_1e6,
    "ode45_1e-9": ode45.ode45_1e9,
    "ode45_1e-12": ode45.ode45_1e12,
    "ode45_tightest": ode45.ode45_tightest,
    "lsoda": equator_numerical.lsoda,
    "dop853": equator_numerical.dop853,
}
"""The computations that are subjects of the benchmark, by their names in its registry."""


_COLUMNS_AT_END = (
    "dv_north_end_m_per_s",
    "dv_up_end_m_per_s",
    "dv_east_end_m_per_s",
    "d_height_end_m",
    "d_latitude_end_rad",
    "d_longitude_end_rad",
)
"""Keys of the errors at the end, in the order of the state."""


@cache
def case() -> EquatorCase:
    """Return the case of (24): 600 m/s at 10 km for two hours."""
    return next(c for c in paper_cases("equator_errors") if isinstance(c, EquatorCase) and c.name == "fighter_check")


@cache
def truth() -> EquatorTruth:
    """Return its certified solution."""
    return equator_truth(case())


def _initial() -> Array:
    return np.array([float(x) for x in case().initial_errors])


@cache
def errors_of(name: str) -> Array:
    """Return the errors, computed minus true, of one of `SOLVERS` at the epochs of the case, shape (n, 6), SI."""
    given = case()
    computed = SOLVERS[name](truth().time, float(given.v_east), float(given.height), _initial())
    return np.asarray(difference(computed, truth().state, truth().state_lo))


def errors_of_rounded_constants(digits: int) -> Array:
    """Return the errors of the corrected (22) if its constants (17) are rounded to significant digits, shape (n, 6)."""
    given = case()
    constants = equator_formulas.modal_constants(float(given.v_east), float(given.height))
    rounded = {f.name: float(f"{getattr(constants, f.name):.{digits - 1}e}") for f in fields(constants)}
    matrix = equator_formulas._transition_matrix(truth().time, replace(constants, **rounded), "corrected")
    return np.asarray(difference(matrix @ _initial(), truth().state, truth().state_lo))


def orders_below_upward_velocity(differences: Array) -> tuple[float, float] | None:
    """Return by how many orders of magnitude the other components stay below dv_H: the least and the most.

    Each component counts with its largest absolute value over the interval, in SI units, as the paper compares them.

    Returns
    -------
    tuple of float, or None
        None if dv_H alone, or nothing, differs.
    """
    largest = np.abs(differences).max(axis=0)
    others = np.delete(largest, UP)
    if not largest[UP] or not others.any():
        return None
    orders = np.log10(largest[UP] / others[others > 0])
    return float(orders.min()), float(orders.max())


def row(name: str, errors: Array) -> dict[str, Any]:
    """Return one row of the story: errors at the end, the largest of dv_H with its instant, and two ratios.

    The orders of magnitude are those of the differences from the printed (22), which is what the paper looked at.
    """
    upward = np.abs(errors[:, UP])
    least, most = orders_below_upward_velocity(errors - errors_of("equator_printed")) or (None, None)
    return {
        "computation": name,
        **{column: float(x) for column, x in zip(_COLUMNS_AT_END, errors[-1], strict=True)},
        "dv_up_largest_m_per_s": float(upward.max()),
        "instant_of_largest_s": float(truth().time[upward.argmax()]),
        "height_to_velocity_end_s": float(abs(errors[-1, HEIGHT] / errors[-1, UP])),
        "orders_below_least": least,
        "orders_below_most": most,
    }


def extremes(errors: Array) -> list[float]:
    """Return the instants, s, at which the size of the error of dv_H has a local maximum."""
    upward = np.abs(errors[:, UP])
    peaks = (upward[1:-1] > upward[:-2]) & (upward[1:-1] >= upward[2:])
    return [float(t) for t in truth().time[1:-1][peaks]]


def largest_over_signs() -> float:
    """Return the largest error of dv_H at the end by the printed (22), m/s, over all signs of the initial errors."""
    given = case()
    end = truth().time[-1:]
    printed, corrected = (
        equator_formulas.transition_matrix(end, float(given.v_east), float(given.height), edition)[0, UP]
        for edition in ("printed", "corrected")
    )
    return float(np.abs((printed - corrected) * _initial()).sum())


def growth_length() -> float:
    """Return 1/beta3, s: the ratio of dH to dv_H in the growing mode."""
    given = case()
    return 1 / equator_formulas.modal_constants(float(given.v_east), float(given.height)).beta3
