"""Leaderboards: each method's worst score over the cases, one board a dataset."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import log
from statistics import mean
from typing import Any, NamedTuple

from sinsbench.cli.scores import EQUATOR_ERRORS
from sinsbench.report.model import Table
from sinsbench.report.results import Row, real
from sinsbench.scoring.mast import NEES_TIMES
from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.tiers import cases_of, tiers_of

__all__ = ["BOARDS", "Board", "boards", "known_cases", "own_interval", "worst"]


class Column(NamedTuple):
    """A column of a board.

    Attributes
    ----------
    heading, field : str
        Heading and field of the scores.
    pick : callable
        Which of several values stands for all.
    times : tuple of int
        Times that the braces in heading and field stand for: the last one counts that all have a value at, s.
    """

    heading: str
    field: str
    pick: Callable[[Iterable[float]], float] = max
    times: tuple[int, ...] = ()

    def among(self, rows: Sequence[Row]) -> Column:
        """Return the column with the time that counts for rows; those with a value at no time are not asked."""
        if not self.times:
            return self
        told = [{time for time in self.times if real(row, self.field.format(time)) is not None} for row in rows]
        shared = set.intersection(*filter(None, told)) if any(told) else ()
        last = max(shared, default=self.times[0])
        return self._replace(heading=self.heading.format(last), field=self.field.format(last))


def _farthest_from_one(ratios: Iterable[float]) -> float:
    return max(ratios, key=lambda ratio: abs(log(ratio)) if ratio > 0 else float("inf"))


class Board(NamedTuple):
    """The leaderboard of a dataset.

    Methods are in the order of the first column: least first, or most first where the least counts as the worst.
    """

    title: str
    columns: tuple[Column, ...]


BOARDS: Mapping[str, Board] = {
    "dual_precession": Board(
        "Attitude and velocity on dual precession, at the cases' own sampling interval",
        (
            Column("drift, deg/h", "drift_deg_per_h"),
            Column("secular drift, deg/h", "secular_drift_deg_per_h"),
            Column("attitude error, rad", "attitude_error_max"),
            Column("velocity error, m/s", "velocity_error_max"),
            Column("order", "observed_order", min),
            Column("order by theory", "expected_order", min),
            Column("rate needed, Hz", "rate_needed_hz"),
            Column("operations a sample", "flops_per_sample"),
            Column("relative cost", "relative_cost", min),
        ),
    ),
    "equator_errors": Board(
        "Error equations on the equator",
        (
            Column("correct digits, mixed", "mescd", min),
            Column("correct digits", "scd", min),
            *(Column(heading, field) for heading, field in EQUATOR_ERRORS.items()),
            Column("ns a row", "ns_per_sample", min),
        ),
    ),
    "gyro_systems": Board(
        "Gyroscopic systems, R times the angle to the true vertical",
        (
            Column("largest, m", "vertical_error_max_m"),
            Column("after 1 h, m", "vertical_error_1h_m"),
            Column("after 2 h, m", "vertical_error_2h_m"),
            Column("after 4 h, m", "vertical_error_4h_m"),
            Column("heading, arcsec", "heading_error_max_arcsec"),
            Column("order", "observed_order", min),
            Column("ns a step", "ns_per_step", min),
        ),
    ),
    "mast_antenna": Board(
        "Estimators of the antenna on a mast, root mean squares of the second half (expected: NEES 16, NIS 1)",
        (
            Column("antenna to level, rad", "antenna_rms_late"),
            Column("vehicle, rad", "mu_rms_late"),
            Column("antenna to vehicle, rad", "nu_rms_late"),
            Column("mast, rad", "mast_rms_late"),
            Column("position, m", "position_rms_late"),
            Column("mean NEES at {} s", "nees_joint_{}s", mean, NEES_TIMES),
            Column("NIS", "nis_ratio", _farthest_from_one),
            Column("us a step", "us_per_step", min),
        ),
    ),
}
"""Boards by dataset; `worst` makes one of the fields that end in ``_max`` for a dataset that has none here."""

#: Datasets whose ladder goes to finer intervals than the case's own.
_FINER = {"dual_precession"}


def known_cases(dataset: str, names: Collection[str]) -> dict[str, Case]:
    """Return the cases of the tiers that have one of the names."""
    found: dict[str, Case] = {}
    for tier in tiers_of(dataset) if dataset in CASE_CLASSES else ():
        if set(names) <= found.keys():  # the cases of the larger tiers take a while to build
            break
        found |= {case.name: case for case in cases_of(dataset, tier) if case.name in names}
    return found


def own_interval(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of scores that were taken at the cases' own sampling intervals.

    A case of no tier is taken at the second interval of the ladder that its subjects share, as `sinsbench score`
    goes from twice the own one, or at the finest where the ladder ends with it.
    """
    found: list[Row] = []
    for dataset in dict.fromkeys(row["dataset"] for row in rows):
        own = [row for row in rows if row["dataset"] == dataset]
        known = known_cases(dataset, {row["case"] for row in own})
        for case in dict.fromkeys(row["case"] for row in own):
            of_case = [row for row in own if row["case"] == case]
            interval = float(known[case].interval) if case in known else None
            if interval is None or all(row["interval"] not in (None, interval) for row in of_case):
                interval = _shared_interval(of_case, finer=dataset in _FINER)
            found += [row for row in of_case if row["interval"] in (None, interval)]
    return found


