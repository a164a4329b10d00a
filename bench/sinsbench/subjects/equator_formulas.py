"""The closed-form solution of the equator error equations, evaluated literally in float64.

Source: Loginov, Tkachenko, Chelnokov 2013, eqs. (16)-(22) and the compact formulas of the northern channel.
Two editions are kept apart by data: *printed* is what the paper prints, *corrected* what satisfies the
equations.  The longitude channel under misalignment, which the paper does not print, comes from
`particular_solution`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sinsbench.subjects.equator_model import (
    EquatorCase,
    EquatorMotion,
    FloatArray,
    NotApplicableError,
    checked_time,
    particular_solution,
    solver,
)

Edition = Literal["printed", "corrected"]


@dataclass(frozen=True)
class ModalConstants:
    """Constants (17) of the general solution, under the names of the paper.

    Attributes
    ----------
    rho1, rho2 : float
        Roots of rho^2 + p rho - q = 0, 1/s^2.
    beta3 : float
        Rate of growth, 1/s.
    omega, mu : float
        Frequencies of the northern channel and of the longitude channel, rad/s.
    alpha33, alpha35 : float
        Ratios of dv_E to dH in the growing mode and in the oscillation, 1/s.
    alpha63, nu : float
        Ratios of dlam to dH in the growing mode and in the oscillation, rad/m.
    schuler_speed : float
        sqrt(g R), m/s.
    """

    rho1: float
    rho2: float
    beta3: float
    omega: float
    mu: float
    alpha33: float
    alpha35: float
    alpha63: float
    nu: float
    schuler_speed: float


def modal_constants(v_east: float, height: float) -> ModalConstants:
    """Return the modal constants exactly as (17) states them, cancellations included.

    Parameters
    ----------
    v_east, height : float
        Eastward speed, m/s, and height, m.

    Returns
    -------
    ModalConstants
        With nu taken from rho_2 (the print lost the index).

    Raises
    ------
    NotApplicableError
        Where (17) divides by zero or takes the root of a negative number.
    """
    return _modal_constants(EquatorMotion.at(v_east, height))


def _modal_constants(motion: EquatorMotion) -> ModalConstants:
    rate, coriolis, a_H = motion.inertial_rate, motion.coriolis_rate, motion.specific_force
    a_24, R = motion.vertical_gradient, motion.radius
    if rate == 0:
        raise NotApplicableError("the formulas (17) divide by omega_N, which is zero at this speed")
    if a_H == 0:
        raise NotApplicableError("the formulas (17) divide by a_H, which is zero at this speed")
    centre = -rate * coriolis + (a_24 - a_H / R) / 2
    discriminant = (2 * rate * coriolis - a_24 + a_H / R) ** 2 + 4 * a_H * (a_24 + 2 * rate * motion.v_east / R) / R
    if discriminant < 0:
        raise NotApplicableError("rho_1 and rho_2 are complex at this speed, beyond the limit where a_H > 0")
    rho1, rho2 = centre + np.sqrt(discriminant) / 2, centre - np.sqrt(discriminant) / 2
    if rho1 <= 0:
        raise NotApplicableError("the modes are not real: rho_1 <= 0 outside the limits where a_H > 0")
    beta3, mu = np.sqrt(rho1), np.sqrt(-rho2)
    alpha33, alpha35 = (rho1 - a_24) / (2 * rate), (rho2 - a_24) / (2 * rate)
    return ModalConstants(
        rho1=float(rho1),
        rho2=float(rho2),
        beta3=float(beta3),
        omega=motion.schuler_rate,
        mu=float(mu),
        alpha33=float(alpha33),
        alpha35=float(alpha35),
        alpha63=float(-beta3 * (coriolis + alpha33) / a_H),
        nu=float(-mu * (coriolis + alpha35) / a_H),
        schuler_speed=motion.schuler_speed,
    )


class _Element(NamedTuple):
    """One element of (22): (growth * exponentials + oscillation * trigonometric) / divisor.

    The exponentials are exp(beta3 t) +- exp(-beta3 t) with the sign `parity`; the trigonometric function is
    cos(mu t) for parity +1 and sin(mu t) for parity -1.  Each part is a number times a product of constants.
    """

    row: int
    column: int
    divisor: str
    parity: int
    growth: int
    growth_factors: tuple[str, ...]
    oscillation: int
    oscillation_factors: tuple[str, ...]


_ELEMENTS = (
    _Element(2, 2, "odd", +1, +1, ("beta3", "nu"), -2, ("mu", "alpha63")),
    _Element(2, 3, "even", -1, +1, ("beta3",), +2, ("mu",)),
    _Element(2, 4, "even", -1, -1, ("beta3", "alpha35"), -2, ("mu", "alpha33")),
    _Element(2, 6, "odd", +1, -1, ("beta3", "mu"), +2, ("beta3", "mu")),
    _Element(3, 2, "odd", -1, +1, ("nu", "alpha33"), -2, ("alpha35", "alpha63")),
    _Element(3, 3, "even", +1, +1, ("alpha33",), -2, ("alpha35",)),
    _Element(3, 4, "even", +1, -1, ("alpha33", "alpha35"), +2, ("alpha33", "alpha35")),
    _Element(3, 6, "odd", -1, -1, ("mu", "alpha33"), +2, ("beta3", "alpha35")),
    _Element(4, 2, "odd", -1, +1, ("nu",), -2, ("alpha63",)),
    _Element(4, 3, "even", +1, +1, (), -2, ()),
    _Element(4, 4, "even", +1, -1, ("alpha35",), +2, ("alpha33",)),
    _Element(4, 6, "odd", -1, -1, ("mu",), +2, ("beta3",)),
    _Element(6, 2, "odd", +1, +1, ("nu", "alpha63"), -2, ("nu", "alpha63")),
    _Element(6, 3, "even", -1, +1, ("alpha63",), +2, ("nu",)),
    _Element(6, 4, "even", -1, -1, ("alpha63", "alpha35"), -2, ("nu", "alpha33")),
    _Element(6, 6, "odd", +1, -1, ("mu", "alpha63"), +2, ("beta3", "nu")),
)
"""Elements of (22) in the longitude channel, corrected edition; rows and columns count from 1."""

_PRINTED_OSCILLATION = {(2, 2): -1, (2, 3): +1, (2, 4): -1, (2, 6): +1}
"""Coefficients of the oscillation that the paper prints otherwise: row 2 lacks the factor 2."""


def _product(modes: ModalConstants, factors: tuple[str, ...]) -> float:
    return float(np.prod([getattr(modes, name) for name in factors]))


def _transition_matrix(time: FloatArray, modes: ModalConstants, edition: Edition) -> FloatArray:
    growing, decaying = np.exp(modes.beta3 * time), np.exp(-modes.beta3 * time)
    exponentials = {+1: growing + decaying, -1: growing - decaying}
    trigonometric = {+1: np.cos(modes.mu * time), -1: np.sin(modes.mu * time)}
    divisors = {
        "even": 2 * (modes.alpha33 - modes.alpha35),
        "odd": 2 * (modes.nu * modes.beta3 - modes.mu * modes.alpha63),
    }
    replaced = _PRINTED_OSCILLATION if edition == "printed" else {}
    matrix = np.zeros((time.size, 6, 6))
    for element in _ELEMENTS:
        position = (element.row, element.column)
        growth = element.growth * _product(modes, element.growth_factors)
        oscillation = replaced.get(position, element.oscillation) * _product(modes, element.oscillation_factors)
        matrix[:, element.row - 1, element.column - 1] = (
            growth * exponentials[element.parity] + oscillation * trigonometric[element.parity]
        ) / divisors[element.divisor]
    cosine, sine = np.cos(modes.omega * time), np.sin(modes.omega * time)
    matrix[:, 0, 0] = matrix[:, 4, 4] = cosine
    matrix[:, 0, 4] = -modes.schuler_speed * sine
    matrix[:, 4, 0] = sine / modes.schuler_speed
    return matrix


def transition_matrix(time: ArrayLike, v_east: float, height: float, edition: Edition = "corrected") -> FloatArray:
    """Return the transition matrix P(t) of (20), (22).

    Parameters
    ----------
    time : (n,) array_like
        Instants, s.
    v_east, height : float
        Eastward speed, m/s, and height, m.
    edition : {"corrected", "printed"}
        Which coefficients to use.

    Returns
    -------
    (n, 6, 6) array
        P(t); its element (i, j) has the unit of component i over that of component j.

    Raises
    ------
    NotApplicableError
        See `modal_constants`.
    """
    if edition not in ("printed", "corrected"):
        raise ValueError(f"edition = {edition!r}: 'printed' or 'corrected' is needed")
    return _transition_matrix(checked_time(time), modal_constants(v_east, height), edition)


def integration_constants(modes: ModalConstants, initial_errors: ArrayLike) -> FloatArray:
    """Return the constants C_1 ... C_6 of the general solution (16) from the initial errors, shape (6,)."""
    north, up, east, height, latitude, longitude = np.asarray(initial_errors, dtype=np.float64)
    even = modes.alpha33 - modes.alpha35
    odd = modes.mu * modes.alpha63 - modes.nu * modes.beta3
    half_sum = (east - height * modes.alpha35) / even / 2
    half_difference = (modes.mu * longitude - modes.nu * up) / odd / 2
    return np.array(
        [
            latitude,
            north / modes.schuler_speed,
            half_sum + half_difference,
            half_sum - half_difference,
            (modes.alpha33 * height - east) / even,
            (modes.alpha63 * up - modes.beta3 * longitude) / odd,
        ]
    )


def _exponential_part(time: FloatArray, modes: ModalConstants, constants: FloatArray) -> FloatArray:
    growing, decaying = constants[2] * np.exp(modes.beta3 * time), constants[3] * np.exp(-modes.beta3 * time)
    zero = np.zeros_like(time)
    total, difference = growing + decaying, growing - decaying
    columns = [zero, modes.beta3 * difference, modes.alpha33 * total, total, zero, modes.alpha63 * difference]
    return np.stack(columns, axis=1)


def _general_solution(time: FloatArray, modes: ModalConstants, initial: FloatArray) -> FloatArray:
    constants = integration_constants(modes, initial)
    C1, C2, _, _, C5, C6 = constants
    cosine, sine = np.cos(modes.omega * time), np.sin(modes.omega * time)
    cosine_mu, sine_mu = np.cos(modes.mu * time), np.sin(modes.mu * time)
    in_phase, quadrature = C5 * cosine_mu + C6 * sine_mu, C6 * cosine_mu - C5 * sine_mu
    oscillation = [
        modes.schuler_speed * (C2 * cosine - C1 * sine),
        modes.mu * quadrature,
        modes.alpha35 * in_phase,
        in_phase,
        C1 * cosine + C2 * sine,
        modes.nu * quadrature,
    ]
    result: FloatArray = _exponential_part(time, modes, constants) + np.stack(oscillation, axis=1)
    return result


def _principal_phase(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Principal value of the phase whose tangent (19) prints; pi/2 stands for an infinite tangent."""
    return np.arctan2(np.where(denominator < 0, -numerator, numerator), np.abs(denominator))


