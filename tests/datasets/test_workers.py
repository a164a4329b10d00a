"""Who computes does not matter: one process, several, or independent jobs give the same bytes."""

from __future__ import annotations

import multiprocessing
import shutil
import sys
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from rehearsals import (
    PATIENCE,
    SHARDS,
    beside,
    ended,
    half_written,
    make,
    offspring,
    place_of,
    snapshot,
    sound,
    survivors,
    target_of,
    wait_for_rows,
)  # fmt: skip
from sinsdata.generation import workers
from sinsdata.generation.workers import WorkerError

JOB = """
import sys
from pathlib import Path
from rehearsals import announce, make

made = make(Path(sys.argv[1]), 40, announce, part=(int(sys.argv[2]), int(sys.argv[3])))
print("missing", made.missing)
"""


def test_two_workers(undisturbed: Any, tmp_path: Path) -> None:
    seen: list[tuple[int, int, str]] = []
    made = make(tmp_path, progress=lambda *report: seen.append(report), workers=2)
    assert made.manifest == undisturbed.manifest
    assert snapshot(made.folder) == snapshot(undisturbed.folder)
    assert [done for done, _, _ in seen] == sorted(done for done, _, _ in seen)
    assert seen[-1] == (8002, 8002, "done")
    assert multiprocessing.active_children() == []


def test_an_error_in_a_worker_reaches_the_caller(tmp_path: Path) -> None:
    """A folder stands where a receipt belongs; what other workers have finished is kept."""
    place = place_of(tmp_path)
    (place.staging / "truth-00001-of-00004.parquet.receipt" / "in the way").mkdir(parents=True)
    with pytest.raises(IsADirectoryError):
        make(tmp_path, workers=2)
    assert multiprocessing.active_children() == []
    assert half_written(tmp_path) == []
    assert make(tmp_path / "elsewhere").reused == 0
    shutil.rmtree(place.staging / "truth-00001-of-00004.parquet.receipt")
    assert make(tmp_path).reused > 0


class _Broken:
    """A pool whose workers die between the last result and the next task, once."""

    deaths = 0

    def __init__(self, count: int) -> None:
        self.submitted = 0

    def submit(self, function: Any, *arguments: Any) -> Future[Any]:
        self.submitted += 1
        if self.submitted == 6 and not _Broken.deaths:
            _Broken.deaths += 1
            raise workers.BrokenProcessPool
        future: Future[Any] = Future()
        future.set_result(function(*arguments))
        return future


def test_a_task_that_the_dying_pool_did_not_take_is_not_lost(
    undisturbed: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "_executor", _Broken)
    monkeypatch.setattr(workers, "_stop", lambda pool: None)
    made = make(tmp_path, workers=2)
    assert _Broken.deaths == 1
    assert made.manifest == undisturbed.manifest


@pytest.mark.parametrize("order", [(1, 2, 3), (3, 1, 2)])
def test_jobs_in_any_order(undisturbed: Any, tmp_path: Path, order: tuple[int, ...]) -> None:
    missing = []
    for number in order[:-1]:
        made = make(tmp_path, part=(number, 3))
        assert made.manifest == {}
        assert not target_of(tmp_path).exists()
        missing.append(made.missing)
    assert missing == [6, 3]
    made = make(tmp_path, part=(order[-1], 3))
    assert (made.manifest, made.missing, made.reused) == (undisturbed.manifest, 0, 6)
    assert snapshot(made.folder) == snapshot(undisturbed.folder)
    assert make(tmp_path, part=(2, 3)).reused == SHARDS
    assert beside(tmp_path) == ["sweep"]


def test_more_jobs_than_files(tmp_path: Path, undisturbed: Any) -> None:
    made = [make(tmp_path, part=(number, 11)) for number in range(11, 0, -1)]
    assert [one.missing for one in made] == [9, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0]
    assert made[-1].manifest == undisturbed.manifest


def test_jobs_at_the_same_time_one_of_them_killed_and_repeated(
    start_python: Any, undisturbed: Any, tmp_path: Path
) -> None:
    jobs = [start_python(JOB, tmp_path, number, 3) for number in (1, 2, 3)]
    wait_for_rows(jobs[1], 1)
    jobs[1].kill()
    jobs[1].communicate(timeout=PATIENCE)
    for job in (jobs[0], jobs[2]):
        assert int(ended(job).split()[-1]) > 0
    assert not target_of(tmp_path).exists()
    repeated = start_python(JOB, tmp_path, 2, 3)
    assert ended(repeated).split()[-2:] == ["missing", "0"]
    assert snapshot(target_of(tmp_path)) == snapshot(undisturbed.folder)
    assert sound(target_of(tmp_path))
    assert beside(tmp_path) == ["sweep"]


def test_a_job_whose_files_were_damaged_meanwhile(undisturbed: Any, tmp_path: Path) -> None:
    make(tmp_path, part=(1, 2))
    (found,) = target_of(tmp_path).parent.glob(".partial-*/files/cases.parquet")
    found.write_bytes(b"PAR1")
    made = make(tmp_path, part=(2, 2))
    assert (made.manifest, made.reused) == (undisturbed.manifest, 4)


def test_no_scheduler_at_the_address(tmp_path: Path) -> None:
    with pytest.raises(WorkerError, match=r"tcp://127\.0\.0\.1:9: no Dask scheduler answers"):
        make(tmp_path, 1, scheduler="tcp://127.0.0.1:9")
    assert beside(tmp_path) == []


def test_a_cluster_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(WorkerError, match="a cluster needs the extra `cluster`: pip install"):
        make(tmp_path, 1, scheduler="tcp://127.0.0.1:9")


PARTS = """
import os, time
from sinsbench.reproduction import parallel

os.sched_getaffinity = lambda pid: {0, 1}  # on machines of one core too
parts = [parallel.Part("short", time.sleep, (0,)), *[parallel.Part("long", time.sleep, (600,))] * 2]
parallel.run_parts(parts, lambda done, total, what: print("rows", done, flush=True))
"""


def test_workers_of_a_reproduction_end_with_it(start_python: Any) -> None:
    process = start_python(PARTS)
    wait_for_rows(process, 1)
    children = offspring(process)
    assert len(children) > 0
    process.kill()
    process.wait(PATIENCE)
    assert survivors(children, 20) == []
