"""Equations of Sokolov, Pogorelov, Reshetnikova 2024 in the form printed and in others, put to the test on exact data.

A form is the text of the part in question; everything else of the equation is right. What decides on it is a pair of
vectors: what the definitions give, and what the form gives. The definitions are the specific force over a sphere, the
specific force at the top of a rigid mast, the composition of rotations, and the paper's own (3.11) where only signs are
in question.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from itertools import product as pairs
from typing import TypeAlias

from sinsbench.claims.gyroscopic_form_data import Data, rate_of, times, total
from sinsbench.claims.gyroscopic_forms import residuals_of
from sinsbench.claims.quantities import Enclosure
from sinsref.arithmetic import Number
from sinsref.mast import Constants, level_force, resolved, top_force
from sinsref.quaternion import cross, dot, product

__all__ = ["EQUATIONS", "residuals"]

Vector: TypeAlias = Sequence[Number]
Forms: TypeAlias = Mapping[str, tuple[Vector, Vector]]


def _minus(a: Vector, b: Vector) -> list[Number]:
    return [x - y for x, y in zip(a, b, strict=True)]


# Vehicle


class _Vehicle:
    """A vehicle over a sphere: what (3.2) tells of its specific force."""

    def __init__(self, data: Data) -> None:
        self.sine, self.cosine = latitude = data.balls.sin_cos(data.angle())
        radius, gravity, rate, height = (abs(data.number()) for _ in range(4))
        self.distance, self.rate, self.gravitation = radius + height, rate, gravity
        self.velocity, self.acceleration = data.vector(), data.vector()
        constants = Constants(radius, gravity, rate, abs(data.number()))
        self.force = level_force(constants, self.velocity, self.acceleration, height, latitude)
        east, north, _ = self.velocity
        self.turning = [
            -north / self.distance,
            2 * rate * self.cosine + east / self.distance,
            2 * rate * self.sine + east * self.sine / (self.cosine * self.distance),
        ]

    def gravity(self, north: Number | None = None, up: Number | None = None) -> list[Number]:
        """Return g_S, with other horizontal and upward centrifugal parts than the right ones if they are given."""
        swing = self.rate * self.rate * self.distance * self.cosine
        return [
            self.sine * 0,
            -swing * self.sine if north is None else north,
            (swing * self.cosine if up is None else up) - self.gravitation,
        ]

    def sides(self, sign: int, gravity: Vector) -> tuple[Vector, Vector]:
        """Return dV/dt, and f_S + sign (2 Omega_S + omega_S) x V + g_S."""
        return self.acceleration, total(self.force, times(sign, cross(self.turning, self.velocity)), gravity)


def transport(data: Data) -> Forms:
    """(3.5): sign of (2 Omega_S + omega_S) x V; (3.3), in components, has the right one."""
    at = _Vehicle(data)
    return {f"{name} (2 Omega_S + omega_S) x V": at.sides(sign, at.gravity()) for name, sign in (("-", -1), ("+", 1))}


def upward_gravity(data: Data) -> Forms:
    """(3.14) and g_Q: the upward component of the centrifugal acceleration."""
    at = _Vehicle(data)
    first = at.rate * at.rate * at.distance * at.cosine
    return {
        "Omega^2 r cos^2(lat)": at.sides(-1, at.gravity()),
        "Omega^2 r cos(lat)": at.sides(-1, at.gravity(up=first)),
    }


def northward_gravity(data: Data) -> Forms:
    """g_Q: its northward component."""
    at = _Vehicle(data)
    first = -at.rate * at.distance * at.cosine * at.sine
    return {
        "-Omega^2 r cos(lat) sin(lat)": at.sides(-1, at.gravity()),
        "-Omega r cos(lat) sin(lat)": at.sides(-1, at.gravity(north=first)),
    }


# Mast, by the paper's own (3.11): V = (R wY, -R wX, 0)


class _Mast:
    """A point on a sphere of radius R that turns at w, by (3.11): what the second accelerometers are said to add."""

    def __init__(self, data: Data) -> None:
        self.length = abs(data.number())
        self.rate, self.slope = ([data.number(), data.number(), data.zero] for _ in range(2))
        self.earth, self.gravity = data.vector(), data.vector()
        velocity, acceleration = ([self.length * y, -self.length * x, z] for x, y, z in (self.rate, self.slope))
        turning = total(times(2, self.earth), self.rate)
        self.force = _minus(total(acceleration, cross(turning, velocity)), self.gravity)


def mast_force_x(data: Data) -> Forms:
    """(3.12), A_X."""
    at = _Mast(data)
    x, slope = at.rate[0], at.slope[1]
    return {
        f"R wY' {name} 2 Omega_Z R wX - g_X": (
            at.force[:1],
            [at.length * (slope + sign * 2 * at.earth[2] * x) - at.gravity[0]],
        )
        for name, sign in (("+", 1), ("-", -1))
    }


def mast_force_y(data: Data) -> Forms:
    """(3.12), A_Y."""
    at = _Mast(data)
    (x, y, _), slope, twice = at.rate, at.slope[0], 2 * at.earth[2]
    return {
        "-R wX' + 2 Omega_Z R wY - g_Y": (at.force[1:2], [at.length * (twice * y - slope) - at.gravity[1]]),
        "R wX' - 2 Omega_Z R wX - g_Y": (at.force[1:2], [at.length * (slope - twice * x) - at.gravity[1]]),
    }


def mast_force_z(data: Data) -> Forms:
    """(3.12), A_Z: as printed without an equals sign."""
    at = _Mast(data)
    (x, y, _), (earth_x, earth_y, _) = at.rate, at.earth
    whole = at.length * ((2 * earth_y + y) * y + (2 * earth_x + x) * x)
    return {
        f"{name}(2 Omega_Y + wY) R wY {name or '+'} (2 Omega_X + wX) R wX - g_Z": (
            at.force[2:],
            [sign * whole - at.gravity[2]],
        )
        for name, sign in (("-", -1), ("", 1))
    }


_RIGHT = ("-+", "+-", "-+")
"""Signs, in the lines X and Y of w', of the terms with (A_Y, A_X), (wY, wX) and (g_Y, g_X)."""
_RATE_FORMS: Mapping[str, tuple[int, Mapping[str, str]]] = {
    "(3.13), accelerations": (0, {"(1/R) [0 -1; 1 0]": "-+", "-(1/R) [0 1; 1 0]": "--"}),
    "(3.14), accelerations": (0, {"(1/R) [0 -1; 1 0]": "-+", "-R [0 1; 1 0]": "-- times R"}),
    "(3.13), Coriolis": (1, {"[0 1; -1 0]": "+-", "[0 -1; 1 0]": "-+"}),
    "(3.14), Coriolis": (1, {"[0 1; -1 0]": "+-", "[0 1; 1 0]": "++"}),
    "(3.13), gravity": (2, {"(-g_Y, g_X)": "-+", "(-g_Y, -g_X)": "--"}),
}
"""The three terms of w', (3.12) solved for it: which of them a form is of, and its signs and factor."""


