"""Derivatives of the mast's equations with respect to the state, written out by hand, as compiled functions.

Those of F and H of `sinsbench.subjects.mast.model`; F_1 and Theta are in `sinsbench.subjects.mast.disturbances`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.equations import quaternion, vector
from sinsbench.subjects.kernels import Quaternion, Vector, add, conjugate, cross, dot, scale, vector_part
from sinsbench.subjects.mast.model import (
    ETA,
    HEIGHT,
    LAMBDA,
    LATITUDE,
    LONGITUDE,
    MU,
    RATE,
    STATES,
    VELOCITY,
    Constants,
    Sensors,
    antenna_rate,
    back,
    carried_rate,
    from_local,
    gravity,
    index,
    inner,
    leverage,
    resolved,
    satellite_offset,
    satellite_range,
    satellite_range_rate,
    to_local,
    transport_rate,
    turn_rate,
)
from sinsbench.subjects.mast.terms import Terms

__all__ = ["antenna_rate_derivative", "constraint_derivative", "satellite_derivative", "state_derivative"]

Array = NDArray[np.float64]
TOP = index(0)
"""First row."""
Columns = tuple[Vector, Vector, Vector, Vector]
"""Derivative of a vector with respect to the four components of a quaternion."""


@inner
def resolved_columns(q: Quaternion, v: Vector) -> Columns:
    """Return the derivative of D(q) v with respect to q."""
    u = vector_part(q)
    along, turned = 2.0 * dot(u, v), scale(2.0 * q[0], v)
    return (
        add(scale(4.0 * q[0], v), scale(-2.0, cross(u, v))),
        (along + 2.0 * u[0] * v[0], 2.0 * u[1] * v[0] + turned[2], 2.0 * u[2] * v[0] - turned[1]),
        (2.0 * u[0] * v[1] - turned[2], along + 2.0 * u[1] * v[1], 2.0 * u[2] * v[1] + turned[0]),
        (2.0 * u[0] * v[2] + turned[1], 2.0 * u[1] * v[2] - turned[0], along + 2.0 * u[2] * v[2]),
    )


@inner
def back_columns(q: Quaternion, v: Vector) -> Columns:
    """Return the derivative of D(q)^T v with respect to q."""
    c = resolved_columns(conjugate(q), v)
    return c[0], scale(-1.0, c[1]), scale(-1.0, c[2]), scale(-1.0, c[3])


@inner
def add_product_columns(out: Array, row: int, column: int, q: Quaternion, rate: Vector) -> None:
    """Add 1/2 Phi(q) rate, the derivative of q' with respect to a number that its rate depends on."""
    u = vector_part(q)
    x, y, z = add(scale(0.5 * q[0], rate), scale(0.5, cross(u, rate)))
    out[row, column] += -0.5 * dot(u, rate)
    out[row + 1, column] += x
    out[row + 2, column] += y
    out[row + 3, column] += z


@inner
def put_turning(out: Array, first: int, rate: Vector) -> None:
    """Write the derivative of 1/2 Phi(q) rate with respect to q."""
    x, y, z = scale(0.5, rate)
    out[first, first + 1], out[first, first + 2], out[first, first + 3] = -x, -y, -z
    out[first + 1, first], out[first + 1, first + 2], out[first + 1, first + 3] = x, z, -y
    out[first + 2, first], out[first + 2, first + 1], out[first + 2, first + 3] = y, -z, x
    out[first + 3, first], out[first + 3, first + 1], out[first + 3, first + 2] = z, y, -x


@inner
def put_column(out: Array, row: int, column: int, value: Vector) -> None:
    """Write a vector down a column."""
    out[row, column] = value[0]
    out[row + 1, column] = value[1]
    out[row + 2, column] = value[2]


