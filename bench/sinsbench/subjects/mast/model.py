"""The mast's equations: rates F(Y, t) of the state and measurements H(Y, t), as compiled functions.

The state is an array of 20 numbers,

    Y = (mu[4], longitude, latitude, V[3], H, eta[4], lambda[4], w_X, w_Y),

with the attitudes mu from inertial axes to the vehicle's J1, lambda from J1 to the mast's Q, eta from Q to the
antenna's J2 (scalar first, Hamilton product; a quaternion q resolves a vector of its old axes in its new ones as
D(q) v), the Earth-relative velocity V in axes east, north, up, and the absolute rates w_X, w_Y of the mast in Q.
Inertial axes and Earth-fixed axes have the Earth's spin axis second.

Equation numbers are those of Sokolov, Pogorelov, Reshetnikova 2024; each equation is the corrected one unless `Terms`
say otherwise. The mast's own equations replace (3.11) to (3.13): with u = D(lambda) w1 and
Delta = D(eta)^T f2 - D(lambda) f1, the rigid body gives

    w_X' = -Delta_Y / R + w_Y u_Z,  w_Y' = Delta_X / R - w_X u_Z,  0 = Delta_Z + R (w_X^2 + w_Y^2).
"""

import math
from typing import Any, NamedTuple, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.equations import put, quaternion, vector
from sinsbench.subjects.kernels import (
    Function,
    Quaternion,
    Vector,
    add,
    conjugate,
    cross,
    dot,
    quaternion_product,
    scale,
    vector_part,
)
from sinsbench.subjects.mast.terms import Terms

__all__ = [
    "ETA",
    "HEIGHT",
    "LAMBDA",
    "LATITUDE",
    "LONGITUDE",
    "MU",
    "RATE",
    "STATES",
    "VELOCITY",
    "Constants",
    "Sensors",
]

Array = NDArray[np.float64]


def index(place: int) -> int:
    """Return an index as a NumPy integer.

    A Python integer that is constant has a type of its own in compiled code, and what it is passed to is compiled again
    for each of them.
    """
    return cast("int", np.int64(place))


MU, LONGITUDE, LATITUDE, VELOCITY, HEIGHT, ETA, LAMBDA, RATE, STATES = map(index, (0, 4, 5, 6, 9, 10, 14, 18, 20))
"""Where the parts of the state begin, and how long it is."""


class Constants(NamedTuple):
    """Constants of the scenario.

    Attributes
    ----------
    mast_length : float
        R, m.
    earth_radius : float
        m.
    earth_rate : float
        Omega, rad/s.
    gravitation : float
        g, gravitation alone, m/s^2.
    """

    mast_length: float = 5.0
    earth_radius: float = 6371000.0
    earth_rate: float = 7.292115e-5
    gravitation: float = 9.81


class Sensors(NamedTuple):
    """What the two groups of sensors show at one moment.

    Attributes
    ----------
    rate1, force1, rate2, force2 : tuple of 3 floats
        Z_d1, rad/s, and Z_a1, m/s^2, of the vehicle in J1; Z_d2 and Z_a2 of the antenna in J2.
    """

    rate1: Vector
    force1: Vector
    rate2: Vector
    force2: Vector


def entry(function: Function) -> Function:
    """Compile on the first call, as `compiled` does, but without copying the code into its callers."""
    return _compiled(function, {"no_cfunc_wrapper": True})


def inner(function: Function) -> Function:
    """Compile what only compiled code calls: without the ways in from Python it takes three quarters of the time."""
    return _compiled(function, {"no_cpython_wrapper": True, "no_cfunc_wrapper": True})


def _compiled(function: Function, options: dict[str, bool]) -> Function:
    jit: Any = njit  # its type knows nothing of leaving out wrappers
    try:
        result = jit(cache=True, error_model="numpy", **options)(function)
    except RuntimeError:  # numba found no writable folder for its cache
        result = jit(error_model="numpy", **options)(function)
    return cast("Function", result)


@entry
def axis(k: int) -> Vector:
    """Return the unit vector of an axis."""
    return 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0


@entry
def resolved(q: Quaternion, v: Vector) -> Vector:
    """D(q) v: a vector of the old axes of q in its new ones."""
    u = vector_part(q)
    along = add(scale(2.0 * q[0] * q[0] - 1.0, v), scale(2.0 * dot(u, v), u))
    return add(along, scale(-2.0 * q[0], cross(u, v)))


def plain_matrix(q: Array) -> Array:
    """D(q) as an array of shape (3, 3), for what is no loop over steps."""
    return np.array([resolved(tuple(q), tuple(axis)) for axis in np.eye(3)]).T


@inner
def back(q: Quaternion, v: Vector) -> Vector:
    """D(q)^T v: a vector of the new axes of q in its old ones."""
    return resolved(conjugate(q), v)


