r"""Equations of gyroscopic systems, their unperturbed states, and the solutions that differ from the vertical.

All vectors are resolved in the non-rotating axes X. With :math:`\kappa = ml/H` the axis of a gyropendulum without
moments obeys :math:`\dot\eta_3 = \kappa\,\eta_3\times a`; of the two gyropendulums of a bi-gyro vertical one has
:math:`-\kappa`. In the Darboux trihedron :math:`(y_1, y_2, y_3)` of the absolute motion the axis stands at the
angle :math:`\alpha` about :math:`y_1`: :math:`\eta_3 = y_3\cos\alpha - y_2\sin\alpha`.

Source: Chelnokov 1991, eq. (2.5), (2.6), (2.15), (3.1) and the text around them; the unperturbed states beyond the
paper's are derived here, and tested by substitution.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor, inf
from operator import mul

from flint import arb

from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.enclosure import EnclosureError, multiple, rounded_step
from sinsref.expansion import SHORTEST, Expander, values_at
from sinsref.gyroscopic import Kinematics, Motion, kinematics_of
from sinsref.quaternion import Vector, conjugate, cross, dot, product, rotate

#: Cosine and sine of the tilt of an axis.
Tilt = tuple[Number, Number]


def axis_rate(kappa: Number, axis: Vector, force: Vector) -> list[Number]:
    """Return the rate of a gyropendulum's axis, 1/s: (2.6), or (2.5) where kappa = ml/H(t)."""
    return [x * kappa for x in cross(axis, force)]


def paper_tilt(ar: Arithmetic, scale: Number, speed: Number) -> Tilt:
    """Return the tilt alpha = -v/V, the paper's law (section 2.1), which holds to relative O(v^2/V^2)."""
    sine, cosine = ar.sin_cos(speed / scale)
    return cosine, -sine


def exact_tilt(ar: Arithmetic, scale: Number, speed: Number) -> Tilt:
    """Return the tilt sin(alpha) = -v/V: exact for any motion on the sphere where H = m l sqrt(g R - v^2)."""
    sine = speed / scale
    return ar.sqrt(1 - sine * sine), -sine


def equilibrium_tilt(
    ar: Arithmetic, kappa: Number, speed: Number, turn: Number, radius: Number, gravity: Number
) -> Tilt:
    """Return the tilt at which a gyropendulum of constant H rests in the Darboux trihedron.

    ``tan(alpha) = -v (1/R + kappa w3) / (w3 + kappa (g - v^2/R))``, with abs(alpha) < pi/2: exact while speed and
    rate of turn are constant.

    Parameters
    ----------
    ar : Arithmetic
    kappa : Number
        ml/H, s/m; negative for the second gyropendulum of a bi-gyro vertical.
    speed : Number
        Absolute, m/s.
    turn : Number
        w3, rate of the trihedron about the vertical, rad/s.
    radius, gravity : Number
        m, m/s^2.
    """
    along = -(speed * (1 / radius + kappa * turn))
    down = turn + kappa * (gravity - speed * speed / radius)
    length = ar.sqrt(along * along + down * down) * ar.sign(down)
    return down / length, along / length


def tilted(trihedron: Sequence[Vector], tilt: Tilt) -> list[Number]:
    """Return the axis ``y3 cos(alpha) - y2 sin(alpha)``."""
    _, left, up = trihedron
    cosine, sine = tilt
    return [y3 * cosine - y2 * sine for y2, y3 in zip(left, up, strict=True)]


def bisector(ar: Arithmetic, first: Vector, second: Vector) -> list[Number]:
    """Return the vertical of a bi-gyro: the unit vector half way between its axes."""
    total = [x + y for x, y in zip(first, second, strict=True)]
    length = ar.sqrt(dot(total, total))
    return [x / length for x in total]


def self_tuned_rates(
    ar: Arithmetic, scale: Number, first: Vector, second: Vector, force: Vector
) -> tuple[list[Number], list[Number]]:
    """Return the rates of the axes of a bi-gyro that tunes itself, kappa = 2/(V abs(p + n)), 1/s.

    It is the vertical, the Darboux trihedron and the speed for any motion on the sphere when it starts at `exact_tilt`.
    """
    total = [x + y for x, y in zip(first, second, strict=True)]
    kappa = 2 / (scale * ar.sqrt(dot(total, total)))
    return axis_rate(kappa, first, force), axis_rate(-kappa, second, force)


