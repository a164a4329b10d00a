"""Runs on which the claims of Sokolov, Pogorelov, Reshetnikova 2024 are judged: estimators on cases of `mast_antenna`.

The paper says neither how many satellites there are nor how well they are measured, nor the errors of the start. The
cases are those of the tier ``paper``: N1 and N4 with one and four satellites, G1 to G3 by their noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cache, lru_cache
from typing import Any

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
from sinsdata.truth.mast_blocks import GridModel
from sinsref.exact import ExactNumber

__all__ = ["ANGLES", "DURATIONS", "Run", "angles", "changed_sizes", "nis_ratio", "run", "settled"]

Array = NDArray[np.float64]

DATASET = "mast_antenna"
DURATIONS: Mapping[tuple[str, str], str] = {
    ("cekf", "N1_G1"): "250",
    ("cekf", "N4_G1"): "600",
    ("mekf_nu_az", "N1_G1"): "250",
    ("mekf_nu_az", "N4_G1"): "1000",
    ("mekf_nu_az", "N4_G2"): "300",
    ("mekf_nu_az", "N4_G3"): "600",
}
"""How long estimators are run on cases of the tier ``paper``, s: 1000 as in the paper where most claims may hold to the
end; where they fail before, that decides them."""
BRIEF = "20"
"""Length of the runs that show what an error in a filter's equations does, s."""
SEEDS = tuple(range(1000, 1008))
"""Seeds of noise and initial errors over which a change of the mast's motion is judged."""
CHANGED: Mapping[str, Any] = {"duration": ExactNumber("100"), "interval": ExactNumber("0.05")}
"""Length of these runs and their step, s: five times the paper's, for time; ratios of errors are judged."""
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
    found = (*_paper_cases().values(), *cases_of(DATASET, "standard"))
    return {case.name: case for case in found if isinstance(case, MastCase)}


@cache
def _paper_cases() -> Mapping[str, MastCase]:
    return {case.name: case for case in cases_of(DATASET, "paper") if isinstance(case, MastCase)}


@lru_cache(maxsize=2)
def _motion(duration: str) -> MastMotion:
    """Return the paper's motion with four satellites, which the cases of the tier ``paper`` share."""
    return sampled(replace(_cases()["N4_G1"], duration=ExactNumber(duration)))


def _truth(name: str, duration: str) -> MastMotion:
    """Return the first part of a case; those of the tier ``paper`` are one motion, which each measures in its way."""
    case = replace(_cases()[name], duration=ExactNumber(duration))
    if name not in _paper_cases():
        return sampled(case)
    whole = _motion(BRIEF if float(duration) <= float(BRIEF) else max(DURATIONS.values(), key=float))
    steps, used = case.samples, case.satellite_count
    rows = {whole.steps: steps, 2 * whole.steps + 1: 2 * steps + 1}
    arrays = {field.name: getattr(whole, field.name) for field in fields(whole)}
    own: dict[str, Any] = {
        name: x[: rows[len(x)]] for name, x in arrays.items() if isinstance(x, np.ndarray) and len(x) in rows
    }
    own |= {name: own[name][:, :used] for name in ("satellite_position", "satellite_velocity", "range_rate", "range")}
    for name, noise in zip(("range_rate", "range"), GridModel(case).measurement_noise(0, steps + 1), strict=True):
        own |= {f"{name}_noise": noise[:, :used], f"{name}_sd": float(getattr(case, f"{name}_sd"))}
    return replace(whole, case_name=case.name, **own)


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
    return _run(estimator, _truth(case, duration or DURATIONS[estimator, case]))


def _run(estimator: str, truth: MastMotion) -> Run:
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


@cache
def changed_sizes(estimator: str, case: str) -> Mapping[str, Array]:
    """Return root mean square errors over the second half of runs as `CHANGED` says, one with each of `SEEDS`.

    Parameters
    ----------
    estimator : str
        One that bears the step.
    case : str
        Name of a case of the tier ``standard``, whose motion it is; its seeds are not used.

    Returns
    -------
    mapping of str to ndarray, shape (8,)
        The names of `sinsbench.scoring.mast_errors.QUANTITIES`.
    """
    # The paper's long motion has no use here, and 130 MB.
    _motion.cache_clear()
    sizes: dict[str, list[float]] = {}
    for seed in map(ExactNumber, SEEDS):
        found = _run(estimator, sampled(replace(_cases()[case], seed=seed, error_seed=seed, **CHANGED)))
        late = found.time >= float(CHANGED["duration"]) / 2
        for name, error in found.errors.items():
            sizes.setdefault(name, []).append(float(np.sqrt(np.mean(error[late] ** 2))))
    return {name: np.array(values) for name, values in sizes.items()}


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
