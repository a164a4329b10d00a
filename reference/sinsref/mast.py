"""Antenna on a mast on a moving vehicle: frames, kinematics, specific forces and satellite measurements.

Every formula takes numbers of any arithmetic: balls, mpmath, power series, or columns of binary64. Angles come in as
pairs of sine and cosine.

Frames, right-handed: I inertial, axis 2 along the Earth's rotation, axis 3 in the zero meridian at time 0; G the same,
fixed to the Earth; S local level (east, north, up); J1 sensors of the vehicle; Q mast, Z along it; J2 sensors at its
top. Attitudes mu (I to J1), lambda (J1 to Q), eta (Q to J2) and nu = lambda o eta are unit quaternions that take
components to the rotated frame: v_J1 = conj(mu) o v_I o mu.

The equations are those of the paper with its misprints corrected, and with the kinematics of a rigid body in place of
its model of the mast, in which gravity and the Earth's rate are counted twice: see the page of the paper.

Sources: S. V. Sokolov, V. A. Pogorelov, I. V. Reshetnikova, "Nonlinear stochastic estimation of the navigation
parameters of the antenna of a mobile radio engineering complex by inertial-satellite measurements" (2024, in Russian),
eq. (3.1)-(3.17); P. C. Hughes, "Spacecraft Attitude Dynamics", Wiley 1986, chapter 2 (acceleration of a point of a
rigid body).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from sinsref.arithmetic import Arithmetic, Number
from sinsref.elementary import cosine_and_sinc
from sinsref.exact import ExactNumber
from sinsref.quaternion import Quaternion, Vector, conjugate, cross, dot, product, rotate

#: Sine and cosine of an angle.
SineCosine: TypeAlias = tuple[Number, Number]

#: Radius and inclination of the satellites' circular orbits, m and rad, and the Earth's gravitational parameter,
#: m^3/s^2.
ORBIT_RADIUS, INCLINATION = ExactNumber("26560000"), ExactNumber("11*pi/36")
GRAVITATIONAL_PARAMETER = ExactNumber("3.986004418e14")


@dataclass(frozen=True)
class Constants:
    """The Earth, a sphere of uniform attraction, and the mast.

    Attributes
    ----------
    radius, gravity, rotation_rate : Number
        m; m/s^2, the same at all heights; rad/s.
    mast_length : Number
        From the vehicle's sensors to the antenna's, m.
    """

    radius: Number
    gravity: Number
    rotation_rate: Number
    mast_length: Number


def resolved(attitude: Quaternion, vector: Vector) -> list[Number]:
    """Return the components of a vector in the rotated frame of an attitude: D(q) v."""
    return rotate(conjugate(attitude), vector)


def exponential(ar: Arithmetic, rotation: Vector) -> list[Number]:
    """Return the quaternion of a rotation vector."""
    half = [x / 2 for x in rotation]
    cosine, sinc = cosine_and_sinc(ar, dot(half, half))
    return [cosine, *(x * sinc for x in half)]


def level_quaternion(ar: Arithmetic, longitude: Number, latitude: Number) -> list[Number]:
    """Return the quaternion of S in I, or in G, by the longitude in it: q_2(L) o q_1(-lat)."""
    sine, cosine = ar.sin_cos(longitude / 2)
    sine_1, cosine_1 = ar.sin_cos(latitude / 2)
    zero = sine * 0
    return product([cosine, zero, sine, zero], [cosine_1, -sine_1, zero, zero])


def from_level(longitude: SineCosine, latitude: SineCosine, vector: Vector) -> list[Number]:
    """Return a vector of S resolved in I, or in G, by the longitude in it: B^T v."""
    (sin_l, cos_l), (sin_b, cos_b) = longitude, latitude
    east, north, up = vector
    outward = cos_b * up - sin_b * north
    return [cos_l * east + sin_l * outward, cos_b * north + sin_b * up, cos_l * outward - sin_l * east]


def position_rates(
    constants: Constants, velocity: Vector, height: Number, latitude: SineCosine
) -> tuple[Number, Number]:
    """Return the rates of longitude and latitude, rad/s: eq. (3.1)."""
    distance = height + constants.radius
    return velocity[0] / (distance * latitude[1]), velocity[1] / distance


def level_force(
    constants: Constants, velocity: Vector, acceleration: Vector, height: Number, latitude: SineCosine
) -> list[Number]:
    """Return the specific force in S, m/s^2: eq. (3.2), f = dV/dt + a x V - g.

    Parameters
    ----------
    constants : Constants
    velocity, acceleration : sequence of Number
        Earth-relative velocity (east, north, up) and its derivative, m/s and m/s^2.
    height : Number
        m.
    latitude : SineCosine
    """
    sine, cosine = latitude
    distance, rate = height + constants.radius, constants.rotation_rate
    east, north, _ = velocity
    turning = [
        -north / distance,
        2 * rate * cosine + east / distance,
        2 * rate * sine + east * sine / (cosine * distance),
    ]
    swing = rate * rate * distance * cosine
    gravity = [sine * 0, -swing * sine, swing * cosine - constants.gravity]
    return [x + y - z for x, y, z in zip(acceleration, cross(turning, velocity), gravity, strict=True)]


def mast_rates(lam: Quaternion, rate_1: Vector, mast_rate: Vector) -> tuple[list[Number], list[Number]]:
    """Return u = D(lambda) w1 and the absolute rate of Q, w = wQ + u, both in Q, rad/s.

    Parameters
    ----------
    lam : Quaternion
    rate_1 : Vector
        Absolute rate of J1, in J1.
    mast_rate : sequence of two Number
        Rate of Q relative to J1 about the axes X and Y of Q: the mast never spins about itself.
    """
    carried = resolved(lam, rate_1)
    return carried, [carried[0] + mast_rate[0], carried[1] + mast_rate[1], carried[2]]


def top_force(
    constants: Constants,
    lam: Quaternion,
    force_1: Vector,
    rate_1: Vector,
    acceleration_1: Vector,
    mast_rate: Vector,
    mast_acceleration: Vector,
) -> list[Number]:
    """Return the specific force at the top of the mast, in Q, m/s^2: that of a rigid body.

    f2 = D(lambda) f1 + dw/dt x rho + w x (w x rho) with rho = (0, 0, R); the change of gravity over R is neglected.

    Parameters
    ----------
    constants : Constants
    lam : Quaternion
    force_1, rate_1, acceleration_1 : Vector
        Specific force, absolute rate and its derivative, in J1.
    mast_rate, mast_acceleration : sequence of two Number
        Rate of Q relative to J1 in Q and its derivative.
    """
    u, (w_x, w_y, w_z) = mast_rates(lam, rate_1, mast_rate)
    # dw/dt = dwQ/dt + D(lambda) dw1/dt - wQ x u
    carried = resolved(lam, acceleration_1)
    angular_x = mast_acceleration[0] + carried[0] - mast_rate[1] * u[2]
    angular_y = mast_acceleration[1] + carried[1] + mast_rate[0] * u[2]
    x, y, z = resolved(lam, force_1)
    length = constants.mast_length
    return [
        x + length * (angular_y + w_x * w_z),
        y + length * (w_y * w_z - angular_x),
        z - length * (w_x * w_x + w_y * w_y),
    ]


@dataclass(frozen=True)
class Orbit:
    """Where the satellites of circular orbits are, by angles that grow with time.

    Attributes
    ----------
    radius, motion : Number
        Radius, m, and mean motion n = sqrt(GM/a^3), rad/s.
    inclination : SineCosine
    rotation_rate : Number
        Of the Earth, rad/s.
    """

    radius: Number
    motion: Number
    inclination: SineCosine
    rotation_rate: Number

    @classmethod
    def at(cls, ar: Arithmetic, rotation_rate: Number) -> Orbit:
        """Return the orbits in an arithmetic."""
        radius = ar.number(ORBIT_RADIUS)
        motion = ar.sqrt(ar.number(GRAVITATIONAL_PARAMETER) / (radius * radius * radius))
        return cls(radius, motion, ar.sin_cos(ar.number(INCLINATION)), rotation_rate)

    def place(self, node: SineCosine, argument: SineCosine) -> tuple[list[Number], list[Number]]:
        """Return position and Earth-relative velocity in G, m and m/s.

        Parameters
        ----------
        node : SineCosine
            Of the ascending node's longitude on the rotating Earth, O0 - Om t.
        argument : SineCosine
            Of the argument of latitude, u0 + n t.
        """
        (sin_o, cos_o), (sin_u, cos_u), (sin_i, cos_i) = node, argument, self.inclination
        # Along the node and across it, in the equator; the derivative of the argument is n, of the node -Om.
        along, across, up = self.radius * cos_u, self.radius * sin_u * cos_i, self.radius * sin_u * sin_i
        along_rate, across_rate, up_rate = (
            -self.motion * self.radius * sin_u,
            self.motion * along * cos_i,
            (self.motion * along * sin_i),
        )
        x, y = cos_o * along - sin_o * across, sin_o * along + cos_o * across
        x_rate = cos_o * along_rate - sin_o * across_rate + self.rotation_rate * y
        y_rate = sin_o * along_rate + cos_o * across_rate - self.rotation_rate * x
        return [y, up, x], [y_rate, up_rate, x_rate]


def receiver_position(
    constants: Constants, longitude: SineCosine, latitude: SineCosine, height: Number
) -> list[Number]:
    """Return the vehicle's position in G, m."""
    return from_level(longitude, latitude, [height * 0, height * 0, height + constants.radius])


def range_and_rate(
    sqrt: Callable[[Number], Number], position: Vector, velocity: Vector, satellite: Vector, satellite_velocity: Vector
) -> tuple[Number, Number]:
    """Return distance of a satellite and its rate, m and m/s: eq. (3.16), (3.17), with the bracket squared.

    Parameters
    ----------
    sqrt : callable
        Square root of the arithmetic.
    position, velocity : Vector
        Of the vehicle, in G.
    satellite, satellite_velocity : Vector
        In G, Earth-relative.
    """
    line = [x - y for x, y in zip(satellite, position, strict=True)]
    distance = sqrt(dot(line, line))
    closing = [x - y for x, y in zip(satellite_velocity, velocity, strict=True)]
    return distance, dot(line, closing) / distance
