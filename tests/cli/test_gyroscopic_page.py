"""The commands of docs/gyroscopic.md, and the tables beside them."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from sinsbench.cli import run
from toolchain import provide_tools

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "gyroscopic.md").read_text(encoding="utf-8")
#: Commands, and the table that stands behind the last of them, if there is one.
BLOCKS = re.findall(r"```console\n(.*?)```(?:\n\n```text\n(.*?)```)?", PAGE, flags=re.DOTALL)
TIME = "step"


def numbers(line: str) -> list[float]:
    return [float(word) for word in re.findall(r"(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?(?![\w.])", line)]


@pytest.mark.parametrize(("commands", "table"), BLOCKS)
def test_commands_run_and_print_the_table(
    commands: str, table: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    provide_tools(tmp_path / "tools", monkeypatch)
    for command in commands.splitlines():
        capsys.readouterr()
        program, *arguments = shlex.split(command)
        assert program == "sinsbench"
        assert run(arguments) == 0, command
    printed = capsys.readouterr().out.splitlines()
    words = [line.split() for line in table.splitlines()]
    heading = next((k for k, line in enumerate(words) if line[0] == "subject"), 0)
    timed = bool(words) and words[heading][-1] == TIME
    for row in table.splitlines()[heading + 1 :]:
        name = row.split()[0]
        shown = numbers(row.partition(name)[2])
        found = [numbers(line.partition(name)[2]) for line in printed if line.split()[:1] == [name]]
        shown = shown[: len(shown) - timed]
        # The last of three digits, and errors that differ between machines by their rounding alone.
        assert any(len(x) >= len(shown) and x[: len(shown)] == pytest.approx(shown, rel=0.02) for x in found), row
