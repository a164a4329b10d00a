"""Compiled right-hand sides of the equations of motion of gyroscopic systems, and the conditions of their validity.

Every right-hand side obeys one contract,

    f(state, force, aid, constants, rate) -> None,

where ``state`` begins with the unit quaternions of the system and ends with its plain numbers, ``force`` is the
apparent acceleration a_X in the non-rotating axes X, m/s^2, and ``aid`` holds the further inputs that the system
asks for. It writes to ``rate`` the angular velocity of each quaternion in the axes that the quaternion starts from,
2 q' = rate o q, rad/s, and then the derivatives of the numbers. That is what both the classical and the
structure-preserving driver can integrate.

A condition obeys ``c(state, aid, constants) -> float`` and is positive as long as the equations hold.

Equation numbers are those of Chelnokov 1991; where its print has slips, the corrected form is meant. Quaternions are
scalar-first with Hamilton product; a quaternion takes vectors from its new axes to its old ones.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.kernels import (
    Quaternion,
    Vector,
    add,
    compiled,
    conjugate,
    cross,
    dot,
    quaternion_product,
    rotate,
    scale,
)

__all__ = ["Condition", "Constants", "RightHandSide"]

Array = NDArray[np.float64]


class Constants(NamedTuple):
    """Constants of a gyroscopic system over a spherical Earth.

    Attributes
    ----------
    radius : float
        Radius R of the sphere that the system is tuned to, m.
    gravity : float
        Gravitational acceleration g on it, m/s^2.
    tuning : float
        kappa = m l / H of a gyropendulum of constant momentum, s/m.
    pendulosity : float
        m l, mass times distance of the centre of mass, kg m.
    rotor_momentum : float
        Angular momentum B of one rotor of the two-rotor frame, kg m^2/s.
    inverse_inertia : float
        n of (3.1), 1/(kg m^2).
    moment_offset, moment_slope : float
        Moment N = offset + slope E of the spring of the two-rotor frame with a linear law, N m and N m/rad.
    """

    radius: float
    gravity: float
    tuning: float
    pendulosity: float
    rotor_momentum: float
    inverse_inertia: float
    moment_offset: float
    moment_slope: float


RightHandSide = Callable[[Array, Vector, Array, Constants, Array], None]
Condition = Callable[[Array, Array, Constants], float]

UP = (0.0, 0.0, 1.0)


@compiled
def quaternion(state: Array, first: int) -> Quaternion:
    """Return the quaternion that starts at an index of the state."""
    return state[first], state[first + 1], state[first + 2], state[first + 3]


@compiled
def vector(values: Array, first: int) -> Vector:
    """Return the vector that starts at an index."""
    return values[first], values[first + 1], values[first + 2]


@compiled
def put(rate: Array, first: int, value: Vector) -> None:
    """Write a vector to the rates from an index on."""
    rate[first] = value[0]
    rate[first + 1] = value[1]
    rate[first + 2] = value[2]


# Pendulums with one gyroscope


@compiled
def gyropendulum(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.6): 2 e' = -kappa a_X o e. State e."""
    put(rate, 0, scale(-constants.tuning, force))


@compiled
def gyropendulum_programmed(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.5) with H(t) = m l sqrt(g R - v(t)^2). State e; aid v, m/s."""
    speed = aid[0]
    put(rate, 0, scale(-1.0 / math.sqrt(constants.gravity * constants.radius - speed * speed), force))


@compiled
def gyropendulum_moments(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.1), (2.2): momentum and moments of any law. State e, H; aid M_eta (3), N m, and spin rate w*_3, rad/s."""
    e, momentum, moment = quaternion(state, 0), state[4], vector(aid, 0)
    ratio = constants.pendulosity / momentum
    specific = rotate(conjugate(e), force)
    turning = add(scale(-ratio, specific), scale(-1.0 / momentum, cross(moment, UP)))
    spin = aid[3] + ratio * specific[2]
    put(rate, 0, rotate(e, add(turning, scale(spin, UP))))
    rate[3] = moment[2]