def _shared_interval(rows: Sequence[Row], *, finer: bool) -> float | None:
    ladders: dict[str, set[float]] = {}
    for row in rows:
        if row["interval"] is not None:
            ladders.setdefault(row["subject"], set()).add(row["interval"])
    if not ladders:
        return None
    shared = sorted(set.intersection(*ladders.values()) or set.union(*ladders.values()), reverse=True)
    return shared[1] if finer and len(shared) > 1 else shared[-1]


def worst(dataset: str, rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return a row for each subject: the worst of its scores, the subject with the least error first.

    Parameters
    ----------
    dataset : str
    rows : sequence of mapping
        Scores at the cases' own intervals. Subjects that failed on cases stand behind the others.
    """
    board = BOARDS.get(dataset) or Board(
        "", tuple(Column(name.replace("_", " "), name) for name in rows[0] if name.endswith("_max"))
    )
    columns = [column.among(rows) for column in board.columns]
    table: list[dict[str, Any]] = []
    for subject in dict.fromkeys(row["subject"] for row in rows):
        own = [row for row in rows if row["subject"] == subject]
        good = [row for row in own if row["status"] == "ok"]
        line: dict[str, Any] = {"rank": None, "subject": subject}
        for column in columns:
            values = [value for row in good if (value := real(row, column.field)) is not None]
            line[column.heading] = column.pick(values) if values else None
        statuses = dict.fromkeys(row["status"] for row in own if row["status"] != "ok")
        table.append(line | {"cases": len(good), "failures": ", ".join(statuses)})
    if board.columns:
        leading, sign = board.columns[0].heading, -1.0 if board.columns[0].pick is min else 1.0
        table.sort(key=lambda line: (-line["cases"], line[leading] is None, sign * (line[leading] or 0.0)))
    for rank, line in enumerate(table, start=1):
        line["rank"] = rank if line["cases"] else None
    empty = [name for name in table[0] if all(line[name] in (None, "") for line in table)]
    return [{name: value for name, value in line.items() if name not in empty} for line in table]


def _comparable(rows: Sequence[Row]) -> tuple[list[Row], int]:
    """Return the rows on the cases that all subjects were scored on, and their number; all rows if there is none."""
    cases: dict[str, set[str]] = {}
    for row in rows:
        cases.setdefault(row["subject"], set()).add(row["case"])
    common = set.intersection(*cases.values())
    return [row for row in rows if not common or row["case"] in common], len(common)


def boards(scores: Sequence[Row]) -> tuple[Table, ...]:
    """Return the leaderboards of all datasets that were scored on.

    Parameters
    ----------
    scores : sequence of mapping
        Rows at the cases' own intervals.
    """
    tables = []
    scored = dict.fromkeys(row["dataset"] for row in scores)
    for dataset in (*(name for name in BOARDS if name in scored), *(name for name in scored if name not in BOARDS)):
        rows, common = _comparable([row for row in scores if row["dataset"] == dataset])
        title = BOARDS[dataset].title if dataset in BOARDS else dataset.replace("_", " ")
        worst_of = f"worst of the {common} cases that all were scored on" if common > 1 else "on one case"
        caption = f"{title}: {worst_of if common else 'worst case; not all were scored on the same ones'}"
        tables.append(Table(f"leaderboard_{dataset}", caption, worst(dataset, rows)))
    return tuple(tables)
