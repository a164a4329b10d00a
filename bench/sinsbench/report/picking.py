"""What sections pick from rows of results: columns for people, fields for charts, names for legends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from sinsbench.report.results import Row

__all__ = ["picked", "places", "short"]

_DIGITS = 4


def picked(rows: Iterable[Row], columns: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return rows with the headings people read; columns that say nothing throughout are left out."""
    known = list(rows)
    used = {
        heading: field
        for heading, field in columns.items()
        if any(row.get(field) not in (None, "", "ok") for row in known)
    }
    return [{heading: row.get(field) for heading, field in used.items()} for row in known]


def short(row: Row, fields: Iterable[str]) -> dict[str, Any]:
    """Return fields of a row, numbers with the digits that a chart can show."""
    values = {name: row.get(name) for name in fields}
    return {
        name: float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value for name, value in values.items()
    }


def places(scores: Iterable[Row], dataset: str, drawn: Iterable[Row]) -> dict[str, int]:
    """Return the subjects that rows are of, each with its place among all that were scored on a dataset.

    The place decides on the style of a series, which is the same in all charts.
    """
    names = dict.fromkeys(row["subject"] for row in scores if row["dataset"] == dataset)
    known = {row["subject"] for row in drawn}
    return {name: place for place, name in enumerate(names) if name in known}
