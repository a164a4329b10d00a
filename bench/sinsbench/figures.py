"""Figures of scores: error against sampling interval, with the orders as slopes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

#: Kinds of file, by suffix.
SUFFIXES = (".svg", ".png")


class FigureError(ValueError):
    """A figure cannot be made; the message says why and what would do."""


def check_figure(path: Path | None, datasets: Sequence[str]) -> None:
    """See, before anything is computed, that a figure of scores on datasets can be made.

    Raises
    ------
    FigureError
        For a suffix that is not of `SUFFIXES`, or where no integrator is scored.
    """
    if path is None:
        return
    if path.suffix not in SUFFIXES:
        raise FigureError(f"{path}: a figure ends in {' or '.join(SUFFIXES)}")
    if "dual_precession" not in datasets:
        raise FigureError(f"{path}: the figure shows integrators on dual_precession")


def ladder_figure(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Draw largest attitude error and velocity error over the ladder of sampling intervals, log-log.

    Parameters
    ----------
    rows : sequence of mapping
        Scores of integrators.
    path : Path
        File to write, SVG or PNG by suffix.

    Raises
    ------
    FigureError
        If the rows hold no ladder.
    """
    import altair as alt

    measures = {
        "attitude_error_max": "largest attitude error, rad",
        "velocity_error_max": "largest velocity error, m/s",
    }
    points = [
        {"subject": row["subject"], "case": row["case"], "interval": row["interval"], **{m: row[m] for m in measures}}
        for row in rows
        if row["dataset"] == "dual_precession" and row["status"] == "ok" and row["attitude_error_max"]
    ]
    if not points:
        raise FigureError(f"{path}: no integrator was scored, so there is no error over a sampling interval to draw")
    several = len({point["case"] for point in points}) > 1
    # The same legend for colour and shape, on one layer only, so that they become one.
    legend = alt.Legend(orient="top", title=None)
    names = list(dict.fromkeys(point["subject"] for point in points))
    colour = alt.Color("subject:N", scale=alt.Scale(scheme="dark2", domain=names), legend=legend)
    shape = alt.Shape("subject:N", scale=alt.Scale(domain=names), legend=legend)
    base = alt.Chart({"values": points}).encode(
        x=alt.X("interval:Q", title="sampling interval, s", scale=alt.Scale(type="log", nice=False, padding=12)),
        detail="case:N",
    )
    dashes = {"strokeDash": alt.StrokeDash("case:N", title=None)} if several else {}
    panels = []
    for measure, title in measures.items():
        axis = alt.Axis(format=".0e", tickCount=8)
        panel = base.encode(y=alt.Y(f"{measure}:Q", title=title, scale=alt.Scale(type="log"), axis=axis))
        lines = panel.mark_line().encode(color=colour, **dashes)
        marks = panel.mark_point(size=55, filled=True, opacity=1).encode(color=colour, shape=shape)
        panels.append((lines + marks).properties(width=300, height=260))
    case = points[0]["case"] if not several else f"{len({point['case'] for point in points})} cases"
    chart = (
        alt.hconcat(*panels)
        .properties(title=f"Error against certified truth: {case.replace('_', ' ')}", background="white", padding=10)
        .configure_axis(labelFontSize=11, titleFontSize=12)
        .configure_legend(labelFontSize=12)
    )
    temporary = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        chart.save(str(temporary), **({"scale_factor": 2} if path.suffix == ".png" else {}))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