@inner
def antenna_rate_derivative(state: Array, sensors: Sensors, terms: Terms, constants: Constants, out: Array) -> None:
    """Write the derivative of H_d, (3.15).

    Parameters
    ----------
    state : ndarray, shape (20,)
    sensors : Sensors
    terms : Terms
    constants : Constants
    out : ndarray, shape (3, 20)
        Receives it; it must be zero elsewhere.
    """
    mu, eta, lam = quaternion(state, MU), quaternion(state, ETA), quaternion(state, LAMBDA)
    earth = resolved(mu, (0.0, constants.earth_rate, 0.0))
    by_mu = resolved_columns(mu, (0.0, constants.earth_rate, 0.0))
    by_eta = resolved_columns(eta, carried_rate(state, sensors, terms, constants))
    by_vehicle, by_earth = resolved_columns(lam, sensors.rate1), resolved_columns(lam, earth)
    for k in range(4):
        v = by_vehicle[k]
        carried = add((terms.relative * v[0], terms.relative * v[1], v[2]), scale(terms.earth_rate_again, by_earth[k]))
        put_column(out, TOP, ETA + k, by_eta[k])
        put_column(out, TOP, LAMBDA + k, resolved(eta, carried))
        put_column(out, TOP, MU + k, scale(terms.earth_rate_again, resolved(eta, resolved(lam, by_mu[k]))))
    put_column(out, TOP, RATE, resolved(eta, (1.0, 0.0, 0.0)))
    put_column(out, TOP, RATE + 1, resolved(eta, (0.0, 1.0, 0.0)))


@inner
def constraint_derivative(state: Array, sensors: Sensors, terms: Terms, constants: Constants, out: Array) -> None:
    """Write the derivative of `mast_constraint` to an array of shape (20,) that must be zero elsewhere."""
    eta, lam = quaternion(state, ETA), quaternion(state, LAMBDA)
    u = resolved(lam, sensors.rate1)
    x = 2.0 * constants.mast_length * (state[RATE] + terms.relative * u[0])
    y = 2.0 * constants.mast_length * (state[RATE + 1] + terms.relative * u[1])
    by_eta, by_lambda = back_columns(eta, sensors.force2), resolved_columns(lam, sensors.force1)
    by_vehicle = resolved_columns(lam, sensors.rate1)
    for k in range(4):
        v = by_vehicle[k]
        out[ETA + k] = by_eta[k][2]
        out[LAMBDA + k] = -by_lambda[k][2] + terms.relative * (x * v[0] + y * v[1])
    out[RATE] = x
    out[RATE + 1] = y


@inner
def satellite_derivative(
    state: Array, position: Vector, velocity: Vector, terms: Terms, constants: Constants, out: Array
) -> None:
    """Write the derivatives of range rate (row 0) and range (row 1) to a satellite.

    In axes east, north, up the offset d loses what the position gains, and the range rate is d . (v_s - V)/|d|.

    Parameters
    ----------
    state : ndarray, shape (20,)
    position, velocity : tuple of 3 floats
        Of the satellite, in Earth-fixed axes, m and m/s.
    terms : Terms
    constants : Constants
    out : ndarray, shape (2, 20)
        Receives them; it must be zero elsewhere.
    """
    latitude, longitude, v = state[LATITUDE], state[LONGITUDE], vector(state, VELOCITY)
    s, c, r = math.sin(latitude), math.cos(latitude), constants.earth_radius + state[HEIGHT]
    d = satellite_offset(state, position, constants)
    relative = add(to_local(longitude, latitude, velocity), scale(-1.0, v))
    length = math.sqrt(dot(d, d))
    rate = satellite_range_rate(state, position, velocity, constants)
    sight = scale(1.0 / length, d)
    across = scale(1.0 / length, add(relative, scale(-rate, sight)))
    # Velocity that stays fixed in S turns with it: by (0, c, s) per longitude, by -east per latitude.
    out[0, LONGITUDE] = -across[0] * r * c - dot(sight, cross((0.0, c, s), v))
    out[0, LATITUDE] = -across[1] * r + dot(sight, cross((1.0, 0.0, 0.0), v))
    out[0, HEIGHT] = -across[2]
    for k in range(3):
        out[0, VELOCITY + k] = -sight[k]
    # The range as printed counts the axial difference e by its first power: e' instead of 2 e e'.
    offset = from_local(longitude, latitude, d)
    axial = terms.range_square * offset[1] + 0.5 * (1.0 - terms.range_square)
    printed = satellite_range(state, position, terms, constants)
    gradient = to_local(longitude, latitude, scale(-1.0 / printed, (offset[0], axial, offset[2])))
    out[1, LONGITUDE] = gradient[0] * r * c
    out[1, LATITUDE] = gradient[1] * r
    out[1, HEIGHT] = gradient[2]