_PHASE: dict[Edition, Callable[[FloatArray, FloatArray], FloatArray]] = {
    "printed": _principal_phase,
    "corrected": np.arctan2,
}
"""How each edition solves tan(eps) of (19): the print leaves the quadrant open."""


def amplitudes_and_phases(
    modes: ModalConstants, initial_errors: ArrayLike, edition: Edition = "corrected"
) -> tuple[FloatArray, FloatArray]:
    """Return the amplitudes and initial phases (19) of the oscillation in each component.

    Parameters
    ----------
    modes : ModalConstants
        Constants (17).
    initial_errors : (6,) array_like
        State at t = 0.
    edition : {"corrected", "printed"}
        The corrected phase is a four-quadrant arctangent, the printed one its principal value.

    Returns
    -------
    amplitude, phase : (6,) arrays
        Amplitudes in the units of the state, phases in rad.  The amplitudes of dv_E and dlam carry the
        signs of alpha35 and nu, as printed.
    """
    C1, C2, _, _, C5, C6 = integration_constants(modes, initial_errors)
    north, east = np.hypot(C1, C2), np.hypot(C5, C6)
    amplitude = np.array([modes.schuler_speed, modes.mu, modes.alpha35, 1.0, 1.0, modes.nu])
    amplitude *= np.array([north, east, east, east, north, east])
    sines, cosines = np.array([C2, C6, C5, C5, C1, C6]), np.array([-C1, -C5, C6, C6, C2, -C5])
    return amplitude, _PHASE[edition](sines, cosines)


