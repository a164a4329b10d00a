"""Integrators of polynomial fit against the truth of regular precession, and their invariants."""

import os
import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.scoring.errors import attitude_error_vectors, difference, rotated
from sinsbench.subjects import fitted_integrators
from sinsbench.subjects.fitted_integrators import FITTED_INTEGRATORS, FittedStreamingIntegrator
from sinsbench.subjects.fitted_methods import FITTED_METHODS
from sinsbench.subjects.integrators import INTEGRATORS
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

EPS = np.finfo(float).eps
CASES = {case.name: case for case in paper_cases("dual_precession")}
DEG_PER_H = np.degrees(1.0) * 3600

every_integrator = pytest.mark.parametrize("name", FITTED_INTEGRATORS)
few = settings(derandomize=True, deadline=None, max_examples=10)
seeds = st.integers(0, 2**32)


def random_inputs(seed, samples, steps=6, scale=0.05):
    """Increments of a smooth random motion: rate and force of a few harmonics, 1/32 of a period apart."""
    random = np.random.default_rng(seed)
    phase = 2 * np.pi * (np.arange(samples * steps)[:, None] / 32 + random.random((1, 3)))
    attitude = random.normal(size=4)
    angle, velocity = (
        size * sum(random.normal(size=3) * np.sin(k * phase + random.normal(size=3)) for k in (0, 1, 2))
        for size in (scale, 0.3)
    )
    return angle, velocity, 0.01, attitude / np.linalg.norm(attitude), random.normal(scale=10, size=3)


def turned(frame, vectors):
    """Vectors in the axes of a turned body."""
    return rotated(frame * [1, -1, -1, -1], vectors)


def product(a, b):
    """Hamilton products of quaternions in the last axis."""
    scalar = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def cut_off(name, turn):
    """What functional iteration leaves out of a quaternion at each step that turns by so many radians.

    Up to a factor below 4, which the other iterates and coefficients add, that is twice the first Chebyshev
    coefficient left out, that of exp(tau turn/4).
    """
    if FITTED_METHODS[name].flow != "functional iteration":
        return 0.0
    first = FITTED_METHODS[name].samples_per_step + 2
    return 4 * 2 * (turn / 8) ** first / factorial(first)


@cache
def motion(case, samples, duration):
    """A case of the papers, divided into so many samples, with truth at its start and its end."""
    interval, end = ExactNumber(f"({duration})/{samples}"), ExactNumber(duration)
    return sample(replace(CASES[case], duration=end, interval=interval), Fraction(1), end)


def end_errors(name, sampled):
    """Attitude error vector (rad) and velocity error (m/s, inertial axes) at the end of a motion."""
    start = sampled.attitude[0], sampled.velocity_inertial[0]
    result = FITTED_INTEGRATORS[name](sampled.angle, sampled.velocity, sampled.interval, *start)
    attitude = attitude_error_vectors(result["attitude"][-1:], sampled.attitude[-1:], sampled.attitude_lo[-1:])
    truth = sampled.velocity_inertial[-1], sampled.velocity_inertial_lo[-1]
    return np.linalg.norm(attitude), np.linalg.norm(difference(result["velocity_inertial"][-1], *truth))


# Method, duration (s): drift (deg/h) and error of inertial velocity (m/s) on coning and on general precession at
# 100 Hz, recomputed in binary64 by series of thirty terms without compensation. The rows of N = 8 and 10, which are
# nothing but its rounding, show what that leaves: up to 2e-9 deg/h and 3e-9 m/s where the error itself is smaller.
RECOMPUTED = {
    ("taylor3", "99.99"): ((7.5947e-3, 4.2694e-3), (3.7974e-3, 2.1367e-3)),
    ("taylor4", "100"): ((2.5395e-5, 1.4314e-5), (1.2699e-5, 7.1696e-6)),
    ("taylor5", "100"): ((1.0845e-5, 6.1147e-6), (5.4225e-6, 3.0592e-6)),
    ("taylor6", "99.96"): ((7.0921e-8, 4.0692e-8), (3.5725e-8, 1.9606e-8)),
    ("magnus4", "100"): ((9.9427e-3, 5.4782e-3), (5.1318e-3, 2.9309e-3)),
}


