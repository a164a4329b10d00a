"""What rehearsed faults share: a dataset of many small files, also for Python processes that tests start."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

import psutil

from sinsdata.cases import Case, DualPrecessionCase
from sinsdata.format.storage import WRITING, file_hash
from sinsdata.generation import tables
from sinsdata.generation.destination import LocalFolder
from sinsdata.generation.generate import Generated, generate
from sinsdata.generation.specification import Specification
from sinsdata.verification.verify import verify

DATASET, TIER = "dual_precession", "sweep"
#: Beside the cases.
TABLES = ("increments", "truth")
#: One page of the content hash: the shortest file that others may follow.
SHARD_ROWS = 1024
#: Seconds of motion that fill 9 files: one of the case, 4 of increments, 4 of truth.
DURATION, SHARDS = 40, 9
#: Seconds after which a process that should end is given up.
PATIENCE = 60


def cone(duration: float, name: str = "cone") -> DualPrecessionCase:
    """Return a case of 100 rows a second."""
    return DualPrecessionCase.from_mapping({
        "name": name, "spin_rate": 1, "precession_ratio": -1, "nutation": "pi/18", "spin_rate_dual": 0.5,
        "nutation_dual": 10, "initial_velocity": [10, 0, 0], "interval": "0.01", "duration": duration,
    })  # fmt: skip


@dataclass(frozen=True)
class DeadlyCase(DualPrecessionCase):
    """A case that ends the process that receives it."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what ends a process without a word, as the want of memory does."""
        return os._exit, (1,)


def small_shards() -> Any:
    """Return a context in which files are short."""
    short = tuple(replace(group, shard_rows=SHARD_ROWS) for group in tables.GROUPS[DATASET])
    return mock.patch.dict(tables.GROUPS, {DATASET: short})


def make(
    out: Path | str,
    duration: float = DURATION,
    progress: Callable[[int, int, str], None] = lambda done, total, what: None,
    cases: Sequence[Case] = (),
    **options: Any,
) -> Generated:
    """Generate a dataset of small files."""
    with small_shards():
        return generate(DATASET, TIER, cases or [cone(duration)], out, progress, **{"tables": TABLES, **options})


def place_of(out: Path, duration: float = DURATION) -> LocalFolder:
    """Return the place that `make` writes to, as another run sees it."""
    with small_shards():
        return LocalFolder(out / DATASET / TIER, Specification(DATASET, TIER, [cone(duration)], TABLES).key)


def target_of(out: Path) -> Path:
    """Return the folder that `make` writes."""
    return out / DATASET / TIER


def partial_of(out: Path) -> Path:
    """Return the folder of what runs have finished without finishing the dataset."""
    (found,) = target_of(out).parent.glob(f".partial-{TIER}-*")
    return found


def finished_shards(out: Path) -> int:
    """Return how many files of an unfinished dataset are finished; where none is, there is no folder of them."""
    return len(list(target_of(out).parent.glob(f".partial-{TIER}-*/[!.]*.receipt")))


def half_written(out: Path) -> list[Path]:
    """Return the files that somebody was writing."""
    return list(out.rglob(f"{WRITING}*"))


def beside(out: Path) -> list[str]:
    """Return the names of all that stands in the folder of the dataset's tiers."""
    return sorted(path.name for path in target_of(out).parent.iterdir())


def snapshot(folder: Path) -> dict[str, str]:
    """Return the hashes of all files of a folder."""
    return {path.name: file_hash(path) for path in sorted(folder.iterdir())}


def sound(folder: Path) -> bool:
    """Return whether a dataset verifies, by its bytes and without computing anything again."""
    with small_shards():
        return all(check.holds for check in verify(folder, 0))


def ended(process: subprocess.Popen[str]) -> str:
    """Return the output of a process that must end well."""
    output, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, errors
    return output


def offspring(process: subprocess.Popen[str]) -> list[psutil.Process]:
    """Return the processes that a process has started."""
    return psutil.Process(process.pid).children(recursive=True)


def survivors(processes: Iterable[psutil.Process], seconds: float) -> list[psutil.Process]:
    """Return which of some processes are still running when seconds have gone by."""
    _, alive = psutil.wait_procs(list(processes), timeout=seconds)
    # Nobody may be there to collect the exit status of an orphan.
    return [process for process in alive if process.status() != psutil.STATUS_ZOMBIE]


def announce(done: int, total: int, what: str) -> None:
    """Print what is done: a test that reads it knows how far a process is."""
    print(what, done, flush=True)


def wait_for_rows(process: subprocess.Popen[str], rows: int) -> None:
    """Wait until a process has announced so many rows."""
    assert process.stdout is not None
    for line in process.stdout:
        what, _, done = line.rpartition(" ")
        if what.strip() == "rows" and int(done) >= rows:
            return
    raise AssertionError(process.communicate()[1])


def die(*arguments: Any, **named: Any) -> None:
    """Kill this process, as ``kill -9`` does."""
    os.kill(os.getpid(), signal.SIGKILL)


def eventually(condition: Callable[[], bool], seconds: float = PATIENCE) -> None:
    """Wait for a condition."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def start(script: str, *arguments: object, before: Sequence[str] = (), **options: Any) -> subprocess.Popen[str]:
    """Start a Python of its own that can import this module."""
    command = [*before, sys.executable, "-W", "error", "-c", script, *map(str, arguments)]
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, **options
    )
