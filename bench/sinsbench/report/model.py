"""What a report consists of: sections of sentences, tables and charts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sinsbench.report.results import Row

__all__ = ["Chart", "Check", "Section", "Table"]

#: Rows that a table of the page has at most; more make a page slow to open.
MOST_ROWS = 500


@dataclass(frozen=True)
class Table:
    """A table for people.

    Attributes
    ----------
    name : str
        Name of its element.
    caption : str
    rows : sequence of mapping
        The keys of the first row are the headings.
    note : str
        A sentence above it.
    """

    name: str
    caption: str
    rows: Sequence[Row]
    note: str = ""

    @property
    def columns(self) -> tuple[str, ...]:
        """The headings: those of the first row."""
        return tuple(self.rows[0]) if self.rows else ()

    @property
    def shown(self) -> Sequence[Row]:
        """The rows that the page shows: the first `MOST_ROWS`; the files hold all of them."""
        return self.rows[:MOST_ROWS]


@dataclass(frozen=True)
class Chart:
    """A chart: a Vega-Lite specification whose data stand apart.

    Attributes
    ----------
    name : str
        Name of its element, and of its files as a figure.
    title, description : str
        What people read above it, and what a screen reader reads in its place.
    specification : mapping
        Vega-Lite, with the name of its data. A parameter ``shown_case`` chooses a case, ``hidden`` is the list of the
        series that are not shown.
    data : str
        Name of its data.
    """

    name: str
    title: str
    description: str
    specification: Mapping[str, Any]
    data: str


@dataclass(frozen=True)
class Check:
    """A line of the first screen: what was checked, and what of it holds.

    Attributes
    ----------
    what, found : str
    holds : bool
    section : str
        Name of the section that tells more.
    words : tuple of str
        What is said where it holds, and where it does not.
    """

    what: str
    found: str
    holds: bool
    section: str
    words: tuple[str, str] = ("holds", "does not hold")

    @property
    def verdict(self) -> str:
        """The one of the words that is the case."""
        return self.words[0 if self.holds else 1]


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Attributes
    ----------
    name, title : str
    short : str
        Title in the navigation.
    text : str
    tables : tuple of Table
    charts : tuple of Chart
    data : mapping of str to list of mapping
        The data of the charts by name.
    series : mapping of str to int
        Names in the legend, which hides and shows them, with the places that choose their styles.
    cases : tuple of str
        Cases to choose from.
    files : mapping of str to list of mapping
        Everything that the section shows, for download, by the name of the file.
    """

    name: str
    title: str
    short: str
    text: str = ""
    tables: tuple[Table, ...] = ()
    charts: tuple[Chart, ...] = ()
    data: Mapping[str, Sequence[Row]] = field(default_factory=dict)
    series: Mapping[str, int] = field(default_factory=dict)
    cases: tuple[str, ...] = ()
    files: Mapping[str, Sequence[Row]] = field(default_factory=dict)
