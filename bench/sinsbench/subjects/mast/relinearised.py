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

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.mast.contract import ERRORS, MastInputs, MastStart, Result
from sinsbench.subjects.mast.discrete import History, filter_steps, new_history
from sinsbench.subjects.mast.error_state import corrected
from sinsbench.subjects.mast.model import STATES, entry
from sinsbench.subjects.mast.running import collected, prepared
from sinsbench.subjects.mast.steps import Options, new_workspace
from sinsbench.subjects.mast.terms import CORRECTED, Terms

__all__ = ["WINDOWS", "relinearised_filter", "smooth"]

Array = NDArray[np.float64]

WINDOWS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Times at which the filter goes back to the start, s."""
PASSES = 10
"""How often it does so at most each time."""
SETTLED = 0.05
"""Largest move of the trajectory's ends, in standard deviations, after which there is no further pass."""
FULL_WEIGHT = Options(inflation=0.0)


@entry
def smooth(
    trajectory: Array,
    error: Array,
    covariance: Array,
    composite: float,
    steps: int,
    history: History,
    adjoint: Array,
) -> float:
    """Move a trajectory that the filter has run along to the smoothed one.

    Parameters
    ----------
    trajectory : ndarray, shape (steps + 1, 20) or longer
        Becomes the smoothed one.
    error, covariance : ndarray, shape (17,) and (17, 17)
        Its error at the end, which is overwritten, and the covariance there.
    composite : float
        Coordinates of the errors.
    steps : int
    history : History
        Of all of them.
    adjoint : ndarray, shape (17,)
        To work in.

    Returns
    -------
    float
        How far the ends of the trajectory moved at most, in standard deviations.
    """
    largest = 0.0
    for i in range(ERRORS):
        adjoint[i] = 0.0
        if covariance[i, i] > 0.0:
            largest = max(largest, abs(error[i]) / math.sqrt(covariance[i, i]))
    corrected(trajectory[steps], error, composite, trajectory[steps])
    for k in range(steps - 1, -1, -1):
        for i in range(ERRORS):
            value = 0.0
            for j in range(ERRORS):
                value += history.transition[k, j, i] * adjoint[j]
            error[i] = value
        for i in range(ERRORS):
            adjoint[i] = error[i]
        for i in range(ERRORS):
            value = history.error[k, i]
            for j in range(ERRORS):
                value -= history.covariance[k, i, j] * adjoint[j]
            error[i] = value
            # At the start too: along its own trajectory a first pass repeats the filter and does not move the end.
            if k == 0 and history.covariance[0, i, i] > 0.0:
                largest = max(largest, abs(value) / math.sqrt(history.covariance[0, i, i]))
        corrected(trajectory[k], error, composite, trajectory[k])
        for m in range(history.row.shape[1] - 1, -1, -1):
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
    trajectory, error, adjoint = np.zeros((windows[-1] + 1, STATES)), np.zeros(ERRORS), np.zeros(ERRORS)
    work, history = new_workspace(), new_history(windows[-1], data.range.shape[2], options)
    trajectory[0] = state

    def run(first: int, last: int, given: bool) -> int:
        return filter_steps(
            state, error, covariance, data, first, last, variances, options, terms, constants, problem.sums,
            trajectory, given, history, work,
        )  # fmt: skip

    def advance(first: int, last: int) -> int:
        while first < last:
            end = min([last, *(window for window in windows if window > first)])
            failed = run(first, end, False)
            if failed >= 0:
                return failed
            if end in windows:
                for _ in range(PASSES):
                    state[:], covariance[:], problem.sums[:] = prior, prior_covariance, 0.0
                    failed = run(0, end, True)
                    if failed >= 0:
                        return failed
                    if smooth(trajectory, error, covariance, options.composite, end, history, adjoint) < SETTLED:
                        break
                state[:] = trajectory[end]
            first = end
        return -1

    return collected(problem, terms, advance, lambda: covariance.copy())
