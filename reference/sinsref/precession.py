r"""Regular precession of a rigid body and its dual analogue: exact attitude, apparent velocity, increments.

The body spins at the rate :math:`\nu`, its spin axis precesses at :math:`\mu = \varepsilon\nu` at the nutation angle
:math:`\vartheta`. Dual parts :math:`\nu^\circ` (m/s^2) and :math:`\vartheta^\circ` (m/s) of spin rate and
nutation make the specific force, by the transfer principle of Kotelnikov and Study. :math:`\varepsilon =
-1` is classical coning.

Every dual quantity here comes from the formula of its principal part, evaluated in dual numbers: (4.3),
(4.5)-(4.7), the velocity increments and their resolved forms are nowhere written out (the tests do that, and compare).

Source: Lebedev, Panov 1989, sections 4 and 6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sinsref.arithmetic import Arithmetic, Number
from sinsref.dual_quaternion import apparent_velocity, transfer
from sinsref.exact import ExactNumber
from sinsref.quaternion import conjugate, normalised, product, rotate


@dataclass(frozen=True)
class DualPrecession:
    """Parameters of the motion, exactly given.

    Attributes
    ----------
    spin_rate : ExactNumber
        nu, rad/s.
    precession_ratio : ExactNumber
        eps, the precession rate in units of the spin rate.
    nutation : ExactNumber
        theta, rad.
    spin_rate_dual : ExactNumber
        nu0, m/s^2.
    nutation_dual : ExactNumber
        theta0, m/s.
    initial_attitude : tuple of 4 ExactNumber, or None
        Quaternion body to inertial at t = 0, normalised before use; None for that of the precession frame, in which the
        precession axis is z.
    initial_velocity : tuple of 3 ExactNumber
        Apparent velocity at t = 0 in inertial axes, m/s.
    """

    spin_rate: ExactNumber
    precession_ratio: ExactNumber
    nutation: ExactNumber
    spin_rate_dual: ExactNumber
    nutation_dual: ExactNumber
    initial_attitude: tuple[ExactNumber, ...] | None
    initial_velocity: tuple[ExactNumber, ...]

    def principal(self, ar: Arithmetic) -> list[Number]:
        """Return (nu, eps, theta) in an arithmetic."""
        return [ar.number(self.spin_rate), ar.number(self.precession_ratio), ar.number(self.nutation)]

    def dual(self, ar: Arithmetic) -> list[Number]:
        """Return the dual parts (nu0, 0, theta0): the ratio of the rates has none."""
        return [ar.number(self.spin_rate_dual), ar.number(0), ar.number(self.nutation_dual)]


def precession_attitude(ar: Arithmetic, parameters: list[Number], time: Number) -> list[Number]:
    """Return Q(t): body relative to the precession frame (4.4), as spin after nutation after precession.

    Parameters
    ----------
    ar : Arithmetic
    parameters : list of 3 Number
        nu, eps, theta.
    time : Number
        s.
    """
    nu, eps, theta = parameters
    sin_half, cos_half = ar.sin_cos(theta / 2)
    sin_sum, cos_sum = ar.sin_cos((eps + 1) * nu / 2 * time)
    sin_difference, cos_difference = ar.sin_cos((1 - eps) * nu / 2 * time)
    return [cos_half * cos_sum, sin_half * cos_difference, -(sin_half * sin_difference), cos_half * sin_sum]


def body_rate(ar: Arithmetic, parameters: list[Number], time: Number) -> list[Number]:
    """Return the angular rate in body axes (4.1), rad/s; in dual numbers also the specific force (4.3), m/s^2."""
    nu, eps, theta = parameters
    sin_theta, cos_theta = ar.sin_cos(theta)
    sine, cosine = ar.sin_cos(nu * time)
    equatorial = eps * nu * sin_theta
    return [equatorial * sine, equatorial * cosine, nu * (eps * cos_theta + 1)]


def body_increment(ar: Arithmetic, parameters: list[Number], time: Number, interval: Number) -> list[Number]:
    """Return the integral of `body_rate` from ``time - interval`` to ``time`` (the formulas that close section 4)."""
    nu, eps, theta = parameters
    sin_theta, cos_theta = ar.sin_cos(theta)
    sin_end, cos_end = ar.sin_cos(nu * time)
    sin_start, cos_start = ar.sin_cos(nu * (time - interval))
    equatorial = eps * sin_theta
    return [
        equatorial * (cos_start - cos_end),
        equatorial * (sin_end - sin_start),
        nu * (eps * cos_theta + 1) * interval,
    ]


def body_rotation(ar: Arithmetic, parameters: list[Number], time: Number, interval: Number) -> list[Number]:
    """Return conj(Q(t - h)) o Q(t): the rotation from ``time - interval`` to ``time``, in body axes.

    The body turns by eps nu h about the precession axis, which stands at the angle theta to the spin axis and seen from
    the body has turned back by nu (t - h), then by nu h about the spin axis.
    """
    nu, eps, theta = parameters
    sin_theta, cos_theta = ar.sin_cos(theta)
    sine, cosine = ar.sin_cos(nu * (time - interval))
    sin_precession, cos_precession = ar.sin_cos(eps * nu * interval / 2)
    sin_spin, cos_spin = ar.sin_cos(nu * interval / 2)
    equatorial, zero = sin_precession * sin_theta, ar.number(0)
    precession = [cos_precession, equatorial * sine, equatorial * cosine, sin_precession * cos_theta]
    return product(precession, [cos_spin, zero, zero, sin_spin])


def _transferred(
    ar: Arithmetic, motion: DualPrecession, formula: Callable[..., list[Number]], *times: Number
) -> tuple[list[Number], list[Number]]:
    """Return a formula of the principal parameters and of times, and its dual part."""
    return transfer(
        ar,
        lambda duals, p: formula(duals, p, *(duals.constant(time) for time in times)),
        motion.principal(ar),
        motion.dual(ar),
    )


def particular_solution(ar: Arithmetic, motion: DualPrecession, time: Number) -> tuple[list[Number], list[Number]]:
    """Return Q (4.4) and R (4.5): attitude in the precession frame and its dual part."""
    return _transferred(ar, motion, precession_attitude, time)


def angular_rate_and_specific_force(
    ar: Arithmetic, motion: DualPrecession, time: Number
) -> tuple[list[Number], list[Number]]:
    """Return angular rate (4.1), rad/s, and specific force (4.3), m/s^2, in body axes."""
    return _transferred(ar, motion, body_rate, time)


def increments(
    ar: Arithmetic, motion: DualPrecession, time: Number, interval: Number
) -> tuple[list[Number], list[Number]]:
    """Return angle increment, rad, and velocity increment, m/s, over the interval that ends at `time`.

    They are the integrals (2.1) of angular rate and of specific force in body axes.
    """
    return _transferred(ar, motion, body_increment, time, interval)


def mean_rates(
    ar: Arithmetic, motion: DualPrecession, time: Number, interval: Number
) -> tuple[list[Number], list[Number]]:
    """Return mean angular rate, rad/s, and mean specific force, m/s^2, over the interval that ends at `time`."""
    angle, velocity = increments(ar, motion, time, interval)
    return [x / interval for x in angle], [x / interval for x in velocity]


def accumulated(ar: Arithmetic, motion: DualPrecession, time: Number) -> tuple[list[Number], list[Number]]:
    """Return the integrals from 0 to `time` of angular rate, rad, and of specific force, m/s, in body axes."""
    return increments(ar, motion, time, time)


def resolved_increments(
    ar: Arithmetic, motion: DualPrecession, time: Number, interval: Number
) -> tuple[list[Number], list[Number]]:
    """Return the change of the apparent velocity over the interval that ends at `time`, m/s, in two fixed frames.

    Returns
    -------
    start, end : list of 3 Number
        Integral of the specific force resolved in the axes that the body has at the start of the interval, and at its
        end: dW_I and dW_E of (2.6), from the dual quaternion of the step.
    """
    return apparent_velocity(*_transferred(ar, motion, body_rotation, time, interval))


def frame_offset(ar: Arithmetic, motion: DualPrecession) -> list[Number]:
    """Return C = Lambda(0) o conj(Q(0)): the precession frame relative to the inertial frame."""
    if motion.initial_attitude is None:
        return [ar.number(k) for k in (1, 0, 0, 0)]
    given = [ar.number(x) for x in motion.initial_attitude]
    sine, cosine = ar.sin_cos(ar.number(motion.nutation) / 2)
    zero = ar.number(0)
    # With three components zero the norm is known without a square root, and exact zeros stay exact.
    unit = given if _is_axis(motion) else normalised(ar, given)
    return product(unit, conjugate([cosine, sine, zero, zero]))


def _is_axis(motion: DualPrecession) -> bool:
    texts = sorted(x.text for x in motion.initial_attitude or ())
    return texts == ["0", "0", "0", "1"]


def solution(ar: Arithmetic, motion: DualPrecession, time: Number) -> tuple[list[Number], list[Number], list[Number]]:
    """Return the exact solution of (1.6), (1.7) with the motion's initial values.

    Parameters
    ----------
    ar : Arithmetic
    motion : DualPrecession
    time : Number
        s.

    Returns
    -------
    attitude : list of 4 Number
        Lambda = C o Q (1.8), body to inertial.
    velocity_inertial, velocity_body : list of 3 Number
        Apparent velocity (1.10), (1.11), m/s.

    Notes
    -----
    The printed C_I below (1.11) is a slip; here W_I(t) = W_I(0) + C o (U_I(t) - U_I(0)) o conj(C), which is also
    exact at t = 0.
    """
    offset = frame_offset(ar, motion)
    unit, dual = particular_solution(ar, motion, time)
    attitude = product(offset, unit)
    travelled, _ = apparent_velocity(unit, dual)
    # U_I(0) = (theta0, 0, 0): (4.7) at t = 0.
    change = [travelled[0] - ar.number(motion.nutation_dual), travelled[1], travelled[2]]
    inertial = [ar.number(x) + y for x, y in zip(motion.initial_velocity, rotate(offset, change), strict=True)]
    return attitude, inertial, rotate(conjugate(attitude), inertial)
