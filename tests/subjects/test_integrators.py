import os
import subprocess
import sys
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.instrumentation import rebuilt_kernels
from sinsbench.subjects.integrators import (
    INTEGRATORS,
    StreamingIntegrator,
    attitude_only,
    extrapolated_start,
    panov6,
)
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.rotation_vector_methods import (
    METHODS,
    PANOV_4,
    PANOV_6,
    RotationVectorMethod,
    binary64_coefficients,
)

EPS = np.finfo(float).eps
PLAIN = rebuilt_kernels()  # not compiled: any numbers, tuples of any length
MP = mpmath.MPContext()
MP.dps = 40

ALL_METHODS = PUBLISHED_METHODS | METHODS
METHOD_OF = {name: ALL_METHODS[name.removesuffix("_compensated")] for name in INTEGRATORS}
every_integrator = pytest.mark.parametrize("name", INTEGRATORS)
every_method = pytest.mark.parametrize("method", ALL_METHODS.values(), ids=ALL_METHODS)
compiling = settings(derandomize=True, deadline=None, max_examples=25)  # the first call compiles
component = st.floats(-1, 1).filter(lambda x: x == 0 or abs(x) > 1e-6)
vectors = st.tuples(component, component, component).map(np.array)
quaternions = (
    st.tuples(component, component, component, component)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


def multiply(a, b):
    """Hamilton product in whatever arithmetic the components have."""
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]


def conjugated(q):
    return [q[0], -q[1], -q[2], -q[3]]


def turn(q, v):
    return multiply(multiply(q, [0 * q[0], *v]), conjugated(q))[1:]


def random_inputs(seed, steps=50, scale=0.1, samples=4):
    random = np.random.default_rng(seed)
    attitude = random.normal(size=4)
    return (
        random.normal(scale=scale, size=(samples * steps, 3)),
        random.normal(scale=0.3, size=(samples * steps, 3)),
        0.01,
        attitude / np.linalg.norm(attitude),
        random.normal(scale=10, size=3),
    )


def precession(eps, samples, duration):
    """Increments and final state of dual regular precession in binary64, from 40 digits: eqs. (4.3)-(4.7)."""
    theta, nu0, theta0 = MP.pi / 18, MP.mpf(10), MP.mpf(100)
    eps, h, n = MP.mpf(eps), MP.mpf(duration) / samples, samples
    s, c = MP.sin(theta), MP.cos(theta)
    # About one turn a second, such that the constant third component of the rate has 20 bits: over intervals of
    # a power of two its increments are exact, and no rounding is repeated at every sample.
    nu = MP.mpf(round(float(2 * MP.pi * (1 + eps * c)) * 2**18)) / 2**18 / (1 + eps * c)
    times = [k * h for k in range(n + 1)]
    cosines, sines = zip(*(MP.cos_sin(nu * t) for t in times), strict=True)
    angle, velocity = np.empty((n, 3)), np.empty((n, 3))
    for k in range(n):
        dc, ds = cosines[k + 1] - cosines[k], sines[k + 1] - sines[k]
        dtc, dts = (times[k + 1] * f[k + 1] - times[k] * f[k] for f in (cosines, sines))
        angle[k] = -eps * s * dc, eps * s * ds, nu * (1 + eps * c) * h
        velocity[k] = (
            eps * (nu0 * s * dts - theta0 * c * dc),
            eps * (nu0 * s * dtc + theta0 * c * ds),
            (nu0 * (1 + eps * c) - eps * nu * theta0 * s) * h,
        )

    def state(t):
        plus, minus = (1 + eps) * nu * t / 2, (1 - eps) * nu * t / 2
        ch, sh = MP.cos(theta / 2), MP.sin(theta / 2)
        attitude = [ch * MP.cos(plus), sh * MP.cos(minus), -sh * MP.sin(minus), ch * MP.sin(plus)]
        w = eps * nu * t
        return attitude, [
            nu0 * t * s * MP.sin(w) + theta0 * MP.cos(w),
            -nu0 * t * s * MP.cos(w) + theta0 * MP.sin(w),
            nu0 * t * (eps + c),
        ]

    return angle, velocity, state(MP.mpf(0)), state(times[-1])


def end_errors(integrate, motion):
    angle, velocity, (attitude0, velocity0), (attitude, inertial) = motion
    result = integrate(angle, velocity, 1.0, [float(x) for x in attitude0], [float(x) for x in velocity0])
    error = multiply([MP.mpf(x) for x in result["attitude"][-1]], conjugated(attitude))[1:]
    body = turn(conjugated(attitude), inertial)
    return [
        2 * float(MP.norm(error)),
        float(MP.norm([MP.mpf(x) - y for x, y in zip(result["velocity_inertial"][-1], inertial, strict=True)])),
        float(MP.norm([MP.mpf(x) - y for x, y in zip(result["velocity_body"][-1], body, strict=True)])),
    ]


