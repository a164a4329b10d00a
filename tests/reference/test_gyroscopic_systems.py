"""Exact motions put into the equations of gyroscopic systems, and the proved solutions that are not the vertical.

What is left of an equation is a ball; that it contains zero and is narrow is the statement, and that another law leaves
a ball without zero shows that the statement says something.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from math import floor, log10

import pytest
from flint import arb

from gyroscopic_figures import METHODICAL
from sinsref.arithmetic import BallArithmetic, MpArithmetic, Number
from sinsref.enclosure import EnclosureError
from sinsref.exact import ExactNumber
from sinsref.gyroscopic import Kinematics, Motion, Place
from sinsref.gyroscopic_systems import (
    axis_rate,
    bisector,
    compass_rates,
    enclosed_axes,
    equilibrium_tilt,
    exact_tilt,
    full_acceleration,
    paper_tilt,
    self_tuned_rates,
    start,
    tilted,
    usual_tuning,
)
from sinsref.profiles import Profile
from sinsref.quaternion import conjugate, cross, dot, product, rotate
from sinsref.series import Series, SeriesArithmetic
from sinsref.taylor import doubled

BITS = 200
HEADING = [Profile("2*pi/9 + pi/10800*t + pi/9*sin(2*pi*t/1200)"), Profile("0"), Profile("0")]
CONSTANTS = [ExactNumber("6371000"), ExactNumber("9.81"), ExactNumber("7.292115e-5")]


def made(kind: str, latitude: str, longitude: str, speed: str = "0", course: str = "0", altitude: str = "0") -> Motion:
    places = [Profile(latitude), Profile(longitude), Profile(speed)]
    return Motion(kind, *places, ExactNumber(course), Profile(altitude), *HEADING, *CONSTANTS)


TRACK = ("5*pi/18 + pi/120*sin(2*pi*t/3000)", "pi/6 + pi/90000*t + pi/180*sin(2*pi*t/4500)")
MOTIONS = {
    "T1": made("great_circle", "pi/4", "pi/6", "300", "pi/3"),
    "T2": made("parallel", "11*pi/36", "pi/6", "250"),
    "T3": made("track", *TRACK),
    "T4": made("great_circle", "pi/4", "pi/6", "300 + 100*sin(2*pi*t/1800)", "pi/3"),
    "T5": made("track", "pi/180 + 0.05*(t - 1800)/6371000", "pi/6 + 0.1*(t - 1800)*(t - 1800)/6371000"),
}
HIGH = made("track", *TRACK, altitude="5000 - 5000*cos(2*pi*t/3600)")
TIMES = (0, 1799, 5000)


class Instant:
    """A motion near a time, as Taylor series: place, Darboux trihedron, specific force in X."""

    def __init__(self, balls: BallArithmetic, motion: Motion, time: int) -> None:
        self.ar = SeriesArithmetic(balls)
        self.kinematics = Kinematics(self.ar, motion)
        t = self.ar.variable(balls.number(time))
        self.place: Place = self.kinematics.place(t)
        self.quaternion = self.kinematics.darboux(self.place)
        zero, one = self.ar.number(0), self.ar.number(1)
        units = ([one, zero, zero], [zero, one, zero], [zero, zero, one])
        self.axes = [rotate(self.quaternion, unit) for unit in units]
        self.speed = self.kinematics.speed(self.place)
        self.force = self.kinematics.force_x(t)
        self.scale, self.kappa = usual_tuning(self.ar, motion)

    @property
    def turn(self) -> Number:
        """Rate of the trihedron about the vertical."""
        return dot(self.force, self.axes[1]) / self.speed


def vanishes(left: Sequence[Series], right: Sequence[Series], order: int = 1, width: float = 1e-30) -> bool:
    """Whether the derivatives of the left side, to an order, are the right side: narrow balls around zero."""
    factor = 1 if order == 1 else 2
    residuals = [x[order] * factor - y[0] for x, y in zip(left, right, strict=True)]
    assert all(x.rad() < width for x in residuals)
    return all(x.contains(0) for x in residuals)


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("name", MOTIONS)
def test_a_gyropendulum_of_varying_momentum_is_exact_for_any_motion(name: str, time: int) -> None:
    """(2.5) with H = m l sqrt(g R - v^2): sin(alpha) = -v/V; the paper's law with constant H is not."""
    with BallArithmetic(BITS) as balls:
        at = Instant(balls, MOTIONS[name], time)
        axis = tilted(at.axes, exact_tilt(at.ar, at.scale, at.speed))
        kappa = 1 / at.ar.sqrt(at.scale * at.scale - at.speed * at.speed)
        assert vanishes(axis, axis_rate(kappa, axis, at.force))
        assert not vanishes(axis, axis_rate(at.kappa, axis, at.force))
        law = tilted(at.axes, paper_tilt(at.ar, at.scale, at.speed))
        assert not vanishes(law, axis_rate(at.kappa, law, at.force))


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("name", MOTIONS)
def test_a_self_tuned_bi_gyro_is_exact_for_any_motion(name: str, time: int) -> None:
    with BallArithmetic(BITS) as balls:
        at = Instant(balls, MOTIONS[name], time)
        cosine, sine = exact_tilt(at.ar, at.scale, at.speed)
        axes = tilted(at.axes, (cosine, sine)), tilted(at.axes, (cosine, -sine))
        for axis, rate in zip(axes, self_tuned_rates(at.ar, at.scale, *axes, at.force), strict=True):
            assert vanishes(axis, rate)
        for x, y in zip(bisector(at.ar, *axes), at.axes[2], strict=True):
            assert (x[0] - y[0]).contains(0)
        length = at.ar.sqrt(dot(*[[x - y for x, y in zip(*axes, strict=True)]] * 2)) / 2
        assert abs(length[0] * at.scale[0] - at.speed[0]) < 1e-40


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("name", MOTIONS)
def test_the_gyrohorizoncompass_is_exact_for_any_motion(name: str, time: int) -> None:
    """(2.15): the Darboux quaternion and the speed; a force that is wrong by a part in 1e9 leaves a residual."""
    with BallArithmetic(BITS) as balls:
        at = Instant(balls, MOTIONS[name], time)
        state = [*at.quaternion, at.speed]
        radius, climb = at.place.radius[0] + at.ar.number(0), at.ar.number(0)
        assert vanishes(state, compass_rates(at.quaternion, at.speed, radius, climb, at.force))
        spoiled = [*at.force[:2], at.force[2] * (1 + 1e-9)]
        assert not vanishes(state, compass_rates(at.quaternion, at.speed, radius, climb, spoiled))