@inner
def put_navigation(state: Array, t: float, sensors: Sensors, terms: Terms, constants: Constants, out: Array) -> None:
    """Write the rows of longitude, latitude, velocity and height."""
    latitude, v, mu = state[LATITUDE], vector(state, VELOCITY), quaternion(state, MU)
    angle = state[LONGITUDE] + constants.earth_rate * t
    s, c, r = math.sin(latitude), math.cos(latitude), constants.earth_radius + state[HEIGHT]
    out[LONGITUDE, LATITUDE] = v[0] * s / (r * c * c)
    out[LONGITUDE, VELOCITY] = 1.0 / (r * c)
    out[LONGITUDE, HEIGHT] = -v[0] / (r * r * c)
    out[LATITUDE, VELOCITY + 1] = 1.0 / r
    out[LATITUDE, HEIGHT] = -v[1] / (r * r)
    out[HEIGHT, VELOCITY + 2] = 1.0
    by_mu = back_columns(mu, sensors.force1)
    for k in range(4):
        put_column(out, VELOCITY, MU + k, to_local(angle, latitude, by_mu[k]))
    force = to_local(angle, latitude, back(mu, sensors.force1))
    put_column(out, VELOCITY, LONGITUDE, scale(-1.0, cross((0.0, c, s), force)))
    a, rate = transport_rate(state, constants), constants.earth_rate
    by_latitude = (0.0, -2.0 * rate * s, 2.0 * rate * c + v[0] / (r * c * c))
    by_height = (v[1] / (r * r), -v[0] / (r * r), -v[0] * s / (c * r * r))
    upward = terms.upward_square * c + 1.0 - terms.upward_square
    tide = (0.0, -rate * rate * r * (c * c - s * s), -rate * rate * r * s * (upward + terms.upward_square * c))
    put_column(
        out,
        VELOCITY,
        LATITUDE,
        add(add(cross((1.0, 0.0, 0.0), force), scale(terms.transport, cross(by_latitude, v))), tide),
    )
    lifted = (0.0, -rate * rate * c * s, rate * rate * c * upward)
    put_column(out, VELOCITY, HEIGHT, add(scale(terms.transport, cross(by_height, v)), lifted))
    east = add(cross((0.0, 1.0 / r, s / (c * r)), v), cross(a, (1.0, 0.0, 0.0)))
    north = add(cross((-1.0 / r, 0.0, 0.0), v), cross(a, (0.0, 1.0, 0.0)))
    put_column(out, VELOCITY, VELOCITY, scale(terms.transport, east))
    put_column(out, VELOCITY, VELOCITY + 1, scale(terms.transport, north))
    put_column(out, VELOCITY, VELOCITY + 2, scale(terms.transport, cross(a, (0.0, 0.0, 1.0))))


@inner
def add_mast_gravity(state: Array, t: float, terms: Terms, constants: Constants, out: Array) -> None:
    """Add what the rows of w_X, w_Y owe to the gravity that the paper counts twice."""
    mu, lam, latitude = quaternion(state, MU), quaternion(state, LAMBDA), state[LATITUDE]
    angle, r = state[LONGITUDE] + constants.earth_rate * t, constants.earth_radius + state[HEIGHT]
    local = gravity(state, terms.mast_gravity_square, terms.upward_square, constants)
    inertial = from_local(angle, latitude, local)
    by_mu, by_lambda = resolved_columns(mu, inertial), resolved_columns(lam, resolved(mu, inertial))
    s, c, rate = math.sin(latitude), math.cos(latitude), constants.earth_rate
    power = rate * (terms.mast_gravity_square * rate + 1.0 - terms.mast_gravity_square)
    upward = terms.upward_square * c + 1.0 - terms.upward_square
    tide = (0.0, -power * r * (c * c - s * s), -rate * rate * r * s * (upward + terms.upward_square * c))
    shifts = (
        cross((0.0, c, s), local),
        add(cross((-1.0, 0.0, 0.0), local), tide),
        (0.0, -power * c * s, rate * rate * c * upward),
    )
    x, y = terms.gravity_x / constants.mast_length, terms.gravity_y / constants.mast_length
    for k in range(4):
        g, h = resolved(lam, by_mu[k]), by_lambda[k]
        out[RATE, MU + k] += x * g[1]
        out[RATE + 1, MU + k] += y * g[0]
        out[RATE, LAMBDA + k] += x * h[1]
        out[RATE + 1, LAMBDA + k] += y * h[0]
    for k in range(3):
        g = resolved(lam, resolved(mu, from_local(angle, latitude, shifts[k])))
        column = HEIGHT if k == 2 else LONGITUDE + k
        out[RATE, column] += x * g[1]
        out[RATE + 1, column] += y * g[0]


