"""The antenna on a mast: time a step of every estimator, and what the truth and the readings of a motion cost.

`extra_info["us_per_step"]` is from the minimum over the rounds. The relinearised filter spends its extra time in the
first 32 s: what a short run shows is more than a long one pays.
"""

from typing import Any

import numpy as np
import pytest

from sinsbench.subjects.mast import subjects
from sinsbench.subjects.mast.catalogue import SUBJECTS
from sinsbench.subjects.mast.contract import BreakdownError, MastConstants, MastInputs, MastNoise, MastStart, Result
from sinsdata.cases import MastCase
from sinsdata.truth.mast import sampled

STEPS, STEP, RADIUS = 500, 0.01, 6371000.0
CASE = MastCase("minute", "60", "0.01")


@pytest.fixture(scope="module")
def problem() -> tuple[MastInputs, MastStart]:
    """Vehicle and mast at rest on the equator, the mast upright, four satellites that stand still."""
    time = STEP * np.arange(STEPS + 1)
    zero, up = np.zeros((STEPS, 3, 3)), np.zeros((STEPS, 3, 3))
    earth = MastConstants()
    up[..., 2] = earth.gravitation - earth.earth_rate**2 * RADIUS
    turning = zero.copy()
    turning[..., 1] = earth.earth_rate
    sky = np.array([[0, 0, 1], [0.6, 0, 0.8], [0, 0.6, 0.8], [-0.6, -0.3, 0.74]]) * 2.6e7
    distance = np.linalg.norm(sky - [0, 0, RADIUS], axis=1)
    inputs = MastInputs(
        time,
        turning,
        up,
        turning,
        up,
        np.tile(sky, (2 * STEPS + 1, 1, 1)),
        np.zeros((2 * STEPS + 1, 4, 3)),
        np.zeros((STEPS, 3, 4)),
        np.tile(distance, (STEPS, 3, 1)),
        MastNoise(5e-8, 1e-4, 5e-8, 1e-4, 1e-2, 0.1, 5.0),
        earth,
    )
    one = np.array([1.0, 0, 0, 0])
    deviations = np.array([*[6e-3] * 3, *[5e-7] * 2, *[0.05] * 3, 3.0, *[6e-3] * 5, 0.0, *[5e-3] * 2])
    rate = np.array([0.0, earth.earth_rate])
    return inputs, MastStart(one, 0.0, 0.0, np.zeros(3), 0.0, one, one, rate, deviations)


def estimate(name: str, inputs: MastInputs, start: MastStart) -> Result:
    """Run an estimator as far as it comes: with the equations as printed, for a second."""
    try:
        result: Result = getattr(subjects, name)(inputs, start)
    except BreakdownError as error:
        return error.partial
    return result


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.benchmark(group="mast antenna: estimators")
def test_estimator(benchmark: Any, problem: tuple[MastInputs, MastStart], name: str) -> None:
    # The first call compiles.
    result = benchmark.pedantic(estimate, args=(name, *problem), rounds=10, warmup_rounds=1)
    steps = round(result["time"][-1] / STEP)
    assert steps >= 1 / STEP
    if benchmark.stats is not None:  # None when benchmarks are disabled and only run once
        benchmark.extra_info["us_per_step"] = benchmark.stats.stats.min / steps * 1e6


@pytest.mark.benchmark(group="mast antenna: truth")
def test_truth(benchmark: Any) -> None:
    motion = benchmark.pedantic(lambda: sampled(CASE).readings(), rounds=5, warmup_rounds=1)
    assert len(motion.rate1) == CASE.samples
    if benchmark.stats is not None:
        benchmark.extra_info["us_per_step"] = benchmark.stats.stats.min / CASE.samples * 1e6
