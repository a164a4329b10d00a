"""One step of a filter in error coordinates: measurement rows, scalar updates, propagation; compiled.

Nothing is allocated: all arrays are handed in, and `Workspace` holds those that no caller looks at.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.equations import quaternion
from sinsbench.subjects.mast.disturbances import NOISES, noise_gain
from sinsbench.subjects.mast.error_state import ERRORS, put_quaternion, reduced, spread
from sinsbench.subjects.mast.jacobians import (
    antenna_rate_derivative,
    constraint_derivative,
    satellite_derivative,
    state_derivative,
)
from sinsbench.subjects.mast.model import (
    ETA,
    LAMBDA,
    MU,
    STATES,
    Constants,
    Sensors,
    antenna_rate,
    index,
    inner,
    mast_constraint,
    satellite_range,
    satellite_range_rate,
    state_rates,
)
from sinsbench.subjects.mast.terms import Terms

__all__ = ["Data", "Options", "Variances", "Workspace", "measure", "new_workspace", "propagate", "update"]

Array = NDArray[np.float64]


BEGINNING = index(0)
"""Point of a step: its start."""


class Data(NamedTuple):
    """The arrays of `sinsbench.subjects.mast.contract.MastInputs`, in the order there, and the step."""

    time: Array
    rate1: Array
    force1: Array
    rate2: Array
    force2: Array
    position: Array
    velocity: Array
    range_rate: Array
    range: Array
    step: float


class Variances(NamedTuple):
    """Variances of the noise per sample, in the order of `sinsbench.subjects.mast.contract.MastNoise`."""

    rate1: float
    force1: float
    rate2: float
    force2: float
    antenna: float
    range_rate: float
    range: float


class Options(NamedTuple):
    """How a discrete filter works.

    Attributes
    ----------
    composite : float
        1 for the coordinates nu, 0 for eta: see `sinsbench.subjects.mast.error_state`.
    constraint : float
        1 if the mast's constant length, Delta_Z + R (w_X^2 + w_Y^2) = 0, is used as a measurement.
    inflation, fading : float
        Its variance is multiplied by 1 + inflation exp(-t/fading), fading in s, while the linearisation is poor.
    """

    composite: float = 1.0
    constraint: float = 1.0
    inflation: float = 1e4
    fading: float = 2.0


class Workspace(NamedTuple):
    """Arrays that a step works in; all begin as zeros."""

    spread: Array
    antenna: Array
    row: Array
    sky: Array
    derivative: Array
    slope: Array
    slopes: Array
    trial: Array
    sensitivity: Array
    sensitivity_slope: Array
    sensitivity_sum: Array
    sensitivity_trial: Array
    gain: Array
    noise: Array
    product: Array
    column: Array
    before: Array
    defect: Array


def new_workspace() -> Workspace:
    """Allocate what the steps work in."""
    return Workspace(
        np.zeros((STATES, ERRORS)),
        np.zeros((3, STATES)),
        np.zeros(STATES),
        np.zeros((2, STATES)),
        np.zeros((STATES, STATES)),
        np.zeros(STATES),
        np.zeros(STATES),
        np.zeros(STATES),
        np.zeros((STATES, ERRORS)),
        np.zeros((STATES, ERRORS)),
        np.zeros((STATES, ERRORS)),
        np.zeros((STATES, ERRORS)),
        np.zeros((STATES, NOISES)),
        np.zeros((ERRORS, NOISES)),
        np.zeros((ERRORS, ERRORS)),
        np.zeros(ERRORS),
        np.zeros(STATES),
        np.zeros(ERRORS),
    )


@inner
def sensors_at(data: Data, k: int, point: int) -> Sensors:
    """Return what the sensors show in step k at its start, middle or end."""
    a, b, c, d = data.rate1[k, point], data.force1[k, point], data.rate2[k, point], data.force2[k, point]
    return Sensors((a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2]), (d[0], d[1], d[2]))


@inner
def put_error_row(row: Array, matrix: Array, rows: Array, m: int) -> None:
    """Write a row of H in error coordinates: its product with the derivative of state [+] error. Most of it is zero."""
    for j in range(ERRORS):
        rows[m, j] = 0.0
    for i in range(STATES):
        if row[i] != 0.0:
            for j in range(ERRORS):
                rows[m, j] += row[i] * matrix[i, j]


@inner
def measure(
    state: Array,
    data: Data,
    k: int,
    variances: Variances,
    options: Options,
    terms: Terms,
    constants: Constants,
    rows: Array,
    residual: Array,
    variance: Array,
    work: Workspace,
) -> int:
    """Linearise the measurements of step k: rows of H in error coordinates, Z - H(Y), variances.

    Returns
    -------
    int
        Their number: two for each satellite, three rates of gyroscope 2 and, if asked for, the mast's constraint.
    """
    spread(state, options.composite, work.spread)
    satellites: int = data.range.shape[2]
    for i in range(satellites):
        p, v, m = data.position[2 * k, i], data.velocity[2 * k, i], 2 * i
        position, velocity = (p[0], p[1], p[2]), (v[0], v[1], v[2])
        satellite_derivative(state, position, velocity, terms, constants, work.sky)
        put_error_row(work.sky[0], work.spread, rows, m)
        put_error_row(work.sky[1], work.spread, rows, m + 1)
        residual[m] = data.range_rate[k, 0, i] - satellite_range_rate(state, position, velocity, constants)
        residual[m + 1] = data.range[k, 0, i] - satellite_range(state, position, terms, constants)
        variance[m], variance[m + 1] = variances.range_rate, variances.range
    sensors = sensors_at(data, k, BEGINNING)
    antenna_rate_derivative(state, sensors, terms, constants, work.antenna)
    shown = antenna_rate(state, sensors, terms, constants)
    for i in range(3):
        m = 2 * satellites + i
        put_error_row(work.antenna[i], work.spread, rows, m)
        residual[m] = sensors.rate2[i] - shown[i]
        variance[m] = variances.antenna + variances.rate2
    m = 2 * satellites + 3
    if options.constraint != 0.0:
        constraint_derivative(state, sensors, terms, constants, work.row)
        put_error_row(work.row, work.spread, rows, m)
        residual[m] = -mast_constraint(state, sensors, terms, constants)
        faded = 1.0 + options.inflation * math.exp(-(data.time[k] - data.time[0]) / options.fading)
        variance[m] = (variances.force1 + variances.force2) * faded
        m += 1
    return m


@inner
def update(
    covariance: Array,
    error: Array,
    rows: Array,
    innovation: Array,
    variance: Array,
    count: int,
    gains: Array,
    scales: Array,
    work: Workspace,
) -> float:
    """Update an error and its covariance with scalars one by one, in Joseph's form.

    Joseph's form keeps the covariance positive whatever the rounding of the gain: position in radians and velocity in
    m/s leave twelve decades between the variances.

    Parameters
    ----------
    covariance : ndarray, shape (17, 17)
    error : ndarray, shape (17,)
        Both are updated.
    rows, innovation, variance : ndarray
        What `measure` writes; the residuals become innovations.
    count : int
        Number of scalars.
    gains : ndarray, shape (count, 17)
        Receives the gains.
    scales : ndarray, shape (count,)
        Receives the variances of the innovations.

    Returns
    -------
    float
        Sum of the normalised innovations squared; NaN where a variance is not positive.
    """
    total = 0.0
    column, product = work.column, work.product
    for m in range(count):
        spread_variance = variance[m]
        predicted = 0.0
        for i in range(ERRORS):
            value = 0.0
            for j in range(ERRORS):
                value += covariance[i, j] * rows[m, j]
            column[i] = value
            spread_variance += rows[m, i] * value
            predicted += rows[m, i] * error[i]
        if not spread_variance > 0.0:
            return math.nan
        innovation[m] -= predicted
        scales[m] = spread_variance
        total += innovation[m] * innovation[m] / spread_variance
        for i in range(ERRORS):
            gains[m, i] = column[i] / spread_variance
            error[i] += gains[m, i] * innovation[m]
        # M = (I - K h) P, then M (I - K h)^T + K r K^T.
        for i in range(ERRORS):
            value = 0.0
            for j in range(ERRORS):
                product[i, j] = covariance[i, j] - gains[m, i] * column[j]
                value += product[i, j] * rows[m, j]
            column_gain = variance[m] * gains[m, i] - value
            for j in range(ERRORS):
                product[i, j] += column_gain * gains[m, j]
        for i in range(ERRORS):
            for j in range(ERRORS):
                covariance[i, j] = 0.5 * (product[i, j] + product[j, i])
    return total


@inner
def multiplied(left: Array, right: Array, out: Array) -> None:
    """Write left right; what is zero on the left is passed over, which is most of it."""
    for i in range(left.shape[0]):
        for j in range(right.shape[1]):
            out[i, j] = 0.0
        for k in range(left.shape[1]):
            factor = left[i, k]
            if factor != 0.0:
                for j in range(right.shape[1]):
                    out[i, j] += factor * right[k, j]


@inner
def normalise(state: Array) -> None:
    """Bring the quaternions back to the norm 1."""
    put_quaternion(state, MU, quaternion(state, MU))
    put_quaternion(state, ETA, quaternion(state, ETA))
    put_quaternion(state, LAMBDA, quaternion(state, LAMBDA))


@inner
def propagate(
    state: Array,
    data: Data,
    k: int,
    options: Options,
    terms: Terms,
    constants: Constants,
    transition: Array,
    work: Workspace,
) -> None:
    """Propagate the state over step k and write its transition matrix: Runge-Kutta 4 of both, gyroscope 2 driving eta.

    What is integrated with the state is its derivative with respect to the errors at the start, Y' = F_Y Y_d.

    Parameters
    ----------
    state : ndarray, shape (20,)
        Becomes that at the end of the step.
    transition : ndarray, shape (17, 17)
        Receives the matrix that takes errors of the start to errors of the end.
    """
    spread(state, options.composite, work.sensitivity)
    for i in range(STATES):
        work.trial[i], work.slopes[i] = state[i], 0.0
        for j in range(ERRORS):
            work.sensitivity_trial[i, j], work.sensitivity_sum[i, j] = work.sensitivity[i, j], 0.0
    start = data.time[k]
    for stage in range(4):
        point = (stage + 1) // 2
        t, weight, distance = start + 0.5 * point * data.step, data.step / 3.0, 0.5 * data.step
        if stage == 0 or stage == 3:
            weight = data.step / 6.0
        if stage == 2:
            distance = data.step
        sensors = sensors_at(data, k, point)
        state_rates(work.trial, t, sensors, 1.0, terms, constants, work.slope)
        antenna_rate_derivative(work.trial, sensors, terms, constants, work.antenna)
        state_derivative(work.trial, t, sensors, 1.0, work.antenna, terms, constants, work.derivative)
        multiplied(work.derivative, work.sensitivity_trial, work.sensitivity_slope)
        for i in range(STATES):
            work.slopes[i] += weight * work.slope[i]
            work.trial[i] = state[i] + distance * work.slope[i]
            for j in range(ERRORS):
                slope = work.sensitivity_slope[i, j]
                work.sensitivity_sum[i, j] += weight * slope
                work.sensitivity_trial[i, j] = work.sensitivity[i, j] + distance * slope
    for i in range(STATES):
        state[i] += work.slopes[i]
        for j in range(ERRORS):
            work.sensitivity_sum[i, j] += work.sensitivity[i, j]
            work.sensitivity[i, j] = 0.0
    normalise(state)
    reduced(state, work.sensitivity_sum, options.composite, transition)


@inner
def carry(
    covariance: Array,
    transition: Array,
    state: Array,
    t: float,
    step: float,
    variances: Variances,
    options: Options,
    terms: Terms,
    constants: Constants,
    work: Workspace,
) -> None:
    """Propagate the covariance over a step: F P F^T + h G D G^T with the intensities D = sd^2 h.

    Parameters
    ----------
    covariance, transition : ndarray, shape (17, 17)
    state : ndarray, shape (20,)
        At the start of the step, where the noise is taken to enter.
    t, step : float
        Its time and its length, s.
    """
    noise_gain(state, t, 1.0, terms, constants, work.gain)
    reduced(state, work.gain, options.composite, work.noise)
    multiplied(transition, covariance, work.product)
    for i in range(ERRORS):
        for j in range(i, ERRORS):
            value = 0.0
            for k in range(ERRORS):
                value += work.product[i, k] * transition[j, k]
            noise = 0.0
            for k in range(3):
                noise += variances.rate1 * work.noise[i, k] * work.noise[j, k]
                noise += variances.force1 * work.noise[i, 3 + k] * work.noise[j, 3 + k]
                noise += variances.force2 * work.noise[i, 6 + k] * work.noise[j, 6 + k]
                noise += variances.rate2 * work.noise[i, 9 + k] * work.noise[j, 9 + k]
            covariance[i, j] = value + step * step * noise
            covariance[j, i] = covariance[i, j]
