r"""Motions over a sphere in inertial space, and what gyroscopes and accelerometers measure along them.

The axes X do not rotate: X2 is the axis of the Earth's rotation, X1 and X3 lie in the equator, X3 in the meridian of
Greenwich at t = 0. In them the vertical at latitude :math:`\varphi` and absolute longitude :math:`L` is
:math:`(\cos\varphi\sin L,\ \sin\varphi,\ \cos\varphi\cos L)`. Local axes are east, north, up, in this order; vehicle
axes are right, forward, up. Attitude follows from heading (clockwise from north), pitch (nose up) and roll (right side
down) as in (2.11).

A place moves in one of three ways (`Motion.kind`):

============  ==================================================================================
track         latitude and longitude are functions of time
parallel      latitude is constant, the speed east over the Earth a function of time
great_circle  fixed in inertial space; the absolute speed along it is a function of time
============  ==================================================================================

`Kinematics` has closed forms, resolved in the local axes, for any arithmetic. `literal_sensors` is the definition
itself, derivatives of position and attitude in the axes X by Taylor series: that both agree is a test.

Source: Chelnokov 1991, eq. (1.14)-(1.16), (2.8)-(2.11); the sphere's attraction is uniform over its surface.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from sinsref.arithmetic import Arithmetic, Number
from sinsref.elementary import angle
from sinsref.exact import ExactNumber
from sinsref.profiles import Profile, TimeSum
from sinsref.quaternion import conjugate, product, rotate
from sinsref.series import Series, SeriesArithmetic

#: The kinds of motion.
KINDS = ("track", "parallel", "great_circle")


@dataclass(frozen=True)
class Motion:
    """A motion over the sphere and the attitude during it, exactly given.

    Attributes
    ----------
    kind : {"track", "parallel", "great_circle"}
    latitude : Profile
        Geocentric, rad. On a great circle that at t = 0.
    longitude : Profile
        Relative to the rotating Earth, rad; that at t = 0 unless the motion is a track.
    speed : Profile
        On a parallel the speed east over the Earth, on a great circle the absolute speed, both at the sphere's surface,
        m/s. A track has none.
    course : ExactNumber
        Direction of the great circle at t = 0, clockwise from north, rad.
    altitude : Profile
        Above the sphere, m.
    heading, pitch, roll : Profile
        rad.
    radius : ExactNumber
        Of the sphere, m.
    gravity : ExactNumber
        Attraction at its surface, m/s^2; it falls with the square of the distance.
    rotation_rate : ExactNumber
        Of the Earth, rad/s.
    """

    kind: str
    latitude: Profile
    longitude: Profile
    speed: Profile
    course: ExactNumber
    altitude: Profile
    heading: Profile
    pitch: Profile
    roll: Profile
    radius: ExactNumber
    gravity: ExactNumber
    rotation_rate: ExactNumber


@dataclass(frozen=True)
class Place:
    """Where the vehicle is, and how its local axes east-north-up turn.

    Attributes
    ----------
    latitude : tuple of 2 Number
        Sine and cosine.
    longitude : tuple of 2 Number
        Sine and cosine of the absolute longitude.
    axes : list of 4 Number
        Quaternion from the local axes to X: of the columns east, north, up.
    rate : list of 3 Number
        Angular rate of the local axes relative to X, in themselves, rad/s.
    acceleration : tuple of 2 Number
        East and north component of the second derivative of the vertical, rad/s^2.
    radius : tuple of 3 Number
        Distance from the centre and its two derivatives, m.
    attraction : Number
        m/s^2.
    """

    latitude: tuple[Number, Number]
    longitude: tuple[Number, Number]
    axes: list[Number]
    rate: list[Number]
    acceleration: tuple[Number, Number]
    radius: tuple[Number, Number, Number]
    attraction: Number

    def from_local(self, vector: Sequence[Number]) -> list[Number]:
        """Return a vector given by its components east, north, up in the axes X."""
        (sin_lat, cos_lat), (sin_lon, cos_lon), (east, north, up) = self.latitude, self.longitude, vector
        level = up * cos_lat - north * sin_lat
        return [east * cos_lon + level * sin_lon, north * cos_lat + up * sin_lat, level * cos_lon - east * sin_lon]

    @property
    def vertical(self) -> list[Number]:
        """Third of the local axes, in X."""
        (sin_lat, cos_lat), (sin_lon, cos_lon) = self.latitude, self.longitude
        return [cos_lat * sin_lon, sin_lat, cos_lat * cos_lon]

    @property
    def velocity(self) -> list[Number]:
        """Absolute velocity in the local axes, m/s."""
        r, r_dot, _ = self.radius
        return [r * self.rate[1], -(r * self.rate[0]), r_dot]

    @property
    def specific_force(self) -> list[Number]:
        """Absolute acceleration less attraction, in the local axes, m/s^2."""
        r, r_dot, r_ddot = self.radius
        east, north = self.rate[1], -self.rate[0]
        return [
            r * self.acceleration[0] + r_dot * east * 2,
            r * self.acceleration[1] + r_dot * north * 2,
            r_ddot - r * (east * east + north * north) + self.attraction,
        ]


def half_turn(ar: Arithmetic, sine: Number, cosine: Number) -> tuple[Number, Number]:
    """Return cosine and sine of half an angle in (-pi, pi], from sine and cosine of the angle, without cancellation."""
    if ar.sign(cosine) >= 0:
        half = ar.sqrt((cosine + 1) / 2)
        return half, sine / (half * 2)
    half = ar.sqrt((1 - cosine) / 2)
    if ar.sign(sine) < 0:
        half = -half
    return sine / (half * 2), half


def elementary(ar: Arithmetic, axis: int, turn: Number) -> list[Number]:
    """Return the quaternion of a rotation by an angle about axis 1, 2 or 3."""
    sine, cosine = ar.sin_cos(turn / 2)
    rotation = [cosine, *[ar.number(0)] * 3]
    rotation[axis] = sine
    return rotation


class Kinematics:
    """A motion in an arithmetic.

    Parameters
    ----------
    ar : Arithmetic
    motion : Motion
    """

    def __init__(self, ar: Arithmetic, motion: Motion) -> None:
        self.ar, self.motion = ar, motion
        names = ("latitude", "longitude", "speed", "altitude", "heading", "pitch", "roll")
        self._profiles: dict[str, TimeSum] = {name: getattr(motion, name).terms(ar) for name in names}
        self.radius, self.gravity, self.rotation_rate, self._course = (
            ar.number(x) for x in (motion.radius, motion.gravity, motion.rotation_rate, motion.course)
        )

    @property
    def rates(self) -> list[Number]:
        """The angular rates of all oscillations of the profiles, rad/s."""
        return [part.rate for terms in self._profiles.values() for part in terms.oscillations]

    def jet(self, name: str, time: Number) -> tuple[Number, Number, Number]:
        """Return value and two derivatives of a profile of the motion."""
        return self._profiles[name].jet(self.ar, time)

    def travelled(self, time: Number) -> tuple[Number, Number, Number]:
        """Return the integral of the speed over the radius, an angle, and its two derivatives."""
        terms = self._profiles["speed"]
        speed, slope, _ = terms.jet(self.ar, time)
        return terms.integral(self.ar, time) / self.radius, speed / self.radius, slope / self.radius

    def angles(self, time: Number) -> tuple[tuple[Number, Number, Number], tuple[Number, Number, Number]]:
        """Return latitude and absolute longitude with two derivatives each; not for a great circle."""
        latitude, (longitude, rate, acceleration) = self.jet("latitude", time), self.jet("longitude", time)
        longitude, rate = longitude + self.rotation_rate * time, rate + self.rotation_rate
        if self.motion.kind == "parallel":
            _, cosine = self.ar.sin_cos(latitude[0])
            turn, turn_rate, turn_acceleration = (x / cosine for x in self.travelled(time))
            return latitude, (longitude + turn, rate + turn_rate, acceleration + turn_acceleration)
        return latitude, (longitude, rate, acceleration)

    def place(self, time: Number) -> Place:
        """Return place and turning of the local axes at a time, s."""
        altitude, climb, climb_rate = self.jet("altitude", time)
        radius = self.radius + altitude
        ratio = self.radius / radius
        vertical = (radius, climb, climb_rate), self.gravity * ratio * ratio
        if self.motion.kind == "great_circle":
            return self._on_great_circle(time, *vertical)
        (lat, lat_rate, lat_acceleration), (lon, lon_rate, lon_acceleration) = self.angles(time)
        sin_lat, cos_lat = self.ar.sin_cos(lat)
        east = lon_rate * cos_lat
        return Place(
            (sin_lat, cos_lat),
            self.ar.sin_cos(lon),
            product(elementary(self.ar, 2, lon), elementary(self.ar, 1, -lat)),
            [-lat_rate, east, lon_rate * sin_lat],
            (
                lon_acceleration * cos_lat - sin_lat * lat_rate * lon_rate * 2,
                lat_acceleration + sin_lat * lon_rate * east,
            ),
            *vertical,
        )

    @cached_property
    def _start(self) -> tuple[Number, ...]:
        """Return sine and cosine of latitude, longitude and course at the start of a great circle."""
        zero = self.ar.number(0)
        angles = self.jet("latitude", zero)[0], self.jet("longitude", zero)[0], self._course
        return tuple(x for angle in angles for x in self.ar.sin_cos(angle))

    def _on_great_circle(self, time: Number, radius: tuple[Number, Number, Number], attraction: Number) -> Place:
        """Spherical trigonometry; the local axes are those of the path, turned by the convergence of the meridians."""
        ar = self.ar
        sin_0, cos_0, sin_lon_0, cos_lon_0, sin_course, cos_course = self._start
        turn, rate, acceleration = self.travelled(time)
        sine, cosine = ar.sin_cos(turn)
        sin_lat = sin_0 * cosine + cos_0 * cos_course * sine
        # Cosine of the latitude times cosine and sine of the course at the time: the latter is Clairaut's constant.
        ahead, across = cos_0 * cos_course * cosine - sin_0 * sine, cos_0 * sin_course
        cos_lat = ar.sqrt(ahead * ahead + across * across)
        # Cosine of the latitude times cosine and sine of the change of longitude.
        along, aside = cos_0 * cosine - sin_0 * cos_course * sine, sin_course * sine
        longitude = (
            (sin_lon_0 * along + cos_lon_0 * aside) / cos_lat,
            (cos_lon_0 * along - sin_lon_0 * aside) / cos_lat,
        )
        # The course changes by less than half a turn: half that change is found without a choice of branches.
        change, unchanged = across * cos_course - ahead * sin_course, ahead * cos_course + across * sin_course
        norm = ar.sqrt(cos_lat * (cos_lat + unchanged) * 2)
        zero = ar.number(0)
        convergence = [(cos_lat + unchanged) / norm, zero, zero, change / norm]
        path = product(self._path_axes, elementary(ar, 1, -turn))
        axes = product(product(path, elementary(ar, 3, self._course)), convergence)
        north, east = ahead / cos_lat, across / cos_lat
        return Place(
            (sin_lat, cos_lat),
            longitude,
            axes,
            [-(rate * north), rate * east, rate * east * sin_lat / cos_lat],
            (acceleration * east, acceleration * north),
            radius,
            attraction,
        )

    @cached_property
    def _path_axes(self) -> list[Number]:
        """Return the quaternion of the axes right, along, up of a great circle at its start."""
        zero = self.ar.number(0)
        local = product(
            elementary(self.ar, 2, self.jet("longitude", zero)[0]),
            elementary(self.ar, 1, -self.jet("latitude", zero)[0]),
        )
        return product(local, elementary(self.ar, 3, -self._course))

    def attitude(self, place: Place, time: Number) -> list[Number]:
        """Return the quaternion from vehicle axes to X."""
        heading, pitch, roll = (self.jet(name, time)[0] for name in ("heading", "pitch", "roll"))
        body = product(elementary(self.ar, 3, -heading), elementary(self.ar, 1, pitch))
        return product(place.axes, product(body, elementary(self.ar, 2, roll)))

    def sensors(self, place: Place, time: Number) -> list[Number]:
        """Return angular rate, rad/s, and specific force, m/s^2, in vehicle axes: 6 numbers."""
        rate, force = list(place.rate), place.specific_force
        for name, axis, sign in (("heading", 2, -1), ("pitch", 0, 1), ("roll", 1, 1)):
            value, slope, _ = self.jet(name, time)
            sine, cosine = self.ar.sin_cos(value * sign)
            rate, force = (_resolved(vector, axis, sine, cosine) for vector in (rate, force))
            rate[axis] = rate[axis] + slope * sign
        return [*rate, *force]

    def coordinates(self, place: Place, time: Number) -> tuple[Number, Number]:
        """Return latitude and absolute longitude, rad; the longitude goes on through whole turns.

        On a great circle they come from their sines and cosines, and the numbers must have a nearest binary64.
        """
        if self.motion.kind != "great_circle":
            (latitude, *_), (longitude, *_) = self.angles(time)
            return latitude, longitude
        # Over half a turn of the path the longitude changes by half a turn: what it differs by stays below that.
        sin_course, start = self._start[4], self.jet("longitude", time)[0]
        turned = start + self.travelled(time)[0] * self.ar.sign(sin_course)
        sine, cosine = self.ar.sin_cos(turned)
        sin_lon, cos_lon = place.longitude
        difference = angle(self.ar, sin_lon * cosine - cos_lon * sine, cos_lon * cosine + sin_lon * sine)
        return angle(self.ar, *place.latitude), turned + difference

    def force_x(self, time: Number) -> list[Number]:
        """Return the specific force in the axes X (2.8), m/s^2."""
        place = self.place(time)
        return place.from_local(place.specific_force)

    def speed(self, place: Place) -> Number:
        """Return the magnitude of the horizontal absolute velocity, m/s."""
        east, north, _ = place.velocity
        return self.ar.sqrt(east * east + north * north)

    def darboux(self, place: Place) -> list[Number]:
        """Return the quaternion from the Darboux trihedron of the absolute motion to X.

        Its third axis is the vertical, its first along the horizontal velocity. The angle from east to the latter is
        taken in (-pi, pi]: the sign of the quaternion jumps where the velocity turns through west.
        """
        east, north, _ = place.velocity
        speed = self.speed(place)
        cosine, sine = half_turn(self.ar, north / speed, east / speed)
        zero = self.ar.number(0)
        return product(place.axes, [cosine, zero, zero, sine])


def kinematics_of(motion: Motion) -> Callable[[Arithmetic], Kinematics]:
    """Return a function from arithmetics to the motion in each, whose constants are evaluated once an arithmetic."""
    known: dict[int, Kinematics] = {}

    def of(ar: Arithmetic) -> Kinematics:
        if id(ar) not in known:
            known[id(ar)] = Kinematics(ar, motion)  # keeps the arithmetic, so that no other ever has its identity
        return known[id(ar)]

    return of


def _resolved(vector: Sequence[Number], axis: int, sine: Number, cosine: Number) -> list[Number]:
    """Return the components of a vector in axes turned by an angle about one of them."""
    turned = list(vector)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turned[i], turned[j] = vector[i] * cosine + vector[j] * sine, vector[j] * cosine - vector[i] * sine
    return turned


def literal_sensors(ar: Arithmetic, motion: Motion, time: Number) -> list[Number]:
    """Return angular rate and specific force in vehicle axes by definition: derivatives of attitude and position.

    (1.14) gives the rate as ``2 conj(s) o s'``; the specific force is the second derivative of the position in X less
    attraction. The derivatives are coefficients of Taylor series.

    Parameters
    ----------
    ar : Arithmetic
    motion : Motion
    time : Number
        s.
    """
    series = SeriesArithmetic(ar)
    t = series.variable(time)
    kinematics = Kinematics(series, motion)
    place = kinematics.place(t)
    attitude = [_as_series(series, x) for x in kinematics.attitude(place, t)]
    value, slope = ([x[k] for x in attitude] for k in (0, 1))
    rate = [x * 2 for x in product(conjugate(value), slope)[1:]]
    position = [_as_series(series, place.radius[0] * x) for x in place.vertical]
    pull = _as_series(series, place.attraction)[0]
    upward = [_as_series(series, x)[0] for x in place.vertical]
    force = [x[2] * 2 + pull * up for x, up in zip(position, upward, strict=True)]
    return [*rate, *rotate(conjugate(value), force)]


def _as_series(series: SeriesArithmetic, x: Number) -> Series:
    return x if isinstance(x, Series) else series.constant(x)
