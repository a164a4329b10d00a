"""What the pytest plugin costs a test run that does not use it: less than 50 ms of processor time."""

import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

LIMIT = 0.05
#: Other plugins take longer than everything measured here.
BARE = ("-p", "no:hypothesispytest", "-p", "no:xdist", "-p", "no:cacheprovider", "-p", "no:benchmark")


def bench_foreign_run(benchmark: Any, tmp_path: Path) -> None:
    (tmp_path / "test_nothing.py").write_text("def test_nothing():\n    pass\n")
    without: list[float] = []
    with_plugin: list[float] = []

    def seconds(*options: str) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, "-m", "pytest", "-q", *BARE, *options]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    # One after the other, so that a busy machine slows both.
    def pair() -> None:
        without.append(seconds("-p", "no:sinsbench"))
        with_plugin.append(seconds())

    benchmark.pedantic(pair, rounds=10, warmup_rounds=1)
    cost = min(with_plugin) - min(without)
    benchmark.extra_info["plugin_ms"] = 1e3 * cost
    assert cost < LIMIT