@inner
def put_rate(out: Array, first: int, q: Quaternion, rate: Vector) -> None:
    """Write q' = 1/2 Phi(q) rate from an index on."""
    x, y, z = scale(0.5, rate)
    p = quaternion_product(q, (0.0, x, y, z))
    out[first] = p[0]
    out[first + 1] = p[1]
    out[first + 2] = p[2]
    out[first + 3] = p[3]


@inner
def to_local(angle: float, latitude: float, v: Vector) -> Vector:
    """B v: from inertial axes (`angle` = longitude + Omega t) or Earth-fixed ones (longitude) to east, north, up."""
    sa, ca, s, c = math.sin(angle), math.cos(angle), math.sin(latitude), math.cos(latitude)
    meridian = ca * v[2] + sa * v[0]
    return ca * v[0] - sa * v[2], c * v[1] - s * meridian, s * v[1] + c * meridian


@inner
def from_local(angle: float, latitude: float, v: Vector) -> Vector:
    """B^T v: from axes east, north, up to inertial or Earth-fixed ones."""
    sa, ca, s, c = math.sin(angle), math.cos(angle), math.sin(latitude), math.cos(latitude)
    meridian = c * v[2] - s * v[1]
    return ca * v[0] + sa * meridian, c * v[1] + s * v[2], ca * meridian - sa * v[0]


@inner
def transport_rate(state: Array, constants: Constants) -> Vector:
    """2 Omega_S + omega_S of (3.2), rad/s."""
    latitude, r = state[LATITUDE], constants.earth_radius + state[HEIGHT]
    s, c, east = math.sin(latitude), math.cos(latitude), state[VELOCITY] / r
    return (
        -state[VELOCITY + 1] / r,
        2.0 * constants.earth_rate * c + east,
        2.0 * constants.earth_rate * s + east * s / c,
    )


@inner
def gravity(state: Array, northward: float, upward_square: float, constants: Constants) -> Vector:
    """g_S of (3.2), east, north, up, m/s^2.

    `northward` is 1 for the squared Earth rate of the northward component, 0 for the printed first power.
    """
    latitude, r, rate = state[LATITUDE], constants.earth_radius + state[HEIGHT], constants.earth_rate
    s, c = math.sin(latitude), math.cos(latitude)
    power = rate * (northward * rate + 1.0 - northward)
    return (
        0.0,
        -power * r * c * s,
        rate * rate * r * c * (upward_square * c + 1.0 - upward_square) - constants.gravitation,
    )


@inner
def mast_gravity(state: Array, t: float, terms: Terms, constants: Constants) -> Vector:
    """g_Q = D(lambda) C g_S of the paper, m/s^2: what it adds to specific forces that hold gravity already."""
    g = gravity(state, terms.mast_gravity_square, terms.upward_square, constants)
    inertial = from_local(state[LONGITUDE] + constants.earth_rate * t, state[LATITUDE], g)
    return resolved(quaternion(state, LAMBDA), resolved(quaternion(state, MU), inertial))


@inner
def mast_earth_rate(state: Array, constants: Constants) -> Vector:
    """Omega_Q, the Earth's rate in the mast's axes, rad/s."""
    inertial = (0.0, constants.earth_rate, 0.0)
    return resolved(quaternion(state, LAMBDA), resolved(quaternion(state, MU), inertial))


@inner
def force_difference(state: Array, sensors: Sensors) -> Vector:
    """Delta = D(eta)^T f2 - D(lambda) f1 in the mast's axes, m/s^2."""
    return add(
        back(quaternion(state, ETA), sensors.force2),
        scale(-1.0, resolved(quaternion(state, LAMBDA), sensors.force1)),
    )


@inner
def turn_rate(state: Array, u: Vector, terms: Terms, constants: Constants) -> float:
    """Return k of the mast's Coriolis term, rad/s: the vehicle's rate about the mast, or the paper's 2 Omega_Z."""
    earth = mast_earth_rate(state, constants)[2]
    earth = terms.whole_earth_rate * constants.earth_rate + (1.0 - terms.whole_earth_rate) * earth
    return (1.0 - terms.earth_turn) * u[2] + 2.0 * terms.earth_turn * earth


@inner
def leverage(terms: Terms, constants: Constants) -> float:
    """1/R, or the R that (3.14) prints."""
    return terms.length_inverted / constants.mast_length + (1.0 - terms.length_inverted) * constants.mast_length


