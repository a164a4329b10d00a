"""Forms of the read-out (2.9)-(2.11) and of the full equations (3.1) of Chelnokov 1991.

A function takes data and returns the forms of one equation, as in `sinsbench.claims.gyroscopic_precession_forms`.
"""

from collections.abc import Mapping

from sinsbench.claims.gyroscopic_form_data import AS_PRINTED, Data, Sides, scalar, times, total, vector
from sinsref.arithmetic import Number
from sinsref.gyroscopic import elementary
from sinsref.gyroscopic_systems import full_acceleration
from sinsref.quaternion import conjugate, cross, dot, product, rotate

# The read-out


class _Vehicle:
    """Quaternions of (2.9)-(2.11) from angles: e of any azimuth about the vertical, s, and mu."""

    def __init__(self, data: Data) -> None:
        ar = data.balls
        longitude, latitude, azimuth, heading, pitch, roll = (data.angle() for _ in range(6))
        local = product(elementary(ar, 2, longitude), elementary(ar, 1, -latitude))
        body = product(elementary(ar, 3, -heading), product(elementary(ar, 1, pitch), elementary(ar, 2, roll)))
        self.e, s = product(local, elementary(ar, 3, azimuth)), product(local, body)
        self.mu = product(conjugate(self.e), s)
        self.sines = {
            name: ar.sin_cos(turn)
            for name, turn in (
                ("latitude", latitude), ("longitude", longitude), ("heading", heading), ("pitch", pitch),
                ("roll", roll),
            )
        }  # fmt: skip
        self.ar, self.half = ar, ar.number(1) / 2

    def direction(self, over: Number, under: Number) -> tuple[Number, Number]:
        """Return sine and cosine of the angle of a tangent over/under."""
        length = self.ar.sqrt(over * over + under * under)
        return over / length, under / length

    def sides(self, name: str, found: tuple[Number, Number]) -> Sides:
        """Return sine and cosine of an angle, and those found."""
        zero = found[0] * 0
        return [*self.sines[name], zero, zero], [*found, zero, zero]


def position(data: Data) -> Mapping[str, Sides]:
    """(2.9): sine of the latitude, and sine and cosine of the longitude by its tangent."""
    at = _Vehicle(data)
    e0, e1, e2, e3 = at.e
    longitude = at.direction(e1 * e3 + e0 * e2, e0 * e0 + e3 * e3 - at.half)
    known = [*at.sines["longitude"], at.sines["latitude"][0], data.zero]
    return {AS_PRINTED: (known, [*longitude, 2 * (e2 * e3 - e0 * e1), data.zero])}


def heading(data: Data) -> Mapping[str, Sides]:
    """(2.9), (2.11): the heading, the sum of two angles of which the azimuth of the gyro frame drops out."""
    at = _Vehicle(data)
    (e0, e1, e2, e3), (m0, m1, m2, m3) = at.e, at.mu
    s1, c1 = at.direction(-(e1 * e2 + e0 * e3), e0 * e0 + e2 * e2 - at.half)
    s2, c2 = at.direction(m1 * m2 - m0 * m3, m0 * m0 + m2 * m2 - at.half)
    return {AS_PRINTED: at.sides("heading", (s1 * c2 + c1 * s2, c1 * c2 - s1 * s2))}


def pitch(data: Data) -> Mapping[str, Sides]:
    """(2.11): sine of the pitch."""
    at = _Vehicle(data)
    m0, m1, m2, m3 = at.mu
    return {AS_PRINTED: (scalar(at.sines["pitch"][0]), scalar(2 * (m2 * m3 + m0 * m1)))}


def roll(data: Data) -> Mapping[str, Sides]:
    """(2.11): tangent of the roll."""
    at = _Vehicle(data)
    m0, m1, m2, m3 = at.mu
    over = -(m1 * m3 - m0 * m2)
    return {
        text: at.sides("roll", at.direction(over, square - at.half))
        for text, square in (("mu0^2 + mu3^2", m0 * m0 + m3 * m3), ("mu0^2 mu3^2", m0 * m0 * m3 * m3))
    }


# Section 3


class _Full:
    """Data of (3.1): z' = n L_X o z/2 with L' = M + m a x l, l = -l Y'3."""

    def __init__(self, data: Data) -> None:
        self.z, momentum = data.frame()[0], data.vector()
        self.inverse, self.ml = abs(data.number()), data.mass * data.length
        self.rate = times(self.inverse / 2, product(vector(momentum), self.z))
        self.data = data
        weight = cross(rotate(conjugate(self.z), data.force), [data.zero, data.zero, -self.ml])
        change = total(data.moment, rotate(self.z, weight))
        acceleration = total(product(vector(change), self.z), product(vector(momentum), self.rate))
        self.acceleration = times(self.inverse / 2, acceleration)
        self.moment_term = times(self.inverse / 2, product(vector(data.moment), self.z))

    def exact(self) -> list[Number]:
        """Return z'' by (3.1): the reference's form with 1/R = n m l, and the moment."""
        radius = 1 / (self.inverse * self.ml)
        return total(full_acceleration(radius, self.z, self.rate, self.data.force), self.moment_term)


def full_momentum(data: Data) -> Mapping[str, Sides]:
    """(3.1), second line: of which four numbers the sum of squares is (nL/2)^2."""
    at = _Full(data)
    wrong = total(at.exact(), times(dot(at.rate, at.rate) - dot(at.z, at.z), at.z))
    return {
        "z0'^2 + z1'^2 + z2'^2 + z3'^2": (at.acceleration, at.exact()),
        "z0^2 + z1^2 + z2^2 + z3^2": (at.acceleration, wrong),
    }


def full_weight(data: Data) -> Mapping[str, Sides]:
    """(3.1), first line: in which axes the specific force is resolved."""
    at = _Full(data)
    east, second = rotate(conjugate(at.z), data.force)[0], [data.zero, data.zero, data.one, data.zero]
    # -(1/2) n m l z o (-x i2) is what a component x adds.
    wrong = times(at.inverse * at.ml / 2 * (data.force[0] - east), product(at.z, second))
    return {
        "(a_Y'2 i1 - a_Y'1 i2)": (at.acceleration, at.exact()),
        "(a_Y'2 i1 - a_X1 i2)": (at.acceleration, total(at.exact(), wrong)),
    }


def frame_turning(data: Data) -> Mapping[str, Sides]:
    """After (3.1): Y' turns at n L, the frame Y at omega, with L . y3 = I3 omega_Y3; u is the difference along y3.

    No phi with the index Y3 is defined; that of the paper is the latitude, whose rate is here another number.
    """
    inverse, inertia, rate, latitude_rate = (data.number() for _ in range(4))
    needed = scalar(inverse * inertia * rate - rate)
    return {
        f"{name} y3": (needed, scalar((inverse * inertia - 1) * value))
        for name, value in (("omega_Y3", rate), ("phi'_Y3", latitude_rate))
    }
