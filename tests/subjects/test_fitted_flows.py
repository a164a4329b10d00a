"""One step of each flow against other ways to the same motion, and the bounds by which series end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import chebyshev, polynomial
from scipy.integrate import solve_ivp

from sinsbench.subjects.fitted_integrators import FITTED_INTEGRATORS
from sinsbench.subjects.fitted_methods import FITTED_METHODS, iterate_degree

EPS = np.finfo(float).eps
few = settings(derandomize=True, deadline=None, max_examples=5)
samples = pytest.mark.parametrize("n", range(2, 11))


def product(a, b):
    """Hamilton product."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def conjugated(q):
    return q * [1, -1, -1, -1]


def interpolated(increments):
    """Polynomial whose integrals over the parts of (-1, 1) are the rows: the derivative of that through their sums."""
    edges = np.linspace(-1, 1, len(increments) + 1)
    sums = np.vstack([np.zeros(3), np.cumsum(increments, axis=0)])
    return polynomial.polyder(np.linalg.solve(polynomial.polyvander(edges, len(increments)), sums))


def smooth_increments(n, seed, scale):
    random = np.random.default_rng(seed)
    phase = 2 * np.pi * (np.arange(n)[:, None] / 40 + random.random((1, 3)))
    return tuple(size * (random.normal(size=3) + np.sin(phase)) for size in (scale, 0.3))


def one_step(name, angle, velocity):
    """Rotation of a step, and the velocity gained in axes of its start."""
    result = FITTED_INTEGRATORS[name](angle, velocity, 0.01, [1, 0, 0, 0], [0, 0, 0])
    return result["attitude"][1], result["velocity_inertial"][1]


