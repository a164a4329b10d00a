"""A discrete filter that goes back to the start while it is still learning: iterated smoothing over growing windows.

The errors of the first seconds are larger than the mast's constant length can be linearised for: 0.006 rad of tilt bend
Delta_Z by g theta^2 = 3.5e-4 m/s^2, more than twice the noise of that measurement. An extended filter therefore either
weakens the measurement at the start and loses accuracy, or trusts it and loses consistency for good: what was
linearised at a wrong place is never taken back.

Here the filter of `sinsbench.subjects.mast.discrete` is run again from t = 0 whenever the time reaches one of
`WINDOWS`, linearised along the smoothed trajectory of the window instead of along the filtered one, until it settles.
That is Gauss and Newton's iteration for the trajectory of greatest posterior probability (Bell 1994), so that all data
count in full and are linearised where they turn out to be. After the last window the filter simply goes on.

The backward pass is that of Bryson and Frazier 1963 for scalar measurements (Bierman 1973): it inverts no covariance,
and those of the mast are singular along the twist that the start knows exactly.

References
----------
B. M. Bell, The iterated Kalman smoother as a Gauss-Newton method, SIAM Journal on Optimization 4 (1994) 626-636.
G. J. Bierman, Fixed interval smoothing with discrete measurements, International Journal of Control 18 (1973) 65-75.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.mast.contract import ERRORS, MastInputs, MastStart, Result
from sinsbench.subjects.mast.discrete import filter_steps
from sinsbench.subjects.mast.error_state import corrected, difference
from sinsbench.subjects.mast.model import STATES, Constants, entry
from sinsbench.subjects.mast.running import collected, prepared
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

__all__ = ["WINDOWS", "History", "relinearised_filter", "smooth"]

Array = NDArray[np.float64]

WINDOWS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Times at which the filter goes back to the start, s."""
PASSES = 10
"""How often it does so at most each time."""
SETTLED = 0.05
"""Largest move of the trajectory's ends, in standard deviations, after which there is no further pass."""
FULL_WEIGHT = Options(inflation=0.0)


class History(NamedTuple):
    """What a forward pass leaves for the backward pass, one row a step."""

    error: Array
    covariance: Array
    transition: Array
    row: Array
    gain: Array
    innovation: Array
    scale: Array


def new_history(steps: int, satellites: int) -> History:
    """Allocate the history of a window."""
    m = 2 * satellites + 4
    return History(
        np.zeros((steps, ERRORS)),
        np.zeros((steps, ERRORS, ERRORS)),
        np.zeros((steps, ERRORS, ERRORS)),
        np.zeros((steps, m, ERRORS)),
        np.zeros((steps, m, ERRORS)),
        np.zeros((steps, m)),
        np.zeros((steps, m)),
    )


