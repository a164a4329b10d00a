"""The discrete multiplicative extended Kalman filter of the mast's antenna.

At each step the satellites' range rates and ranges, the rates of gyroscope 2 as a pseudo-measurement and, if asked for,
the mast's constant length are used one scalar after the other; then the state is propagated with gyroscope 2 driving
eta, which removes the correlation of process and measurement noise exactly.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.mast.contract import ERRORS, MastInputs, MastStart, Result
from sinsbench.subjects.mast.error_state import corrected, difference
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

__all__ = ["History", "discrete_filter", "filter_steps", "new_history"]

Array = NDArray[np.float64]

FADING = Options()
"""Coordinates nu, the constraint's variance inflated at the start."""


class History(NamedTuple):
    """What the steps leave behind, one row each: the last steps, as many as there are rows."""

    error: Array
    covariance: Array
    transition: Array
    row: Array
    gain: Array
    innovation: Array
    variance: Array
    scale: Array


def new_history(steps: int, satellites: int, options: Options) -> History:
    """Allocate the history of some steps."""
    m = 2 * satellites + 3 + (options.constraint != 0)
    return History(
        np.zeros((steps, ERRORS)),
        np.zeros((steps, ERRORS, ERRORS)),
        np.zeros((steps, ERRORS, ERRORS)),
        np.zeros((steps, m, ERRORS)),
        np.zeros((steps, m, ERRORS)),
        np.zeros((steps, m)),
        np.zeros((steps, m)),
        np.zeros((steps, m)),
    )


@entry
def filter_steps(
    state: Array,
    error: Array,
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
    given: bool,
    history: History,
    work: Workspace,
) -> int:
    """Run the filter over the steps from `first` to before `last`.

    Parameters
    ----------
    state, covariance : ndarray, shape (20,) and (17, 17)
        Become those at the end.
    error : ndarray, shape (17,)
        Becomes the error of the given trajectory at the end.
    data, variances, options, terms, constants
        As the functions of `sinsbench.subjects.mast.steps` take them.
    first, last : int
        Steps.
    sums : ndarray, shape (2,)
        The sum of the normalised innovations squared and their number are added to it.
    trajectory : ndarray, shape (n, 20)
        States at the ends of the steps, in the rows first ... last: those to linearise along, if they are given.
        Otherwise the filter is linearised at its own estimates, which are written there as far as there are rows.
    given : bool
        Whether the trajectory is.
    history : History
        Receives what the steps leave behind.

    Returns
    -------
    int
        -1, or the step that broke down.
    """
    kept = history.error.shape[0]
    before, defect = work.before, work.defect
    for i in range(ERRORS):
        error[i] = 0.0
    if given:
        difference(state, trajectory[first], options.composite, error)
    for k in range(first, last):
        j = k % kept
        at = trajectory[k] if given else state
        rows, innovation, variance = history.row[j], history.innovation[j], history.variance[j]
        count = measure(at, data, k, variances, options, terms, constants, rows, innovation, variance, work)
        total = update(covariance, error, rows, innovation, variance, count, history.gain[j], history.scale[j], work)
        if not math.isfinite(total):
            return k
        sums[0] += total
        sums[1] += count
        transition = history.transition[j]
        if given:
            for i in range(ERRORS):
                history.error[j, i] = error[i]
                for m in range(ERRORS):
                    history.covariance[j, i, m] = covariance[i, m]
            for i in range(STATES):
                before[i] = at[i]
        else:
            corrected(state, error, options.composite, before)
            for i in range(ERRORS):
                error[i] = 0.0
        for i in range(STATES):
            state[i] = before[i]
        propagate(state, data, k, options, terms, constants, transition, work)
        carry(covariance, transition, before, data.time[k], data.step, variances, options, terms, constants, work)
        magnitude = 0.0
        for i in range(STATES):
            magnitude += abs(state[i])
        if given:
            # The trajectory need not obey the equations of motion: what is missing at the end of the step.
            difference(state, trajectory[k + 1], options.composite, defect)
            for i in range(ERRORS):
                for m in range(ERRORS):
                    defect[i] += transition[i, m] * history.error[j, m]
            for i in range(ERRORS):
                error[i] = defect[i]
                magnitude += abs(error[i])
        elif k + 1 < trajectory.shape[0]:
            for i in range(STATES):
                trajectory[k + 1, i] = state[i]
        if not math.isfinite(magnitude):
            return k
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
    data, work, nowhere = problem.data, new_workspace(), np.zeros((0, STATES))
    error, history = np.zeros(ERRORS), new_history(1, data.range.shape[2], options)
    covariance[:] = separate_covariance(state, covariance, options.composite)

    def advance(first: int, last: int) -> int:
        return filter_steps(
            state, error, covariance, data, first, last, problem.variances, options, terms, problem.constants,
            problem.sums, nowhere, False, history, work,
        )  # fmt: skip

    return collected(problem, terms, advance, lambda: composite_covariance(state, covariance, options.composite))