def mast_rate(data: Data, place: str) -> Forms:
    """(3.13) and (3.14), one term of w' at a time."""
    at, (part, texts) = _Mast(data), _RATE_FORMS[place]
    factors = [1 / at.length, 2 * at.earth[2], 1 / at.length]
    vectors = [vector[1::-1] for vector in (at.force, at.rate, at.gravity)]

    def given(form: str) -> list[Number]:
        terms = []
        for k, (right, factor, vector) in enumerate(zip(_RIGHT, factors, vectors, strict=True)):
            own = form if k == part else right
            size = at.length if "times R" in own else factor
            terms.append([size * (x if sign == "+" else -x) for sign, x in zip(own[:2], vector, strict=True)])
        return total(*terms)

    return {text: (at.slope[:2], given(form)) for text, form in texts.items()}


# Mast, by the mechanics of a rigid body


def top_of_the_mast(data: Data) -> Forms:
    """A_Q of (3.11) in Z_a2 = D(eta) (A_Q + D(lambda) f1): f1 holds gravity already, and J1 turns at w1."""
    frame, length = data.frame()[0], abs(data.number())
    force, rate, slope = (data.vector() for _ in range(3))
    own, own_slope = ([data.number(), data.number(), data.zero] for _ in range(2))
    constants = Constants(data.one, data.one, data.one, length)
    top = top_force(constants, frame, force, rate, slope, own[:2], own_slope[:2])
    carried = resolved(frame, force)
    u = resolved(frame, rate)
    absolute = total(own, u)
    change = total(own_slope, resolved(frame, slope), times(-1, cross(own, u)))
    arm = [data.zero, data.zero, length]
    velocity, acceleration = cross(own, arm), cross(own_slope, arm)
    earth, gravity = data.vector(), data.vector()
    # Of (3.11) the part without gravity, with 2 Omega_Q or with the vehicle's whole turn in place of it.
    printed = total(acceleration, cross(total(times(2, earth), own), velocity))
    rigid = total(cross(change, arm), cross(absolute, cross(absolute, arm)))
    return {
        text: (top, total(carried, form))
        for text, form in (
            ("w' x rho + w x (w x rho)", rigid),
            ("V'_Q + (2 Omega_Q + omega_Q) x V_Q - g_Q", _minus(printed, gravity)),
            ("V'_Q + (2 Omega_Q + omega_Q) x V_Q", printed),
            ("w' x rho + w x (w x rho) - g_Q", _minus(rigid, gravity)),
        )
    }


