"""A form of the equator solution that keeps float64 accuracy at every speed.

P(t) = exp(A t) is written as f_e(A^2) + A f_o(A^2), with f_e(x) = cosh(sqrt(x) t) and f_o(x) =
sinh(sqrt(x) t)/sqrt(x), by divided differences over the two roots rho of the characteristic equation of
Loginov, Tkachenko, Chelnokov 2013, eq. (17).  Nothing is divided by omega_N, a_H or beta_3, where the
formulas (22) of the paper are singular although the solution is not.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from sinsbench.subjects.equator_model import (
    EquatorCase,
    EquatorMotion,
    FloatArray,
    checked_time,
    harmonic_denominator,
    particular_solution,
    solver,
)
from sinsbench.subjects.equator_numerical import exponential_solution, exponential_transition

DOUBLE_ROOT = 1e-4
"""Where (p^2 + 4q)/p^2 is below this, divided differences lose more digits than the exponential does."""
SERIES_LIMIT = 1.0
"""Where |rho| t^2 is below this, differences cancel: a series and the exponential take over."""
SERIES_TERMS = 10
"""Terms of that series: at the limit those left out are below 1e-17 of the sum."""
CANCELLATION = 1e-2
"""Where a denominator of the particular solution, in units of the Schuler rate, is below this, the matrix
exponential is more accurate."""


def _roots(motion: EquatorMotion) -> tuple[float, float] | None:
    """Roots rho_1 > rho_2 without cancellation; None if they are complex or nearly equal."""
    p, q = motion.p, motion.q
    discriminant = p * p + 4 * q
    if discriminant <= DOUBLE_ROOT * p * p:
        return None
    larger = -(p + math.copysign(math.sqrt(discriminant), p)) / 2
    other = -q / larger
    return max(larger, other), min(larger, other)


def _sinh_root(x: float, time: FloatArray) -> FloatArray:
    """f_o(x) = sinh(sqrt(x) t)/sqrt(x), entire in x."""
    if x == 0:
        return time
    root = math.sqrt(abs(x))
    return np.asarray((np.sinh(root * time) if x > 0 else np.sin(root * time)) / root)


def _half_square(x: float, time: FloatArray) -> FloatArray:
    """sinh(sqrt(x) t/2)^2 = (cosh(sqrt(x) t) - 1)/2, without the cancellation."""
    half = math.sqrt(abs(x)) * time / 2
    return np.asarray(np.sinh(half) ** 2 if x > 0 else -(np.sin(half) ** 2))


def _even_difference(rho1: float, rho2: float, time: FloatArray) -> FloatArray:
    """Divided difference of f_e over the roots."""
    return 2 * (_half_square(rho1, time) - _half_square(rho2, time)) / (rho1 - rho2)


def _odd_difference(rho1: float, rho2: float, time: FloatArray) -> FloatArray:
    """Divided difference of f_o over the roots.

    At small arguments it is the sum over k >= 1 of t^(2k+1)/(2k+1)! times the complete homogeneous polynomial
    of degree k - 1 in the roots.
    """
    difference = (_sinh_root(rho1, time) - _sinh_root(rho2, time)) / (rho1 - rho2)
    early = _early(rho1, rho2, time)
    small = time[early]
    power, polynomial, rho2_power = small**3 / 6, 1.0, 1.0
    series = power.copy()
    for k in range(2, SERIES_TERMS):
        rho2_power *= rho2
        polynomial = rho1 * polynomial + rho2_power
        power = power * small**2 / (2 * k * (2 * k + 1))
        series += power * polynomial
    difference[early] = series
    return difference


def _early(rho1: float, rho2: float, time: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.asarray(max(abs(rho1), abs(rho2)) * time**2 < SERIES_LIMIT)


def _transition_matrix(time: FloatArray, motion: EquatorMotion) -> FloatArray:
    roots = _roots(motion)
    if roots is None:
        return exponential_transition(time, motion)
    rho1, rho2 = roots
    # rho_2 < 0 at every speed: a_H < 0 implies p > 0.
    c2, s2 = np.cos(math.sqrt(-rho2) * time), _sinh_root(rho2, time)
    Fe, Fo = _even_difference(rho1, rho2, time), _odd_difference(rho1, rho2, time)
    R, a_H, a_24 = motion.radius, motion.specific_force, motion.vertical_gradient
    rate2, c, curvature = 2 * motion.inertial_rate, motion.coriolis_rate, motion.v_east / motion.radius**2
    # a_24 - rho_1 by its product with a_24 - rho_2: the difference itself vanishes with omega_N.
    delta = rate2 * (c * a_24 - a_H * curvature) / (a_24 - rho2)
    k = a_H * curvature - c * a_24
    P = np.zeros((time.size, 6, 6))
    P[:, 1, 1] = c2 + Fe * (rho1 + a_H / R)
    P[:, 1, 2] = rate2 * (s2 + rho1 * Fo)
    P[:, 1, 3] = a_24 * s2 + rho1 * (a_24 - rho2) * Fo
    P[:, 1, 5] = -rate2 * a_H * Fe
    P[:, 2, 1] = Fo * (a_H * curvature - c * rho1) - c * s2
    P[:, 2, 2] = c2 - delta * Fe
    P[:, 2, 3] = k * Fe
    P[:, 2, 5] = a_H * (delta * Fo - s2)
    P[:, 3, 1] = s2 + Fo * (rho1 + a_H / R)
    P[:, 3, 2] = rate2 * Fe
    P[:, 3, 3] = c2 + Fe * (a_24 - rho2)
    P[:, 3, 5] = -rate2 * a_H * Fo
    P[:, 5, 1] = -(c / R + curvature) * Fe
    P[:, 5, 2] = s2 / R - Fo * (delta / R + rate2 * curvature)
    P[:, 5, 3] = Fo * (k / R - curvature * (a_24 - rho2)) - curvature * s2
    P[:, 5, 5] = c2 + Fe * (rate2 * c - delta)
    angle = motion.schuler_rate * time
    P[:, 0, 0] = P[:, 4, 4] = np.cos(angle)
    P[:, 0, 4] = -motion.schuler_speed * np.sin(angle)
    P[:, 4, 0] = np.sin(angle) / motion.schuler_speed
    return P


def transition_matrix(time: ArrayLike, v_east: float, height: float) -> FloatArray:
    """Return the transition matrix P(t) of X' = A X at any speed and height.

    Parameters
    ----------
    time : (n,) array_like
        Instants, s.
    v_east, height : float
        Eastward speed, m/s, and height, m.

    Returns
    -------
    (n, 6, 6) array
        P(t); its element (i, j) has the unit of component i over that of component j.
    """
    return _transition_matrix(checked_time(time), EquatorMotion.at(v_east, height))


def _north_channel(case: EquatorCase, misalignment: FloatArray) -> FloatArray:
    """Response of dv_N and dphi to the misalignment: the compact formulas free of the resonance's 0/0.

    Products of sines are integrals of the form t sinc(x) cos(y), finite where omega = |omega_N|.
    """
    motion, t, th = case.motion, case.time, case.inertial_longitude
    w, rate = motion.schuler_rate, motion.inertial_rate

    def oscillation(frequency: float, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
        half = frequency * t / 2
        envelope = t * np.sinc(half / np.pi) / 2
        return envelope * np.cos(half + phase), envelope * np.sin(half + phase)

    cosine_minus, sine_minus = oscillation(rate - w, w * t + th)
    cosine_plus, sine_plus = oscillation(-rate - w, w * t - th)
    l12, l13 = misalignment[0, 1:]
    response = np.zeros((t.size, 6))
    response[:, 0] = l12 * (cosine_minus + cosine_plus) + l13 * (sine_minus - sine_plus)
    response[:, 4] = l12 * (sine_minus + sine_plus) + l13 * (cosine_plus - cosine_minus)
    response *= motion.specific_force
    response[:, 4] /= motion.schuler_speed
    return response


def _particular_solution_cancels(motion: EquatorMotion) -> bool:
    """Whether a denominator of `particular_solution` is small."""
    w = motion.schuler_rate
    return abs(harmonic_denominator(motion)) < CANCELLATION * w**4 or abs(motion.height_stiffness) < CANCELLATION * w**2


@solver
def robust(case: EquatorCase) -> FloatArray:
    """Evaluate a closed form without the removable singularities of (22).

    The matrix exponential replaces it for complex or nearly equal rho_1, rho_2 and, under a misalignment,
    near the speeds where 2 omega_N is an eigenfrequency and at early instants, when the particular solution
    would cancel against the homogeneous one.
    """
    homogeneous = _transition_matrix(case.time, case.motion)
    if case.misalignment is None:
        return homogeneous @ case.initial_errors
    roots = _roots(case.motion)
    if roots is None or _particular_solution_cancels(case.motion):
        return exponential_solution(case)
    start = particular_solution(case.motion, case.misalignment, case.inertial_longitude)
    result = homogeneous @ (case.initial_errors - start)
    result += particular_solution(case.motion, case.misalignment, case.angle)
    result += _north_channel(case, case.misalignment)
    early = _early(*roots, case.time)
    result[early] = exponential_solution(replace(case, time=case.time[early]))
    return result
