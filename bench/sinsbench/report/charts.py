"""The charts of scores: work against precision, errors over intervals and over time, secular against periodic parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from sinsbench.report.model import Chart
from sinsbench.report.results import Row, positive
from sinsbench.report.style import HEIGHT, logarithmic, series_encodings, specification

__all__ = ["GUIDE_ORDERS", "MEASURES", "Quantity", "consistency", "growth", "ladders", "parts", "work_precision"]


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


class Quantity(NamedTuple):
    """What is drawn over time: field, unit, name (that of the field if there is none), and the field of its bound."""

    field: str
    unit: str
    name: str = ""
    bound: str = ""

    @property
    def what(self) -> str:
        """Its name."""
        return self.name or self.field.replace("_", " ")


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


def _shown(alt: Any, data: str, names: Mapping[str, int], case: str, *fields: str) -> tuple[Any, dict[str, Any]]:
    """Return a base chart that shows the chosen case without the hidden series, and the encodings of its series."""
    valid = " && ".join(f"isValid(datum.{field}) && datum.{field} > 0" for field in fields)
    chosen = f"datum.case == shown_case && indexof(hidden, datum.subject) < 0 && {valid}"
    chart = (
        alt.Chart(alt.NamedData(name=data))
        .add_params(alt.param(name="hidden", value=[]), alt.param(name="shown_case", value=case))
        .transform_filter(chosen)
    )
    return chart, series_encodings(alt, "subject", names)


def _lines(
    alt: Any,
    chart: Any,
    series: Mapping[str, Any],
    order: str,
    floor: str = "",
    bound: Any = None,
    marked: str = "",
    **encodings: Any,
) -> Any:
    """Return lines; where a field tells of a floor, with points on them. The series under the pointer stands out.

    `bound` is the position of a second line of each series, which is dashed; `marked` says where there are points.
    """
    hover = alt.selection_point(name="pointed", on="pointerover", clear="pointerout", fields=["subject"])
    faded = alt.when(hover).then(alt.value(1)).otherwise(alt.value(0.12))
    base = chart.encode(**encodings, color=series["color"], opacity=faded)
    # A legend of shapes has no dashes: they would be drawn around the shapes.
    dashes = series["strokeDash"].legend(None) if floor else series["strokeDash"]
    lines = base.mark_line(strokeWidth=1.6).encode(order=f"{order}:Q", strokeDash=dashes)
    # A wide line that is not seen makes the thin one easy to meet with the pointer.
    wide = chart.encode(**encodings, detail="subject:N").mark_line(strokeWidth=9, opacity=0).add_params(hover)
    if bound is not None:
        dashed = base.encode(y=bound).mark_line(strokeWidth=1.1, strokeDash=[4, 3]).encode(order=f"{order}:Q")
        known = f"isValid(datum.{bound.shorthand.partition(':')[0]})"
        return dashed.transform_filter(known) + lines + wide
    if not floor:
        return lines + wide
    hollow = alt.condition(f"datum.{floor}", alt.value(0), alt.value(1))
    points = base.transform_filter(marked) if marked else base
    marks = points.mark_point(size=48, filled=True, strokeWidth=1.4).encode(
        shape=series["shape"], fillOpacity=hollow, stroke=series["color"]
    )
    return lines + marks + wide if marked else lines + marks.add_params(hover)


def _tooltip(alt: Any, *pairs: tuple[str, str]) -> list[Any]:
    named = [alt.Tooltip("subject:N", title="method"), alt.Tooltip("interval:Q", title="interval, s", format="~g")]
    return named + [alt.Tooltip(f"{field}:Q", title=title, format=".4~g") for field, title in pairs]


def _seen(measures: Iterable[Measure], rows: Sequence[Row], cost: str = "interval") -> Iterator[Measure]:
    """Yield the errors that have a place on axes: some row has a positive one, at a positive cost."""
    for measure in measures:
        if any(positive(row, measure.field) and positive(row, cost) for row in rows):
            yield measure


def work_precision(data: str, rows: Sequence[Row], names: Mapping[str, int], case: str, dataset: str) -> list[Chart]:
    """Return the diagrams of error against operations and against time.

    Parameters
    ----------
    data : str
        Name of the rows.
    rows : sequence of mapping
        With ``subject, case, interval``, the errors of `MEASURES` and the costs ``flops_per_second, ns_per_second``.
    names : mapping of str to int
        The series, with the places that choose their styles.
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


def ladders(data: str, rows: Sequence[Row], names: Mapping[str, int], case: str, dataset: str) -> list[Chart]:
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


