"""The published methods written out as their papers have them: recursions, classical velocity updates, start-up."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sinsbench.instrumentation import rebuilt_kernels
from sinsbench.subjects.integrators import INTEGRATORS, StreamingIntegrator, extrapolated_start, integrator
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.rotation_vector_methods import RotationVectorMethod, binary64_coefficients

EPS = np.finfo(float).eps
KERNELS = rebuilt_kernels()
WITH_HISTORY = [name for name, method in PUBLISHED_METHODS.items() if method.history]
seeds = st.integers(0, 2**32)
examples = settings(derandomize=True, deadline=None, max_examples=30)


def random_increments(seed, samples):
    random = np.random.default_rng(seed)
    return random.normal(scale=0.1, size=(samples, 3)), random.normal(size=(samples, 3))


def rotation_vectors(method, angle, velocity):
    p, b = (tuple(map(tuple, array.tolist())) for array in (angle, velocity))
    coefficients = binary64_coefficients(method)
    return KERNELS["rotation_vector"](p, coefficients), KERNELS["rotation_vector_dual"](p, b, coefficients)


@pytest.mark.parametrize(("name", "samples"), [("recursive", 1), ("savage_high_rate4", 4)])
@examples
@given(seed=seeds)
def test_high_rate_recursions(name, samples, seed):
    """Savage 1998, parts I and II: coning and sculling, accumulated sample by sample."""
    angle, velocity = random_increments(seed, samples + 1)
    attitude, gained, coning, sculling = np.zeros((4, 3))
    for k in range(1, samples + 1):
        coning += np.cross(attitude + angle[k - 1] / 6, angle[k]) / 2
        sculling += np.cross(attitude + angle[k - 1] / 6, velocity[k]) / 2
        sculling += np.cross(gained + velocity[k - 1] / 6, angle[k]) / 2
        attitude, gained = attitude + angle[k], gained + velocity[k]
    phi, phi_dual = rotation_vectors(PUBLISHED_METHODS[name], angle, velocity)
    # Some ten roundings of numbers below one.
    np.testing.assert_allclose(phi, attitude + coning, rtol=0, atol=20 * EPS)
    np.testing.assert_allclose(phi_dual, gained + sculling, rtol=0, atol=100 * EPS)


@examples
@given(seed=seeds)
def test_two_samples_and_the_sum_of_the_two_before(seed):
    """Ignagni 1996: 32/45 p1 x p2 less 1/180 of the product of the sums of both steps."""
    (before1, before2, p1, p2), velocity = random_increments(seed, 4)
    expected = p1 + p2 + 32 / 45 * np.cross(p1, p2) - np.cross(before1 + before2, p1 + p2) / 180
    phi, _ = rotation_vectors(PUBLISHED_METHODS["ignagni2"], np.array([before1, before2, p1, p2]), velocity)
    np.testing.assert_allclose(phi, expected, rtol=0, atol=20 * EPS)


@pytest.mark.parametrize("compensated", [False, True], ids=["plain", "compensated"])
@pytest.mark.parametrize(("name", "third"), [("two_sample_savage", 0), ("two_sample_savage_third", 1 / 6)])
def test_classical_velocity_update(name, third, compensated):
    """Savage 1998, part II, with vectors of numpy and rotations of scipy."""
    angle, velocity = random_increments(1, 40)
    attitude, inertial = Rotation.from_quat([0.5, 0.5, -0.5, 0.5], scalar_first=True), np.array([10.0, -20, 5])
    integrate = integrator(PUBLISHED_METHODS[name], compensated=compensated)
    result = integrate(angle, velocity, 0.01, attitude.as_quat(scalar_first=True), inertial)
    for k, ((p1, p2), (b1, b2)) in enumerate(zip(angle.reshape(-1, 2, 3), velocity.reshape(-1, 2, 3), strict=True)):
        rotation_correction = np.cross(p1 + p2, b1 + b2)
        gain = b1 + b2 + 2 / 3 * (np.cross(p1, b2) + np.cross(b1, p2)) + rotation_correction / 2
        gain += third * np.cross(p1 + p2, rotation_correction)
        inertial = inertial + attitude.apply(gain)
        attitude = attitude * Rotation.from_rotvec(p1 + p2 + 2 / 3 * np.cross(p1, p2))
        # At most 20 steps of some 50 roundings of velocities below 50 m/s.
        tolerance = {"rtol": 0, "atol": 1000 * 50 * EPS}
        np.testing.assert_allclose(result["velocity_inertial"][k + 1], inertial, **tolerance)
        np.testing.assert_allclose(result["velocity_body"][k + 1], attitude.inv().apply(inertial), **tolerance)


@pytest.mark.parametrize("name", ["two_sample_savage", "two_sample_savage_third"])
def test_the_velocity_rule_leaves_the_attitude_alone(name):
    inputs = (*random_increments(2, 40), 0.01, [1.0, 0, 0, 0], np.zeros(3))
    result, other = INTEGRATORS[name](*inputs), INTEGRATORS["two_sample"](*inputs)
    np.testing.assert_array_equal(result["attitude"], other["attitude"])
    assert np.abs(result["velocity_inertial"] - other["velocity_inertial"]).max() > 1e-4


@pytest.mark.parametrize("known", [0, 1, 2, 3, 8])
@given(seed=seeds, count=st.integers(0, 3))
@examples
def test_start_is_continued_by_the_polynomial_through_the_first_samples(known, seed, count):
    coefficients = np.random.default_rng(seed).integers(-99, 99, size=(min(known, 3), 3)).astype(float)
    sampled = [sum((c * k**power for power, c in enumerate(coefficients)), np.zeros(3)) for k in range(-count, known)]
    expected = np.array(sampled[:count]).reshape(count, 3)
    # Whole numbers: every operation is exact.
    np.testing.assert_array_equal(extrapolated_start(np.array(sampled[count:]).reshape(known, 3), count), expected)


@pytest.mark.parametrize("name", WITH_HISTORY)
def test_a_start_from_zeros_leaves_what_its_products_would_have_given(name):
    """The error is that of the first rotation vector, and it stays."""
    method = PUBLISHED_METHODS[name]
    r = method.samples_per_step
    time = np.arange(40 * r + 1)[:, np.newaxis] * 0.01
    angle = 0.02 * np.diff(np.hstack([np.sin(3 * time), np.cos(3 * time), time]), axis=0)
    start = [1.0, 0, 0, 0], np.zeros(3)
    stream = StreamingIntegrator(method, *start)
    rest = [stream.update(angle[k : k + r], angle[k : k + r]).attitude for k in range(0, len(angle), r)]
    batch = INTEGRATORS[name](angle, angle, 0.01, *start)["attitude"][1:]
    before = extrapolated_start(angle, method.history)
    first = np.vstack([before, angle[:r]])
    missing = np.subtract(
        *(rotation_vectors(method, rows, rows)[0] for rows in (first, np.vstack([0 * before, angle[:r]])))
    )
    offsets = [
        2 * np.array(KERNELS["quaternion_product"](tuple(a), KERNELS["conjugate"](tuple(b))))[1:]
        for a, b in zip(batch, rest, strict=True)
    ]
    # The first step turns by less than 0.06 rad, so the length of the missing vector is kept to the square of half
    # of that. Afterwards both turn alike, but for the rounding of up to 160 samples.
    np.testing.assert_allclose(np.linalg.norm(offsets, axis=1), np.linalg.norm(missing), rtol=1e-3, atol=0)
    assert np.linalg.norm(missing) > 1e-10
    np.testing.assert_allclose(offsets - offsets[0], 0, atol=160 * 4 * EPS)


def test_increments_before_the_first_are_checked():
    method, start = PUBLISHED_METHODS["recursive"], ([1.0, 0, 0, 0], np.zeros(3))
    with pytest.raises(ValueError, match="earlier has shape 2 x 3, expected 1 x 3"):
        StreamingIntegrator(method, *start, earlier=(np.zeros((2, 3)), np.zeros((1, 3))))


@pytest.mark.parametrize("index", [(1, 5), (-1, 1), (1, 2, 3)])
def test_method_table_refuses_a_wrong_index(index):
    with pytest.raises(ValueError, match=r"is not 2 sample numbers in 0\.\.4"):
        RotationVectorMethod("wrong", 2, 4, {index: Fraction(1)}, {}, {}, "test", history=1)


def test_method_table_refuses_an_unknown_velocity_rule():
    with pytest.raises(ValueError, match="'fourth order' is none of transfer, second order, third order"):
        RotationVectorMethod("wrong", 2, 4, {}, {}, {}, "test", velocity_rule="fourth order")
