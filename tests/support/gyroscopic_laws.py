"""The laws of mechanics that each right-hand side of the gyroscopic systems must be.

The laws are stated by vectors and rotation matrices, without the quaternion formulas: the momentum of a gyroscope
changes by the moments on it, a point on a sphere accelerates by specific force and attraction. A law takes the module
of the right-hand sides, compiled or not.
"""

import numpy as np

from gyroscopic_motions import conjugate, product, turned
from sinsbench.subjects.gyroscopic.equations import Constants

#: Each law is a handful of float64 operations on numbers of order 1 to 10.
ROUNDING = 1e-12
#: All of order 1, none equal to another: a defect is as visible as it can be.
CONSTANTS = Constants(
    radius=1.7, gravity=2.3, tuning=0.6, pendulosity=1.9, rotor_momentum=0.8, inverse_inertia=0.45,
    moment_offset=0.7, moment_slope=-1.3,
)  # fmt: skip
FORCE = (0.9, -1.4, 2.2)


def quaternion(seed):
    q = np.random.default_rng(seed).normal(size=4)
    return q / np.linalg.norm(q)


E1, E2 = quaternion(1), quaternion(2)
BASIS = np.eye(3)
Y = np.array([turned(E1, axis) for axis in BASIS])  # new axes of E1 in the old ones
FIRST, SECOND, THIRD = Y
A = np.array(FORCE)


def rates(module, name, state, aid=()):
    """Rates that a right-hand side writes; NaN where it writes none, and what follows them."""
    rate = np.full(12, np.nan)
    getattr(module, name)(np.array(state, float), FORCE, np.array(aid, float), CONSTANTS, rate)
    return rate


def agree(*pairs):
    return all(np.allclose(x, y, rtol=ROUNDING, atol=ROUNDING) for x, y in pairs)


def written(rate, count):
    return bool(np.isfinite(rate[:count]).all() and np.isnan(rate[count:]).all())


def gyropendulum(module):
    """The axis form eta_3' = kappa eta_3 x a, and the turn about eta_3 that (2.6) has: -kappa a_3."""
    rate = rates(module, "gyropendulum", E1)
    return written(rate, 3) and agree((rate[:3], -0.6 * A))


def gyropendulum_programmed(module):
    rate = rates(module, "gyropendulum_programmed", E1, [1.1])
    return written(rate, 3) and agree((rate[:3] * np.sqrt(2.3 * 1.7 - 1.1**2), -A))


def gyropendulum_moments(module):
    """(H eta_3)' = M + a x (-m l eta_3), and the given spin about eta_3."""
    momentum, moment = 1.3, np.array([0.4, -0.3, 0.8])
    rate = rates(module, "gyropendulum_moments", [*E1, momentum], [*moment, 0.55])
    change = rate[3] * THIRD + momentum * np.cross(rate[:3], THIRD)
    torque = turned(E1, moment) + np.cross(A, -1.9 * THIRD)
    return written(rate, 4) and agree((change, torque), (rate[:3] @ THIRD, 0.55))


def gyroscope_general(module):
    """(L eta_3)' = M + a x (m l) with the centre of mass anywhere."""
    momentum, moment, arm = 1.3, np.array([0.4, -0.3, 0.8]), np.array([0.2, 0.9, -0.6])
    rate = rates(module, "gyroscope_general", [*E1, momentum], [*moment, 0.55, *arm])
    change = rate[3] * THIRD + momentum * np.cross(rate[:3], THIRD)
    torque = turned(E1, moment) + np.cross(A, turned(E1, arm))
    return written(rate, 4) and agree((change, torque), (rate[:3] @ THIRD, 0.55))


def bi_gyro(module):
    rate = rates(module, "bi_gyro", [*E1, *E2])
    return written(rate, 6) and agree((rate[:3], -0.6 * A), (rate[3:6], 0.6 * A))


def bi_gyro_self_tuned(module):
    """H = m l V cos(alpha), 2 alpha the angle between the axes."""
    half = np.arccos(THIRD @ turned(E2, BASIS[2])) / 2
    kappa = 1 / (np.sqrt(2.3 * 1.7) * np.cos(half))
    rate = rates(module, "bi_gyro_self_tuned", [*E1, *E2])
    return written(rate, 6) and agree((rate[:3], -kappa * A), (rate[3:6], kappa * A))


def _frame(rate, angle):
    """(H Y2)' is the moment of the weight, H = 2B cos E."""
    momentum, change = 1.6 * np.cos(angle), -1.6 * np.sin(angle) * rate[3]
    moved = change * SECOND + momentum * np.cross(rate[:3], SECOND)
    return moved, np.cross(A, -1.9 * THIRD)


def gyroframe(module):
    rate = rates(module, "gyroframe", [*E1, 0.7])
    turning = 1.6 * np.cos(0.7) / (1.9 * 1.7)  # H/(m l R)
    return written(rate, 4) and agree(_frame(rate, 0.7), (rate[:3] @ SECOND, turning))


def gyroframe_linear(module):
    rate = rates(module, "gyroframe_linear", [*E1, 0.7])
    balance = 1.6 * np.sin(0.7) * (rate[:3] @ SECOND)
    return written(rate, 4) and agree(_frame(rate, 0.7), (balance, -(0.7 - 1.3 * 0.7)))


