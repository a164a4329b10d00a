"""Reading stored runs of pytest-benchmark."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["Run", "StoreError", "Timing", "is_run", "read_runs"]


class StoreError(ValueError):
    """A stored run cannot be read; the message says which, and why."""


@dataclass(frozen=True)
class Timing:
    """Times of one benchmark in one run.

    Attributes
    ----------
    group : str
        Group of pytest-benchmark; empty for none.
    minimum, median : float
        Over all rounds, s.
    rounds : int
    samples : tuple of float
        Order statistics of the rounds, s, as `sinsbench.dashboard.recording` keeps them; empty where there are none.
    calibration_ns, calibration_most_ns : float or None
        Times of the calibration workload before and after it, ns: the lesser and the greater.
    """

    group: str
    minimum: float
    median: float
    rounds: int
    samples: tuple[float, ...] = ()
    calibration_ns: float | None = None
    calibration_most_ns: float | None = None


@dataclass(frozen=True)
class Run:
    """One run of a benchmark suite.

    Attributes
    ----------
    file : str
        Name of the file it is stored in.
    time : str
        When it was made, ISO 8601.
    commit : str
        40 hexadecimal digits; empty where there was no repository.
    dirty : bool
        Whether the checkout differed from the commit.
    machine : str
        System, architecture, processor, number of cores, Python: times compare where all are equal.
    versions : mapping of str to str
        Distribution -> version.
    timings : mapping of str to Timing
        By the full name of the benchmark.
    """

    file: str
    time: str
    commit: str
    dirty: bool
    machine: str
    versions: Mapping[str, str]
    timings: Mapping[str, Timing]


def is_run(document: Any) -> bool:
    """Return whether a parsed JSON document is a stored run of pytest-benchmark."""
    return isinstance(document, dict) and {"benchmarks", "machine_info"} <= document.keys()


def read_runs(paths: Iterable[Path]) -> list[Run]:
    """Read stored runs, oldest first.

    Parameters
    ----------
    paths : iterable of Path
        Files; or folders, of which every run below them is read and other JSON is passed over.

    Raises
    ------
    StoreError
        If there is no such file or folder, a file is not JSON or not a run, or a folder holds none.
    """
    runs: dict[Path, Run] = {}
    for path in paths:
        if path.is_dir():
            inside = {file: _run(file, document) for file, document in _documents(path) if is_run(document)}
            if not inside:
                raise StoreError(f"{path}: holds no stored benchmark run (pytest --benchmark-json, or tox -e bench)")
            runs |= inside
        elif is_run(document := _parsed(path)):
            runs[path] = _run(path, document)
        else:
            raise StoreError(f"{path}: is not a stored run of pytest-benchmark: no benchmarks or no machine_info")
    return sorted(runs.values(), key=lambda run: run.time)


def _documents(folder: Path) -> Iterator[tuple[Path, Any]]:
    for file in sorted(folder.rglob("*.json")):
        yield file, _parsed(file)


def _parsed(file: Path) -> Any:
    try:
        return json.loads(file.read_bytes())
    except OSError as error:
        raise StoreError(f"{file}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{file}: not JSON: {error}") from None


def _run(file: Path, document: Mapping[str, Any]) -> Run:
    try:
        commit = document.get("commit_info") or {}
        known = str(commit.get("id") or "")
        return Run(
            file.name,
            str(document["datetime"]),
            known if set(known) <= set("0123456789abcdef") else "",
            bool(commit.get("dirty")),
            _machine(document["machine_info"]),
            dict(document["machine_info"].get("versions") or {}),
            {str(one["fullname"]): _timing(one) for one in document["benchmarks"]},
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise StoreError(f"{file}: is not a stored run of pytest-benchmark: {type(error).__name__}: {error}") from None


def _machine(info: Mapping[str, Any]) -> str:
    cpu = info.get("cpu") or {}
    cores = cpu.get("count")
    python = f"{info.get('python_implementation', '')} {'.'.join(str(info.get('python_version', '')).split('.')[:2])}"
    parts = (info.get("system"), info.get("machine"), cpu.get("brand_raw"), cores and f"{cores} cores", python.strip())
    return ", ".join(str(part) for part in parts if part)


def _timing(benchmark: Mapping[str, Any]) -> Timing:
    stats, extra = benchmark["stats"], benchmark.get("extra_info") or {}
    least = extra.get("calibration_ns")
    most = extra.get("calibration_most_ns", least)
    # A run of pytest-benchmark alone keeps all rounds, or none.
    samples = tuple(float(value) for value in stats.get("samples") or stats.get("data") or ())
    times = (float(stats["min"]), float(stats["median"]), *samples, *(float(x) for x in (least, most) if x is not None))
    if not all(math.isfinite(value) and value > 0 for value in times):
        raise ValueError(f"times of {benchmark['fullname']} must be positive")
    return Timing(
        str(benchmark.get("group") or ""),
        times[0],
        times[1],
        int(stats["rounds"]),
        samples,
        None if least is None else float(least),
        None if most is None else float(most),
    )
