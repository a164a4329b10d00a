"""The sections of a report about estimators of the antenna on a mast: scores, errors over time, consistency."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import mean
from typing import Any

from sinsbench.cli.scores import MAST_COLUMNS, MAST_SUMMARY_COLUMNS
from sinsbench.report.boards import own_interval
from sinsbench.report.charts import Quantity, consistency, growth
from sinsbench.report.model import Section, Table
from sinsbench.report.picking import picked, places, short
from sinsbench.report.results import Row
from sinsbench.report.series import CASES, DEVIATIONS, SERIES_FIELDS
from sinsbench.scoring.mast import DATASET, NEES_TIMES
from sinsbench.scoring.mast_errors import BLOCKS
from sinsbench.scoring.mast_summary import CONFIDENCE, family_of, nees_band, summary

__all__ = ["DATASET", "NAME", "sections"]

NAME = "mast"
"""Name of the section of scores."""

_SCORES = MAST_COLUMNS | {"status": "status", "message": "message"}
_SEEDS = {heading: field for heading, field in MAST_SUMMARY_COLUMNS.items() if field != "band"} | {
    "band from": "nees_joint_low",
    "to": "nees_joint_high",
}
_NAMES = {
    "antenna": "the antenna to local level",
    "mu": "the vehicle's attitude",
    "nu": "the antenna to the vehicle",
    "mast": "the mast's direction",
    "position": "position",
    "velocity": "velocity",
}
_BLOCKS = {
    "joint": "all {} errors",
    "navigation": "{} errors of attitude, place and velocity",
    "antenna": "{} errors of the antenna to the vehicle",
    "mast": "{} errors of the mast",
}
_PLACES = 6  # decimals by which seconds are told apart: times are multiples of an interval in binary64
_BAND = f"strip: {100 * CONFIDENCE:.0f} % band"
_NOTE = "Errors are as large as their estimator says where its line is in the strip; above, it is too sure of itself."


def sections(scores: Sequence[Row], series: Sequence[Row]) -> Iterator[Section]:
    """Yield the sections.

    Parameters
    ----------
    scores : sequence of mapping
        Of all datasets.
    series : sequence of mapping
        Errors over time, as `sinsbench.report.series.error_series` returns them.
    """
    own = [row for row in own_interval(scores) if row["dataset"] == DATASET]
    if not own:
        return
    families = summary(own)
    tables = [Table("mast_scores", "Root mean squares of the second half of the motion", picked(own, _SCORES))]
    if families:
        caption = "Over the seeds of a scenario: medians, mean NEES of 16 degrees of freedom with its band"
        tables.append(Table("mast_summary", caption, picked(families, _SEEDS)))
    yield Section(
        NAME,
        "Antenna on a mast",
        "Mast",
        "Errors of what does not depend on how the mast's own axes are twisted about it, which no reading sees: the "
        "antenna to local level (what it is all for), the vehicle (mu), the antenna to the vehicle (nu), the mast's "
        "direction. "
        "NIS is 1 where innovations are as large as the estimator believes.",
        tables=tuple(tables),
        files={"scores": scores},
    )
    found = [row for row in series if row["dataset"] == DATASET]
    drawn = tuple(dict.fromkeys(row["case"] for row in found))[:CASES]
    yield from _over_time([row for row in found if row["case"] in drawn], own)
    yield from _over_seeds(families, found, own)


def _over_time(series: Sequence[Row], scores: Sequence[Row]) -> Iterator[Section]:
    if not series:
        return
    names = places(scores, DATASET, series)
    cases = tuple(dict.fromkeys(row["case"] for row in series))
    missing = dict.fromkeys(row["subject"] for row in scores if row["case"] in cases and row["subject"] not in names)
    why = "failed, not built in, or one too many to run again"
    told = f" Not drawn ({why}): {', '.join(missing)}." if missing else ""
    quantities = [
        Quantity(field, unit, f"error of {_NAMES[field]}", f"bound_{field}") for field, unit in SERIES_FIELDS[DATASET]
    ]
    data = f"series_{DATASET}"
    bands = [_band(case, "joint", 1) for case in cases]
    title = f"NEES of {_BLOCKS['joint'].format(len(BLOCKS['joint']))} (one run)"
    drawn = (*(name for one in quantities for name in (one.field, one.bound)), "nees_joint")
    yield Section(
        f"growth_{DATASET}",
        "Antenna on a mast: errors over time",
        "Mast: over time",
        f"Built-in estimators run again while this page was made. Dashed: {DEVIATIONS} standard deviations by the "
        "estimator's own covariance, of angles and norms the root mean square that it predicts. An error above its "
        f"dashed line is one that the estimator does not know of.{told}",
        charts=(
            *(growth(data, names, cases[0], quantity) for quantity in quantities),
            consistency("growth_nees", data, names, cases[0], "nees_joint", (title, _NOTE), bands),
        ),
        data={data: [short(row, ("subject", "case", "time", *drawn)) for row in series]},
        series=names,
        cases=cases,
        files={data: series},
    )


def _band(case: str, block: str, runs: int) -> dict[str, Any]:
    low, high = nees_band(len(BLOCKS[block]), runs)
    label = f"{_BAND} of one run" if runs == 1 else f"{_BAND} of the mean of {runs} runs"
    return {"case": case, "low": low, "high": high, "label": label}


def _over_seeds(families: Sequence[Row], series: Sequence[Row], scores: Sequence[Row]) -> Iterator[Section]:
    runs: dict[str, int] = {}
    for told in families:
        runs[told["family"]] = max(told["cases"], runs.get(told["family"], 0))
    rows = [
        {"subject": told["subject"], "case": told["family"], "fewer": told["cases"] < runs[told["family"]]} | point
        for told in families
        for point in _means(told, series) or _told(told)
    ]
    if not rows:
        return
    cases = tuple(dict.fromkeys(row["case"] for row in rows))
    counted = ", ".join(f"{case}: mean of {runs[case]} runs" for case in cases)
    data, names = "mast_seeds", places(scores, DATASET, rows)
    charts = []
    for block, what in _BLOCKS.items():
        field, title = f"nees_{block}", f"NEES of {what.format(len(BLOCKS[block]))} ({counted})"
        bands = [_band(case, block, runs[case]) for case in cases]
        charts.append(consistency(f"seeds_{block}", data, names, cases[0], field, (title, _NOTE), bands, "fewer"))
    yield Section(
        data,
        "Antenna on a mast: consistency over the seeds",
        "Mast: seeds",
        "One run does not tell whether an estimator knows its errors; the mean over runs with other noise and other "
        "initial errors does. Points are what was scored; lines between them are of built-in estimators, run again. "
        "Hollow points are means over fewer runs: the others failed.",
        charts=tuple(charts),
        data={data: [short(row, row) for row in rows]},
        series=names,
        cases=cases,
        files={data: families},
    )


def _told(family: Row) -> Iterator[dict[str, Any]]:
    """Yield the means of a family that its scores tell."""
    for when in NEES_TIMES:
        if family[f"nees_joint_{when}s"] is not None:
            yield {"time": when, "told": True} | {f"nees_{block}": family[f"nees_{block}_{when}s"] for block in BLOCKS}


def _means(family: Row, series: Sequence[Row]) -> list[dict[str, Any]]:
    """Return the means of a family over time, none unless as many runs were run again as were scored."""
    times: dict[float, list[Row]] = {}
    for row in series:
        if (row["subject"], family_of(row["case"])) == (family["subject"], family["family"]) and "nees_joint" in row:
            times.setdefault(round(row["time"], _PLACES), []).append(row)
    return [
        {"time": time, "told": time in NEES_TIMES}
        | {f"nees_{block}": mean(row[f"nees_{block}"] for row in own) for block in BLOCKS}
        for time, own in sorted(times.items())
        if len(own) == family["cases"]
    ]