def gyroframe_moments(module):
    momentum, moment = 1.3, np.array([0.4, -0.3, 0.8])
    rate = rates(module, "gyroframe_moments", [*E1, momentum], [*moment, 0.55])
    change = rate[3] * SECOND + momentum * np.cross(rate[:3], SECOND)
    torque = turned(E1, moment) + np.cross(A, -1.9 * THIRD)
    return written(rate, 4) and agree((change, torque), (rate[:3] @ SECOND, 0.55))


def _on_sphere(rate, velocity, change, radius, climb):
    """r^' = v/r, and v' tangential + the centripetal part = a tangential - r' v/r."""
    turn = np.cross(rate[:3], THIRD)
    expected = A - (A @ THIRD) * THIRD - velocity @ velocity / radius * THIRD - climb / radius * velocity
    return (turn, velocity / radius), (change, expected)


def gyrohorizoncompass(module):
    h, radius, climb = 1.2, 2.6, 0.35
    rate = rates(module, "gyrohorizoncompass", [*E1, h], [radius, climb])
    change = rate[3] * FIRST + h * np.cross(rate[:3], FIRST)
    return written(rate, 4) and agree(*_on_sphere(rate, h * FIRST, change, radius, climb))


def two_component(module):
    v1, v2, radius, climb = 1.2, -0.7, 2.6, 0.35
    rate = rates(module, "two_component", [*E1, v1, v2], [radius, climb])
    velocity = v1 * FIRST + v2 * SECOND
    change = rate[3] * FIRST + rate[4] * SECOND + np.cross(rate[:3], velocity)
    laws = _on_sphere(rate, velocity, change, radius, climb)
    return written(rate, 5) and agree(*laws, (rate[:3] @ THIRD, 0.0))


def full_equations(module):
    """omega = n L and L' = M + a x (-m l Y3'), where 2 z' = omega o z."""
    omega, moment = np.array([0.5, -0.8, 0.3]), np.array([0.4, -0.3, 0.8])
    slope = product(np.array([0.0, *omega]), E1) / 2
    rate = rates(module, "full_equations", [*E1, *slope], moment)
    curvature = 2 * product(rate[4:8], conjugate(E1))
    torque = moment + np.cross(A, -1.9 * THIRD)
    laws = (rate[:4], slope), (curvature[1:], 0.45 * torque), (curvature[0], -2 * slope @ slope)
    return written(rate, 8) and agree(*laws)


def newton(module):
    position, velocity = np.array([0.6, -1.1, 0.9]), np.array([0.2, 0.5, -0.4])
    rate = rates(module, "newton", [*position, *velocity])
    attraction = 2.3 * (1.7 / np.linalg.norm(position)) ** 2 * position / np.linalg.norm(position)
    return written(rate, 6) and agree((rate[:3], velocity), (rate[3:6], A - attraction))


def _composed(rate, reference):
    """2 e' e~ of e = nu o lambda."""
    nu, deviation = E1, E2
    slopes = [product(np.array([0.0, *rate[3 * k : 3 * k + 3]]), q) / 2 for k, q in enumerate((nu, deviation))]
    e = product(nu, deviation)
    change = product(slopes[0], deviation) + product(nu, slopes[1])
    return e, 2 * product(change, conjugate(e))[1:], (rate[:3], turned(nu, reference))


def deviation(module):
    reference, turning = np.array([0.3, -0.2, 0.6]), np.array([-0.5, 0.9, 0.1])
    rate = rates(module, "deviation", [*E1, *E2], [*reference, *turning])
    e, omega, law = _composed(rate, reference)
    return written(rate, 6) and agree((omega, turned(e, turning)), law)


def gyropendulum_deviation(module):
    """(2.7) is (2.4), w*_X = -kappa a_X - (M x eta_3)_X/H, seen from the trihedron."""
    reference, moment, momentum = np.array([0.3, -0.2, 0.6]), np.array([0.4, -0.3, 0.8]), 1.3
    rate = rates(module, "gyropendulum_deviation", [*E1, *E2, momentum], [*reference, *moment])
    e, omega, law = _composed(rate, reference)
    third = turned(e, BASIS[2])
    expected = -1.9 / momentum * A - np.cross(turned(e, moment), third) / momentum
    return written(rate, 7) and agree((omega, expected), law, (rate[6], moment[2]))


def conditions(module):
    """What each condition measures."""
    pair, apart = np.array([*E1, *E2]), THIRD + turned(E2, BASIS[2])
    numbers = np.array([*E1, 0.7, 0.0, 0.0, 0.0, -0.4])
    position = np.array([0.6, -1.1, 0.9])
    none = np.zeros(0)
    expected = {
        "unconditional": (pair, none, 1.0),
        "below_schuler_speed": (pair, np.array([1.1]), 1 - 1.1**2 / (2.3 * 1.7)),
        "axes_apart_from_opposite": (pair, none, apart @ apart),
        "frame_open": (numbers, none, 0.7),
        "first_number_positive": (numbers, none, 0.7),
        "second_number_positive": (numbers, none, -0.4),
        "away_from_centre": (position, none, position @ position / 1.7**2),
    }
    far = np.array([*E1, 1.3])
    if not agree((module.frame_open(far, none, CONSTANTS), np.pi / 2 - 1.3)):
        return False
    return agree(*((getattr(module, name)(*given, CONSTANTS), value) for name, (*given, value) in expected.items()))


LAWS = (
    gyropendulum, gyropendulum_programmed, gyropendulum_moments, gyroscope_general, bi_gyro, bi_gyro_self_tuned,
    gyroframe, gyroframe_linear, gyroframe_moments, gyrohorizoncompass, full_equations, two_component, newton,
    deviation, gyropendulum_deviation, conditions,
)  # fmt: skip
