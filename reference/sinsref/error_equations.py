r"""The ideal equations of a strapdown INS in the normal geographic frame, and their linear error equations.

The frame Z' = (N, H, E) points north, up, east, in that order, over an ellipsoid of revolution.
`ideal_rates` and `attitude_rate` are the nonlinear equations of ideal operation; `error_matrix` is the
matrix A of the linear error equations (1)-(2), as printed and for any motion. That A is the Jacobian of the
ideal equations is a test, not an assumption: the equations accept numbers that carry derivatives.

Source: Loginov, Tkachenko, Chelnokov 2013, sections 1 and 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sinsref.arithmetic import Arithmetic, Number
from sinsref.earth import (
    ECCENTRICITY_SQUARED,
    EQUATORIAL_GRAVITY,
    GRAVITY_FLATTENING,
    ROTATION_RATE,
    SEMI_MAJOR_AXIS,
)
from sinsref.quaternion import Quaternion, Vector, conjugate, product, rotate


@dataclass(frozen=True)
class Earth:
    """Constants of the Earth in an arithmetic.

    Attributes
    ----------
    rotation_rate : Number
        u, rad/s.
    semi_major_axis : Number
        m.
    eccentricity_squared : Number
        e^2; 0 for a sphere.
    equatorial_gravity : Number
        m/s^2.
    gravity_flattening : Number
        delta of ``g = g_eo (a/(a + H))^2 (1 + delta sin^2 phi)``.
    """

    rotation_rate: Number
    semi_major_axis: Number
    eccentricity_squared: Number
    equatorial_gravity: Number
    gravity_flattening: Number

    @classmethod
    def krasovsky(cls, ar: Arithmetic, *, spherical: bool = False) -> Earth:
        """Return the paper's constants; with `spherical`, e^2 = 0 and delta = 0."""
        zero = ar.number(0)
        return cls(
            ar.number(ROTATION_RATE),
            ar.number(SEMI_MAJOR_AXIS),
            zero if spherical else ar.number(ECCENTRICITY_SQUARED),
            ar.number(EQUATORIAL_GRAVITY),
            zero if spherical else ar.number(GRAVITY_FLATTENING),
        )


@dataclass(frozen=True)
class LocalGeometry:
    """What the equations need at a place and velocity: radii, rates of the frame, gravity.

    Attributes
    ----------
    sin_latitude, cos_latitude : Number
    alpha : Number
        sqrt(1 - e^2 sin^2 phi).
    distance : Number
        a + H, m.
    prime_vertical, meridian : Number
        The radii R_1 and R_2 as the paper defines them, m.
    earth_north, earth_up : Number
        Components u_N, u_H of the Earth's rotation, rad/s.
    north, up, east : Number
        Angular rate of the frame Z' relative to inertial space, rad/s.
    gravity : Number
        m/s^2.
    """

    sin_latitude: Number
    cos_latitude: Number
    alpha: Number
    distance: Number
    prime_vertical: Number
    meridian: Number
    earth_north: Number
    earth_up: Number
    north: Number
    up: Number
    east: Number
    gravity: Number


def local_geometry(ar: Arithmetic, earth: Earth, state: Sequence[Number]) -> LocalGeometry:
    """Return radii, rates and gravity at a state (v_N, v_H, v_E, H, phi, lambda)."""
    v_north, _, v_east, height, latitude, _ = state
    sine, cosine = ar.sin_cos(latitude)
    alpha = ar.sqrt(1 - earth.eccentricity_squared * sine * sine)
    distance = earth.semi_major_axis + height
    prime_vertical = distance / alpha
    meridian = distance * (1 - earth.eccentricity_squared) / (alpha * alpha * alpha)
    earth_north, earth_up = earth.rotation_rate * cosine, earth.rotation_rate * sine
    ratio = earth.semi_major_axis / distance
    gravity = earth.equatorial_gravity * ratio * ratio * (earth.gravity_flattening * sine * sine + 1)
    turn = v_east / prime_vertical
    return LocalGeometry(
        sine,
        cosine,
        alpha,
        distance,
        prime_vertical,
        meridian,
        earth_north,
        earth_up,
        earth_north + turn,
        earth_up + turn * sine / cosine,
        -(v_north / meridian),
        gravity,
    )


def ideal_rates(ar: Arithmetic, earth: Earth, state: Sequence[Number], force: Vector) -> list[Number]:
    """Return the time derivative of (v_N, v_H, v_E, H, phi, lambda).

    Parameters
    ----------
    ar : Arithmetic
    earth : Earth
    state : sequence of 6 Number
        Velocity relative to the Earth (m/s), height (m), latitude, longitude (rad).
    force : sequence of 3 Number
        Specific force (a_N, a_H, a_E), m/s^2.
    """
    v_north, v_up, v_east = state[:3]
    at = local_geometry(ar, earth, state)
    around_up, around_north = at.earth_up + at.up, at.earth_north + at.north
    return [
        force[0] + at.east * v_up - around_up * v_east,
        force[1] - at.east * v_north + around_north * v_east - at.gravity,
        force[2] + around_up * v_north - around_north * v_up,
        v_up / at.alpha,
        v_north / at.meridian,
        v_east / (at.prime_vertical * at.cos_latitude),
    ]


def required_force(ar: Arithmetic, earth: Earth, state: Sequence[Number], acceleration: Vector) -> list[Number]:
    """Return the specific force (a_N, a_H, a_E) under which the velocity changes at the given rates, m/s^2."""
    zero = ar.number(0)
    free = ideal_rates(ar, earth, state, [zero, zero, zero])
    return [x - y for x, y in zip(acceleration, free[:3], strict=True)]


