"""`sinsbench score --workers`: cases in several processes give what they give in one."""

import json
from pathlib import Path
from typing import Any

import pytest

from sinsbench.cli import run

MOTIONS = """
[case]
motion = "great_circle"
latitude = 0.5
longitude = 0
course = 1
duration = 60
interval = 5

[grid]
speed = [200, 300, 400]
"""
SYSTEM = """
import numpy as np

def still(inputs, start):
    return np.tile(start.vertical, (len(inputs.time) // 2 + 1, 1))

def broken(inputs, start):
    raise ArithmeticError("not today")
"""
#: Fields that hold times.
_TIMES = ("ns_per_step", "ns_per_sample", "us_per_step")


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.chdir(tmp_path)
    Path("motions.toml").write_text(MOTIONS)
    Path("system.py").write_text(SYSTEM)
    return ["score", "system.py:still", "system.py:broken", "--on", "gyro_systems", "--cases", "motions.toml"]


def _told(path: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(path.read_text())
    return [{name: value for name, value in row.items() if name not in _TIMES} for row in rows]


def test_two_processes_tell_what_one_tells(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """In the same order, and with subjects of one's own, of which one fails."""
    assert run([*command, "--json", "one.json"]) == 1
    assert run([*command, "--json", "two.json", "--workers", "2"]) == 1
    rows = _told(Path("one.json"))
    assert rows == _told(Path("two.json"))
    assert [row["subject"] for row in rows] == ["system.py:still", "system.py:broken"] * 3
    assert "not today" in capsys.readouterr().out


def test_a_subject_that_is_not_there_is_told_before_any_process_begins(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    command[1] = "nowhere.py:still"
    assert run([*command, "--workers", "2"]) == 2
    assert "nowhere.py" in capsys.readouterr().err
