"""The published rotation-vector methods: coefficients, orders, check values.

Orders are those of one step in 200 digits, at intervals where the next power of the interval is seven digits away.
On regular precession each step repeats the last one, turned about the axis of precession: of the error of a step, the
component along that axis adds up, and the others come round again.
"""

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import factorial, prod

import mpmath
import numpy as np
import pytest

from sinsbench.instrumentation import rebuilt_kernels
from sinsbench.subjects.integrators import INTEGRATORS
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.rotation_vector_methods import (
    COSINE_SERIES,
    DUAL_SERIES,
    METHODS,
    SINE_SERIES,
    VELOCITY_RULES,
    binary64_coefficients,
)
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

KERNELS = rebuilt_kernels()
MP = mpmath.MPContext()
MP.dps = 200
ALL_METHODS = PUBLISHED_METHODS | METHODS
every_method = pytest.mark.parametrize("method", ALL_METHODS.values(), ids=ALL_METHODS)


class Precession:
    """Dual regular precession of rate 1 rad/s: Lebedev, Panov 1989, eqs. (4.3)-(4.7)."""

    def __init__(self, eps, theta, nu0=1.3, theta0=0.7):
        self.eps, self.theta, self.nu0, self.theta0 = map(MP.mpf, (eps, theta, nu0, theta0))

    def increments(self, start, end):
        """Integrals of angular rate and specific force."""
        s, c = MP.sin(self.theta), MP.cos(self.theta)
        cosine, sine = MP.cos(end) - MP.cos(start), MP.sin(end) - MP.sin(start)
        t_cosine, t_sine = end * MP.cos(end) - start * MP.cos(start), end * MP.sin(end) - start * MP.sin(start)
        eps, nu0, theta0, h = self.eps, self.nu0, self.theta0, end - start
        angle = (-eps * s * cosine, eps * s * sine, (1 + eps * c) * h)
        velocity = (
            eps * (nu0 * s * t_sine - theta0 * c * cosine),
            eps * (nu0 * s * t_cosine + theta0 * c * sine),
            (nu0 * (1 + eps * c) - eps * theta0 * s) * h,
        )
        return angle, velocity

    def state(self, t):
        """Attitude, inertial velocity and body velocity."""
        c, s = MP.cos(self.theta / 2), MP.sin(self.theta / 2)
        plus, minus, w = (1 + self.eps) * t / 2, (1 - self.eps) * t / 2, self.eps * t
        attitude = (c * MP.cos(plus), s * MP.cos(minus), -s * MP.sin(minus), c * MP.sin(plus))
        across = self.nu0 * t * MP.sin(self.theta)
        inertial = (
            across * MP.sin(w) + self.theta0 * MP.cos(w),
            -across * MP.cos(w) + self.theta0 * MP.sin(w),
            self.nu0 * t * (self.eps + MP.cos(self.theta)),
        )
        return attitude, inertial, KERNELS["body_velocity"](attitude, inertial)


def exact_coefficients(method):
    def numbers(fractions, size=0):
        values = tuple(MP.mpf(x.numerator) / x.denominator for x in fractions)
        return values + (MP.mpf(0),) * (size - len(values))

    rounded = binary64_coefficients(method)
    return rounded._replace(
        pair=numbers(method.pairs.values(), len(rounded.pair)),
        triple=numbers(method.triples.values(), len(rounded.triple)),
        quartic=numbers(method.quartics.values(), len(rounded.quartic)),
        cosine=numbers(COSINE_SERIES),
        sine=numbers(SINE_SERIES),
        dual=numbers(DUAL_SERIES),
        resolving=numbers(VELOCITY_RULES[method.velocity_rule]),
    )


def error_of_a_step(method, motion, interval, start):
    """Attitude error along the axis of precession, across it, and velocity errors in inertial and body axes."""
    end = start + method.samples_per_step * interval
    ends = [start + k * interval for k in range(-method.history, method.samples_per_step + 1)]
    samples = [motion.increments(*pair) for pair in pairwise(ends)]
    angle, velocity = zip(*samples, strict=True)
    computed = KERNELS["step"](motion.state(start), angle, velocity, exact_coefficients(method))
    true = motion.state(end)
    x, y, z = KERNELS["vector_part"](KERNELS["quaternion_product"](computed[0], KERNELS["conjugate"](true[0])))
    return z, MP.hypot(x, y), *(MP.norm([a - b for a, b in zip(computed[k], true[k], strict=True)]) for k in (1, 2))


