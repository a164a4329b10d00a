"""Defects planted one at a time in the equator subjects must be seen by a comparison with truth.

Every number, every coefficient of a table, every sum, difference and product of the modules is changed in its
turn.  Truth is the exponential of the equations in ball arithmetic, which shares nothing with the formulas.
"""

import ast
from fractions import Fraction
from functools import cache
from typing import ClassVar

import numpy as np
import pytest

import equator_truth
from equator_truth import NO_MISALIGNMENT
from mutants import Planter, load, source, survivors
from sinsbench.subjects import equator_formulas, equator_robust, ode45
from sinsbench.subjects.equator_model import EquatorMotion, NotApplicableError

INITIAL = (0.01, -0.02, 0.015, 1.0, 3e-7, 1.57e-7)
LAMBDA = ((1e-5, 7e-5, -5e-5), (2e-5, 3e-5, 4e-5), (-3e-5, 6e-5, -2e-5))
LONGITUDE = 0.7


def truth(v_east, height, times, initial, misalignment=NO_MISALIGNMENT):
    """The state at `times`, one row an instant, rounded to float64."""
    states = (equator_truth.state(v_east, height, t, tuple(initial), misalignment, LONGITUDE) for t in times)
    return np.array([[float(x) for x in state] for state in states])


def agrees(solver, v_east, height, times, tolerance, initial=INITIAL, misalignment=NO_MISALIGNMENT):
    forced = {} if misalignment is NO_MISALIGNMENT else {"misalignment": misalignment}
    actual = solver(times, v_east, height, initial, inertial_longitude=LONGITUDE, **forced)
    expected = truth(v_east, height, times, initial, misalignment)
    # Component by component, each against its own largest value of the run.
    return bool((np.abs(actual - expected) <= tolerance * np.abs(expected).max(axis=0)).all())


def refuses(solver, v_east, sentence, misalignment=None):
    try:
        solver((1.0,), v_east, 0.0, INITIAL, misalignment)
    except NotApplicableError as error:
        return sentence in str(error)
    return False


STATIONARY = -7.29e-5 * 6378245.0
V_MAX = 7446.951262516
EARLY, LATE = (0.5, 20.0, 75.0, 80.0, 85.0, 500.0), (1500.0, 3600.0, 7200.0)
PAPER = (0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7)  # the initial errors (24)
RIGHT_HALF_PLANE = (0.01, -0.01, 0.01, -1.0, -1e-7, 1e-7)  # every phase within pi/2 of zero
NORTH = (0.01, 0.0, 0.0, 0.0, 0.0, 0.0)


def formulas_hold(module):
    # 1e-9 is far above the rounding of the formulas at these motions and far below any planted defect.
    for solver in (module.corrected, module.general_solution, module.amplitude_phase):
        for misalignment in (NO_MISALIGNMENT, LAMBDA):
            if not agrees(solver, 600.0, 1e4, LATE, 1e-9, misalignment=misalignment):
                return False
    for initial in (RIGHT_HALF_PLANE, NORTH):
        if not agrees(module.amplitude_phase_printed, 10.0, 0.0, LATE, 1e-9, initial):
            return False
    # The opposite errors have the same tangents: the principal value leaves dv_N and dphi as they were.
    opposite = [-error for error in RIGHT_HALF_PLANE]
    turned = module.amplitude_phase_printed(LATE, 10.0, 0.0, opposite)[:, [0, 4]]
    exact = truth(10.0, 0.0, LATE, RIGHT_HALF_PLANE)[:, [0, 4]]
    if not np.allclose(turned, exact, rtol=1e-9, atol=0):
        return False
    # The printed matrix lacks half of the oscillation of dv_H, and nothing else.
    modes = module.modal_constants(600.0, 1e4)
    *_, C5, C6 = module.integration_constants(modes, INITIAL)
    angle = modes.mu * np.array(LATE)
    missing = modes.mu * (C5 * np.sin(angle) - C6 * np.cos(angle)) / 2
    difference = module.printed(LATE, 600.0, 1e4, INITIAL) - truth(600.0, 1e4, LATE, INITIAL)
    return (
        np.allclose(difference[:, 1], missing, rtol=1e-6, atol=0)
        and refuses(module.corrected, STATIONARY, "omega_N")
        and refuses(module.corrected, weightless_speed(), "divide by a_H")
        and refuses(module.corrected, resonant_speed(), "resonance", LAMBDA)
        and refuses(module.corrected, 8000.0, "complex")
        and refuses(module.corrected, 7700.0, "not real")
        and refuses(module.printed, 600.0, "prints no response", LAMBDA)
    )


@cache
def exact_zero(near, quantity):
    """The speed nearest to `near`, at H = 0, at which `quantity` of the motion is zero in float64."""
    speeds = near + np.arange(-400, 401) * np.spacing(near)
    zeros = [v for v in speeds if quantity(EquatorMotion.at(v, 0.0)) == 0]
    return float(min(zeros, key=lambda v: abs(v - near)))


def weightless(motion):
    return motion.specific_force


def resonance(motion):
    return motion.schuler_rate**2 - motion.inertial_rate**2


