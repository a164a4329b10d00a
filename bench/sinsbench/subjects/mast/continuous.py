"""The paper's filter: the continuous extended Kalman filter with correlated noises, (3.18), in the state's 20 numbers.

With S = H_1 D_H H_1^T, Theta = F_1 E[W V^T] H_1^T and the covariance P,

    K  = (P H_Y^T + Theta) S^-1,      Y' = F + K (Z - H),      A = F_Y - Theta S^-1 H_Y,
    P' = A P + P A^T + F_1 D_0 F_1^T - Theta S^-1 Theta^T - P H_Y^T S^-1 H_Y P,

integrated by the classical Runge-Kutta method, state and covariance together; after each step the covariance is made
symmetric and the quaternions are normalised. (3.18) as printed leaves the second A untransposed.

What the paper leaves out of A is the derivative of Theta S^-1 with respect to the state, times the innovation: the
innovation holds the antenna's own rate w_J, 1e-2 rad/s, and Theta turns with eta.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.mast.contract import MastInputs, MastStart, Result, StabilityError
from sinsbench.subjects.mast.disturbances import NOISES, noise_gain, shared_noise
from sinsbench.subjects.mast.error_state import ERRORS, reduced, spread
from sinsbench.subjects.mast.jacobians import antenna_rate_derivative, satellite_derivative, state_derivative
from sinsbench.subjects.mast.model import (
    ETA,
    STATES,
    Constants,
    antenna_rate,
    entry,
    inner,
    satellite_range,
    satellite_range_rate,
    state_rates,
)
from sinsbench.subjects.mast.running import Problem, collected, prepared
from sinsbench.subjects.mast.steps import Data, Variances, multiplied, normalise, sensors_at
from sinsbench.subjects.mast.terms import CORRECTED, Terms

__all__ = ["BOUND", "continuous_filter", "riccati_steps", "stability_product"]

Array = NDArray[np.float64]

BOUND = 2.78
"""Where the real axis leaves the stability region of the classical Runge-Kutta method."""


class Slopes(NamedTuple):
    """Rates of state and covariance, and the arrays that they are worked out in; all begin as zeros."""

    state: Array
    covariance: Array
    derivative: Array
    product: Array
    row: Array
    weighted: Array
    innovation: Array
    gain: Array
    theta: Array
    coupled: Array
    inverse: Array
    triangle: Array
    solved: Array
    trial: Array
    change: Array
    trial_covariance: Array
    change_covariance: Array


def new_slopes(satellites: int) -> Slopes:
    """Allocate what a rate is worked out in."""
    m = 2 * satellites + 3
    return Slopes(
        np.zeros(STATES),
        np.zeros((STATES, STATES)),
        np.zeros((STATES, STATES)),
        np.zeros((STATES, STATES)),
        np.zeros((m, STATES)),
        np.zeros((m, STATES)),
        np.zeros(m),
        np.zeros((STATES, NOISES)),
        np.zeros((STATES, 3)),
        np.zeros((STATES, 3)),
        np.zeros((3, 3)),
        np.zeros((m, m)),
        np.zeros(m),
        np.zeros(STATES),
        np.zeros(STATES),
        np.zeros((STATES, STATES)),
        np.zeros((STATES, STATES)),
    )


@entry
def linearise(
    state: Array,
    t: float,
    data: Data,
    k: int,
    point: int,
    variances: Variances,
    terms: Terms,
    constants: Constants,
    out: Slopes,
) -> None:
    """Write F, F_Y, H_Y, Z - H, F_1, Theta, S^-1 and Theta S^-1 of a moment.

    The three rates of gyroscope 2 come first among the measurements, then range rate and range of each satellite.
    """
    sensors = sensors_at(data, k, point)
    state_rates(state, t, sensors, 0.0, terms, constants, out.state)
    antenna_rate_derivative(state, sensors, terms, constants, out.row)
    state_derivative(state, t, sensors, 0.0, out.row, terms, constants, out.derivative)
    shown = antenna_rate(state, sensors, terms, constants)
    for i in range(3):
        out.innovation[i] = sensors.rate2[i] - shown[i]
    for i in range(data.range.shape[2]):
        p, v, m = data.position[2 * k + point, i], data.velocity[2 * k + point, i], 3 + 2 * i
        position, velocity = (p[0], p[1], p[2]), (v[0], v[1], v[2])
        satellite_derivative(state, position, velocity, terms, constants, out.row[m:])
        shown_rate = satellite_range_rate(state, position, velocity, constants)
        out.innovation[m] = data.range_rate[k, point, i] - shown_rate
        out.innovation[m + 1] = data.range[k, point, i] - satellite_range(state, position, terms, constants)
    noise_gain(state, t, 0.0, terms, constants, out.gain)
    h = data.step
    shared_noise(
        state, out.gain, h * variances.rate1, h * variances.antenna, h * variances.rate2, terms, out.theta, out.inverse
    )
    multiplied(out.theta, out.inverse, out.coupled)


@inner
def add_turning(matrix: Array, x: float, y: float, z: float) -> None:
    """Add the derivative of 1/2 Phi(eta) (2x, 2y, 2z) with respect to eta to its block."""
    e = ETA
    matrix[e, e + 1] -= x
    matrix[e, e + 2] -= y
    matrix[e, e + 3] -= z
    matrix[e + 1, e] += x
    matrix[e + 1, e + 2] += z
    matrix[e + 1, e + 3] -= y
    matrix[e + 2, e] += y
    matrix[e + 2, e + 1] -= z
    matrix[e + 2, e + 3] += x
    matrix[e + 3, e] += z
    matrix[e + 3, e + 1] += y
    matrix[e + 3, e + 2] -= x


@inner
def rates(covariance: Array, h: float, variances: Variances, missing: float, out: Slopes) -> None:
    """Write Y' and P' of (3.18).

    Parameters
    ----------
    covariance : ndarray, shape (20, 20)
    h : float
        Step, s.
    variances : Variances
    missing : float
        1 with the derivative of Theta S^-1 that the paper leaves out, 0 without. It is 1/2 Phi turned by the
        innovation, times the share of w_J in S; that of the other terms of Theta is 1e-10 of it.
    out : Slopes
        Holds what `linearise` writes; receives the rates in ``state`` and ``covariance``.
    """
    measurements = out.row.shape[0]
    # P H^T by rows, and S^-1 (Z - H) into the rates of the state.
    multiplied(out.row, covariance, out.weighted)
    z = out.innovation
    for i in range(STATES):
        for a in range(3):
            weighted = 0.0
            for b in range(3):
                weighted += out.inverse[a, b] * z[b]
            out.state[i] += (out.weighted[a, i] + out.theta[i, a]) * weighted
    for m in range(3, measurements):
        weighted = z[m] / (h * (variances.range_rate if m % 2 == 1 else variances.range))
        for i in range(STATES):
            out.state[i] += out.weighted[m, i] * weighted
    # A
    for i in range(STATES):
        for a in range(3):
            factor = out.coupled[i, a]
            if factor != 0.0:
                for j in range(STATES):
                    out.derivative[i, j] -= factor * out.row[a, j]
    if missing != 0.0:
        share = 0.5 * variances.antenna / (variances.antenna + variances.rate2)
        add_turning(out.derivative, share * z[0], share * z[1], share * z[2])
    multiplied(out.derivative, covariance, out.product)
    for i in range(STATES):
        for j in range(i, STATES):
            value = out.product[i, j] + out.product[j, i]
            for m in range(3, measurements):
                intensity = h * (variances.range_rate if m % 2 == 1 else variances.range)
                value -= out.weighted[m, i] * out.weighted[m, j] / intensity
            for a in range(3):
                value -= out.coupled[i, a] * out.theta[j, a]
                for b in range(3):
                    value -= out.weighted[a, i] * out.inverse[a, b] * out.weighted[b, j]
            for a in range(3):
                value += h * variances.rate1 * out.gain[i, a] * out.gain[j, a]
                value += h * variances.force1 * out.gain[i, 3 + a] * out.gain[j, 3 + a]
                value += h * variances.force2 * out.gain[i, 6 + a] * out.gain[j, 6 + a]
                value += h * variances.antenna * out.gain[i, 9 + a] * out.gain[j, 9 + a]
            out.covariance[i, j] = value
            out.covariance[j, i] = value


@inner
def innovation_square(slopes: Slopes, variances: Variances) -> float:
    """Normalised innovation squared of a sample: z^T (H P H^T + S/h)^-1 z, by Cholesky's decomposition."""
    triangle, solved = slopes.triangle, slopes.solved
    measurements, total = slopes.row.shape[0], 0.0
    for i in range(measurements):
        for j in range(i + 1):
            value = 0.0
            for c in range(STATES):
                value += slopes.row[i, c] * slopes.weighted[j, c]
            if i == j and i < 3:
                value += variances.antenna + variances.rate2
            elif i == j:
                value += variances.range_rate if i % 2 == 1 else variances.range
            for c in range(j):
                value -= triangle[i, c] * triangle[j, c]
            triangle[i, j] = math.sqrt(value) if i == j else value / triangle[j, j]
        solved[i] = slopes.innovation[i]
        for c in range(i):
            solved[i] -= triangle[i, c] * solved[c]
        solved[i] /= triangle[i, i]
        total += solved[i] * solved[i]
    return total


