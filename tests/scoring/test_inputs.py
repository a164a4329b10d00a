"""The input floor against brute force: the same integration with rounded and with exact increments, in forty digits."""

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from sinsbench.scoring.inputs import input_errors
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

MP = mpmath.MPContext()
MP.dps = 40


def product(a, b):
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]


def conjugate(q):
    return [q[0], -q[1], -q[2], -q[3]]


def turn(p, part):
    size = MP.sqrt(sum(x * x for x in p))
    return [MP.cos(size * part / 2), *(MP.sin(size * part / 2) * x / size for x in p)]


def integrate(angle, velocity, attitude, inertial):
    """One rotation a sample, the velocity increment resolved in its middle: of second order, exactly evaluated."""
    norm = MP.sqrt(sum(x * x for x in attitude))  # what an algorithm can avoid is no part of the floor
    attitude = [x / norm for x in attitude]
    history = [(attitude, inertial)]
    for p, b in zip(angle, velocity, strict=True):
        middle = product(attitude, turn(p, MP.mpf("0.5")))
        gain = product(product(middle, [MP.mpf(0), *b]), conjugate(middle))[1:]
        attitude = product(attitude, turn(p, MP.mpf(1)))
        inertial = [x + y for x, y in zip(inertial, gain, strict=True)]
        history.append((attitude, inertial))
    return history


def numbers(high, low=None):
    low = np.zeros_like(high) if low is None else low
    return [
        [MP.mpf(x) + MP.mpf(y) for x, y in zip(*row, strict=True)]
        for row in zip(high.tolist(), low.tolist(), strict=True)
    ]


@pytest.fixture(scope="module", params=["coning", "general"])
def motion(request):
    given = next(case for case in paper_cases("dual_precession") if case.name == f"variant3_{request.param}")
    # An attitude whose components are no binary64, so that the initial rounding counts too.
    attitude = tuple(map(ExactNumber, ("cos(0.7)", "sin(0.7)*0.6", "sin(0.7)*0.8", "0")))
    case = replace(given, duration=ExactNumber("1.6"), initial_attitude=attitude)
    return sample(case, Fraction(1, 2), ExactNumber("0.08"))


@pytest.fixture(scope="module")
def brute_force(motion):
    start = motion.attitude[:1], motion.attitude_lo[:1], motion.velocity_inertial[:1], motion.velocity_inertial_lo[:1]
    rounded = integrate(numbers(motion.angle), numbers(motion.velocity), numbers(start[0])[0], numbers(start[2])[0])
    exact = integrate(
        numbers(motion.angle, motion.angle_lo),
        numbers(motion.velocity, motion.velocity_lo),
        numbers(*start[:2])[0],
        numbers(*start[2:])[0],
    )
    attitude, inertial, body = [], [], []
    for (q, w), (star, w_star) in zip(rounded, exact, strict=True):
        attitude.append([float(2 * x) for x in product(q, conjugate(star))[1:]])
        inertial.append([float(x - y) for x, y in zip(w, w_star, strict=True)])
        # The error of the body components, turned into inertial axes.
        components = [product(product(conjugate(p), [MP.mpf(0), *v]), p) for p, v in ((q, w), (star, w_star))]
        error = [x - y for x, y in zip(*components, strict=True)]
        body.append([float(x) for x in product(product(star, error), conjugate(star))[1:]])
    return tuple(np.array(x)[motion.checkpoints] for x in (attitude, inertial, body))


def test_floors(motion, brute_force):
    found = input_errors(motion)
    for computed, expected in zip((found.attitude, found.velocity, found.velocity_body), brute_force, strict=True):
        largest = np.abs(expected).max()
        assert largest > 1e-17  # there is something to compare
        # The brute force is itself of second order in the sample: per cent.
        assert computed == pytest.approx(expected, abs=0.02 * largest)


def test_bias_response_is_the_integral_of_the_rotation_matrix(motion):
    """A gyro bias along the last spin axis, against Simpson's rule on the true attitude."""
    found = input_errors(motion).bias_response
    w, x, y, z = motion.attitude.T
    column = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    h = motion.time[1] - motion.time[0]
    simpson = np.cumsum((column[:-2:2] + 4 * column[1:-1:2] + column[2::2]) * h / 3, axis=0)
    # Simpson errs by (frequency h)^4 / 180, with frequencies up to 10 rad/s and h = 0.08 s.
    assert found[2::2, :, 2] == pytest.approx(simpson, abs=5e-3)
    assert found[0] == pytest.approx(np.zeros((3, 3)))