def weightless_speed():
    rate = np.sqrt(7.29e-5**2 + 9.78049 / 6378245.0)
    return exact_zero(6378245.0 * (rate - 7.29e-5), weightless)


def resonant_speed():
    return exact_zero(6378245.0 * (np.sqrt(9.78049 / 6378245.0) - 7.29e-5), resonance)


def robust_holds(module):
    # Tighter than the exponential (3e-13 at 600 m/s), so that using it without need is seen.
    for misalignment in (NO_MISALIGNMENT, LAMBDA):
        if not agrees(module.robust, 600.0, 1e4, LATE, 3e-14, misalignment=misalignment):
            return False
    # Elements as small as t^3 must keep their digits, or the series was not used in time.
    for column in range(6):
        unit = tuple(np.eye(6)[column])
        exact = truth(600.0, 1e4, EARLY, unit)
        matrix = module.transition_matrix(EARLY, 600.0, 1e4)[:, :, column]
        if not np.allclose(matrix, exact, rtol=2e-15, atol=0):
            return False
    cases = [(v, 1e3, 1e-11) for v in (7433.27647, -8363.224591, 7700.0, -8380.0, 2 * STATIONARY, STATIONARY)]
    cases += [(v, 0.0, 1e-11) for v in (V_MAX - 1e-6, weightless_speed(), 7941.571244, 8000.0, 12000.0)]
    cases += [(v, 0.0, 1e-11) for v in (STATIONARY, 3644.262041, -4574.210162)]
    # Far enough from the poles of the particular solution to evaluate it, too near to keep its digits.
    cases += [(3644.272, 0.0, 5e-13)]
    # a_24 + 2 omega_N v/R = omega_N^2 + 2 g/R - u^2 vanishes only above 46,000 km, where motion is slow.
    radius = 7e7
    rate = np.sqrt(7.29e-5**2 - 2 * 9.78049 * 6378245.0**2 / radius**3)
    for speed in ((rate - 7.29e-5) * radius, (rate - 7.29e-5) * radius * (1 + 1e-6)):
        place = (speed, radius - 6378245.0)
        if not agrees(module.robust, *place, (20000.0, 86400.0), 1e-12, misalignment=LAMBDA):
            return False
    return all(
        agrees(module.robust, v_east, height, times, tolerance, misalignment=misalignment)
        for v_east, height, tolerance in cases
        for misalignment in (NO_MISALIGNMENT, LAMBDA)
        for times in (EARLY[:3], LATE)
    )


def ode45_holds(module):
    matrix = EquatorMotion.at(600.0, 1e4).matrix()
    for relative, steps in ((1e-3, 14), (1e-6, 59)):
        if module.ode45(lambda _, y: matrix @ y, (0.0, 7200.0), PAPER, relative, 1e-6).steps != steps:
            return False
    instants = np.linspace(0.0, 7200.0, 50)
    result = module.ode45(lambda _, y: matrix @ y, instants, PAPER, 1e-6, 1e-9)
    expected = truth(600.0, 1e4, tuple(instants), PAPER)
    return bool((np.abs(result.state - expected) <= 1e-5 * np.abs(expected).max(axis=0)).all())


NAMES = ("beta3", "mu", "nu", "alpha33", "alpha35", "alpha63")
NEXT = {"odd": "even", "even": "odd"} | dict(zip(NAMES, (*NAMES[1:], NAMES[0]), strict=True))


class TablePlanter(Planter):
    """* and / change places too; floats grow by 1 %, fractions in strings by 1/100, named factors are exchanged."""

    operators: ClassVar = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}

    def changed(self, value):
        if type(value) is int:
            return value + 1
        if type(value) is float:
            return value * 1.01 or 1.0
        if value in NEXT or not isinstance(value, str):
            return NEXT.get(value)
        try:
            return str(Fraction(value) + Fraction(1, 100))
        except ValueError:
            return None


# Where the robust form hands over to the series or to the exponential both are accurate to the tolerances of
# `robust_holds`, so that a threshold 1 % off, or one more term of the series, changes no digit that counts.
EQUIVALENT = ("DOUBLE_ROOT", "SERIES_LIMIT", "SERIES_TERMS", "CANCELLATION")


@pytest.mark.parametrize(
    ("module", "holds", "chosen", "least"),
    [
        (equator_formulas, formulas_hold, lambda name: True, 400),
        (equator_robust, robust_holds, lambda name: name not in EQUIVALENT, 200),
        (ode45, ode45_holds, {"STAGES", "EMBEDDED", "INTERPOLANT"}.__contains__, 56),
    ],
    ids=["formulas", "robust", "ode45"],
)
def test_every_planted_defect_is_seen(module, holds, chosen, least):
    assert holds(load(source(module), module))
    unseen, planted = survivors(module, holds, TablePlanter, chosen)
    assert unseen == []
    assert planted >= least


def test_equivalents_are_equivalent():
    unseen, planted = survivors(equator_robust, robust_holds, TablePlanter, EQUIVALENT.__contains__)
    assert len(unseen) == planted == len(EQUIVALENT)