def attitude_rate(
    ar: Arithmetic, earth: Earth, state: Sequence[Number], attitude: Quaternion, angular_rate: Vector
) -> list[Number]:
    """Return the time derivative of kappa, body relative to Z': (kappa o omega - omega_Z' o kappa) / 2.

    Parameters
    ----------
    ar : Arithmetic
    earth : Earth
    state : sequence of 6 Number
    attitude : sequence of 4 Number
        kappa; a vector of the body is ``kappa o v o conj(kappa)`` in Z'.
    angular_rate : sequence of 3 Number
        Of the body relative to inertial space, in body axes, rad/s.
    """
    at, zero = local_geometry(ar, earth, state), ar.number(0)
    body = product(attitude, [zero, *angular_rate])
    frame = product([zero, at.north, at.up, at.east], attitude)
    return [(x - y) / 2 for x, y in zip(body, frame, strict=True)]


def geographic_force(attitude: Quaternion, body_force: Vector) -> list[Number]:
    """Return the specific force in Z' from that in body axes."""
    return rotate(attitude, body_force)


def geographic_attitude(ar: Arithmetic, latitude: Number, inertial_longitude: Number) -> list[Number]:
    """Return the quaternion that takes a vector of Z' to the inertial frame X (axis 1 polar).

    At latitude and inertial longitude 0 the two frames coincide; Z' turns about its north axis with
    longitude and about its east axis with latitude: the transpose of the matrix C_nu, (7) on the equator.
    """
    sin_longitude, cos_longitude = ar.sin_cos(inertial_longitude / 2)
    sin_latitude, cos_latitude = ar.sin_cos(latitude / 2)
    zero = ar.number(0)
    return product([cos_longitude, sin_longitude, zero, zero], [cos_latitude, zero, zero, -sin_latitude])


def force_at_displaced_position(
    ar: Arithmetic, state: Sequence[Number], displaced: Sequence[Number], force: Vector
) -> list[Number]:
    """Return the specific force as the computer resolves it at a displaced position.

    The orientation in the inertial frame is exact, so a position error turns the frame in which the
    measured vector is resolved: the first two terms of (3), to all orders.

    Parameters
    ----------
    ar : Arithmetic
    state, displaced : sequence of 6 Number
        True and computed state.
    force : sequence of 3 Number
        True specific force in Z'.
    """
    inertial = rotate(geographic_attitude(ar, state[4], state[5]), force)
    return rotate(conjugate(geographic_attitude(ar, displaced[4], displaced[5])), inertial)


def error_matrix(ar: Arithmetic, earth: Earth, state: Sequence[Number], force: Vector) -> list[list[Number]]:
    """Return the matrix A of the linear error equations (1), element by element as printed in (2).

    Parameters
    ----------
    ar : Arithmetic
    earth : Earth
    state : sequence of 6 Number
        v_N, v_H, v_E (m/s), H (m), phi, lambda (rad) of the true motion.
    force : sequence of 3 Number
        Its specific force in Z', m/s^2 (`required_force`).

    Notes
    -----
    The error is (dv_N, dv_H, dv_E, dH, dphi, dlambda), computed minus true, with the orientation in the
    inertial frame exact.
    """
    v_n, v_h, v_e = state[:3]
    a_n, a_h, a_e = force
    at = local_geometry(ar, earth, state)
    e2, u_n, u_h = earth.eccentricity_squared, at.earth_north, at.earth_up
    sin, cos, alpha, d, r1, r2 = (
        at.sin_latitude,
        at.cos_latitude,
        at.alpha,
        at.distance,
        at.prime_vertical,
        at.meridian,
    )
    over_n, over_h = at.north - u_n, at.up - u_h  # rates due to the motion alone
    tan, slant = sin / cos, e2 * sin * cos / (r1 * (1 - e2)) * 3
    zero = ar.number(0)
    gravity_slope = earth.equatorial_gravity * (earth.semi_major_axis / d) * (earth.semi_major_axis / d)
    return [
        [
            -(v_h / r2),
            at.east,
            -(at.up * 2),
            (over_h * v_e - at.east * v_h) / d,
            -a_h
            - u_n * v_e * 2
            - over_n * v_e / (cos * cos)
            + v_e * v_e * e2 * sin * sin / (d * alpha)
            + v_n * v_h * slant,
            -(a_e * sin),
        ],
        [
            -(at.east * 2),
            zero,
            at.north * 2,
            (at.east * v_n - over_n * v_e + at.gravity * 2) / d,
            a_n
            - u_h * v_e * 2
            - gravity_slope * earth.gravity_flattening * sin * cos * 2
            - v_n * v_n * slant
            - v_e * v_e * e2 * sin * cos / (d * alpha),
            a_e * cos,
        ],
        [
            u_h + at.up,
            -u_n - at.north,
            (v_n * tan - v_h) / r1,
            (over_n * v_h - over_h * v_n) / d,
            u_n * v_n * 2
            + u_h * v_h * 2
            + over_n * v_n / (cos * cos)
            + v_e * e2 * sin * (v_h * cos - v_n * sin) / (d * alpha),
            a_n * sin - a_h * cos,
        ],
        [zero, 1 / alpha, zero, zero, v_h * e2 * sin * cos / (alpha * alpha * alpha), zero],
        [1 / r2, zero, zero, -(v_n / (r2 * d)), -(v_n * slant), zero],
        [
            zero,
            zero,
            1 / (r1 * cos),
            -(v_e / (r1 * cos * d)),
            v_e * sin / (r1 * cos * cos) - v_e * e2 * sin / (d * alpha),
            zero,
        ],
    ]
