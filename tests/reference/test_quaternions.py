"""Quaternions, dual quaternions, rotation vectors."""

from fractions import Fraction

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.dual_quaternion import (
    apparent_velocity,
    dual_part,
    from_dual_rotation_vector,
    from_rotation_vector,
    to_dual_rotation_vector,
    to_rotation_vector,
)
from sinsref.quaternion import conjugate, cross, dot, normalised, product, rotate
from sinsref.series import SeriesArithmetic

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=60)
AR = MpArithmetic(60)
CLOSE = AR.number("1e-55")  # 60 digits, components up to 10, some ten operations
integers = st.integers(-50, 50)
components = st.floats(-2, 2, allow_subnormal=False)
integer_quaternions = st.tuples(*[integers] * 4)
quaternions = st.tuples(*[components] * 4).map(lambda q: [AR.number(x) for x in q])
vectors = st.tuples(*[components] * 3).map(lambda v: [AR.number(x) for x in v])
units = quaternions.filter(lambda q: dot(q, q) > 0.01).map(lambda q: normalised(AR, q))


def near(a, b, tolerance=CLOSE):
    return all(abs(x - y) <= tolerance for x, y in zip(a, b, strict=True))


def plus(a, b):
    return [x + y for x, y in zip(a, b, strict=True)]


@deterministic
@given(integer_quaternions, integer_quaternions, integer_quaternions)
def test_the_product_is_hamiltons(a, b, c):
    assert product(product(a, b), c) == product(a, product(b, c))
    assert product(a, plus(b, c)) == plus(product(a, b), product(a, c))
    assert conjugate(product(a, b)) == product(conjugate(b), conjugate(a))
    assert dot(product(a, b), product(a, b)) == dot(a, a) * dot(b, b)
    assert product(a, conjugate(a)) == [dot(a, a), 0, 0, 0]
    # The scalar-vector form {a0 b0 - a.b, a0 b + b0 a + a x b}.
    scalar = a[0] * b[0] - dot(a[1:], b[1:])
    vector = plus(plus([a[0] * x for x in b[1:]], [b[0] * x for x in a[1:]]), cross(a[1:], b[1:]))
    assert product(a, b) == [scalar, *vector]


def test_the_basis_multiplies_as_hamilton_carved_it():
    one, i, j, k = ([int(n == m) for m in range(4)] for n in range(4))
    minus = [-1, 0, 0, 0]
    assert product(i, j) == k
    assert product(j, k) == i
    assert product(k, i) == j
    assert product(i, i) == product(j, j) == product(k, k) == product(product(i, j), k) == minus
    assert product(one, i) == i


@deterministic
@given(units, units, vectors, vectors)
def test_rotations_compose_and_keep_lengths_and_orientation(a, b, v, w):
    assert near(rotate(product(a, b), v), rotate(a, rotate(b, v)))
    assert near(rotate(conjugate(a), rotate(a, v)), v)
    assert abs(dot(rotate(a, v), rotate(a, w)) - dot(v, w)) < CLOSE
    assert near(cross(rotate(a, v), rotate(a, w)), rotate(a, cross(v, w)))


def test_a_quarter_turn_about_the_third_axis_takes_the_first_to_the_second():
    quarter = from_rotation_vector(AR, [AR.number(0), AR.number(0), AR.pi / 2])
    assert near(rotate(quarter, [AR.number(x) for x in (1, 0, 0)]), [0, 1, 0])


# Lengths from 1e-30 to nearly pi, where the scalar part vanishes.
lengths = st.one_of(
    st.integers(-30, -1).map(lambda n: AR.number(10) ** n),
    st.floats(1e-6, 3.14159).map(AR.number),
    st.integers(3, 25).map(lambda n: AR.pi - AR.number(10) ** -n),
)


def vector_of(direction, length):
    norm = AR.sqrt(dot(direction, direction))
    assume(norm > 0.01)
    return [x / norm * length for x in direction]


