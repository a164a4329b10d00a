"""Speed of the gyroscopic systems: one hour of a manoeuvre at 100 Hz through each of them.

`extra_info["seconds_per_hour"]` is the minimum over the rounds; a system must stay under a second. What is to be
compared between machines is the ratio of two minima.
"""

import numpy as np
import pytest

from sinsbench.subjects.gyroscopic import subjects
from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS
from sinsbench.subjects.gyroscopic.contract import Inputs, Start
from sinsbench.subjects.gyroscopic.start_rules import products, rotated

HOUR, INTERVAL = 3600.0, 0.01
R, G = 6371000.0, 9.81
COMPILED = [name for name, row in SUBJECTS.items() if row.method != "dop853"]


def turn(axis, angle):
    """Quaternions (n, 4) of the rotation about an axis."""
    return np.column_stack([np.cos(angle / 2), np.outer(np.sin(angle / 2), np.eye(3)[axis])])


@pytest.fixture(scope="module")
def motion():
    """Points of a great circle along the equator of X at 300 m/s, rolling and pitching, as sensors and start."""
    time = INTERVAL * np.arange(round(HOUR / INTERVAL) + 1)
    zero, turned = np.zeros_like(time), 300 / R * time
    vertical = np.column_stack([np.sin(turned), zero, np.cos(turned)])
    roll = 0.1 * np.sin(2 * np.pi * time / 20)
    # X2 carries the vehicle round, its forward axis turns from there by the heading of 90 degrees.
    attitude = products(products(turn(1, turned), turn(2, zero - np.pi / 2)), turn(1, roll))
    roll_rate = 0.1 * 2 * np.pi / 20 * np.cos(2 * np.pi * time / 20)
    across = rotated(attitude * [1, -1, -1, -1], np.tile([0.0, 300 / R, 0.0], (len(time), 1)))
    rate = across + np.outer(roll_rate, [0.0, 1.0, 0.0])
    force = rotated(attitude * [1, -1, -1, -1], (G - 300**2 / R) * vertical)
    aids = {"radius": zero + R, "radius_rate": zero, "speed": zero + 300.0}
    start = Start(attitude[0], vertical[0], np.array([300.0, 0.0, 0.0]), R, G, 0.0)
    return time, rate, force, aids, start


def inputs_of(motion, kind):
    time, rate, force, aids, start = motion
    if kind == "increments":
        rate, force = ((x[1:] + x[:-1]) * (INTERVAL / 2) for x in (rate, force))
    return Inputs(time, rate, force, aids, kind), start


@pytest.mark.parametrize("name", COMPILED)
@pytest.mark.benchmark(group="gyroscopic systems: one hour at 100 Hz")
def test_one_hour(benchmark, motion, name):
    function, arguments = getattr(subjects, name), inputs_of(motion, SUBJECTS[name].takes)
    result = benchmark.pedantic(function, args=arguments, rounds=5, warmup_rounds=1)  # the first call compiles
    assert len(result["vertical"]) == (len(arguments[0].time) - 1) // SUBJECTS[name].samples_per_step + 1
    if benchmark.stats is not None:  # None when benchmarks are disabled and only run once
        benchmark.extra_info["seconds_per_hour"] = benchmark.stats.stats.min
        benchmark.extra_info["ns_per_step"] = benchmark.stats.stats.min / (len(result["vertical"]) - 1) * 1e9
    if name == "ghc":
        turned = 300 / R * arguments[0].time[::2]
        expected = np.column_stack([np.sin(turned), 0 * turned, np.cos(turned)])
        # The motion is what it says: the vertical is the true one, but for the rounding of 180,000 steps.
        assert np.abs(result["vertical"] - expected).max() < 180_000 * 2.3e-16
