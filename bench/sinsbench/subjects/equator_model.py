"""Error equations of an inertial system carried along the equator: the model in float64.

The motion is uniform: constant eastward speed at constant height over a spherical Earth.  The state is
``(dv_N, dv_H, dv_E, dH, dphi, dlam)`` in m/s, m/s, m/s, m, rad, rad; the axes are north, up, east; errors
are computed minus true.  Source: Loginov, Tkachenko, Chelnokov 2013, eqs. (7)-(10) and (17), with g
proportional to the inverse square of the distance from the centre (the print lost the square).
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

EARTH_RATE = 7.29e-5
"""Rotation rate of the Earth u, rad/s, to the digits the paper uses."""
EARTH_RADIUS = 6378245.0
"""Equatorial radius a of the Krasovsky ellipsoid, m."""
EQUATORIAL_GRAVITY = 9.78049
"""Gravity g_eo on the equator at zero height, m/s^2."""


class NotApplicableError(ValueError):
    """The method cannot treat this case; the message says why in one sentence."""


@dataclass(frozen=True)
class EquatorMotion:
    """Uniform motion along the equator and the quantities of the error equations that follow from it.

    Attributes
    ----------
    v_east, height : float
        Eastward speed relative to the Earth, m/s, and height, m.
    radius : float
        Distance from the Earth's centre R, m.
    gravity : float
        Gravitational acceleration g at that distance, m/s^2.
    inertial_rate : float
        Rate of the inertial longitude omega_N = u + v/R, rad/s.
    coriolis_rate : float
        2u + v/R, rad/s.
    specific_force : float
        Vertical projection of the specific force a_H, m/s^2.
    vertical_gradient : float
        a_24, the derivative of the vertical acceleration with respect to height, 1/s^2.
    """

    v_east: float
    height: float
    radius: float
    gravity: float
    inertial_rate: float
    coriolis_rate: float
    specific_force: float
    vertical_gradient: float

    @classmethod
    def at(cls, v_east: float, height: float) -> "EquatorMotion":
        """Derive the motion from the eastward speed, m/s, and the height, m.

        Raises
        ------
        ValueError
            If a value is not finite or the height lies at or below the Earth's centre.
        """
        v_east, height = float(v_east), float(height)
        if not np.isfinite(v_east):
            raise ValueError(f"v_east = {v_east} m/s is not finite")
        if not (np.isfinite(height) and height > -EARTH_RADIUS):
            raise ValueError(f"height = {height} m: a finite height above {-EARTH_RADIUS} m is needed")
        radius = EARTH_RADIUS + height
        gravity = EQUATORIAL_GRAVITY * (EARTH_RADIUS / radius) ** 2
        transport_rate = v_east / radius
        return cls(
            v_east=v_east,
            height=height,
            radius=radius,
            gravity=gravity,
            inertial_rate=EARTH_RATE + transport_rate,
            coriolis_rate=2 * EARTH_RATE + transport_rate,
            specific_force=gravity - 2 * EARTH_RATE * v_east - v_east * transport_rate,
            vertical_gradient=2 * gravity / radius - transport_rate**2,
        )

    @property
    def schuler_rate(self) -> float:
        """Frequency sqrt(g/R) of the northern channel, rad/s."""
        return float(np.sqrt(self.gravity / self.radius))

    @property
    def schuler_speed(self) -> float:
        """Speed sqrt(g R), m/s: the ratio of the amplitudes of dv_N and dphi."""
        return float(np.sqrt(self.gravity * self.radius))

    @property
    def p(self) -> float:
        """Coefficient p of the characteristic equation beta^4 + p beta^2 - q = 0, 1/s^2."""
        return 2 * self.inertial_rate * self.coriolis_rate - self.vertical_gradient + self.specific_force / self.radius

    @property
    def height_stiffness(self) -> float:
        """a_24 + 2 omega_N v/R, 1/s^2: what holds a constant height error at equilibrium."""
        return self.vertical_gradient + 2 * self.inertial_rate * self.v_east / self.radius

    @property
    def q(self) -> float:
        """Coefficient q of the characteristic equation beta^4 + p beta^2 - q = 0, 1/s^4."""
        return self.height_stiffness * self.specific_force / self.radius

    @property
    def state_scale(self) -> FloatArray:
        """Natural unit of each component: sqrt(g R) for velocities, R for height, 1 rad for angles."""
        speed = self.schuler_speed
        return np.array([speed, speed, speed, self.radius, 1.0, 1.0])

    def matrix(self) -> FloatArray:
        """Matrix A of X' = A X, eq. (10), shape (6, 6)."""
        matrix = np.zeros((6, 6))
        matrix[0, 4] = -self.gravity
        matrix[1, 2], matrix[1, 3] = 2 * self.inertial_rate, self.vertical_gradient
        matrix[2, 1], matrix[2, 5] = -self.coriolis_rate, -self.specific_force
        matrix[3, 1] = 1.0
        matrix[4, 0] = 1 / self.radius
        matrix[5, 2], matrix[5, 3] = 1 / self.radius, -self.v_east / self.radius**2
        return matrix


