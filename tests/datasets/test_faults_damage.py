"""Damage: files that changed, vanished or belong to something else are made again, and never taken for finished."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rehearsals import SHARDS, beside, half_written, make, partial_of, snapshot, sound, target_of

FILES = ["cases.parquet", "truth-00002-of-00004.parquet", "digits.csv", "croissant.json", "manifest.json"]


def flip(path: Path, number: int) -> None:
    """Flip one bit of a file, the same for the same number."""
    content = bytearray(path.read_bytes())
    bit = random.Random(number).randrange(8 * len(content))
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def _rename(path: Path) -> None:
    path.rename(path.with_name("renamed.parquet"))


def _older(path: Path) -> None:
    manifest = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**manifest, "version": "0.9.0"}), encoding="utf-8")


DAMAGES: list[tuple[str, Callable[[Path], Any]]] = [
    *[(file, lambda path: flip(path, 1)) for file in FILES],
    ("increments-00001-of-00004.parquet", Path.unlink),
    ("truth-00000-of-00004.parquet", _rename),
    ("truth-00003-of-00004.parquet", lambda path: path.write_bytes(path.read_bytes()[:-1])),
    ("manifest.json", Path.unlink),
    ("manifest.json", _older),
]


@pytest.mark.parametrize(("file", "damage"), DAMAGES)
def test_a_damaged_dataset_is_found_and_made_again(
    undisturbed: Any, tmp_path: Path, file: str, damage: Callable[[Path], Any]
) -> None:
    folder = make(tmp_path).folder
    damage(folder / file)
    if file != "manifest.json":
        assert not sound(folder)
    made = make(tmp_path)
    assert (made.reused, made.manifest) == (0, undisturbed.manifest)
    assert snapshot(folder) == snapshot(undisturbed.folder)
    assert beside(tmp_path) == ["sweep"]


def test_an_intact_dataset_is_not_made_again(undisturbed: Any, tmp_path: Path) -> None:
    folder = make(tmp_path).folder
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert make(tmp_path).reused == SHARDS
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before


class _StoppedError(Exception):
    """Stops a run when all of its files are finished."""


def stopped(out: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Leave all files of a dataset finished but the dataset not, and return their folder."""

    def stop(*arguments: Any) -> None:
        raise _StoppedError

    with monkeypatch.context() as patched:
        patched.setattr("sinsdata.generation.destination.LocalFolder.finish", stop)
        with pytest.raises(_StoppedError):
            make(out)
    assert half_written(out) == []
    return partial_of(out)


@pytest.mark.parametrize(
    ("file", "damage"),
    [
        *[("files/truth-00002-of-00004.parquet", lambda path, n=n: flip(path, n)) for n in range(8)],
        *[("truth-00002-of-00004.parquet.receipt", lambda path, n=n: flip(path, n)) for n in range(4)],
        ("files/cases.parquet", Path.unlink),
        ("cases.parquet.receipt", Path.unlink),
        ("files/truth-00002-of-00004.parquet", lambda path: path.write_bytes(path.read_bytes()[:-1])),
    ],
)
def test_a_finished_file_that_is_damaged_is_computed_again(
    undisturbed: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, damage: Callable[[Path], Any]
) -> None:
    """Whichever bit: in the data, in the footer of the file, or in its receipt."""
    damage(stopped(tmp_path, monkeypatch) / file)
    made = make(tmp_path)
    assert (made.reused, made.manifest) == (SHARDS - 1, undisturbed.manifest)
    assert snapshot(target_of(tmp_path)) == snapshot(undisturbed.folder)


def test_files_of_another_specification_are_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped(tmp_path, monkeypatch)
    assert make(tmp_path, 30).reused == 0
    assert make(tmp_path).reused == SHARDS
