"""A twin of MATLAB's ode45: the Dormand-Prince pair 5(4) under the step control MATLAB documents.

The paper checked its solution with MATLAB; this integrator shows what such a check can see.  The pair is
Dormand, Prince 1980, "A family of embedded Runge-Kutta formulae", J. Comput. Appl. Math. 6, 19-26; the
control and the interpolant are those of Shampine, Reichelt 1997, "The MATLAB ODE Suite", SIAM J. Sci.
Comput. 18, 1-22.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from sinsbench.subjects.equator_model import EquatorCase, FloatArray, Solver, solver
from sinsbench.subjects.equator_numerical import RightHandSide, right_hand_side

STAGES = (
    ("1/5",),
    ("3/40", "9/40"),
    ("44/45", "-56/15", "32/9"),
    ("19372/6561", "-25360/2187", "64448/6561", "-212/729"),
    ("9017/3168", "-355/33", "46732/5247", "49/176", "-5103/18656"),
    ("35/384", "0", "500/1113", "125/192", "-2187/6784", "11/84"),
)
"""Weights of the stages 2 to 7; those of stage 7 are the solution of order 5, so it opens the next step."""

EMBEDDED = ("5179/57600", "0", "7571/16695", "393/640", "-92097/339200", "187/2100", "1/40")
"""Weights of the solution of order 4 that estimates the error."""

INTERPOLANT = (
    ("1", "-183/64", "37/12", "-145/128"),
    ("0", "0", "0", "0"),
    ("0", "1500/371", "-1000/159", "1000/371"),
    ("0", "-125/32", "125/12", "-375/64"),
    ("0", "9477/3392", "-729/106", "25515/6784"),
    ("0", "-11/7", "11/3", "-55/28"),
    ("0", "3/2", "-4", "5/2"),
)
"""Weights of the stages (rows) as polynomials of s, s^2, s^3, s^4 (columns): order 4 at s = (t - t_n)/h."""


def _floats(fractions: tuple[str, ...]) -> FloatArray:
    return np.array([float(Fraction(text)) for text in fractions])


_WEIGHTS = [_floats(row) for row in STAGES]
_ABSCISSAE = [float(sum(map(Fraction, row))) for row in STAGES]
_ERROR = np.array([float(Fraction(a) - Fraction(b)) for a, b in zip((*STAGES[-1], "0"), EMBEDDED, strict=True)])
_INTERPOLANT = np.array([_floats(row) for row in INTERPOLANT])

SMALLEST_RELATIVE_TOLERANCE = 100 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Ode45Result:
    """Solution and cost of one integration.

    Attributes
    ----------
    time : (m,) array
        Instants of output.
    state : (m, k) array
        The solution there.
    steps, rejected, evaluations : int
        Accepted steps, rejected steps, evaluations of the right-hand side.
    """

    time: FloatArray
    state: FloatArray
    steps: int
    rejected: int
    evaluations: int


def ode45(
    right_hand_side: Callable[[float, FloatArray], FloatArray],
    times: ArrayLike,
    initial: ArrayLike,
    relative_tolerance: float = 1e-3,
    absolute_tolerance: float = 1e-6,
) -> Ode45Result:
    """Integrate y' = f(t, y) as MATLAB's ode45 does.

    Parameters
    ----------
    right_hand_side : callable
        f(t, y), shape (k,).
    times : (m,) array_like
        Ascending.  Two of them are the ends of the interval, and the output is every step; more are the
        instants of output, interpolated to order 4.
    initial : (k,) array_like
        y at the first of `times`.
    relative_tolerance, absolute_tolerance : float
        MATLAB's RelTol and AbsTol.  RelTol is raised to 100 eps if it is below.

    Returns
    -------
    Ode45Result

    Raises
    ------
    ValueError
        If `times` are fewer than two or do not ascend, or a tolerance is not positive.
    RuntimeError
        If no step above the resolution of t meets the tolerance.
    """
    instants = np.asarray(times, dtype=np.float64)
    if instants.ndim != 1 or instants.size < 2 or not (np.diff(instants) > 0).all():
        raise ValueError("times must be at least two ascending instants")
    if not (relative_tolerance > 0 and absolute_tolerance > 0):
        raise ValueError("the tolerances must be positive")
    tolerance = max(relative_tolerance, SMALLEST_RELATIVE_TOLERANCE)
    threshold = absolute_tolerance / tolerance
    every_step = instants.size == 2
    time, end = float(instants[0]), float(instants[-1])
    state = np.array(initial, dtype=np.float64)
    slopes = np.zeros((7, state.size))
    slopes[0] = right_hand_side(time, state)
    rejected, evaluations, wanted = 0, 1, 1
    output_time, output_state = [time], [state]

    largest = 0.1 * (end - time)
    size = min(largest, float(instants[1]) - time)
    rate = _norm(slopes[0] / np.maximum(np.abs(state), threshold)) / (0.8 * tolerance**0.2)
    if size * rate > 1:
        size = 1 / rate
    steps = 0
    while time < end:
        smallest = 16 * float(np.spacing(time))
        size = min(largest, max(smallest, size))
        failed = False
        while True:
            # A step that would leave less than a tenth of itself to go is stretched to the end.
            last = not failed and 1.1 * size >= end - time
            if last:
                size = end - time
            for stage, (weights, abscissa) in enumerate(zip(_WEIGHTS, _ABSCISSAE, strict=True), start=1):
                trial = state + size * (weights @ slopes[:stage])
                slopes[stage] = right_hand_side(time + abscissa * size, trial)
            evaluations += 6
            scale = np.maximum(np.maximum(np.abs(state), np.abs(trial)), threshold)
            error = size * _norm((_ERROR @ slopes) / scale)
            if error <= tolerance:
                break
            rejected += 1
            if not size > smallest:
                raise RuntimeError(f"ode45: no step above {smallest:g} meets the tolerance at t = {time:g}")
            factor = 0.5 if failed else max(0.1, 0.8 * (tolerance / error) ** 0.2)
            size = max(smallest, size * factor)
            failed = True
        steps += 1
        reached = end if last else time + size
        if every_step:
            output_time.append(reached)
            output_state.append(trial)
        else:
            while wanted < instants.size and instants[wanted] <= reached:
                s = (instants[wanted] - time) / size
                weights = _INTERPOLANT @ s ** np.arange(1, 5)
                output_time.append(float(instants[wanted]))
                output_state.append(trial if instants[wanted] == reached else state + size * (weights @ slopes))
                wanted += 1
        if not failed:
            size /= max(0.2, 1.25 * (error / tolerance) ** 0.2)
        time, state = reached, trial
        slopes[0] = slopes[6]
    return Ode45Result(np.array(output_time), np.array(output_state), steps, rejected, evaluations)


def _norm(values: FloatArray) -> float:
    return float(np.abs(values).max())


TOLERANCES = {
    "ode45_1e3": (1e-3, 1e-6),
    "ode45_1e6": (1e-6, 1e-6),
    "ode45_1e9": (1e-9, 1e-12),
    "ode45_1e12": (1e-12, 1e-12),
    "ode45_tightest": (2.22e-14, 1e-20),
}
"""RelTol and AbsTol of each subject; the first pair is MATLAB's default."""


def _subject(name: str) -> Solver:
    relative, absolute = TOLERANCES[name]

    def method(case: EquatorCase) -> FloatArray:
        instants = np.union1d([0.0], case.time)
        if instants.size == 1:
            return np.tile(case.initial_errors, (case.time.size, 1))
        function: RightHandSide = right_hand_side(case)
        result = ode45(function, instants, case.initial_errors, relative, absolute)
        return result.state[np.searchsorted(result.time, case.time)]

    method.__name__ = name
    method.__doc__ = f"MATLAB's ode45 with RelTol = {relative:g} and AbsTol = {absolute:g}."
    return solver(method)


ode45_1e3 = _subject("ode45_1e3")
ode45_1e6 = _subject("ode45_1e6")
ode45_1e9 = _subject("ode45_1e9")
ode45_1e12 = _subject("ode45_1e12")
ode45_tightest = _subject("ode45_tightest")
