"""The exact systems integrated at fifty digits and more: they are where the truth is to what the integration leaves.

The equations are integrated together by Taylor series, from the specific force in X of the manoeuvre; their start is
that of the paper's systems, corrected. Beside them runs the gyropendulum of the usual tuning, which is not exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import pytest

from sinsref.arithmetic import BallArithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.gyroscopic import Kinematics, Motion
from sinsref.gyroscopic_systems import (
    axis_rate,
    bisector,
    compass_rates,
    exact_tilt,
    frame_rates,
    full_acceleration,
    self_tuned_rates,
    tilted,
    two_component_rates,
    usual_tuning,
)
from sinsref.profiles import Profile
from sinsref.quaternion import Vector, cross, dot, product, rotate
from sinsref.series import Series, SeriesArithmetic
from sinsref.taylor import integrate

ZERO, UNITS = Profile("0"), ((1, 0, 0), (0, 1, 0), (0, 0, 1))
MANOEUVRE = Motion(
    "track", Profile("5*pi/18 + pi/120*sin(2*pi*t/3000)"), Profile("pi/6 + pi/90000*t + pi/180*sin(2*pi*t/4500)"),
    ZERO, ExactNumber("0"), ZERO, ZERO, ZERO, ZERO,
    ExactNumber("6371000"), ExactNumber("9.81"), ExactNumber("7.292115e-5"),
)  # fmt: skip
#: 2B/(m l) of the two-rotor frame, m/s.
LIMIT = 2000
BITS, TIME, STEPS, ORDER = 190, 120, 2, 40
#: Components of the states: compass, frame, full equations, two-component system, two bi-gyro axes, two gyropendulums.
PLACES = [0, 5, 10, 18, 24, 30, 33, 36]


def parts(state: Sequence[Number]) -> list[Sequence[Number]]:
    return [state[first:last] for first, last in pairwise(PLACES)]


def field(ar: SeriesArithmetic, time: Series, state: list[Series]) -> list[Number]:
    kinematics = Kinematics(ar, MANOEUVRE)
    force, speed = kinematics.force_x(time), kinematics.speed(kinematics.place(time))
    radius, (scale, kappa) = kinematics.radius, usual_tuning(ar, MANOEUVRE)
    compass, frame, full, inertial, pair, programmed, usual = parts(state)
    law = 1 / ar.sqrt(scale * scale - speed * speed)
    return [
        *compass_rates(compass[:4], compass[4], radius, ar.number(0), force),
        *frame_rates(ar, frame[:4], frame[4], radius, ar.number(LIMIT), force),
        *full[4:],
        *full_acceleration(radius, full[:4], full[4:], force),
        *two_component_rates(inertial[:4], inertial[4:], radius, force),
        *(x for axis in self_tuned_rates(ar, scale, pair[:3], pair[3:], force) for x in axis),
        *axis_rate(law, programmed, force),
        *axis_rate(kappa, usual, force),
    ]


def trihedron(balls: BallArithmetic, quaternion: Sequence[Number]) -> list[Vector]:
    return [rotate(quaternion, [balls.number(x) for x in unit]) for unit in UNITS]


def initial(balls: BallArithmetic) -> list[Number]:
    kinematics, zero = Kinematics(balls, MANOEUVRE), balls.number(0)
    place = kinematics.place(zero)
    e, v = kinematics.darboux(place), kinematics.speed(place)
    axes, (scale, _) = trihedron(balls, e), usual_tuning(balls, MANOEUVRE)
    cosine, sine = exact_tilt(balls, scale, v)
    tilts = [tilted(axes, (cosine, sign * sine)) for sign in (1, -1)]
    turning = [zero, *(x * v / kinematics.radius for x in axes[1])]  # r x v/R is v/R along the axis left of v
    return [
        *(*e, v),
        *(*e, (v / LIMIT).acos()),
        *(*e, *(x / 2 for x in product(turning, e))),
        *(*e, v, zero),
        *(*tilts[0], *tilts[1]),
        *tilts[0],
        *tilts[0],
    ]


@pytest.fixture(scope="module")
def run() -> tuple[list[Number], list[Vector], Number, Number]:
    """States at the end, and the true trihedron, speed and V."""
    with BallArithmetic(BITS) as balls:
        end = balls.number(TIME)
        state = integrate(balls, field, initial(balls), balls.number(0), end, steps=STEPS, order=ORDER)
        kinematics = Kinematics(balls, MANOEUVRE)
        place = kinematics.place(end)
        axes = trihedron(balls, kinematics.darboux(place))
        return state, axes, kinematics.speed(place), usual_tuning(balls, MANOEUVRE)[0]


def worst(pairs: Sequence[tuple[Vector, Vector]]) -> float:
    return max(float(abs(x - y).abs_upper()) for a, b in pairs for x, y in zip(a, b, strict=True))


def test_the_exact_systems_are_where_the_truth_is(run) -> None:
    state, axes, v, scale = run
    with BallArithmetic(BITS) as balls:
        compass, frame, full, inertial, pair, programmed, _ = parts(state)
        free = trihedron(balls, inertial[:4])
        velocity = [x * inertial[4] + y * inertial[5] for x, y in zip(free[0], free[1], strict=True)]
        turning = product(full[4:], [full[0], *(-x for x in full[1:4])])
        law = tilted(axes, exact_tilt(balls, scale, v))
        pairs = [
            *zip(trihedron(balls, compass[:4]), axes, strict=True),
            *zip(trihedron(balls, frame[:4]), axes, strict=True),
            (trihedron(balls, full[:4])[2], axes[2]),
            (free[2], axes[2]),
            (bisector(balls, pair[:3], pair[3:]), axes[2]),
            (programmed, law),
            ([compass[4] / v, frame[4].cos() * LIMIT / v], [balls.number(1)] * 2),
            ([x / v for x in velocity], axes[0]),
            ([x * 2 * balls.number(6371000) / v for x in turning[1:]], cross(axes[2], axes[0])),
            ([dot(full[:4], full[:4]), dot(full[:4], full[4:])], [balls.number(1), balls.number(0)]),
        ]
        # What is left of a step of 60 s is its 41st power of 60 s over the radius of convergence.
        assert worst(pairs) < 1e-46


def test_the_usual_gyropendulum_is_not_exact(run) -> None:
    """Its axis leaves the law within two minutes."""
    state, axes, v, scale = run
    with BallArithmetic(BITS) as balls:
        usual, law = parts(state)[-1], tilted(axes, exact_tilt(balls, scale, v))
        assert 1e-6 < worst([(usual, law)]) < 1e-3
