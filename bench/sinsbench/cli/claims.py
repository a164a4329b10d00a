"""Claims and the stories behind them, as tables for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from sinsbench.claims.evaluate import evaluate
from sinsbench.claims.model import PAPERS, VERDICTS, recorded_verdicts
from sinsbench.cli.errors import UsageError
from sinsbench.cli.output import Progress


def _known(papers: Sequence[str] | None) -> Sequence[str]:
    for paper in papers or ():
        if paper not in PAPERS:
            raise UsageError(f"unknown paper {paper!r}; admissible: {', '.join(PAPERS)}")
    return papers or PAPERS


def claim_rows(papers: Sequence[str] | None, progress: Progress) -> list[dict[str, Any]]:
    """Recompute the claims of papers, of all of them without a name.

    Raises
    ------
    UsageError
        For an unknown paper.
    """
    rows = []
    wanted = _known(papers)
    for number, paper in enumerate(wanted):
        progress(number, len(wanted), f"claims of {paper}")
        rows += [result.to_row() for result in evaluate(paper)]
    return rows


def check_verdict(verdict: str | None) -> None:
    """Refuse an unknown verdict.

    Raises
    ------
    UsageError
    """
    if verdict not in (None, *VERDICTS):
        raise UsageError(f"unknown verdict {verdict!r}; admissible: {', '.join(VERDICTS)}")


def claim_table(rows: Sequence[Mapping[str, Any]], verdict: str | None) -> list[dict[str, Any]]:
    """Return the claims, of one verdict or of all, with the columns people read."""
    return [
        {
            "claim": f"{row['paper']} {row['id']}",
            "quantity": row["quantity"],
            "printed": row["printed"],
            "computed": _computed(row["computed"], row["printed"]),
            "unit": row["unit"],
            "verdict": row["verdict"],
            "note": row["note"],
        }
        for row in rows
        if verdict in (None, row["verdict"])
    ]


def _computed(value: float | str, printed: str) -> str:
    """Return a computed value with two digits more than are printed, at least six."""
    if isinstance(value, str):
        return value
    digits = sum(character.isdigit() for character in printed.partition("e")[0])
    return f"{value:.{max(6, digits + 2)}g}"


def verdict_counts(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return how many claims of each paper have which verdict."""
    counts = Counter((row["paper"], row["verdict"]) for row in rows)
    papers = dict.fromkeys(row["paper"] for row in rows)
    return [
        {
            "paper": paper,
            **{verdict: counts[paper, verdict] for verdict in VERDICTS},
            "claims": sum(counts[paper, verdict] for verdict in VERDICTS),
        }
        for paper in papers
    ]


def story_tables(papers: Sequence[str] | None, progress: Progress) -> list[tuple[str, list[dict[str, Any]], str]]:
    """Return title, table and sentence of every story of the papers."""
    # Imported here: it loads the compiler, which a process that only shows claims has no use for.
    from sinsbench.claims.stories import stories

    told = []
    wanted = _known(papers)
    for number, paper in enumerate(wanted):
        progress(number, len(wanted), f"stories of {paper}")
        told += [
            (f"{paper}: {story.name.replace('_', ' ')}", list(story.rows), story.sentence) for story in stories(paper)
        ]
    return told


def changed_verdicts(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a line for each claim whose verdict is not the one on record."""
    recorded = {paper: recorded_verdicts(paper) for paper in PAPERS}
    lines = []
    for row in rows:
        before = recorded[row["paper"]].get(row["id"], "reproduced")
        if row["verdict"] != before:
            lines.append(f"changed: {row['paper']} {row['id']} is {row['verdict']}, on record as {before}")
    return lines
