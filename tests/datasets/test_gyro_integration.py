"""Rows of `gyro_systems` against the differential equations integrated from the start."""

from __future__ import annotations

from pathlib import Path

import pytest

from sinsdata.cases import GyroCase
from sinsdata.generation.generate import generate
from sinsdata.verification import gyroscopic_problem
from sinsdata.verification.integrate import integrate
from sinsref.arithmetic import Arithmetic, Number
from sinsref.gyroscopic import Kinematics, Motion

CASES = [
    {
        "name": "circle",
        "motion": "great_circle",
        "latitude": "0.7",
        "longitude": "3.1415",
        "course": "2",
        "speed": "250 + t",
        "altitude": "5*t",
        "duration": "30",
        "interval": "10",
    },
    {
        "name": "track",
        "motion": "track",
        "latitude": "0.01*sin(t/100)",
        "longitude": "1 - 1e-3*t",
        "duration": "30",
        "interval": "10",
    },
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    cases = [GyroCase.from_mapping(given) for given in CASES]
    made: Path = generate("gyro_systems", "sweep", cases, tmp_path_factory.mktemp("gyro")).folder
    return made


def failed(folder: Path) -> set[str]:
    return {check.where.rpartition(" ")[2] for check in integrate(folder, 1) if not check.holds}


def test_every_row_follows_from_the_equations(folder: Path) -> None:
    """Great circle over the date line in a climb; a track over the equator, westward and against the Earth."""
    checks = list(integrate(folder, 1))
    assert {check.where.rpartition(" ")[2] for check in checks} == {"sensors", "truth", "reference"}
    assert all(check.holds for check in checks)
    assert all(check.what == "8 rows integrated from the differential equations" for check in checks)


def test_another_tuning_of_the_gyropendulums_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """kappa off by a part in 1e25: what 30 digits tell apart."""
    usual = gyroscopic_problem.usual_tuning

    def mistuned(ar: Arithmetic, motion: Motion) -> tuple[Number, Number]:
        scale, kappa = usual(ar, motion)
        return scale, kappa * (1 + ar.number("1e-25"))

    monkeypatch.setattr(gyroscopic_problem, "usual_tuning", mistuned)
    assert failed(folder) == {"reference"}


def test_another_attraction_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Heavier(Kinematics):
        def __init__(self, ar: Arithmetic, motion: Motion) -> None:
            super().__init__(ar, motion)
            self.radius = self.radius * (1 + ar.number("1e-25"))

    monkeypatch.setattr(gyroscopic_problem, "Kinematics", Heavier)
    assert "truth" in failed(folder)
