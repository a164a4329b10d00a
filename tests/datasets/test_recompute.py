"""The two paths that compute stored rows again: mpmath for some rows, the differential equations for all of them."""

from __future__ import annotations

import shutil
from itertools import pairwise
from math import inf, nan
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.format.manifest import DatasetError, read_manifest
from sinsdata.generation.generate import generate
from sinsdata.generation.tables import Segment, TableGroup, groups_of
from sinsdata.verification.integrate import compare, integrate, precession_problem, states
from sinsdata.verification.recompute import Worst, errors, pair_columns, python_row, rows_to_recompute
from sinsref.arithmetic import BallArithmetic
from sinsref.precession import solution
from sinsref.rounding import RoundingTally


def _case(dataset: str, mapping: Any, **changes: Any) -> Case:
    return CASE_CLASSES[dataset].from_mapping(mapping(dataset, **changes))


def _group(rows: int, limit: int = 10**9) -> TableGroup:
    return TableGroup(("t",), lambda case: rows, lambda *given: iter(()), lambda case, row: [], spot_limit=limit)


# Which rows.


@settings(derandomize=True, deadline=None)
@given(
    rows=st.integers(1, 500), wanted=st.integers(0, 600), limit=st.integers(1, 600), cuts=st.lists(st.integers(0, 500))
)
def test_rows_to_recompute_are_the_ends_and_between(rows: int, wanted: int, limit: int, cuts: list[int]) -> None:
    group: Any = _group(rows, limit)
    case: Any = None
    chosen = list(rows_to_recompute(group, case, wanted, 0, rows))
    reachable = min(rows, limit)
    assert len(chosen) == min(wanted, reachable)
    assert chosen == sorted(set(chosen))
    assert not chosen or chosen[0] == 0
    assert len(chosen) < 2 or chosen[-1] == reachable - 1
    gaps = [b - a for a, b in pairwise(chosen)]
    assert not gaps or max(gaps) - min(gaps) <= 1
    # The same rows whatever the pieces in which they are looked for.
    ends = [0, *sorted({cut for cut in cuts if cut < rows}), rows]
    pieces = [row for first, end in pairwise(ends) for row in rows_to_recompute(group, case, wanted, first, end)]
    assert pieces == chosen


def test_none_means_all_rows_and_some_groups_have_nothing_to_compute() -> None:
    case: Any = None
    assert list(rows_to_recompute(_group(7), case, None, 2, 6)) == [2, 3, 4, 5]
    assert list(rows_to_recompute(groups_of("dual_precession")[0], case, None, 0, 1)) == []


# What counts as an error.


@pytest.mark.parametrize("dataset", ["dual_precession", "equator_errors"])
def test_stored_rows_agree_and_changed_ones_do_not(dataset: str, mapping: Any) -> None:
    case = _case(dataset, mapping)
    for group in groups_of(dataset):
        if group.exact_row is None:
            continue
        row = min(group.rows(case), group.spot_limit) - 1
        (batches,) = group.batches("test", [Segment(case, row, 1)], RoundingTally())
        stored = [python_row(batch, 0) for batch in batches]
        assert max(error for _, _, error in errors(dataset, group, case, row, stored)) < 1e-32
        for number, table in enumerate(group.tables):
            name = max(pair_columns(dataset, table), key=lambda name: abs(stored[number][name]))
            for changed, least in (
                (stored[number][name] * 1e-29, 9e-30), (nan, inf), (inf, inf), (None, inf),
            ):  # fmt: skip
                row_values = [dict(values) for values in stored]
                low = row_values[number][f"{name}_lo"]
                row_values[number][f"{name}_lo"] = None if changed is None else low + changed
                found = {(t, c): error for t, c, error in errors(dataset, group, case, row, row_values)}
                assert found.pop((table, name)) >= least
                assert max(found.values()) < 1e-32


def test_modes_that_do_not_exist_must_be_null(mapping: Any) -> None:
    case = _case("equator_errors", mapping, v_east=9000.0)
    group = next(group for group in groups_of("equator_errors") if group.tables == ("modes",))
    (batches,) = group.batches("test", [Segment(case, 0, 1)], RoundingTally())
    stored = python_row(batches[0], 0)
    assert set(stored.values()) == {None, case.name}
    assert max(error for *_, error in errors("equator_errors", group, case, 0, [stored])) == 0
    assert max(error for *_, error in errors("equator_errors", group, case, 0, [{**stored, "mu": 0.0}])) == inf


def test_the_worst_remembers_where() -> None:
    worst = Worst()
    for size, where in ((1e-3, "a"), (nan, "b"), (5.0, "c")):
        worst.take(size, where)
    assert (worst.size, worst.where, worst.count) == (inf, "b", 3)


# The differential equations.


@pytest.fixture(scope="module")
def made(make_dataset: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    out = tmp_path_factory.mktemp("integrated")
    return {dataset: make_dataset(dataset, out).folder for dataset in ("equator_errors", "dual_precession")}


@pytest.mark.parametrize("dataset", ["equator_errors", "dual_precession"])
def test_every_row_solves_the_differential_equations(dataset: str, made: dict[str, Path]) -> None:
    """With misalignment and initial attitude: what the second case of each dataset has."""
    reports: list[tuple[int, int, str]] = []
    checks = list(integrate(made[dataset], 1, lambda *report: reports.append(report)))
    tables = {check.where.rpartition(" ")[2] for check in checks}
    assert tables >= {"equator_errors": {"truth", "transition"}, "dual_precession": {"truth", "increments"}}[dataset]
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
    assert failed.detail.endswith(f"epoch {epoch}")


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