def growth(data: str, names: Mapping[str, int], case: str, quantity: Quantity, periods: Sequence[Row] = ()) -> Chart:
    """Return the diagram of an error over time, with its bound dashed and the Schuler periods as upright lines.

    Parameters
    ----------
    data, names, case
        As for `work_precision`.
    quantity : Quantity
        The error. Where it has a bound, the axis of time is logarithmic: estimators settle within seconds.
    periods : sequence of mapping
        ``case, time`` (s) and ``label`` of the upright lines.
    """
    import altair as alt

    field, what, unit = quantity.field, quantity.what, quantity.unit
    chart, series = _shown(alt, data, names, case, field)
    title = f"{what}, {unit}"
    drawn = _lines(
        alt,
        chart,
        series,
        "time",
        bound=logarithmic(alt, alt.Y, quantity.bound, title) if quantity.bound else None,
        x=_over_time(alt, settling=bool(quantity.bound)),
        y=logarithmic(alt, alt.Y, field, title),
        tooltip=[
            "subject:N",
            alt.Tooltip("time:Q", title="time, s"),
            alt.Tooltip(f"{field}:Q", title=title, format=".4~g"),
            *([alt.Tooltip(f"{quantity.bound}:Q", title="dashed", format=".4~g")] if quantity.bound else []),
        ],
    )
    marked = ""
    if periods:
        base = alt.Chart(alt.NamedData(name="periods")).transform_filter("datum.case == shown_case")
        rule = base.mark_rule(color="#8a8a8a", strokeDash=[4, 3]).encode(x="time:Q")
        text = base.mark_text(color="#8a8a8a", align="left", baseline="bottom", dx=4, fontSize=11)
        drawn = rule + text.encode(x="time:Q", y=alt.value(HEIGHT - 4), text="label:N") + drawn
        marked = " Upright dashed lines mark whole Schuler periods."
    capital = what[:1].upper() + what[1:]
    bounded = " Dashed: the bound that the method itself gives, three standard deviations." if quantity.bound else ""
    return Chart(
        f"growth_{field}",
        f"{capital} over time",
        f"{capital} over time, logarithmic, one line a method.{bounded}{marked}",
        specification(drawn, periods=periods),
        data,
    )


def _over_time(alt: Any, *, settling: bool) -> Any:
    if settling:
        return logarithmic(alt, alt.X, "time", "time, s")
    return alt.X("time:Q", title="time, s", scale=alt.Scale(nice=False))


def consistency(
    name: str,
    data: str,
    names: Mapping[str, int],
    case: str,
    field: str,
    told: tuple[str, str],
    bands: Sequence[Row],
    fewer: str = "",
) -> Chart:
    """Return the diagram of a normalised estimation error squared over time, with its band as a shaded strip.

    Parameters
    ----------
    name : str
        Name of the chart.
    data, names, case
        As for `work_precision`.
    field : str
        The normalised error.
    told : tuple of str
        Title, and what the description adds to it.
    bands : sequence of mapping
        ``case``, ends ``low`` and ``high`` of the band, and ``label``.
    fewer : str
        Field that is true where a value rests on fewer runs than the band. Points are drawn then, these hollow, where
        the field ``told`` is true.
    """
    import altair as alt

    chart, series = _shown(alt, data, names, case, field)
    title, more = told
    axis = "normalised estimation error squared"
    drawn = _lines(
        alt,
        chart,
        series,
        "time",
        fewer,
        marked="datum.told",
        x=_over_time(alt, settling=True),
        y=logarithmic(alt, alt.Y, field, axis),
        tooltip=[
            "subject:N",
            alt.Tooltip("time:Q", title="time, s"),
            alt.Tooltip(f"{field}:Q", title="NEES", format=".4~g"),
        ],
    )
    base = alt.Chart(alt.NamedData(name="bands")).transform_filter("datum.case == shown_case")
    strip = base.mark_rect(color="#808080", opacity=0.22).encode(y=alt.Y("low:Q", title=axis), y2="high:Q")
    # In the corner that lines leave free: they begin low.
    label = base.mark_text(color="#8a8a8a", align="left", baseline="top", fontSize=11).encode(
        x=alt.value(6), y=alt.value(6), text="label:N"
    )
    shown = specification(strip + drawn + label, bands=bands)
    return Chart(name, title, f"{title}, both axes logarithmic. {more}", shown, data)


def parts(data: str, names: Mapping[str, int], case: str) -> list[Chart]:
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