def test_the_gyrohorizoncompass_at_varying_altitude_needs_the_climb() -> None:
    with BallArithmetic(BITS) as balls:
        at = Instant(balls, HIGH, 700)
        state, (radius, climb, _) = [*at.quaternion, at.speed], at.place.radius
        assert vanishes(state, compass_rates(at.quaternion, at.speed, radius, climb, at.force))
        assert not vanishes(state, compass_rates(at.quaternion, at.speed, radius, climb * 0, at.force))
        sphere = at.kinematics.radius
        assert not vanishes(state, compass_rates(at.quaternion, at.speed, sphere, climb, at.force))


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("azimuth", ["0", "1"])
def test_the_full_equations_are_exact_for_any_motion(name: str, time: int, azimuth: str) -> None:
    """(3.1): the trihedron that does not turn about the vertical, z' = (r x r') o z / 2, from any azimuth."""
    with BallArithmetic(BITS) as balls:
        at = Instant(balls, MOTIONS[name], time)
        vertical = at.place.vertical
        sine, cosine = balls.sin_cos(balls.number(azimuth))
        value = product([x[0] for x in at.quaternion], [cosine, balls.number(0), balls.number(0), sine])
        r, v, a = ([x[k] * (1, 1, 2)[k] for x in vertical] for k in (0, 1, 2))
        zero = balls.number(0)
        rate = [x / 2 for x in product([zero, *cross(r, v)], value)]
        second = [x / 2 for x in product([zero, *cross(r, a)], value)]
        second = [x + y / 2 for x, y in zip(second, product([zero, *cross(r, v)], rate), strict=True)]
        force, radius = [x[0] for x in at.force], balls.number(6371000)
        found = full_acceleration(radius, value, rate, force)
        for x, y in zip(second, found, strict=True):
            assert (x - y).contains(0)
            assert (x - y).rad() < 1e-30
        # A component of the momentum along the vertical spoils it.
        spoiled = [x + y for x, y in zip(rate, product(value, [zero, zero, zero, balls.number("1e-6")]), strict=True)]
        worse = full_acceleration(radius, value, spoiled, force)
        assert not all((x - y).contains(0) for x, y in zip(second, worse, strict=True))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("name", "rests"), [("T1", True), ("T2", True), ("T3", False), ("T4", False)])
def test_a_gyropendulum_of_constant_momentum_rests_where_speed_and_turn_are_constant(
    name: str, rests: bool, sign: int
) -> None:
    with BallArithmetic(BITS) as balls:
        at = Instant(balls, MOTIONS[name], 1000)
        kappa, radius, gravity = at.kappa * sign, at.kinematics.radius, at.kinematics.gravity
        tilt = equilibrium_tilt(at.ar, kappa, at.speed, at.turn, radius, gravity)
        axis = tilted(at.axes, tilt)
        assert vanishes(axis, axis_rate(kappa, axis, at.force)) == rests
        assert tilt[0][0] > 0


def rounds_to(value: arb, figure: float, unit: float) -> bool:
    """Whether a ball rounds to a figure of given last digit; 0 stands for less than 1e-30."""
    return bool(abs(value - arb(figure)) < 0.5 * unit if figure else abs(value) < 1e-30)


