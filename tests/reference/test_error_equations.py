"""The linear error equations against the nonlinear ones they come from."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.equator import EquatorModel
from sinsref.equator_forced import Misalignment, solution
from sinsref.error_equations import (
    Earth,
    attitude_rate,
    error_matrix,
    force_at_displaced_position,
    geographic_attitude,
    geographic_force,
    ideal_rates,
    local_geometry,
    required_force,
)
from sinsref.exact import ExactNumber
from sinsref.quaternion import conjugate, product, rotate
from sinsref.series import SeriesArithmetic
from sinsref.taylor import integrate

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=25)
AR = MpArithmetic(60)
S = SeriesArithmetic(AR)
EARTH = Earth.krasovsky(AR)
numbers = st.tuples(
    *[st.floats(-1000, 1000)] * 3, st.floats(-1e4, 1e6), st.floats(-1.4, 1.4), st.floats(-4, 4),
    *[st.floats(-20, 20)] * 3,
)  # fmt: skip


def motion(values):
    state = [AR.number(x) for x in values[:6]]
    return state, required_force(AR, EARTH, state, [AR.number(x) for x in values[6:]])


def constant(earth):
    return Earth(*(S.constant(getattr(earth, name)) for name in Earth.__dataclass_fields__))


def jacobian(state, force):
    """The derivatives of the ideal equations with the force resolved at the displaced position, by dual numbers."""
    columns = []
    for j in range(6):
        true = [S.constant(x) for x in state]
        displaced = [S.variable(x, int(i == j)) for i, x in enumerate(state)]
        resolved = force_at_displaced_position(S, true, displaced, [S.constant(x) for x in force])
        columns.append([rate[1] for rate in ideal_rates(S, constant(EARTH), displaced, resolved)])
    return [list(row) for row in zip(*columns, strict=True)]


#: Units in which the elements are of one size: errors of velocity m/s, of position in radians or metres.
UNITS = (1, 1, 1, 1000, 1, 1)


def disagreeing_elements(matrix, expected):
    """Row and column of the elements that differ by more than 50 digits of the row's largest element."""
    places = []
    for i, (row, other) in enumerate(zip(matrix, expected, strict=True)):
        scale = max([AR.number("1e-9"), *(abs(x * u) for x, u in zip(other, UNITS, strict=True))])
        pairs = zip(row, other, UNITS, strict=True)
        places += [(i, j) for j, (x, y, u) in enumerate(pairs) if abs(x - y) * u > AR.number("1e-50") * scale]
    return places


@deterministic
@given(numbers)
def test_the_printed_matrix_is_the_jacobian_of_the_ideal_equations(values):
    state, force = motion(values)
    assert disagreeing_elements(error_matrix(AR, EARTH, state, force), jacobian(state, force)) == []


def test_the_jacobian_check_sees_a_defect_in_any_element():
    values = (210.0, -40.0, 330.0, 7000.0, 0.7, 1.1, 3.0, -2.0, 5.0)
    state, force = motion(values)
    matrix, expected = error_matrix(AR, EARTH, state, force), jacobian(state, force)
    for i in range(6):
        for j in range(6):
            kept = matrix[i][j]
            # Relative 1e-6 of the element; an element that is zero gets the same part of a tiny rate.
            matrix[i][j] = kept * (1 + AR.number("1e-6")) if kept else AR.number("1e-20")
            assert disagreeing_elements(matrix, expected) == [(i, j)]
            matrix[i][j] = kept


def test_elements_that_are_zero_for_every_motion():
    state, force = motion((210.0, -40.0, 330.0, 7000.0, 0.7, 1.1, 3.0, -2.0, 5.0))
    matrix = error_matrix(AR, EARTH, state, force)
    zeros = {(i + 1, j + 1) for i in range(6) for j in range(6) if not matrix[i][j]}
    assert zeros == {(2, 2), (4, 1), (4, 3), (4, 4), (4, 6), (5, 2), (5, 3), (5, 6), (6, 1), (6, 2), (6, 6)}