def global_orders(method, motion):
    """Exponents of the errors of a step, less the one that the number of steps takes away."""
    start, interval = MP.mpf("0.3"), MP.mpf("1e-7")
    errors = [error_of_a_step(method, motion, h, start) for h in (interval, interval / 2)]
    return [float(MP.log(abs(coarse / fine), 2)) - 1 for coarse, fine in zip(*errors, strict=True)]


@pytest.mark.parametrize("eps", [-1, 0.5], ids=["coning", "general precession"])
@every_method
def test_orders(method, eps):
    along, across, *velocities = global_orders(method, Precession(eps, MP.pi / 18))
    # The next power of the interval changes the ratio of the errors by some 1e-6.
    tolerance = {"abs": 1e-4}
    assert along == pytest.approx(method.order_drift or method.order, **tolerance)
    assert min(along, across) == pytest.approx(method.order, **tolerance)
    assert velocities == pytest.approx([method.order_velocity or method.order] * 2, **tolerance)


@every_method
def test_orders_on_a_narrow_cone(method):
    """So narrow, 1e-30 rad, that the fourth power of the half-angle is nothing beside its square."""
    along, *_ = global_orders(method, Precession(-1, MP.mpf("1e-30")))
    expected = method.order_coning or method.order_drift or method.order
    assert along == pytest.approx(expected, abs=1e-4)


TERMS = 6  # powers x^3, x^5, ... x^13: one more than the highest order needs


def odd_series(terms):
    """Coefficients of x^3, x^5, ... of a sum of factor * sin(multiple * x)."""
    return [
        sum(factor * Fraction((-1) ** k * multiple ** (2 * k + 1), factorial(2 * k + 1)) for factor, multiple in terms)
        for k in range(1, TERMS + 1)
    ]


def coning_residual(method):
    """Drift that the pairs of a method leave in one step of coning, as coefficients of x^3, x^5, ...

    x is the angle of coning in a sample, and the square of the half-angle of the cone is taken out. The rotation
    vector needs (r x - sin r x)/2 along the axis, and p_i x p_j gives 2 sin(s x) - sin((s + 1) x) - sin((s - 1) x)
    there, where s = j - i: Ignagni 1996.
    """
    terms = [(Fraction(-1, 2), method.samples_per_step)]
    for (i, j), coefficient in method.pairs.items():
        terms += [(-2 * coefficient, j - i), (coefficient, j - i + 1), (coefficient, j - i - 1)]
    return odd_series(terms)


@pytest.mark.parametrize("name", PUBLISHED_METHODS)
def test_coning_is_annulled_up_to_the_order_exactly(name):
    method = PUBLISHED_METHODS[name]
    order = method.order_coning or method.order_drift or method.order
    vanishing = order // 2 - 1  # a step leaves x^(order + 1)
    residual = coning_residual(method)
    assert residual[:vanishing] == [0] * vanishing
    assert residual[vanishing] != 0


@pytest.mark.parametrize("name", ["two_sample", "savage3", "lee4", "park5"])
def test_drift_that_the_best_coefficients_leave(name):
    """Park, Kim, Lee, Chung 1999: N N! / (2^(N+1) 1 3 5 ... (2N+1)) times x^(2N+1) for N samples."""
    n = PUBLISHED_METHODS[name].samples_per_step
    expected = Fraction(n * factorial(n), 2 ** (n + 1) * prod(range(1, 2 * n + 2, 2)))
    assert abs(coning_residual(PUBLISHED_METHODS[name])[n - 1]) == expected


CHECK_VALUES = {
    # Drift in deg/h and inertial velocity error in m/s on coning, the same on general precession: variant 2 of Lebedev,
    # Panov 1989, 100 samples a second for 100 s, in fifty digits; for 3 samples a step the last one is left out.
    "two_sample": (9.9427e-3, 5.4782e-3, 5.1318e-3, 2.9309e-3),
    "miller3": (7.5794e-3, 4.2548e-3, 4.7617e-2, 2.6842e-2),
    "miller3_coning": (9.0991e-5, 1.1000e-4, 4.5745e-2, 2.5806e-2),
    "savage3": (9.2987e-5, 1.7817e-4, 4.5687e-2, 2.5540e-2),
    "lee4": (7.3615e-4, 9.1650e-4, 1.9399e-1, 1.0825e-1),
}


