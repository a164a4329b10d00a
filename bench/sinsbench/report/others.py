"""The charts of claims, planted defects and stored timings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sinsbench.claims.model import VERDICTS
from sinsbench.report.model import Chart
from sinsbench.report.style import COLOURS, logarithmic, specification

__all__ = ["MUTANT_VERDICTS", "claim_chart", "mutant_chart", "timing_chart"]

MUTANT_VERDICTS = ("told apart", "equivalent", "unexplained", "survivor")
_GOOD, _NOTE, _BAD, _GREY = COLOURS[2], COLOURS[1], COLOURS[3], COLOURS[9]


def _verdicts(alt: Any, names: Sequence[str], colours: Sequence[str]) -> Any:
    scale = alt.Scale(domain=list(names), range=list(colours))
    return alt.Color("verdict:N", scale=scale, legend=alt.Legend(orient="top", title=None))


def claim_chart(data: str, places: int) -> Chart:
    """Return the differences between printed and recomputed numbers, one row a place of a paper."""
    import altair as alt

    verdict = _verdicts(alt, VERDICTS, (_GOOD, _NOTE, _BAD))
    marks = (
        alt.Chart(alt.NamedData(name=data))
        .transform_filter("datum.difference > 0")
        .mark_point(size=60, filled=True, opacity=0.85)
        .encode(
            x=logarithmic(alt, alt.X, "difference", "relative difference"),
            y=alt.Y("place:N", title=None, sort=None),
            color=verdict,
            shape=alt.Shape(
                "verdict:N", scale=alt.Scale(domain=list(VERDICTS), range=["circle", "square", "triangle-up"])
            ),
            tooltip=["claim:N", "quantity:N", "printed:N", "recomputed:N", "unit:N", "verdict:N"],
        )
    )
    return Chart(
        "claims",
        "Printed against recomputed",
        "Relative difference between printed and recomputed numbers, logarithmic, by place in the papers. Numbers that "
        "are equal have no place on the axis; the table has all.",
        specification(marks, height=22 * places + 60),
        data,
    )


def mutant_chart(data: str, subjects: int) -> Chart:
    """Return how many defects of each subject were told apart."""
    import altair as alt

    bars = (
        alt.Chart(alt.NamedData(name=data))
        .mark_bar()
        .encode(
            x=alt.X("defects:Q", title="planted defects"),
            y=alt.Y("subject:N", title=None, sort=None),
            color=_verdicts(alt, MUTANT_VERDICTS, (_GOOD, _GREY, _NOTE, _BAD)),
            order="order:Q",
            tooltip=["subject:N", "verdict:N", "defects:Q"],
        )
    )
    return Chart(
        "mutants",
        "What the score sees of planted defects",
        "Bars, one a method: how many of the defects planted in it the score tells apart, how many make no difference "
        "for a reason, and how many survive.",
        specification(bars, height=22 * subjects + 60),
        data,
    )


def timing_chart(data: str) -> Chart:
    """Return times of benchmarks over stored runs, relative to the first on the same machine."""
    import altair as alt

    base = alt.Chart(alt.NamedData(name=data)).encode(
        x=alt.X(
            "run:O", title="stored run, in order of time", sort=None, axis=alt.Axis(labelAngle=-30, labelLimit=140)
        ),
        y=alt.Y("relative:Q", title="least time / that of the first run", scale=alt.Scale(type="log", padding=8)),
    )
    tooltip = ["benchmark:N", "run:N", "commit:N", alt.Tooltip("relative:Q", format=".3f"), "verdict:N", "machine:N"]
    lines = base.mark_line(color=_GREY, strokeWidth=1, opacity=0.6).encode(detail=["benchmark:N", "machine:N"])
    marks = base.mark_point(size=50, filled=True, opacity=0.9).encode(
        color=_verdicts(alt, ("first", "same", "slower", "faster", "undecided"), (_GREY, _GREY, _BAD, _GOOD, _NOTE)),
        shape=alt.Shape(
            "verdict:N",
            scale=alt.Scale(
                domain=["first", "same", "slower", "faster", "undecided"],
                range=["circle", "circle", "triangle-up", "triangle-down", "square"],
            ),
        ),
        tooltip=tooltip,
    )
    return Chart(
        "timings",
        "Least times over stored runs",
        "Least time of each benchmark over the stored runs, relative to its first run on the same machine and divided "
        "by the calibration workload where both have it. Triangles mark runs that are slower or faster than before.",
        specification(lines + marks),
        data,
    )
