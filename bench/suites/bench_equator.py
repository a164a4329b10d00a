"""Cost of the equator subjects: time per row of a two-hour run sampled every minute, and of one long table."""

import numpy as np
import pytest

from sinsbench.subjects.loading import resolve
from sinsbench.subjects.registry import EQUATOR_ERRORS, subjects_of

MOTION = (600.0, 10000.0)
INITIAL = (0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7)
MISALIGNMENT = 1e-5 * np.arange(9.0).reshape(3, 3)
SUBJECTS = tuple(subject.name for subject in subjects_of(EQUATOR_ERRORS))
CLOSED_FORMS = ("equator_corrected", "equator_general_solution", "equator_robust")


def measure(benchmark, subject, time, *misalignment):
    benchmark(subject, time, *MOTION, INITIAL, *misalignment)
    benchmark.extra_info["rows"] = time.size
    if benchmark.stats is not None:
        benchmark.extra_info["minimum_ns_per_row"] = benchmark.stats.stats.min / time.size * 1e9
        benchmark.extra_info["median_ns_per_row"] = benchmark.stats.stats.median / time.size * 1e9


@pytest.mark.benchmark(group="equator: 121 rows")
@pytest.mark.parametrize("name", SUBJECTS)
def test_two_hours(benchmark, name):
    measure(benchmark, resolve(name).function, np.linspace(0.0, 7200.0, 121))


@pytest.mark.benchmark(group="equator: 100,000 rows")
@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_long_table(benchmark, name):
    measure(benchmark, resolve(name).function, np.linspace(600.0, 7200.0, 100_000))


@pytest.mark.benchmark(group="equator: 121 rows under misalignment")
@pytest.mark.parametrize("name", ["equator_corrected", "equator_robust", "expm"])
def test_two_hours_under_misalignment(benchmark, name):
    measure(benchmark, resolve(name).function, np.linspace(0.0, 7200.0, 121), MISALIGNMENT)