@cache
def paper_motion(motion):
    return sample(next(case for case in paper_cases("dual_precession") if case.name == f"variant2_{motion}"))


def attitude_error(computed, true):
    difference = [float(x) for x in KERNELS["quaternion_product"](computed, KERNELS["conjugate"](true))]
    return 2 * np.linalg.norm(difference[1:])


def end_errors(name, data):
    """Drift in deg/h, and inertial velocity error."""
    n = data.samples - data.samples % PUBLISHED_METHODS[name].samples_per_step
    inputs = data.first[:n], data.second[:n], data.interval, data.attitude[0], data.velocity_inertial[0]
    result = INTEGRATORS[name](*inputs)
    drift = np.degrees(attitude_error(result["attitude"][-1], data.attitude[n])) * 3600 / (n * data.interval)
    return drift, np.linalg.norm(result["velocity_inertial"][-1] - data.velocity_inertial[n])


@pytest.mark.parametrize("motion", ["coning", "general"])
@pytest.mark.parametrize("name", CHECK_VALUES)
def test_check_values(name, motion):
    expected = CHECK_VALUES[name][:2] if motion == "coning" else CHECK_VALUES[name][2:]
    # Five digits are tabulated: all of them.
    assert [f"{x:.4e}" for x in end_errors(name, paper_motion(motion))] == [f"{x:.4e}" for x in expected]


@pytest.mark.parametrize("name", [name for name, method in PUBLISHED_METHODS.items() if not method.order_coning])
def test_drift_on_coning_is_that_of_the_residual(name):
    """At 10 degrees, 1 Hz and 100 Hz: 12.86 deg/h for the plain exponential, 0.01015 deg/h for the 1/12 recursion."""
    method, data = PUBLISHED_METHODS[name], paper_motion("coning")
    x, half_angle, order = 2 * np.pi * data.interval, np.pi / 18, method.order_drift or method.order
    left = abs(float(coning_residual(method)[order // 2 - 1])) * x ** (order + 1) * np.sin(half_angle) ** 2
    expected = np.degrees(left) * 3600 / (method.samples_per_step * data.interval)
    # Neglected are the square of the half-angle, 3 %, and that of the angle of coning in a step, 6 %, with factors
    # below 1.
    assert end_errors(name, data)[0] == pytest.approx(expected, rel=0.05)


@pytest.fixture(scope="module")
def ladder():
    """General precession for six seconds, a whole number of its periods, at two intervals."""
    case = next(case for case in paper_cases("dual_precession") if case.name == "variant1_general")
    case = replace(case, duration=ExactNumber("6"))
    return [sample(case, Fraction(1, 2**k)) for k in (3, 4)]


@pytest.mark.parametrize("name", PUBLISHED_METHODS)
def test_observed_orders(ladder, name):
    method = PUBLISHED_METHODS[name]
    errors = []
    for data in ladder:
        result = INTEGRATORS[name](data.first, data.second, data.interval, data.attitude[0], data.velocity_inertial[0])
        true = [array[:: method.samples_per_step] for array in (data.attitude, data.velocity_inertial)]
        attitude = [attitude_error(*pair) for pair in zip(result["attitude"], true[0], strict=True)]
        velocity = np.linalg.norm(result["velocity_inertial"] - true[1], axis=1)
        errors.append([max(attitude), attitude[-1], velocity.max()])
    largest, drift, velocity = np.log2(errors[0]) - np.log2(errors[1])
    assert drift == pytest.approx(method.order_drift or method.order, abs=0.1)
    if method.history and method.samples_per_step > 1:  # the term of order 3 is small, and rises with finer intervals
        assert method.order < largest < method.order_drift
    else:
        assert largest == pytest.approx(method.order, abs=0.1)
        assert velocity == pytest.approx(method.order_velocity or method.order, abs=0.1)
