"""The summary of a reproduction: which tables it shows, in the terminal and in Markdown alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from sinsbench.claims.model import VERDICTS
from sinsbench.cli.claims import claim_table, verdict_counts
from sinsbench.cli.output import Output, certified, markdown_table
from sinsbench.cli.scores import native, score_tables

if TYPE_CHECKING:
    from sinsbench.reproduction.run import Reproduction

_ORDERS = ("panov2", "panov4", "panov6")


@dataclass(frozen=True)
class Section:
    """A part of the summary.

    Attributes
    ----------
    title : str
    table : list of dict
        Rows.
    sentence : str
        What they show.
    long : bool
        Whether the table is for the file only; the terminal then shows the sentence.
    """

    title: str
    table: list[dict[str, Any]]
    sentence: str = ""
    long: bool = False


def sections(result: Reproduction) -> Iterator[Section]:
    """Yield the parts of the summary: what was checked, what reproduces, what does not, how the orders compare."""
    totals = {
        key: sum(row[heading] for row in result.datasets)
        for key, heading in (("values", "values"), ("exact_zeros", "exact zeros"), ("bounded_zeros", "bounded zeros"))
    }
    yield Section(
        "Truth: generated, proved, verified",
        result.datasets,
        certified({**totals, "bounded_ties": 0}),
    )
    yield Section(
        "Claims: what the papers print",
        verdict_counts(result.claims),
        "Every number and statement is recomputed; a misprint is one that a named and tested slip explains.",
    )
    columns = ("claim", "printed", "computed", "unit", "note")
    for verdict in VERDICTS[1:]:
        rows = [{name: row[name] for name in columns} for row in claim_table(result.claims, verdict)]
        yield Section(f"Claims: {verdict}", rows)
    for title, table, sentence in result.stories:
        yield Section(f"Behind the differences: {title}", table, sentence, long=True)
    yield Section("Orders 2, 4 and 6 compared", orders(result), _ratios(result))
    yield Section(
        "Solvers on the equator, the worst over all cases",
        solvers(result),
        "Largest error in dv_H, correct digits at the end (relative, and mixed absolute and relative), time a row.",
    )
    for title, table in score_tables(result.scores, result.cases):
        yield Section(f"All scores: {title}", table, long=True)


def solvers(result: Reproduction) -> list[dict[str, Any]]:
    """Return, for each solver of the equator, the worst of its scores over all cases."""
    rows = [row for row in result.scores if row["dataset"] == "equator_errors" and row["status"] == "ok"]
    table = []
    for subject in dict.fromkeys(row["subject"] for row in rows):
        own = [row for row in rows if row["subject"] == subject]
        table.append(
            {
                "subject": subject,
                "cases": len(own),
                "dv_H, m/s": max(row["error_dv_up_max"] for row in own),
                "correct digits": min(row["scd"] for row in own),
                "mixed": min(row["mescd"] for row in own),
                "ns a row": min(row["ns_per_sample"] for row in own),
            }
        )
    return table


def orders(result: Reproduction) -> list[dict[str, Any]]:
    """Return drift, velocity error and fitted order of the algorithms of orders 2, 4, 6 at the papers' interval."""
    rows = [row for row in native(result.scores, result.cases) if row["subject"] in _ORDERS]
    table = []
    for case in dict.fromkeys(row["case"] for row in rows):
        own = {row["subject"]: row for row in rows if row["case"] == case}
        line: dict[str, Any] = {"case": case}
        for name in _ORDERS:
            line |= {
                f"{name}: drift, deg/h": own[name]["drift_deg_per_h"],
                "velocity, m/s" + " " * _ORDERS.index(name): own[name]["velocity_error_end"],
                "order" + " " * _ORDERS.index(name): f"{own[name]['observed_order']:.2f}",
            }
        table.append(line)
    return table


def _ratios(result: Reproduction) -> str:
    rows = {(row["subject"], row["case"]): row for row in native(result.scores, result.cases)}
    cases = [case for subject, case in rows if subject == "panov2"]
    gains = {
        (low, high): [rows[low, case]["drift_deg_per_h"] / rows[high, case]["drift_deg_per_h"] for case in cases]
        for low, high in pairwise(_ORDERS)
    }
    times = [min(rows[name, case]["ns_per_sample"] for case in cases) for name in _ORDERS]
    return (
        f"At the papers' sampling interval order 4 drifts {min(gains['panov2', 'panov4']):.0f} to "
        f"{max(gains['panov2', 'panov4']):.0f} times less than order 2, order 6 "
        f"{min(gains['panov4', 'panov6']):.0f} to {max(gains['panov4', 'panov6']):.0f} times less than order 4, "
        f"for {times[1] / times[0]:.1f} and {times[2] / times[0]:.1f} times the time of order 2."
    )


def headline(result: Reproduction) -> str:
    """Return the one sentence that says what came out."""
    total = len(result.claims)
    numbers = {verdict: sum(row["verdict"] == verdict for row in result.claims) for verdict in VERDICTS}
    return (
        f"{total} printed numbers and statements: {numbers['reproduced']} reproduced, "
        f"{numbers['misprint']} misprints explained, {numbers['not reproduced']} not reproduced."
    )


def show(result: Reproduction, output: Output) -> None:
    """Print the summary without its long tables, which are in ``summary.md``."""
    from sinsbench.report.write import PAGE

    for section in sections(result):
        if section.long and not section.sentence:
            continue
        if section.long:
            output.line(section.title)
        else:
            output.table(section.table, title=section.title)
        if section.sentence:
            output.line(f"{section.sentence}\n")
    output.line(headline(result))
    for failure in result.failures:
        output.line(f"does not hold: {failure}")
    output.line(f"Everything is in {result.folder}: summary.md, scores.json, claims.json, stories.json, data/.")
    output.line(f"The page is {result.folder / PAGE}.")


def markdown(result: Reproduction) -> str:
    """Return the whole summary as Markdown."""
    parts = ["# What the papers print, recomputed", headline(result)]
    parts += [f"- does not hold: {failure}" for failure in result.failures]
    for section in sections(result):
        parts.append(f"## {section.title}")
        if section.table:
            parts.append(markdown_table(section.table))
        if section.sentence:
            parts.append(section.sentence)
    known = ", ".join(f"{name} {value}" for name, value in result.environment.items())
    parts.append(f"Made by `sinsbench reproduce` with {known}.")
    return "\n\n".join(parts) + "\n"
