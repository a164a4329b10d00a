"""Compiled drivers with fixed step: any right-hand side of `sinsbench.subjects.gyroscopic.equations`, one loop each.

The full state is the attitude s of the vehicle, X -> xi, and behind it the state of the system. A step reads the
sensors at its start, its middle and its end: the rates Omega_xi, the specific force a_xi and the aiding inputs, each
of shape (steps, 3, columns).

A right-hand side arrives as a pointer to a compiled function, so that a driver is compiled once for all systems.
"""

import functools
import inspect
from typing import Any

import numpy as np
from numba import njit, typeof, types
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic import equations
from sinsbench.subjects.gyroscopic.equations import Condition, Constants, RightHandSide, put, quaternion, vector
from sinsbench.subjects.kernels import (
    Quaternion,
    add_compensated,
    compiled,
    quaternion_product,
    rotate,
    rotation_quaternion,
    scale,
)
from sinsbench.subjects.rotation_vector_methods import PANOV_4, binary64_coefficients

__all__ = ["FIXED_STEP", "compiled_run", "component_slopes", "function_pointer"]

Array = NDArray[np.float64]

ELEMENTARY = binary64_coefficients(PANOV_4)
"""Power series that replace sine and cosine of a small rotation; the other coefficients are not used."""

COMMUTATOR_FREE = (
    (1 / 2, 0.0, 0.0, 0.0),
    (0.0, 1 / 2, 0.0, 0.0),
    (-1 / 2, 0.0, 1.0, 0.0),
    (1 / 4, 1 / 6, 1 / 6, -1 / 12),
    (-1 / 12, 1 / 6, 1 / 6, 1 / 4),
)
"""Weights of the four slopes in the exponentials of Celledoni, Marthinsen, Owren 2003: those that lead from the state
to the second stage and the third, from the second stage to the fourth, and from the state through two to the end."""


@compiled
def put_quaternion(state: Array, first: int, value: Quaternion) -> None:
    """Write a quaternion to a state from an index on."""
    state[first] = value[0]
    state[first + 1] = value[1]
    state[first + 2] = value[2]
    state[first + 3] = value[3]


@compiled
def rates(
    right_hand_side: RightHandSide,
    state: Array,
    rotation_rate: Array,
    force: Array,
    aid: Array,
    constants: Constants,
    rate: Array,
) -> None:
    """Rates of the full state: Omega_xi of (1.14), then those of the system under a_X = s o a_xi o s~, (2.8)."""
    put(rate, 0, vector(rotation_rate, 0))
    right_hand_side(state[4:], rotate(quaternion(state, 0), vector(force, 0)), aid, constants, rate[3:])


@compiled
def component_slopes(state: Array, rate: Array, quaternions: int, slope: Array) -> None:
    """Turn the rates of a full state into derivatives of its components: 2 s' = s o Omega_xi and 2 q' = rate o q."""
    x, y, z = scale(0.5, vector(rate, 0))
    put_quaternion(slope, 0, quaternion_product(quaternion(state, 0), (0.0, x, y, z)))
    for k in range(1, quaternions + 1):
        x, y, z = scale(0.5, vector(rate, 3 * k))
        put_quaternion(slope, 4 * k, quaternion_product((0.0, x, y, z), quaternion(state, 4 * k)))
    for i in range(4 * (quaternions + 1), state.size):
        slope[i] = rate[i - (quaternions + 1)]


@compiled
def moved(state: Array, change: Array, quaternions: int, result: Array) -> None:
    """Turn the quaternions of a full state by rotation vectors, each from the side of its rate; add to the numbers."""
    turn = rotation_quaternion(vector(change, 0), ELEMENTARY)
    put_quaternion(result, 0, quaternion_product(quaternion(state, 0), turn))
    for k in range(1, quaternions + 1):
        turn = rotation_quaternion(vector(change, 3 * k), ELEMENTARY)
        put_quaternion(result, 4 * k, quaternion_product(turn, quaternion(state, 4 * k)))
    for i in range(4 * (quaternions + 1), state.size):
        result[i] = state[i] + change[i - (quaternions + 1)]


@compiled
def copied(values: Array, result: Array) -> None:
    """Copy an array; a loop compiles several times faster than what numba makes of a slice."""
    for i in range(values.size):
        result[i] = values[i]


@compiled
def combined(slopes: Array, weights: Quaternion, step: float, change: Array) -> None:
    """Write the step times the weighted sum of four slopes."""
    for i in range(change.size):
        change[i] = step * (
            weights[0] * slopes[0, i]
            + weights[1] * slopes[1, i]
            + weights[2] * slopes[2, i]
            + weights[3] * slopes[3, i]
        )


