"""The charts of scores: work against precision, errors over intervals and over time, secular against periodic parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from sinsbench.report.model import Chart
from sinsbench.report.results import Row, positive
from sinsbench.report.style import HEIGHT, logarithmic, series_encodings, specification

__all__ = ["GUIDE_ORDERS", "MEASURES", "growth", "ladders", "parts", "work_precision"]


class Measure(NamedTuple):
    """An error: field, name, unit, and the field that tells whether rounding sets it."""

    field: str
    name: str
    unit: str
    at_floor: str

    @property
    def title(self) -> str:
        """Name and unit, for an axis."""
        return f"{self.name}, {self.unit}"

    @property
    def short(self) -> str:
        """Its first word, for names of files."""
        return self.field.partition("_")[0]


MEASURES: Mapping[str, tuple[Measure, ...]] = {
    "dual_precession": (
        Measure("attitude_error_max", "largest attitude error", "rad", "at_floor"),
        Measure("velocity_error_max", "largest velocity error", "m/s", "velocity_at_floor"),
        Measure("secular_drift_deg_per_h", "secular drift", "deg/h", "secular_at_floor"),
    ),
    "gyro_systems": (Measure("vertical_error_max_m", "largest error of the vertical", "m", "at_floor"),),
}
"""Errors that are drawn over the sampling interval, by dataset; the secular drift is not drawn against costs."""
_COSTS = (
    ("flops_per_second", "operations", "floating-point operations a second of motion"),
    ("ns_per_second", "time", "ns a second of motion, least of the repetitions"),
)
_SECULAR = (
    ("attitude", "attitude_periodic_max", "secular_drift_deg_per_h", "periodic part, rad", "secular drift, deg/h"),
    ("velocity", "velocity_periodic_max", "secular_velocity_rate", "periodic part, m/s", "secular rate, m/s²"),
)
GUIDE_ORDERS = (2, 4, 6, 8)
"""Orders whose slopes are drawn."""


def _shown(alt: Any, data: str, names: Sequence[str], case: str, *fields: str) -> tuple[Any, dict[str, Any]]:
    """Return a base chart that shows the chosen case without the hidden series, and the encodings of its series."""
    valid = " && ".join(f"isValid(datum.{field}) && datum.{field} > 0" for field in fields)
    chosen = f"datum.case == shown_case && indexof(hidden, datum.subject) < 0 && {valid}"
    chart = (
        alt.Chart(alt.NamedData(name=data))
        .add_params(alt.param(name="hidden", value=[]), alt.param(name="shown_case", value=case))
        .transform_filter(chosen)
    )
    return chart, series_encodings(alt, "subject", names)


def _lines(alt: Any, chart: Any, series: Mapping[str, Any], order: str, floor: str = "", **encodings: Any) -> Any:
    """Return lines; where a field tells of a floor, with points on them. The series under the pointer stands out."""
    hover = alt.selection_point(name="pointed", on="pointerover", clear="pointerout", fields=["subject"])
    faded = alt.when(hover).then(alt.value(1)).otherwise(alt.value(0.12))
    base = chart.encode(**encodings, color=series["color"], opacity=faded)
    # A legend of shapes has no dashes: they would be drawn around the shapes.
    dashes = series["strokeDash"].legend(None) if floor else series["strokeDash"]
    lines = base.mark_line(strokeWidth=1.6).encode(order=f"{order}:Q", strokeDash=dashes)
    if not floor:
        # A wide line that is not seen makes the thin one easy to meet with the pointer.
        wide = chart.encode(**encodings, detail="subject:N").mark_line(strokeWidth=9, opacity=0).add_params(hover)
        return lines + wide
    hollow = alt.condition(f"datum.{floor}", alt.value(0), alt.value(1))
    marks = base.mark_point(size=48, filled=True, strokeWidth=1.4).encode(
        shape=series["shape"], fillOpacity=hollow, stroke=series["color"]
    )
    return lines + marks.add_params(hover)


def _tooltip(alt: Any, *pairs: tuple[str, str]) -> list[Any]:
    named = [alt.Tooltip("subject:N", title="method"), alt.Tooltip("interval:Q", title="interval, s", format="~g")]
    return named + [alt.Tooltip(f"{field}:Q", title=title, format=".4~g") for field, title in pairs]


def _seen(measures: Iterable[Measure], rows: Sequence[Row], cost: str = "interval") -> Iterator[Measure]:
    """Yield the errors that have a place on axes: some row has a positive one, at a positive cost."""
    for measure in measures:
        if any(positive(row, measure.field) and positive(row, cost) for row in rows):
            yield measure


def work_precision(data: str, rows: Sequence[Row], names: Sequence[str], case: str, dataset: str) -> list[Chart]:
    """Return the diagrams of error against operations and against time.

    Parameters
    ----------
    data : str
        Name of the rows.
    rows : sequence of mapping
        With ``subject, case, interval``, the errors of `MEASURES` and the costs ``flops_per_second, ns_per_second``.
    names : sequence of str
        The series.
    case : str
        The case that is shown first.
    dataset : str
        Dataset of the scores.
    """
    import altair as alt

    charts = []
    for cost, short, title in _COSTS:
        for measure in _seen(MEASURES[dataset][:2], rows, cost):
            chart, series = _shown(alt, data, names, case, measure.field, cost)
            drawn = _lines(
                alt,
                chart,
                series,
                "interval",
                measure.at_floor,
                x=logarithmic(alt, alt.X, cost, title),
                y=logarithmic(alt, alt.Y, measure.field, measure.title),
                tooltip=_tooltip(alt, (measure.field, measure.title), (cost, title)),
            )
            what = f"{measure.name.capitalize()} against {short}"
            text = (
                f"{what}, both logarithmic: down is more accurate, left is cheaper. A line is a method, a point a "
                "sampling interval; hollow where rounding sets the error."
            )
            charts.append(Chart(f"work_precision_{measure.short}_{short}", what, text, specification(drawn), data))
    return charts


def _guides(rows: Sequence[Row], measure: Measure) -> list[dict[str, Any]]:
    """Return straight lines of the slopes `GUIDE_ORDERS`, one of each for every case.

    They begin at the largest error and the coarsest interval, and end where the errors do.
    """
    lines: list[dict[str, Any]] = []
    for case in dict.fromkeys(row["case"] for row in rows):
        own = [row for row in rows if row["case"] == case]
        points = [(x, y) for row in own if (x := positive(row, "interval")) and (y := positive(row, measure.field))]
        if len({interval for interval, _ in points}) < 2:
            continue
        coarse, fine = max(points)[0], min(points)[0]
        top, bottom = (pick(error for _, error in points) for pick in (max, min))
        for order in GUIDE_ORDERS:
            # Where the line meets the least error, or the finest interval.
            last = max(fine, coarse * (bottom / top) ** (1 / order))
            common = {"case": case, "order": order}
            lines += [
                {**common, "interval": interval, "error": top * (interval / coarse) ** order, "end": interval == last}
                for interval in (coarse, last)
            ]
    return lines


def ladders(data: str, rows: Sequence[Row], names: Sequence[str], case: str, dataset: str) -> list[Chart]:
    """Return the diagrams of errors over the sampling interval, with the slopes of orders as grey lines.

    Parameters
    ----------
    data, rows, names, case, dataset
        As for `work_precision`.
    """
    import altair as alt

    charts = []
    for measure in _seen(MEASURES[dataset], rows):
        chart, series = _shown(alt, data, names, case, measure.field, "interval")
        x = logarithmic(alt, alt.X, "interval", "sampling interval, s")
        drawn = _lines(
            alt,
            chart,
            series,
            "interval",
            measure.at_floor,
            x=x,
            y=logarithmic(alt, alt.Y, measure.field, measure.title),
            tooltip=_tooltip(alt, (measure.field, measure.title), ("observed_order", "fitted order")),
        )
        lines = (
            alt.Chart(alt.NamedData(name="guides"))
            .transform_filter("datum.case == shown_case")
            .encode(x=x, y=alt.Y("error:Q", title=measure.title), detail="order:N")
        )
        grey = lines.mark_line(color="#9a9a9a", strokeWidth=1, strokeDash=[3, 3])
        ends = lines.transform_filter("datum.end").transform_calculate(label="'order ' + datum.order")
        label = ends.mark_text(color="#8a8a8a", align="left", dx=4, dy=9, fontSize=11).encode(text="label:N")
        what = f"{measure.name.capitalize()} over the sampling interval"
        text = (
            f"{what}, both logarithmic. A method of order p falls along a line of slope p; grey dashed lines have the "
            "slopes 2, 4, 6, 8. Hollow where rounding sets the error."
        )
        slopes = specification(grey + drawn + label, guides=_guides(rows, measure))
        charts.append(Chart(f"ladder_{measure.short}", what, text, slopes, data))
    return charts


def growth(data: str, names: Sequence[str], case: str, field: str, unit: str, periods: Sequence[Row] = ()) -> Chart:
    """Return the diagram of an error over time, with the Schuler periods as upright lines.

    Parameters
    ----------
    data, names, case
        As for `work_precision`.
    field, unit : str
        The error.
    periods : sequence of mapping
        ``case, time`` (s) and ``label`` of the upright lines.
    """
    import altair as alt

    chart, series = _shown(alt, data, names, case, field)
    what = field.replace("_", " ")
    drawn = _lines(
        alt,
        chart,
        series,
        "time",
        x=alt.X("time:Q", title="time, s", scale=alt.Scale(nice=False)),
        y=logarithmic(alt, alt.Y, field, f"{what}, {unit}"),
        tooltip=["subject:N", alt.Tooltip("time:Q", title="time, s"), alt.Tooltip(f"{field}:Q", format=".4~g")],
    )
    marked = ""
    if periods:
        base = alt.Chart(alt.NamedData(name="periods")).transform_filter("datum.case == shown_case")
        rule = base.mark_rule(color="#8a8a8a", strokeDash=[4, 3]).encode(x="time:Q")
        text = base.mark_text(color="#8a8a8a", align="left", baseline="bottom", dx=4, fontSize=11)
        drawn = rule + text.encode(x="time:Q", y=alt.value(HEIGHT - 4), text="label:N") + drawn
        marked = " Upright dashed lines mark whole Schuler periods."
    return Chart(
        f"growth_{field}",
        f"{what.capitalize()} over time",
        f"{what.capitalize()} over time, logarithmic, one line a method.{marked}",
        specification(drawn, periods=periods),
        data,
    )


def parts(data: str, names: Sequence[str], case: str) -> list[Chart]:
    """Return the diagrams of the secular part of an error against what is left without it."""
    import altair as alt

    charts = []
    for name, periodic, secular, across, up in _SECULAR:
        chart, series = _shown(alt, data, names, case, periodic, secular)
        drawn = (
            chart.transform_filter("datum.own")
            .mark_point(size=70, filled=True, opacity=1)
            .encode(
                x=logarithmic(alt, alt.X, periodic, across),
                y=logarithmic(alt, alt.Y, secular, up),
                color=series["color"],
                shape=series["shape"],
                tooltip=_tooltip(alt, (secular, up), (periodic, across)),
            )
        )
        charts.append(
            Chart(
                f"parts_{name}",
                f"{name.capitalize()} error: secular against periodic part",
                f"Each point is a method at the case's own sampling interval: what its {name} error gains steadily, "
                "upwards, against the largest of what is left, to the right; both logarithmic.",
                specification(drawn),
                data,
            )
        )
    return charts