@deterministic
@given(vectors, lengths)
def test_the_rotation_vector_comes_back(direction, length):
    phi = vector_of(direction, length)
    unit = from_rotation_vector(AR, phi)
    assert abs(dot(unit, unit) - 1) < CLOSE
    sine, cosine = AR.sin_cos(length / 2)
    assert near(unit, [cosine, *(sine * x / length for x in phi)])
    for sign in (1, -1):  # both quaternions of a rotation
        found = to_rotation_vector(AR, [sign * x for x in unit])
        assert near(found, phi, 100 * CLOSE * length)


@deterministic
@given(vectors, lengths, vectors)
def test_the_dual_rotation_vector_comes_back(direction, length, phi_dual):
    phi = vector_of(direction, length)
    back = to_dual_rotation_vector(AR, *from_dual_rotation_vector(AR, phi, phi_dual))
    assert near(back[0], phi, 100 * CLOSE * length)
    assert near(back[1], phi_dual, 1000 * CLOSE)


def test_the_zero_vector_is_the_identity():
    zero, dual = [AR.number(0)] * 3, [AR.number(x) for x in (1, 2, 3)]
    unit, moment = from_dual_rotation_vector(AR, zero, dual)
    assert unit == [1, 0, 0, 0]
    assert near(moment, [0, *(x / 2 for x in dual)])
    back = to_dual_rotation_vector(AR, unit, moment)
    assert near([*back[0], *back[1]], [*zero, *dual])


def equation_1_12(phi, phi_dual, sign):
    """mu written out (Lebedev, Panov 1989, eq. (1.12)); the printed sign of its last term is -1."""
    n = AR.sqrt(dot(phi, phi))
    sine, cosine = AR.sin_cos(n / 2)
    d = dot(phi, phi_dual)
    last = (cosine / 2 - sine / n) / (n * n) * d * sign
    return [-(sine / n * d / 2), *(sine / n * y + last * x for x, y in zip(phi, phi_dual, strict=True))]


@deterministic
@given(vectors, st.floats(0.05, 3.1), vectors)
@example([AR.number(1)] * 3, 1.0, [AR.number(x) for x in (1, 2, -1)])
def test_equation_1_12_holds_with_the_corrected_sign_and_not_with_the_printed_one(direction, length, phi_dual):
    phi = vector_of(direction, AR.number(length))
    unit, moment = from_dual_rotation_vector(AR, phi, phi_dual)
    assert near(moment, equation_1_12(phi, phi_dual, 1), 1e5 * CLOSE)  # the closed form divides by n^3
    printed = equation_1_12(phi, phi_dual, -1)
    difference = max(abs(x - y) for x, y in zip(moment, printed, strict=True))
    # Twice the last term, (1/12) |phi . phi0| |phi_i| at small angles; not less than 1/20 of that up to pi.
    reach = abs(dot(phi, phi_dual)) * max(map(abs, phi))
    assert difference > reach / 240 or reach < CLOSE
    # Norm and Pluecker condition, whose signs are printed reversed.
    assert abs(dot(unit, unit) - 1) < CLOSE
    assert abs(dot(unit, moment)) < 100 * CLOSE
    if abs(moment[0]) > 0.01:
        assert abs(unit[0] * moment[0] - dot(unit[1:], moment[1:])) > 0.001 * abs(moment[0] * unit[0])


def test_the_small_angle_series_of_the_last_term():
    """(cos(n/2)/2 - sin(n/2)/n)/n^2 = -1/24 + n^2/960 - n^4/107520 + n^6/23224320 - ..."""
    coefficients = [Fraction(-1, 24), Fraction(1, 960), Fraction(-1, 107520), Fraction(1, 23224320)]
    for exponent in (-3, -8, -20, -30):
        n = AR.number(10) ** exponent
        # phi = (n, 0, 0), phi0 = (1, 0, 0): mu_1 = sin(n/2)/n + the term times n^2.
        _, moment = from_dual_rotation_vector(AR, [n, n * 0, n * 0], [AR.number(x) for x in (1, 0, 0)])
        sine, _ = AR.sin_cos(n / 2)
        term = (moment[1] - sine / n) / (n * n)
        series = sum(c.numerator * n ** (2 * k) / c.denominator for k, c in enumerate(coefficients))
        # The next term, and the cancellation of the difference on the left.
        assert abs(term - series) < n**8 / 10**9 + CLOSE / (n * n)


