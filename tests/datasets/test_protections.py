"""The rehearsals are rehearsed: with a protection removed, the fault that it is there for does its harm.

Each test lets a fault happen twice, with the protection and without it; the harm must show in the second run only.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from rehearsals import (
    PATIENCE,
    SHARDS,
    beside,
    make,
    offspring,
    partial_of,
    place_of,
    snapshot,
    sound,
    survivors,
    target_of,
    wait_for_rows,
)  # fmt: skip
from sinsdata.format.manifest import NAME
from sinsdata.format.storage import Kind
from sinsdata.generation import destination, generate, shards, workers
from sinsdata.generation.destination import LocalFolder, RemoteFolder
from sinsdata.generation.workers import WorkerError

#: ``harm(tmp_path)``: lets the fault happen and tells whether it did harm.
Harm = Callable[[Path], bool]
#: ``remove(patch)``: takes the protection away.
Removal = Callable[[pytest.MonkeyPatch], None]


def _interrupt(*arguments: Any) -> None:
    raise KeyboardInterrupt


def _interrupt_when(rows: int) -> Callable[[int, int, str], None]:
    return lambda done, total, what: _interrupt() if what == "rows" and done >= rows else None


def _stop_before_the_end(out: Path) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LocalFolder, "finish", _interrupt)
        with pytest.raises(KeyboardInterrupt):
            make(out)
    return partial_of(out)


def _change(path: Path, number: int) -> None:
    content = bytearray(path.read_bytes())
    content[number] ^= 1
    path.write_bytes(content)


def _half_a_file_moves_along(out: Path) -> bool:
    """Another run writes a file that this one has finished, and is not done with it when the dataset moves."""
    with suppress(FileNotFoundError), ExitStack() as stack:

        def write_half(done: int, total: int, what: str) -> None:
            if what == "rows" and done == total:
                path = stack.enter_context(place_of(out).write("truth-00000-of-00004.parquet"))
                path.write_bytes(b"PAR1")

        make(out, progress=write_half)
    return not sound(target_of(out))


@contextmanager
def _in_place(target: Path, beside: Path, run: str) -> Iterator[Path]:
    yield target


def _an_older_dataset_suffers(out: Path) -> bool:
    before = snapshot(make(out, 1).folder)
    with pytest.raises(KeyboardInterrupt):
        make(out, progress=_interrupt_when(2000))
    return snapshot(target_of(out)) != before


def _the_old_is_lost_between_the_renames(out: Path) -> bool:
    make(out, 1)
    rename = Path.rename

    def interrupted(path: Path, target: Path) -> Path:
        if path.name == "files" and not target.exists():
            raise KeyboardInterrupt
        return rename(path, target)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "rename", interrupted)
        with pytest.raises(KeyboardInterrupt):
            make(out)
    return not target_of(out).is_dir()


def _remove_first(made: Path, target: Path, kind: Kind | None = None) -> None:
    shutil.rmtree(target, ignore_errors=True)
    made.rename(target)


def _a_changed_file_is_taken_for_finished(out: Path) -> bool:
    _change(_stop_before_the_end(out) / "files" / "truth-00001-of-00004.parquet", 5000)
    return make(out).reused == SHARDS or not sound(target_of(out))


def _a_changed_receipt_is_believed(out: Path) -> bool:
    receipt = _stop_before_the_end(out) / "truth-00001-of-00004.parquet.receipt"
    text = receipt.read_text(encoding="utf-8")
    place = text.index('"pages": "') + 20
    receipt.write_text(text[:place] + ("0" if text[place] != "0" else "1") + text[place + 1 :], encoding="utf-8")
    make(out)
    return not sound(target_of(out))


def _damage_stays(out: Path) -> bool:
    _change(make(out).folder / "cases.parquet", 100)
    make(out)
    return not sound(target_of(out))


def _a_run_that_is_overtaken_fails(out: Path) -> bool:
    overtaken = []

    def overtake(done: int, total: int, what: str) -> None:
        if done > 3000 and not overtaken:
            overtaken.append(make(out))

    try:
        make(out, progress=overtake)
    except FileNotFoundError:
        return True
    return False


def _half_written_files_stay(out: Path) -> bool:
    with pytest.raises(KeyboardInterrupt):
        make(out, progress=_interrupt_when(1))
    return beside(out) != []


def _a_death_ends_the_run(out: Path) -> bool:
    def kill_one(done: int, total: int, what: str) -> None:
        for child in multiprocessing.active_children()[: done > 1]:
            if made.setdefault("killed", child) is child:
                child.kill()

    made: dict[str, Any] = {}
    try:
        return make(out, progress=kill_one, workers=2).manifest == {}
    except WorkerError:
        return True


def _workers_go_on_after_an_interrupt(out: Path) -> bool:
    with pytest.raises(KeyboardInterrupt):
        make(out, 300, progress=_interrupt_when(1), workers=2)
    # A worker that is told nothing waits for the next task, or works.
    left = [child for child in multiprocessing.active_children() if child.is_alive()]
    for child in left:
        child.kill()
        child.join()
    return left != []


def _an_object_store_shows_a_part(out: Path) -> bool:
    place = RemoteFolder(target_of(out).as_uri(), "0" * 64)
    place.begin()
    sent: list[str] = []
    write = RemoteFolder.write

    def cut_off(folder: RemoteFolder, name: str) -> Any:
        if len(sent) == 2:
            raise KeyboardInterrupt
        sent.append(name)
        return write(folder, name)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RemoteFolder, "write", cut_off)
        with pytest.raises(KeyboardInterrupt):
            place.finish({NAME: "{}", "croissant.json": "{}", "digits.csv": ""}, [])
    return (target_of(out) / NAME).exists()


def _make_both(place: LocalFolder) -> None:
    for folder in (place.gathered, place.staging):
        folder.mkdir(parents=True, exist_ok=True)


def _gather(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LocalFolder, "gathered", property(lambda place: place.target))
    patch.setattr(LocalFolder, "begin", _make_both)


def _recorded(place: LocalFolder, name: str) -> str | None:
    """Return the hash that stands in the receipt, as if the file had it."""
    for receipt in place.receipts():
        for file in json.loads((place.receipt(receipt) or "").partition("\n")[2])["files"]:
            if file["file"] == name:
                return str(file["sha256"])
    return None


PROTECTIONS: dict[str, tuple[Harm, Removal]] = {
    "files are written under another name": (
        _half_a_file_moves_along,
        lambda patch: patch.setattr(destination, "writing", _in_place),
    ),
    "files gather outside of the dataset": (
        _an_older_dataset_suffers,
        _gather,
    ),
    "the old dataset returns": (
        _the_old_is_lost_between_the_renames,
        lambda patch: patch.setattr(destination, "take_place", _remove_first),
    ),
    "finished files are hashed": (
        _a_changed_file_is_taken_for_finished,
        lambda patch: patch.setattr(LocalFolder, "digest", _recorded),
    ),
    "receipts are sealed": (
        _a_changed_receipt_is_believed,
        lambda patch: patch.setattr(shards, "_seal", lambda text: "0" * 64),
    ),
    "a dataset that is there is hashed": (
        _damage_stays,
        lambda patch: patch.setattr(LocalFolder, "intact", lambda place, manifest: True),
    ),
    "a run that was overtaken finds the dataset": (
        _a_run_that_is_overtaken_fails,
        lambda patch: patch.setattr(generate, "_LOSSES", 0),
    ),
    "what is half written is removed": (
        _half_written_files_stay,
        lambda patch: patch.setattr(LocalFolder, "leave", lambda place: None),
    ),
    "workers are replaced": (
        _a_death_ends_the_run,
        lambda patch: patch.setattr(workers, "_REVIVALS", 0),
    ),
    "workers are ended": (
        _workers_go_on_after_an_interrupt,
        lambda patch: patch.setattr(workers, "_stop", lambda executor: executor.shutdown(wait=False)),
    ),
    "the manifest comes last": (
        _an_object_store_shows_a_part,
        lambda patch: patch.setattr(destination, "sorted", lambda names, key: list(names), raising=False),
    ),
}


@pytest.mark.parametrize("protection", PROTECTIONS)
def test_without_its_protection_the_fault_does_harm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, protection: str
) -> None:
    harm, remove = PROTECTIONS[protection]
    assert not harm(tmp_path / "protected")
    remove(monkeypatch)
    assert harm(tmp_path / "unprotected")


ORPHANS = """
import sys
from pathlib import Path
from rehearsals import announce, make
from sinsdata.generation import workers

if sys.argv[2] == "unprotected":
    workers.follow_parent = print
make(Path(sys.argv[1]), 300, announce, workers=2)
"""


@pytest.mark.parametrize("protected", [True, False])
def test_workers_that_do_not_watch_their_parent_survive_it(start_python: Any, tmp_path: Path, protected: bool) -> None:
    process = start_python(ORPHANS, tmp_path, "protected" if protected else "unprotected")
    wait_for_rows(process, 1)
    children = offspring(process)
    os.kill(process.pid, signal.SIGKILL)
    process.wait(PATIENCE)
    left = survivors(children, 2 if protected else 0.3)
    for child in left:
        child.kill()
    assert bool(left) != protected
