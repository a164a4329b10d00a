"""Stored runs that differ are told apart, equal ones are not; runs of two machines never meet."""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from sinsbench.dashboard import COMPARISON_FIELDS, Run, StoreError, compared, is_run, read_runs, standing_regressions
from sinsbench.dashboard.recording import SAMPLES, order_statistics

CALIBRATION = ("calibration_ns", "calibration_most_ns")
LAPTOP = {"brand_raw": "Laptop", "count": 2}


def stored(
    day: int,
    factors: dict[str, float],
    *,
    rounds: int = 200,
    calibration: tuple[float, float] | None = (10.0, 10.0),
    cpu: dict[str, Any] | None = None,
    noise: float = 0.03,
) -> dict[str, Any]:
    """Return what pytest-benchmark stores, of rounds that others disturb: some of them much, none to run faster."""
    source = random.Random(day)
    benchmarks = []
    for name, factor in factors.items():
        times = [1e-3 * factor * (1 + abs(source.gauss(0, noise)) + (source.random() < 0.1)) for _ in range(rounds)]
        ranked = sorted(times)
        stats = {"min": ranked[0], "median": ranked[rounds // 2], "mean": sum(times) / rounds, "rounds": rounds}
        benchmarks.append(
            {
                "fullname": name,
                "group": None,
                "stats": stats | {"samples": order_statistics(times)},
                "extra_info": dict(zip(CALIBRATION, calibration or (), strict=False)),
            }
        )
    machine = {"system": "Linux", "machine": "x86_64", "cpu": cpu or LAPTOP, "python_version": "3.11.9"}
    commit = {"id": f"{day:040x}", "dirty": False}
    return {"benchmarks": benchmarks, "machine_info": machine, "commit_info": commit, "datetime": f"2026-01-{day:02}"}


@pytest.fixture
def runs_of(tmp_path: Path) -> Callable[..., list[Run]]:
    def read(*documents: dict[str, Any]) -> list[Run]:
        files = [tmp_path / f"{number}.json" for number in range(len(documents))]
        for file, document in zip(files, documents, strict=True):
            file.write_text(json.dumps(document))
        return read_runs(files)

    return read


def verdicts(runs: list[Run]) -> list[str]:
    return [row["verdict"] for row in compared(runs)]


def test_a_planted_slowdown_is_told_and_marked_with_its_commit(runs_of: Callable[..., list[Run]]) -> None:
    runs = runs_of(stored(1, {"a": 1, "b": 1}), stored(2, {"a": 1.5, "b": 1}))
    rows = compared(runs)
    assert [(row["benchmark"], row["verdict"]) for row in rows] == [
        ("a", "first"), ("a", "slower"), ("b", "first"), ("b", "same"),
    ]  # fmt: skip
    (standing,) = standing_regressions(rows)
    assert standing["commit"] == f"{2:040x}"
    assert standing["baseline_commit"] == f"{1:040x}"
    assert standing["ratio_minimum"] == pytest.approx(1.5, rel=0.01)  # minima of 200 rounds, noise of 3 per cent
    assert standing["p_value"] < 1e-6
    assert all(list(row) == [field.name for field in COMPARISON_FIELDS] for row in rows)


@pytest.mark.parametrize("seed", range(2, 28))
def test_equal_runs_are_not_told_apart(runs_of: Callable[..., list[Run]], seed: int) -> None:
    assert verdicts(runs_of(stored(1, {"a": 1}, noise=0.1), stored(seed, {"a": 1}, noise=0.1))) == ["first", "same"]


def test_a_step_is_marked_once_and_undone_once(runs_of: Callable[..., list[Run]]) -> None:
    runs = runs_of(*(stored(day, {"a": factor}) for day, factor in enumerate([1, 1.5, 1.5, 1, 1], start=1)))
    rows = compared(runs)
    assert [row["verdict"] for row in rows] == ["first", "slower", "same", "faster", "same"]
    assert standing_regressions(rows[:3]) == [rows[1]]
    assert standing_regressions(rows) == []


def test_small_steps_are_marked_when_they_add_up(runs_of: Callable[..., list[Run]]) -> None:
    runs = runs_of(*(stored(day, {"a": 1.04 ** (day - 1)}, noise=0.01) for day in range(1, 6)))
    assert verdicts(runs) == ["first", "same", "same", "slower", "same"]


def test_runs_of_two_machines_are_never_compared(runs_of: Callable[..., list[Run]]) -> None:
    runs = runs_of(stored(1, {"a": 1}), stored(2, {"a": 3}, cpu={"brand_raw": "Board", "count": 4}))
    assert verdicts(runs) == ["first", "first"]


def test_a_slow_machine_excuses_and_a_slow_calibration_does_not_accuse(runs_of: Callable[..., list[Run]]) -> None:
    for factor, calibration, verdict in (
        (1.5, (15.0, 15.0), "same"),  # throttled
        (1.5, (10.0, 15.0), "same"),  # throttled in between
        (1, (5.0, 5.0), "same"),
        (1 / 1.5, (5.0, 10.0), "same"),
        (1.5 * 1.5, (15.0, 15.0), "slower"),
        (1 / 1.5 / 1.5, (7.0, 10.0), "faster"),
    ):
        later = stored(2, {"a": factor}, calibration=calibration)
        assert verdicts(runs_of(stored(1, {"a": 1}), later)) == ["first", verdict], (factor, calibration)


def test_few_rounds_decide_nothing(runs_of: Callable[..., list[Run]]) -> None:
    few = [stored(day, {"a": factor}, rounds=3) for day, factor in ((1, 1), (2, 2), (3, 1))]
    assert verdicts(runs_of(*few)) == ["first", "undecided", "same"]
    # 2 / C(2 n, n), the probability of samples that do not overlap, is below the level from n = 7 on.
    for rounds, verdict in ((6, "undecided"), (7, "slower")):
        pair = [stored(day, {"a": factor}, rounds=rounds, calibration=None) for day, factor in ((4, 1), (5, 3))]
        assert verdicts(runs_of(*pair)) == ["first", verdict]


def test_order_statistics_do_not_depend_on_the_number_of_rounds() -> None:
    assert order_statistics([3.0, 1.0, 2.0]) == [1.0, 2.0, 3.0]
    levels = [(i + 0.5) / SAMPLES for i in range(SAMPLES)]
    for rounds in (31, 100, 12345):
        kept = order_statistics([float(k) for k in reversed(range(rounds))])
        # A round is one step on the axis of times.
        assert kept == pytest.approx([level * rounds for level in levels], rel=0, abs=1)


def test_other_files_are_refused_in_one_line_or_passed_over_in_a_folder(tmp_path: Path) -> None:
    good, rows, broken = (tmp_path / name for name in ("run.json", "rows.json", "broken.json"))
    good.write_text(json.dumps(stored(1, {"a": 1})))
    rows.write_text("[{}]")
    assert [run.file for run in read_runs([tmp_path, good])] == ["run.json"]
    assert not is_run([{}])
    document = stored(1, {"a": 1})
    document["benchmarks"][0]["stats"]["min"] = 0
    broken.write_text(json.dumps(document))
    empty = tmp_path / "empty"
    empty.mkdir()
    for path, words in (
        (rows, "is not a stored run"),
        (broken, "times of a must be positive"),
        (empty, "holds no stored benchmark run"),
        (tmp_path / "absent.json", "No such file"),
    ):
        with pytest.raises(StoreError, match=words) as refused:
            read_runs([path])
        assert "\n" not in str(refused.value)