@compiled
def gyroscope_general(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(1.8) with k = 3 and (1.12), centre of mass anywhere. State e, L; aid M_eta (3), w*_3, (m l)_eta (3)."""
    e, momentum, moment, arm = quaternion(state, 0), state[4], vector(aid, 0), vector(aid, 4)
    specific = rotate(conjugate(e), force)
    along, torque = dot(specific, arm), cross(specific, arm)
    # The vector part of (M + m a o l) o i3, where the scalar part of a o l is -a.l.
    product = add(cross(add(moment, torque), UP), scale(-along, UP))
    put(rate, 0, rotate(e, add(scale(aid[3] - along / momentum, UP), scale(-1.0 / momentum, product))))
    rate[3] = torque[2] + moment[2]


# The bi-gyro vertical


@compiled
def axes_sum(state: Array) -> Vector:
    """Return p + n, the sum of the third axes of the two gyropendulums."""
    return add(rotate(quaternion(state, 0), UP), rotate(quaternion(state, 4), UP))


@compiled
def bi_gyro(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.6) for two gyropendulums of opposite momenta. State e_1, e_2."""
    put(rate, 0, scale(-constants.tuning, force))
    put(rate, 3, scale(constants.tuning, force))


@compiled
def bi_gyro_self_tuned(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.5) twice, H = m l V cos(alpha) with 2 alpha the angle between the axes, V = sqrt(g R). State e_1, e_2."""
    total = axes_sum(state)
    tuning = 2.0 / math.sqrt(constants.gravity * constants.radius * dot(total, total))
    put(rate, 0, scale(-tuning, force))
    put(rate, 3, scale(tuning, force))


# Gyroscopic frames and compasses


@compiled
def frame_turning(state: Array, force: Vector, moment: float, constants: Constants, rate: Array) -> None:
    """(2.12)-(2.14) with M = 0 for a spring moment N = `moment`. State e, E."""
    e, sine, cosine = quaternion(state, 0), math.sin(state[4]), math.cos(state[4])
    specific = rotate(conjugate(e), force)
    momentum, gearing = 2.0 * constants.rotor_momentum * cosine, 2.0 * constants.rotor_momentum * sine
    pendulosity = constants.pendulosity
    put(rate, 0, rotate(e, (0.0, -moment / gearing, pendulosity * specific[1] / momentum)))
    rate[3] = -pendulosity * specific[0] / gearing


@compiled
def gyroframe(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.12)-(2.14) with the unperturbed law N(E) = -(4 B^2/(m l R)) sin E cos E. State e, E."""
    momentum = 2.0 * constants.rotor_momentum
    stiffness = momentum * momentum / (constants.pendulosity * constants.radius)
    frame_turning(state, force, -stiffness * (math.sin(state[4]) * math.cos(state[4])), constants, rate)


@compiled
def gyroframe_linear(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.12)-(2.14) with a spring of linear law N(E) = offset + slope E. State e, E."""
    frame_turning(state, force, constants.moment_offset + constants.moment_slope * state[4], constants, rate)


@compiled
def gyroframe_moments(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.12), (2.13): moments and rate w_Y2 of any law. State e, H; aid M_Y (3), N m, and w_Y2, rad/s."""
    e, momentum = quaternion(state, 0), state[4]
    specific = rotate(conjugate(e), force)
    pendulosity = constants.pendulosity
    put(rate, 0, rotate(e, (aid[2] / momentum, aid[3], (pendulosity * specific[1] - aid[0]) / momentum)))
    rate[3] = pendulosity * specific[0] + aid[1]


@compiled
def gyrohorizoncompass(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.15) with h' = a_Y1 - r' h/r, which makes it exact at a varying radius. State e, h; aid r, m, and r', m/s."""
    e, h = quaternion(state, 0), state[4]
    specific = rotate(conjugate(e), force)
    put(rate, 0, rotate(e, (0.0, h / aid[0], specific[1] / h)))
    rate[3] = specific[0] - aid[1] * h / aid[0]


# The full equations


@compiled
def full_equations(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(3.1), of second order. State z, z' as plain numbers; aid M_X (3), N m."""
    z, moment, n = quaternion(state, 0), vector(aid, 0), constants.inverse_inertia
    square = state[4] * state[4] + state[5] * state[5] + state[6] * state[6] + state[7] * state[7]
    specific = rotate(conjugate(z), force)
    weight = quaternion_product(z, (0.0, specific[1], -specific[0], 0.0))
    correction = quaternion_product((0.0, moment[0], moment[1], moment[2]), z)
    half = 0.5 * n
    for i in range(4):
        rate[i] = state[4 + i]
        rate[4 + i] = half * correction[i] - half * constants.pendulosity * weight[i] - square * z[i]


# Inertial systems for comparison


@compiled
def two_component(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """Two-component inertial system in the azimuth-free trihedron. State nu, v_1, v_2; aid r, m, and r', m/s."""
    nu, v1, v2, curvature = quaternion(state, 0), state[4], state[5], 1.0 / aid[0]
    specific = rotate(conjugate(nu), force)
    put(rate, 0, rotate(nu, (-v2 * curvature, v1 * curvature, 0.0)))
    rate[3] = specific[0] - aid[1] * v1 * curvature
    rate[4] = specific[1] - aid[1] * v2 * curvature


@compiled
def newton(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """Newton's equation r'' = a - g R^2 r/|r|^3, unaided. State r (3), v (3)."""
    position = vector(state, 0)
    square = dot(position, position)
    attraction = constants.gravity * constants.radius * constants.radius / (square * math.sqrt(square))
    put(rate, 0, vector(state, 3))
    put(rate, 3, add(force, scale(-attraction, position)))


# Equations of the deviation from a reference trihedron Z


@compiled
def deviation(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(1.13): 2 lambda' = lambda o w*_eta - w0_Z o lambda, 2 nu' = nu o w0_Z. State nu, lambda; aid w0_Z, w*_eta."""
    reference, turning = vector(aid, 0), vector(aid, 3)
    put(rate, 0, rotate(quaternion(state, 0), reference))
    put(rate, 3, add(rotate(quaternion(state, 4), turning), scale(-1.0, reference)))


@compiled
def gyropendulum_deviation(state: Array, force: Vector, aid: Array, constants: Constants, rate: Array) -> None:
    """(2.7): 2 H lambda' + (H w0_Z + m l a_Z + H') o lambda = -lambda o M_eta o i3, H' = M_3. State nu, lambda, H.

    Aid w0_Z (3), rad/s, and M_eta (3), N m. The scalar parts H' and M_3 cancel.
    """
    nu, deviation_, momentum = quaternion(state, 0), quaternion(state, 4), state[8]
    reference, moment = vector(aid, 0), vector(aid, 3)
    specific = rotate(conjugate(nu), force)
    torque = add(scale(constants.pendulosity, specific), rotate(deviation_, cross(moment, UP)))
    put(rate, 0, rotate(nu, reference))
    put(rate, 3, add(scale(-1.0 / momentum, torque), scale(-1.0, reference)))
    rate[6] = moment[2]


# Conditions


@compiled
def unconditional(state: Array, aid: Array, constants: Constants) -> float:
    """Return 1: the equations are singular nowhere."""
    return 1.0


@compiled
def below_schuler_speed(state: Array, aid: Array, constants: Constants) -> float:
    """Return (g R - v^2)/(g R)."""
    speed: float = aid[0]
    return 1.0 - speed * speed / (constants.gravity * constants.radius)


@compiled
def axes_apart_from_opposite(state: Array, aid: Array, constants: Constants) -> float:
    """Return |p + n|^2."""
    total = axes_sum(state)
    return dot(total, total)


@compiled
def frame_open(state: Array, aid: Array, constants: Constants) -> float:
    """Return how far E is from the nearer end of its range: beside an end a step may leap over it by whole turns."""
    angle: float = state[4]
    return min(angle, 0.5 * math.pi - angle)


@compiled
def first_number_positive(state: Array, aid: Array, constants: Constants) -> float:
    """Return the number behind one quaternion: H, h."""
    number: float = state[4]
    return number


@compiled
def second_number_positive(state: Array, aid: Array, constants: Constants) -> float:
    """Return the number behind two quaternions: H."""
    number: float = state[8]
    return number


@compiled
def away_from_centre(state: Array, aid: Array, constants: Constants) -> float:
    """Return |r|^2 relative to R^2."""
    position = vector(state, 0)
    return dot(position, position) / (constants.radius * constants.radius)
