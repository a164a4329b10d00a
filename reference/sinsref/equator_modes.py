"""Modes of the error equations on the equator: constants (17), amplitudes and phases (18)-(19), limiting speeds.

Source: Loginov, Tkachenko, Chelnokov 2013, equations (16)-(19).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sinsref.arithmetic import Arithmetic, Number
from sinsref.earth import EQUATORIAL_GRAVITY, ROTATION_RATE, SEMI_MAJOR_AXIS
from sinsref.equator import EquatorModel
from sinsref.exact import ExactNumber


class NoRealModesError(ValueError):
    """The roots are not one positive and one negative: the exponential and the oscillation of (16) do not exist."""


@dataclass(frozen=True)
class Modes:
    """The constants of (17).

    Attributes
    ----------
    rho1, rho2 : Number
        Positive and negative root of the quadratic in beta^2, 1/s^2.
    beta3, mu : Number
        Rate of the exponentials and of the oscillation, 1/s.
    omega : Number
        Schuler rate, 1/s.
    nu, alpha6 : Number
        Longitude components of the eigenvectors (dH component 1), rad/m.
    alpha3_growing, alpha3_swinging : Number
        East velocity components alpha_3^(3) and alpha_3^(5), 1/s.
    """

    rho1: Number
    rho2: Number
    beta3: Number
    omega: Number
    mu: Number
    nu: Number
    alpha3_growing: Number
    alpha3_swinging: Number
    alpha6: Number


def modes(ar: Arithmetic, model: EquatorModel) -> Modes:
    """Return the constants of (17), with the square root of -rho2 in nu where the print has -rho.

    Raises
    ------
    NoRealModesError
        If the roots are not certainly of opposite sign, or the frame rate vanishes.
    """
    if ar.sign(model.q) <= 0 or ar.sign(model.frame_rate) == 0:
        raise NoRealModesError("no exponential and oscillating modes at this speed: outside a_H > 0, or omega_N = 0")
    root = ar.sqrt(model.p * model.p + model.q * 4)
    rho1, rho2 = (root - model.p) / 2, (-root - model.p) / 2
    beta3, mu = ar.sqrt(rho1), ar.sqrt(-rho2)
    growing, swinging = ((rho - model.a24) / (model.frame_rate * 2) for rho in (rho1, rho2))
    alpha6 = -(beta3 * (model.coriolis_rate + growing)) / model.specific_force
    nu = -(mu * (model.coriolis_rate + swinging)) / model.specific_force
    return Modes(rho1, rho2, beta3, model.schuler_rate, mu, nu, growing, swinging, alpha6)


def constants_of_integration(ar: Arithmetic, model: EquatorModel, m: Modes, initial: Sequence[Number]) -> list[Number]:
    """Return C_1 ... C_6 of (16) from the initial errors (the formulas below (17))."""
    north, up, east, height, latitude, longitude = initial
    even = (east - m.alpha3_swinging * height) / (m.alpha3_growing - m.alpha3_swinging)
    determinant = m.mu * m.alpha6 - m.nu * m.beta3
    odd = (m.mu * longitude - m.nu * up) / determinant
    return [
        latitude,
        north / (model.schuler_rate * model.radius),
        (even + odd) / 2,
        (even - odd) / 2,
        (m.alpha3_growing * height - east) / (m.alpha3_growing - m.alpha3_swinging),
        (m.alpha6 * up - m.beta3 * longitude) / determinant,
    ]


@dataclass(frozen=True)
class Oscillation:
    """The oscillation ``amplitude * sin(rate * t + phase)`` of one error.

    The amplitude carries the sign of its eigenvector component (that of dv_E is negative); the phase then
    follows from both of its functions, which the printed tangents alone do not fix.
    """

    amplitude: Number
    sine: Number
    cosine: Number

    def signed(self, ar: Arithmetic) -> tuple[Number, str]:
        """Return amplitude and phase as the tables of the paper give them: phase 0 or pi/2, a signed amplitude.

        Raises
        ------
        ValueError
            If the phase is not a multiple of pi/2.
        """
        if not ar.sign(self.sine):
            return self.amplitude * ar.sign(self.cosine), "0"
        if not ar.sign(self.cosine):
            return self.amplitude * ar.sign(self.sine), "pi/2"
        raise ValueError("the phase is not a multiple of pi/2")


def oscillations(ar: Arithmetic, model: EquatorModel, m: Modes, initial: Sequence[Number]) -> list[Oscillation | None]:
    """Return the oscillating part (18) of the six errors; None where it vanishes."""
    c1, c2, _, _, c5, c6 = constants_of_integration(ar, model, m, initial)

    def oscillation(scale: Number, sine: Number, cosine: Number) -> Oscillation | None:
        if not (ar.sign(sine) or ar.sign(cosine)):
            return None
        norm = ar.sqrt(sine * sine + cosine * cosine)
        return Oscillation(scale * norm, sine / norm, cosine / norm)

    one = ar.number(1)
    return [
        oscillation(model.schuler_rate * model.radius, c2, -c1),
        oscillation(m.mu, c6, -c5),
        oscillation(m.alpha3_swinging, c5, c6),
        oscillation(one, c5, c6),
        oscillation(one, c1, c2),
        oscillation(m.nu, c6, -c5),
    ]


def vanishing_force_speeds(ar: Arithmetic, height: ExactNumber) -> tuple[Number, Number]:
    """Return the speeds west and east, m/s, at which the specific force vanishes: the printed v_max is the second.

    Between them the error equations have an exponential mode; R (-u -+ sqrt(u^2 + g/R)), not symmetric
    about zero.
    """
    u = ar.number(ROTATION_RATE)
    radius = ar.number(SEMI_MAJOR_AXIS) + ar.number(height)
    ratio = ar.number(SEMI_MAJOR_AXIS) / radius
    root = ar.sqrt(u * u + ar.number(EQUATORIAL_GRAVITY) * ratio * ratio / radius)
    return -(radius * (u + root)), radius * (root - u)
