"""The driver that all gyroscopic systems share: sensors and a start in, vertical, attitude and speed out.

Methods: the classical and a commutator-free Lie group Runge-Kutta method of order 4 with fixed step, fed with points,
or with the increments of four samples a step; and SciPy's DOP853 on interpolated points.
"""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.catalogue import CATALOGUE
from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Inputs, Start
from sinsbench.subjects.gyroscopic.equations import Constants
from sinsbench.subjects.gyroscopic.systems import System, constants

__all__ = ["METHODS", "GyroscopicSubject", "integrated", "points_of_increments", "subject"]

Array = NDArray[np.float64]
GyroscopicSubject = Callable[[Inputs, Start], dict[str, Array]]

METHODS: Mapping[str, int] = {"rk4": 2, "commutator_free": 2, "dop853": 2}
"""Methods, and the intervals between points that one step spans."""

SAMPLES_PER_STEP = 4
"""Samples of increments that one step spans."""

FIRST_POINT = (25.0, -23.0, 13.0, -3.0)
MIDDLE_POINT = (-1.0, 7.0, 7.0, -1.0)
"""Twelfths by which four increments, over their interval, give the cubic of these integrals at start and middle."""

RELATIVE_TOLERANCE = 3e-14
"""Of DOP853: 1e-6 m on the Earth are 1.6e-13 rad, and SciPy accepts nothing below 2.2e-14."""
LONGEST_STEP = 60.0
"""Of DOP853, s: a manoeuvre must not be stepped over."""
FIRST_STEP = 1.0
"""Of DOP853, s: to choose one, SciPy would look ahead, and never come back from where slopes are not finite."""
INTERPOLATION_DEGREE = 7
"""Of the splines through the points that DOP853 reads, where there are enough points."""


def points_of_increments(increments: Array, interval: float) -> Array:
    """Return what increments say about start, middle and end of each step of four samples.

    A cubic has four integrals; Simpson's rule, which the Runge-Kutta methods of order 4 are for a pure quadrature,
    integrates it exactly: no part of an increment is lost.

    Parameters
    ----------
    increments : ndarray, shape (4 m, columns)
        Integrals over the samples.
    interval : float
        Sampling interval, s.

    Returns
    -------
    ndarray, shape (m, 3, columns)
    """
    weights = np.array([FIRST_POINT, MIDDLE_POINT, FIRST_POINT[::-1]]) / (12 * interval)
    return np.ascontiguousarray(weights @ increments.reshape(-1, SAMPLES_PER_STEP, increments.shape[1]))


def _points(values: Array) -> Array:
    """Return values (2 m + 1, columns) at start, middle and end of each step, shape (m, 3, columns)."""
    return np.stack([values[:-1:2], values[1::2], values[2::2]], axis=1)


def _aids(system: System, inputs: Inputs, fixed: Constants) -> Array:
    """Return the aiding inputs of a system at the times of the inputs, shape (n + 1, number)."""
    columns = np.zeros((len(inputs.time), len(system.aids)))
    for column, aid in enumerate(system.aids):
        if aid.name in inputs.aids:
            columns[:, column] = inputs.aids[aid.name]
        elif aid.default is None:
            raise ValueError(f"{system.name} needs the aiding input {aid.name!r}")
        else:
            columns[:, column] = aid.default(fixed)
    return columns


