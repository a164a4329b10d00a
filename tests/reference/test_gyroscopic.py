"""Motions over the sphere: fixtures, the definition in ball arithmetic, and the proved integrals."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, sqrt

import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.elementary import angle
from sinsref.enclosure import EnclosureError
from sinsref.exact import ExactNumber, ExpressionError
from sinsref.expansion import tabulated
from sinsref.gyroscopic import Kinematics, Motion, half_turn, literal_sensors
from sinsref.pi_monomials import PiMonomialArithmetic
from sinsref.profiles import Profile
from sinsref.quaternion import dot, rotate

BITS = 200
ZERO = Profile(0)
#: The motions of the paper's claims: kind, latitude, longitude, speed, course.
GIVEN = {
    "T0": ("parallel", "11*pi/36", "pi/6", "0", "0"),
    "T1": ("great_circle", "pi/4", "pi/6", "300", "pi/3"),
    "T2": ("parallel", "11*pi/36", "pi/6", "250", "0"),
    "T3": ("track", "5*pi/18 + pi/120*sin(2*pi*t/3000)", "pi/6 + pi/90000*t + pi/180*sin(2*pi*t/4500)", "0", "0"),
    "T4": ("great_circle", "pi/4", "pi/6", "300 + 100*sin(2*pi*t/1800)", "pi/3"),
}
#: time: latitude, longitude (deg), speed, a_X, Omega_xi, a_xi, attitude: independently computed, all digits as given.
FIXTURES = {
    ("T0", 3600): (
        "55.000000000000 45.041066876065 266.472511703 3.967838486405 8.035881554475 3.962154645402",
        "4.629075072124e-04 -6.177608556301e-04 -2.007763875606e-03 -1.132126232622 0.988205160705 9.682951244305",
        "0.694936383978 -0.470262811702 -0.094545096896 -0.535702841888",
    ),
    ("T1", 0): (
        "45.000000000000 30.000000000000 300.000000000 3.463364285946 6.926728571893 5.998722908379",
        "1.036328531944e-03 6.207324799286e-04 -1.983526629497e-03 -0.977732089617 0.341871054536 9.740959991724",
        "0.873985133968 -0.402634127462 0.138424868601 -0.234252643012",
    ),
    ("T1", 7200): (
        "51.668857177875 57.671176658627 300.000000000 5.133716109052 7.684268896703 3.249016443813",
        "-6.569168904431e-04 -1.381222268418e-03 -2.070943788191e-03 -0.292510463072 0.743200807490 9.763259066833",
        "0.367267907280 -0.469422053851 -0.322970763065 -0.735151076885",
    ),
    ("T2", 7200): (
        "55.000000000000 88.304682449424 516.472511703 5.551358438572 8.035881554475 0.164306393466",
        "-6.775123865777e-04 -1.406749804561e-03 -2.012458272409e-03 -0.312251429039 0.685069711647 9.739258082485",
        "0.455792051183 -0.640815438314 -0.233691225541 -0.571837032031",
    ),
    ("T3", 3600): (
        "51.426584774443 51.290010359770 470.795163199 5.223564948985 7.234266375113 4.046572567557",
        "4.326568430851e-04 -6.364821276399e-04 -1.978521384982e-03 -0.489772860984 1.208504490076 9.710542196446",
        "0.696051439988 -0.486264554994 -0.034434550232 -0.527137019377",
    ),
    ("T3", 7200): (
        "50.881677878439 73.894348499838 453.114291885 6.262432993904 7.329985411079 1.684332685282",
        "-7.089645083616e-04 -1.371350276679e-03 -2.063666537862e-03 -0.264074468787 1.162679013855 9.714019348867",
        "0.405872550834 -0.569431482045 -0.262898770530 -0.664755215241",
    ),
    ("T4", 3600): (
        "49.166975948395 42.911802707601 300.000000000 4.537454558950 7.491740182748 4.400718071512",
        "4.643278057413e-04 -6.352053140268e-04 -2.014619634363e-03 -1.288798241350 1.289817598638 9.631010021831",
        "0.690454549697 -0.437527104414 -0.071072668950 -0.571656560738",
    ),
    ("T4", 7200): (
        "51.668857177875 57.671176658627 300.000000000 5.281374006455 7.718567816342 2.934584102346",
        "-6.569168904431e-04 -1.381222268418e-03 -2.070943788191e-03 -0.634993384969 0.808923189494 9.747995232858",
        "0.367267907280 -0.469422053851 -0.322970763065 -0.735151076885",
    ),
}


def motion(name: str, **changes: Profile | ExactNumber) -> Motion:
    kind, latitude, longitude, speed, course = GIVEN[name]
    made = Motion(
        kind,
        Profile(latitude),
        Profile(longitude),
        Profile(speed),
        ExactNumber(course),
        ZERO,
        Profile("2*pi/9 + pi/10800*t + pi/9*sin(2*pi*t/1200)"),
        Profile("pi/90 + pi/45*sin(2*pi*t/500)"),
        Profile("2*pi/45*sin(2*pi*t/700 + 1) - pi/180"),
        ExactNumber("6371000"),
        ExactNumber("9.81"),
        ExactNumber("7.292115e-5"),
    )
    return replace(made, **changes)


ALTITUDE = {"altitude": Profile("5000 - 5000*cos(2*pi*t/3600)")}
MOTIONS = {**{name: motion(name) for name in GIVEN}, "T3_altitude": motion("T3", **ALTITUDE),
           "T4_altitude": motion("T4", **ALTITUDE)}  # fmt: skip


def printed(value: arb, text: str) -> bool:
    """Whether a ball rounds to a printed decimal: half a unit of its last digit."""
    mantissa, _, exponent = text.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return bool(abs(value - arb(text)) <= 0.5 * unit * (1 + 1e-9))


@pytest.mark.parametrize(("name", "time"), FIXTURES)
def test_the_fixtures_are_reproduced_to_all_digits(name: str, time: int) -> None:
    with BallArithmetic(BITS) as ar:
        kinematics, t = Kinematics(ar, MOTIONS[name]), ar.number(time)
        place = kinematics.place(t)
        degrees = [x * 180 / ar.pi for x in kinematics.coordinates(place, t)]
        found = [*degrees, kinematics.speed(place), *kinematics.force_x(t), *kinematics.sensors(place, t)]
        texts = " ".join(FIXTURES[name, time]).split()
        for value, text in zip([*found, *kinematics.attitude(place, t)], texts, strict=True):
            assert printed(value, text)


@pytest.mark.parametrize("name", MOTIONS)
def test_closed_forms_are_the_definition(name: str) -> None:
    """Rates and force resolved in local axes, and derivatives of attitude and position in X: balls of 1e-50."""
    with BallArithmetic(BITS) as ar:
        for time in ("0", "1234.5", "5000"):
            t = ar.number(time)
            kinematics = Kinematics(ar, MOTIONS[name])
            closed = kinematics.sensors(kinematics.place(t), t)
            for x, y in zip(closed, literal_sensors(ar, MOTIONS[name], t), strict=True):
                assert (x - y).contains(0)
                assert (x - y).rad() < 1e-50


@pytest.mark.parametrize("name", MOTIONS)
def test_trihedron_and_attitude_in_x(name: str) -> None:
    with BallArithmetic(BITS) as ar:
        kinematics, t = Kinematics(ar, MOTIONS[name]), ar.number(2500)
        place = kinematics.place(t)
        trihedron, zero, one = kinematics.darboux(place), ar.number(0), ar.number(1)
        moving = rotate(trihedron, [kinematics.speed(place), zero, place.radius[1]])
        for x, y in (
            *zip(rotate(trihedron, [zero, zero, one]), place.vertical, strict=True),
            *zip(moving, place.from_local(place.velocity), strict=True),
            *zip(rotate(place.axes, [zero, zero, one]), place.vertical, strict=True),
            (dot(kinematics.attitude(place, t), kinematics.attitude(place, t)), one),
        ):
            assert (x - y).contains(0)
            assert (x - y).rad() < 1e-45


def test_a_great_circle_goes_on_through_whole_turns() -> None:
    """After half a turn the latitude is the opposite one, the longitude half a turn on; after three and a half too."""
    fast = motion("T1", speed=Profile("7000"))
    with BallArithmetic(BITS) as ar:
        kinematics = Kinematics(ar, fast)
        for turns in (0, 1, 3):
            half = ar.pi * kinematics.radius * (2 * turns + 1) / 7000
            latitude, longitude = kinematics.coordinates(kinematics.place(half), half)
            assert abs(latitude + ar.pi / 4) < 1e-50
            assert abs(longitude - ar.pi / 6 - ar.pi * (2 * turns + 1)) < 1e-50


@pytest.mark.parametrize("course", ["0", "pi", "pi/2", "-pi/2", "3"])
def test_great_circles_of_special_courses_are_the_definition(course: str) -> None:
    special = motion("T4", course=ExactNumber(course), latitude=Profile("0.2"))
    with BallArithmetic(BITS) as ar:
        kinematics, t = Kinematics(ar, special), ar.number(700)
        closed = kinematics.sensors(kinematics.place(t), t)
        for x, y in zip(closed, literal_sensors(ar, special, t), strict=True):
            assert (x - y).contains(0)
            assert (x - y).rad() < 1e-45


def test_increments_are_integrals_of_the_sensors() -> None:
    """Proved integrals over 10 s, and Gauss-Legendre quadrature in mpmath: 30 digits."""
    t3 = MOTIONS["T3"]

    def sensors(ar: BallArithmetic, time: arb) -> list[arb]:
        kinematics = Kinematics(ar, t3)
        return kinematics.sensors(kinematics.place(time), time)

    with BallArithmetic(BITS) as balls:
        rows = list(tabulated(balls, sensors, balls.number(10), 100, 103, order=30, tolerance=1e-40))
        assert len(rows) == 4
        for epoch, (values, _) in enumerate(rows, start=100):
            for x, y in zip(values, sensors(balls, balls.number(10 * epoch)), strict=True):
                assert (x - y).contains(0)
                assert (x - y).rad() < 1e-38
        integrals = [x.mid().str(40, radius=False) for x in rows[-1][1]]
    ar = MpArithmetic(45)
    kinematics = Kinematics(ar, t3)
    known: dict[object, list[object]] = {}

    def component(time: object, number: int) -> object:
        if time not in known:
            known[time] = kinematics.sensors(kinematics.place(time), time)
        return known[time][number]

    for number, text in enumerate(integrals):
        value = ar.context.quad(lambda t, n=number: component(t, n), [1000, 1030], method="gauss-legendre", maxdegree=4)
        assert abs(value - ar.context.mpf(text)) < 1e-32 * max(1, abs(value))


def test_a_narrow_passage_is_taken_in_short_pieces() -> None:
    """Over a long piece the divisor may be zero for all that balls know; it never is."""
    with BallArithmetic(BITS) as balls:
        narrow = [1 / ((t - arb("2.5")) ** 2 + arb("0.01")) for t in map(arb, range(5))]
        rows = list(
            tabulated(
                balls,
                lambda ar, t: [1 / ((t - arb("2.5")) * (t - arb("2.5")) + arb("0.01"))],
                arb(1),
                0,
                4,
                order=20,
                tolerance=1e-30,
            )
        )
        area = ((arb("1.5") * 10).atan() + (arb("2.5") * 10).atan()) * 10
        for ((value,), _), exact in zip(rows, narrow, strict=True):
            assert value.overlaps(exact)
            assert value.rad() < 1e-27
        assert rows[-1][1][0].overlaps(area)
        assert rows[-1][1][0].rad() < 1e-26


def test_a_pole_of_a_function_is_not_passed() -> None:
    with BallArithmetic(64) as balls, pytest.raises(EnclosureError, match="no expansion beyond"):
        list(tabulated(balls, lambda ar, t: [1 / (t - arb(2.5))], arb(1), 0, 4, order=10, tolerance=1e-12))


@given(st.floats(-3.1, 3.1))
@settings(derandomize=True, deadline=None)
def test_angles_and_half_turns(value: float) -> None:
    with BallArithmetic(BITS) as ar:
        exact = ar.number(value)
        sine, cosine = ar.sin_cos(exact)
        assert abs(angle(ar, sine, cosine) - exact) < 1e-55
        for x, y in zip(half_turn(ar, sine, cosine), reversed(ar.sin_cos(exact / 2)), strict=True):
            assert abs(x - y) < 1e-50


def test_an_angle_of_exactly_nothing_is_exactly_zero() -> None:
    with PiMonomialArithmetic(BITS) as ar:
        assert ar.sign(angle(ar, ar.number(0), ar.number(1))) == 0


TERMS = st.tuples(st.floats(-5, 5), st.floats(0.001, 2), st.floats(-3, 3))


@given(st.floats(-9, 9), st.floats(-1, 1), TERMS, TERMS, st.floats(0, 50))
@settings(derandomize=True, deadline=None, max_examples=25)
def test_derivatives_and_integral_of_a_profile(
    level: float, slope: float, first: tuple[float, float, float], second: tuple[float, float, float], time: float
) -> None:
    (a, w, p), (b, u, s) = first, second
    profile = Profile(
        f"{level:f} + {slope:f}*t/2 - t*t*{slope:f} + {a:f}*sin({w:f}*t + {p:f}) - cos({s:f} - {u:f}*t)*{b:f}"
    )
    ar = MpArithmetic(40)
    terms, t = profile.terms(ar), ar.number(time)
    jet = terms.jet(ar, t)
    for order in (1, 2):
        numeric = ar.context.diff(lambda x: terms.jet(ar, x)[0], t, order)
        assert abs(jet[order] - numeric) < 1e-15 * (1 + abs(numeric))
    assert abs(ar.context.diff(lambda x: terms.integral(ar, x), t) - jet[0]) < 1e-15 * (1 + abs(jet[0]))
    assert terms.integral(ar, ar.number(0)) == 0
    level, slope, a, w, p, b, u, s = (float(f"{x:f}") for x in (level, slope, a, w, p, b, u, s))
    plain = level + slope * time / 2 - time * time * slope + a * sin(w * time + p) - cos(s - u * time) * b
    assert float(jet[0]) == pytest.approx(plain, abs=1e-11)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t*sin(t)", "a product of two functions of time"),
        ("1/t", "a function of time cannot be a divisor"),
        ("sin(t*t)", "must be linear in time"),
        ("sin(t + sin(t))", "must be linear in time"),
        ("sqrt(t)", "where a constant must"),
        ("sin(0*t)", "0 times the time"),
        ("1/0 + t", "no finite real value"),
        ("sqrt(-1)*t", "no finite real value"),
        ("t + x", "outside the grammar"),
        ("", "an expression has 1 to 200 characters"),
    ],
)
def test_what_is_no_profile_is_refused(text: str, message: str) -> None:
    with pytest.raises(ExpressionError, match=message):
        Profile(text)


def test_a_constant_profile_knows_its_value() -> None:
    assert Profile("pi/6").constant == ExactNumber("pi/6")
    assert Profile(0.5).constant == ExactNumber(0.5)
    assert Profile("t").constant is None
    assert Profile("t") == Profile(Profile("t"))


def test_the_sphere_at_rest_feels_its_attraction() -> None:
    """A vehicle at rest on the rotating Earth, in plain floats: attraction less what its circle needs."""
    rate, radius, latitude = 7.292115e-5, 6371000.0, radians(55)
    vertical, level = 9.81 - rate**2 * radius * cos(latitude) ** 2, rate**2 * radius * cos(latitude) * sin(latitude)
    with BallArithmetic(BITS) as ar:
        force = [float(x) for x in Kinematics(ar, MOTIONS["T0"]).force_x(ar.number(100))]
    assert sqrt(sum(x * x for x in force)) == pytest.approx(sqrt(vertical**2 + level**2), rel=1e-14)
    assert pi * 55 / 180 == latitude