def second_gyroscope(data: Data) -> Forms:
    """(3.15): what turns J2; the rate of J1 is absolute, as gyroscopes measure it."""
    (mu, mu_), (lam, lam_), (eta, eta_) = (data.frame() for _ in range(3))
    nu, nu_ = product(lam, eta), total(product(lam_, eta), product(lam, eta_))
    chi, chi_ = product(mu, nu), total(product(mu_, nu), product(mu, nu_))
    vehicle, mast, antenna = (rate_of(*pair) for pair in ((mu, mu_), (lam, lam_), (eta, eta_)))
    earth = resolved(nu, data.vector())
    carried, driven = resolved(nu, vehicle), resolved(eta, mast)
    known = rate_of(chi, chi_)
    return {
        "w_JQ + D(eta) omega_Q + D(eta) D(lambda) w1": (known, total(antenna, driven, carried)),
        "w_JQ + D(eta) omega_Q + Omega_QJ2 + D(eta) D(lambda) w1": (known, total(antenna, driven, earth, carried)),
        "w_JQ + Omega_QJ2 + D(eta) D(lambda) w1": (known, total(antenna, earth, carried)),
    }


def vehicle_rate(data: Data) -> Forms:
    """omega_J12 before (3.15), of Z_d1 = w1 + W_d1."""
    frame, rate, noise = data.frame()[0], data.vector(), data.vector()
    shown, known = total(rate, noise), resolved(frame, rate)
    return {
        "Z_d1 - W_d1": (known, resolved(frame, _minus(shown, noise))),
        "Z_d1 + W_d1": (known, resolved(frame, total(shown, noise))),
    }


def noise_vector(data: Data) -> Forms:
    """W of (3.14): A_Q = D^T(eta) (Z_a2 - W_a2) - D(lambda) (Z_a1 - W_a1), with what stands third in it as W_a2."""
    own, first, second = (data.vector() for _ in range(3))
    return {name: (own, _minus(total(own, second), noise)) for name, noise in (("W_a2", second), ("W_a1", first))}


def satellite_range(data: Data) -> Forms:
    """Z_R before (3.17), squared: under the root the printed sum may be negative."""
    x, y, z = data.vector()
    known = [dot([x, y, z], [x, y, z])]
    return {
        f"(eta_c - r sin(lat)){power}": (known, [x * x + axial + z * z]) for power, axial in (("^2", y * y), ("", y))
    }


def covariance_rate(data: Data) -> Forms:
    """(3.18): the rate of R = x x^T for x' = A x."""
    x, rows = data.vector(), [data.vector() for _ in range(3)]
    slope = [dot(row, x) for row in rows]
    places = tuple(pairs(range(3), repeat=2))
    known = [slope[i] * x[j] + x[i] * slope[j] for i, j in places]
    left = [sum((rows[i][k] * x[k] * x[j] for k in range(3)), data.zero) for i, j in places]
    right = [sum((x[i] * x[k] * rows[j][k] for k in range(3)), data.zero) for i, j in places]
    untransposed = [sum((x[i] * x[k] * rows[k][j] for k in range(3)), data.zero) for i, j in places]
    return {"A R + R A^T": (known, total(left, right)), "A R + R A": (known, total(left, untransposed))}


EQUATIONS: Mapping[str, Callable[[Data], Forms]] = {
    "(3.5)": transport,
    "(3.14), g": upward_gravity,
    "g_Q": northward_gravity,
    "(3.12), A_X": mast_force_x,
    "(3.12), A_Y": mast_force_y,
    "(3.12), A_Z": mast_force_z,
    **{place: partial(mast_rate, place=place) for place in _RATE_FORMS},
    "(3.11)": top_of_the_mast,
    "(3.15)": second_gyroscope,
    "omega_J12": vehicle_rate,
    "W": noise_vector,
    "Z_R": satellite_range,
    "(3.18)": covariance_rate,
}
"""Equations by place: a function from data to the forms of each."""


@cache
def residuals(equation: str) -> Mapping[str, Enclosure]:
    """Return what each form of an equation leaves, relative to the equation, over all data.

    Parameters
    ----------
    equation : str
        A key of `EQUATIONS`.
    """
    return residuals_of(EQUATIONS[equation])