@inner
def put_mast(state: Array, sensors: Sensors, terms: Terms, constants: Constants, out: Array) -> None:
    """Write the rows of lambda and of w_X, w_Y, but for the gravity that the paper counts twice."""
    mu, eta, lam = quaternion(state, MU), quaternion(state, ETA), quaternion(state, LAMBDA)
    u, by_vehicle = resolved(lam, sensors.rate1), resolved_columns(lam, sensors.rate1)
    absolute = 1.0 - terms.relative
    put_turning(out, LAMBDA, (state[RATE] - absolute * u[0], state[RATE + 1] - absolute * u[1], 0.0))
    earth_rate = (0.0, constants.earth_rate, 0.0)
    by_earth = resolved_columns(lam, resolved(mu, earth_rate))
    by_mu = resolved_columns(mu, earth_rate)
    by_eta, by_lambda = back_columns(eta, sensors.force2), resolved_columns(lam, sensors.force1)
    per_length, k = leverage(terms, constants), turn_rate(state, u, terms, constants)
    x, y = terms.mast_x * per_length, terms.mast_y * per_length
    along = 2.0 * terms.earth_turn * (1.0 - terms.whole_earth_rate)
    for i in range(4):
        v = by_vehicle[i]
        add_product_columns(out, LAMBDA, LAMBDA + i, lam, (-absolute * v[0], -absolute * v[1], 0.0))
        turn = (1.0 - terms.earth_turn) * v[2] + along * by_earth[i][2]
        out[RATE, LAMBDA + i] = -x * by_lambda[i][1] + terms.turn_x * state[RATE + 1] * turn
        out[RATE + 1, LAMBDA + i] = -y * by_lambda[i][0] + terms.turn_y * state[RATE] * turn
        out[RATE, ETA + i] = x * by_eta[i][1]
        out[RATE + 1, ETA + i] = y * by_eta[i][0]
        turn = along * resolved(lam, by_mu[i])[2]
        out[RATE, MU + i] = terms.turn_x * state[RATE + 1] * turn
        out[RATE + 1, MU + i] = terms.turn_y * state[RATE] * turn
    add_product_columns(out, LAMBDA, RATE, lam, (1.0, 0.0, 0.0))
    add_product_columns(out, LAMBDA, RATE + 1, lam, (0.0, 1.0, 0.0))
    out[RATE, RATE + 1] = terms.turn_x * k
    out[RATE + 1, RATE] = terms.turn_y * k


@inner
def state_derivative(
    state: Array,
    t: float,
    sensors: Sensors,
    driven: float,
    antenna: Array,
    terms: Terms,
    constants: Constants,
    out: Array,
) -> None:
    """F_Y, the derivative of `sinsbench.subjects.mast.model.state_rates`.

    Parameters
    ----------
    state, t, sensors, driven, terms, constants
        As for `state_rates`.
    antenna : ndarray, shape (3, 20)
        What `antenna_rate_derivative` writes.
    out : ndarray, shape (20, 20)
        Receives it.
    """
    for i in range(STATES):
        for j in range(STATES):
            out[i, j] = 0.0
    put_turning(out, MU, sensors.rate1)
    put_navigation(state, t, sensors, terms, constants, out)
    eta = quaternion(state, ETA)
    shown = antenna_rate(state, sensors, terms, constants)
    put_turning(out, ETA, scale(driven, add(sensors.rate2, scale(-1.0, shown))))
    for j in range(STATES):
        if j < LONGITUDE or j >= ETA:
            add_product_columns(out, ETA, j, eta, scale(-driven, (antenna[0, j], antenna[1, j], antenna[2, j])))
    put_mast(state, sensors, terms, constants, out)
    if terms.gravity_x != 0.0 or terms.gravity_y != 0.0:
        add_mast_gravity(state, t, terms, constants, out)
