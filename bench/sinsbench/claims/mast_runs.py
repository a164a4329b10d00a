"""Runs on which the claims of Sokolov, Pogorelov, Reshetnikova 2024 are judged: estimators on cases of `mast_antenna`.

The paper says neither how many satellites there are nor how well they are measured, nor the errors of the start. The
cases are those of the tier ``paper``: N1 and N4 with one and four satellites, G1 to G3 by their noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.mast_errors import (
    COLUMNS,
    Estimates,
    checked_estimates,
    gauge_free_errors,
    inputs_of,
    start_of,
)
from sinsbench.subjects.mast import subjects
from sinsbench.subjects.mast.contract import BreakdownError
from sinsbench.subjects.mast.model import plain_matrix
from sinsdata.cases import MastCase
from sinsdata.tiers import cases_of
from sinsdata.truth.mast import MastMotion, sampled
from sinsref.exact import ExactNumber

__all__ = ["ANGLES", "DURATIONS", "Run", "angles", "nis_ratio", "run", "settled"]

Array = NDArray[np.float64]

DATASET = "mast_antenna"
DURATIONS: Mapping[str, str] = {
    **dict.fromkeys(("N4_G1", "N4_G3"), "1000"),
    **dict.fromkeys(("N4_G2", "N1_G1", "N1_G3"), "300"),
}
"""How long the cases of the tier ``paper`` are run, s: 1000 as in the paper where a claim may hold to the end; where it
fails before 300 s, that decides it. Those of the tier ``standard`` last as long as they do."""
BRIEF = "100"
"""Length of the runs that show what an error in a filter's equations does to its innovations, s."""
ANGLES = ("heading", "pitch", "roll")
"""Turns about the third, the first and the second axis, one after the other; the paper does not say which it means."""


@dataclass(frozen=True)
class Run:
    """What an estimator made of a case, at whole seconds.

    Attributes
    ----------
    time : ndarray, shape (m,)
        s; to where the estimator came.
    estimated, true : mapping of str to ndarray
        The names of `sinsbench.scoring.mast_errors.COLUMNS`.
    errors : mapping of str to ndarray
        The names of `sinsbench.scoring.mast_errors.QUANTITIES`.
    stopped : str
        Why the estimator stopped before the end; empty if it did not.
    """

    time: Array
    estimated: Mapping[str, Array]
    true: Mapping[str, Array]
    errors: Mapping[str, Array]
    stopped: str

    def components(self, name: str) -> Array:
        """Return the largest error of a quaternion's four numbers, its sign aside, over time."""
        given, true = self.estimated[name], self.true[name]
        side = np.where(np.sum(given * true, axis=1, keepdims=True) < 0, -1.0, 1.0)
        return np.asarray(np.abs(side * given - true).max(axis=1))


@cache
def _cases() -> Mapping[str, MastCase]:
    found = [case for tier in ("paper", "standard") for case in cases_of(DATASET, tier)]
    return {case.name: case for case in found if isinstance(case, MastCase)}


@lru_cache(maxsize=1)
def _truth(name: str, duration: str) -> MastMotion:
    case = _cases()[name]
    return sampled(replace(case, duration=ExactNumber(duration)) if duration else case)


@cache
def run(estimator: str, case: str, duration: str = "") -> Run:
    """Run an estimator on a case; what was run is kept.

    Parameters
    ----------
    estimator : str
        Name in `sinsbench.subjects.mast.catalogue.SUBJECTS`.
    case : str
        Name of a case of the tiers ``paper`` and ``standard``.
    duration : str
        s; as long as `DURATIONS` says by default.
    """
    truth = _truth(case, duration or DURATIONS.get(case, ""))
    stopped = ""
    try:
        result = getattr(subjects, estimator)(inputs_of(truth), start_of(truth.start))
    except BreakdownError as broken:
        result, stopped = broken.partial, str(broken)
    if stopped:
        finite = np.isfinite(np.column_stack([result[name] for name in COLUMNS])).all(axis=1)
        count = int(np.argmin(finite)) if not finite.all() else len(finite)
        rows = np.rint((result["time"][:count] - truth.time[0]) / truth.interval).astype(np.int64) * 2
        estimates = Estimates(rows, {name: result[name][:count] for name in COLUMNS}, None, None, None)
    else:
        estimates = checked_estimates(result, truth)
    true = {name: getattr(truth, "lam" if name == "lambda" else name)[estimates.rows] for name in COLUMNS}
    errors = gauge_free_errors(estimates, truth)
    return Run(truth.time[estimates.rows], estimates.values, true, errors, stopped)


@cache
def nis_ratio(estimator: str, case: str, duration: str = BRIEF) -> float:
    """Return normalised innovations squared over their degrees of freedom, from the start on.

    Infinite where they leave the range of binary64.
    """
    truth = _truth(case, duration)
    try:
        result = getattr(subjects, estimator)(inputs_of(truth), start_of(truth.start))
    except BreakdownError as broken:
        result = broken.partial
    finite = np.isfinite(result["nis"])
    if not finite.all():
        return float("inf")
    return float(result["nis"][-1] / result["nis_freedom"][-1])


def settled(time: Array, error: Array, limit: float) -> float:
    """Return the time from which on an error stays below a limit, s; infinite if it is not below it at the end."""
    above = np.flatnonzero(~(error < limit))
    if not above.size:
        return float(time[0])
    return float("inf") if above[-1] == len(error) - 1 else float(time[above[-1] + 1])


def angles(quaternions: Array) -> dict[str, Array]:
    """Return `ANGLES` of D(q), rad: D = D_2(roll) D_1(pitch) D_3(heading)."""
    matrices = np.array([plain_matrix(q) for q in quaternions])
    return {
        "heading": np.arctan2(-matrices[:, 1, 0], matrices[:, 1, 1]),
        "pitch": np.arcsin(np.clip(matrices[:, 1, 2], -1, 1)),
        "roll": np.arctan2(-matrices[:, 0, 2], matrices[:, 2, 2]),
    }
