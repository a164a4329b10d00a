"""Generate, verify, score and judge the papers' cases."""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from sinsbench.claims.model import PAPERS
from sinsbench.cli.claims import changed_verdicts, claim_rows, story_tables
from sinsbench.cli.output import Progress
from sinsbench.reproduction.files import write_results
from sinsbench.scoring.score import score
from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.generate import generate
from sinsdata.tiers import paper_cases
from sinsdata.verify import load_cases, verify

#: Packages whose versions decide on what comes out.
_PACKAGES = ("sinsbench", "numpy", "scipy", "numba", "pyarrow", "python-flint", "mpmath")


@dataclass(frozen=True)
class Reproduction:
    """What one run found.

    Attributes
    ----------
    folder : Path
        Where everything was written.
    datasets : list of dict
        A row a dataset: values proved, rows, checks.
    scores : list of dict
        As `sinsbench.scoring.score.score` returns them.
    cases : tuple of Case
        The cases that were scored.
    claims : list of dict
        As `sinsbench.claims.model.ClaimResult.to_row` gives them.
    stories : list of (str, list of dict, str)
        Title, table and sentence.
    environment : dict
        Versions and machine.
    failures : list of str
        What does not hold: failed checks, broken subjects, verdicts that differ from those on record.
    """

    folder: Path
    datasets: list[dict[str, Any]]
    scores: list[dict[str, Any]]
    cases: tuple[Case, ...]
    claims: list[dict[str, Any]]
    stories: list[tuple[str, list[dict[str, Any]], str]]
    environment: dict[str, str]
    failures: list[str]

    @property
    def holds(self) -> bool:
        """Whether nothing failed."""
        return not self.failures


def reproduce(out: Path, progress: Progress) -> Reproduction:
    """Run everything on the papers' cases and write it to a folder.

    Parameters
    ----------
    out : Path
        The folder: ``data/`` with the datasets, ``summary.md`` and the JSON files.
    progress : callable
        ``progress(done, total, what)``.

    Returns
    -------
    Reproduction
    """
    # Shares of the whole, roughly by time.
    steps = iter((0, 10, 20, 30, 70, 80, 100))

    def part(title: str) -> Callable[[int, int, str], None]:
        start, width = next(steps), 10

        def inner(done: int, total: int, what: str) -> None:
            progress(round(start + width * done / max(total, 1)), 100, f"{title}: {what}")

        inner(0, 1, "")
        return inner

    failures: list[str] = []
    datasets: list[dict[str, Any]] = []
    scored: list[Case] = []
    scores: list[dict[str, Any]] = []
    for dataset in CASE_CLASSES:
        made = generate(dataset, "paper", paper_cases(dataset), out / "data", part(f"generate {dataset}"))
        checks = list(verify(made.folder))
        failures += [f"{check.where}: {check.what}: {check.detail}" for check in checks if not check.holds]
        known = made.manifest["certification"]
        datasets.append(
            {
                "dataset": dataset,
                "cases": len(made.manifest["cases"]),
                "rows": sum(entry["rows"] for entry in made.manifest["tables"].values()),
                "values proved": known["values"],
                "exact zeros": known["exact_zeros"],
                "checks that hold": sum(check.holds for check in checks),
                "checks that fail": sum(not check.holds for check in checks),
            }
        )
        # The cases that are scored are those of the files just written.
        _, cases = load_cases(made.folder)
        scored += cases
        scores += score(None, cases, part(f"score {dataset}"))
    failures += [
        f"{row['subject']} on {row['case']}: {row['status']}: {row['message']}"
        for row in scores
        if row["status"] not in ("ok", "not applicable")
    ]
    claims = claim_rows(PAPERS, part("claims"))
    failures += changed_verdicts(claims)
    result = Reproduction(
        out, datasets, scores, tuple(scored), claims, story_tables(PAPERS, part("stories")), _environment(), failures
    )
    write_results(result)
    progress(100, 100, "done")
    return result


def _environment() -> dict[str, str]:
    packages = {name: version(name) for name in _PACKAGES}
    return {"python": platform.python_version(), "machine": platform.machine(), "system": platform.system(), **packages}
