"""The sections of a report about scores, and all of them in order; one without results is absent."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from sinsbench.cli.scores import EQUATOR_ERRORS
from sinsbench.report import charts, findings, mast
from sinsbench.report.boards import known_cases, own_interval
from sinsbench.report.model import Section, Table
from sinsbench.report.picking import picked, places, short
from sinsbench.report.results import Results, Row, positive, real
from sinsbench.report.series import SERIES_FIELDS, Progress, error_series
from sinsbench.report.stability import places_of, stability_charts, stability_limits, stability_map
from sinsdata.cases import EquatorCase

__all__ = ["sections"]

#: Rows that the charts of a section draw at most; of more, the first cases are drawn.
_MOST_POINTS = 2500
#: What the charts of secular and periodic parts need besides the errors.
_PARTS = ["attitude_periodic_max", "secular_velocity_rate", "velocity_periodic_max"]
_SECULAR_TABLE = {
    "subject": "subject",
    "case": "case",
    "secular drift, deg/h": "secular_drift_deg_per_h",
    "periodic attitude, rad": "attitude_periodic_max",
    "secular velocity rate, m/s²": "secular_velocity_rate",
    "periodic velocity, m/s": "velocity_periodic_max",
    "predicted secular drift, deg/h": "predicted_secular_drift_deg_per_h",
}
_EQUATOR_TABLE = {
    "subject": "subject",
    "case": "case",
    **EQUATOR_ERRORS,
    "correct digits": "scd",
    "mixed": "mescd",
    "ns a row": "ns_per_sample",
    "status": "status",
    "message": "message",
}
_GYRO_TABLE = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "largest, m": "vertical_error_max_m",
    "after 1 h, m": "vertical_error_1h_m",
    "after 2 h, m": "vertical_error_2h_m",
    "heading, arcsec": "heading_error_max_arcsec",
    "pitch, arcsec": "pitch_error_max_arcsec",
    "roll, arcsec": "roll_error_max_arcsec",
    "order": "observed_order",
    "period of the error, s": "error_period",
    "ns a step": "ns_per_step",
    "status": "status",
    "message": "message",
}
_GROWTH_TITLES = {
    "dual_precession": ("Error over time", "Over time"),
    "gyro_systems": ("Gyroscopic systems: error over time", "Gyroscopic: over time"),
}


def _in_charts(rows: Sequence[Row]) -> tuple[str, ...]:
    """Return the cases that charts can hold, the one with the most rows first."""
    counts: dict[str, int] = {}
    for row in rows:
        counts[row["case"]] = counts.get(row["case"], 0) + 1
    kept: list[str] = []
    points = 0
    for case in sorted(counts, key=lambda case: -counts[case]):
        points += counts[case]
        if kept and points > _MOST_POINTS:
            break
        kept.append(case)
    return tuple(kept)


def _told_of_cases(shown: Collection[str], rows: Sequence[Row]) -> str:
    cases = {row["case"] for row in rows}
    return "" if len(shown) == len(cases) else f" The charts show {len(shown)} of {len(cases)} cases."


class _Ladder(NamedTuple):
    """What the sections about the ladders of a dataset are called, and the table of orders in them."""

    work: tuple[str, str, str]
    orders: tuple[str, str, str]
    table: Mapping[str, str]


_LADDERS = {
    "dual_precession": _Ladder(
        ("work_precision", "Work and precision", "Work"),
        ("ladders", "Order ladders", "Orders"),
        {
            "subject": "subject",
            "case": "case",
            "attitude order": "observed_order",
            "by theory": "expected_order",
            "residual, log2": "order_residual",
            "points": "order_points",
            "secular order": "secular_observed_order",
            "secular by theory": "secular_expected_order",
            "narrow cone": "narrow_cone_order",
            "velocity order": "velocity_observed_order",
            "velocity by theory": "velocity_expected_order",
            "without an order because": "order_note",
        },
    ),
    "gyro_systems": _Ladder(
        ("gyroscopic_work", "Gyroscopic systems: work and precision", "Gyroscopic: work"),
        ("gyroscopic_ladders", "Gyroscopic systems: order ladders", "Gyroscopic: orders"),
        {
            "subject": "subject",
            "case": "case",
            "order of the method": "observed_order",
            "residual, log2": "order_residual",
            "points": "order_points",
        },
    ),
}


def _a_second(row: Row) -> dict[str, Any]:
    """Return a row with the cost of a second of motion, where it tells the cost of a step."""
    step, interval, samples = (positive(row, name) for name in ("ns_per_step", "interval", "samples_per_step"))
    return {**row, "ns_per_second": step / interval / samples} if step and interval and samples else dict(row)


def _ladders(scores: Sequence[Row], dataset: str) -> Iterator[Section]:
    """Yield the sections about a ladder of sampling intervals: work and precision, orders, secular parts."""
    rows = [row for row in scores if row["dataset"] == dataset and row["status"] == "ok"]
    if not rows:
        return
    told = _LADDERS[dataset]
    own = {id(row) for row in own_interval(rows)}
    cases = _in_charts(rows)
    names = places(scores, dataset, rows)
    fields = ["subject", "case", "interval", "observed_order", "flops_per_second", "ns_per_second"]
    fields += [name for measure in charts.MEASURES[dataset] for name in (measure.field, measure.at_floor)]
    fields += _PARTS if dataset == "dual_precession" else ()
    name = f"scores_{dataset}"
    drawn = [short(_a_second(row), fields) | {"own": id(row) in own} for row in rows if row["case"] in cases]
    common: dict[str, Any] = {
        "data": {name: drawn},
        "series": names,
        "cases": cases,
        "files": {"scores": scores},
    }
    scope = _told_of_cases(cases, rows)
    if work := charts.work_precision(name, drawn, names, cases[0], dataset):
        yield Section(
            *told.work,
            "What each method spends for its error. A method that lies below and to the left of another is better in "
            "both; operations are counted, times were measured." + scope,
            charts=tuple(work),
            **common,
        )
    if steps := charts.ladders(name, drawn, names, cases[0], dataset):
        firsts = {(row["subject"], row["case"]): row for row in rows}
        yield Section(
            *told.orders,
            "The same motion at a ladder of sampling intervals: the slope is the order of the method, where neither "
            "the floor of rounding nor the coarsest intervals bend it." + scope,
            tables=(Table(told.orders[0], "Fitted orders", picked(firsts.values(), told.table)),),
            charts=tuple(steps),
            **common,
        )
    split = [row for row in own_interval(rows) if real(row, "secular_drift_deg_per_h") is not None]
    if split:
        yield Section(
            "secular",
            "Secular and periodic parts",
            "Secular",
            "What the error gains steadily, and what only comes and goes, fitted both at once; the first is what "
            "navigation is left with." + scope,
            tables=(Table("secular_parts", "At the cases' own sampling interval", picked(split, _SECULAR_TABLE)),),
            charts=tuple(charts.parts(name, names, cases[0])),
            **common,
        )


def _growth(series: Sequence[Row], scores: Sequence[Row], dataset: str) -> Iterator[Section]:
    """Yield a section of errors over time."""
    rows = [row for row in series if row["dataset"] == dataset]
    if not rows:
        return
    measures = SERIES_FIELDS[dataset]
    names = places(scores, dataset, rows)
    cases = tuple(dict.fromkeys(row["case"] for row in rows))
    periods = _periods(rows)
    told = f" The Schuler period is {periods[0]['time']:.0f} s." if periods else ""
    data = f"series_{dataset}"
    yield Section(
        f"growth_{dataset}",
        *_GROWTH_TITLES[dataset],
        f"Built-in methods run again while this page was made, at the cases' own sampling interval.{told}",
        charts=tuple(charts.growth(data, names, cases[0], charts.Quantity(*one), periods) for one in measures),
        data={data: [short(row, ("subject", "case", "time", *(field for field, _ in measures))) for row in rows]},
        series=names,
        cases=cases,
        files={data: rows},
    )


def _periods(rows: Sequence[Row]) -> list[dict[str, Any]]:
    lines: list[dict[str, Any]] = []
    for case in dict.fromkeys(row["case"] for row in rows):
        own = [row for row in rows if row["case"] == case]
        period, end = positive(own[0], "schuler_period"), max(row["time"] for row in own)
        if period:
            numbers = range(1, int(end / period) + 1)
            lines += [
                {"case": case, "time": n * period, "label": "Schuler period" if n == 1 else f"{n} periods"}
                for n in numbers
            ]
    return lines


def _equator(results: Results) -> Iterator[Section]:
    scores = [row for row in results.scores if row["dataset"] == "equator_errors"]
    if scores:
        caption = "Largest errors against certified truth"
        yield Section(
            "equator",
            "Solvers of the error equations on the equator",
            "Equator",
            "Largest error of each component over each case, and correct digits at the end.",
            tables=(Table("equator_scores", caption, picked(scores, _EQUATOR_TABLE)),),
            files={"scores": results.scores},
        )
    if scores or any(row["paper"] == "loginov2013" for row in results.claims):
        known = known_cases("equator_errors", {row["case"] for row in scores}).values()
        scored = places_of(case for case in known if isinstance(case, EquatorCase))
        rows = stability_map()
        data = {"stability": [short(row, row) for row in rows]}
        yield Section(
            "stability",
            "Stability of the equator model",
            "Stability",
            "The vertical channel grows as exp(β₃ t), the longitude channel oscillates with the frequency μ, between "
            "the two speeds at which the specific force a_H vanishes. The formulas of Loginov, Tkachenko, Chelnokov "
            "(2013) also divide by ω_N, which vanishes at a westward speed of 465 m/s on the ground.",
            charts=tuple(stability_charts("stability", scored, stability_limits())),
            data=data,
            files={"stability": rows},
        )


def _gyroscopic(results: Results) -> Iterator[Section]:
    scores = [row for row in results.scores if row["dataset"] == "gyro_systems"]
    tables = []
    if scores:
        caption = "Errors of the vertical (R times the angle) and of the angles, at the cases' own intervals"
        tables.append(Table("gyroscopic_scores", caption, picked(own_interval(scores), _GYRO_TABLE)))
    if results.responses:
        names = {name: name for row in results.responses for name in row}
        tables.append(
            Table("responses", "Answers to errors of instruments and start", picked(results.responses, names))
        )
    if tables:
        files = {"scores": results.scores} if scores else {}
        yield Section(
            "gyroscopic",
            "Gyroscopic systems",
            "Gyroscopic",
            "Errors of the modelled vertical, and of the heading, pitch and roll that are read out with it.",
            tables=tuple(tables),
            files=files | ({"responses": results.responses} if results.responses else {}),
        )


def _others(results: Results) -> Iterator[Section]:
    """Yield the scores on datasets that have no section of their own."""
    for dataset in dict.fromkeys(row["dataset"] for row in results.scores):
        if dataset in ("dual_precession", "equator_errors", "gyro_systems", mast.DATASET):
            continue
        rows = [row for row in own_interval(results.scores) if row["dataset"] == dataset]
        table = Table(f"scores_{dataset}", "Scores", picked(rows, {name: name for row in rows for name in row}))
        title = dataset.replace("_", " ").capitalize()
        yield Section(f"scores_{dataset}", title, title, tables=(table,), files={"scores": results.scores})


def sections(results: Results, progress: Progress = lambda done, total, what: None) -> tuple[Section, ...]:
    """Return the sections of a report in order.

    Parameters
    ----------
    results : Results
    progress : callable
        ``progress(done, total, what)``, while errors over time are computed.
    """
    scores = results.scores
    series = error_series(own_interval(scores), progress, results.cases)
    return (
        *_ladders(scores, "dual_precession"),
        *_growth(series, scores, "dual_precession"),
        *_gyroscopic(results),
        *_ladders(scores, "gyro_systems"),
        *_growth(series, scores, "gyro_systems"),
        *mast.sections(scores, series),
        *_equator(results),
        *_others(results),
        *findings.sections(results),
    )