@entry
def smooth(
    reference: Array,
    prior: Array,
    covariance: Array,
    data: Data,
    steps: int,
    variances: Variances,
    options: Options,
    terms: Terms,
    constants: Constants,
    sums: Array,
    history: History,
    work: Workspace,
) -> float:
    """Run filter and smoother once along a trajectory and move the trajectory to the smoothed one.

    Parameters
    ----------
    reference : ndarray, shape (steps + 1, 20) or longer
        The trajectory that everything is linearised along; becomes the smoothed one.
    prior : ndarray, shape (20,)
        Estimate at the start.
    covariance : ndarray, shape (17, 17)
        Its covariance; becomes that at the end.
    data, variances, options, terms, constants
        As the functions of `sinsbench.subjects.mast.steps` take them.
    steps : int
    sums : ndarray, shape (2,)
        Becomes the sum of the normalised innovations squared of this pass and their number.
    history : History
        Of at least that many steps.

    Returns
    -------
    float
        How far the ends of the trajectory moved at most, in standard deviations, or -1 - k where step k broke down.
    """
    variance, state = np.zeros(history.row.shape[1]), np.zeros(STATES)
    error, defect = np.zeros(ERRORS), np.zeros(ERRORS)
    sums[0], sums[1] = 0.0, 0.0
    difference(prior, reference[0], options.composite, error)
    for k in range(steps):
        rows, innovation = history.row[k], history.innovation[k]
        count = measure(reference[k], data, k, variances, options, terms, constants, rows, innovation, variance, work)
        total = update(covariance, error, rows, innovation, variance, count, history.gain[k], history.scale[k], work)
        if not math.isfinite(total):
            return -1.0 - k
        sums[0] += total
        sums[1] += count
        for i in range(ERRORS):
            history.error[k, i] = error[i]
            for j in range(ERRORS):
                history.covariance[k, i, j] = covariance[i, j]
        for i in range(STATES):
            state[i] = reference[k, i]
        transition = history.transition[k]
        propagate(state, data, k, options, terms, constants, transition, work)
        t, at = data.time[k], reference[k]
        carry(covariance, transition, at, t, data.step, variances, options, terms, constants, work)
        # The trajectory need not obey the equations of motion: what is missing at the end of the step.
        difference(state, reference[k + 1], options.composite, defect)
        for i in range(ERRORS):
            for j in range(ERRORS):
                defect[i] += transition[i, j] * history.error[k, j]
        for i in range(ERRORS):
            error[i] = defect[i]
            if not math.isfinite(error[i]):
                return -1.0 - k
    largest = 0.0
    for i in range(ERRORS):
        if covariance[i, i] > 0.0:
            largest = max(largest, abs(error[i]) / math.sqrt(covariance[i, i]))
    for i in range(STATES):
        state[i] = reference[steps, i]
    corrected(state, error, options.composite, reference[steps])
    adjoint, moved = np.zeros(ERRORS), np.zeros(ERRORS)
    for k in range(steps - 1, -1, -1):
        for i in range(ERRORS):
            value = 0.0
            for j in range(ERRORS):
                value += history.transition[k, j, i] * adjoint[j]
            moved[i] = value
        for i in range(ERRORS):
            adjoint[i] = moved[i]
        for i in range(ERRORS):
            value = history.error[k, i]
            for j in range(ERRORS):
                value -= history.covariance[k, i, j] * adjoint[j]
            error[i] = value
            # At the start too: along its own trajectory a first pass repeats the filter and does not move the end.
            if k == 0 and history.covariance[0, i, i] > 0.0:
                largest = max(largest, abs(value) / math.sqrt(history.covariance[0, i, i]))
        for i in range(STATES):
            state[i] = reference[k, i]
        corrected(state, error, options.composite, reference[k])
        for m in range(count - 1, -1, -1):
            along = history.innovation[k, m] / history.scale[k, m]
            for i in range(ERRORS):
                along += history.gain[k, m, i] * adjoint[i]
            for i in range(ERRORS):
                adjoint[i] -= along * history.row[k, m, i]
    return largest


def relinearised_filter(
    inputs: MastInputs, start: MastStart, options: Options = FULL_WEIGHT, terms: Terms = CORRECTED
) -> Result:
    """Estimate by the discrete filter, relinearised from the start whenever the time reaches one of `WINDOWS`.

    Parameters, result and errors are those of `sinsbench.subjects.mast.discrete.discrete_filter`; the coordinates
    must be composite.
    """
    problem = prepared(inputs, start, terms)
    data, variances, constants, state, covariance = problem[:5]
    prior, prior_covariance = state.copy(), covariance.copy()
    steps = len(data.rate1)
    windows = [min(steps, round(window / data.step)) for window in WINDOWS]
    work, reference = new_workspace(), np.zeros((windows[-1] + 1, STATES))
    history = new_history(windows[-1], data.range.shape[2])
    reference[0] = state

    def plain(first: int, last: int) -> int:
        return filter_steps(
            state, covariance, data, first, last, variances, options, terms, constants, problem.sums, reference, work
        )

    def advance(first: int, last: int) -> int:
        while first < last:
            end = min([last, *(window for window in windows if window > first)])
            failed = plain(first, end)
            if failed >= 0:
                return failed
            if end in windows:
                for _ in range(PASSES):
                    covariance[:] = prior_covariance
                    moved = smooth(
                        reference, prior, covariance, data, end, variances, options, terms, constants, problem.sums,
                        history, work,
                    )  # fmt: skip
                    if moved < 0.0:
                        return int(-1.0 - moved)
                    if moved < SETTLED:
                        break
                state[:] = reference[end]
            first = end
        return -1

    return collected(problem, terms, advance, lambda: covariance.copy())