@pytest.fixture(scope="module", params=[-1, 0.5], ids=["coning", "general precession"])
def ladder(request):
    return [precession(request.param, 8 * 2**k, 8) for k in range(4, 11)]


@pytest.mark.parametrize("name", [f"{method}{suffix}" for method in METHODS for suffix in ("", "_compensated")])
def test_orders_are_2_4_6(ladder, name):
    order = METHOD_OF[name].order
    # Six intervals of seven: at the shortest, order 6 is at the floor of binary64 (1e-14 rad); at the longest,
    # orders 2 and 4 are not asymptotic yet, the step being a quarter of a turn.
    motions = ladder[:6] if order == 6 else ladder[1:]
    errors = np.array([end_errors(INTEGRATORS[name], motion) for motion in motions])
    slopes = np.polyfit(np.arange(6), -np.log2(errors), 1)[0]
    np.testing.assert_allclose(slopes, order, rtol=0, atol=0.03)


@every_integrator
@compiling
@given(
    rate=vectors,
    force=vectors,
    attitude0=quaternions,
    velocity0=vectors,
    size=st.sampled_from([1e-6, 0.1, 1.3]),
)
def test_constant_rate_and_force_are_integrated_exactly(name, rate, force, attitude0, velocity0, size):
    """A screw motion, in closed form: Lambda = Lambda0 o exp(omega t/2), W_I' = Lambda o a o conj(Lambda)."""
    samples = 3 * METHOD_OF[name].samples_per_step
    angle, velocity = np.tile(size * rate, (samples, 1)), np.tile(force, (samples, 1))
    result = INTEGRATORS[name](angle, velocity, 0.01, attitude0, velocity0)
    total = [samples * MP.mpf(x) for x in angle[0]]
    n = MP.norm(total)
    rotation = [MP.cos(n / 2), *(MP.sinc(n / 2) / 2 * x for x in total)]
    q0 = [MP.mpf(x) for x in attitude0]
    a = [samples * MP.mpf(x) for x in velocity[0]]
    cross1 = [
        total[1] * a[2] - total[2] * a[1],
        total[2] * a[0] - total[0] * a[2],
        total[0] * a[1] - total[1] * a[0],
    ]
    along = [sum(x * y for x, y in zip(total, a, strict=True)) * x / n**2 if n else a[i] for i, x in enumerate(total)]
    first = (1 - MP.cos(n)) / n**2 if n else MP.mpf(0)
    second = MP.sin(n) / n if n else MP.mpf(0)
    gained = [u + second * (v - u) + first * w for u, v, w in zip(along, a, cross1, strict=True)]
    inertial = [MP.mpf(w) + x for w, x in zip(velocity0, turn(q0, gained), strict=True)]
    # 3 steps of some 60 roundings; velocities are of the size of 15 |a| + |W| < 28 m/s.
    np.testing.assert_allclose(result["attitude"][-1], np.array(multiply(q0, rotation), float), rtol=0, atol=30 * EPS)
    if METHOD_OF[name].velocity_rule == "transfer":
        expected = np.array(inertial, float)
        np.testing.assert_allclose(result["velocity_inertial"][-1], expected, rtol=0, atol=28 * 40 * EPS)


@every_integrator
@compiling
@given(seed=st.integers(0, 2**32), scale=st.sampled_from([1e-3, 0.1, 1.0]))
def test_norm_is_kept_and_both_velocities_are_one_vector(name, seed, scale):
    inputs = random_inputs(seed, scale=scale, samples=METHOD_OF[name].samples_per_step)
    result = INTEGRATORS[name](*inputs)
    # 50 steps of a product with relative error below 4 eps.
    np.testing.assert_allclose(np.linalg.norm(result["attitude"], axis=1), 1, rtol=200 * EPS)
    body = np.array(turn(conjugated(result["attitude"].T), result["velocity_inertial"].T)).T
    size = np.abs(result["velocity_inertial"]).max()
    np.testing.assert_allclose(result["velocity_body"], body, rtol=0, atol=1000 * EPS * size)


