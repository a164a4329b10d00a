"""Errors over time of built-in subjects, computed when the report is made: scores hold the largest and the last.

A subject whose largest error is not the one that its row of scores holds is left out: that row is of another case of
the same name, or of other code.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.report.boards import known_cases
from sinsbench.report.results import Row, positive
from sinsbench.scoring.gyroscopic_errors import inputs_of, rows_at, start_of, vertical_error
from sinsbench.scoring.running import RunError, run
from sinsbench.scoring.runs import norms, run_rung
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import BUILT_IN
from sinsdata.cases import Case, DualPrecessionCase
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth import gyroscopic
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

__all__ = ["SERIES_FIELDS", "error_series"]

Array = NDArray[np.float64]
Progress = Callable[[int, int, str], None]

SERIES_FIELDS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "dual_precession": (("attitude_error", "rad"), ("velocity_error", "m/s")),
    "gyro_systems": (("vertical_error", "m"),),
}
"""Errors over time by dataset, with their units."""

#: Instants of a series at most, and cases whose series are computed.
_INSTANTS, _CASES = 64, 2
#: How far the largest errors may be apart: a series is taken at fewer instants, and other machines round otherwise.
_SAME = 3.0


def error_series(scores: Sequence[Row], progress: Progress = lambda done, total, what: None) -> list[dict[str, Any]]:
    """Compute errors over time on the first cases that most of the subjects were scored on.

    Parameters
    ----------
    scores : sequence of mapping
        Rows at the cases' own intervals.
    progress : callable
        ``progress(done, total, what)``.

    Returns
    -------
    list of dict
        Rows with ``dataset, case, subject, time`` (s) and the fields of `SERIES_FIELDS`, of built-in subjects on cases
        of the tiers. On gyroscopic systems also ``schuler_period`` (s).
    """
    parts = [part for dataset in SERIES_FIELDS for part in _parts([x for x in scores if x["dataset"] == dataset])]
    rows: list[dict[str, Any]] = []
    for number, (case, own) in enumerate(parts):
        progress(number, len(parts), f"errors over time on {case.name}")
        rows += _GROWTH[type(case)](case, own)
    return rows


def _parts(rows: Sequence[Row]) -> Iterator[tuple[Case, list[Row]]]:
    good = [row for row in rows if row["status"] == "ok" and row["subject"] in BUILT_IN]
    counts: dict[str, int] = {}
    for row in good:
        counts[row["case"]] = counts.get(row["case"], 0) + 1
    dataset = good[0]["dataset"] if good else ""
    known = known_cases(dataset, counts)
    for name in sorted(known, key=lambda name: -counts[name])[:_CASES]:
        yield known[name], [row for row in good if row["case"] == name]


def _results(own: Sequence[Row], measure: Callable[[LoadedSubject], Any]) -> Iterator[tuple[Row, Any]]:
    for row in own:
        with contextlib.suppress(RunError):
            yield row, measure(resolve(row["subject"]))


def _same(row: Row, lines: Sequence[Row], name: str, field: str) -> bool:
    """Return whether a series is of what the row of scores is of, as far as largest errors tell."""
    largest, own = positive(row, field), max((line[name] for line in lines if name in line), default=None)
    return largest is None or own is None or row.get("at_floor") is True or largest / _SAME <= own <= largest * _SAME


def _stride(samples: int) -> int:
    """Return the distance of the instants in samples: a divisor, of whole steps of four samples where there is one."""
    divisors = [n for n in range(1, samples + 1) if samples % n == 0 and samples // n <= _INSTANTS]
    return next((n for n in divisors if n % 4 == 0), divisors[0])


def _on_precession(case: DualPrecessionCase, own: Sequence[Row]) -> list[dict[str, Any]]:
    motion = sample(case, Fraction(1), ExactNumber(f"({case.interval.text})*{_stride(case.samples)}"), "increments")
    rows: list[dict[str, Any]] = []
    for row, found in _results(own, partial(run_rung, motion=motion, repetitions=0, warm=True)):
        errors = {"attitude_error": found.attitude, "velocity_error": found.velocity}
        sizes = {name: norms(error) for name, error in errors.items() if error is not None}
        # At the start there is no error.
        lines = [
            {**_names(row, time), **{name: float(size[place]) for name, size in sizes.items()}}
            for place, time in enumerate(found.time)
            if place
        ]
        rows += lines if _same(row, lines, "attitude_error", "attitude_error_max") else []
    return rows


def _names(row: Row, time: float) -> dict[str, Any]:
    return {"dataset": row["dataset"], "case": row["case"], "subject": row["subject"], "time": float(time)}


def _on_sphere(case: GyroCase, own: Sequence[Row]) -> list[dict[str, Any]]:
    truth = gyroscopic.sampled(case)
    radius, gravity = float(case.radius), float(case.gravity)
    period = float(2 * np.pi * np.sqrt(radius / gravity))
    start = start_of(truth, radius, gravity)

    def distances(loaded: LoadedSubject) -> tuple[Array, Array]:
        inputs = inputs_of(truth, increments=loaded.subject.takes == "increments")
        vertical = np.asarray(run(loaded.function, (inputs, start), 0, True).result["vertical"])
        return rows_at(truth.time, len(vertical)), vertical_error(vertical, truth).angle * radius

    rows: list[dict[str, Any]] = []
    for row, (time, error) in _results(own, distances):
        at = np.unique(np.linspace(1, len(time) - 1, min(_INSTANTS, len(time) - 1)).round().astype(np.intp))
        lines = [
            {**_names(row, time[place]), "vertical_error": float(error[place]), "schuler_period": period}
            for place in at
        ]
        rows += lines if _same(row, lines, "vertical_error", "vertical_error_max_m") else []
    return rows


_GROWTH: Mapping[type, Callable[[Any, Sequence[Row]], list[dict[str, Any]]]] = {
    DualPrecessionCase: _on_precession,
    GyroCase: _on_sphere,
}
