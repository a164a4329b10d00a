"""Scores of what a test computed, and thresholds on them."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from sinsbench.pytest_plugin.cases import SuppliedCase, mast_motion
from sinsbench.scoring.gyroscopic import FIELDS as GYRO_FIELDS
from sinsbench.scoring.gyroscopic import LADDER as GYRO_LADDER
from sinsbench.scoring.gyroscopic import ladder as gyroscopic_ladder
from sinsbench.scoring.gyroscopic import score_gyroscopic
from sinsbench.scoring.ladders import LADDER
from sinsbench.scoring.mast import FIELDS as MAST_FIELDS
from sinsbench.scoring.mast import score_mast
from sinsbench.scoring.requirements import RequirementError, parse_requirement, violations
from sinsbench.scoring.rows import FIELDS
from sinsbench.scoring.score import score
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import Subject
from sinsdata.cases import GyroCase, MastCase

__all__ = ["ScoreFailureError", "Scores", "scores_of"]

#: What a failure shows of the scores, where it has a value.
_SHOWN = (
    *("attitude_error_max", "drift_deg_per_h", "secular_drift_deg_per_h", "velocity_error_max", "observed_order"),
    *("scd", "mescd", "input_floor", "vertical_error_max_m", "heading_error_max_arcsec"),
    *("mu_rms_late", "antenna_rms_late", "mast_rms_late", "position_rms_late", "nis_ratio"),
)


class ScoreFailureError(AssertionError):
    """A score misses its threshold, or there is none; the message tells the scores."""


class Scores(Mapping[str, Any]):
    """Scores of one subject on one case: the fields of the row at the case's own sampling interval.

    Parameters
    ----------
    rows : sequence of mapping
        One row for each sampling interval, coarsest first, as `sinsbench.scoring.score.score` returns them.
    interval : float
        The case's own, s.

    Attributes
    ----------
    rows : sequence of mapping
    """

    def __init__(self, rows: Sequence[Mapping[str, Any]], interval: float) -> None:
        self.rows = rows
        self._row = min(rows, key=lambda row: abs(row["interval"] - interval))

    def __getitem__(self, field: str) -> Any:
        if field not in self._row:
            near = difflib.get_close_matches(field, self._row, n=3, cutoff=0.4)
            raise KeyError(f"no score {field!r}; near it: {', '.join(near) or 'none'}")
        return self._row[field]

    def __iter__(self) -> Iterator[str]:
        return iter(self._row)

    def __len__(self) -> int:
        return len(self._row)

    def __repr__(self) -> str:
        row = self._row
        shown = [f"{name} {row[name]:.4g}" for name in _SHOWN if isinstance(row.get(name), float)]
        return f"<Scores of {row['subject']} on {row['case']}: {', '.join([row['status'], *shown])}>"

    def require(self, *conditions: str) -> Scores:
        """Check conditions on the fields, and return the scores.

        Parameters
        ----------
        conditions : str
            Such as ``"drift_deg_per_h<1e-3"``, as `sinsbench score --require` takes them.

        Raises
        ------
        ScoreFailureError
            If one does not hold; a field without a value meets none.
        ValueError
            If one cannot be understood.
        """
        __tracebackhide__ = True  # the test that asked is the place to look at
        try:
            requirements = [parse_requirement(text) for text in conditions]
        except RequirementError as error:
            raise ValueError(str(error).removeprefix("--require ")) from None
        if missed := violations(requirements, [self._row]):
            raise ScoreFailureError(self._told([line.removeprefix("does not hold: ") for line in missed]))
        return self

    def _told(self, lines: Sequence[str]) -> str:
        units = {field.name: field.unit for field in (*GYRO_FIELDS, *MAST_FIELDS, *FIELDS)}
        hint = [f"  {self._row['message']}"] if self._row["message"] else []
        values = [
            f"  {name} = {self._row[name]:.6g} {units[name]}".rstrip()
            for name in _SHOWN
            if isinstance(self._row.get(name), float)
        ]
        return "\n".join([*lines, *hint, *values])


def scores_of(case: SuppliedCase, answer: Any, name: str | None = None) -> Scores:
    """Score a function, or what one returned, on a case.

    Parameters
    ----------
    case : SuppliedCase
    answer : callable or result
        A function with the contract of the dataset is run on a ladder of sampling intervals, so that it has an observed
        order too; on ``mast_antenna`` it is run once. What a function returned for ``case.inputs`` is scored at the
        case's own interval.
    name : str, optional
        How to call it in messages; the function's own name by default.

    Raises
    ------
    ScoreFailureError
        If the function fails, or its result is none that can be scored: the status and the reason.
    """
    __tracebackhide__ = True
    subject = _subject(case, answer, name)
    if isinstance(case.case, GyroCase):
        factors = GYRO_LADDER if callable(answer) else (Fraction(1),)
        rows = score_gyroscopic(subject, case.case, gyroscopic_ladder(case.case, factors), repetitions=0)
    elif isinstance(case.case, MastCase):
        rows = score_mast(subject, case.case, mast_motion(case.case), repetitions=0)
    else:
        factors = LADDER if callable(answer) else (Fraction(1),)
        rows = score([subject], [case.case], factors=factors, repetitions=0)
    scores = Scores(rows, float(case.case.interval))
    if scores["status"] != "ok":
        raise ScoreFailureError(f"{subject.subject.name} on {case.name}: {scores['status']}: {scores['message']}")
    return scores


def _subject(case: SuppliedCase, answer: Any, name: str | None) -> LoadedSubject:
    own = name or getattr(answer, "__name__", None) or "result"
    if not callable(answer):
        subject = Subject(own, None, own, "", takes=case.takes or None)
        return LoadedSubject(subject, lambda *_, **__: answer, elsewhere=True)
    samples, takes = (getattr(answer, attribute, None) for attribute in ("samples_per_step", "takes"))
    samples = samples if type(samples) is int and samples > 0 else None
    return LoadedSubject(
        Subject(own, None, own, "", samples_per_step=samples, takes=takes or case.takes or None), answer
    )
