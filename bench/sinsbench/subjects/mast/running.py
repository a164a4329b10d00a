"""What all estimators of the mast's antenna share around their loops: preparing the arrays, collecting the rows."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.mast.contract import STRIDE, BreakdownError, MastInputs, MastStart, Result
from sinsbench.subjects.mast.error_state import THETA_LAMBDA, THETA_NU
from sinsbench.subjects.mast.model import (
    ETA,
    HEIGHT,
    LAMBDA,
    LATITUDE,
    LONGITUDE,
    MU,
    RATE,
    VELOCITY,
    Constants,
    plain_matrix,
)
from sinsbench.subjects.mast.steps import Data, Variances
from sinsbench.subjects.mast.terms import Terms

__all__ = ["Problem", "collected", "composite_covariance", "is_positive", "prepared", "separate_covariance"]

Array = NDArray[np.float64]
Advance = Callable[[int, int], int]


class Problem(NamedTuple):
    """What a loop over steps works on.

    Attributes
    ----------
    data : Data
    variances : Variances
    constants : Constants
    state, covariance : ndarray, shape (20,) and (17, 17)
        Initial estimate; a loop changes them.
    sums : ndarray, shape (2,)
        Normalised innovations squared and their degrees of freedom, added up.
    """

    data: Data
    variances: Variances
    constants: Constants
    state: Array
    covariance: Array
    sums: Array


BROKEN = "the estimate is not finite or its covariance no longer positive"
"""What a step that fails means."""
INDEFINITE = "the covariance is no longer positive: a smaller step may keep it so"
_NOTHING, _ROUNDING = 1e-12, 1e-9


def prepared(inputs: MastInputs, start: MastStart, terms: Terms) -> Problem:
    """Check inputs and start and turn them into arrays.

    Where the equations hold relative rates of the mast, the initial ones are made relative with the first sample of
    the vehicle's gyroscopes.

    Raises
    ------
    ValueError
        As `MastInputs.checked` and `MastStart.checked` do.
    """
    checked = inputs.checked()
    state, covariance = start.checked()
    state[RATE:] -= terms.relative * (plain_matrix(state[LAMBDA : LAMBDA + 4]) @ checked.rate1[0, 0])[:2]
    noise = checked.noise
    data = Data(
        checked.time,
        checked.rate1,
        checked.specific_force1,
        checked.rate2,
        checked.specific_force2,
        checked.satellite_position,
        checked.satellite_velocity,
        checked.range_rate,
        checked.range,
        checked.step,
    )
    deviations = (noise.rate1, noise.specific_force1, noise.rate2, noise.specific_force2, noise.antenna_rate)
    variances = Variances(*(float(x) ** 2 for x in (*deviations, noise.range_rate, noise.range)))
    constants = Constants(*map(float, checked.constants))
    return Problem(data, variances, constants, state, np.array(covariance), np.zeros(2))


def composite_covariance(state: Array, covariance: Array, composite: float) -> Array:
    """Covariance in the coordinates of the contract: theta_nu = theta_eta + D(eta) theta_lambda."""
    return _changed(state, covariance, 1.0 - composite)


def separate_covariance(state: Array, covariance: Array, composite: float) -> Array:
    """Covariance of the contract in a filter's own coordinates, the inverse of `composite_covariance`."""
    return _changed(state, covariance, composite - 1.0)


def _changed(state: Array, covariance: Array, factor: float) -> Array:
    change = np.eye(len(covariance))
    nu, tilt = slice(THETA_NU, THETA_NU + 3), slice(THETA_LAMBDA, THETA_LAMBDA + 3)
    change[nu, tilt] = factor * plain_matrix(state[ETA : ETA + 4])
    return np.asarray(change @ covariance @ change.T)


def is_positive(covariance: Array, size: Array) -> bool:
    """Whether a covariance is one: the correlations have no negative eigenvalue but by rounding.

    Parameters
    ----------
    covariance : ndarray, shape (n, n)
    size : ndarray, shape (n,)
        Variances to compare with: what is 1e-12 of them is zero.
    """
    variances = np.diag(covariance)
    known = np.abs(variances) <= _NOTHING * size
    if (variances[~known] < 0).any():
        return False
    scale = np.sqrt(variances[~known])
    part = covariance[~known][:, ~known] / np.outer(scale, scale)
    return bool(np.linalg.eigvalsh(part)[0] > -_ROUNDING)


def collected(problem: Problem, terms: Terms, advance: Advance, error_covariance: Callable[[], Array]) -> Result:
    """Run a loop from row to row.

    Parameters
    ----------
    problem : Problem
    terms : Terms
    advance : callable
        ``advance(first, last)`` runs the steps first ... last - 1 on `problem` and returns -1 or the step that failed.
    error_covariance : callable
        Returns the covariance of the errors, in the coordinates of the contract, at this moment.

    Raises
    ------
    BreakdownError
        If a step fails, or a row's covariance is no longer positive: an explicit method of integration does not keep
        it so.
    """
    data, state = problem.data, problem.state
    steps = len(data.rate1)
    stride = max(1, round(STRIDE / data.step))
    ends = range(0, steps + 1, stride)
    states: list[Array] = []
    covariances: list[Array] = []
    sums: list[Array] = []
    times = data.time[ends.start : ends.stop : stride]

    def record(k: int) -> None:
        row = state.copy()
        shown = data.rate1[k, 0] if k < steps else data.rate1[-1, 2]
        row[RATE:] += terms.relative * (plain_matrix(row[LAMBDA : LAMBDA + 4]) @ shown)[:2]
        states.append(row)
        covariances.append(covariance)
        sums.append(problem.sums.copy())

    covariance = error_covariance()
    size = np.diag(covariance).copy()
    size[THETA_LAMBDA + 2] = max(size[THETA_LAMBDA : THETA_LAMBDA + 3])  # the twist may be known exactly at the start
    record(0)
    for end in ends[1:]:
        failed = advance(end - stride, end)
        if failed >= 0:
            raise BreakdownError(BROKEN, float(data.time[failed]), _rows(times, states, covariances, sums))
        covariance = error_covariance()
        record(end)
        if not is_positive(covariance, size):
            raise BreakdownError(INDEFINITE, float(data.time[end]), _rows(times, states, covariances, sums))
    return _rows(times, states, covariances, sums)


def _rows(times: Array, states: list[Array], covariances: list[Array], sums: list[Array]) -> Result:
    y, total = np.array(states), np.array(sums)
    return {
        "time": np.array(times[: len(y)]),
        "mu": y[:, MU : MU + 4],
        "longitude": y[:, LONGITUDE],
        "latitude": y[:, LATITUDE],
        "velocity": y[:, VELOCITY : VELOCITY + 3],
        "height": y[:, HEIGHT],
        "eta": y[:, ETA : ETA + 4],
        "lambda": y[:, LAMBDA : LAMBDA + 4],
        "mast_rate": y[:, RATE:],
        "covariance": np.array(covariances),
        "nis": total[:, 0],
        "nis_freedom": total[:, 1],
    }
