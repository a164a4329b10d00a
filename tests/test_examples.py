"""The examples in three languages, scored by the commands that docs/scoring.md and docs/mast.md print."""

import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sinsbench.cli import run
from toolchain import provide_tools

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "scoring.md").read_text(encoding="utf-8")
COMMANDS = {"mine": "./mine {input} {output}", "two_sample.js": "node examples/two_sample.js"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    provide_tools(tmp_path / "tools", monkeypatch)
    return tmp_path


def execute(command: str) -> int:
    program, *arguments = shlex.split(command)
    if program == "sinsbench":
        return run(arguments)
    return subprocess.run([program, *arguments], check=False).returncode


def test_every_command_of_the_page_runs_and_so_does_the_python(folder: Path) -> None:
    for language, block in re.findall(r"```(console|python)\n(.*?)```", PAGE, flags=re.DOTALL):
        if language == "python":
            assert subprocess.run([sys.executable, "-c", block], check=False).returncode == 0
            continue
        for command in block.splitlines():
            assert execute(command) == 0, command


def test_the_examples_score_as_the_built_in_method(folder: Path) -> None:
    (compile_it,) = (line for line in PAGE.splitlines() if line.startswith("cc "))
    assert execute(compile_it) == 0
    assert run(["generate", "dual_precession", "--tier", "short", "--out", "sets"]) == 0
    arguments = [word for command in COMMANDS.values() for word in ("--command", command)]
    arguments += ["--on", "sets/dual_precession/short", "--case", "coning_003", "--json", "rows.json"]
    subjects = ["two_sample", "examples/two_sample.py:two_sample"]
    assert run(["score", *subjects, *arguments]) == 0
    errors: dict[str, dict[float, float]] = {}
    for row in json.loads(Path("rows.json").read_text(encoding="utf-8")):
        errors.setdefault(row["subject"], {})[row["interval"]] = row["attitude_error_max"]
    built_in = errors.pop("two_sample")
    assert set(errors) == {*subjects[1:], *COMMANDS}
    for theirs in errors.values():
        # Steps are added and multiplied in another order: a few roundings for each, of which there are up to 1024.
        assert theirs == pytest.approx(built_in, rel=0, abs=1024 * 2.0**-52)


def test_the_program_in_c_says_what_it_misses(folder: Path) -> None:
    (compile_it,) = (line for line in PAGE.splitlines() if line.startswith("cc "))
    assert execute(f"{compile_it} -Wall -Wextra -Werror") == 0
    for lines, complaint in (
        ("", "there is no header in input.csv"),
        ("angle_x,angle_y\n", "there is no column angle_z"),
    ):
        (folder / "input.csv").write_text(lines, encoding="utf-8")
        made = subprocess.run(["./mine", "input.csv", "output.csv"], capture_output=True, text=True, check=False)
        assert (made.returncode, made.stderr) == (1, f"two_sample: {complaint}\n")


def test_estimators_of_ones_own_run_by_the_commands_of_the_page(folder: Path) -> None:
    page = (ROOT / "docs" / "mast.md").read_text(encoding="utf-8")
    section = re.findall(r"## An estimator of your own\n(.*?)\n## ", page, flags=re.DOTALL)[0]
    commands = re.findall(r"```console\n(.*?)\n```", section)
    assert len(commands) == 2
    for command in commands:
        assert execute(f"{command} --json rows.json") == 0, command
    own, program = json.loads(Path("rows.json").read_text(encoding="utf-8"))
    same = {name for name, value in own.items() if re.search("_(rms|max)_", name) and value is not None}
    # A few roundings in each of 6000 steps, of attitudes and of the radius.
    limits = {name: 1e-8 if "position" in name else 1e-12 for name in same}
    assert all(program[name] == pytest.approx(own[name], rel=0, abs=limits[name]) for name in same)
    assert (own["mu_rms_late"] > 0, program["subject"]) == (True, "mast_gyros_program.py")
