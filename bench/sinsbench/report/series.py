"""Errors over time of built-in subjects, computed when the report is made: scores hold the largest and the last.

A subject whose largest error is not the one that its row of scores holds is left out: that row is of another case of
the same name, or of other code.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import count
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.report.boards import known_cases
from sinsbench.report.results import Row, positive
from sinsbench.scoring.gyroscopic_errors import inputs_of, rows_at, start_of, vertical_error
from sinsbench.scoring.mast import NEES_TIMES, error_history
from sinsbench.scoring.mast_errors import BLOCKS, QUANTITIES
from sinsbench.scoring.mast_summary import family_of
from sinsbench.scoring.running import RunError, run
from sinsbench.scoring.runs import norms, run_rung
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import BUILT_IN, MAST_ANTENNA
from sinsdata.cases import Case, DualPrecessionCase, MastCase
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth import gyroscopic, mast
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

__all__ = ["CASES", "DEVIATIONS", "SERIES_FIELDS", "error_series"]

Array = NDArray[np.float64]
Progress = Callable[[int, int, str], None]

_OF_MAST = ("antenna", "mu", "nu", "mast", "position", "velocity")
SERIES_FIELDS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "dual_precession": (("attitude_error", "rad"), ("velocity_error", "m/s")),
    "gyro_systems": (("vertical_error", "m"),),
    MAST_ANTENNA: tuple((name, QUANTITIES[name][0]) for name in _OF_MAST),
}
"""Errors over time by dataset, with their units."""
DEVIATIONS = 3
"""Standard deviations that an estimator's own bound of an error is away from none."""

CASES = 2
"""Cases whose series are computed; of the mast's antenna all runs of a scenario of which there is one, if they fit."""
#: Instants of a series at most.
_INSTANTS = 64
#: Steps of estimators of the mast's antenna, of all that are run again on all cases: about a minute.
_MOST_STEPS = 1_000_000
#: How far from the second that is asked for an instant may be, s: steps are multiples of an interval in binary64.
_ON_TIME = 1e-6
#: How far the largest errors may be apart: a series is taken at fewer instants, and other machines round otherwise.
_SAME = 3.0


def error_series(
    scores: Sequence[Row],
    progress: Progress = lambda done, total, what: None,
    cases: Mapping[str, Mapping[str, Case]] = MappingProxyType({}),
) -> list[dict[str, Any]]:
    """Compute errors over time on the first cases that most of the subjects were scored on.

    Parameters
    ----------
    scores : sequence of mapping
        Rows at the cases' own intervals.
    progress : callable
        ``progress(done, total, what)``.
    cases : mapping of str to mapping of str to Case
        Dataset, then name: cases of no tier.

    Returns
    -------
    list of dict
        Rows with ``dataset, case, subject, time`` (s) and the fields of `SERIES_FIELDS`, of built-in subjects on cases
        of the tiers and those given. On gyroscopic systems also ``schuler_period`` (s). Of estimators of the mast's
        antenna, the best ones if there are many, also `DEVIATIONS` standard deviations that they give themselves,
        ``bound_`` and the name of the field, and ``nees_`` and the names of `sinsbench.scoring.mast_errors.BLOCKS`.
    """
    parts = [
        part
        for dataset in SERIES_FIELDS
        for part in _parts([row for row in scores if row["dataset"] == dataset], cases.get(dataset, {}))
    ]
    total, done = sum(len(own) for _, own in parts), count()

    def told(own: Sequence[Row]) -> Iterator[Row]:
        for row in own:
            progress(next(done), total, f"errors over time: {row['subject']} on {row['case']}")
            yield row

    return [line for case, own in parts for line in _GROWTH[type(case)](case, told(own))]


def _parts(rows: Sequence[Row], cases: Mapping[str, Case]) -> Iterator[tuple[Case, list[Row]]]:
    good = [row for row in rows if row["status"] == "ok" and row["subject"] in BUILT_IN]
    counts: dict[str, int] = {}
    for row in good:
        counts[row["case"]] = counts.get(row["case"], 0) + 1
    dataset = good[0]["dataset"] if good else ""
    known = {name: case for name, case in cases.items() if name in counts}
    known |= known_cases(dataset, counts.keys() - known.keys())
    order = sorted(known, key=lambda name: -counts[name])
    parts = [(known[name], [row for row in good if row["case"] == name]) for name in order]
    yield from _affordable(parts) if dataset == MAST_ANTENNA else parts[:CASES]


def _affordable(parts: Sequence[tuple[Any, list[Row]]]) -> Iterator[tuple[MastCase, list[Row]]]:
    """Yield the first parts, of each as many estimators as there is room for, and the other runs of their scenarios."""
    room, begun = _MOST_STEPS, dict[str | None, None]()
    for case, own in parts[:CASES]:
        own.sort(key=lambda row: positive(row, "antenna_rms_late") or np.inf)
        kept = own[: room // _steps(case)]
        room -= len(kept) * _steps(case)
        begun[family_of(case.name)] = None
        if kept:
            yield case, kept
    for family in filter(None, begun):
        others = [(case, own) for case, own in parts[CASES:] if family_of(case.name) == family]
        needed = sum(len(own) * _steps(case) for case, own in others)
        if needed <= room:
            room -= needed
            yield from others


def _steps(case: MastCase) -> int:
    return round(float(case.duration) / float(case.interval))


def _results(own: Iterable[Row], measure: Callable[[LoadedSubject], Any]) -> Iterator[tuple[Row, Any]]:
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


def _on_precession(case: DualPrecessionCase, own: Iterable[Row]) -> list[dict[str, Any]]:
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


def _on_sphere(case: GyroCase, own: Iterable[Row]) -> list[dict[str, Any]]:
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


def _on_mast(case: MastCase, own: Iterable[Row]) -> list[dict[str, Any]]:
    truth = mast.sampled(case)
    fields = [field for field, _ in SERIES_FIELDS[MAST_ANTENNA]]
    rows: list[dict[str, Any]] = []
    for row, history in _results(own, partial(error_history, truth=truth)):
        time = history["time"]
        late = time >= (time[0] + time[-1]) / 2
        largest = [{"antenna": float(history["antenna"][late].max())}]
        if not _same(row, largest, "antenna", "antenna_max_late"):
            continue
        # Most of what happens does so in the first seconds.
        places = np.geomspace(1, len(time) - 1, 2 * _INSTANTS).round().astype(np.intp)
        told = np.flatnonzero(np.abs(time[:, None] - NEES_TIMES).min(axis=1) < _ON_TIME)
        for place in np.union1d(places, told):
            line = {field: float(history[field][place]) for field in fields}
            if "nees_joint" in history:
                line |= {f"bound_{field}": DEVIATIONS * float(history[f"deviation_{field}"][place]) for field in fields}
                line |= {f"nees_{block}": float(history[f"nees_{block}"][place]) for block in BLOCKS}
            rows.append(_names(row, time[place]) | line)
    return rows


_GROWTH: Mapping[type, Callable[[Any, Iterable[Row]], list[dict[str, Any]]]] = {
    DualPrecessionCase: _on_precession,
    GyroCase: _on_sphere,
    MastCase: _on_mast,
}
