"""The command line as a user meets it: what is printed where, which exit status, what is left on disk."""

import json
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from sinsbench.cli import run
from sinsbench.cli.output import Output, cell
from sinsbench.scoring.score import SCORE_FIELDS
from sinsdata.publishing.loading import SHORT as SHORT_TIER

SHORT = """
[[case]]
name = "short"
spin_rate = "2*pi"
precession_ratio = -1
nutation = "pi/18"
spin_rate_dual = 0.5
nutation_dual = 10
initial_velocity = [10, 0, 0]
interval = "0.01"
duration = "0.64"
"""
TRANSPORT = """
[[case]]
name = "transport"
v_east = 250.0          # m/s
height = 5000.0         # m
duration = 7200.0       # s
interval = 60.0         # s
initial_errors = [0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7]
misalignment = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
inertial_longitude = 0.0
"""
SUBJECTS = """
import numpy as np

def _size(angle):
    return len(angle) // 4 + 1

def still(angle, velocity, interval, attitude0, velocity0):
    return np.tile(attitude0, (_size(angle), 1))

def raises(angle, velocity, interval, attitude0, velocity0):
    raise RuntimeError("no gyro")

def short(angle, velocity, interval, attitude0, velocity0):
    return np.tile(attitude0, (_size(angle), 1))[:, :3]

def not_finite(angle, velocity, interval, attitude0, velocity0):
    return np.full((_size(angle), 4), np.nan)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.toml").write_text(SHORT)
    (tmp_path / "transport.toml").write_text(TRANSPORT)
    (tmp_path / "mine.py").write_text(SUBJECTS)
    return tmp_path


def test_own_cases_are_generated_verified_and_scored(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["generate", "dual_precession", "--cases", "short.toml", "--out", "data"]) == 0
    assert run(["verify", "data"]) == 0
    assert run(["score", "panov4", "panov6", "--on", "data", "--json", "scores.json"]) == 0
    printed = capsys.readouterr()
    assert "short" in printed.out
    assert printed.err == ""
    rows = json.loads((folder / "scores.json").read_text())
    assert set(SCORE_FIELDS) == set(rows[0])
    native = {row["subject"]: row for row in rows if row["interval"] == 0.01}
    assert native["panov6"]["attitude_error_max"] < native["panov4"]["attitude_error_max"] / 10


def test_the_case_of_the_readme_runs(folder: Path) -> None:
    assert run(["generate", "equator_errors", "--cases", "transport.toml", "--out", "data"]) == 0
    assert run(["verify", "data/equator_errors/sweep", "--json", "checks.json"]) == 0
    assert all(check["holds"] for check in json.loads((folder / "checks.json").read_text()))


def test_a_failing_subject_is_a_row_and_the_others_still_run(folder: Path) -> None:
    run(["generate", "dual_precession", "--cases", "short.toml", "--out", "data"])
    names = [f"mine.py:{name}" for name in ("raises", "short", "not_finite", "still")]
    assert run(["score", *names, "panov2", "--on", "data", "--json", "scores.json"]) == 1
    rows = json.loads((folder / "scores.json").read_text())
    status = {row["subject"].rpartition(":")[2]: row["status"] for row in rows}
    assert status == {
        "raises": "error",
        "short": "wrong shape",
        "not_finite": "not finite",
        "still": "ok",
        "panov2": "ok",
    }
    assert "no gyro" in next(row["message"] for row in rows if row["status"] == "error")


def test_a_flipped_byte_gives_status_1(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(["generate", "dual_precession", "--cases", "short.toml", "--out", "data"])
    path = folder / "data/dual_precession/sweep/truth.parquet"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    capsys.readouterr()
    assert run(["verify", "data"]) == 1
    assert "truth" in capsys.readouterr().out


BAD = {
    "no such command": (["fly"], "fly"),
    "no such option": (["score", "--fast"], "--fast"),
    "missing argument": (["generate"], "dataset"),
    "unknown dataset": (["generate", "moon"], "equator_errors"),
    "unknown tier": (["generate", "equator_errors", "--tier", "gold"], "paper"),
    "missing case file": (["generate", "equator_errors", "--cases", "no.toml"], "no.toml"),
    "not a dataset": (["verify", "empty"], "manifest.json"),
    "no such folder": (["verify", "nowhere"], "nowhere"),
    "unknown dataset to score on": (["score", "panov6", "--on", "moon"], "dual_precession"),
    "unknown subject": (["score", "panov7", "--on", "dual_precession"], "panov6"),
    "subject of another dataset": (["score", "rk45", "--on", "dual_precession"], "equator_errors"),
    "own subject without a dataset": (["score", "mine.py:still"], "--on"),
    "file without that function": (["score", "mine.py:fly", "--on", "dual_precession"], "still"),
    "file that does not import": (["score", "broken.py:f", "--on", "dual_precession"], "broken.py, line 3"),
    "missing subject file": (["score", "none.py:f", "--on", "dual_precession"], "none.py"),
    "dataset without subjects": (["score", "--on", "error_equations"], "no subjects are scored on error_equations yet"),
    "folder of such a dataset": (
        ["score", "--on", str(SHORT_TIER / "error_equations")],
        "admissible: dual_precession, eq",
    ),
    "empty output": (["generate", "dual_precession", "--cases", "short.toml", "--out", ""], "--out"),
    "empty output of fetch": (["fetch", "dual_precession", "--out", ""], "local folder"),
    "output of export on a URI": (["export", "empty", "--out", "s3://b/x"], "local folder"),
    "no address": (["generate", "dual_precession", "--scheduler", "foo"], "scheme://host:port"),
    "verify a URI": (["verify", "s3://b/x"], "s3://b/x: datasets are read from local folders"),
    "score on a URI": (["score", "panov6", "--on", "s3://b/x"], "s3://b/x: datasets are read from local folders"),
    "publish a URI": (["publish", "s3://b/x", "--out", "o"], "s3://b/x: datasets are read from local folders"),
    "export a URI": (["export", "s3://b/x", "--out", "o"], "s3://b/x: datasets are read from local folders"),
    "unknown tier to fetch": (["fetch", "dual_precession", "--tier", "gold"], "admissible: paper, standard, short"),
    "no such bundle": (["fetch", "dual_precession", "--from", "nowhere"], "nowhere: no such folder"),
    "unknown case": (["score", "panov6", "--case", "variant9"], "variant1_coning"),
    "unknown paper": (["claims", "newton1687"], "loginov2013"),
    "unknown verdict": (["claims", "--verdict", "perhaps"], "misprint"),
    "unknown list": (["list", "planets"], "subjects"),
    "nothing to cite": (["cite", "newton1687"], "lebedev1989"),
    "folder for a file": (["generate", "equator_errors", "--cases", "empty"], "empty"),
    "unwritable output": (["generate", "dual_precession", "--cases", "short.toml", "--out", "mine.py"], "mine.py"),
}


@pytest.mark.parametrize("arguments_and_hint", BAD.values(), ids=BAD)
def test_bad_input_gives_status_2_and_one_line(
    folder: Path, arguments_and_hint: tuple[list[str], str], capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "empty").mkdir()
    (folder / "broken.py").write_text("import math\n\nx = 1 / 0\n")
    before = sorted(folder.rglob("*"))
    arguments, hint = arguments_and_hint
    assert run(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert hint in printed.err
    assert printed.err.count("\n") == 1
    assert "Traceback" not in printed.err
    assert [path for path in sorted(folder.rglob("*")) if "__pycache__" not in path.parts] == before


BAD_CASES = {
    "v_east = nan": "v_east",
    "height = -6378245.0": "height",
    "height = inf": "height",
    "interval = 0": "interval",
    "interval = -60.0": "interval",
    "duration = 1e9": "duration",
    "initial_errors = [1, 2]": "initial_errors",
    'v_east = "600 m/s"': "v_east",
    'v_east = "__import__(1)"': "v_east",
    "v_est = 1.0": "v_east",
    "misalignment = [1, 2, 3]": "misalignment",
    'name = ""': "name",
    "height = true": "height",
}


@pytest.mark.parametrize(("line", "field"), BAD_CASES.items(), ids=BAD_CASES)
def test_bad_cases_name_file_case_and_field(
    folder: Path, line: str, field: str, capsys: pytest.CaptureFixture[str]
) -> None:
    key = line.split(" = ")[0]
    kept = [text for text in TRANSPORT.splitlines() if not text.startswith(f"{key} =")]
    (folder / "bad.toml").write_text("\n".join([*kept, line]))
    assert run(["generate", "equator_errors", "--cases", "bad.toml", "--out", "data"]) == 2
    message = capsys.readouterr().err
    assert "bad.toml" in message
    assert "case 1" in message
    assert field in message
    assert not (folder / "data").exists()


def test_broken_toml_says_where(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "bad.toml").write_text('[[case]]\nname = "x\n')
    assert run(["generate", "equator_errors", "--cases", "bad.toml"]) == 2
    assert "line 2" in capsys.readouterr().err


def test_claims_print_every_number_with_its_verdict(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["claims", "loginov2013", "--no-stories", "--json", "claims.json"]) == 0
    rows = json.loads((folder / "claims.json").read_text())
    fields = (
        "paper, id, where, quantity, printed, unit, computed, relative_difference, rounds_to_printed, verdict, note"
    )
    assert list(rows[0]) == fields.split(", ")
    assert "misprint" in capsys.readouterr().out


@pytest.mark.parametrize("what", ["all", "datasets", "cases", "subjects", "papers"])
def test_list(folder: Path, what: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", what, "--json", "list.json"]) == 0
    assert json.loads((folder / "list.json").read_text())
    assert capsys.readouterr().out


def test_cite_prints_bibtex(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["cite", "panov6"]) == 0
    printed = capsys.readouterr().out
    assert "@software{sinsbench" in printed
    assert "lebedev1989" in printed
    assert "loginov2013" not in printed
    assert run(["cite", "error_equations"]) == 0
    assert "loginov2013" in capsys.readouterr().out


def test_help_loads_nothing_heavy() -> None:
    program = """
        import sys
        from sinsbench.cli import run
        status = run(["--help"])
        heavy = {"numpy", "scipy", "numba", "pyarrow", "pandas", "mpmath", "flint"} & set(sys.modules)
        sys.exit(f"loaded {heavy}" if heavy or status else 0)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "reproduce" in done.stdout