@deterministic
@given(vectors, lengths, vectors)
def test_the_dual_part_is_the_derivative(direction, length, phi_dual):
    phi = vector_of(direction, length)
    _, moment = from_dual_rotation_vector(AR, phi, phi_dual)
    fine = MpArithmetic(150)
    step = fine.number("1e-45")

    def displaced(sign):
        return from_rotation_vector(
            fine, [fine.number(0) + x + sign * step * y for x, y in zip(phi, phi_dual, strict=True)]
        )

    slope = [(x - y) / (2 * step) for x, y in zip(displaced(1), displaced(-1), strict=True)]
    assert near(moment, slope)


@deterministic
@given(units, vectors)
def test_apparent_velocity_and_its_inverse(unit, velocity):
    moment = dual_part(unit, velocity)
    inertial, body = apparent_velocity(unit, moment)
    assert near(inertial, velocity)
    assert near(body, rotate(conjugate(unit), velocity))
    # M = Lambda o W_E / 2 too, and the dual quaternion keeps the Pluecker condition.
    assert near(moment, [x / 2 for x in product(unit, [AR.number(0), *body])])
    assert abs(dot(unit, moment)) < CLOSE


@deterministic
@given(units, vectors, vectors, vectors)
def test_dual_quaternions_compose_as_rotations_and_velocities_do(unit, velocity, phi, phi_dual):
    """(2.6): W_I grows by the increment of velocity turned to inertial axes with the attitude before the step."""
    step, step_dual = from_dual_rotation_vector(AR, phi, phi_dual)
    moment = dual_part(unit, velocity)
    after = product(unit, step)
    after_dual = plus(product(unit, step_dual), product(moment, step))
    inertial, body = apparent_velocity(after, after_dual)
    change, change_body = apparent_velocity(step, step_dual)
    assert near(inertial, plus(velocity, rotate(unit, change)))
    before = rotate(conjugate(unit), velocity)
    assert near(body, plus(rotate(conjugate(step), before), change_body))


@pytest.mark.parametrize("length", ["1e-25", "1e-3", "0.4", "0.6", "2", "3.14159265358979323846"])
def test_balls_enclose_at_any_precision(length):
    def values(ar):
        phi = [ar.number(length) * ar.number(x) for x in ("2/7", "-3/7", "6/7")]
        unit = from_rotation_vector(ar, phi)
        return [*unit, *to_rotation_vector(ar, unit)]

    with BallArithmetic(90) as coarse:
        low = values(coarse)
    with BallArithmetic(500) as fine:
        high = values(fine)
        phi = [fine.number(length) * fine.number(x) for x in ("2/7", "-3/7", "6/7")]
    assert all(x.overlaps(y) for x, y in zip(low, high, strict=True))
    assert all(x.overlaps(y) for x, y in zip(high[4:], phi, strict=True))
    assert max(float(x.rad()) for x in low) < 1e-23  # 90 bits are 27 digits
    assert max(float(x.rad()) for x in high) < 1e-145


def test_formulas_accept_series():
    """A rotation about a fixed axis at a constant rate: 2 Lambda' = Lambda o omega holds term by term."""
    series = SeriesArithmetic(AR)
    rate = [AR.number(x) for x in ("0.3", "-0.4", "1.2")]
    unit = from_rotation_vector(series, [series.variable(x, x) for x in rate])  # at t = 1 + s
    derivative = product(unit, [series.constant(x) for x in (AR.number(0), *rate)])
    for k in range(12):
        assert near([2 * (k + 1) * q[k + 1] for q in unit], [q[k] for q in derivative])