@every_integrator
@compiling
@given(seed=st.integers(0, 2**32), frame=quaternions)
def test_turning_a_frame_turns_the_result(name, seed, frame):
    samples = METHOD_OF[name].samples_per_step
    angle, velocity, interval, attitude0, velocity0 = random_inputs(seed, samples=samples)
    plain = INTEGRATORS[name](angle, velocity, interval, attitude0, velocity0)
    size = np.abs(plain["velocity_inertial"]).max()
    tolerance = {"rtol": 0, "atol": 1000 * EPS}  # 50 steps, some 20 roundings each

    other = INTEGRATORS[name](
        angle, velocity, interval, np.array(multiply(frame, attitude0)), np.array(turn(frame, velocity0))
    )
    np.testing.assert_allclose(other["attitude"], np.array(multiply(frame, plain["attitude"].T)).T, **tolerance)
    expected = np.array(turn(frame, plain["velocity_inertial"].T)).T
    np.testing.assert_allclose(other["velocity_inertial"] / size, expected / size, **tolerance)
    np.testing.assert_allclose(other["velocity_body"] / size, plain["velocity_body"] / size, **tolerance)

    turned = (np.array(turn(conjugated(frame), array.T)).T for array in (angle, velocity))
    other = INTEGRATORS[name](*turned, interval, np.array(multiply(attitude0, frame)), velocity0)
    np.testing.assert_allclose(other["attitude"], np.array(multiply(plain["attitude"].T, frame)).T, **tolerance)
    expected = np.array(turn(conjugated(frame), plain["velocity_body"].T)).T
    np.testing.assert_allclose(other["velocity_body"] / size, expected / size, **tolerance)
    np.testing.assert_allclose(other["velocity_inertial"] / size, plain["velocity_inertial"] / size, **tolerance)


@every_method
@compiling
@given(seed=st.integers(0, 2**32))
def test_dual_part_is_the_derivative(method, seed):
    """The complex step: no difference is formed, so nothing cancels and the step can be as small as 1e-30."""
    angle, velocity, *_ = random_inputs(seed, steps=1, scale=0.5, samples=method.window)
    coefficients = binary64_coefficients(method)
    complex_angle = tuple(map(tuple, (angle + 1e-30j * velocity).tolist()))
    derivative = [x.imag / 1e-30 for x in PLAIN["rotation_vector"](complex_angle, coefficients)]
    p, b = (tuple(map(tuple, array.tolist())) for array in (angle, velocity))
    dual = PLAIN["rotation_vector_dual"](p, b, coefficients)
    np.testing.assert_allclose(dual, derivative, rtol=0, atol=300 * EPS)


@compiling
@given(seed=st.integers(0, 2**32))
def test_order_6_is_the_printed_formula(seed):
    """Lebedev, Panov 1989, eqs. (2.2) and (2.5), written out as printed."""
    angle, velocity, *_ = random_inputs(seed, steps=1, scale=0.5)
    (p1, p2, p3, p4), (b1, b2, b3, b4) = angle, velocity
    x = np.cross
    phi = (
        angle.sum(axis=0)
        + 2 / 3 * x(p1 + p2, p3 + p4)
        + 32 / 15 * (x(p1, p3) + x(p2, p4))
        - 8 / 9 * x(p1 + p2, p3 + p4)
        + 32 / 45 * (x(p1, x(p2, p4)) - x(p4, x(p1, p3)))
        - 64 / 45 * (1 - p2 @ p3) * x(p2, p3)
    )
    outer = x(b1 + b2, p3 + p4) + x(p1 + p2, b3 + b4)
    dual = (
        velocity.sum(axis=0)
        + 2 / 3 * outer
        + 32 / 15 * (x(b1, p3) + x(p1, b3) + x(b2, p4) + x(p2, b4))
        - 8 / 9 * outer
        + 32 / 45 * (x(b1, x(p2, p4)) - x(b4, x(p1, p3)))
        + 32 / 45 * (x(x(p4, b2) + x(b4, p2), p1) - x(x(p3, b1) + x(b3, p1), p4))
        - 64 / 45 * ((1 - p2 @ p3) * (x(b2, p3) + x(p2, b3)) - (p2 @ b3 + b2 @ p3) * x(p2, p3))
    )
    p, b = (tuple(map(tuple, array.tolist())) for array in (angle, velocity))
    coefficients = binary64_coefficients(PANOV_6)
    np.testing.assert_allclose(PLAIN["rotation_vector"](p, coefficients), phi, rtol=0, atol=100 * EPS)
    np.testing.assert_allclose(PLAIN["rotation_vector_dual"](p, b, coefficients), dual, rtol=0, atol=300 * EPS)


@every_integrator
def test_streaming_is_the_batch_bit_for_bit(name):
    method = METHOD_OF[name]
    r = method.samples_per_step
    angle, velocity, interval, attitude0, velocity0 = random_inputs(7, samples=r)
    angle[40:60] *= 20  # closed forms too
    batch = INTEGRATORS[name](angle, velocity, interval, attitude0, velocity0)
    before = tuple(extrapolated_start(array, method.history) for array in (angle, velocity))
    stream = StreamingIntegrator(method, attitude0, velocity0, name.endswith("compensated"), before)
    states = [stream.state]
    states += [stream.update(angle[k : k + r], velocity[k : k + r]) for k in range(0, len(angle), r)]
    for field, column in batch.items():
        np.testing.assert_array_equal([getattr(state, field) for state in states], column)