@pytest.mark.parametrize(("name", "duration"), RECOMPUTED)
def test_drift_and_velocity_are_the_recomputed_ones(name, duration):
    for case, (drift, velocity) in zip(
        ("variant2_coning", "variant2_general"), RECOMPUTED[name, duration], strict=True
    ):
        attitude, error = end_errors(name, motion(case, round(float(duration) * 100), duration))
        # Half a unit of the fifth digit is at most 5e-5 of a number that begins with 1.
        assert attitude / float(duration) * DEG_PER_H == pytest.approx(drift, rel=5e-5, abs=2e-9)
        assert error == pytest.approx(velocity, rel=5e-5, abs=3e-9)


@pytest.mark.parametrize("case", ["variant1_coning", "variant1_general"])
@pytest.mark.parametrize(
    ("name", "limit"),
    [("taylor8", 1.1e-13), ("taylor9", 1e-13), ("taylor10", 1.5e-13), ("quatfiter8", 1.5e-13), ("quatfiter10", 3e-13)],
)
def test_eight_samples_and_more_reach_the_floor_of_the_inputs(name, limit, case):
    """Of 100 s at 100 Hz. Rounding the increments of a constant rate alone turns the body by 1e-13 rad by then.

    taylor8 has 1.02e-13 on coning, which is the error of its fit and no rounding.
    """
    samples = 10_000 - 10_000 % FITTED_METHODS[name].samples_per_step
    attitude, velocity = end_errors(name, motion(case, samples, f"{samples}/100"))
    assert attitude < limit
    # Forces are of 100 m/s^2 at most: 1e4 m/s in all, turned by the error of attitude, and a few roundings of each sum.
    assert velocity < 1e4 * (limit + EPS)


STEPS = (14, 20, 28, 40, 56, 80, 112, 160, 224)
"""Steps in 8 s: each about the square root of 2 times the one before."""


@pytest.mark.parametrize(("case", "ratio"), [("variant1_coning", -1), ("variant1_general", 0.5)])
@every_integrator
def test_orders_on_coning_and_on_general_precession(name, case, ratio):
    method = FITTED_METHODS[name]
    # Rounding turns the body by about an eps of what it turns about its third axis, 1.6e-16 and 1.6e-14 rad.
    floor = EPS * 8 * 2 * np.pi * (1 + ratio * np.cos(np.pi / 18))
    ladder, errors = STEPS if method.order > 6 else STEPS[-3:], []
    for steps in ladder:
        error = end_errors(name, motion(case, method.samples_per_step * steps, "8"))
        if error[0] < 10 * floor:
            break
        errors.append(error)
    slopes = np.log(np.divide(errors[-2], errors[-1])) / np.log(ladder[len(errors) - 1] / ladder[len(errors) - 2])
    if method.order <= 6:
        np.testing.assert_allclose(slopes, method.order, rtol=0, atol=0.15)  # 224 steps
    else:
        # A method that is symmetric about the middle of its step has even orders only. High ones meet the floor before
        # the slope is a straight line's, but not before it is nearer to one even number than to another.
        np.testing.assert_array_equal(2 * np.round(slopes / 2), method.order)


