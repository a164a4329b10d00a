"""Motions over the ellipsoid and their errors: against closed forms, geometry, and integration without enclosures."""

from itertools import pairwise

import pytest

from balls import near
from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.enclosure import enclosed_states
from sinsref.equator import EquatorModel
from sinsref.equator_forced import solution
from sinsref.error_equations import Earth, force_at_displaced_position, ideal_rates, local_geometry
from sinsref.exact import ExactNumber
from sinsref.quaternion import dot
from sinsref.taylor import doubled, integrate
from sinsref.travel import Turning, acceleration, error_field, motion_rates

BITS = 256
SHARP = {"order": 40, "tolerance": 1e-45}
ERRORS = ("0.01", "-0.02", "0.03", "1", "1.57e-7", "-2e-7")


def initial(ar, *, speed="600", heading="pi/4", climb="0", height="10000", latitude="pi/4", errors=ERRORS):
    sine, cosine = ar.sin_cos(ar.number(heading))
    motion = [ar.number(speed) * cosine, ar.number(climb), ar.number(speed) * sine, ar.number(height)]
    zero = ar.number(0)
    return [*motion, ar.number(latitude), zero, *(ar.number(x) for x in errors), *[zero] * 6]


def travelled(ar, earth, turning, state, interval, count):
    return list(enclosed_states(ar, error_field(earth, turning), state, ar.number(interval), count, **SHARP))


def test_along_the_equator_of_a_sphere_it_is_the_closed_form():
    with BallArithmetic(BITS) as ar:
        state = initial(ar, heading="0", latitude="0")
        state[0], state[2] = ar.number(0), ar.number(600)
        sphere = Earth.krasovsky(ar, spherical=True)
        model = EquatorModel.at(ar, ExactNumber("600"), ExactNumber("10000"))
        states = travelled(ar, sphere, Turning(ar.number(0)), state, "300", 6)
        for k, found in enumerate(states):
            expected = solution(ar, model, [ar.number(x) for x in ERRORS], None, ar.number(300) * k)
            # Both are proved: they overlap, and each is known to more than 40 digits.
            assert all(x.overlaps(y) for x, y in zip(found[6:12], expected, strict=True))
            assert all(x.rad() < 1e-40 for x in found)
            assert found[5].overlaps(ar.number(600) * 300 * k / model.radius)
            assert [float(x) for x in found[:5]] == [0, 0, 600, 10000, 0]


#: The last column: how the velocity turns, and along a geodesic or not.
TRACKS = {
    "parallel": ({"heading": "pi/2"}, "0", False),
    "meridian": ({"heading": "0"}, "0", False),
    "great_circle": ({}, "0", True),
    "climbing_turn": ({"climb": "20"}, "1/300", False),
}


@pytest.mark.parametrize("track", TRACKS)
def test_enclosures_agree_with_the_integration_of_two_separate_computers(track):
    """True and displaced state are integrated in mpmath from the ideal equations and the true force, without balls.

    The steps are 60 and 30 s: with rates below 1/150 1/s terms of order 34 are below 0.4^34 / 34!, 1e-52.
    """
    start, rate, along_geodesic = TRACKS[track]
    with MpArithmetic(60) as ar:
        earth, turning = Earth.krasovsky(ar), Turning(ar.number(rate), along_geodesic)

        def field(series, _, state):
            true, displaced = state[:6], state[6:]
            force = motion_rates(series, earth, turning, true)[1]
            resolved = force_at_displaced_position(series, true, displaced, force)
            return [*ideal_rates(series, earth, true, force), *ideal_rates(series, earth, displaced, resolved)]

        state = initial(ar, **start)
        pair = [*state[:6], *(x + e for x, e in zip(state[:6], state[6:12], strict=True))]
        plain, difference = doubled(ar, field, pair, ar.number(0), ar.number(60), steps=1, order=34)
        assert difference < 1e-38
        true = [str(x) for x in plain[:6]]
        errors = [str(y - x) for x, y in zip(plain[:6], plain[6:], strict=True)]
    with BallArithmetic(BITS) as ar:
        earth, turning = Earth.krasovsky(ar), Turning(ar.number(rate), along_geodesic)
        found = travelled(ar, earth, turning, initial(ar, **start), "60", 1)[1]
        assert near(found[:6], [ar.number(x) for x in true])
        assert near([x + y for x, y in zip(found[6:12], found[12:], strict=True)], [ar.number(x) for x in errors])


