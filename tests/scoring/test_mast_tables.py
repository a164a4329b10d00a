"""Estimators of the mast's antenna as subjects: by name through `score`, as tables, with longer and longer steps."""

from typing import Any

import numpy as np
import pytest

from sinsbench.cli.scores import score_tables
from sinsbench.scoring.mast import FIELDS
from sinsbench.scoring.mast_steps import largest_stable_step
from sinsbench.scoring.requirements import parse_requirement, violations
from sinsbench.scoring.score import score
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.mast.catalogue import SUBJECTS
from sinsbench.subjects.mast.contract import MastInputs, MastStart
from sinsbench.subjects.registry import MAST_ANTENNA, Subject, subjects_of
from sinsdata.cases import CaseError, MastCase

Rows = list[dict[str, Any]]


@pytest.fixture(scope="module")
def cases() -> tuple[MastCase, ...]:
    return tuple(MastCase(f"brief_{n}", "10", "0.01", seed=str(n), error_seed=str(n)) for n in (1, 2))


@pytest.fixture(scope="module")
def rows(cases: tuple[MastCase, ...]) -> Rows:
    return score(["mekf_nu_az", "cekf_printed_313"], cases)


def test_every_estimator_of_the_catalogue_is_a_subject() -> None:
    assert {subject.name for subject in subjects_of(MAST_ANTENNA)} == set(SUBJECTS)
    assert {subject.paper for subject in subjects_of(MAST_ANTENNA)} == {"sokolov2024"}
    assert callable(resolve("mekf_nu_az").function)


def test_scores_by_name(rows: Rows) -> None:
    assert [(row["subject"], row["case"], row["status"]) for row in rows] == [
        ("mekf_nu_az", "brief_1", "ok"),
        ("cekf_printed_313", "brief_1", "not finite"),
        ("mekf_nu_az", "brief_2", "ok"),
        ("cekf_printed_313", "brief_2", "not finite"),
    ]
    assert all(list(row) == [field.name for field in FIELDS] for row in rows)
    assert rows[0]["nees_joint_10s"] is not None


def test_tables(rows: Rows, cases: tuple[MastCase, ...]) -> None:
    titles, tables = zip(*score_tables(rows, cases), strict=True)
    assert [title.split(" (")[0].split(",")[0] for title in titles] == [
        "estimators on mast_antenna", "no score", "over the seeds: medians",
    ]  # fmt: skip
    scores, told, seeds = tables
    assert [row["subject"] for row in scores] == ["mekf_nu_az"] * 2
    assert all("first at t = " in row["message"] for row in told)
    assert seeds[0]["its band"] == "9.1 to 24.7"  # chi-square of 32 degrees of freedom, halved
    assert float(seeds[0]["NEES at 10 s"]) == pytest.approx(
        np.mean([row["nees_joint_10s"] for row in rows if row["status"] == "ok"]), rel=5e-3
    )
    assert seeds[1]["failed"] == 2


def test_thresholds(rows: Rows) -> None:
    kept = parse_requirement("mast_max_late<0.1")
    missed = parse_requirement("mast_max_late<1e-9")
    assert not violations([kept], rows[:1])
    assert "mekf_nu_az on brief_1" in violations([missed], rows[:1])[0]


def test_the_largest_stable_step() -> None:
    """At 0.02 s the covariance of the continuous filter ceases to be one; the discrete filter works."""
    case = MastCase("steps", "20", "0.01")
    continuous, discrete = (largest_stable_step(resolve(name), case, (1, 2)) for name in ("cekf", "mekf_nu_az"))
    assert (continuous.step, discrete.step, discrete.reason) == (0.01, 0.02, "")
    assert "no longer positive" in continuous.reason
    assert [row["interval"] for row in continuous.rows] == [0.01, 0.02]


def _still(inputs: MastInputs, start: MastStart) -> dict[str, Any]:
    """Leave the start as it is."""
    time = inputs.time[:: round(1 / inputs.step)]
    given = {name: value for name, value in vars(start).items() if name not in ("deviations", "covariance")}
    return {"time": time, **{name.rstrip("_"): np.array([value] * len(time)) for name, value in given.items()}}


def test_an_estimator_that_learns_nothing_has_no_stable_step(cases: tuple[MastCase, ...]) -> None:
    still = LoadedSubject(Subject("still", None, "", ""), _still)
    found = largest_stable_step(still, cases[0], (1, 2))
    assert found.step is None
    assert found.reason.startswith("mu errs by")
    with pytest.raises(CaseError, match="no multiple of it divides 10 s"):
        largest_stable_step(still, cases[0], (3,))