@every_integrator
@few
@given(seed=seeds, size=st.sampled_from([1e-6, 1e-2, 0.3]))
def test_constant_rate_and_force_are_a_screw_motion(name, seed, size):
    random = np.random.default_rng(seed)
    rate, force, velocity0 = size * random.uniform(-1, 1, 3), random.uniform(-1, 1, 3), random.uniform(-1, 1, 3)
    samples = 2 * FITTED_METHODS[name].samples_per_step
    inputs = np.tile(rate, (samples, 1)), np.tile(force, (samples, 1))
    result = FITTED_INTEGRATORS[name](*inputs, 0.01, [1, 0, 0, 0], velocity0)
    # In extended precision: half the angle, and the integral of the turned force by Rodrigues' formula.
    turn = samples * rate.astype(np.longdouble)
    n = np.sqrt(turn @ turn)
    attitude = np.concatenate([[np.cos(n / 2)], np.sin(n / 2) / n * turn])
    twice = np.cross(turn, np.cross(turn, force)) / n**2
    first = np.cross(turn, force) * 2 * (np.sin(n / 2) / n) ** 2
    gained = samples * (force + first + (1 - np.sin(n) / n if n > 1e-3 else n**2 / 6 - n**4 / 120) * twice)
    # 2 steps, each of a few roundings of numbers that sum up to the exponential of half the turn of half a step.
    growth = np.exp(float(n) / 8)
    tolerance = 10 * EPS * growth + 2 * cut_off(name, float(n) / 2)
    np.testing.assert_allclose(result["attitude"][-1], attitude.astype(float), rtol=0, atol=tolerance)
    expected = (velocity0 + gained).astype(float)
    np.testing.assert_allclose(result["velocity_inertial"][-1], expected, rtol=0, atol=tolerance * 2 * samples)


@every_integrator
@few
@given(seed=seeds)
def test_norm_is_kept_and_both_velocities_are_one_vector(name, seed):
    result = FITTED_INTEGRATORS[name](*random_inputs(seed, FITTED_METHODS[name].samples_per_step))
    attitude, inertial = result["attitude"], result["velocity_inertial"]
    if FITTED_METHODS[name].flow != "functional iteration":  # whose series, cut off, is no unit quaternion
        # Compensated sums: in 6 steps what is left is some roundings of each step itself.
        np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1, rtol=0, atol=20 * EPS)
    back = attitude * [1, -1, -1, -1]
    body = product(product(back, np.insert(inertial, 0, 0, axis=1)), attitude)[:, 1:]
    np.testing.assert_allclose(result["velocity_body"], body, rtol=0, atol=20 * EPS * np.abs(inertial).max())


@every_integrator
@few
@given(seed=seeds)
def test_turning_a_frame_turns_the_result(name, seed):
    method, integrate = FITTED_METHODS[name], FITTED_INTEGRATORS[name]
    angle, velocity, interval, attitude0, velocity0 = random_inputs(seed, method.samples_per_step)
    plain = integrate(angle, velocity, interval, attitude0, velocity0)
    frame = np.random.default_rng(seed + 1).normal(size=4)
    frame /= np.linalg.norm(frame)
    size = np.abs(plain["velocity_inertial"]).max()
    tolerance = {"rtol": 0, "atol": 300 * EPS}  # 6 steps of some tens of roundings

    other = integrate(angle, velocity, interval, product(frame, attitude0), rotated(frame, velocity0))
    np.testing.assert_allclose(other["attitude"], product(frame, plain["attitude"]), **tolerance)
    expected = rotated(frame, plain["velocity_inertial"])
    np.testing.assert_allclose(other["velocity_inertial"] / size, expected / size, **tolerance)
    np.testing.assert_allclose(other["velocity_body"] / size, plain["velocity_body"] / size, **tolerance)

    increments = turned(frame, angle), turned(frame, velocity)
    other = integrate(*increments, interval, product(attitude0, frame), velocity0)
    np.testing.assert_allclose(other["attitude"], product(plain["attitude"], frame), **tolerance)
    np.testing.assert_allclose(other["velocity_inertial"] / size, plain["velocity_inertial"] / size, **tolerance)


