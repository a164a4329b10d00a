"""Gyroscopic systems run on the motions of `gyroscopic_motions`, each but once."""

from functools import cache

import numpy as np

from gyroscopic_motions import G, R, grid, motion
from sinsbench.subjects.gyroscopic.contract import Inputs, Start
from sinsbench.subjects.gyroscopic.drivers import subject
from sinsbench.subjects.gyroscopic.systems import SYSTEMS

STEP = 0.5


def inputs_of(m):
    return Inputs(
        m.time, m.rate, m.specific_force, {"radius": m.radius, "radius_rate": m.radius_rate, "speed": m.speed}
    )


def start_of(m):
    speed = m.speed[0]
    turn_rate = m.axes[0, 1] @ m.force_inertial[0] / speed if speed else None
    return Start(m.attitude[0], m.vertical[0], m.velocity[0], R, G, turn_rate)


@cache
def case(name, duration=7200.0, step=STEP, **options):
    m = motion(name, grid(duration, step), **options)
    return m, inputs_of(m), start_of(m)


@cache
def result(name, system, method="rk4", duration=7200.0, step=STEP):
    return subject(SYSTEMS[system], method)(*case(name, duration, step)[1:])


def angles(first, second):
    """Angles between unit vectors, rad."""
    return 2 * np.arctan2(np.linalg.norm(first - second, axis=1), np.linalg.norm(first + second, axis=1))