def _amplitude_phase(time: FloatArray, modes: ModalConstants, initial: FloatArray, edition: Edition) -> FloatArray:
    amplitude, phase = amplitudes_and_phases(modes, initial, edition)
    frequency = np.array([modes.omega, modes.mu, modes.mu, modes.mu, modes.omega, modes.mu])
    constants = integration_constants(modes, initial)
    return _exponential_part(time, modes, constants) + amplitude * np.sin(np.outer(time, frequency) + phase)


def _north_channel(case: EquatorCase, misalignment: FloatArray) -> FloatArray:
    """Response of dv_N and dphi to the misalignment: the compact formulas after (23), as printed."""
    motion, t, th = case.motion, case.time, case.inertial_longitude
    w, rate = motion.schuler_rate, motion.inertial_rate
    resonance = w**2 - rate**2
    if resonance == 0:
        raise NotApplicableError("the compact formulas divide by zero at the resonance omega = |omega_N|")
    l12, l13 = misalignment[0, 1:]
    velocity = l12 * (
        -2 * rate * np.sin(rate * t + th) + (w + rate) * np.sin(w * t + th) + (w - rate) * np.sin(w * t - th)
    ) + l13 * (2 * rate * np.cos(rate * t + th) + (w - rate) * np.cos(w * t - th) - (w + rate) * np.cos(w * t + th))
    cosines = w * (np.cos(rate * t) - np.cos(w * t))
    sines = w * np.sin(rate * t) - rate * np.sin(w * t)
    latitude = l12 * (np.cos(th) * cosines - np.sin(th) * sines) + l13 * (np.cos(th) * sines + np.sin(th) * cosines)
    response = np.zeros((t.size, 6))
    response[:, 0] = motion.specific_force * velocity / (2 * resonance)
    response[:, 4] = motion.specific_force * latitude / (motion.schuler_speed * resonance)
    return response