@every_integrator
def test_streaming_is_the_batch_bit_for_bit(name):
    method = FITTED_METHODS[name]
    angle, velocity, interval, attitude0, velocity0 = random_inputs(7, method.samples_per_step, steps=20)
    angle[: len(angle) // 2] *= 1e-3
    batch = FITTED_INTEGRATORS[name](angle, velocity, interval, attitude0, velocity0)
    stream = FittedStreamingIntegrator(method, attitude0, velocity0)
    states = [stream.state]
    for k in range(0, len(angle), method.samples_per_step):
        rows = slice(k, k + method.samples_per_step)
        states.append(stream.update(angle[rows], velocity[rows]))
    for field, column in batch.items():
        np.testing.assert_array_equal([getattr(state, field) for state in states], column)


def test_magnus_4_on_two_samples_is_the_two_sample_coning_correction():
    """The linear fit has one commutator: p1 + p2 + (2/3) p1 x p2, and with it the two-sample method."""
    inputs = random_inputs(3, 2)
    for field, expected in INTEGRATORS["two_sample"](*inputs).items():
        # 6 steps of a few roundings, of velocities up to 30 m/s.
        np.testing.assert_allclose(FITTED_INTEGRATORS["magnus4"](*inputs)[field], expected, rtol=0, atol=300 * EPS * 30)


@pytest.mark.parametrize("name", ["taylor10", "quatfiter10"])
def test_a_step_that_turns_too_far_is_refused(name):
    angle = np.random.default_rng(1).normal(size=(20, 3))
    angle[:10], angle[10:] = 0.01, 100 * angle[10:]
    message = f"step 1: {name} does not converge: its 10 samples turn by 1.46e+03 rad in all"
    with pytest.raises(ValueError, match=re.escape(message)):
        FITTED_INTEGRATORS[name](angle, angle, 0.01, [1, 0, 0, 0], [0, 0, 0])
    stream = FittedStreamingIntegrator(FITTED_METHODS[name], [1, 0, 0, 0], [1, 2, 3])
    before = stream.update(angle[:10], angle[:10])
    with pytest.raises(ValueError, match="does not converge"):
        stream.update(angle[10:], angle[10:])
    assert stream.state is before


@pytest.mark.parametrize("samples", [0, 8])
def test_result_starts_with_the_initial_state(samples):
    increments = np.full((samples, 3), 0.01)
    result = FITTED_INTEGRATORS["taylor4"](increments, increments, 0.01, [0, 1, 0, 0], [1, 2, 3])
    assert {name: array.shape for name, array in result.items()} == {
        "attitude": (samples // 4 + 1, 4),
        "velocity_inertial": (samples // 4 + 1, 3),
        "velocity_body": (samples // 4 + 1, 3),
    }
    np.testing.assert_array_equal(result["attitude"][0], [0, 1, 0, 0])
    np.testing.assert_array_equal(result["velocity_inertial"][0], [1, 2, 3])
    np.testing.assert_array_equal(result["velocity_body"][0], [1, -2, -3])


def test_bad_input_is_refused():
    good = np.zeros((6, 3)), np.zeros((6, 3)), 0.01, [1.0, 0, 0, 0], np.zeros(3)
    with pytest.raises(ValueError, match="angle has 6 samples, expected a multiple of 4"):
        fitted_integrators.taylor4(*good)
    with pytest.raises(ValueError, match="velocity has shape 5 x 3, expected 6 x 3"):
        fitted_integrators.taylor3(good[0], np.zeros((5, 3)), *good[2:])
    stream = FittedStreamingIntegrator(FITTED_METHODS["taylor3"], *good[3:])
    with pytest.raises(ValueError, match="angle has shape 2 x 3, expected 3 x 3"):
        stream.update(np.zeros((2, 3)), np.zeros((3, 3)))
    with pytest.raises(ValueError, match="attitude0 has values that are not finite"):
        FittedStreamingIntegrator(FITTED_METHODS["taylor3"], [np.nan, 0, 0, 0], np.zeros(3))


def test_integrators_say_what_they_are():
    for name, integrate in FITTED_INTEGRATORS.items():
        assert integrate.__name__ == name
        assert getattr(fitted_integrators, name) is integrate
        assert "(n, 3)" in integrate.__doc__
        assert FITTED_METHODS[name].source in integrate.__doc__
    with pytest.raises(AttributeError, match="taylor11"):
        _ = fitted_integrators.taylor11


def test_import_does_not_import_the_compiler():
    code = "import sys; from sinsbench.subjects import fitted_integrators; print('numba' in sys.modules)"
    completed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ)
    assert completed.stdout.strip() == "False"