@pytest.mark.parametrize("name", ["T1", "T2", "T3", "T4"])
def test_the_methodical_errors_of_constant_momentum(name: str) -> None:
    """Every figure computed by others, to the digits given: after 1 h and 2 h, from both starts."""
    rows = {row[1:3]: row[3:] for row in METHODICAL if row[0] == name and row[1] != "gf_linear"}
    assert len(rows) == 8
    with BallArithmetic(160) as ar:
        motion = MOTIONS[name]
        kinematics, (scale, _) = Kinematics(ar, motion), usual_tuning(ar, motion)
        every = enclosed_axes(ar, motion, ar.number(3600), 1, 2, order=34, tolerance=1e-36)
        for time, axes in zip((3600, 7200), every, strict=True):
            place = kinematics.place(ar.number(time))
            back, true_speed = conjugate(kinematics.darboux(place)), kinematics.speed(place)
            for rule, first, second in (("paper", axes[:3], axes[3:6]), ("equilibrium", axes[6:9], axes[9:])):
                difference = [x - y for x, y in zip(first, second, strict=True)]
                speed = scale * (ar.sqrt(dot(difference, difference)) / 2).asin() - true_speed
                for system, axis in (("gp", first), ("bg", bisector(ar, first, second))):
                    *components, metres, read_out = rows[f"{system}_{rule}", time]
                    *error, up = rotate(back, axis)
                    for value, figure in zip(error, components, strict=True):
                        # Ten significant digits.
                        assert rounds_to(value, figure, 10.0 ** (floor(log10(abs(figure))) - 9) if figure else 0)
                    if metres:
                        across = ar.sqrt(error[0] ** 2 + error[1] ** 2)
                        assert rounds_to(kinematics.radius * arb.atan2(across, up), metres, 1e-6)
                    if read_out is not None:
                        assert rounds_to(speed, read_out, 10.0 ** (floor(log10(abs(read_out))) - 6))


def test_proved_axes_and_plain_integration_agree() -> None:
    """Taylor series without enclosures, with half the step again, in mpmath: what balls prove to 1e-40."""
    motion, ar = MOTIONS["T3"], MpArithmetic(50)
    begin, (_, kappa) = start(ar, motion), usual_tuning(ar, motion)

    def field(series: SeriesArithmetic, time: Series, axes: list[Series]) -> list[Number]:
        force = Kinematics(series, motion).force_x(time)
        signed = zip((kappa, -kappa, kappa, -kappa), range(0, 12, 3), strict=True)
        return list(chain.from_iterable(axis_rate(sign, axes[n : n + 3], force) for sign, n in signed))

    initial = [*begin.paper, *begin.equilibrium]
    plain, difference = doubled(ar, field, initial, ar.number(0), ar.number(200), steps=2, order=24)
    assert difference < 1e-30
    with BallArithmetic(BITS) as balls:
        (row,) = enclosed_axes(balls, motion, balls.number(200), 1, 1, order=40, tolerance=1e-40)
        texts = [x.mid().str(45, radius=False) for x in row]
        assert max(float(x.rad()) for x in row) < 1e-38
    assert max(abs(x - ar.context.mpf(text)) for x, text in zip(plain, texts, strict=True)) < 1e-32


def test_two_solutions_of_one_gyropendulum_keep_their_angle() -> None:
    with BallArithmetic(BITS) as ar:
        rows = list(enclosed_axes(ar, MOTIONS["T3"], ar.number(600), 0, 4, order=40, tolerance=1e-40))
        assert len(rows) == 5
        for axis in (0, 3):
            cosines = [dot(row[axis : axis + 3], row[axis + 6 : axis + 9]) for row in rows]
            assert all((x - cosines[0]).contains(0) and x.rad() < 1e-35 for x in cosines)


def test_epochs_do_not_depend_on_where_one_begins() -> None:
    with BallArithmetic(BITS) as ar:
        every = list(enclosed_axes(ar, MOTIONS["T2"], ar.number(7), 0, 40, order=30, tolerance=1e-30))
        late = list(enclosed_axes(ar, MOTIONS["T2"], ar.number(7), 33, 40, order=30, tolerance=1e-30))
    assert len(late) == 8
    assert all(x.overlaps(y) for a, b in zip(every[33:], late, strict=True) for x, y in zip(a, b, strict=True))


def test_a_motion_into_the_pole_has_no_enclosure() -> None:
    """On a great circle the formulas are singular at the pole, which this one meets after 64 s."""
    polar = made("great_circle", "1.5", "0", "7000", "0")
    with BallArithmetic(64) as ar, pytest.raises(EnclosureError, match="beyond"):
        list(enclosed_axes(ar, polar, ar.number(60), 0, 30, order=12, tolerance=1e-12))
