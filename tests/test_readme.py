"""Every command and example of the README runs, and its table is what the command beside it makes."""

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from sinsbench.cli import run
from toolchain import provide_tools

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
DATASETS = (ROOT / "docs" / "datasets.md").read_text(encoding="utf-8")


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page, flags=re.DOTALL)


def commands(page: str) -> list[str]:
    return [line for block in blocks(page, "console") for line in block.splitlines()]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    provide_tools(tmp_path / "tools", monkeypatch)
    (tmp_path / "my.toml").write_text(blocks(README, "toml")[0])
    (tmp_path / "sweep.toml").write_text(blocks(DATASETS, "toml")[0])
    return tmp_path


def test_the_two_commands_are_the_first() -> None:
    first = ["python -m pip install . && sinsbench reproduce", "python -m pip install tox && tox"]
    assert commands(README)[:2] == first


def run_all(page: str, first: int) -> None:
    for command in commands(page)[first:]:
        program, *arguments = shlex.split(command)
        if program == "sinsbench":
            assert run(arguments) == 0, command
        else:
            subprocess.run([program, *arguments], check=True)


def printed(page: str, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    (example,) = blocks(page, "python")
    exec(compile(example, "page", "exec"), {})  # the example itself
    return capsys.readouterr().out


def test_every_command_of_the_readme_runs_and_so_does_the_python(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_all(README, 2)
    drawn = (folder / "orders.svg").read_text()
    assert "largest attitude error, rad" in drawn
    assert printed(README, capsys).endswith(" rad\n")


def test_every_command_of_the_datasets_page_runs_and_so_does_the_python(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_all(DATASETS, 0)
    assert (folder / "checks.json").exists()
    assert printed(DATASETS, capsys).endswith(" m\n")


def test_the_table_is_that_of_the_main_job(folder: Path) -> None:
    assert run(["reproduce"]) == 0
    summary = (folder / "sinsbench-results" / "summary.md").read_text(encoding="utf-8")
    made = re.search(r"## Orders 2, 4 and 6 compared\n\n(\|.*?)\n\n", summary, flags=re.DOTALL)
    assert made
    # Timings do not appear in this table, and its four digits are far above what differs between machines.
    assert made.group(1) in README
