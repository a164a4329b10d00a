"""The commands for published packages, where none is installed but SciPy."""

import json

import pytest

from sinsbench.cli import run
from sinsbench.peers.catalogue import packages

NUMBER = sum(len(package.subjects) for package in packages())


@pytest.fixture(autouse=True)
def no_environments(tmp_path, monkeypatch):
    monkeypatch.setenv("SINSBENCH_PEERS", str(tmp_path / "none"))


def test_list(tmp_path, capsys):
    assert run(["peers", "list", "--json", str(tmp_path / "list.json")]) == 0
    rows = json.loads((tmp_path / "list.json").read_text())
    assert len(rows) == NUMBER
    assert next(row for row in rows if row["subject"] == "scipy.Rotation")["version"]
    assert "scalar-first" in capsys.readouterr().out


def test_score_scipy_beside_a_built_in_subject(tmp_path, capsys):
    file = tmp_path / "rows.json"
    wanted = ["scipy.Rotation", "qmt", "--beside", "panov4", "--case", "variant1_coning", "--rungs", "2"]
    files = ["--json", str(file), "--markdown", str(tmp_path / "table.md")]
    assert run(["peers", "score", *wanted, *files]) == 1  # qmt needs an environment
    rows = {(row["subject"], row["interval"]): row for row in json.loads(file.read_text())}
    assert rows["panov4", 0.01]["status"] == "ok"
    exponential = rows["scipy.Rotation", 0.01]
    assert exponential["drift_deg_per_h"] == pytest.approx(12.85, rel=5e-4)  # half a unit of the last digit
    assert exponential["version"].startswith("scipy ")
    assert exponential["local_order"] == pytest.approx(2, abs=0.02)
    assert rows["qmt.quatFromGyrStrapdown", 0.01]["status"] == "not installed"
    assert "sinsbench peers install qmt" in rows["qmt.quatFromGyrStrapdown", 0.01]["message"]
    assert "12.85" in capsys.readouterr().out
    lines = (tmp_path / "table.md").read_text().splitlines()
    assert lines[0].startswith("| subject | method | variant1_coning: drift, deg/h |")
    assert [line.split("|")[1].strip() for line in lines[2:]] == [
        "panov4",
        "scipy.Rotation",
        "qmt.quatFromGyrStrapdown",
    ]
    assert "| exponential | 12.85 |" in lines[3]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["score", "arhs"], "there is no package 'arhs'; admissible: scipy, python-ins, ahrs"),
        (["install", "arhs"], "there is no package 'arhs'"),
        (["list", "arhs"], "there is no package 'arhs'"),
        (["score", "scipy", "--case", "nowhere"], "unknown case 'nowhere'"),
    ],
)
def test_what_is_wrong_is_said(arguments, message, capsys):
    assert run(["peers", *arguments]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


def test_environments_do_not_take_the_place_of_a_file(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("kept")
    assert run(["peers", "install", "qmt", "--into", str(file)]) == 2
    assert str(file) in capsys.readouterr().err
    assert file.read_text() == "kept"
