"""Speed of the compiled integrators, beside an interpreted one of the same method in the same run.

`extra_info["ns_per_sample"]` is from the minimum over the rounds.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sinsbench.subjects.integrators import INTEGRATORS, StreamingIntegrator, attitude_only
from sinsbench.subjects.rotation_vector_methods import METHODS, PANOV_6

SAMPLES = 40_000
ATTITUDE = np.array([1.0, 0.0, 0.0, 0.0])
VELOCITY = np.array([100.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def increments():
    """Random increments of the size met at 100 Hz: 3 rad/s and 100 m/s^2."""
    random = np.random.default_rng(1)
    return random.normal(scale=0.03, size=(SAMPLES, 3)), random.normal(size=(SAMPLES, 3))


def record(benchmark, samples):
    if benchmark.stats is not None:  # None when benchmarks are disabled and only run once
        benchmark.extra_info["ns_per_sample"] = benchmark.stats.stats.min / samples * 1e9


def run(benchmark, function, increments, rounds=30):
    arguments = (*increments, 0.01, ATTITUDE, VELOCITY)
    benchmark.pedantic(function, args=arguments, rounds=rounds, warmup_rounds=2)  # the first call compiles
    record(benchmark, len(increments[0]))


@pytest.mark.parametrize("name", INTEGRATORS)
@pytest.mark.benchmark(group="integrators: attitude and velocity")
def test_attitude_and_velocity(benchmark, increments, name):
    run(benchmark, INTEGRATORS[name], increments)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.benchmark(group="integrators: attitude alone")
def test_attitude_alone(benchmark, increments, name):
    run(benchmark, attitude_only(METHODS[name]), increments)


@pytest.mark.parametrize("compensated", [False, True], ids=["plain", "compensated"])
@pytest.mark.benchmark(group="integrators: streaming, called from Python")
def test_streaming(benchmark, increments, compensated):
    angle, velocity = (array[:4000] for array in increments)

    def stream():
        integrator = StreamingIntegrator(PANOV_6, ATTITUDE, VELOCITY, compensated=compensated)
        for k in range(0, len(angle), 4):
            integrator.update(angle[k : k + 4], velocity[k : k + 4])

    benchmark.pedantic(stream, rounds=10, warmup_rounds=1)
    record(benchmark, len(angle))


def interpreted_panov4(angle, velocity, interval, attitude0, velocity0):
    """Order 4, attitude alone, the way it is first written: numpy for vectors, scipy for rotations, a loop."""
    attitude = Rotation.from_quat(attitude0, scalar_first=True)
    result = [attitude]
    for k in range(0, len(angle), 4):
        p = angle[k : k + 4]
        attitude = attitude * Rotation.from_rotvec(p.sum(axis=0) + 2 / 3 * np.cross(p[0] + p[1], p[2] + p[3]))
        result.append(attitude)
    return {"attitude": Rotation.concatenate(result).as_quat(scalar_first=True)}


RATIO = ("compiled", "interpreted")


@pytest.mark.parametrize("kind", RATIO)
@pytest.mark.benchmark(group="integrators: panov4 attitude, compiled against numpy and scipy a step at a time")
def test_compiled_against_interpreted(benchmark, increments, kind):
    """Both in one group: the ratio of the two minima is what to compare between machines."""
    few = tuple(array[:4000] for array in increments)
    compiled = attitude_only(METHODS["panov4"])
    arguments = (*few, 0.01, ATTITUDE, VELOCITY)
    np.testing.assert_allclose(
        compiled(*arguments)["attitude"], interpreted_panov4(*arguments)["attitude"], rtol=0, atol=1e-12
    )  # 1000 steps of a few roundings each
    run(benchmark, compiled if kind == "compiled" else interpreted_panov4, few, rounds=10)
