"""`sinsbench generate`: workers, parts and tables as a user asks for them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from sinsbench.cli import run
from sinsdata.generation.specification import Specification
from sinsdata.tiers import cases_of

CASES = """
[[case]]
name = "short"
spin_rate = 1
precession_ratio = -1
nutation = "pi/18"
spin_rate_dual = 0.5
nutation_dual = 10
initial_velocity = [10, 0, 0]
interval = "0.01"
duration = "0.1"
"""


@pytest.fixture
def generate(tmp_path: Path) -> Any:
    (tmp_path / "cases.toml").write_text(CASES, encoding="utf-8")

    def command(out: str, *options: str) -> tuple[int, list[dict[str, Any]]]:
        rows = tmp_path / "rows.json"
        rows.unlink(missing_ok=True)
        status = run([
            "generate", "dual_precession", "--cases", str(tmp_path / "cases.toml"), "--out", str(tmp_path / out),
            "--tables", "increments,truth", "--json", str(rows), *options,
        ])  # fmt: skip
        return status, json.loads(rows.read_text(encoding="utf-8")) if rows.exists() else []

    return command


def test_workers_and_parts_give_the_same_content(generate: Any, capsys: pytest.CaptureFixture[str]) -> None:
    status, rows = generate("one")
    assert (status, sorted(row["table"] for row in rows)) == (0, ["cases", "increments", "truth"])
    assert generate("two", "--workers", "2") == (0, rows)
    assert generate("parts", "--shard", "2/2") == (0, [])
    assert "1 of 3 files are there" in " ".join(capsys.readouterr().out.split())
    assert generate("parts", "--shard", "1/2") == (0, rows)
    assert generate("one") == (0, rows)
    assert "It was there already, byte for byte." in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--shard", "3/2"), "must be I/N"),
        (("--tables", "trooth"), "has no table 'trooth'"),
        (("--workers", "0"), "--workers"),
    ],
)
def test_wrong_options(
    generate: Any, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], message: str
) -> None:
    assert generate("out", *options) == (2, [])
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err


def test_files_are_counted_and_not_the_parts_that_have_several(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["generate", "error_equations", "--tier", "short", "--out", str(tmp_path), "--shard", "1/2"]
    assert run(command) == 0
    printed = " ".join(capsys.readouterr().out.split())
    specification = Specification("error_equations", "short", cases_of("error_equations", "short"))
    files = [len(shard.files) for shard in specification.shards]
    assert sum(files) > len(files)
    assert f"{sum(files[::2])} of {sum(files)} files are there" in printed
