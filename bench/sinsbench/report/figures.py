"""The charts of a report as files for papers: SVG and PNG, on white, with a legend."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sinsbench.report.model import Chart, Section
from sinsbench.report.results import Row
from sinsbench.report.style import FIGURE_CONFIG

__all__ = ["figures", "write_figures"]

_WIDTH, _PIXELS_A_UNIT = 420, 2


def figures(sections: Sequence[Section]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield name and Vega-Lite specification of every figure: one for each chart and each of its cases."""
    for section in sections:
        for chart in section.charts:
            rows = section.data[chart.data]
            for case in section.cases or ("",):
                own = [row for row in rows if not case or row["case"] == case]
                if own:
                    yield f"{chart.name}_{case}" if case else chart.name, _figure(chart, case, own)


def _figure(chart: Chart, case: str, rows: Sequence[Row]) -> dict[str, Any]:
    specification: dict[str, Any] = json.loads(json.dumps(chart.specification))
    subtitle = [case.replace("_", " ")] if case else []
    title = {"text": chart.title, "subtitle": subtitle, "anchor": "start", "fontSize": 13}
    for parameter in specification.get("params", ()):
        if parameter["name"] == "shown_case":
            parameter["value"] = case
    datasets = {**specification.get("datasets", {}), chart.data: list(rows)}
    return specification | {"width": _WIDTH, "title": title, "datasets": datasets, "config": dict(FIGURE_CONFIG)}


def write_figures(sections: Sequence[Section], folder: Path) -> list[Path]:
    """Write every figure as SVG and PNG, each whole or not at all.

    Parameters
    ----------
    sections : sequence of Section
    folder : Path
        Made if it is not there.

    Returns
    -------
    list of Path
        The files, with the same bytes for the same results and versions.
    """
    import altair as alt
    import vl_convert

    version = ".".join(alt.SCHEMA_VERSION.removeprefix("v").split(".")[:2])
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, specification in figures(sections):
        svg: str = vl_convert.vegalite_to_svg(specification, vl_version=version)
        png: bytes = vl_convert.svg_to_png(svg, scale=_PIXELS_A_UNIT)
        for suffix, content in ((".svg", svg.encode()), (".png", png)):
            path = folder / f"{name}{suffix}"
            temporary = path.with_name(f".{path.name}.partial")
            try:
                temporary.write_bytes(content)
                temporary.replace(path)
            finally:
                temporary.unlink(missing_ok=True)
            written.append(path)
    return written
