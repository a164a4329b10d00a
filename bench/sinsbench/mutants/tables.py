"""Tables of defects and of what became of them."""

from collections.abc import Mapping, Sequence
from typing import Any

from sinsbench.mutants.runner import Mutant, Planting, Verdict

__all__ = ["TITLES", "counts", "grouped", "reasons"]

TITLES: Mapping[Verdict, str] = {
    "survivor": "survivors: results change, and the score does not see it",
    "unexplained": "no difference found, and no reason known",
    "equivalent": "no difference, for a reason",
}
"""Verdicts whose defects are listed, and the titles of the lists."""


def counts(planted: Sequence[Planting]) -> list[dict[str, Any]]:
    """Return a row a subject with the numbers of its defects by verdict, and a row with the sums.

    Parameters
    ----------
    planted : sequence of Planting
    """
    rows: list[dict[str, Any]] = []
    for one in planted:
        verdicts = [mutant.verdict for mutant in one.mutants]
        rows.append(
            {
                "subject": one.subject,
                "planted": len(verdicts),
                "told apart": verdicts.count("told apart"),
                "equivalent": verdicts.count("equivalent"),
                "unexplained": verdicts.count("unexplained"),
                "survivors": verdicts.count("survivor"),
                "told apart in an earlier subject": one.shown,
            }
        )
    names = [name for name in rows[0] if name != "subject"] if rows else []
    return [*rows, {"subject": "all", **{name: sum(row[name] for row in rows) for name in names}}]


def grouped(mutants: Sequence[Mutant], verdict: Verdict) -> list[dict[str, Any]]:
    """Return the defects of a verdict, those of several subjects once.

    Parameters
    ----------
    mutants : sequence of Mutant
    verdict : {"told apart", "equivalent", "unexplained", "survivor"}
    """
    groups: dict[tuple[str, str, str], list[str]] = {}
    for mutant in mutants:
        if mutant.verdict == verdict:
            groups.setdefault((mutant.reason, mutant.kind, mutant.defect), []).append(mutant.subject)
    return [
        {
            "kind": kind,
            "defect": defect,
            **({"reason": reason} if reason else {}),
            "in": names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more",
        }
        for (reason, kind, defect), names in sorted(groups.items())
    ]


def reasons(mutants: Sequence[Mutant]) -> list[dict[str, Any]]:
    """Return the reasons for which defects make no difference, where these are, and how many in how many subjects.

    Parameters
    ----------
    mutants : sequence of Mutant
    """
    groups: dict[tuple[str, str], list[str]] = {}
    for mutant in mutants:
        if mutant.verdict == "equivalent":
            groups.setdefault((_place(mutant), mutant.reason), []).append(mutant.subject)
    return [
        {"where": place, "why it makes no difference": reason, "defects": len(names), "subjects": len(set(names))}
        for (place, reason), names in sorted(groups.items())
    ]


def _place(mutant: Mutant) -> str:
    """Return the table of numbers, or the function or module, that a defect is in."""
    if mutant.kind in ("coefficient", "series"):
        return "table `" + mutant.defect.partition("[")[0].partition(" ")[0] + "`"
    return "`" + mutant.defect.partition(": ")[0].strip(".") + "`"
