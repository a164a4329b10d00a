"""The row that docs/scores.md reads is what the command beside it prints, and every field that it explains exists."""

import json
import re
import shlex
from pathlib import Path

import pytest

from sinsbench.cli import run
from sinsbench.cli.output import number
from sinsbench.scoring.gyroscopic import FIELDS as GYRO_FIELDS
from sinsbench.scoring.rows import SCORE_FIELDS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "scores.md").read_text(encoding="utf-8")


def test_the_table_is_what_the_command_makes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (command,) = re.findall(r"```console\nsinsbench (.*)\n```", PAGE)
    assert run(shlex.split(command)) == 0
    rows = {r["subject"]: r for r in json.loads(Path("rows.json").read_text()) if r["interval"] == 0.01}
    table = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \|$", PAGE, flags=re.MULTILINE)
    assert len(table) > 5
    # Four digits; what machines differ in lies at the floors, below 1e-13.
    for field, *printed in table:
        assert printed == [number(rows[subject][field]) for subject in ("panov4", "panov6")], field


def test_the_fields_exist() -> None:
    named = set(re.findall(r"`([a-z]+(?:_[a-z]+)+)`", PAGE))
    assert len(named) > 15
    assert named <= {*SCORE_FIELDS, *(field.name for field in GYRO_FIELDS)}