@entry
def riccati_steps(
    state: Array,
    covariance: Array,
    data: Data,
    first: int,
    last: int,
    variances: Variances,
    missing: float,
    terms: Terms,
    constants: Constants,
    sums: Array,
    slopes: Slopes,
) -> int:
    """Integrate state and covariance over the steps from `first` to before `last`.

    Parameters
    ----------
    state, covariance : ndarray, shape (20,) and (20, 20)
        Become those at the end.
    data, variances, terms, constants
        As the functions of `sinsbench.subjects.mast.steps` take them.
    missing : float
        As for `rates`.
    sums : ndarray, shape (2,)
        The sum of the normalised innovations squared and their number are added to it.
    slopes : Slopes
        To work in.

    Returns
    -------
    int
        -1, or the step that broke down.
    """
    trial, change = slopes.trial, slopes.change
    trial_covariance, change_covariance = slopes.trial_covariance, slopes.change_covariance
    for k in range(first, last):
        for i in range(STATES):
            trial[i], change[i] = state[i], 0.0
            for j in range(STATES):
                trial_covariance[i, j], change_covariance[i, j] = covariance[i, j], 0.0
        for stage in range(4):
            point = (stage + 1) // 2
            t, weight, distance = data.time[k] + 0.5 * point * data.step, data.step / 3.0, 0.5 * data.step
            if stage == 0 or stage == 3:
                weight = data.step / 6.0
            if stage == 2:
                distance = data.step
            linearise(trial, t, data, k, point, variances, terms, constants, slopes)
            rates(trial_covariance, data.step, variances, missing, slopes)
            if stage == 0:
                sums[0] += innovation_square(slopes, variances)
                sums[1] += slopes.row.shape[0]
            for i in range(STATES):
                change[i] += weight * slopes.state[i]
                trial[i] = state[i] + distance * slopes.state[i]
                for j in range(STATES):
                    slope = slopes.covariance[i, j]
                    change_covariance[i, j] += weight * slope
                    trial_covariance[i, j] = covariance[i, j] + distance * slope
        magnitude = 0.0
        for i in range(STATES):
            state[i] += change[i]
            for j in range(STATES):
                covariance[i, j] += change_covariance[i, j]
                magnitude += abs(covariance[i, j])
        normalise(state)
        for i in range(STATES):
            magnitude += abs(state[i])
        if not math.isfinite(magnitude):
            return k
    return -1