@pytest.mark.parametrize("width", [24, 40, 60, 80, 180])
def test_no_cell_is_cut_off(width: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    rows = [
        {"claim": "loginov2013 table2.III.amplitude.d_longitude_rad", "number": -0.000138466, "note": "a [red]b " * 12},
        {"claim": "x", "number": None, "note": "short"},
    ]
    Output().table(rows, title="o[/x]")
    printed = "".join(capsys.readouterr().out.split())
    assert "o[/x]" in printed
    for row in rows:
        for value in row.values():
            # Folded cells come in pieces, in order: each character is there, beside those of other columns.
            remaining = iter(printed)
            assert all(character in remaining for character in "".join(cell(value).split()))
    assert all(len(line) <= width for line in capsys.readouterr().out.splitlines())


@pytest.mark.parametrize("name", ["", ".", "/", "nowhere/x.json"])
def test_a_file_that_cannot_be_written_is_refused_first(
    name: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["generate", "dual_precession", "--cases", "short.toml", "--out", "data", "--json", name]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (folder / "data").exists()


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = f"{sys.executable} -c 'from sinsbench.cli import main; main()' list | head -1; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "0"
    assert done.stderr == ""


def test_an_interrupt_says_so_and_leaves_nothing_half_written(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from sinsbench.cli import main; main()",
        "reproduce",
        "--out",
        str(tmp_path / "o"),
    ]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True) as process:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(4)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err.decode().splitlines() == [
        "sinsbench: interrupted; no file is half-written, and `generate` goes on where it stopped"
    ]
    assert out == b""
    assert not list((tmp_path / "o").rglob(".writing-*"))  # files of a dataset that are whole may wait for another run
