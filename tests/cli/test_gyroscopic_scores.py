"""`sinsbench score` on gyro_systems as a user meets it: motions and systems of one's own, refusals, responses."""

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest

from sinsbench.cli import run
from sinsbench.scoring.gyroscopic import FIELDS
from sinsbench.scoring.gyroscopic_responses import PERTURBATIONS, RESPONSE_FIELDS

ROOT = Path(__file__).resolve().parents[2]

MOTIONS = """
[[case]]
name = "circle"
motion = "great_circle"
latitude = 0.5
longitude = 0
course = 1
speed = 300
duration = 240
interval = 5

[[case]]
name = "fast"
motion = "great_circle"
latitude = 0.5
longitude = 0
course = 1
speed = "1980 + 0.5*t"
duration = 240
interval = 5

[[case]]
name = "stop"
motion = "track"
latitude = "pi/180 + 0.01*(t - 120)/6371000"
longitude = "pi/6 + 0.1*(t - 120)*(t - 120)/6371000"
rotation_rate = 0
duration = 240
interval = 3
"""
SYSTEMS = """
import numpy as np
from sinsbench.subjects.gyroscopic.subjects import ghc

def still(inputs, start):
    return np.tile(start.vertical, (len(inputs.time) // 2 + 1, 1))

def from_increments(inputs, start):
    assert inputs.kind == "increments"
    assert len(inputs.rate) == len(inputs.time) - 1
    return ghc(inputs, start)

from_increments.takes = "increments"

def with_a_gap(inputs, start):
    inputs.time[9:] += 0.5
    return ghc(inputs, start)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "motions.toml").write_text(MOTIONS)
    (tmp_path / "mine.py").write_text(SYSTEMS)
    return tmp_path


def scores(*arguments: str, status: int = 0) -> list[dict[str, Any]]:
    command = ["score", *arguments, "--on", "gyro_systems", "--cases", "motions.toml", "--json", "rows.json"]
    assert run(command) == status
    rows: list[dict[str, Any]] = json.loads(Path("rows.json").read_text())
    return rows


def test_own_motions_are_generated_verified_and_scored(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "short.toml").write_text(MOTIONS.split("\n\n")[0].replace("240", "40"))
    assert run(["generate", "gyro_systems", "--cases", "short.toml", "--out", "data"]) == 0
    assert run(["verify", "data"]) == 0
    data = ["--on", "data/gyro_systems/sweep", "--case", "circle"]
    assert run(["score", "ghc", "bg_paper_increments", *data, "--json", "rows.json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "max, m" in printed.out
    rows = json.loads((folder / "rows.json").read_text())
    assert list(rows[0]) == [field.name for field in FIELDS]
    assert {row["subject"]: row["takes"] for row in rows} == {"ghc": "points", "bg_paper_increments": "increments"}
    (finest,) = (row for row in rows if row["subject"] == "ghc" and row["interval"] == 5)
    assert finest["vertical_error_max_m"] < 0.01


def test_scores_from_the_file_are_those_from_the_dataset_made_of_it(folder: Path) -> None:
    run(["generate", "gyro_systems", "--cases", "motions.toml", "--out", "data", "--tables", "truth"])
    run(["score", "full", "--on", "data/gyro_systems/sweep", "--case", "circle", "--json", "rows.json"])
    stored = json.loads((folder / "rows.json").read_text())
    direct = scores("full", "--case", "circle")
    for rows in (stored, direct):
        for row in rows:
            del row["ns_per_step"]
    assert direct == stored


def test_conditions_that_break_are_rows_that_say_which_and_when(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = scores("ghc", "gf", "gf_increments", "full", "--case", "fast", "--case", "stop")
    told = {(row["subject"], row["case"]): (row["status"], row["message"]) for row in rows if row["interval"] in (5, 3)}
    # 1980 + 0.5 t m/s reach 2B/(m l) = 2000 m/s after 40 s, which steps of 10 and 20 s see at their ends.
    speed = "0 < E < pi/2, that is 0 < v < 2B/(m l), does not hold, first at t = {} s"
    assert told["gf", "fast"] == ("not applicable", speed.format(50))
    assert told["gf_increments", "fast"] == ("not applicable", speed.format(60))
    status, message = told["ghc", "stop"]
    assert status == "not applicable"
    assert message.startswith("h > 0 does not hold, first at t = 12")
    assert told["full", "stop"] == told["ghc", "fast"] == ("ok", None)
    assert "h > 0 does not hold" in " ".join(capsys.readouterr().out.split())


BAD_MOTIONS = {
    "through a pole": ('latitude = "pi/2 - 0.01 + 1e-4*t"\nlongitude = 0', "latitude", "within 0.001 rad of a pole"),
    "nose up": ('latitude = 0.5\nlongitude = "1e-4*t"\npitch = "0.01*t"', "pitch", "of a right angle"),
    "at rest in inertial space": (
        'latitude = 0.5\nlongitude = "-7.292115e-5*t"', "latitude", "speed falls below 0.001 m/s",
    ),
    "a slip in a formula": ('latitude = "0.5 + sin(t"\nlongitude = 0', "latitude", "'0.5 + sin(t'"),
    "too few samples": ('latitude = 0.5\nlongitude = "1e-4*t"\ninterval = 120', "interval", "whole steps of four"),
}  # fmt: skip


@pytest.mark.parametrize("motion", BAD_MOTIONS.values(), ids=BAD_MOTIONS)
@pytest.mark.parametrize("command", ["score", "generate"])
def test_inadmissible_motions_say_what_and_when(
    folder: Path, motion: tuple[str, str, str], command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    lines, field, why = motion
    interval = "" if "interval" in lines else "interval = 5\n"
    if command == "generate" and "interval" in lines:
        return  # a dataset may have any number of samples
    (folder / "bad.toml").write_text(f'[[case]]\nname = "bad"\nmotion = "track"\nduration = 240\n{interval}{lines}\n')
    words = ["ghc", "--on", "gyro_systems"] if command == "score" else ["gyro_systems", "--out", "data"]
    assert run([command, *words, "--cases", "bad.toml"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert field in printed.err
    assert why in printed.err
    assert not (folder / "data").exists()


def test_own_systems_stand_beside_built_in_ones(folder: Path) -> None:
    rows = scores("mine.py:still", "mine.py:from_increments", "ghc_increments", "--case", "circle")
    own, built_in = ([row for row in rows if row["subject"] == name] for name in
                     ("mine.py:from_increments", "ghc_increments"))  # fmt: skip
    assert [row["vertical_error_max_m"] for row in own] == [row["vertical_error_max_m"] for row in built_in]
    # Whoever believes to stand still is off by the way.
    still = [row["vertical_error_max_m"] for row in rows if row["subject"] == "mine.py:still"]
    assert still == pytest.approx([300 * 240] * len(still), rel=1e-6)


def test_own_systems_run_in_processes_of_their_own(folder: Path) -> None:
    (folder / "loop.py").write_text("def loop(inputs, start):\n    while True:\n        pass\n")
    shutil.copy(ROOT / "examples" / "gyroscopic_system.py", folder)
    name = "gyroscopic_system.py:moment_of_velocity"
    rows = scores(name, "loop.py:loop", "--case", "circle", "--timeout", "2", status=1)
    assert {(row["subject"], row["status"]) for row in rows} == {(name, "ok"), ("loop.py:loop", "timeout")}
    here = scores(name, "--case", "circle")
    isolated = [row["vertical_error_max_m"] for row in rows if row["subject"] == name]
    assert isolated == [row["vertical_error_max_m"] for row in here]


def test_a_sampling_gap_is_told_with_its_place(folder: Path) -> None:
    rows = scores("mine.py:with_a_gap", "--case", "circle", status=1)
    assert {row["status"] for row in rows} == {"error"}
    assert "sampling gap: 5.5 s between t = 40 s and 45.5 s, 5 s elsewhere" in rows[-1]["message"]


@pytest.mark.parametrize("kind", ["points", "increments"])
def test_programs_get_the_tables_and_results_are_looked_up(folder: Path, kind: str) -> None:
    """A program that copies what it got shows the columns, and its answer scores as a file of results does."""
    program = folder / "copy.py"
    program.write_text(
        "import csv, shutil, sys\n"
        "rows = list(csv.DictReader(open(sys.argv[1])))\n"
        "shutil.copy(sys.argv[1], sys.argv[3])\n"
        "out = csv.writer(open(sys.argv[2], 'w'))\n"
        "out.writerow(['time', 'vertical_x', 'vertical_y', 'vertical_z'])\n"
        "out.writerows([row['time'], *(row[f'vertical0_{axis}'] for axis in 'xyz')] for row in rows)\n"
    )
    seen = folder / "seen.csv"
    command = f"{sys.executable} {program} {{input}} {{output}} {seen}"
    rows = scores("--command", command, "--name", "copy", "--takes", kind, "--case", "circle")
    assert {(row["subject"], row["status"], row["takes"]) for row in rows} == {("copy", "ok", kind)}
    assert rows[-1]["vertical_error_max_m"] == pytest.approx(300 * 240, rel=1e-6)
    header, first, *_ = (line.split(",") for line in seen.read_text().splitlines())
    sensors = {"points": ("angular_rate_x", "specific_force_z"), "increments": ("angle_x", "velocity_z")}[kind]
    assert {*sensors, "radius", "speed", "attitude0_w", "velocity0_z", "turn_rate0", "sphere_radius"} <= set(header)
    values = dict(zip(header, map(float, first), strict=True))
    assert (values["sample"], values["time"], values["sphere_radius"], values["speed"]) == (0, 0, 6371000, 300)
    assert (values["angle_x"] == 0) if kind == "increments" else (values["angular_rate_x"] != 0)
    results = ["case,time,vertical_x,vertical_y,vertical_z"]
    vertical = [values[f"vertical0_{axis}"] for axis in "xyz"]
    results += [",".join(["circle", *map(repr, [5.0 * k, *vertical])]) for k in range(49)]
    (folder / "results.csv").write_text("\n".join(results))
    (row,) = scores("--result", "results.csv", "--takes", kind, "--case", "circle")
    assert row["vertical_error_max_m"] == rows[-1]["vertical_error_max_m"]
    (folder / "results.csv").write_text("\n".join(results[:20] + results[21:]))
    (row,) = scores("--result", "results.csv", "--case", "circle", status=1)
    assert "1 row missing of 49, the first of them time 95" in row["message"]


def test_responses_have_a_table_of_their_own(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = scores("ghc", "mine.py:still", "--case", "circle", "--responses", "--require", "response_max_m<1e4")
    assert list(rows[0]) == [field.name for field in RESPONSE_FIELDS]
    assert [row["error"] for row in rows] == 2 * list(PERTURBATIONS)
    by_error = {row["error"]: row["response_max_m"] for row in rows if row["subject"] == "ghc"}
    # Within four minutes of the start the tilt itself, 1e-4 rad, is largest.
    assert by_error["tilt"] == pytest.approx(637.1, rel=1e-6)
    assert "50 ug" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["ghc", "--on", "dual_precession"], "ghc is a subject of gyro_systems"),
        (["panov6", "--on", "gyro_systems"], "panov6 is a subject of dual_precession"),
        (["mine.py:still", "--on", "gyro_systems", "--takes", "rates"], "admissible: points, increments"),
        (["mine.py:still"], "--on gyro_systems"),
        (["ghc", "--case", "T9"], "unknown case 'T9'"),
        (["panov6", "--responses"], "panov6 is a subject of dual_precession"),
        (["--responses", "--on", "equator_errors"], "not of equator_errors"),
        (["--cases", "motions.toml"], "--cases motions.toml: say of which dataset"),
        (["ghc", "--responses", "--ladder"], "--responses"),
        (["--on", "data", "--cases", "motions.toml"], "--cases motions.toml: say of which dataset"),
        (["ghc", "--cases", "none.toml"], "none.toml"),
        (["ghc", "--require", "vertical_error_m<1"], "did you mean"),
        (["ghc", "--on", "gyro_systems", "--figure", "x.svg"], "x.svg"),
    ],
)
def test_wrong_usage_gives_one_line(
    folder: Path, arguments: list[str], hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["score", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert hint in printed.err
    assert printed.err.count("\n") == 1


def test_thresholds_hold_for_the_rows_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scores("ghc", "--case", "circle", "--require", "vertical_error_max_m<1", "--require", "status==ok")
    scores("ghc", "--case", "circle", "--require", "vertical_error_max_m<1e-9", status=1)
    assert "required < 1e-09" in capsys.readouterr().out


def test_tables_fit_a_window_of_100_columns(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    scores("ghc", "bg_equilibrium", "--case", "circle")
    printed = capsys.readouterr().out
    assert printed.count("subject") == 1  # one part: nothing is folded or broken
    for heading in ("heading", "pitch", "roll", "ns a"):
        assert heading in printed


def test_the_systems_of_the_examples_are_one_in_two_languages(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from toolchain import provide_tools

    shutil.copytree(ROOT / "examples", folder / "examples")
    provide_tools(folder / "tools", monkeypatch)
    python = "examples/gyroscopic_system.py:moment_of_velocity"
    rows = scores(python, "full", "--command", "node examples/gyroscopic_system.js", "--case", "circle")
    errors = {row["subject"]: row["vertical_error_max_m"] for row in rows if row["interval"] == 5}
    # The same operations in another order, 24 steps: 1e-16 rad each, and the square of a small angle.
    assert errors["gyroscopic_system.js"] == pytest.approx(errors[python], abs=1e-7)
    # The same equations as (3.1) in other variables: integrated with the same method, of the same size of error.
    assert errors[python] == pytest.approx(errors["full"], rel=0.2)
