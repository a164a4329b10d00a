"""The stability map of the error equations on the equator: growth and oscillation over speed and height, with limits.

Source: Loginov, Tkachenko, Chelnokov 2013, eq. (17) and the limiting speeds that follow, evaluated by `sinsref`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from sinsbench.report.model import Chart
from sinsbench.report.results import Row
from sinsbench.report.style import specification
from sinsdata.cases import EquatorCase
from sinsref.arithmetic import MpArithmetic
from sinsref.equator import EquatorModel
from sinsref.equator_modes import NoRealModesError, modes, vanishing_force_speeds
from sinsref.exact import ExactNumber

__all__ = ["places_of", "stability_charts", "stability_limits", "stability_map"]

_DIGITS = 20  # far more than the four that a chart tells
_SPEEDS = tuple(range(-9000, 9001, 200))
_HEIGHTS = tuple(range(0, 1001, 50))
_WEST = "a_H = 0, west"


class _Mode(NamedTuple):
    field: str
    title: str
    name: str
    scheme: Any


_MODES = (
    _Mode("growth_time", "e-folding time of the growing mode, min", "growth", "oranges"),
    _Mode("oscillation_period", "period of the oscillation, min", "oscillation", "blues"),
)


def stability_map() -> list[dict[str, Any]]:
    """Return the constants of the modes over a grid of speeds and heights, where they exist.

    Returns
    -------
    list of dict
        Rows with ``speed`` (m/s), ``height`` (km), ``beta3`` and ``mu`` (1/s), ``growth_time`` and
        ``oscillation_period`` (min).
    """
    ar = MpArithmetic(_DIGITS)
    rows: list[dict[str, Any]] = []
    for height in _HEIGHTS:
        for speed in _SPEEDS:
            try:
                found = modes(ar, EquatorModel.at(ar, ExactNumber(speed), ExactNumber(1000 * height)))
            except NoRealModesError:
                continue
            beta3, mu = float(found.beta3), float(found.mu)
            minutes = {"growth_time": 1 / beta3 / 60, "oscillation_period": 2 * np.pi / mu / 60}
            rows.append({"speed": speed, "height": height, "beta3": beta3, "mu": mu, **minutes})
    return rows


def stability_limits() -> list[dict[str, Any]]:
    """Return the speeds at which the modes end, over height.

    Returns
    -------
    list of dict
        Rows with ``limit``, ``height`` (km), ``speed`` (m/s): west and east, where the specific force vanishes, and the
        speed at which the frame does not rotate, where the formulas (17) divide by zero.
    """
    ar = MpArithmetic(_DIGITS)
    rows: list[dict[str, Any]] = []
    for height in _HEIGHTS:
        exact = ExactNumber(1000 * height)
        west, east = vanishing_force_speeds(ar, exact)
        still = EquatorModel.at(ar, ExactNumber(0), exact)
        speeds = {_WEST: west, "a_H = 0, east": east, "omega_N = 0": -still.frame_rate * still.radius}
        rows += [{"limit": name, "height": height, "speed": float(speed)} for name, speed in speeds.items()]
    return rows


def places_of(cases: Iterable[EquatorCase]) -> list[dict[str, Any]]:
    """Return the places of cases on the map, those of equal speed and height once."""
    names: dict[tuple[float, float], list[str]] = {}
    for case in cases:
        names.setdefault((float(case.v_east), float(case.height) / 1000), []).append(case.name)
    return [{"speed": speed, "height": height, "cases": ", ".join(own)} for (speed, height), own in names.items()]


def stability_charts(data: str, places: Sequence[Row], limits: Sequence[Row]) -> list[Chart]:
    """Return the two maps: how fast the vertical channel grows, and how fast the longitude channel oscillates."""
    import altair as alt

    x = alt.X("speed:Q", title="speed east, m/s", scale=alt.Scale(nice=False, domain=[_SPEEDS[0], _SPEEDS[-1]]))
    y = alt.Y("height:Q", title="height, km", scale=alt.Scale(nice=False, domain=[_HEIGHTS[0], _HEIGHTS[-1]]))
    # Cells overlap a little, or the paper would shine through between them.
    half = 0.55 * (_SPEEDS[1] - _SPEEDS[0]), 0.55 * (_HEIGHTS[1] - _HEIGHTS[0])
    edges = alt.Chart(alt.NamedData(name="limits")).encode(x=x, y=y, detail="limit:N")
    lines = edges.mark_line(color="#808080", strokeDash=[5, 3], strokeWidth=1.6).encode(
        order="height:Q", tooltip=["limit:N", "height:Q", alt.Tooltip("speed:Q", format=".1f")]
    )
    middle = edges.transform_filter(f"datum.height == {_HEIGHTS[len(_HEIGHTS) // 2]}").encode(text="limit:N")
    # Names stand inside the map, whose colours are light in both themes.
    east, west = (
        middle.transform_filter(f"datum.limit {sign} '{_WEST}'").mark_text(
            color="#333333", dy=dy, fontSize=11, angle=270
        )
        for sign, dy in (("!=", -9), ("==", 14))
    )
    cases = (
        alt.Chart(alt.NamedData(name="places"))
        .mark_point(shape="diamond", size=60, filled=True, opacity=1, color="#1f9d55", stroke="white", strokeWidth=0.8)
        .encode(x=x, y=y, tooltip=["cases:N", "speed:Q", "height:Q"])
    )
    charts = []
    for mode in _MODES:
        cells = (
            alt.Chart(alt.NamedData(name=data))
            .transform_calculate(
                left=f"datum.speed - {half[0]}",
                right=f"datum.speed + {half[0]}",
                low=f"max({_HEIGHTS[0]}, datum.height - {half[1]})",
                high=f"min({_HEIGHTS[-1]}, datum.height + {half[1]})",
            )
            .mark_rect()
            .encode(
                x=alt.X("left:Q", title="speed east, m/s", scale=alt.Scale(nice=False)),
                x2="right:Q",
                y=alt.Y("low:Q", title="height, km", scale=alt.Scale(nice=False)),
                y2="high:Q",
                color=alt.Color(
                    f"{mode.field}:Q",
                    title=mode.title,
                    scale=alt.Scale(type="log", scheme=mode.scheme),
                    legend=alt.Legend(orient="bottom", gradientLength=240, titleLimit=400),
                ),
                tooltip=[
                    alt.Tooltip("speed:Q", title="speed, m/s"),
                    alt.Tooltip("height:Q", title="height, km"),
                    alt.Tooltip("beta3:Q", title="β₃, 1/s", format=".4~g"),
                    alt.Tooltip("mu:Q", title="μ, 1/s", format=".4~g"),
                    alt.Tooltip(f"{mode.field}:Q", title=mode.title, format=".4~g"),
                ],
            )
        )
        charts.append(
            Chart(
                f"stability_{mode.name}",
                f"{mode.title.split(',')[0].capitalize()} over speed and height",
                f"Map of {mode.title} over speed east and height. Modes exist between the limits west and east, "
                "dashed, at which the specific force vanishes; at the third the frame does not rotate. Diamonds are "
                "scored cases.",
                specification(cells + lines + east + west + cases, limits=limits, places=places),
                data,
            )
        )
    return charts
