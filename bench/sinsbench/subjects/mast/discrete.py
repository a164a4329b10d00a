"""The discrete multiplicative extended Kalman filter of the mast's antenna.

At each step the satellites' range rates and ranges, the rates of gyroscope 2 as a pseudo-measurement and, if asked for,
the mast's constant length are used one scalar after the other; then the state is propagated with gyroscope 2 driving
eta, which removes the correlation of process and measurement noise exactly.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.mast.contract import ERRORS, MastInputs, MastStart, Result
from sinsbench.subjects.mast.error_state import corrected
from sinsbench.subjects.mast.model import STATES, Constants, entry
from sinsbench.subjects.mast.running import collected, composite_covariance, prepared, separate_covariance
from sinsbench.subjects.mast.steps import (
    Data,
    Options,
    Variances,
    Workspace,
    carry,
    measure,
    new_workspace,
    propagate,
    update,
)
from sinsbench.subjects.mast.terms import CORRECTED, Terms

__all__ = ["discrete_filter", "filter_steps"]

Array = NDArray[np.float64]

FADING = Options()
"""Coordinates nu, the constraint's variance inflated at the start."""


@entry
def filter_steps(
    state: Array,
    covariance: Array,
    data: Data,
    first: int,
    last: int,
    variances: Variances,
    options: Options,
    terms: Terms,
    constants: Constants,
    sums: Array,
    trajectory: Array,
    work: Workspace,
) -> int:
    """Run the filter over the steps from `first` to before `last`.

    Parameters
    ----------
    state, covariance : ndarray, shape (20,) and (17, 17)
        Become those at the end.
    data, variances, options, terms, constants
        As the functions of `sinsbench.subjects.mast.steps` take them.
    first, last : int
        Steps.
    sums : ndarray, shape (2,)
        The sum of the normalised innovations squared and their number are added to it.
    trajectory : ndarray, shape (n, 20)
        Receives the states at the ends of the steps, in the rows first + 1 ... last, as far as it has them.

    Returns
    -------
    int
        -1, or the step that broke down.
    """
    most = 2 * data.range.shape[2] + 4
    rows, gains = np.zeros((most, ERRORS)), np.zeros((most, ERRORS))
    residual, variance, scales = np.zeros(most), np.zeros(most), np.zeros(most)
    error, transition, before = np.zeros(ERRORS), np.zeros((ERRORS, ERRORS)), np.zeros(STATES)
    for k in range(first, last):
        count = measure(state, data, k, variances, options, terms, constants, rows, residual, variance, work)
        for i in range(ERRORS):
            error[i] = 0.0
        total = update(covariance, error, rows, residual, variance, count, gains, scales, work)
        if not math.isfinite(total):
            return k
        sums[0] += total
        sums[1] += count
        corrected(state, error, options.composite, before)
        for i in range(STATES):
            state[i] = before[i]
        propagate(state, data, k, options, terms, constants, transition, work)
        carry(covariance, transition, before, data.time[k], data.step, variances, options, terms, constants, work)
        magnitude = 0.0
        for i in range(STATES):
            magnitude += abs(state[i])
        if not math.isfinite(magnitude):
            return k
        if k + 1 < trajectory.shape[0]:
            for i in range(STATES):
                trajectory[k + 1, i] = state[i]
    return -1


def discrete_filter(
    inputs: MastInputs, start: MastStart, options: Options = FADING, terms: Terms = CORRECTED
) -> Result:
    """Estimate by the discrete multiplicative extended Kalman filter.

    Parameters
    ----------
    inputs : MastInputs
    start : MastStart
    options : Options
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
    BreakdownError
        If the estimate is no longer finite or an innovation's variance no longer positive.
    """
    problem = prepared(inputs, start, terms)
    state, covariance = problem.state, problem.covariance
    work, nowhere = new_workspace(), np.zeros((0, STATES))
    covariance[:] = separate_covariance(state, covariance, options.composite)

    def advance(first: int, last: int) -> int:
        return filter_steps(
            state, covariance, problem.data, first, last, problem.variances, options, terms, problem.constants,
            problem.sums, nowhere, work,
        )  # fmt: skip

    return collected(problem, terms, advance, lambda: composite_covariance(state, covariance, options.composite))