def compass_rates(
    trihedron: Sequence[Number], speed: Number, radius: Number, climb: Number, force: Vector
) -> list[Number]:
    """Return the rates of a spatial gyrohorizoncompass (2.15): of its quaternion, 1/s, and of h = H/(ml), m/s^2.

    Parameters
    ----------
    trihedron : sequence of 4 Number
        e, from its axes to X.
    speed : Number
        h, m/s.
    radius, climb : Number
        Distance from the centre, m, and its rate, m/s: with the latter ``h' = a_1 - r' h/r``, exact for any altitude.
    force : sequence of 3 Number
        Specific force, m/s^2.
    """
    along, left, _ = rotate(conjugate(trihedron), force)
    zero = speed * 0
    turning = product(trihedron, [zero, zero, speed / radius, left / speed])
    return [*(x / 2 for x in turning), along - climb * speed / radius]


def frame_rates(
    ar: Arithmetic, trihedron: Sequence[Number], angle: Number, radius: Number, limit: Number, force: Vector
) -> list[Number]:
    """Return the rates of a two-rotor gyroframe (2.12)-(2.14): of its quaternion, 1/s, and of E, rad/s.

    The moment of its spring is that of the unperturbed frame, ``N = -(4 B^2/(m l R)) sin(E) cos(E)``.

    Parameters
    ----------
    ar : Arithmetic
    trihedron : sequence of 4 Number
        e, from its axes to X.
    angle : Number
        E, from the axis of the frame to that of a rotor, rad.
    radius : Number
        R, m.
    limit : Number
        2B/(ml), the speed that the frame cannot reach, m/s.
    force : sequence of 3 Number
        Specific force, m/s^2.
    """
    along, left, _ = rotate(conjugate(trihedron), force)
    sine, cosine = ar.sin_cos(angle)
    moment, zero = -(limit * limit / radius) * sine * cosine, sine * 0
    turning = product(trihedron, [zero, zero, -moment / (limit * sine), left / (limit * cosine)])
    return [*(x / 2 for x in turning), -along / (limit * sine)]


def two_component_rates(
    trihedron: Sequence[Number], velocity: Sequence[Number], radius: Number, force: Vector
) -> list[Number]:
    """Return the rates of the two-component inertial system in the azimuth-free trihedron, for comparison.

    Parameters
    ----------
    trihedron : sequence of 4 Number
        nu, from its axes to X.
    velocity : sequence of 2 Number
        Components along the first two axes, m/s.
    radius : Number
        R, m.
    force : sequence of 3 Number
        Specific force, m/s^2.

    Returns
    -------
    list of 6 Number
        Of the quaternion, 1/s, and of the velocity, m/s^2.
    """
    first, second = velocity
    along, left, _ = rotate(conjugate(trihedron), force)
    zero = first * 0
    turning = product(trihedron, [zero, -second / radius, first / radius, zero])
    return [*(x / 2 for x in turning), along, left]


def full_acceleration(
    radius: Number, quaternion: Sequence[Number], rate: Sequence[Number], force: Vector
) -> list[Number]:
    """Return the second derivative of the quaternion of the full equations (3.1) with M = 0, n = 1/(m l R), 1/s^2."""
    east, north, _ = rotate(conjugate(quaternion), force)
    zero = east * 0
    turning = product(quaternion, [zero, north, -east, zero])
    square = dot(rate, rate)
    return [-(square * z) - x / (radius * 2) for z, x in zip(quaternion, turning, strict=True)]


@dataclass(frozen=True)
class Start:
    """Axes of the two gyropendulums at t = 0, by two rules.

    Attributes
    ----------
    paper : list of 6 Number
        First and second axis at the paper's tilt.
    equilibrium : list of 6 Number
        Each at its own equilibrium (`equilibrium_tilt`).
    vertical : list of 3 Number
        Which is half way between the axes at the paper's tilt.
    """

    paper: list[Number]
    equilibrium: list[Number]
    vertical: list[Number]


def usual_tuning(ar: Arithmetic, motion: Motion) -> tuple[Number, Number]:
    """Return V = sqrt(g R), m/s, and kappa = 1/V of the usual tuning H = m l sqrt(g R)."""
    scale = ar.sqrt(ar.number(motion.gravity) * ar.number(motion.radius))
    return scale, 1 / scale


def start(ar: Arithmetic, motion: Motion) -> Start:
    """Return the axes of the gyropendulums of the usual tuning at t = 0."""
    kinematics = Kinematics(ar, motion)
    place = kinematics.place(ar.number(0))
    speed = kinematics.speed(place)
    east, north, _ = place.velocity
    force_east, force_north, _ = place.specific_force
    turn = (force_north * east - force_east * north) / (speed * speed)
    scale, kappa = usual_tuning(ar, motion)
    zero, one = ar.number(0), ar.number(1)
    ahead = place.from_local([east / speed, north / speed, zero])
    left = place.from_local([-(north / speed), east / speed, zero])
    trihedron = [ahead, left, place.from_local([zero, zero, one])]
    cosine, sine = paper_tilt(ar, scale, speed)
    resting = [equilibrium_tilt(ar, x, speed, turn, kinematics.radius, kinematics.gravity) for x in (kappa, -kappa)]
    return Start(
        [*tilted(trihedron, (cosine, sine)), *tilted(trihedron, (cosine, -sine))],
        [x for tilt in resting for x in tilted(trihedron, tilt)],
        trihedron[2],
    )