@every_method
def test_attitude_alone_is_the_full_attitude_bit_for_bit(method):
    inputs = random_inputs(8, samples=method.samples_per_step)
    full, alone = INTEGRATORS[method.name](*inputs), attitude_only(method)(*inputs)
    assert list(alone) == ["attitude"]
    np.testing.assert_array_equal(alone["attitude"], full["attitude"])


def test_another_number_of_samples_a_step():
    """On samples merged by twos, order 4 is the two-sample coning correction p1 + p2 + (2/3) p1 x p2."""
    angle, velocity, _, attitude0, velocity0 = random_inputs(9)
    merged = [array.reshape(-1, 2, 3).sum(axis=1) for array in (angle, velocity)]
    two = INTEGRATORS["two_sample"](*merged, 0.01, attitude0, velocity0)
    four = INTEGRATORS["panov4"](angle, velocity, 0.01, attitude0, velocity0)
    np.testing.assert_allclose(two["attitude"], four["attitude"], rtol=0, atol=200 * EPS)


def test_more_samples_than_any_built_in_method_looks_at():
    """Split into thirds, the two samples of order 4 are six: kernels are compiled for longer steps on demand."""
    pairs = {(i, j): Fraction(2, 3) for i in (1, 2, 3) for j in (4, 5, 6)}
    six = attitude_only(RotationVectorMethod("six", 4, 6, pairs, {}, {}, "test"))
    angle, velocity, *rest = random_inputs(9, samples=6)
    merged = [array.reshape(-1, 3, 3).sum(axis=1) for array in (angle, velocity)]
    two = INTEGRATORS["two_sample"](*merged, *rest)
    np.testing.assert_allclose(six(angle, velocity, *rest)["attitude"], two["attitude"], rtol=0, atol=200 * EPS)


def test_result_starts_with_the_initial_state():
    inputs = random_inputs(10)
    result = panov6(*inputs)
    assert {name: array.shape for name, array in result.items()} == {
        "attitude": (51, 4),
        "velocity_inertial": (51, 3),
        "velocity_body": (51, 3),
    }
    np.testing.assert_array_equal(result["attitude"][0], inputs[3])
    np.testing.assert_array_equal(result["velocity_inertial"][0], inputs[4])
    assert panov6(np.empty((0, 3)), np.empty((0, 3)), *inputs[2:])["attitude"].shape == (1, 4)


@pytest.mark.parametrize(
    ("position", "value", "message"),
    [
        (0, np.zeros((7, 3)), "velocity has shape 8 x 3, expected 7 x 3"),
        (0, np.zeros((8, 4)), "angle has shape 8 x 4, expected n x 3"),
        (0, np.zeros(3), "angle has shape 3, expected n x 3"),
        (0, np.full((8, 3), np.nan), "angle has values that are not finite"),
        (1, np.full((8, 3), np.inf), "velocity has values that are not finite"),
        (2, 0.0, "interval is 0.0"),
        (2, np.nan, "interval is nan"),
        (3, np.zeros(3), "attitude0 has shape 3, expected 4"),
        (4, 0.0, "velocity0 has shape"),
    ],
)
def test_bad_input_is_refused(position, value, message):
    inputs = [np.zeros((8, 3)), np.zeros((8, 3)), 0.01, np.array([1.0, 0, 0, 0]), np.zeros(3)]
    inputs[position] = value
    with pytest.raises(ValueError, match=message):
        panov6(*inputs)


def test_incomplete_steps_are_refused():
    with pytest.raises(ValueError, match="angle has 7 samples, expected a multiple of 4"):
        panov6(np.zeros((7, 3)), np.zeros((7, 3)), 0.01, [1.0, 0, 0, 0], np.zeros(3))
    stream = StreamingIntegrator(PANOV_4, [1.0, 0, 0, 0], np.zeros(3))
    with pytest.raises(ValueError, match="angle has shape 3 x 3, expected 4 x 3"):
        stream.update(np.zeros((3, 3)), np.zeros((4, 3)))


def test_integrators_say_what_they_are():
    for name, integrate in INTEGRATORS.items():
        assert integrate.__name__ == name
        assert "(n, 3)" in integrate.__doc__
        assert ("Kahan" in integrate.__doc__) == name.endswith("compensated")


def run_python(code, **environment):
    completed = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert completed.returncode == 0, completed.stderr
    return completed.stdout


def test_import_does_not_import_the_compiler():
    code = "import sys; from sinsbench.subjects import integrators; print('numba' in sys.modules)"
    assert run_python(code).strip() == "False"


def test_without_a_place_for_the_cache_it_still_runs():
    code = "from sinsbench.subjects.kernels import cross; print(cross((1., 0., 0.), (0., 1., 0.)))"
    assert run_python(code, NUMBA_CACHE_DIR=f"{os.devnull}/nowhere").strip() == "(0.0, 0.0, 1.0)"
