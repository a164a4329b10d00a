"""Kills and interrupts, of the run and of its workers: what was finished is kept, the same call goes on from it."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import time
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from rehearsals import (
    DURATION,
    PATIENCE,
    SHARD_ROWS,
    SHARDS,
    DeadlyCase,
    beside,
    cone,
    finished_shards,
    half_written,
    make,
    offspring,
    snapshot,
    sound,
    survivors,
    target_of,
    wait_for_rows,
)
from sinsdata.format.manifest import DatasetError
from sinsdata.generation.workers import WorkerError
from sinsdata.verification.stored_cases import find_datasets

# The child kills itself, as `kill -9` does, at an instant named by its argument.
SELF_KILL = """
import sys
from pathlib import Path
from sinsdata.generation.destination import LocalFolder
from rehearsals import die, make

out, instant, duration = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])

def progress(done, total, what):
    if what == "rows" and instant.isdecimal() and done >= int(instant):
        die()

put_receipt, rename, receipts = LocalFolder.put_receipt, Path.rename, []

def fourth_dies(*arguments):
    receipts.append(arguments)
    if len(receipts) == 4:
        die()
    put_receipt(*arguments)

def renamed(path, target):
    result = rename(path, target)
    if ".old-" in str(target):
        die()
    return result

if instant == "before a receipt":
    LocalFolder.put_receipt = fourth_dies
if instant == "before the manifest":
    LocalFolder.finish = die
if instant == "before the rename":
    Path.rename = die
if instant == "between the renames":
    Path.rename = renamed
if instant == "after the rename":
    LocalFolder.tidy = die
make(out, duration, progress)
"""
#: Instant -> files that are finished by then. Rows are reported while the file that will hold them is open.
INSTANTS = {
    "0": 0,
    "1": 0,
    "1025": 1,
    "6000": 6,
    "before a receipt": 3,
    "before the manifest": SHARDS,
    "before the rename": SHARDS,
}


def _killed(start_python: Any, out: Path, instant: str, duration: int = DURATION) -> None:
    process = start_python(SELF_KILL, out, instant, duration)
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == -signal.SIGKILL, errors


@pytest.mark.parametrize(("instant", "finished"), INSTANTS.items())
def test_after_a_kill_the_same_call_goes_on(
    start_python: Any, undisturbed: Any, tmp_path: Path, instant: str, finished: int
) -> None:
    _killed(start_python, tmp_path, instant)
    assert not target_of(tmp_path).exists()
    with pytest.raises(DatasetError, match="not a dataset"):
        find_datasets(tmp_path)
    made = make(tmp_path)
    assert (made.shards, made.reused) == (SHARDS, finished)
    assert made.manifest == undisturbed.manifest
    assert beside(tmp_path) == ["sweep"]
    assert sound(made.folder)


def test_a_kill_after_the_rename_finds_the_dataset_finished(
    start_python: Any, undisturbed: Any, tmp_path: Path
) -> None:
    _killed(start_python, tmp_path, "after the rename")
    assert sound(target_of(tmp_path))
    made = make(tmp_path)
    assert (made.reused, made.manifest) == (SHARDS, undisturbed.manifest)
    assert beside(tmp_path) == ["sweep"]


def test_a_kill_leaves_an_older_dataset_whole(start_python: Any, tmp_path: Path) -> None:
    folder = make(tmp_path, 1).folder
    before = snapshot(folder)
    for instant in ("1025", "before the manifest", "before the rename"):
        _killed(start_python, tmp_path, instant)
        assert find_datasets(tmp_path) == [folder]
        assert snapshot(folder) == before
    assert sound(folder)


def test_a_kill_between_the_two_renames_leaves_both_whole(start_python: Any, undisturbed: Any, tmp_path: Path) -> None:
    """The one instant at which a kill takes the place of the old dataset from it; nothing of it is lost."""
    before = snapshot(make(tmp_path, 1).folder)
    _killed(start_python, tmp_path, "between the renames")
    with pytest.raises(DatasetError, match="not a dataset"):
        find_datasets(tmp_path)
    (old,) = target_of(tmp_path).parent.glob(".old-*")
    assert snapshot(old) == before
    assert sound(old)
    made = make(tmp_path)
    assert (made.reused, made.manifest) == (SHARDS, undisturbed.manifest)


RUN = """
import sys
from pathlib import Path
from rehearsals import announce, make

