"""Rows of `mast_antenna` against the differential equations integrated from the start."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsdata.cases import MastCase
from sinsdata.generation.generate import generate
from sinsdata.truth.mast_blocks import constants_of
from sinsdata.verification import mast_problem
from sinsdata.verification.integrate import integrate
from sinsref.arithmetic import Arithmetic, Number
from sinsref.mast import Constants, Orbit, level_force

STEPS = 12
#: The paper's motion and one satellite of it; a fast motion over the date line, with a mast that leans, and a fault.
CASES = [
    {"name": "paper", "duration": "0.12", "interval": "0.01"},
    {"name": "one", "duration": "0.12", "interval": "0.01", "run": "paper", "satellites_used": "1", "range_sd": "1"},
    {
        "name": "fast",
        "duration": "0.6",
        "interval": "0.05",
        "longitude": "pi - 1e-5",
        "latitude": "pi/3",
        "velocity_east": "1000 + 50*sin(3*t)",
        "velocity_up": "30*t",
        "vehicle_rotation": ["0.1", "-0.2", "0.3"],
        "mast_rotation": ["0.2", "-0.1", "0"],
        "satellites": [["pi/2", "pi/3"], ["5*pi/6", "pi/18"], ["2*pi/3", "pi/6"], ["pi", "pi/4"]],
        "fault": "specific_force2",
        "fault_time": "0.2",
        "fault_size": "0.01",
    },
]
TABLES = {
    "sensors": 2 * STEPS,
    "satellites": 2 * (STEPS + 1),
    "measurements": 3 * (STEPS + 1),
    "truth": 2 * (STEPS + 1),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    cases = [MastCase.from_mapping(given) for given in CASES]
    made: Path = generate("mast_antenna", "sweep", cases, tmp_path_factory.mktemp("mast")).folder
    return made


def failed(folder: Path) -> dict[str, str]:
    """Return what was found in the tables that do not hold."""
    return {check.where.rpartition(" ")[2]: check.detail for check in integrate(folder, 1) if not check.holds}


def test_every_row_follows_from_the_equations(folder: Path) -> None:
    """Readings, orbits, noise and a fault of 0.01 m/s^2 from the third of twelve steps on."""
    checks = list(integrate(folder, 1))
    told = {check.where.rpartition(" ")[2]: check.what for check in checks}
    assert told == {table: f"{rows} rows integrated from the differential equations" for table, rows in TABLES.items()}
    assert all(check.holds for check in checks), [check.detail for check in checks]


@pytest.mark.parametrize(
    ("table", "column", "defect"),
    [
        ("sensors", "middle_specific_force2_y", 1e-12),
        ("sensors", "end_angular_rate2_z", 1e-14),
        ("sensors", "noise_angular_rate1_x", 1e-20),
        ("satellites", "satellite3_velocity_x", 2e-11),
        ("measurements", "range1", 2e-7),
        ("truth", "eta_w", 1e-14),
        ("truth", "latitude", 2e-14),
        ("truth", "mast_absolute_rate_x", 1e-14),
    ],
)
def test_a_defect_of_a_few_times_the_accuracy_is_found(
    table: str, column: str, defect: float, folder: Path, tmp_path: Path
) -> None:
    """In a late row of the last case."""
    copy = Path(shutil.copytree(folder, tmp_path / "copy"))
    path = copy / f"{table}.parquet"
    data = pq.read_table(path, partitioning=None)
    values = data[column].to_pylist()
    values[-2] += defect
    place = data.column_names.index(column)
    pq.write_table(data.set_column(place, data.schema.field(place), pa.array(values)), path)
    found = failed(copy)
    assert list(found) == [table]
    assert "times the accuracy that is stated, at fast, epoch " in found[table]
    assert found[table].endswith(f"epoch {STEPS - 1}, {column}")


def test_another_mast_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def longer(ar: Arithmetic, case: MastCase) -> Constants:
        constants = constants_of(ar, case)
        return replace(constants, mast_length=constants.mast_length * (1 + 2.0**-20))

    monkeypatch.setattr(mast_problem, "constants_of", longer)
    assert set(failed(folder)) == {"sensors"}


def test_a_force_that_contradicts_the_place_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Coriolis' acceleration off by a millionth: the vehicle drifts away at 1e-7 m/s, and comes 1e-8 m far."""

    def off(constants: Constants, *given: Any) -> list[Number]:
        return level_force(replace(constants, rotation_rate=constants.rotation_rate * (1 + 2.0**-20)), *given)

    monkeypatch.setattr(mast_problem, "level_force", off)
    assert set(failed(folder)) == {"sensors", "satellites", "measurements", "truth"}


def test_another_orbit_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Slower(Orbit):
        @classmethod
        def at(cls, ar: Arithmetic, rotation_rate: Number) -> Orbit:
            orbit = Orbit.at(ar, rotation_rate)
            return replace(orbit, motion=orbit.motion * (1 - 2.0**-30))

    monkeypatch.setattr(mast_problem, "Orbit", Slower)
    assert set(failed(folder)) == {"satellites", "measurements"}
