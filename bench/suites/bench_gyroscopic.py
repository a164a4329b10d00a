"""Gyroscopic systems: time a step of every subject, and what the proved sensors and truth of their motions cost.

`extra_info["ns_per_step"]` is from the minimum over the rounds.
"""

from typing import Any

import pytest

from sinsbench.scoring.gyroscopic_errors import inputs_of, start_of
from sinsbench.subjects.gyroscopic import subjects
from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.gyroscopic import GyroMotion, sampled

CASE = GyroCase(
    name="parallel", motion="parallel", latitude="0.9", longitude="0.5", speed="250", duration="1200", interval="1"
)


@pytest.fixture(scope="module")
def motion() -> GyroMotion:
    return sampled(CASE)


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.benchmark(group="gyroscopic systems")
def test_system(benchmark: Any, motion: GyroMotion, name: str) -> None:
    row = SUBJECTS[name]
    inputs = inputs_of(motion, increments=row.takes == "increments")
    start = start_of(motion, float(CASE.radius), float(CASE.gravity))
    # Drivers that SciPy steps take a second a run; the others compile in the first.
    rounds = 3 if row.method == "dop853" else 30
    benchmark.pedantic(getattr(subjects, name), args=(inputs, start), rounds=rounds, warmup_rounds=1)
    benchmark.extra_info["ns_per_step"] = benchmark.stats.stats.min / (CASE.samples / row.samples_per_step) * 1e9


@pytest.mark.benchmark(group="gyroscopic systems: truth")
def test_truth(benchmark: Any) -> None:
    benchmark.pedantic(sampled, args=(CASE,), rounds=10, warmup_rounds=1)
    benchmark.extra_info["rows_per_second"] = round((CASE.samples + 1) / benchmark.stats.stats.min)
