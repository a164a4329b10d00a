"""Speed of the compiled integrators, beside interpreted ones and published packages in the same run.

`extra_info["ns_per_sample"]` is from the minimum over the rounds. What is to be compared between machines is the ratio
of two minima of one group: each group "... against ..." holds one method twice.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sinsbench.subjects.integrators import INTEGRATORS, StreamingIntegrator, attitude_only
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.rotation_vector_methods import METHODS, PANOV_6

ALL_METHODS = PUBLISHED_METHODS | METHODS
SAMPLES = 42_000  # a multiple of every number of samples a step
INTERVAL = 0.01
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
    arguments = (*increments, INTERVAL, ATTITUDE, VELOCITY)
    benchmark.pedantic(function, args=arguments, rounds=rounds, warmup_rounds=2)  # the first call compiles
    record(benchmark, len(increments[0]))


@pytest.mark.parametrize("name", INTEGRATORS)
@pytest.mark.benchmark(group="integrators: attitude and velocity")
def test_attitude_and_velocity(benchmark, increments, name):
    run(benchmark, INTEGRATORS[name], increments)


@pytest.mark.parametrize("name", ALL_METHODS)
@pytest.mark.benchmark(group="integrators: attitude alone")
def test_attitude_alone(benchmark, increments, name):
    run(benchmark, attitude_only(ALL_METHODS[name]), increments)


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


@pytest.mark.parametrize("kind", ["compiled", "interpreted"])
@pytest.mark.benchmark(group="integrators: panov4 attitude, compiled against numpy and scipy a step at a time")
def test_compiled_against_interpreted(benchmark, increments, kind):
    few = tuple(array[:4000] for array in increments)
    compiled = attitude_only(METHODS["panov4"])
    arguments = (*few, INTERVAL, ATTITUDE, VELOCITY)
    np.testing.assert_allclose(
        compiled(*arguments)["attitude"], interpreted_panov4(*arguments)["attitude"], rtol=0, atol=1e-12
    )  # 1000 steps of a few roundings each
    run(benchmark, compiled if kind == "compiled" else interpreted_panov4, few, rounds=10)


def python_ins(angle, velocity):
    """Return a call of python-ins that makes rotation vectors and velocity increments, 1/12 of the sample before."""
    strapdown = pytest.importorskip("pyins.strapdown")
    pandas, util = pytest.importorskip("pandas"), pytest.importorskip("pyins.util")
    columns = util.GYRO_COLS + util.ACCEL_COLS
    readings = pandas.DataFrame(np.hstack([angle, velocity]), INTERVAL * np.arange(len(angle)), columns)
    return lambda *_: strapdown.compute_increments_from_imu(readings, "increment")


@pytest.mark.parametrize("kind", ["python-ins", "recursive", "panov6"])
@pytest.mark.benchmark(group="integrators: attitude and velocity against python-ins, its increments alone")
def test_against_python_ins(benchmark, increments, kind):
    peer = python_ins(*increments)  # skips the other kinds too: nothing to compare with
    steps = Rotation.from_quat(
        INTEGRATORS["recursive"](*increments, INTERVAL, ATTITUDE, VELOCITY)["attitude"][1:, [1, 2, 3, 0]]
    )
    theta = peer()[["theta_x", "theta_y", "theta_z"]].to_numpy()
    # The same formula, and quaternions composed of 42,000 factors compared as quotients of neighbours.
    np.testing.assert_allclose((steps[:-1].inv() * steps[1:]).as_rotvec(), theta, rtol=0, atol=1e-14)
    run(benchmark, peer if kind == "python-ins" else INTEGRATORS[kind], increments, rounds=10)


def jaxlie_exponentials():
    """Return the composition of exponentials in jaxlie, a compiled scan."""
    jax, jaxlie = pytest.importorskip("jax"), pytest.importorskip("jaxlie")
    jax.config.update("jax_enable_x64", True)

    def step(attitude, increment):
        after = attitude @ jaxlie.SO3.exp(increment)
        return after, after.wxyz

    scan = jax.jit(lambda angle, attitude0: jax.lax.scan(step, jaxlie.SO3(attitude0), angle)[1])
    return lambda angle, velocity, interval, attitude0, velocity0: np.asarray(scan(angle, attitude0))


@pytest.mark.parametrize("kind", ["jaxlie", "one_sample", "panov6"])
@pytest.mark.benchmark(group="integrators: attitude alone against jaxlie, its exponentials")
def test_against_jaxlie(benchmark, increments, kind):
    peer, plain = jaxlie_exponentials(), attitude_only(ALL_METHODS["one_sample"])
    inputs = (*increments, INTERVAL, ATTITUDE, VELOCITY)
    # Rounding errors of 42,000 products, a unit roundoff each.
    np.testing.assert_allclose(plain(*inputs)["attitude"][1:], peer(*inputs), rtol=0, atol=SAMPLES * 2.3e-16)
    run(benchmark, peer if kind == "jaxlie" else attitude_only(ALL_METHODS[kind]), increments, rounds=10)
