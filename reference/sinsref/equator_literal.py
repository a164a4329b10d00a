r"""The closed form of the paper as it stands, in any arithmetic, with the slips of the print corrected.

Beside it `sinsref.equator` and `sinsref.equator_forced` are another form of the same solution, which divides by
nothing that can vanish. The form of the paper divides by the frame rate, the specific force and the differences of
modes: in exact arithmetic both agree wherever this one is defined, in rounded arithmetic this one loses digits near the
zeros of its divisors. How many is the difficulty of a case.

Source: Loginov, Tkachenko, Chelnokov 2013, equations (16), (17), (20), (22) and the formulas below (23).
"""

from __future__ import annotations

from collections.abc import Sequence

from sinsref.arithmetic import Arithmetic, Number
from sinsref.equator import COUPLED, EquatorModel, apply
from sinsref.equator_forced import Misalignment
from sinsref.equator_modes import Modes, constants_of_integration, modes


def general_solution(
    ar: Arithmetic, model: EquatorModel, m: Modes, initial: Sequence[Number], time: Number
) -> list[Number]:
    """Return X(t) by (16), from the constants of integration.

    Parameters
    ----------
    ar : Arithmetic
    model : EquatorModel
    m : Modes
        The constants (17).
    initial : sequence of 6 Number
        X(0).
    time : Number
        s.
    """
    c1, c2, c3, c4, c5, c6 = constants_of_integration(ar, model, m, initial)
    growing, decaying = c3 * ar.exp(m.beta3 * time), c4 * ar.exp(-(m.beta3 * time))
    sine, cosine = ar.sin_cos(m.mu * time)
    in_phase, quadrature = c5 * cosine + c6 * sine, c6 * cosine - c5 * sine
    north_sine, north_cosine = ar.sin_cos(m.omega * time)
    return [
        model.schuler_rate * model.radius * (c2 * north_cosine - c1 * north_sine),
        m.beta3 * (growing - decaying) + m.mu * quadrature,
        m.alpha3_growing * (growing + decaying) + m.alpha3_swinging * in_phase,
        growing + decaying + in_phase,
        c1 * north_cosine + c2 * north_sine,
        m.alpha6 * (growing - decaying) + m.nu * quadrature,
    ]


def transition(ar: Arithmetic, model: EquatorModel, m: Modes, time: Number) -> list[list[Number]]:
    """Return P(t) by (22), 6 x 6, with the factor 2 that the print leaves out of its second row.

    Parameters
    ----------
    ar : Arithmetic
    model : EquatorModel
    m : Modes
        The constants (17).
    time : Number
        s.
    """
    rising, falling = ar.exp(m.beta3 * time), ar.exp(-(m.beta3 * time))
    ch, sh = rising + falling, rising - falling
    sn, cs = ar.sin_cos(m.mu * time)
    beta, mu, nu = m.beta3, m.mu, m.nu
    a3, a5, a6 = m.alpha3_growing, m.alpha3_swinging, m.alpha6
    even, odd = (a3 - a5) * 2, (nu * beta - mu * a6) * 2
    coupled = [
        [
            (beta * nu * ch - mu * a6 * cs * 2) / odd,
            (beta * sh + mu * sn * 2) / even,
            -(beta * a5 * sh + mu * a3 * sn * 2) / even,
            -(beta * mu * ch - beta * mu * cs * 2) / odd,
        ],
        [
            (nu * a3 * sh - a5 * a6 * sn * 2) / odd,
            (a3 * ch - a5 * cs * 2) / even,
            -(a3 * a5 * (ch - cs * 2)) / even,
            -(mu * a3 * sh - beta * a5 * sn * 2) / odd,
        ],
        [
            (nu * sh - a6 * sn * 2) / odd,
            (ch - cs * 2) / even,
            -(a5 * ch - a3 * cs * 2) / even,
            -(mu * sh - beta * sn * 2) / odd,
        ],
        [
            nu * a6 * (ch - cs * 2) / odd,
            (a6 * sh + nu * sn * 2) / even,
            -(a5 * a6 * sh + nu * a3 * sn * 2) / even,
            -(mu * a6 * ch - beta * nu * cs * 2) / odd,
        ],
    ]
    full = [[ar.number(0)] * 6 for _ in range(6)]
    sine, cosine = ar.sin_cos(m.omega * time)
    speed = m.omega * model.radius  # sqrt(g R)
    full[0][0], full[0][4], full[4][0], full[4][4] = cosine, -(speed * sine), sine / speed, cosine
    for i, row in zip(COUPLED, coupled, strict=True):
        for j, element in zip(COUPLED, row, strict=True):
            full[i][j] = element
    return full