def _linearised(problem: Problem, terms: Terms) -> Slopes:
    slopes = new_slopes(problem.data.range.shape[2])
    start = float(problem.data.time[0])
    linearise(problem.state, start, problem.data, 0, 0, problem.variances, terms, problem.constants, slopes)
    return slopes


def stability_product(problem: Problem, covariance: Array, terms: Terms) -> float:
    """Step times the largest eigenvalue of P H_Y^T S^-1 H_Y at the start.

    An explicit Runge-Kutta step damps an error of the state by (1 - h P H^T S^-1 H + ...): beyond `BOUND` it grows.

    Parameters
    ----------
    problem : Problem
    covariance : ndarray, shape (20, 20)
    terms : Terms
    """
    slopes, variances = _linearised(problem, terms), problem.variances
    satellites = problem.data.range.shape[2]
    sky = np.tile([variances.range_rate, variances.range], satellites)
    deviation = np.sqrt(np.concatenate([np.full(3, variances.antenna + variances.rate2), sky]))
    rows = slopes.row / deviation[:, None]
    return float(np.linalg.eigvalsh(rows @ covariance @ rows.T)[-1])


def continuous_filter(
    inputs: MastInputs, start: MastStart, missing_term: bool = False, terms: Terms = CORRECTED
) -> Result:
    """Estimate by the continuous extended Kalman filter (3.18), corrected.

    Parameters
    ----------
    inputs : MastInputs
    start : MastStart
    missing_term : bool
        Whether A holds the derivative of Theta S^-1 that the paper leaves out.
    terms : Terms
        Equations that the filter believes in.

    Returns
    -------
    mapping of str to ndarray
        As `sinsbench.subjects.mast.contract` says.

    Raises
    ------
    ValueError
        If inputs or start are malformed.
    StabilityError
        If the step is too long for the initial covariance.
    BreakdownError
        If state or covariance is no longer finite.
    """
    problem = prepared(inputs, start, terms)
    state = problem.state
    into = np.zeros((STATES, ERRORS))
    spread(state, 1.0, into)
    covariance = into @ problem.covariance @ into.T
    product = stability_product(problem, covariance, terms)
    if not product < BOUND:
        raise StabilityError(product, BOUND, problem.data.step)

    slopes = new_slopes(problem.data.range.shape[2])

    def advance(first: int, last: int) -> int:
        return riccati_steps(
            state, covariance, problem.data, first, last, problem.variances, float(missing_term), terms,
            problem.constants, problem.sums, slopes,
        )  # fmt: skip

    def error_covariance() -> Array:
        back = np.zeros((ERRORS, STATES))
        reduced(state, np.eye(STATES), 1.0, back)
        return np.asarray(back @ covariance @ back.T)

    return collected(problem, terms, advance, error_covariance)
