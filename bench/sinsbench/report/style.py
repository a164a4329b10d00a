"""What all charts share: colours and shapes of series, logarithmic axes, the form of a specification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = [
    "COLOURS",
    "FIGURE_CONFIG",
    "HEIGHT",
    "SHAPES",
    "logarithmic",
    "series_encodings",
    "specification",
    "style_of",
]

#: Told apart from each other and from white as well as from near-black paper.
COLOURS = (
    *("#3b7dd8", "#e07b00", "#2a9d5c", "#d1495b", "#8a63c9"),
    *("#0e9aa7", "#b5651d", "#d5569f", "#7a8b1f", "#7f7f8f"),
)
SHAPES = ("circle", "square", "triangle-up", "diamond", "cross", "triangle-down", "triangle-right")
DASHES = ((1, 0), (6, 3), (2, 2), (8, 3, 2, 3), (12, 3), (4, 4), (1, 3))
HEIGHT = 340
"""Height of a chart, pixels."""
#: First digit of a tick, which is a digit times a power of ten.
_LEADING = "round(1e6 * datum.value / pow(10, floor(log(datum.value) / LN10 + 1e-9))) / 1e6"
#: Format of a tick's label: without a power of ten where that is short.
_FORM = "datum.value < 0.001 || datum.value > 1e4 ? '.0e' : '~g'"
#: For figures in papers; the page brings its own, for light and dark.
FIGURE_CONFIG: Mapping[str, Any] = {
    "background": "white",
    "padding": 10,
    "axis": {"labelFontSize": 11, "titleFontSize": 12, "gridColor": "#e4e4e4", "titleFontWeight": "normal"},
    "legend": {"labelFontSize": 11, "titleFontSize": 11, "symbolSize": 60, "labelLimit": 260},
    "axisY": {"labelLimit": 280},
    "view": {"stroke": "#999999"},
}


def style_of(place: int) -> tuple[str, str, tuple[int, ...]]:
    """Return colour, shape and dashes of the series at a place of the legend: 70 that differ."""
    turn = place // len(COLOURS) % len(SHAPES)
    return COLOURS[place % len(COLOURS)], SHAPES[turn], DASHES[turn]


def series_encodings(alt: Any, field: str, names: Mapping[str, int]) -> dict[str, Any]:
    """Return the encodings of colour, shape and dashes by series, with one legend for the three.

    `names` has the series with the places that choose their styles.
    """
    styles = [style_of(place) for place in names.values()]
    legend = alt.Legend(title=None, columns=max(1, -(-len(names) // 24)), symbolLimit=0)
    channels = (("color", alt.Color, 0), ("shape", alt.Shape, 1), ("strokeDash", alt.StrokeDash, 2))
    return {
        name: channel(
            f"{field}:N", scale=alt.Scale(domain=list(names), range=[style[part] for style in styles]), legend=legend
        )
        for name, channel, part in channels
    }


def logarithmic(alt: Any, channel: Any, field: str, title: str) -> Any:
    """Return a position channel with a logarithmic axis that names its unit."""
    ends = f"domain('{'x' if channel is alt.X else 'y'}')"
    labelled = f"{ends}[1] < 30 * {ends}[0] ? [1, 2, 3, 5, 7] : [1, 2, 5]"
    return channel(
        f"{field}:Q",
        title=title,
        scale=alt.Scale(type="log", nice=False, padding=8),
        axis=alt.Axis(
            tickCount=5,
            labelOverlap=True,
            labelExpr=f"indexof({labelled}, {_LEADING}) < 0 ? '' : format(datum.value, {_FORM})",
            gridOpacity=alt.condition(f"{_LEADING} == 1", alt.value(1), alt.value(0.3)),
            tickOpacity=alt.condition(f"{_LEADING} == 1", alt.value(1), alt.value(0.5)),
        ),
    )


def specification(
    chart: Any, width: int | str = "container", height: int = HEIGHT, **datasets: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the Vega-Lite specification of an Altair chart as it stands in the page.

    The address of its schema is left out: the page names nothing that lies elsewhere. So is its configuration, which
    depends on where the chart is shown.

    Parameters
    ----------
    chart : altair.Chart
    width, height : int or str
        Pixels.
    **datasets : sequence of mapping
        Rows of its own, by name.
    """
    # Altair's own validation, which the tests do, takes longer than everything else here.
    made: dict[str, Any] = chart.properties(width=width, height=height).to_dict(validate=False)
    kept = {name: part for name, part in made.items() if name not in ("$schema", "config", "datasets")}
    return kept | {"datasets": {name: list(rows) for name, rows in datasets.items() if rows}}