def forcing_matrix(misalignment: FloatArray) -> FloatArray:
    """Return the coefficients of b/a_H, eq. (8), over the harmonics of the inertial longitude.

    Parameters
    ----------
    misalignment : (3, 3) array
        Lambda = dC^T(t0) C(t0) of the attitude matrix in the inertial frame, rad.

    Returns
    -------
    (6, 5) array
        Columns multiply 1, cos th, sin th, cos 2th, sin 2th; the squares of (8) are written as double angles.
    """
    l = misalignment
    even, odd = (l[1, 1] - l[2, 2]) / 2, (l[1, 2] + l[2, 1]) / 2
    coefficients = np.zeros((6, 5))
    coefficients[0] = [0.0, l[0, 1], l[0, 2], 0.0, 0.0]
    coefficients[1] = [(l[1, 1] + l[2, 2]) / 2, 0.0, 0.0, even, odd]
    coefficients[2] = [(l[2, 1] - l[1, 2]) / 2, 0.0, 0.0, odd, -even]
    return coefficients


def harmonics(angle: ArrayLike) -> FloatArray:
    """Return 1, cos th, sin th, cos 2th, sin 2th of the inertial longitude th, rad; shape (..., 5)."""
    th = np.asarray(angle, dtype=np.float64)
    return np.stack([np.ones_like(th), np.cos(th), np.sin(th), np.cos(2 * th), np.sin(2 * th)], axis=-1)


def forcing(motion: EquatorMotion, misalignment: FloatArray, angle: ArrayLike) -> FloatArray:
    """Return b of eq. (8) at the inertial longitudes `angle`, rad; (..., 6), in units of the state per s."""
    result: FloatArray = motion.specific_force * (harmonics(angle) @ forcing_matrix(misalignment).T)
    return result


def particular_solution(motion: EquatorMotion, misalignment: FloatArray, angle: ArrayLike) -> FloatArray:
    """Return a particular solution of the up, east and longitude equations under the forcing (8).

    The forcing there is a constant plus the second harmonic of the inertial longitude, and so is this
    solution.  It is the part of (23) that the paper calls elementary and does not print.

    Parameters
    ----------
    motion : EquatorMotion
        The motion; 2 omega_N must not be an eigenfrequency and `height_stiffness` not zero.
    misalignment : (3, 3) array
        Lambda, rad.
    angle : array_like
        Inertial longitude th, rad.

    Returns
    -------
    (..., 6) array
        The state; zero in dv_N and dphi.

    Raises
    ------
    NotApplicableError
        If a denominator is zero.
    """
    chi, stiffness = harmonic_denominator(motion), motion.height_stiffness
    if chi == 0 or stiffness == 0:
        raise NotApplicableError("the particular solution divides by zero at this speed and height")
    rate, a_H, R = motion.inertial_rate, motion.specific_force, motion.radius
    constant_up, constant_east = forcing_matrix(misalignment)[1:3, 0]
    up_harmonic, east_harmonic = np.moveaxis(harmonics(angle)[..., 3:] @ forcing_matrix(misalignment)[1:3, 3:].T, -1, 0)
    G = (a_H / R - 8 * rate**2) / chi
    E = (
        2 * rate * (4 * rate**2 + motion.vertical_gradient)
        + 4 * motion.coriolis_rate * rate**2
        + a_H * motion.v_east / R**2
    ) / chi
    height = -a_H * constant_up / stiffness
    state = np.zeros((*up_harmonic.shape, 6))
    state[..., 1] = 2 * rate * a_H * G * east_harmonic
    state[..., 2] = motion.v_east / R * height + a_H * E * up_harmonic
    state[..., 3] = height + a_H * G * up_harmonic
    state[..., 5] = constant_east + (1 - 2 * rate * (E + motion.coriolis_rate * G)) * east_harmonic
    return state


