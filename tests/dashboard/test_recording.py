"""A suite of one's own, run twice by pytest-benchmark: what it stores, and what the command says of it.

Its clock is not the machine's: `work` moves it, so that the same rounds take the same time however busy the machine is.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from sinsbench.cli import run
from sinsbench.dashboard.command import benchmarks
from sinsbench.dashboard.recording import SAMPLES, array_unit

CLOCK = """
import random

now, source = 0.0, random.Random(1)

def timer():
    global now
    now += 1e-9  # pytest-benchmark waits for a clock to move
    return now

def work(seconds):
    global now
    now += seconds * (1 + abs(source.gauss(0, 0.03)))
"""
SUITE = """
import os
import clock

def test_steady(benchmark):
    benchmark.pedantic(clock.work, args=(1e-3,), rounds=100)

def test_planted(benchmark):
    benchmark.pedantic(clock.work, args=(1e-3 * float(os.environ["FACTOR"]),), rounds=100)

def test_without_timing():
    pass
"""
CONFTEST = """
import itertools
import pytest
from sinsbench.dashboard.recording import *

@pytest.fixture(scope="session")
def calibration():
    return itertools.cycle([11.0, 10.0]).__next__
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with three stored runs: two equal ones, and one with a slowdown of 1.5."""
    folder = tmp_path_factory.mktemp("suite")
    for name, text in (("clock.py", CLOCK), ("test_suite.py", SUITE), ("conftest.py", CONFTEST)):
        (folder / name).write_text(text)
    (folder / "pytest.ini").write_text("[pytest]\n")
    for name, factor in (("1", "1"), ("2", "1"), ("3", "1.5")):
        options = ["--benchmark-timer=clock.timer", f"--benchmark-json=run{name}.json", "-p", "pytest_benchmark.plugin"]
        # Without the settings of the run that this test is in: pytest-benchmark is off inside a worker of xdist.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")} | {
            "FACTOR": factor,
            "PYTHONPATH": os.pathsep.join([str(folder), *sys.path]),
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        }
        command = [sys.executable, "-m", "pytest", "-q", *options]
        made = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert made.returncode == 0, made.stdout + made.stderr
        assert "3 passed" in made.stdout
    return folder


def test_a_run_keeps_order_statistics_versions_and_calibration_and_no_name_of_the_machine(store: Path) -> None:
    document = json.loads((store / "run1.json").read_text())
    assert "node" not in document["machine_info"]
    assert {"sinsbench", "numpy", "numba"} <= document["machine_info"]["versions"].keys()
    assert len(document["benchmarks"]) == 2
    for benchmark in document["benchmarks"]:
        assert "data" not in benchmark["stats"]
        assert len(benchmark["stats"]["samples"]) == SAMPLES
        assert benchmark["extra_info"] == {"calibration_ns": 10.0, "calibration_most_ns": 11.0}


def compare(*runs: Path) -> int:
    with pytest.raises(typer.Exit) as left:
        benchmarks(list(runs), 1.1, runs[0].parent / "rows.json")
    return left.value.exit_code


def test_equal_runs_end_well_and_a_slowdown_does_not(store: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [store / f"run{number}.json" for number in (1, 2, 3)]
    assert compare(*runs[:2]) == 0
    assert "slower" not in capsys.readouterr().out
    assert compare(*runs[1:]) == 1
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("slower:")]
    assert len(told) == 1
    # The clock of the third run is that of the second, but for the factor.
    assert told[0].startswith("slower: test_suite.py::test_planted takes 1.5 times as long (minimum 1.5)")
    rows = json.loads((store / "rows.json").read_text())
    assert [row["verdict"] for row in rows] == ["first", "slower", "first", "same"]


def test_the_command_line_compares_a_folder(store: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["benchmarks", str(store)]) == 1
    capsys.readouterr()
    assert run(["benchmarks", str(store / "absent")]) == 2
    assert capsys.readouterr().err == f"sinsbench: {store / 'absent'}: No such file or directory\n"


def test_the_calibration_workload_takes_some_time() -> None:
    # An operation on 50 numbers, called from Python, in ns: a hundredth and a hundred times what it takes today.
    assert 10 < array_unit() < 1e5