@deterministic
@given(st.floats(-9000, 9000), st.floats(-1e4, 1e6), st.floats(-3, 3))
def test_on_the_equator_of_a_sphere_it_is_the_matrix_of_the_closed_form(v_east, height, longitude):
    sphere = Earth.krasovsky(AR, spherical=True)
    zero = AR.number(0)
    state = [zero, zero, AR.number(v_east), AR.number(height), zero, AR.number(longitude)]
    force = required_force(AR, sphere, state, [zero] * 3)
    model = EquatorModel.at(AR, ExactNumber(v_east), ExactNumber(height))
    assert abs(force[1] - model.specific_force) < 1e-50
    expected = model.matrix(AR)
    assert disagreeing_elements(error_matrix(AR, sphere, state, force), expected) == []
    # On the ellipsoid one element differs: a_51 = 1/R_2 with R_2 = R (1 - e^2).
    force = required_force(AR, EARTH, state, [zero] * 3)
    matrix = error_matrix(AR, EARTH, state, force)
    assert disagreeing_elements(matrix, expected) == [(4, 0)]
    assert abs(matrix[4][0] * model.radius * (1 - AR.number("0.006692")) - 1) < 1e-50


def test_constants_of_the_earth_are_those_of_the_paper():
    printed = ("7.29e-5", "6378245", "0.006692", "9.78049", "5.317e-3")
    names = ("rotation_rate", "semi_major_axis", "eccentricity_squared", "equatorial_gravity", "gravity_flattening")
    assert [getattr(EARTH, name) for name in names] == [AR.number(x) for x in printed]
    sphere = Earth.krasovsky(AR, spherical=True)
    assert sphere.eccentricity_squared == sphere.gravity_flattening == 0


@deterministic
@given(numbers)
def test_the_force_that_a_motion_requires_produces_it(values):
    state, force = motion(values)
    rates = ideal_rates(AR, EARTH, state, force)
    assert all(abs(x - y) < 1e-50 for x, y in zip(rates[:3], values[6:], strict=True))


@settings(deterministic, max_examples=10)
@given(numbers)
def test_the_ideal_equations_are_newtons_on_a_sphere(values):
    """In inertial axes d^2 r/dt^2 = f + gravitation: the equations in rotating axes must say the same.

    On a sphere without flattening the position is (a + H) (sin phi, cos phi cos l, cos phi sin l), l the inertial
    longitude. The gravity of the paper holds the centrifugal acceleration: gravitation is -g up + u x (u x r).
    """
    earth = Earth.krasovsky(AR, spherical=True)
    state = [AR.number(x) for x in values[:6]]
    force = [AR.number(x) for x in values[6:]]
    series = SeriesArithmetic(AR)
    constants = Earth(*(series.constant(getattr(earth, name)) for name in Earth.__dataclass_fields__))
    unknowns = [series.unknown(x) for x in state]
    rates = ideal_rates(series, constants, unknowns, [series.constant(x) for x in force])
    for unknown, rate in zip(unknowns, rates, strict=True):
        series.define(unknown, rate)
    *_, height, latitude, longitude = unknowns
    inertial = longitude + series.variable(AR.number(0)) * earth.rotation_rate
    (sp, cp), (sl, cl) = series.sin_cos(latitude), series.sin_cos(inertial)
    distance = height + earth.semi_major_axis
    position = [distance * sp, distance * cp * cl, distance * cp * sl]
    up = [x[0] / distance[0] for x in position]
    resolved = rotate(geographic_attitude(AR, state[4], state[5]), force)
    gravity = local_geometry(AR, earth, state).gravity
    for axis, (x, f, n) in enumerate(zip(position, resolved, up, strict=True)):
        turning = earth.rotation_rate**2 * x[0] if axis else 0
        assert abs(2 * x[2] - (f - gravity * n - turning)) < 1e-45


@deterministic
@given(st.floats(-1.4, 1.4), st.floats(-4, 4))
def test_the_geographic_attitude_takes_north_up_east_to_inertial_axes(latitude, longitude):
    (sp, cp), (sl, cl) = AR.sin_cos(AR.number(latitude)), AR.sin_cos(AR.number(longitude))
    attitude = geographic_attitude(AR, AR.number(latitude), AR.number(longitude))
    axes = {(1, 0, 0): (cp, -sp * cl, -sp * sl), (0, 1, 0): (sp, cp * cl, cp * sl), (0, 0, 1): (0, -sl, cl)}
    for unit, expected in axes.items():
        found = rotate(attitude, [AR.number(x) for x in unit])
        assert all(abs(x - y) < 1e-55 for x, y in zip(found, expected, strict=True))


