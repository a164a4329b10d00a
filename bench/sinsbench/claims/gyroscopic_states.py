"""The states that Chelnokov 1991 calls unperturbed, put into the equations of their systems in ball arithmetic.

A state is a function of time along an exact motion of the dataset `gyro_systems`; what it leaves of the equation,
relative to its own derivative, is a ball. It contains zero and is narrow where the state is a solution for that motion,
and keeps away from zero where it is none.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import TypeAlias

from sinsbench.claims.quantities import Enclosure, hull
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.tiers import paper_cases
from sinsref.arithmetic import BallArithmetic, Number
from sinsref.gyroscopic import Kinematics
from sinsref.gyroscopic_systems import (
    axis_rate,
    compass_rates,
    equilibrium_tilt,
    exact_tilt,
    frame_rates,
    full_acceleration,
    paper_tilt,
    self_tuned_rates,
    tilted,
    usual_tuning,
)
from sinsref.quaternion import cross, dot, product, rotate
from sinsref.series import Series, SeriesArithmetic

BITS = 192
TIMES = (0, 1799, 3500)
"""Times at which a state is put into its equation, s."""
ROTOR_SPEED, SPRING_SPEED = 2000, 600
"""2B/(ml) of the two-rotor frame, and the speed at which a linear spring is right, m/s."""

Residual: TypeAlias = tuple[Sequence[Number], Sequence[Number]]
"""Derivatives of a state, and the right-hand side of its equation."""


@cache
def case(name: str) -> GyroCase:
    """Return a case of the tier ``paper`` of `gyro_systems`."""
    cases = {case.name: case for case in paper_cases("gyro_systems") if isinstance(case, GyroCase)}
    return cases[name]


class Instant:
    """A motion near a time, as Taylor series: place, Darboux trihedron, speed, specific force in X.

    Parameters
    ----------
    balls : BallArithmetic
        Entered.
    motion : str
        Name of a case.
    time : int
        s.
    """

    def __init__(self, balls: BallArithmetic, motion: str, time: int) -> None:
        self.ar = SeriesArithmetic(balls)
        model = case(motion).model
        self.kinematics = Kinematics(self.ar, model)
        t = self.ar.variable(balls.number(time))
        self.place = self.kinematics.place(t)
        self.radius, self.climb, _ = (self._series(x) for x in self.place.radius)
        self.quaternion = self.kinematics.darboux(self.place)
        zero, one = self.ar.number(0), self.ar.number(1)
        units = ([one, zero, zero], [zero, one, zero], [zero, zero, one])
        self.axes = [rotate(self.quaternion, unit) for unit in units]
        self.speed = self.kinematics.speed(self.place)
        self.force = self.kinematics.force_x(t)
        self.scale, self.kappa = usual_tuning(self.ar, model)

    def _series(self, x: Number) -> Number:
        return x if isinstance(x, Series) else self.ar.constant(x)

    @property
    def turn(self) -> Number:
        """Rate w3 of the trihedron about the vertical, rad/s."""
        return dot(self.force, self.axes[1]) / self.speed


def _sides(state: Sequence[Number], rates: Sequence[Number]) -> Residual:
    return [x[1] for x in state], [x[0] for x in rates]


def law_of_the_paper(at: Instant) -> Residual:
    """(2.6), H = m l sqrt(g R): alpha = -(l m/H) v."""
    axis = tilted(at.axes, paper_tilt(at.ar, at.scale, at.speed))
    return _sides(axis, axis_rate(at.kappa, axis, at.force))


def law_with_varying_momentum(at: Instant) -> Residual:
    """(2.5), H = m l sqrt(g R - v^2): tan(alpha) = -(l m/H) v, the same as sin(alpha) = -v/sqrt(g R)."""
    axis = tilted(at.axes, exact_tilt(at.ar, at.scale, at.speed))
    kappa = 1 / at.ar.sqrt(at.scale * at.scale - at.speed * at.speed)
    return _sides(axis, axis_rate(kappa, axis, at.force))


def rest(at: Instant) -> Residual:
    """(2.6), H = m l sqrt(g R): the inclination at which the axis rests while v and w3 are constant."""
    known = at.speed, at.turn, at.kinematics.radius, at.kinematics.gravity
    axis = tilted(at.axes, equilibrium_tilt(at.ar, at.kappa, *known))
    return _sides(axis, axis_rate(at.kappa, axis, at.force))


def self_tuned_pair(at: Instant) -> Residual:
    """(2.5) twice, H = m l sqrt(g R) cos(alpha): both axes, whose bisector is the vertical."""
    cosine, sine = exact_tilt(at.ar, at.scale, at.speed)
    axes = tilted(at.axes, (cosine, sine)), tilted(at.axes, (cosine, -sine))
    first, second = self_tuned_rates(at.ar, at.scale, *axes, at.force)
    return _sides([*axes[0], *axes[1]], [*first, *second])


def compass(at: Instant, *, radius: bool = False, climb: bool = False) -> Residual:
    """(2.15): the Darboux trihedron and h = v; with r(t) in place of R, and with h' = a_1 - r' h/r, if so wished."""
    sphere, zero = at.kinematics.radius, at.ar.number(0)
    rates = compass_rates(
        at.quaternion, at.speed, at.radius if radius else sphere, at.climb if climb else zero, at.force
    )
    # In units of sqrt(g R) the speed is of the size of an angle.
    return _sides([*at.quaternion, at.speed / at.scale], [*rates[:4], rates[4] / at.scale])


def two_rotor_frame(at: Instant, *, linear: bool = False) -> Residual:
    """(2.12)-(2.14), N = -(4 B^2/(m l R)) sin E cos E or its tangent: the Darboux trihedron, cos E = m l v/(2B)."""
    cosine = at.speed / ROTOR_SPEED
    sine = at.ar.sqrt(1 - cosine * cosine)
    angle = at.ar.variable(cosine[0].acos(), -cosine[1] / sine[0])  # a first derivative is all that is needed
    radius, limit = at.kinematics.radius, at.ar.number(ROTOR_SPEED)
    rates = frame_rates(at.ar, at.quaternion, angle, radius, limit, at.force)
    if linear:
        balls = at.ar.base
        angle_0 = (balls.number(SPRING_SPEED) / ROTOR_SPEED).acos()
        sine_2, cosine_2 = balls.sin_cos(2 * angle_0)
        tangent = sine_2 / 2 + cosine_2 * (angle[0] - angle_0)
        wrong = (tangent - sine[0] * cosine[0]) / sine[0] * ROTOR_SPEED / radius[0]
        turning = product([x[0] for x in at.quaternion], [balls.number(0), balls.number(0), wrong, balls.number(0)])
        rates = [*(x + y / 2 for x, y in zip(rates[:4], turning, strict=True)), rates[4]]
    return _sides([*at.quaternion, angle], rates)


def full(at: Instant, *, vertical: str = "0") -> Residual:
    """(3.1), n = 1/(m l R), M = 0: a trihedron that turns at r^ x v/R, and at a rate about the vertical, rad/s."""
    zero, up = at.ar.base.number(0), at.place.vertical
    r, v, a = ([x[k] * (1, 1, 2)[k] for x in up] for k in (0, 1, 2))
    value = [x[0] for x in at.quaternion]
    spin = [x * at.ar.base.number(vertical) for x in r]
    rate = [x / 2 for x in product([zero, *(x + y for x, y in zip(cross(r, v), spin, strict=True))], value)]
    exact = [x / 2 for x in product([zero, *cross(r, v)], value)]
    turning = [x / 2 for x in product([zero, *cross(r, a)], value)]
    known = [x + y / 2 for x, y in zip(turning, product([zero, *cross(r, v)], exact), strict=True)]
    return known, full_acceleration(at.kinematics.radius[0], value, rate, [x[0] for x in at.force])


STATES: Mapping[str, Callable[[Instant], Residual]] = {
    "law of the paper": law_of_the_paper,
    "law with varying momentum": law_with_varying_momentum,
    "rest": rest,
    "self-tuned pair": self_tuned_pair,
    "compass": compass,
    "compass with r(t)": partial(compass, radius=True),
    "compass with r(t) and r'(t)": partial(compass, radius=True, climb=True),
    "two-rotor frame": two_rotor_frame,
    "two-rotor frame, linear spring": partial(two_rotor_frame, linear=True),
    "full equations": full,
    "full equations, 1e-6 rad/s about the vertical": partial(full, vertical="1e-6"),
}
"""States by name."""


def relative_residual(balls: BallArithmetic, known: Sequence[Number], given: Sequence[Number]) -> Enclosure:
    """Return the norm of the difference of two sides of an equation, relative to the norm of the first."""
    difference = [x - y for x, y in zip(known, given, strict=True)]
    size = balls.sqrt(dot(known, known))
    # A square root of a ball around zero is none: the norm is bounded from below and from above instead.
    bounds = ([x.abs_lower() for x in difference], [x.abs_upper() for x in difference])
    return hull(*(Enclosure.of(balls.sqrt(dot(x, x)) / size) for x in bounds))


@cache
def residual_of_state(state: str, motion: str) -> Enclosure:
    """Return what a state leaves of its equation, relative to it, at `TIMES` of a motion.

    Parameters
    ----------
    state : str
        Name in `STATES`.
    motion : str
        Name of a case of the tier ``paper``.
    """
    with BallArithmetic(BITS) as balls:
        return hull(*(relative_residual(balls, *STATES[state](Instant(balls, motion, time))) for time in TIMES))