_Homogeneous = Callable[[FloatArray, ModalConstants, FloatArray], FloatArray]


def _solve(case: EquatorCase, homogeneous: _Homogeneous, edition: Edition) -> FloatArray:
    """Homogeneous solution, plus the response to the misalignment where the edition has one."""
    modes = _modal_constants(case.motion)
    if case.misalignment is None:
        return homogeneous(case.time, modes, case.initial_errors)
    if edition == "printed":
        raise NotApplicableError("the paper prints no response of the longitude channel to a misalignment")
    start = particular_solution(case.motion, case.misalignment, case.inertial_longitude)
    result = homogeneous(case.time, modes, case.initial_errors - start)
    result += particular_solution(case.motion, case.misalignment, case.angle)
    return result + _north_channel(case, case.misalignment)


def _by_matrix(edition: Edition) -> _Homogeneous:
    return lambda time, modes, initial: _transition_matrix(time, modes, edition) @ initial


def _by_amplitude(edition: Edition) -> _Homogeneous:
    return lambda time, modes, initial: _amplitude_phase(time, modes, initial, edition)


@solver
def printed(case: EquatorCase) -> FloatArray:
    """P(t) X(0) with the matrix exactly as printed in (22)."""
    return _solve(case, _by_matrix("printed"), "printed")


@solver
def corrected(case: EquatorCase) -> FloatArray:
    """P(t) X(0) with the matrix (22) corrected in its second row."""
    return _solve(case, _by_matrix("corrected"), "corrected")


@solver
def general_solution(case: EquatorCase) -> FloatArray:
    """General solution (16) with its constants C_1 ... C_6."""
    return _solve(case, _general_solution, "corrected")


@solver
def amplitude_phase(case: EquatorCase) -> FloatArray:
    """Amplitude and phase form (18) with the phases (19) in their right quadrants."""
    return _solve(case, _by_amplitude("corrected"), "corrected")


@solver
def amplitude_phase_printed(case: EquatorCase) -> FloatArray:
    """Amplitude and phase form (18) with the principal values of the arctangents of (19)."""
    return _solve(case, _by_amplitude("printed"), "printed")