def test_a_great_circle_keeps_clairauts_constant():
    """R_1 cos(phi) sin(heading) is constant along a geodesic of the ellipsoid; north speed is lost at the apex."""
    with BallArithmetic(BITS) as ar:
        earth = Earth.krasovsky(ar)
        start = initial(ar, speed="2000", height="0", heading="1.4", latitude="0.6")[:6]

        def along(turning):
            def field(series, state):
                return motion_rates(series, earth, turning, state)[0]

            return list(enclosed_states(ar, field, start, ar.number(300), 6, **SHARP))

        def clairaut(motion):
            at = local_geometry(ar, earth, motion)
            return at.prime_vertical * at.cos_latitude * motion[2]

        constant = clairaut(start)
        states = along(Turning(ar.number(0), True))
        for found in states:
            assert clairaut(found).overlaps(constant)
            assert abs(clairaut(found) / constant - 1) < 1e-40
            assert (found[0] * found[0] + found[2] * found[2]).overlaps(ar.number(2000) ** 2)
        latitudes = [float(found[4]) for found in states]
        assert latitudes != sorted(latitudes)  # it has passed the northernmost point
        # On the same ellipsoid with a heading that stays, it is no geodesic.
        rhumb = along(Turning(ar.number(0)))[-1]
        assert not clairaut(rhumb).overlaps(constant)


def test_a_great_circle_of_a_sphere_is_plane_and_returns():
    """On a sphere the positions stay in the plane of start and velocity, and after 2 pi R / V it is back."""
    with MpArithmetic(50) as ar:
        earth, zero = Earth.krasovsky(ar, spherical=True), ar.number(0)
        turning = Turning(zero, True)
        start = initial(ar, heading="0.7", latitude="0.5", height="0")[:6]
        speed = ar.number(600)
        period = 2 * ar.pi * earth.semi_major_axis / speed

        def field(series, _, state):
            return motion_rates(series, earth, turning, state)[0]

        def place(state):
            (sp, cp), (sl, cl) = ar.sin_cos(state[4]), ar.sin_cos(state[5])
            north = [cp, -sp * cl, -sp * sl]
            return [sp, cp * cl, cp * sl], [
                (n * state[0] + e * state[2]) / speed for n, e in zip(north, [zero, -sl, cl], strict=True)
            ]

        # Steps of 1/64 of a turn at a colatitude of at least 0.9: 0.11^30 is 1e-29, and a step is shorter than that.
        position, direction = place(start)
        quarter = integrate(ar, field, start, zero, period / 4, steps=16, order=34)
        assert all(abs(x - y) < 1e-28 for x, y in zip(place(quarter)[0], direction, strict=True))
        end = integrate(ar, field, start, zero, period, steps=64, order=34)
        expected = [*start[:5], start[5] + 2 * ar.pi]
        assert all(abs(x - y) < 1e-24 for x, y in zip(end, expected, strict=True))
        assert all(abs(x - y) < 1e-26 for x, y in zip(place(end)[0], position, strict=True))


def test_the_error_of_the_linear_theory_is_quadratic():
    """Errors of ratio 1 : 2 : 4 leave it in the ratio 1 : 4 : 16, up to the cubic terms: relative 1e-3 at 1e-5 rad."""
    with BallArithmetic(BITS) as ar:
        earth = Earth.krasovsky(ar)
        ends = []
        for scale in (1, 2, 4):
            errors = [f"{x}*{scale}" for x in ERRORS]
            ends.append(travelled(ar, earth, Turning(ar.number(0), True), initial(ar, errors=errors), "300", 1)[1])
        for smaller, larger in pairwise(ends):
            assert all(abs(y / x - 2) < 1e-40 for x, y in zip(smaller[6:12], larger[6:12], strict=True))
            assert all(abs(y / x - 4) < 4e-3 for x, y in zip(smaller[12:], larger[12:], strict=True))
            assert all(abs(x) > 0 for x in smaller[12:])


def test_the_force_of_a_motion_makes_it():
    ar = MpArithmetic(50)
    earth = Earth.krasovsky(ar)
    state = [ar.number(x) for x in ("210", "-40", "330", "7000", "0.7", "1.1")]
    for turning in (Turning(ar.number("0.01")), Turning(ar.number("0.01"), True), Turning(ar.number(0))):
        rates, force = motion_rates(ar, earth, turning, state)
        assert all(abs(x - y) < 1e-45 for x, y in zip(rates, ideal_rates(ar, earth, state, force), strict=True))
        change = acceleration(ar, earth, turning, state)
        assert rates[:3] == change
        assert abs(dot(change, [state[0], ar.number(0), state[2]])) < 1e-45  # the horizontal speed is constant
        at = local_geometry(ar, earth, state)
        rate = turning.rate + turning.along_geodesic * (at.up - at.earth_up)
        assert abs(change[2] - rate * state[0]) < 1e-45
