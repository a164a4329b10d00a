"""Results for reports, in a folder: scores of short motions, and rows of every other kind."""

import json
from pathlib import Path
from typing import Any

import pytest

from report_results import (
    CASE,
    CHECKS,
    CLAIMS,
    DATASETS,
    ENVIRONMENT,
    EQUATOR,
    MUTANTS,
    PRECESSION,
    STORIES,
    stored_run,
)  # fmt: skip
from sinsbench.report.results import Results, read_results
from sinsbench.report.sections import sections
from sinsbench.scoring.score import score
from sinsdata.tiers import cases_of


@pytest.fixture(scope="session")
def scores() -> list[dict[str, Any]]:
    def rows(subjects, dataset, name):
        case = next(case for case in cases_of(dataset, "short") if name in ("", case.name))
        return score(subjects, [case], repetitions=1)

    return rows(PRECESSION, "dual_precession", CASE) + rows(EQUATOR, "equator_errors", "")


@pytest.fixture(scope="session")
def folder(scores, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    documents = {
        "scores": scores,
        "claims": CLAIMS,
        "mutants": MUTANTS,
        "stories": STORIES,
        "datasets": DATASETS,
        "checks": CHECKS,
        "environment": ENVIRONMENT,
        "runs/1": stored_run(1, 1.0),
        "runs/2": stored_run(2, 1.5),
        "manifest": {"of": "something else"},
    }
    (folder / "runs").mkdir()
    for name, document in documents.items():
        (folder / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    return folder


@pytest.fixture(scope="session")
def results(folder: Path) -> Results:
    return read_results([folder])


@pytest.fixture(scope="session")
def parts(results: Results):
    return sections(results)
