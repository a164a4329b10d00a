"""Initial states of gyroscopic systems from the motion at the start.

A rule is a function of the start and of the constants of the system, and returns the state. Angles alpha turn the
third axis of a gyropendulum from the vertical about the velocity.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Start
from sinsbench.subjects.gyroscopic.equations import Constants
from sinsbench.subjects.kernels import compiled

__all__ = ["StartRule", "products", "quaternions_of_axes", "rotated"]

Array = NDArray[np.float64]
StartRule = Callable[[Start, Constants], Array]
Inclination = Callable[[Start, Constants], tuple[float, float]]
"""Angles alpha of gyropendulums with momentum along and against their third axis, rad."""


def quaternions_of_axes(axes: Array) -> Array:
    """Return the quaternions X -> Y of trihedra.

    Parameters
    ----------
    axes : ndarray, shape (..., 3, 3)
        Row k is the k-th axis of Y in X.

    Returns
    -------
    ndarray, shape (..., 4)
        Unit quaternions, scalar first.
    """
    result = np.empty((*axes.shape[:-2], 4))
    _quaternions_of_axes(np.ascontiguousarray(axes, np.float64).reshape(-1, 3, 3), result.reshape(-1, 4))
    return result


@compiled
def _quaternions_of_axes(axes: Array, result: Array) -> None:
    """Start from the largest of the squares 4 q_i^2 (Shepperd 1978): nothing small is divided by."""
    for n in range(len(axes)):
        x, y, z = axes[n, 0], axes[n, 1], axes[n, 2]
        trace = x[0] + y[1] + z[2]
        if trace >= max(x[0], y[1], z[2]):
            q = 1.0 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]
        elif x[0] >= max(y[1], z[2]):
            q = y[2] - z[1], 1.0 + 2.0 * x[0] - trace, x[1] + y[0], z[0] + x[2]
        elif y[1] >= z[2]:
            q = z[0] - x[2], x[1] + y[0], 1.0 + 2.0 * y[1] - trace, y[2] + z[1]
        else:
            q = x[1] - y[0], z[0] + x[2], y[2] + z[1], 1.0 + 2.0 * z[2] - trace
        norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        for i in range(4):
            result[n, i] = q[i] / norm


def products(first: Array, second: Array) -> Array:
    """Return the Hamilton products of quaternions, shape (..., 4) each."""
    a, u, b, v = first[..., :1], first[..., 1:], second[..., :1], second[..., 1:]
    scalar = a * b - np.sum(u * v, axis=-1, keepdims=True)
    return np.concatenate([scalar, a * v + b * u + np.cross(u, v)], axis=-1)


def rotated(quaternion: Array, vectors: Array) -> Array:
    """Return q o v o q~ for vectors (..., 3) and a unit quaternion, or one for each."""
    scalar, axis = quaternion[..., :1], quaternion[..., 1:]
    twist = 2 * np.cross(axis, vectors)
    return np.asarray(vectors + scalar * twist + np.cross(axis, twist))


def darboux_quaternion(start: Start) -> Array:
    """Return e_D: X -> Darboux trihedron of the absolute motion."""
    return quaternions_of_axes(start.axes())


def paper_inclination(start: Start, constants: Constants) -> tuple[float, float]:
    """Return alpha = -(m l/H) v, section 2.1 of Chelnokov 1991: relative error (v/V)^2."""
    alpha = -constants.tuning * start.speed
    return alpha, -alpha


def exact_inclination(start: Start, constants: Constants) -> tuple[float, float]:
    """Return alpha of sin alpha = -v/sqrt(g R): where H = m l sqrt(g R - v^2), this inclination holds for any motion.

    Raises
    ------
    BrokenConditionError
        If the speed is not below sqrt(g R).
    """
    if start.speed >= start.schuler_speed:
        raise BrokenConditionError("absolute speed < sqrt(g R)", 0.0)
    alpha = -math.asin(start.speed / start.schuler_speed)
    return alpha, -alpha


def equilibrium_inclination(start: Start, constants: Constants) -> tuple[float, float]:
    """Return alpha at which a gyropendulum of constant H rests in the trihedron, were v and its turn rate w3 constant.

    tan alpha = -v (1/R + kappa w3)/(w3 + kappa (g - v^2/R)), with kappa < 0 for the opposite momentum.

    Raises
    ------
    ValueError
        If the start does not tell its turn rate w3.
    """
    if start.turn_rate is None:
        raise ValueError("the start at equilibrium needs turn_rate")
    v, kappa, turn_rate = start.speed, constants.tuning, start.turn_rate
    radius = start.radius
    weight = start.gravity - v * v / radius
    positive, negative = (
        math.atan(-v * (1 / radius + k * turn_rate) / (turn_rate + k * weight)) for k in (kappa, -kappa)
    )
    return positive, negative


def _inclined(start: Start, alpha: float) -> Array:
    y1, y2, y3 = start.axes()
    sine, cosine = math.sin(alpha), math.cos(alpha)
    return quaternions_of_axes(np.array([y1, cosine * y2 + sine * y3, cosine * y3 - sine * y2]))


def pendulum(inclination: Inclination) -> StartRule:
    """Return the rule of one gyropendulum: state e."""
    return lambda start, constants: _inclined(start, inclination(start, constants)[0])


def pendulum_pair(inclination: Inclination) -> StartRule:
    """Return the rule of two gyropendulums of opposite momenta: state e_1, e_2."""

    def rule(start: Start, constants: Constants) -> Array:
        return np.concatenate([_inclined(start, alpha) for alpha in inclination(start, constants)])

    return rule


def with_momentum(rule: StartRule) -> StartRule:
    """Return a rule that appends H = m l/kappa to the state of another."""
    return lambda start, constants: np.append(rule(start, constants), constants.pendulosity / constants.tuning)


def deviation(inclination: Inclination) -> StartRule:
    """Return the rule of the deviation from the Darboux trihedron: state nu = e_D, lambda = q1(alpha)."""

    def rule(start: Start, constants: Constants) -> Array:
        half = inclination(start, constants)[0] / 2
        return np.array([*darboux_quaternion(start), math.cos(half), math.sin(half), 0.0, 0.0])

    return rule


def momentum_frame(start: Start, constants: Constants) -> Array:
    """(2.12): e = e_D, H = m l v."""
    return np.append(darboux_quaternion(start), constants.pendulosity * start.speed)


def compass(start: Start, constants: Constants) -> Array:
    """(2.15): e = e_D, h = v."""
    return np.append(darboux_quaternion(start), start.speed)


def two_rotor_frame(start: Start, constants: Constants) -> Array:
    """(2.14): e = e_D, cos E = m l v/(2B).

    Raises
    ------
    BrokenConditionError
        If the speed is not below 2B/(m l).
    """
    cosine = constants.pendulosity * start.speed / (2 * constants.rotor_momentum)
    if not cosine < 1:
        raise BrokenConditionError("absolute speed < 2B/(m l)", 0.0)
    return np.append(darboux_quaternion(start), math.acos(cosine))


def _any_azimuth(start: Start) -> Array:
    """Return the axes of the trihedron, or of one of any azimuth where the vehicle does not move."""
    if start.speed > 0:
        return start.axes()
    across = np.cross(start.vertical, np.eye(3)[np.argmin(np.abs(start.vertical))])
    across /= np.linalg.norm(across)
    return np.array([across, np.cross(start.vertical, across), start.vertical])


def momentum_of_motion(start: Start, constants: Constants) -> Array:
    """(3.1) with L = m l r^ x v and third axis along r^: state z, z' = (1/2) (r^ x v/R) o z."""
    z = quaternions_of_axes(_any_azimuth(start))
    turning = np.concatenate([[0.0], np.cross(start.vertical, start.velocity) / (2 * start.radius)])
    return np.concatenate([z, products(turning, z)])


def azimuth_free(start: Start, constants: Constants) -> Array:
    """Two-component inertial system: nu with its third axis along r^, v_1, v_2."""
    axes = _any_azimuth(start)
    return np.array([*quaternions_of_axes(axes), *(axes[:2] @ start.velocity)])


def position_and_velocity(start: Start, constants: Constants) -> Array:
    """Newton's equation: state r = |r| r^, v."""
    distance = start.radius if start.distance is None else start.distance
    return np.concatenate([distance * start.vertical, start.velocity])