def classical_run(
    right_hand_side: RightHandSide,
    condition: Condition,
    quaternions: int,
    start: Array,
    rotation_rate: Array,
    force: Array,
    aid: Array,
    step: float,
    constants: Constants,
    states: Array,
) -> int:
    """Run the classical Runge-Kutta method of order 4 on the components.

    Sums are compensated (Kahan): at 100 Hz the rounding of the sums would otherwise outgrow the error of the method.
    The method lowers the norm of a quaternion, and with it the specific force that the quaternion turns: a step of
    Newton's iteration after each step brings the norm back to 1.

    Parameters
    ----------
    right_hand_side, condition : compiled function
        Of one system.
    quaternions : int
        Number of quaternions at the head of its state.
    start : ndarray, shape (4 + n,)
        Full state at the start.
    rotation_rate, force, aid : ndarray, shape (steps, 3, columns)
        Sensors and aiding inputs at start, middle and end of each step.
    step : float
        Length of a step, s.
    constants : Constants
    states : ndarray, shape (steps + 1, 4 + n)
        Receives the states.

    Returns
    -------
    int
        -1, or the row of the first state that breaks the condition, after which nothing is computed.
    """
    n = start.size
    state, carry, trial, rate = start.copy(), np.zeros(n), np.empty(n), np.empty(n)
    slopes = np.empty((4, n))
    copied(state, states[0])
    if not condition(state[4:], aid[0, 0], constants) > 0.0:
        return 0
    for k in range(len(force)):
        copied(state, trial)
        for stage in range(4):
            point = (stage + 1) // 2
            slope = slopes[stage]
            rates(right_hand_side, trial, rotation_rate[k, point], force[k, point], aid[k, point], constants, rate)
            component_slopes(trial, rate, quaternions, slope)
            distance = step if stage == 2 else 0.5 * step
            for i in range(n):
                trial[i] = state[i] + distance * slope[i]
        for i in range(n):
            change = step / 6.0 * (slopes[0, i] + 2.0 * (slopes[1, i] + slopes[2, i]) + slopes[3, i])
            state[i], carry[i] = add_compensated(state[i], carry[i], change)
        for j in range(quaternions + 1):
            q = quaternion(state, 4 * j)
            excess = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0
            for i in range(4 * j, 4 * j + 4):
                state[i], carry[i] = add_compensated(state[i], carry[i], -0.5 * excess * state[i])
        copied(state, states[k + 1])
        if not condition(state[4:], aid[k, 2], constants) > 0.0:  # NaN breaks it too
            return k + 1
    return -1


def commutator_free_run(
    right_hand_side: RightHandSide,
    condition: Condition,
    quaternions: int,
    start: Array,
    rotation_rate: Array,
    force: Array,
    aid: Array,
    step: float,
    constants: Constants,
    states: Array,
) -> int:
    """Run the commutator-free Lie group method of order 4 of Celledoni, Marthinsen, Owren 2003.

    Quaternions are multiplied by unit quaternions and keep their norm; for plain numbers the method is the classical
    one. Parameters and result are those of `classical_run`.
    """
    n = start.size
    size = n - (quaternions + 1)
    state, trial, middle = start.copy(), np.empty(n), np.empty(n)
    change, slopes = np.empty(size), np.zeros((4, size))
    copied(state, states[0])
    if not condition(state[4:], aid[0, 0], constants) > 0.0:
        return 0
    for k in range(len(force)):
        copied(state, trial)
        for stage in range(4):
            point = (stage + 1) // 2
            slope = slopes[stage]
            rates(right_hand_side, trial, rotation_rate[k, point], force[k, point], aid[k, point], constants, slope)
            combined(slopes, COMMUTATOR_FREE[stage], step, change)
            moved(middle if stage == 2 else state, change, quaternions, trial)
            if stage == 0:
                copied(trial, middle)
        combined(slopes, COMMUTATOR_FREE[4], step, change)
        moved(trial, change, quaternions, state)
        copied(state, states[k + 1])
        if not condition(state[4:], aid[k, 2], constants) > 0.0:
            return k + 1
    return -1


_typeof: Any = typeof  # numba has no types of its own for the type checker
_NUMBERS = types.float64[::1]
_VECTOR = _typeof((0.0, 0.0, 0.0))
_CONSTANTS = _typeof(Constants(*[0.0] * len(Constants._fields)))
_RIGHT_HAND_SIDE = types.void(_NUMBERS, _VECTOR, _NUMBERS, _CONSTANTS, _NUMBERS)
_CONDITION = types.float64(_NUMBERS, _NUMBERS, _CONSTANTS)
_POINTERS = types.FunctionType(_RIGHT_HAND_SIDE), types.FunctionType(_CONDITION)
_POINTS = types.float64[:, :, ::1]
_RUN = types.int64(
    *_POINTERS,
    types.int64,
    _NUMBERS,
    _POINTS,
    _POINTS,
    _POINTS,
    types.float64,
    _CONSTANTS,
    types.float64[:, ::1],
)


def _with_signature(function: Any, signature: Any) -> Any:
    """Compile for one signature, which makes what has it a pointer; keep the code on disk where there is a place."""
    try:
        return njit([signature], cache=True, error_model="numpy")(function)
    except RuntimeError:  # no writable folder
        return njit([signature], error_model="numpy")(function)


@functools.cache
def function_pointer(name: str, *, condition: bool = False) -> Any:
    """Return a function of `sinsbench.subjects.gyroscopic.equations`, compiled for the drivers.

    Parameters
    ----------
    name : str
        Its name.
    condition : bool
        Whether it is a condition; otherwise a right-hand side.
    """
    function = inspect.unwrap(getattr(equations, name))
    return _with_signature(function, _CONDITION if condition else _RIGHT_HAND_SIDE)


@functools.cache
def compiled_run(name: str) -> Any:
    """Return the compiled driver of a method of `FIXED_STEP`."""
    return _with_signature(FIXED_STEP[name], _RUN)


FIXED_STEP = {"rk4": classical_run, "commutator_free": commutator_free_run}
"""The methods of fixed step by name."""