def harmonic_denominator(motion: EquatorMotion) -> float:
    """Return chi = 16 omega_N^4 - 4 omega_N^2 p - q, 1/s^4: zero when 2 omega_N is an eigenfrequency."""
    rate_squared = motion.inertial_rate**2
    return 16 * rate_squared**2 - 4 * rate_squared * motion.p - motion.q


@dataclass(frozen=True)
class EquatorCase:
    """What an equator subject is asked to solve, checked and converted.

    Attributes
    ----------
    time : (n,) array
        Instants of output, s, ascending, none negative; the initial errors belong to t = 0.
    motion : EquatorMotion
        The motion.
    initial_errors : (6,) array
        State at t = 0.
    misalignment : (3, 3) array or None
        Lambda, rad; None stands for an error-free attitude (b = 0).
    inertial_longitude : float
        Inertial longitude at t = 0, rad.
    """

    time: FloatArray
    motion: EquatorMotion
    initial_errors: FloatArray
    misalignment: FloatArray | None
    inertial_longitude: float

    @property
    def angle(self) -> FloatArray:
        """Inertial longitude at the instants of output, eq. (7), rad; shape (n,)."""
        return self.inertial_longitude + self.motion.inertial_rate * self.time


class Solver(Protocol):
    """A subject of the equator error equations."""

    def __call__(
        self,
        time: ArrayLike,
        v_east: float,
        height: float,
        initial_errors: ArrayLike,
        misalignment: ArrayLike | None = None,
        inertial_longitude: float = 0.0,
    ) -> FloatArray:
        """Return the errors, shape (n, 6), at the n instants of `time`."""


_CONTRACT = """\
Parameters
----------
time : (n,) array_like
    Instants, s, ascending, none negative; the initial errors belong to t = 0.
v_east, height : float
    Eastward speed, m/s, and height, m.
initial_errors : (6,) array_like
    dv_N, dv_H, dv_E (m/s), dH (m), dphi, dlam (rad).
misalignment : (3, 3) array_like, optional
    Lambda = dC^T(t0) C(t0), rad; None leaves the equations homogeneous.
inertial_longitude : float, optional
    Inertial longitude at t = 0, rad.

Returns
-------
(n, 6) array
    The errors in the order and units of `initial_errors`.

Raises
------
NotApplicableError
    If the method cannot treat the case.
ValueError
    If an argument has the wrong shape or a value outside its range.
"""


def solver(method: Callable[[EquatorCase], FloatArray]) -> Solver:
    """Turn a method that solves an `EquatorCase` into a subject with checked arguments and result."""

    def solve(
        time: ArrayLike,
        v_east: float,
        height: float,
        initial_errors: ArrayLike,
        misalignment: ArrayLike | None = None,
        inertial_longitude: float = 0.0,
    ) -> FloatArray:
        instants = checked_time(time)
        initial = _checked("initial_errors", initial_errors, (6,))
        attitude = None if misalignment is None else _checked("misalignment", misalignment, (3, 3))
        if not np.isfinite(inertial_longitude):
            raise ValueError(f"inertial_longitude = {inertial_longitude} rad is not finite")
        motion = EquatorMotion.at(v_east, height)
        # Overflow is reported once, below, for every method alike.
        with np.errstate(over="ignore", invalid="ignore"):
            result = method(EquatorCase(instants, motion, initial, attitude, float(inertial_longitude)))
        if not np.isfinite(result).all():
            raise NotApplicableError("the errors or a factor of the formula exceed the range of float64")
        return result

    solve.__name__ = solve.__qualname__ = method.__name__
    solve.__module__ = method.__module__
    solve.__doc__ = f"{inspect.getdoc(method)}\n\n{_CONTRACT}"
    return solve


def checked_time(time: ArrayLike) -> FloatArray:
    """Return the instants, s, as a (n,) array.

    Raises
    ------
    ValueError
        If they are not finite, ascending and at or after zero.
    """
    instants = np.asarray(time, dtype=np.float64)
    if instants.ndim != 1:
        raise ValueError(f"time has shape {instants.shape}; (n,) is needed")
    if not np.isfinite(instants).all() or (instants < 0).any() or (np.diff(instants) < 0).any():
        raise ValueError("time must be finite, ascending and nowhere negative, in s")
    return instants


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}; {shape} is needed")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds a value that is not finite")
    return array
