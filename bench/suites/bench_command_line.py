"""What a user waits for: the answer of ``--help``, and the main job with its memory.

Limits: ``sinsbench --help`` in 0.3 s; ``sinsbench reproduce`` in 60 s on two cores and 1 GiB with all its processes.
"""

import os
import resource
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

COMMAND = (sys.executable, "-c", "from sinsbench.cli import main; main()")


def bench_help(benchmark: BenchmarkFixture) -> None:
    bare = []

    def once() -> None:
        subprocess.run([*COMMAND, "--help"], check=True, capture_output=True)

    def setup() -> None:
        # The interpreter alone, in the same run: what is left is ours.
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", "pass"], check=True)
        bare.append(time.perf_counter() - start)

    benchmark.pedantic(once, setup=setup, rounds=10, warmup_rounds=1)
    benchmark.extra_info["ratio_to_bare_interpreter"] = benchmark.stats.stats.min / min(bare)
    assert benchmark.stats.stats.median < 0.3


def bench_reproduce(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    memory = []

    def once() -> None:
        with subprocess.Popen([*COMMAND, "reproduce", "--out", str(tmp_path)], stdout=subprocess.DEVNULL) as process:
            peak = [0]
            watcher = threading.Thread(target=_watch, args=(process, peak))
            watcher.start()
            process.wait()
            watcher.join()
            memory.append(peak[0])
            assert process.returncode == 0

    benchmark.pedantic(once, rounds=1, warmup_rounds=1)
    benchmark.extra_info["peak_memory_MiB"] = max(memory) / 2**20
    benchmark.extra_info["largest_process_MiB"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    benchmark.extra_info["cores"] = os.cpu_count()
    assert max(memory) < 2**30
    if (os.cpu_count() or 1) >= 2:
        assert benchmark.stats.stats.min < 60


def _watch(process: subprocess.Popen[bytes], peak: list[int]) -> None:
    """Keep the largest sum of the resident memory of a process and its descendants."""
    if not Path("/proc").is_dir():
        pytest.fail("the memory of all processes is read from /proc")
    while process.poll() is None:
        peak[0] = max(peak[0], sum(map(_resident, _family(process.pid))))
        time.sleep(0.1)


def _family(pid: int) -> list[int]:
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    return [pid, *(member for child in children for member in _family(int(child)))]


def _resident(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * resource.getpagesize()
    except (OSError, IndexError):
        return 0