def ideal_field(ar, earth, frame_rate, spin, start, force):
    """The equations of an instrument on board: its gyros and accelerometers read what the true motion makes.

    The true motion is steady flight along the equator; the body turns against Z' at the constant rate `spin`
    (in body axes) from the quaternion `start`.
    """

    def field(series, t, y):
        rate = series.constant(ar.sqrt(sum(x * x for x in spin)))
        sine, cosine = series.sin_cos(rate * t / 2)
        turn = [cosine, *(sine * x / rate for x in spin)]
        kappa = product([series.constant(x) for x in start], turn)
        to_body = conjugate(kappa)
        constants = Earth(*(series.constant(getattr(earth, name)) for name in Earth.__dataclass_fields__))
        gyros = [x + y for x, y in zip(rotate(to_body, [series.constant(x) for x in frame_rate]), spin, strict=True)]
        accelerometers = rotate(to_body, [series.constant(x) for x in force])
        state, attitude = y[:6], y[6:]
        return [
            *ideal_rates(series, constants, state, geographic_force(attitude, accelerometers)),
            *attitude_rate(series, constants, state, attitude, gyros),
        ]

    return field


INITIAL = ("0.01", "-0.02", "0.03", "1", "1e-6", "-2e-6")
KAPPA_ERROR = ("3e-6", "1e-6", "-2e-6", "4e-6")


@pytest.mark.parametrize(("v_east", "height"), [("600", "10000"), ("-464.9740605", "0"), ("7700", "0")])
def test_end_to_end_from_the_nonlinear_equations(v_east, height):
    """Two instruments fly together, one with small errors: their difference is the closed form.

    The ideal equations in quaternion form are integrated twice, with errors of 1e-30 times the given ones and of both
    signs: the difference quotient is the linear answer to 60 digits. The closed form gets the initial errors, and as
    misalignment what kappa and position together make of the orientation in the inertial frame.
    """
    with BallArithmetic(400) as ar:
        sphere = Earth.krasovsky(ar, spherical=True)
        zero, time, small = ar.number(0), ar.number(900), ar.number("1e-30")
        longitude = ar.number("0.4")
        true = [zero, zero, ar.number(v_east), ar.number(height), zero, longitude]
        force = required_force(ar, sphere, true, [zero] * 3)
        at = local_geometry(ar, sphere, true)
        start = [ar.number(x) for x in ("0.5", "-0.1", "0.7", "0.5")]  # of norm 1
        spin = [ar.number(x) for x in ("1e-3", "-2e-3", "5e-4")]
        field = ideal_field(ar, sphere, [at.north, at.up, at.east], spin, start, force)
        initial, kappa_error = ([ar.number(x) for x in given] for given in (INITIAL, KAPPA_ERROR))

        def perturbed(sign):
            return [x + e * small * sign for x, e in zip([*true, *start], [*initial, *kappa_error], strict=True)]

        def quotient(function):
            return [(x - y) / (2 * small) for x, y in zip(function(1), function(-1), strict=True)]

        # Steps of 150 s at rates below 1/200 s: 0.75^36/36! is 1e-46.
        found = quotient(lambda sign: integrate(ar, field, perturbed(sign), zero, time, steps=6, order=36))[:6]

        def rows_of_c_lambda(sign):  # row m is axis m of the body in inertial axes
            displaced = perturbed(sign)
            whole = product(geographic_attitude(ar, displaced[4], displaced[5]), displaced[6:])
            return [x for m in range(3) for x in rotate(whole, [ar.number(int(i == m)) for i in range(3)])]

        change, exact = quotient(rows_of_c_lambda), rows_of_c_lambda(0)
        tilt = [[sum(change[3 * m + i] * exact[3 * m + j] for m in range(3)) for j in range(3)] for i in range(3)]
        model = EquatorModel.at(ar, ExactNumber(v_east), ExactNumber(height))
        expected = solution(ar, model, initial, Misalignment(tilt, longitude), time)
        speed = ar.sqrt(model.gravity * model.radius)
        units = [speed, speed, speed, model.radius, 1, 1]
        size = max(abs(y) / unit for y, unit in zip(expected, units, strict=True))
        assert max(abs(x - y) / unit for x, y, unit in zip(found, expected, units, strict=True)) < 1e-40 * size
        # Antisymmetric but for the norm of the quaternion: twice kappa . dkappa on the diagonal.
        stretch = 2 * sum(x * e for x, e in zip(start, kappa_error, strict=True))
        assert all(abs(tilt[i][j] + tilt[j][i] - 2 * stretch * (i == j)) < 1e-40 for i in range(3) for j in range(3))
        assert abs(tilt[2][1]) > 1e-7