@samples
@few
@given(seed=st.integers(0, 2**32))
def test_power_series_is_the_motion_of_the_polynomials(n, seed):
    """Against SciPy's DOP853 on the differential equations of attitude and inertial velocity."""
    angle, velocity = smooth_increments(n, seed, 0.5 / n)
    rate, force = interpolated(angle), interpolated(velocity)

    def derivative(tau, state):
        omega, f = polynomial.polyval(tau, rate), polynomial.polyval(tau, force)
        q = state[:4]
        return [*(product(q, np.array([0, *omega])) / 2), *product(product(q, np.array([0, *f])), conjugated(q))[1:]]

    start = [1.0, 0, 0, 0, 0, 0, 0]
    motion = solve_ivp(derivative, (-1, 1), start, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    rotation, gained = one_step(f"taylor{n}", angle, velocity)
    # DOP853 keeps to some ten times its tolerance; monomials of degree 9 lose up to two digits in `interpolated`.
    np.testing.assert_allclose(rotation, motion[:4], rtol=0, atol=2e-12)
    np.testing.assert_allclose(gained, motion[4:], rtol=0, atol=2e-12 * n)


def literal_iteration(rate, degree):
    """q <- 1 + (1/2) integral of q o omega, as published: products of Chebyshev series, cut off at a degree."""
    q = np.zeros((degree + 1, 4))
    q[0, 0] = 1

    def times(a, b):
        whole = chebyshev.chebmul(q[:, a], rate[:, b])
        return np.pad(whole, (0, degree + len(rate) - len(whole)))  # chebmul drops zeros at the end

    for _ in range(30):
        derivative = [
            -(times(1, 0) + times(2, 1) + times(3, 2)),
            times(0, 0) + times(2, 2) - times(3, 1),
            times(0, 1) + times(3, 0) - times(1, 2),
            times(0, 2) + times(1, 1) - times(2, 0),
        ]
        q = np.stack([chebyshev.chebint(x / 2)[: degree + 1] for x in derivative], axis=1)
        q[0] -= chebyshev.chebval(-1, q) - [1, 0, 0, 0]
    return q


@samples
@few
@given(seed=st.integers(0, 2**32))
def test_functional_iteration_is_the_published_one(n, seed):
    """Attitude as QuatFIter has it, iterated till nothing changes; velocity by quadrature of the turned force."""
    angle, velocity = smooth_increments(n, seed, 0.5 / n)
    force = interpolated(velocity)
    rate = np.stack([chebyshev.poly2cheb(column) for column in interpolated(angle).T], axis=1)
    q = literal_iteration(rate, iterate_degree(n))
    rotation, gained = one_step(f"quatfiter{n}", angle, velocity)
    np.testing.assert_allclose(rotation, q.sum(axis=0), rtol=0, atol=1e-13)  # as above: two digits lost
    nodes, weights = np.polynomial.legendre.leggauss(20)  # exact up to degree 39; that of q o a o conj(q) is 31
    turned = [
        product(product(at, np.array([0, *polynomial.polyval(tau, force)])), conjugated(at))[1:]
        for tau, at in zip(nodes, chebyshev.chebval(nodes, q).T, strict=True)
    ]
    np.testing.assert_allclose(gained, weights @ turned, rtol=0, atol=1e-13 * n)


@pytest.mark.parametrize("name", ["magnus4", "magnus6_three_samples", "magnus6"])
def test_magnus_meets_the_exact_flow_with_its_order(name):
    """Halving the interval divides the difference from the exact flow of one step by 2 to the order plus one."""
    order = {"magnus4": 4}.get(name, 6)
    n = FITTED_METHODS[name].samples_per_step

    def differences(scale):
        """Rate and force as polynomials of degree 3 in time, sampled n times a step of `scale`."""
        edges = np.linspace(-scale, scale, n + 1)[:, None]
        random = np.random.default_rng(4)
        sums = [sum(c * edges**k for k, c in enumerate(random.normal(size=(4, 3)), 1)) for _ in range(2)]
        increments = [np.diff(x, axis=0) for x in sums]
        return [
            np.linalg.norm(x - y)
            for x, y in zip(*(one_step(m, *increments) for m in (name, f"taylor{n}")), strict=True)
        ]

    ratio = np.divide(differences(0.2), differences(0.1))
    # The order of a step is odd, by symmetry; the next term is two orders on.
    np.testing.assert_array_equal(2 * np.round((np.log2(ratio) - 1) / 2), order)


def test_no_rate_and_no_force():
    for name, method in FITTED_METHODS.items():
        rotation, gained = one_step(
            name, np.zeros((method.samples_per_step, 3)), np.zeros((method.samples_per_step, 3))
        )
        np.testing.assert_array_equal(rotation, [1, 0, 0, 0])
        np.testing.assert_array_equal(gained, np.zeros(3))


@pytest.mark.parametrize("name", FITTED_METHODS)
def test_force_without_rotation_is_summed(name):
    """All terms of the series that the highest power of the force needs are there, though there is no rotation."""
    n = FITTED_METHODS[name].samples_per_step
    force = np.random.default_rng(2).normal(size=(n, 3))
    _, gained = one_step(name, np.zeros((n, 3)), force)
    np.testing.assert_allclose(gained, force.sum(axis=0), rtol=0, atol=50 * n * EPS)  # a fit of up to degree 9, undone


@pytest.mark.parametrize("turn", [1e-9, 1e-3, 1.0, 3.0])
@pytest.mark.parametrize("name", ["taylor2", "taylor5", "taylor10"])
def test_series_are_long_enough_for_unsteady_rates(name, turn):
    """A step about one axis has a closed form: cos and sin of half the sum of its increments."""
    n = FITTED_METHODS[name].samples_per_step
    shares = 1 + 0.2 * np.sin(np.arange(n))
    angle = np.zeros((n, 3))
    angle[:, 1] = turn * shares / shares.sum()
    rotation, _ = one_step(name, angle, angle)
    half = angle[:, 1].sum() / 2
    # Terms of the series grow to the exponential of half the turn of half a step before they fall.
    expected = [np.cos(half), 0, np.sin(half), 0]
    np.testing.assert_allclose(rotation, expected, rtol=0, atol=10 * EPS * np.exp(turn / 2))
