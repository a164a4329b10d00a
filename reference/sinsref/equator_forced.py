r"""The inhomogeneous error equations on the equator: the answer to an initial misalignment.

The misalignment :math:`\Lambda = \Delta C_\lambda^T(t_0) C_\lambda(t_0)` with elements l_ij is constant while the
gyros are exact; in the frame that turns with the vehicle it becomes the force b(t) of (8), with harmonics of the frame
rate in the north channel and of twice the frame rate in the coupled one. The paper prints the north channel only. Both
are given here without any division that can vanish: resonances (frame rate equal to the Schuler rate, twice the frame
rate equal to mu) and the zeros of the constant part are ordinary speeds.

Source: Loginov, Tkachenko, Chelnokov 2013, equations (8), (9), (23).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sinsref.arithmetic import Arithmetic, Number
from sinsref.elementary import cosine_and_sinc
from sinsref.equator import EquatorModel, apply, homogeneous, polynomial, series_functions


@dataclass(frozen=True)
class Misalignment:
    """The elements of the misalignment matrix in an arithmetic, and the inertial longitude at t = 0.

    Attributes
    ----------
    elements : sequence of 3 sequences of 3 Number
        Lambda.
    inertial_longitude : Number
        th0 = mu_0 + lambda_0, rad.
    """

    elements: Sequence[Sequence[Number]]
    inertial_longitude: Number

    def force(self, ar: Arithmetic, model: EquatorModel, time: Number) -> list[Number]:
        """Return the six components of b(t), equation (8) with lambda_a = th0 + omega_N t."""
        l = self.elements
        sine, cosine = ar.sin_cos(self.inertial_longitude + model.frame_rate * time)
        zero = ar.number(0)
        north = l[0][1] * cosine + l[0][2] * sine
        up = l[1][1] * cosine * cosine + (l[2][1] + l[1][2]) * cosine * sine + l[2][2] * sine * sine
        east = l[2][1] * cosine * cosine + (l[2][2] - l[1][1]) * cosine * sine - l[1][2] * sine * sine
        return [model.specific_force * x for x in (north, up, east)] + [zero] * 3


def _north_response(ar: Arithmetic, model: EquatorModel, tilt: Misalignment, time: Number) -> tuple[Number, Number]:
    """Return what the misalignment adds to dv_N and dphi: the formulas below (23), resonance-safe."""
    w, turn, th0 = model.schuler_rate, model.frame_rate, tilt.inertial_longitude
    l12, l13 = tilt.elements[0][1], tilt.elements[0][2]

    def integrals(rate: Number, phase: Number) -> tuple[Number, Number]:
        """Return the integrals over (0, t) of cos and sin of ``rate * tau + phase``, also for rate = 0."""
        half = rate * time / 2
        _, sinc = cosine_and_sinc(ar, half * half)
        sine, cosine = ar.sin_cos(half + phase)
        return time * sinc * cosine, time * sinc * sine

    cos_slow, sin_slow = integrals(turn - w, w * time + th0)
    cos_fast, sin_fast = integrals(-turn - w, w * time - th0)
    a = model.specific_force / 2
    velocity = a * (l12 * (cos_slow + cos_fast) + l13 * (sin_slow - sin_fast))
    latitude = a / (w * model.radius) * (l12 * (sin_slow + sin_fast) + l13 * (cos_fast - cos_slow))
    return velocity, latitude


def _coupled_response(ar: Arithmetic, model: EquatorModel, tilt: Misalignment, time: Number) -> list[Number]:
    r"""Return what the misalignment adds to (dv_H, dv_E, dH, dlambda).

    A force F exp(i r tau) is answered by :math:`(A + i r)(E + A O) F + f_o(-r^2) F`, where E and O are the
    divided differences of f_e and f_o at A^2 and -r^2 (`series_functions` with ``forcing``). The constant
    part of (8) has r = 0, the rest r = 2 omega_N.
    """
    l = tilt.elements
    sine, cosine = ar.sin_cos(tilt.inertial_longitude * 2)
    constant = [(l[1][1] + l[2][2]) / 2, (l[2][1] - l[1][2]) / 2]
    difference, sum_ = (l[1][1] - l[2][2]) / 2, (l[1][2] + l[2][1]) / 2
    in_phase = difference * cosine + sum_ * sine
    quadrature = sum_ * cosine - difference * sine
    zero, a = ar.number(0), model.specific_force

    def response(rate: Number, real: Sequence[Number], imaginary: Sequence[Number]) -> list[Number]:
        """Return the real part of the answer to ``(real + i imaginary) exp(i rate tau)``."""
        real, imaginary = ([a * x for x in part] + [zero, zero] for part in (real, imaginary))
        c = series_functions(ar, model.p, model.q, time, forcing=-(rate * rate))
        _, sinc = cosine_and_sinc(ar, rate * time * rate * time)
        from_real = apply(model.coupled_matrix(ar), polynomial(ar, model, c, real))
        from_imaginary = polynomial(ar, model, c, imaginary)
        return [x - rate * y + time * sinc * f for x, y, f in zip(from_real, from_imaginary, real, strict=True)]

    steady = response(zero, constant, [zero, zero])
    swinging = response(model.frame_rate * 2, [in_phase, quadrature], [-quadrature, in_phase])
    return [x + y for x, y in zip(steady, swinging, strict=True)]


def solution(
    ar: Arithmetic, model: EquatorModel, initial: Sequence[Number], tilt: Misalignment | None, time: Number
) -> list[Number]:
    """Return X(t), the solution (23) of (9): initial errors and initial misalignment.

    Parameters
    ----------
    ar : Arithmetic
    model : EquatorModel
    initial : sequence of 6 Number
        X(0).
    tilt : Misalignment or None
        None for an exact initial orientation in the inertial frame.
    time : Number
        s.

    Returns
    -------
    list of 6 Number
        dv_N, dv_H, dv_E (m/s), dH (m), dphi, dlambda (rad).
    """
    state = homogeneous(ar, model, initial, time)
    if tilt is None:
        return state
    velocity, latitude = _north_response(ar, model, tilt, time)
    up, east, height, longitude = _coupled_response(ar, model, tilt, time)
    added = (velocity, up, east, height, latitude, longitude)
    return [x + y for x, y in zip(state, added, strict=True)]