def enclosed_axes(
    balls: BallArithmetic, motion: Motion, interval: Number, first: int, last: int, *, order: int, tolerance: float
) -> Iterator[list[Number]]:
    """Yield balls that contain the axes of both bi-gyros of the usual tuning at first * interval ... last * interval.

    Twelve numbers: first and second axis from the paper's start, then from equilibrium. The specific force is expanded
    about the start of a step; the equation is linear in the axis and keeps its length, so that the coefficients of any
    solution of length 1 are bounded by a scalar recurrence: Lagrange's remainder without an a-priori enclosure.

    Parameters
    ----------
    balls : BallArithmetic
        Entered; its precision is the working precision.
    motion : Motion
    interval : arb
        Distance of the epochs, s.
    first, last : int
        Numbers of epochs; the solution starts at epoch 0.
    order : int
        Order of the Taylor series.
    tolerance : float
        Largest remainder of a step.

    Raises
    ------
    EnclosureError
        If steps become too short.
    """
    _, kappa = usual_tuning(balls, motion)
    given = start(balls, motion)
    axes = _threes([*given.paper, *given.equilibrium])
    if first == 0:
        yield [x for axis in axes for x in axis]

    kinematics = kinematics_of(motion)
    expander = Expander(lambda ar, time: kinematics(ar).force_x(time), balls.bits, order)
    position, size = Fraction(0), Fraction(1)
    while position < last:
        size = min(size, last - position)
        step, middle = multiple(interval, size), multiple(interval, position + size / 2)
        bound = _last_coefficient(kappa, expander.over(middle, step / 2))
        excess = float((bound * step ** (order + 1) / tolerance).abs_upper()) if bound.is_finite() else inf
        factor = Fraction(0.9 * min(max(excess, 1e-300), 1e300) ** (-1 / (order + 1)))
        if excess > 1:
            size = rounded_step(size * max(factor, Fraction(1, 16)))
            if size < SHORTEST:
                raise EnclosureError(f"no enclosure of the axes beyond {float(multiple(interval, position)):g}")
            continue
        terms = expander.at(multiple(interval, position))
        polynomials = [
            [*coefficients, arb(0, bound)]
            for number, axis in enumerate(axes)
            for coefficients in _axis_series(-kappa if number % 2 else kappa, axis, terms)
        ]
        epochs = range(max(first, floor(position) + 1), floor(position + size) + 1)
        yield from values_at(polynomials, step, [(epoch - position) / size for epoch in epochs])
        (state,) = values_at(polynomials, step, [Fraction(1)])
        axes, position = _threes(state), position + size
        size = rounded_step(size * min(factor, Fraction(4)))


def _threes(numbers: Sequence[Number]) -> list[list[Number]]:
    return [list(numbers[place : place + 3]) for place in range(0, len(numbers), 3)]


def _axis_series(kappa: Number, axis: Vector, force: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """Return the Taylor coefficients of the axis through a place, from those of the force: (2.6) term by term."""
    series = [[x] for x in axis]
    for k in range(len(force[0]) - 1):
        rate = [
            sum(map(mul, series[i], force[j][k::-1])) - sum(map(mul, series[j], force[i][k::-1]))
            for i, j in ((1, 2), (2, 0), (0, 1))
        ]
        for own, x in zip(series, rate, strict=True):
            own.append(x * kappa / (k + 1))
    return series


def _last_coefficient(kappa: Number, force: Sequence[Sequence[Number]]) -> Number:
    """Return a bound of the length of the last Taylor coefficient of any axis of length 1, anywhere in a step.

    As |p| = 1, the coefficients of ``p' = kappa p x a`` are bounded by those of ``P' = kappa A P``, P(0) = 1, with the
    lengths of the coefficients of a.
    """
    if not force:
        return arb("inf")
    lengths = [dot(a, a).abs_upper().sqrt().abs_upper() for a in zip(*force, strict=True)]
    bounds = [arb(1)]
    for k in range(len(lengths) - 1):
        bounds.append((sum(map(mul, bounds, lengths[k::-1])) * kappa / (k + 1)).abs_upper())
    return bounds[-1]