def _fixed_step(system: System, method: str, inputs: Inputs, state: Array, fixed: Constants) -> tuple[Array, int]:
    """Run a compiled driver; return the states and the row that breaks the condition, or -1."""
    from sinsbench.subjects.gyroscopic import stepping

    aids = _aids(system, inputs, fixed)
    if inputs.kind == "points":
        step = METHODS[method] * inputs.interval
        rate, force = (_points(values) for values in (inputs.rate, inputs.specific_force))
        aiding = _points(aids)
    else:
        step = SAMPLES_PER_STEP * inputs.interval
        rate, force = (points_of_increments(x, inputs.interval) for x in (inputs.rate, inputs.specific_force))
        aiding = _points(aids[:: SAMPLES_PER_STEP // 2])
    states = np.empty((len(force) + 1, len(state)))
    broken = stepping.compiled_run(method)(
        stepping.function_pointer(system.right_hand_side),
        stepping.function_pointer(system.condition, condition=True),
        system.quaternions,
        state,
        rate,
        force,
        aiding,
        step,
        fixed,
        states,
    )
    return states, broken


def _dop853(system: System, inputs: Inputs, state: Array, fixed: Constants) -> Array:
    """Run DOP853 through the points of the sensors, and return the states at the ends of steps of two intervals.

    Raises
    ------
    BrokenConditionError
        If the condition of the system breaks.
    """
    from scipy.integrate import solve_ivp
    from scipy.interpolate import make_interp_spline

    from sinsbench.subjects import kernels
    from sinsbench.subjects.gyroscopic import stepping

    right_hand_side = stepping.function_pointer(system.right_hand_side)
    condition = stepping.function_pointer(system.condition, condition=True)
    columns = np.column_stack([inputs.rate, inputs.specific_force, _aids(system, inputs, fixed)])
    degree = min(INTERPOLATION_DEGREE, len(columns) - 2)  # odd: whole steps of two intervals have an odd number of ends
    sensors = make_interp_spline(inputs.time, columns, k=degree)
    latest = [float(inputs.time[0])]
    rate, slope = np.empty(len(state) - system.quaternions - 1), np.empty(len(state))

    def slopes(time: float, values: Array) -> Array:
        read, latest[0] = sensors(time), time
        rate[:3] = read[:3]
        right_hand_side(values[4:], kernels.rotate(tuple(values[:4]), tuple(read[3:6])), read[6:], fixed, rate[3:])
        stepping.component_slopes(values, rate, system.quaternions, slope)
        return slope.copy()  # SciPy keeps what it is given, and shortens the step where that is not finite

    def margin(time: float, values: Array) -> float:
        return float(condition(values[4:], sensors(time)[6:], fixed))

    ends = inputs.time[:: METHODS["dop853"]]
    if not margin(ends[0], state) > 0:
        raise BrokenConditionError(system.requirement, ends[0])
    # The components of a vector are measured by its norm: no step meets a tolerance relative to a rounding error.
    vectors = np.split(state[4 * (system.quaternions + 1) :], np.cumsum(system.vectors)[:-1])
    scale = np.ones(len(state))
    scale[4 * (system.quaternions + 1) :] = np.concatenate([np.full(len(x), np.linalg.norm(x)) for x in vectors])
    solution = solve_ivp(
        slopes,
        (ends[0], ends[-1]),
        state,
        method="DOP853",
        t_eval=ends,
        events=_Terminal(margin),
        rtol=RELATIVE_TOLERANCE,
        atol=RELATIVE_TOLERANCE * np.where(scale > 0, scale, 1.0),
        max_step=LONGEST_STEP,
        first_step=min(FIRST_STEP, ends[-1] - ends[0]),
    )
    if solution.status == 1:
        raise BrokenConditionError(system.requirement, float(solution.t_events[0][0]))
    if not solution.success:  # its steps shrink to nothing before a singularity of the equations, and nowhere else
        raise BrokenConditionError(system.requirement, latest[0])
    states: Array = solution.y.T
    return states


class _Terminal:
    """An event that ends the integration where its function crosses zero."""

    terminal = True

    def __init__(self, function: Callable[[float, Array], float]) -> None:
        self.function = function

    def __call__(self, time: float, values: Array) -> float:
        return self.function(time, values)


def integrated(
    system: System, method: str, inputs: Inputs, start: Start, fixed: Constants | None = None
) -> dict[str, Array]:
    """Integrate the equations of a system together with the attitude of the vehicle, (1.14) and (2.8).

    Parameters
    ----------
    system : System
    method : str
        Name in `METHODS`. "dop853" takes points only.
    inputs : Inputs
        Points at starts, middles and ends of the steps, or increments of four samples a step.
    start : Start
    fixed : Constants, optional
        Constants of the system; by default tuned to the sphere of the start.

    Returns
    -------
    dict of str to ndarray
        ``time`` (m + 1,), ``vertical`` (m + 1, 3) and ``trihedron`` (m + 1, 4) in X, ``attitude`` (m + 1, 4), ``speed``
        (m + 1,), m/s, where the system tells it, ``states`` (m + 1, n).

    Raises
    ------
    ValueError
        If the inputs are not what `Inputs.checked` asks for, or the method is unknown or takes no increments.
    BrokenConditionError
        If a condition of the equations does not hold, and when; no state after that is returned.
    """
    if method not in METHODS or (method == "dop853" and inputs.kind != "points"):
        raise ValueError(f"no method {method!r} for {inputs.kind}; there are {', '.join(METHODS)}, the last for points")
    inputs = inputs.checked(METHODS[method] if inputs.kind == "points" else SAMPLES_PER_STEP)
    start = start.checked()
    fixed = constants(start, system.tuning) if fixed is None else fixed
    state = np.concatenate([start.attitude, system.start(start, fixed)])
    with np.errstate(all="ignore"):  # what overflows is found below
        if method == "dop853":
            states, broken = _dop853(system, inputs, state, fixed), -1
        else:
            states, broken = _fixed_step(system, method, inputs, state, fixed)
        time = inputs.time[:: (len(inputs.time) - 1) // (len(states) - 1)]
        if broken >= 0:
            raise BrokenConditionError(system.requirement, time[broken])
        finite = np.isfinite(states).all(axis=1)
        if not finite.all():
            raise BrokenConditionError("the state is finite", time[int(np.argmin(finite))])
    attitude = states[:, :4] / np.linalg.norm(states[:, :4], axis=1, keepdims=True)
    return {"time": time, "attitude": attitude, "states": states[:, 4:]} | system.observe(states[:, 4:], fixed)


def subject(system: System, method: str = "rk4", factor: float = 1.0) -> GyroscopicSubject:
    """Make the subject of a system and a method.

    Parameters
    ----------
    system : System
    method : str
        Name in `METHODS`.
    factor : float
        Multiplies the tuning kappa: a system out of tune.

    Returns
    -------
    callable
        ``f(inputs, start)``, what `integrated` returns.
    """

    def run(inputs: Inputs, start: Start) -> dict[str, Array]:
        return integrated(system, method, inputs, start, constants(start.checked(), system.tuning, factor))

    run.__name__ = run.__qualname__ = f"{system.name}_{method}"
    entry = CATALOGUE[system.name]
    run.__doc__ = f"Integrate the {entry.summary}: {entry.equations}. See `integrated`."
    return run