def north_response(ar: Arithmetic, model: EquatorModel, tilt: Misalignment, time: Number) -> tuple[Number, Number]:
    """Return what a misalignment adds to dv_N (m/s) and dphi (rad): the compact formulas below (23).

    Raises
    ------
    ZeroDivisionError
        If the frame rate is not certainly other than plus or minus the Schuler rate.
    """
    w, turn, th0 = model.schuler_rate, model.frame_rate, tilt.inertial_longitude
    l12, l13 = tilt.elements[0][1], tilt.elements[0][2]
    resonance = _divisor(ar, w * w - turn * turn, "omega^2 - omega_N^2")
    sin_turn, cos_turn = ar.sin_cos(turn * time)
    sin_w, cos_w = ar.sin_cos(w * time)
    sin_0, cos_0 = ar.sin_cos(th0)
    sin_end, cos_end = ar.sin_cos(turn * time + th0)
    sin_plus, cos_plus = ar.sin_cos(w * time + th0)
    sin_minus, cos_minus = ar.sin_cos(w * time - th0)
    velocity = l12 * ((w + turn) * sin_plus + (w - turn) * sin_minus - turn * sin_end * 2) + l13 * (
        turn * cos_end * 2 + (w - turn) * cos_minus - (w + turn) * cos_plus
    )
    cosines, sines = w * (cos_turn - cos_w), w * sin_turn - turn * sin_w
    latitude = l12 * (cos_0 * cosines - sin_0 * sines) + l13 * (cos_0 * sines + sin_0 * cosines)
    a = model.specific_force / resonance
    return a * velocity / 2, a * latitude / (w * model.radius)


def particular_solution(ar: Arithmetic, model: EquatorModel, tilt: Misalignment, time: Number) -> list[Number]:
    """Return the forced oscillation of (dv_H, dv_E, dH, dlambda): constant, and at twice the frame rate.

    The paper leaves this channel as the integral (23); this is the particular solution by undetermined
    coefficients for its force (8).

    Raises
    ------
    ZeroDivisionError
        If twice the frame rate is not certainly other than plus or minus mu, or the constant part has no answer.
    """
    l, turn, radius = tilt.elements, model.frame_rate, model.radius
    coriolis, a_h, v = model.coriolis_rate, model.specific_force, model.v_east
    drop = v / radius
    square = turn * turn * 4
    resonance = _divisor(ar, square * square - square * model.p - model.q, "(4 omega_N^2 + rho1)(4 omega_N^2 + rho2)")
    stiffness = _divisor(ar, model.a24 + turn * drop * 2, "a24 + 2 omega_N v/R")
    sine, cosine = ar.sin_cos((tilt.inertial_longitude + turn * time) * 2)
    difference, total = (l[1][1] - l[2][2]) / 2, (l[1][2] + l[2][1]) / 2
    in_phase, quadrature = difference * cosine + total * sine, total * cosine - difference * sine
    height = (a_h / radius - square * 2) / resonance
    east = (turn * 2 * (square + model.a24) + coriolis * square + a_h * drop / radius) / resonance
    constant = -(a_h * (l[1][1] + l[2][2]) / 2) / stiffness
    return [
        turn * 2 * a_h * height * quadrature,
        drop * constant + a_h * east * in_phase,
        constant + a_h * height * in_phase,
        (l[2][1] - l[1][2]) / 2 + (1 - turn * 2 * (east + coriolis * height)) * quadrature,
    ]


def solution(
    ar: Arithmetic, model: EquatorModel, initial: Sequence[Number], tilt: Misalignment | None, time: Number
) -> list[Number]:
    """Return X(t) = P(t) X(0) by (17), (20), (22), and the answer to a misalignment.

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

    Raises
    ------
    NoRealModesError
        Where (17) has no growing and oscillating modes, or divides by zero.
    ZeroDivisionError
        At a resonance with the misalignment.
    """
    matrix = transition(ar, model, modes(ar, model), time)
    if tilt is None:
        return apply(matrix, initial)
    state = list(initial)
    for place, x in zip(COUPLED, particular_solution(ar, model, tilt, ar.number(0)), strict=True):
        state[place] = state[place] - x
    state = apply(matrix, state)
    for place, x in zip(COUPLED, particular_solution(ar, model, tilt, time), strict=True):
        state[place] = state[place] + x
    velocity, latitude = north_response(ar, model, tilt, time)
    return [state[0] + velocity, *state[1:4], state[4] + latitude, state[5]]


def _divisor(ar: Arithmetic, value: Number, name: str) -> Number:
    if not ar.sign(value):
        raise ZeroDivisionError(f"the closed form divides by {name}, which vanishes at this speed")
    return value
