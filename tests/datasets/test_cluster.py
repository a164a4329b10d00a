"""A Dask cluster of a scheduler and two workers, each a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from rehearsals import PATIENCE, beside, eventually, make, snapshot, sound
from sinsbench.cli import run
from sinsdata.generation.workers import WorkerError, check_workers


@dataclass(frozen=True)
class Cluster:
    """A scheduler, its address, and its workers, which have working directories of their own."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


def _dask(*arguments: object) -> subprocess.Popen[bytes]:
    support = str(Path(__file__).parents[1] / "support")
    environment = {**os.environ, "PYTHONPATH": support, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "distributed.cli." + str(arguments[0]), *map(str, arguments[1:]), "--no-dashboard"]
    return subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment, cwd=Path.home().anchor
    )


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    about = tmp_path / "scheduler.json"
    processes = [_dask("dask_scheduler", "--host", "127.0.0.1", "--port", 0, "--scheduler-file", about)]
    try:
        eventually(about.exists)
        address = json.loads(about.read_text(encoding="utf-8"))["address"]
        for number in range(2):
            folder = tmp_path / f"worker-{number}"
            worker = _dask(
                "dask_worker",
                address,
                "--nthreads",
                1,
                "--no-nanny",
                "--local-directory",
                folder,
                "--host",
                "127.0.0.1",
            )
            processes.append(worker)
        yield Cluster(address, processes[0], processes[1:])
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait(PATIENCE)


def test_a_worker_is_killed_midway_and_then_the_scheduler(
    cluster: Cluster, undisturbed: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The folder is given relative to a directory that the workers are not in."""
    monkeypatch.chdir(tmp_path)

    def kill_worker(done: int, total: int, what: str) -> None:
        if done > 1:
            cluster.workers[0].kill()

    made = make(Path("here"), progress=kill_worker, scheduler=cluster.address)
    assert cluster.workers[0].wait(PATIENCE) < 0
    assert made.manifest == undisturbed.manifest
    assert snapshot(made.folder) == snapshot(undisturbed.folder)
    assert sound(made.folder)
    assert beside(Path("here")) == ["sweep"]

    def kill_scheduler(done: int, total: int, what: str) -> None:
        if done > 1:
            cluster.scheduler.kill()

    with pytest.raises(WorkerError, match="the scheduler is gone; what is finished is kept"):
        make(Path("there"), progress=kill_scheduler, scheduler=cluster.address)
    rest = make(Path("there"))
    assert rest.reused > 0
    assert rest.manifest == undisturbed.manifest


def test_a_scheduler_without_workers_is_given_up(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for worker in cluster.workers:
        worker.kill()
        worker.wait(PATIENCE)
    monkeypatch.setattr("sinsdata.generation.workers._FIRST_WORKER", 5)
    with pytest.raises(WorkerError, match="the scheduler has had no worker for 5 s"):
        make(tmp_path, scheduler=cluster.address)


def test_the_command_line_without_a_scheduler(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status = run([
        "generate", "dual_precession", "--tier", "short", "--out", str(tmp_path), "--scheduler", "tcp://127.0.0.1:9",
    ])  # fmt: skip
    captured = capsys.readouterr()
    assert (status, captured.out) == (2, "")
    assert captured.err.startswith("sinsbench: tcp://127.0.0.1:9: no Dask scheduler answers")


@pytest.mark.parametrize(
    "address", ["foo", "tcp://", "foo://h:1", "tcp://h", "tcp://h:x", "tcp://h:99999", "tcp://:1", "127.0.0.1:8786", ""]
)
def test_what_is_no_address_is_refused_before_anything_is_done(address: str, tmp_path: Path) -> None:
    with pytest.raises(WorkerError, match="must be scheme://host:port"):
        make(tmp_path / "out", scheduler=address)
    assert not (tmp_path / "out").exists()


def test_processes_and_a_scheduler_exclude_one_another() -> None:
    check_workers(1, "tcp://127.0.0.1:8786")
    with pytest.raises(WorkerError, match="--workers and --scheduler exclude one another"):
        check_workers(2, "tcp://127.0.0.1:8786")
