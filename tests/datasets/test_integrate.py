"""The path that integrates the differential equations and compares every row."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.format.manifest import DatasetError, read_manifest
from sinsdata.generation.generate import generate
from sinsdata.verification.integrate import compare, integrate, precession_problem, states
from sinsref.arithmetic import BallArithmetic
from sinsref.precession import solution

#: Nine epochs in one step of the integration, rows beyond those that are looked at by default.
TURN: dict[str, Any] = {
    "motion": "climbing_turn",
    "latitude": "pi/4",
    "longitude": 0.5,
    "height": 5000.0,
    "speed": 250,
    "heading": "pi/3",
    "climb_rate": "10",
    "turn_rate": "pi/240",
    "duration": 16,
    "interval": "2",
    "initial_errors": [0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7],
}


def _case(dataset: str, mapping: Any, **changes: Any) -> Case:
    return CASE_CLASSES[dataset].from_mapping(mapping(dataset, **changes))


@pytest.fixture(scope="module")
def made(make_dataset: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    out = tmp_path_factory.mktemp("integrated")
    folders = {dataset: make_dataset(dataset, out).folder for dataset in ("equator_errors", "dual_precession")}
    cases = [CASE_CLASSES["error_equations"].from_mapping({**TURN, "name": name}) for name in ("a", "b")]
    return {**folders, "error_equations": generate("error_equations", "sweep", cases, out).folder}


@pytest.mark.parametrize("dataset", ["equator_errors", "dual_precession", "error_equations"])
def test_every_row_solves_the_differential_equations(dataset: str, made: dict[str, Path]) -> None:
    """With misalignment and initial attitude: what the second case of each dataset has."""
    reports: list[tuple[int, int, str]] = []
    checks = list(integrate(made[dataset], 1, lambda *report: reports.append(report)))
    expected = {
        "equator_errors": {"truth", "transition"},
        "dual_precession": {"truth", "increments", "mean_rates", "accumulated", "resolved"},
        "error_equations": {"motion", "truth", "nonlinear", "linearisation"},
    }
    tables = {check.where.rpartition(" ")[2] for check in checks}
    assert tables == expected[dataset]
    assert all(check.holds for check in checks), checks
    assert [report[:2] for report in reports] == [(0, 2), (1, 2)]


def test_two_processes_find_the_same(made: dict[str, Path]) -> None:
    assert list(integrate(made["equator_errors"], 2)) == list(integrate(made["equator_errors"], 1))


@pytest.mark.parametrize(
    ("dataset", "table", "column"),
    [
        ("equator_errors", "truth", "d_longitude"),
        ("equator_errors", "transition", "p66"),
        ("dual_precession", "truth", "q_w"),
        ("dual_precession", "truth", "w_body_x"),
        ("dual_precession", "increments", "velocity_x"),
        ("error_equations", "motion", "longitude"),
        ("error_equations", "nonlinear", "dv_up"),
    ],
)
def test_a_defect_of_1e_28_in_any_row_is_found(
    dataset: str, table: str, column: str, made: dict[str, Path], tmp_path: Path
) -> None:
    folder = Path(shutil.copytree(made[dataset], tmp_path / "copy"))
    path = folder / f"{table}.parquet"
    data = pq.read_table(path, partitioning=None)
    high, low = data[column].to_pylist(), data[f"{column}_lo"].to_pylist()
    low[8] += 1e-28 * high[8]
    place = data.column_names.index(f"{column}_lo")
    pq.write_table(data.set_column(place, data.schema.field(place), pa.array(low)), path)
    (failed,) = [check for check in integrate(folder, 1) if not check.holds]
    assert failed.where == f"{folder}: {table}"
    epoch = 8 + ("sample" in data.column_names and data["sample"][0].as_py())
    assert failed.detail.endswith((f"epoch {epoch}", f"row {epoch}, {column}"))


@pytest.mark.parametrize(
    ("interval", "duration"),
    [("1/1000", "1/50"), ("0.5", "20"), ("10", "20")],
    ids=["many epochs a step", "few", "many steps an epoch"],
)
def test_epochs_are_met_whatever_their_distance(mapping: Any, interval: str, duration: str) -> None:
    """To 38 digits, eight more than are compared: errors of the integration never pass for errors of a table."""
    case: Any = _case("dual_precession", mapping, interval=interval, duration=duration)
    with BallArithmetic(256) as ar:
        steps = states(ar, precession_problem(ar, case), ar.number(case.interval), case.samples)
        for epoch, state in enumerate(steps):
            attitude, velocity, _ = solution(ar, case.motion, ar.number(case.interval) * epoch)
            for x, y in zip(state[1:8], [*attitude, *velocity], strict=True):
                assert abs(x - y) < 1e-38 * 1000  # the velocity reaches hundreds of m/s
        assert epoch == case.samples


def test_rows_of_a_case_are_found_in_the_middle_of_the_files(mapping: Any, tmp_path: Path) -> None:
    cases = [_case("equator_errors", mapping, name=name, v_east=v) for name, v in (("a", 10), ("b", 200), ("c", -90))]
    folder = generate("equator_errors", "sweep", cases, tmp_path).folder
    rows = cases[0].samples + 1
    right = compare(cases[1], {"truth": ([folder / "truth.parquet"], rows)})
    assert right["truth"].size < 1
    assert right["truth"].count == rows
    assert compare(cases[1], {"truth": ([folder / "truth.parquet"], 2 * rows)})["truth"].size > 1e6


def test_what_is_not_integrated_is_refused(made: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sinsdata.verification.integrate._PROBLEMS", {})
    assert read_manifest(made["dual_precession"])["dataset"] == "dual_precession"
    with pytest.raises(DatasetError, match="the equations of dual_precession are not integrated here"):
        list(integrate(made["dual_precession"]))
