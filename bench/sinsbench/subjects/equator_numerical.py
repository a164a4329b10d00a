"""The equator error equations solved numerically: the matrix exponential and SciPy's integrators.

The equations are (9) with the forcing (8) of Loginov, Tkachenko, Chelnokov 2013.  Integrators start at t = 0
and give the requested instants by their own continuous extension, as a user would get them.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm as matrix_exponential

from sinsbench.subjects.equator_model import (
    EquatorCase,
    EquatorMotion,
    FloatArray,
    forcing_matrix,
    harmonics,
    solver,
)

RELATIVE_TOLERANCE = 100 * float(np.finfo(np.float64).eps)
"""The smallest relative tolerance SciPy accepts."""
ABSOLUTE_TOLERANCE = 1e-24
"""In the natural unit of each component, `EquatorMotion.state_scale`.

It acts on errors that start at zero, and lies below the relative tolerance of every error above 1e-10 of that
unit (0.6 mm of height)."""

RightHandSide = Callable[[float, FloatArray], FloatArray]


def right_hand_side(case: EquatorCase) -> RightHandSide:
    """X'(t, X) = A X + b(t), eqs. (8)-(10), of a case."""
    matrix = case.motion.matrix()
    if case.misalignment is None:
        return lambda _, state: matrix @ state
    coefficients = case.motion.specific_force * forcing_matrix(case.misalignment)
    start, rate = case.inertial_longitude, case.motion.inertial_rate
    return lambda time, state: matrix @ state + coefficients @ harmonics(start + rate * time)


def exponential_transition(time: FloatArray, motion: EquatorMotion) -> FloatArray:
    """P(t) = exp(A t) by scaling and squaring in natural units, shape (n, 6, 6); singular nowhere."""
    scale = motion.state_scale
    scaled = motion.matrix() * (scale / scale[:, None])
    result: FloatArray = matrix_exponential(time[:, None, None] * scaled) * (scale[:, None] / scale)
    return result


def exponential_solution(case: EquatorCase) -> FloatArray:
    """Solve a case by one exponential for each instant, shape (n, 6); singular nowhere.

    Under a misalignment the state is augmented by 1, cos th, sin th, cos 2th, sin 2th, which makes the
    equations homogeneous.
    """
    if case.misalignment is None:
        return exponential_transition(case.time, case.motion) @ case.initial_errors
    scale, rate = case.motion.state_scale, case.motion.inertial_rate
    generator = np.zeros((11, 11))
    generator[:6, :6] = case.motion.matrix() * (scale / scale[:, None])
    generator[:6, 6:] = case.motion.specific_force * forcing_matrix(case.misalignment) / scale[:, None]
    generator[7, 8], generator[8, 7] = -rate, rate
    generator[9, 10], generator[10, 9] = -2 * rate, 2 * rate
    start = np.concatenate([case.initial_errors / scale, harmonics(case.inertial_longitude)])
    result: FloatArray = (matrix_exponential(case.time[:, None, None] * generator) @ start)[:, :6] * scale
    return result


@solver
def expm(case: EquatorCase) -> FloatArray:
    """SciPy.linalg.expm of the equations in natural units, augmented by the harmonics of the forcing."""
    return exponential_solution(case)


def _integrate(case: EquatorCase, method: Literal["RK45", "DOP853", "Radau", "LSODA"]) -> FloatArray:
    instants, inverse = np.unique(case.time, return_inverse=True)
    if instants.size == 0 or instants[-1] == 0:
        return np.tile(case.initial_errors, (case.time.size, 1))
    options = {"jac": lambda _, __: case.motion.matrix()} if method in ("Radau", "LSODA") else {}
    solution = solve_ivp(
        right_hand_side(case),
        (0.0, instants[-1]),
        case.initial_errors,
        method=method,
        t_eval=instants,
        rtol=RELATIVE_TOLERANCE,
        atol=ABSOLUTE_TOLERANCE * case.motion.state_scale,
        **options,
    )
    if not solution.success:
        raise RuntimeError(f"{method} stopped: {solution.message}")
    result: FloatArray = solution.y.T[inverse]
    return result


@solver
def rk45(case: EquatorCase) -> FloatArray:
    """SciPy's RK45 (Dormand, Prince 5(4)) at the tightest tolerances it accepts."""
    return _integrate(case, "RK45")


@solver
def dop853(case: EquatorCase) -> FloatArray:
    """SciPy's DOP853 (Dormand, Prince 8(5,3)) at the tightest tolerances it accepts."""
    return _integrate(case, "DOP853")


@solver
def radau(case: EquatorCase) -> FloatArray:
    """SciPy's Radau (Radau IIA of order 5) at the tightest tolerances it accepts."""
    return _integrate(case, "Radau")


@solver
def lsoda(case: EquatorCase) -> FloatArray:
    """SciPy's LSODA (Adams and backward differentiation) at the tightest tolerances it accepts."""
    return _integrate(case, "LSODA")