make(Path(sys.argv[1]), int(sys.argv[2]), announce, workers=int(sys.argv[3]))
"""


@pytest.mark.parametrize(
    ("end", "workers", "moment"), [(signal.SIGKILL, 1, 0.03), (signal.SIGKILL, 2, 0.07), (signal.SIGTERM, 2, 0.02)]
)
def test_a_kill_from_outside(
    start_python: Any, tmp_path: Path, end: signal.Signals, workers: int, moment: float
) -> None:
    """At moments that nobody chose; nothing goes on in the background."""
    process = start_python(RUN, tmp_path, 120, workers)
    wait_for_rows(process, SHARD_ROWS)
    time.sleep(moment)
    children = offspring(process)
    assert len(children) >= (workers if workers > 1 else 0)
    process.send_signal(end)
    assert process.wait(PATIENCE) == -end
    assert survivors(children, 10) == []
    with pytest.raises(DatasetError, match="not a dataset"):
        find_datasets(tmp_path)
    finished = finished_shards(tmp_path)
    made = make(tmp_path, 120)
    assert made.reused == finished > 0
    assert beside(tmp_path) == ["sweep"]
    assert sound(made.folder)


# What a terminal sends on Ctrl-C goes to the run and to its workers alike.
@pytest.mark.parametrize("workers", [1, 2])
def test_control_c(start_python: Any, undisturbed: Any, tmp_path: Path, workers: int) -> None:
    script = "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n" + RUN
    process = start_python(script, tmp_path, 120, workers, start_new_session=True)
    wait_for_rows(process, SHARD_ROWS)
    children = offspring(process)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == -signal.SIGINT
    # The interrupt ends the run, and once. It may come while a receipt that is not there yet is looked for, and then
    # Python names that too; anything else would be an error of ours.
    raised = re.findall(r"^(\w+(?:\.\w+)*)(?=:|$)(?!.*most recent call)", errors, re.MULTILINE)
    named = [name for name in raised if name.endswith(("Error", "Exception", "Interrupt", "Exit"))]
    assert named[-1] == "KeyboardInterrupt"
    assert set(named[:-1]) <= {"FileNotFoundError"}
    assert errors.count("Traceback") == len(named)
    assert survivors(children, 10) == []
    assert half_written(tmp_path) == []
    finished = finished_shards(tmp_path)
    made = make(tmp_path, 120)
    assert made.reused == finished > 0
    assert sound(made.folder)


def test_an_interrupt_before_anything_is_finished_leaves_nothing(tmp_path: Path) -> None:
    def interrupt(done: int, total: int, what: str) -> None:
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(tmp_path, progress=interrupt)
    assert beside(tmp_path) == []


def test_an_interrupt_between_the_two_renames_restores_the_old_dataset(
    undisturbed: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make(tmp_path, 1).folder
    before = snapshot(folder)
    rename = Path.rename

    def interrupted(path: Path, target: Path) -> Path:
        result = rename(path, target)
        if ".old-" in str(target):
            raise KeyboardInterrupt
        return result

    with monkeypatch.context() as patched:
        patched.setattr(Path, "rename", interrupted)
        with pytest.raises(KeyboardInterrupt):
            make(tmp_path)
    assert snapshot(folder) == before
    made = make(tmp_path)
    assert (made.reused, made.manifest) == (SHARDS, undisturbed.manifest)
    assert beside(tmp_path) == ["sweep"]


@pytest.mark.parametrize("pause", [0, 0.5])
def test_a_worker_that_is_killed_is_replaced(undisturbed: Any, tmp_path: Path, pause: float) -> None:
    """Noticed while the run waits for results, and, after a pause, when it hands out the next file."""
    killed = []

    def kill_one(done: int, total: int, what: str) -> None:
        if done > 2 * SHARD_ROWS and not killed:
            killed.append(multiprocessing.active_children()[0])
            killed[0].kill()
            time.sleep(pause)

    made = make(tmp_path, progress=kill_one, workers=2)
    assert killed
    assert made.manifest == undisturbed.manifest
    assert beside(tmp_path) == ["sweep"]
    assert multiprocessing.active_children() == []


def test_workers_that_die_again_and_again(tmp_path: Path) -> None:
    case = cone(1)
    deadly = DeadlyCase(**{field.name: getattr(case, field.name) for field in fields(case)})
    with pytest.raises(WorkerError, match=r"workers died 4 times in a row, .*; what is finished is kept"):
        make(tmp_path, cases=[deadly], workers=2)
    assert beside(tmp_path) == []
    assert multiprocessing.active_children() == []