@inner
def carried_rate(state: Array, sensors: Sensors, terms: Terms, constants: Constants) -> Vector:
    """Rate of the mast that gyroscope 2 shares in, in Q, rad/s: (w_X, w_Y, u_Z), or what the paper makes of it."""
    u = resolved(quaternion(state, LAMBDA), sensors.rate1)
    earth = scale(terms.earth_rate_again, mast_earth_rate(state, constants))
    return (
        state[RATE] + terms.relative * u[0] + earth[0],
        state[RATE + 1] + terms.relative * u[1] + earth[1],
        u[2] + earth[2],
    )


@inner
def antenna_rate(state: Array, sensors: Sensors, terms: Terms, constants: Constants) -> Vector:
    """H_d of (3.15): what gyroscope 2 shows of an antenna at rest on the mast, rad/s."""
    return resolved(quaternion(state, ETA), carried_rate(state, sensors, terms, constants))


@inner
def mast_constraint(state: Array, sensors: Sensors, terms: Terms, constants: Constants) -> float:
    """Delta_Z + R (w_X^2 + w_Y^2), m/s^2: zero for a mast of constant length, the A_Z equation of (3.12)."""
    u = resolved(quaternion(state, LAMBDA), sensors.rate1)
    x, y = state[RATE] + terms.relative * u[0], state[RATE + 1] + terms.relative * u[1]
    centripetal: float = constants.mast_length * (x * x + y * y)
    return force_difference(state, sensors)[2] + centripetal


@inner
def satellite_offset(state: Array, position: Vector, constants: Constants) -> Vector:
    """From the vehicle to a satellite, in axes east, north, up, m."""
    local = to_local(state[LONGITUDE], state[LATITUDE], position)
    return local[0], local[1], local[2] - constants.earth_radius - state[HEIGHT]


@inner
def satellite_range(state: Array, position: Vector, terms: Terms, constants: Constants) -> float:
    """Z_R, m. As printed, the difference along the Earth's axis is not squared under the root."""
    offset = from_local(state[LONGITUDE], state[LATITUDE], satellite_offset(state, position, constants))
    axial = offset[1] * (terms.range_square * offset[1] + 1.0 - terms.range_square)
    return math.sqrt(offset[0] * offset[0] + axial + offset[2] * offset[2])


@inner
def satellite_range_rate(state: Array, position: Vector, velocity: Vector, constants: Constants) -> float:
    """Z_V, m/s."""
    offset = satellite_offset(state, position, constants)
    relative = add(to_local(state[LONGITUDE], state[LATITUDE], velocity), scale(-1.0, vector(state, VELOCITY)))
    return dot(offset, relative) / math.sqrt(dot(offset, offset))


@inner
def state_rates(
    state: Array, t: float, sensors: Sensors, driven: float, terms: Terms, constants: Constants, out: Array
) -> None:
    """F(Y, t) of (3.14).

    Parameters
    ----------
    state : ndarray, shape (20,)
    t : float
        Time, s.
    sensors : Sensors
    driven : float
        1 if gyroscope 2 drives eta, which leaves no correlation of process and measurement noise, 0 if eta is constant
        between measurements, as in the paper.
    terms : Terms
    constants : Constants
    out : ndarray, shape (20,)
        Receives the rates.
    """
    mu, eta, lam = quaternion(state, MU), quaternion(state, ETA), quaternion(state, LAMBDA)
    v, latitude = vector(state, VELOCITY), state[LATITUDE]
    r = constants.earth_radius + state[HEIGHT]
    put_rate(out, MU, mu, sensors.rate1)
    out[LONGITUDE] = v[0] / (r * math.cos(latitude))
    out[LATITUDE] = v[1] / r
    force = to_local(state[LONGITUDE] + constants.earth_rate * t, latitude, back(mu, sensors.force1))
    apparent = scale(terms.transport, cross(transport_rate(state, constants), v))
    put(out, VELOCITY, add(add(force, apparent), gravity(state, 1.0, terms.upward_square, constants)))
    out[HEIGHT] = v[2]
    shown = antenna_rate(state, sensors, terms, constants)
    put_rate(out, ETA, eta, scale(driven, add(sensors.rate2, scale(-1.0, shown))))
    u = resolved(lam, sensors.rate1)
    absolute = 1.0 - terms.relative
    put_rate(out, LAMBDA, lam, (state[RATE] - absolute * u[0], state[RATE + 1] - absolute * u[1], 0.0))
    delta, k = force_difference(state, sensors), turn_rate(state, u, terms, constants)
    g, per_length = mast_gravity(state, t, terms, constants), leverage(terms, constants)
    out[RATE] = (
        terms.mast_x * per_length * delta[1]
        + terms.turn_x * k * state[RATE + 1]
        + terms.gravity_x * g[1] / constants.mast_length
    )
    out[RATE + 1] = (
        terms.mast_y * per_length * delta[0]
        + terms.turn_y * k * state[RATE]
        + terms.gravity_y * g[0] / constants.mast_length
    )
