"""The 17 errors of a multiplicative filter and how they sit in the 20 numbers of the state, as compiled functions.

    theta_mu[3], longitude, latitude, V[3], H, theta_nu[3] (or theta_eta[3]), theta_lambda[3], w[2]

mu and lambda are corrected from the right, mu o exp(theta_mu), lambda o exp(theta_lambda), the numbers by addition. In
the coordinates nu the composite lambda o eta is corrected, eta <- exp(-theta_lambda) o eta o exp(theta_nu); in the
coordinates eta it is eta itself, eta <- eta o exp(theta_eta). `composite` is 1 for the first, 0 for the second.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.equations import quaternion, vector
from sinsbench.subjects.kernels import (
    Quaternion,
    Vector,
    conjugate,
    cross,
    dot,
    quaternion_product,
    scale,
    vector_part,
)
from sinsbench.subjects.mast.model import ETA, LAMBDA, LONGITUDE, MU, RATE, axis, entry, index, inner, resolved

__all__ = ["ERRORS", "corrected", "difference", "put_quaternion", "reduced", "spread"]

Array = NDArray[np.float64]

ERRORS = 17
THETA_MU, NUMBERS, THETA_NU, THETA_LAMBDA, RATES = map(index, (0, 3, 9, 12, 15))


@inner
def exponential(v: Vector) -> Quaternion:
    """Quaternion of a rotation vector; below 1e-4 rad sin(x)/x is its series, exact to 1e-17."""
    square = dot(v, v)
    angle = math.sqrt(square)
    factor = 0.5 - square / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), factor * v[0], factor * v[1], factor * v[2]


@inner
def logarithm(q: Quaternion) -> Vector:
    """Rotation vector of a unit quaternion or its negative; the arc tangent is accurate at every angle."""
    u = vector_part(q)
    length = math.sqrt(dot(u, u))
    if length == 0.0:
        return 0.0, 0.0, 0.0
    sign = 1.0 if q[0] >= 0.0 else -1.0
    return scale(2.0 * sign * math.atan2(length, abs(q[0])) / length, u)


@inner
def put_quaternion(state: Array, first: int, q: Quaternion) -> None:
    """Write a quaternion from an index on, normalised."""
    norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    state[first] = q[0] / norm
    state[first + 1] = q[1] / norm
    state[first + 2] = q[2] / norm
    state[first + 3] = q[3] / norm


@inner
def corrected(state: Array, error: Array, composite: float, out: Array) -> None:
    """Write the state [+] an error of shape (17,), over the state itself if need be."""
    tilt = vector(error, THETA_LAMBDA)
    put_quaternion(out, MU, quaternion_product(quaternion(state, MU), exponential(vector(error, THETA_MU))))
    for i in range(LONGITUDE, ETA):
        out[i] = state[i] + error[NUMBERS + i - LONGITUDE]
    eta = quaternion_product(quaternion(state, ETA), exponential(vector(error, THETA_NU)))
    put_quaternion(out, ETA, quaternion_product(exponential(scale(-composite, tilt)), eta))
    put_quaternion(out, LAMBDA, quaternion_product(quaternion(state, LAMBDA), exponential(tilt)))
    out[RATE] = state[RATE] + error[RATES]
    out[RATE + 1] = state[RATE + 1] + error[RATES + 1]


@inner
def difference(state: Array, origin: Array, composite: float, out: Array) -> None:
    """Write the error with state = origin [+] error, the inverse of `corrected`."""
    mu = logarithm(quaternion_product(conjugate(quaternion(origin, MU)), quaternion(state, MU)))
    tilt = logarithm(quaternion_product(conjugate(quaternion(origin, LAMBDA)), quaternion(state, LAMBDA)))
    eta = quaternion_product(exponential(scale(composite, tilt)), quaternion(state, ETA))
    nu = logarithm(quaternion_product(conjugate(quaternion(origin, ETA)), eta))
    for i in range(3):
        out[THETA_MU + i] = mu[i]
        out[THETA_NU + i] = nu[i]
        out[THETA_LAMBDA + i] = tilt[i]
    for i in range(LONGITUDE, ETA):
        out[NUMBERS + i - LONGITUDE] = state[i] - origin[i]
    out[RATES] = state[RATE] - origin[RATE]
    out[RATES + 1] = state[RATE + 1] - origin[RATE + 1]


@inner
def put_half_product(out: Array, row: int, column: int, q: Quaternion, sign: float) -> None:
    """Write sign/2 times what a small rotation, multiplied from the right (1) or the left (-1), adds to q."""
    u = vector_part(q)
    for k in range(3):
        unit = axis(k)
        turned = cross(u, unit)
        out[row, column + k] = -0.5 * sign * u[k]
        for i in range(3):
            out[row + 1 + i, column + k] = 0.5 * (sign * q[0] * unit[i] + turned[i])


@entry
def spread(state: Array, composite: float, out: Array) -> None:
    """Write the derivative of state [+] error at error = 0, to an array of shape (20, 17) that is zero elsewhere."""
    put_half_product(out, MU, THETA_MU, quaternion(state, MU), 1.0)
    for i in range(LONGITUDE, ETA):
        out[i, NUMBERS + i - LONGITUDE] = 1.0
    put_half_product(out, ETA, THETA_NU, quaternion(state, ETA), 1.0)
    if composite != 0.0:
        put_half_product(out, ETA, THETA_LAMBDA, quaternion(state, ETA), -1.0)
    put_half_product(out, LAMBDA, THETA_LAMBDA, quaternion(state, LAMBDA), 1.0)
    out[RATE, RATES] = 1.0
    out[RATE + 1, RATES + 1] = 1.0


@inner
def turning_part(values: Array, first: int, column: int, q: Quaternion) -> Vector:
    """Rotation vector theta that changes q by the four components given: 2 Phi(q)^T dq."""
    change = (values[first, column], values[first + 1, column], values[first + 2, column], values[first + 3, column])
    return scale(2.0, vector_part(quaternion_product(conjugate(q), change)))


@entry
def reduced(state: Array, values: Array, composite: float, out: Array) -> None:
    """Write the errors (17, m) that make the changes of the state (20, m): the inverse of `spread` on its range."""
    mu, eta, lam = quaternion(state, MU), quaternion(state, ETA), quaternion(state, LAMBDA)
    for j in range(values.shape[1]):
        turned, tilt = turning_part(values, MU, j, mu), turning_part(values, LAMBDA, j, lam)
        nu, carried = turning_part(values, ETA, j, eta), resolved(eta, scale(composite, tilt))
        for i in range(3):
            out[THETA_MU + i, j] = turned[i]
            out[THETA_NU + i, j] = nu[i] + carried[i]
            out[THETA_LAMBDA + i, j] = tilt[i]
        for i in range(LONGITUDE, ETA):
            out[NUMBERS + i - LONGITUDE, j] = values[i, j]
        out[RATES, j] = values[RATE, j]
        out[RATES + 1, j] = values[RATE + 1, j]
