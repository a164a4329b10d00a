"""What a benchmark suite stores of a run: hooks of pytest-benchmark and a fixture, for the suite's ``conftest.py``.

`calibration_ns` stands beside every timing, the versions of what ran stand in `machine_info`, and of all rounds no more
than `SAMPLES` order statistics are kept.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import PackageNotFoundError, requires, version
from typing import Any

import pytest

__all__ = [
    "SAMPLES", "array_unit", "calibration", "order_statistics", "pytest_benchmark_update_json",
    "pytest_benchmark_update_machine_info", "timed_beside",
]  # fmt: skip

SAMPLES = 30
"""Order statistics that are kept of a benchmark at most: enough for the test of Mann and Whitney."""

#: Numbers in an array, operations in a run, and runs of the calibration workload: a third of a millisecond each.
_LENGTH, _OPERATIONS, _RUNS = 50, 300, 5


@pytest.fixture(scope="session")
def calibration() -> Callable[[], float]:
    """Return what times the calibration workload, ns: a suite may put another in its place."""
    return array_unit


def array_unit() -> float:
    """Return the time of a product and a sum of short arrays, called from Python, ns, at this moment on this machine.

    A processor that another thread shares takes twice as long for this, as it does for most of what is timed here. A
    chain of compiled products that wait for one another (`sinsbench.scoring.calibration`) hardly feels it.
    """
    import numpy as np

    values = np.ones(_LENGTH)
    times = []
    for _ in range(_RUNS):
        start = time.perf_counter()
        for _ in range(_OPERATIONS):
            values * values + values
        times.append(time.perf_counter() - start)
    return min(times) / _OPERATIONS * 1e9


@pytest.fixture(autouse=True)
def timed_beside(request: pytest.FixtureRequest, calibration: Callable[[], float]) -> Iterator[None]:
    """Time the calibration workload before and after a benchmark, and store both times: the lesser first."""
    before = calibration()
    yield
    # The fixture itself is not asked for: that would make a benchmark of every test. After an interrupt None is there.
    if benchmark := (getattr(request.node, "funcargs", None) or {}).get("benchmark"):
        least, most = sorted((before, calibration()))
        benchmark.extra_info |= {"calibration_ns": least, "calibration_most_ns": most}


def order_statistics(times: Sequence[float], count: int = SAMPLES) -> list[float]:
    """Return order statistics of times: all of them, sorted, or those nearest to the levels (i + 1/2) / `count`.

    Unlike the least times of batches they do not depend on how many rounds there were, and so compare between runs.

    Parameters
    ----------
    times : sequence of float
    count : int
        How many to return at most.
    """
    ranked = sorted(times)
    if len(ranked) <= count:
        return ranked
    return [ranked[int((i + 0.5) / count * len(ranked))] for i in range(count)]


def pytest_benchmark_update_machine_info(machine_info: dict[str, Any]) -> None:
    """Store the versions of sinsbench and of what it needs, and not the name of the machine."""
    machine_info.pop("node", None)
    names = {"sinsbench": None} | dict.fromkeys(
        re.split(r"[^\w.-]", text)[0] for text in _requirements() if "extra ==" not in text
    )
    machine_info["versions"] = {name: found for name in names if (found := _version(name))}


def pytest_benchmark_update_json(output_json: dict[str, Any]) -> None:
    """Keep order statistics of the rounds in place of the rounds."""
    for benchmark in output_json["benchmarks"]:
        stats = benchmark["stats"]
        if (data := stats.pop("data", None)) is not None:
            stats["samples"] = order_statistics(data)


def _requirements() -> list[str]:
    try:
        return requires("sinsbench") or []
    except PackageNotFoundError:
        return []


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
