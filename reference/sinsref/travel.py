"""Motions over the ellipsoid that are not the equator, and the errors of a navigator that makes them.

A motion has constant horizontal speed and constant climb rate; what its horizontal velocity does is a heading rate:

=============  ====================================================================================
parallel       0: due east (or west)
meridian       0: due north (or south)
great circle   that of the meridians' convergence, v_E tan(phi) / R_1: the velocity does not turn
               about the local vertical relative to the Earth. At constant height it is a geodesic
climbing turn  constant
=============  ====================================================================================

The state is (v_N, v_H, v_E, H, phi, lambda). Beside it run two descriptions of the errors of a navigator, computed
minus true: the linear error equations, and what the nonlinear ideal equations add to them.

Source: Loginov, Tkachenko, Chelnokov 2013, equations (1)-(3) and the ideal equations of section 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sinsref.arithmetic import Arithmetic, Number
from sinsref.error_equations import (
    Earth,
    error_matrix,
    force_at_displaced_position,
    ideal_rates,
    local_geometry,
)
from sinsref.quaternion import dot
from sinsref.recorded import AutonomousField


@dataclass(frozen=True)
class Turning:
    """How the horizontal velocity turns.

    Attributes
    ----------
    rate : Number
        Part of the heading rate that does not depend on the place, clockwise from above, rad/s.
    along_geodesic : bool
        Whether the meridians' convergence is added.
    """

    rate: Number
    along_geodesic: bool = False


def acceleration(ar: Arithmetic, earth: Earth, turning: Turning, state: Sequence[Number]) -> list[Number]:
    """Return the rates of v_N, v_H, v_E along a motion, m/s^2.

    Parameters
    ----------
    ar : Arithmetic
    earth : Earth
    turning : Turning
    state : sequence of 6 Number
        v_N, v_H, v_E (m/s), H (m), phi, lambda (rad).
    """
    v_north, _, v_east = state[:3]
    rate = turning.rate
    if turning.along_geodesic:
        at = local_geometry(ar, earth, state)
        rate = rate + v_east * at.sin_latitude / (at.prime_vertical * at.cos_latitude)
    return [-(rate * v_east), ar.number(0), rate * v_north]


def motion_rates(
    ar: Arithmetic, earth: Earth, turning: Turning, state: Sequence[Number]
) -> tuple[list[Number], list[Number]]:
    """Return the time derivative of the state of a motion, and the specific force (a_N, a_H, a_E) that makes it.

    The velocity's rates are those of the motion as they stand, not what the ideal equations give back for the force: a
    rate that is exactly zero stays exactly zero.

    Parameters
    ----------
    ar, earth, turning, state
        As for `acceleration`.
    """
    zero = ar.number(0)
    wanted = acceleration(ar, earth, turning, state)
    free = ideal_rates(ar, earth, state, [zero, zero, zero])
    return [*wanted, *free[3:]], [x - y for x, y in zip(wanted, free[:3], strict=True)]


def error_field(earth: Earth, turning: Turning) -> AutonomousField:
    """Return the field of a motion and its errors: 18 components.

    Components 1-6 are the motion, 7-12 the solution of the linear error equations (1), 13-18 what the nonlinear errors
    have beyond it. The nonlinear errors belong to a computer that integrates the ideal equations from a displaced
    state, with exact gyroscopes and accelerometers: it resolves the specific force at its own position, (3) to all
    orders. Their difference from the linear ones is integrated as a quantity of its own: subtracting two solutions
    would cancel its digits.

    Parameters
    ----------
    earth : Earth
        In the arithmetic of the constants.
    turning : Turning
        Likewise.
    """

    def field(ar: Arithmetic, state: Sequence[Number]) -> list[Number]:
        motion, linear, beyond = state[:6], state[6:12], state[12:]
        rates, force = motion_rates(ar, earth, turning, motion)
        linear_rates = [dot(row, linear) for row in error_matrix(ar, earth, motion, force)]
        computed = [x + (y + z) for x, y, z in zip(motion, linear, beyond, strict=True)]
        # Only the difference of the longitudes matters: counted from the true one it keeps the enclosure narrow.
        here = [*motion[:5], ar.number(0)]
        displaced = [*computed[:5], linear[5] + beyond[5]]
        resolved = force_at_displaced_position(ar, here, displaced, force)
        computed_rates = ideal_rates(ar, earth, computed, resolved)
        return [
            *rates,
            *linear_rates,
            *(x - y - z for x, y, z in zip(computed_rates, rates, linear_rates, strict=True)),
        ]

    return field
