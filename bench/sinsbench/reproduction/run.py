"""Generate, verify, score and judge the papers' cases.

The process that hands out the parts waits for most of the time: what they compute with is imported where it is used,
in the processes that do the work.
"""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sinsbench.claims.model import PAPERS
from sinsbench.cli.claims import changed_verdicts, claim_rows, story_tables
from sinsbench.reproduction.parallel import Part, run_parts
from sinsbench.subjects.registry import subjects_of
from sinsdata.cases import CASE_CLASSES, Case, DualPrecessionCase

if TYPE_CHECKING:
    from sinsbench.cli.output import Progress
    from sinsdata.generation.generate import Generated
    from sinsdata.verification.verify import Check

#: Datasets whose truth the papers' numbers are judged by, and the tables of it; None for all.
_TABLES = {"equator_errors": None, "dual_precession": ("increments", "truth")}
#: Cases on the equator in a group: as many groups as give two processes the same to do.
_TOGETHER = 3
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
        The folder: ``data/`` with the datasets, ``summary.md``, the JSON files and the page ``report.html``.
    progress : callable
        ``progress(done, total, what)``.

    Returns
    -------
    Reproduction
    """
    # The longest first: the later a paper, the more there is to recompute. What comes after is for other processes:
    # compilers do not give back their memory.
    papers = [Part(f"recomputing {paper}", _judge, (paper,)) for paper in PAPERS[::-1]]
    judged = run_parts(papers, _stretch(progress, 0, 40))[::-1]
    # Here and not in a worker, which an interrupt would end in the middle of a file.
    data = []
    for number, dataset in enumerate(_TABLES):
        progress(40 + 5 * number, 100, f"generating {dataset}")
        data.append(_generate(dataset, out / "data"))
    datasets = [row for row, _, _ in data]
    failures = [failure for _, failed, _ in data for failure in failed]
    cases = [case for _, _, stored in data for case in stored]
    parts = [Part(f"scoring on {group[0].name}", _score, (_subjects(group), group)) for group in _groups(cases)]
    scored = run_parts(parts, _stretch(progress, 50, 98))
    places = {case.name: place for place, case in enumerate(cases)}
    scores = sorted((row for rows in scored for row in rows), key=lambda row: places[row["case"]])
    claims = [row for rows, _ in judged for row in rows]
    failures += [
        f"{row['subject']} on {row['case']}: {row['status']}: {row['message']}"
        for row in scores
        if row["status"] not in ("ok", "not applicable")
    ]
    failures += changed_verdicts(claims)
    stories = [story for _, told in judged for story in told]
    result = Reproduction(out, datasets, scores, tuple(cases), claims, stories, _environment(), failures)
    progress(98, 100, "making the page")
    from sinsbench.report.results import read_results
    from sinsbench.report.write import write_report
    from sinsbench.reproduction.files import write_results

    write_report(read_results(write_results(result)), out)
    progress(100, 100, "done")
    return result


def _generate(dataset: str, folder: Path) -> tuple[dict[str, Any], list[str], tuple[Case, ...]]:
    """Write a dataset and check it; its row, the checks that fail, and its cases as the files hold them."""
    from sinsdata.generation.generate import generate
    from sinsdata.tiers import paper_cases
    from sinsdata.verification.stored_cases import load_cases
    from sinsdata.verification.verify import verify

    made = generate(dataset, "paper", paper_cases(dataset), folder, tables=_TABLES[dataset])
    checks = list(verify(made.folder))
    failures = [f"{check.where}: {check.what}: {check.detail}" for check in checks if not check.holds]
    return _dataset_row(made, checks), failures, load_cases(made.folder)[1]


def _dataset_row(made: Generated, checks: list[Check]) -> dict[str, Any]:
    known = made.manifest["certification"]
    return {
        "dataset": made.manifest["dataset"],
        "cases": made.manifest["cases"],
        "rows": sum(entry["rows"] for entry in made.manifest["tables"].values()),
        "values": known["values"],
        "exact zeros": known["exact_zeros"],
        "bounded zeros": known["bounded_zeros"],
        "checks that hold": sum(check.holds for check in checks),
        "checks that fail": sum(not check.holds for check in checks),
    }


def _stretch(progress: Progress, start: int, end: int) -> Progress:
    """Return a report of progress from one per cent to another."""
    return lambda done, total, what: progress(start + round((end - start) * done / total), 100, what)


def _groups(cases: list[Case]) -> list[tuple[Case, ...]]:
    """Return groups of cases to score together, long ones first.

    A group has its methods compiled once, and their first run, which is not timed, made once.
    """
    precessions = tuple(case for case in cases if isinstance(case, DualPrecessionCase))
    others = sorted((case for case in cases if case not in precessions), key=lambda case: -case.samples)
    groups = [precessions, *(tuple(others[first : first + _TOGETHER]) for first in range(0, len(others), _TOGETHER))]
    return [group for group in groups if group]


def _subjects(group: tuple[Case, ...]) -> list[str]:
    """Return the names of the subjects that a paper's claims rest on."""
    dataset = next(name for name, kind in CASE_CLASSES.items() if isinstance(group[0], kind))
    return [subject.name for subject in subjects_of(dataset) if subject.paper]


def _score(subjects: list[str], cases: tuple[Case, ...]) -> list[dict[str, Any]]:
    from sinsbench.scoring.score import score

    return score(subjects, cases)


def _judge(paper: str) -> tuple[list[dict[str, Any]], list[tuple[str, list[dict[str, Any]], str]]]:
    return claim_rows([paper], _silent), story_tables([paper], _silent)


def _silent(done: int, total: int, what: str) -> None:
    pass


def _environment() -> dict[str, str]:
    packages = {name: version(name) for name in _PACKAGES}
    return {"python": platform.python_version(), "machine": platform.machine(), "system": platform.system(), **packages}
