"""Speed of the methods that fit polynomials to increments, one group a family; Panov's order 6 stands in each.

`extra_info["ns_per_sample"]` is from the minimum over the rounds. The increments are those of a smooth motion: how many
terms a series or an iteration needs depends on them.
"""

import numpy as np
import pytest

from sinsbench.subjects.fitted_integrators import FITTED_INTEGRATORS, FittedStreamingIntegrator
from sinsbench.subjects.fitted_methods import FITTED_METHODS
from sinsbench.subjects.integrators import panov6

SAMPLES = 5040  # a multiple of 2 ... 10; short, so that a busy machine leaves some rounds undisturbed
ATTITUDE = np.array([1.0, 0.0, 0.0, 0.0])
VELOCITY = np.array([100.0, 0.0, 0.0])
FAMILIES = {
    family: [name for name in FITTED_METHODS if name.startswith(family)] for family in ("taylor", "quatfiter", "magnus")
}


@pytest.fixture(scope="module")
def increments():
    """Coning of 10 degrees at 1 Hz, sampled at 100 Hz, under a force that turns with it."""
    phase = 2 * np.pi * 0.01 * (np.arange(SAMPLES) + 0.5)
    turning = np.column_stack([np.sin(phase), np.cos(phase), np.zeros(SAMPLES)])
    return 0.0109 * turning + [0, 0, 0.00095], 0.1 * turning + [0, 0, 0.01]


def record(benchmark, samples):
    if benchmark.stats is not None:  # None when benchmarks are disabled and only run once
        benchmark.extra_info["ns_per_sample"] = benchmark.stats.stats.min / samples * 1e9


def run(benchmark, function, increments):
    arguments = (*increments, 0.01, ATTITUDE, VELOCITY)
    benchmark.pedantic(function, args=arguments, rounds=100, warmup_rounds=2)  # the first call compiles
    record(benchmark, SAMPLES)


@pytest.mark.parametrize("name", ["panov6", *FAMILIES["taylor"]])
@pytest.mark.benchmark(group="polynomial fit: power series")
def test_power_series(benchmark, increments, name):
    run(benchmark, FITTED_INTEGRATORS.get(name, panov6), increments)


@pytest.mark.parametrize("name", ["panov6", *FAMILIES["quatfiter"]])
@pytest.mark.benchmark(group="polynomial fit: functional iteration")
def test_functional_iteration(benchmark, increments, name):
    run(benchmark, FITTED_INTEGRATORS.get(name, panov6), increments)


@pytest.mark.parametrize("name", ["panov6", *FAMILIES["magnus"]])
@pytest.mark.benchmark(group="polynomial fit: Magnus expansion")
def test_magnus_expansion(benchmark, increments, name):
    run(benchmark, FITTED_INTEGRATORS.get(name, panov6), increments)


@pytest.mark.parametrize("name", ["taylor8", "quatfiter8", "magnus6"])
@pytest.mark.benchmark(group="polynomial fit: streaming, called from Python")
def test_streaming(benchmark, increments, name):
    method = FITTED_METHODS[name]
    angle, velocity = increments

    def stream():
        integrator = FittedStreamingIntegrator(method, ATTITUDE, VELOCITY)
        for k in range(0, SAMPLES, method.samples_per_step):
            rows = slice(k, k + method.samples_per_step)
            integrator.update(angle[rows], velocity[rows])

    benchmark.pedantic(stream, rounds=10, warmup_rounds=1)
    record(benchmark, SAMPLES)
