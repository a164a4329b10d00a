"""The largest step with which an estimator of the mast's antenna still works: readings further and further apart."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from sinsbench.scoring.mast import score_mast
from sinsbench.subjects.loading import LoadedSubject
from sinsdata.cases import CaseError, MastCase
from sinsdata.truth.mast import sampled
from sinsref.exact import ExactNumber

__all__ = ["FACTORS", "StableStep", "largest_stable_step"]

FACTORS = (1, 2, 4, 5, 10, 20)
"""Steps that are tried, in units of the case's."""


@dataclass(frozen=True)
class StableStep:
    """How far an estimator's step can be lengthened.

    Attributes
    ----------
    step : float or None
        The largest step up to which all that were tried work, s; None if not even the first does.
    rows : tuple of dict
        Scores (`sinsbench.scoring.mast.FIELDS`) of the steps that were tried, the last of them the first that fails.
    reason : str
        Why that one fails; empty if none did.
    """

    step: float | None
    rows: tuple[dict[str, Any], ...]
    reason: str


def largest_stable_step(loaded: LoadedSubject, case: MastCase, factors: Sequence[int] = FACTORS) -> StableStep:
    """Lengthen the step of a case until an estimator fails.

    A step works if the estimator comes to the end and, in the second half, the attitudes of vehicle and antenna err by
    less than at the start. Readings have the same noise a sample, as in the stratum ``step`` of the dataset.

    Parameters
    ----------
    loaded : LoadedSubject
    case : MastCase
    factors : sequence of int
        Increasing multiples of the case's step; those that do not divide its duration are left out.

    Returns
    -------
    StableStep

    Raises
    ------
    CaseError
        If none of the steps divides the duration.
    """
    # A case's numbers are exact; only rational ones can be told to divide one another.
    interval, duration = case.interval.fraction, case.duration.fraction
    tried = [k for k in factors if interval and duration and (duration / interval / k).denominator == 1]
    if not tried or interval is None:
        raise CaseError("interval", case.interval, f"no multiple of it divides {case.duration.text} s")
    rows: list[dict[str, Any]] = []
    step: float | None = None
    for factor in tried:
        longer = replace(case, run=None, interval=_exact(interval * factor))
        truth = sampled(longer)
        rows += score_mast(loaded, longer, truth, repetitions=0)
        if rows[-1]["status"] != "ok":
            return StableStep(step, tuple(rows), rows[-1]["message"])
        for name, first in (("mu", 0), ("nu", 9)):
            begin, end = float(np.linalg.norm(truth.start.errors[first : first + 3])), rows[-1][f"{name}_max_late"]
            if end >= begin:
                return StableStep(step, tuple(rows), f"{name} errs by {end:.3g} rad, by {begin:.3g} rad at the start")
        step = truth.interval
    return StableStep(step, tuple(rows), "")


def _exact(number: Fraction) -> ExactNumber:
    return ExactNumber(f"{number.numerator}/{number.denominator}")
