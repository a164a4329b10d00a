"""Charts: valid Vega-Lite, axes that name their units, slopes that are slopes; figures with the same bytes twice."""

import re
from math import log

import altair as alt
import pytest
import vl_convert

from report_results import CASE, PRECESSION
from sinsbench.report.charts import GUIDE_ORDERS
from sinsbench.report.figures import figures, write_figures
from sinsbench.report.page import without_legend
from sinsbench.report.style import COLOURS, style_of

#: Quantities without a unit, or whose unit is their name.
_PURE = {"planted defects", "relative difference", "least time / that of the first run", "stored run, in order of time"}


def _axes(part):
    """Yield the position encodings of a specification."""
    if isinstance(part, dict):
        for name, encoding in part.items():
            if name in ("x", "y") and isinstance(encoding, dict) and "field" in encoding:
                yield encoding
            yield from _axes(encoding)
    elif isinstance(part, list):
        for one in part:
            yield from _axes(one)


@pytest.fixture(scope="module")
def charts(parts):
    return {chart.name: chart for section in parts for chart in section.charts}


def test_specifications_are_valid(charts) -> None:
    for chart in charts.values():
        alt.LayerChart.validate(dict(chart.specification)) if "layer" in chart.specification else alt.Chart.validate(
            dict(chart.specification)
        )


def test_axes_name_what_they_show_and_its_unit(charts) -> None:
    for chart in charts.values():
        titles = {axis["title"] for axis in _axes(chart.specification) if axis.get("title")}
        assert titles, chart.name
        for title in titles - _PURE:
            assert re.search(r", (rad|m/s|m/s²|deg/h|s|km|m)$|a second of motion", title), title
        assert chart.description
        assert chart.title


def test_every_data_set_that_a_chart_names_is_there(parts) -> None:
    for section in parts:
        for chart in section.charts:
            text = str(chart.specification)
            named = set(re.findall(r"'data': \{'name': '(\w+)'\}", text))
            assert named <= {chart.data, *chart.specification["datasets"]}
            assert chart.data in section.data


def test_grey_lines_have_the_slopes_that_they_name(charts) -> None:
    lines = charts["ladder_attitude"].specification["datasets"]["guides"]
    for order in GUIDE_ORDERS:
        coarse, fine = (row for row in lines if row["order"] == order)
        slope = log(coarse["error"] / fine["error"]) / log(coarse["interval"] / fine["interval"])
        assert slope == pytest.approx(order, rel=1e-12)
        assert (coarse["case"], coarse["end"], fine["end"]) == (CASE, False, True)


def test_styles_differ() -> None:
    styles = [style_of(place) for place in range(70)]
    assert len(set(styles)) == 70
    assert styles[0][0] == COLOURS[0]


def test_figures_show_every_series_on_white_and_are_the_same_twice(parts, tmp_path) -> None:
    chosen = [section for section in parts if section.name in ("growth_dual_precession", "timings")]
    first = write_figures(chosen, tmp_path / "first")
    errors = [f"growth_{name}_error_{CASE}" for name in ("attitude", "velocity")]
    assert [path.name for path in first] == [f"{x}{s}" for x in (*errors, "timings") for s in (".svg", ".png")]
    assert len(first) == 2 * len(list(figures(chosen)))
    drawn = (tmp_path / "first" / f"{errors[0]}.svg").read_text(encoding="utf-8")
    for text in (*PRECESSION, "attitude error, rad", "time, s", CASE.replace("_", " "), 'fill="white"'):
        assert text in drawn
    assert (tmp_path / "first" / "timings.png").read_bytes().startswith(b"\x89PNG")
    for path, again in zip(first, write_figures(chosen, tmp_path / "second"), strict=True):
        assert path.read_bytes() == again.read_bytes()


def test_hidden_series_and_other_cases_are_not_drawn(charts, parts) -> None:
    chart = charts["ladder_attitude"]
    section = next(section for section in parts if section.name == "ladders")
    datasets = chart.specification["datasets"] | {chart.data: section.data[chart.data]}
    specification = without_legend(chart.specification) | {"width": 300, "datasets": datasets}
    colours = [style_of(section.series[name])[0] for name in PRECESSION]

    def drawn(hidden: list[str], case: str) -> list[bool]:
        values = {"hidden": hidden, "shown_case": case}
        chosen = [one | {"value": values.get(one["name"])} for one in specification["params"] if "value" in one]
        others = [one for one in specification["params"] if "value" not in one]
        svg = vl_convert.vegalite_to_svg(specification | {"params": chosen + others})
        return [colour in svg for colour in colours]

    assert drawn([], CASE) == [True, True]
    assert drawn(["panov2"], CASE) == [False, True]
    assert drawn([], "another") == [False, False]
