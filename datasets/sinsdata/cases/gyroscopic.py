"""Cases of motion over a sphere in inertial space, navigated by the equations of gyroscopic systems."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar

from flint import arb

from sinsdata.cases.base import CaseError, SampledCase, check_positive, checked_number
from sinsref.arithmetic import BallArithmetic, Number
from sinsref.exact import ExactNumber, ExpressionError
from sinsref.gyroscopic import KINDS, Kinematics, Motion
from sinsref.profiles import Profile

#: Keys that some kinds of motion have and others have not.
_OWN = {"track": (), "parallel": ("speed",), "great_circle": ("speed", "course")}
#: Keys of functions of time; on other motions than a track latitude and longitude are those at the start.
_PROFILES = ("latitude", "longitude", "speed", "altitude", "heading", "pitch", "roll")
_NUMBERS = ("duration", "interval", "course", "radius", "gravity", "rotation_rate")
#: Where latitude and pitch are still used as angles, rad from a right angle.
CLEARANCE = 1e-3
#: The slowest horizontal speed at which its direction is used, m/s.
SLOWEST = 1e-3
_LOWEST, _HIGHEST = -1e4, 1e6
#: Pieces of the time that a condition is examined on, and the shortest of them, s.
_PIECES, _INSTANT = 2**14, 1e-6

_SURFACE = Profile(0)
_HEADING = Profile("2*pi/9 + pi/10800*t + pi/9*sin(2*pi*t/1200)")
_PITCH = Profile("pi/90 + pi/45*sin(2*pi*t/500)")
_ROLL = Profile("2*pi/45*sin(2*pi*t/700 + 1) - pi/180")
_RADIUS, _GRAVITY, _ROTATION_RATE = ExactNumber("6371000"), ExactNumber("9.81"), ExactNumber("7.292115e-5")


@dataclass(frozen=True)
class GyroCase(SampledCase):
    """Motion over a sphere with a vehicle's attitude: a case of `gyro_systems`.

    Functions of time are given as text with the variable ``t``, in s: sums of powers of t and of sines and cosines of
    linear functions of t (`sinsref.profiles.Profile`). A number is a constant.

    Attributes
    ----------
    name : str
    motion : {"track", "parallel", "great_circle"}
        See `sinsref.gyroscopic`.
    latitude, longitude : Profile
        Geocentric latitude, and longitude relative to the rotating Earth, rad; on a parallel the latitude is constant,
        on a parallel and a great circle the longitude, on a great circle the latitude that at time 0.
    duration, interval : ExactNumber
        s.
    speed : Profile, optional
        On a parallel that east over the Earth, on a great circle the absolute speed; at the sphere's surface, m/s.
    course : ExactNumber, optional
        Of the great circle at time 0, clockwise from north, rad.
    altitude : Profile
        Above the sphere, m; 0 by default.
    heading, pitch, roll : Profile
        rad; by default a slow turn with oscillations of 20, 4 and 8 degrees.
    radius, gravity, rotation_rate : ExactNumber
        Of the sphere, m; attraction at its surface, m/s^2; rate of the Earth, rad/s.

    Raises
    ------
    CaseError
        For values out of range and functions that are not of the kind above; for a key that the motion does not have,
        or lacks; if at some time the motion comes within 1e-3 rad of a pole or the pitch of a right angle, the
        absolute speed falls below 1e-3 m/s or reaches sqrt(g R), or the altitude leaves -10 to 1000 km. The message
        says when.
    """

    name: str
    motion: str
    latitude: Profile
    longitude: Profile
    duration: ExactNumber
    interval: ExactNumber
    speed: Profile | None = None
    course: ExactNumber | None = None
    altitude: Profile = _SURFACE
    heading: Profile = _HEADING
    pitch: Profile = _PITCH
    roll: Profile = _ROLL
    radius: ExactNumber = _RADIUS
    gravity: ExactNumber = _GRAVITY
    rotation_rate: ExactNumber = _ROTATION_RATE

    _optional: ClassVar[frozenset[str]] = frozenset(
        {"speed", "course", "altitude", "heading", "pitch", "roll", "radius", "gravity", "rotation_rate"}
    )

    def __post_init__(self) -> None:
        if not isinstance(self.motion, str) or self.motion not in KINDS:
            raise CaseError("motion", self.motion, f"must be one of {', '.join(KINDS)}")
        own = _OWN[self.motion]
        for field in _OWN["great_circle"]:
            given = getattr(self, field)
            if given is None and field in own:
                raise CaseError(field, given, f"the motion {self.motion!r} needs it")
            if given is not None and field not in own:
                raise CaseError(field, given, f"the motion {self.motion!r} has no such key")
        for field in _PROFILES:
            if getattr(self, field) is not None:
                self._convert(**{field: checked_profile(field, getattr(self, field))})
        for field in _NUMBERS:
            if getattr(self, field) is not None:
                self._convert(**{field: checked_number(field, getattr(self, field))})
        self._check_name_and_sampling()
        for field, unit in (("radius", "m"), ("gravity", "m/s^2")):
            check_positive(field, getattr(self, field), unit)
        starts = {"track": (), "parallel": ("latitude", "longitude"), "great_circle": ("latitude", "longitude")}
        for field in starts[self.motion]:
            if getattr(self, field).constant is None:
                raise CaseError(field, getattr(self, field), f"must be a constant on a {self.motion}")
        refused = _first_refused(self.model, self.duration)
        if refused is not None:
            field, message, time = refused
            raise CaseError(field, getattr(self, field), f"{message}; t = {time:.6g} s")

    @cached_property
    def model(self) -> Motion:
        """The motion without its sampling."""
        return Motion(
            self.motion,
            self.latitude,
            self.longitude,
            self.speed or Profile(0),
            self.course or ExactNumber(0),
            self.altitude,
            self.heading,
            self.pitch,
            self.roll,
            self.radius,
            self.gravity,
            self.rotation_rate,
        )

    def check_speed_below(self, limit: float, field: str = "speed") -> None:
        """Raise `CaseError` unless the absolute horizontal speed stays below a limit: what some systems need.

        Parameters
        ----------
        limit : float
            m/s, such as 2B/(ml) of a two-rotor frame.
        field : str, default "speed"
            What the message names.
        """
        with BallArithmetic(64) as balls:
            kinematics = Kinematics(balls, self.model)
            try:
                time = first_failure(
                    lambda t: limit - kinematics.speed(kinematics.place(t)), balls.number(self.duration)
                )
            except UndecidedTimeError as error:
                time = error.time
        if time is not None:
            given = getattr(self, field, None)
            raise CaseError(field, given, f"the absolute speed must stay below {limit:g} m/s; t = {time:.6g} s")


def checked_profile(field: str, value: Any) -> Profile:
    """Return a function of time that a case was given, exactly.

    Raises
    ------
    CaseError
        If it is none.
    """
    if isinstance(value, Profile):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float | str | ExactNumber):
        raise CaseError(field, value, 'must be a number, or a string such as "pi/4 + 0.01*sin(2*pi*t/600)"')
    try:
        # A number alone has the bounds of numbers.
        profile = Profile(value if isinstance(value, str) else checked_number(field, value))
        return Profile(checked_number(field, profile.text)) if profile.constant is not None else profile
    except ExpressionError as error:
        raise CaseError(field, value, str(error)) from None


class UndecidedTimeError(ValueError):
    """A condition is not decided in as many pieces of time as are tried.

    Parameters
    ----------
    time : float
        From when on, s.
    """

    def __init__(self, time: float) -> None:
        super().__init__(f"not decided from {time:.6g} s on")
        self.time = time


def first_failure(excess: Callable[[Number], Number], duration: Number) -> float | None:
    """Return a time near the first at which a function of time is not proved positive; None if it is everywhere.

    The time is halved until balls decide, from the start on; the innermost pieces last 1e-6 s.

    Parameters
    ----------
    excess : callable
        ``excess(time)`` in ball arithmetic, of a ball of times.
    duration : arb
        s.

    Raises
    ------
    UndecidedTimeError
        If pieces run out: the duration is too long for a function that changes as fast.
    """
    waiting = [(0.0, float(duration.abs_upper()))]
    for _ in range(_PIECES):
        if not waiting:
            return None
        start, end = waiting.pop()
        middle, half = (start + end) / 2, (end - start) / 2
        value = excess(arb(middle, half * (1 + 1e-9)))
        if value > 0:
            continue
        if value < 0 or half < _INSTANT:
            return start
        waiting += [(middle, end), (start, middle)]
    raise UndecidedTimeError(waiting[-1][0])


@lru_cache(maxsize=1024)
def _first_refused(motion: Motion, duration: ExactNumber) -> tuple[str, str, float] | None:
    """Return field, message and time of the first condition that a motion breaks."""
    with BallArithmetic(64) as balls:
        kinematics = Kinematics(balls, motion)
        end = balls.number(duration)
        small, slowest, fastest = arb(CLEARANCE).sin(), arb(SLOWEST) ** 2, kinematics.gravity * kinematics.radius

        def altitude(time: Number) -> Number:
            return kinematics.jet("altitude", time)[0]

        def cosine(name: str) -> Callable[[Number], Number]:
            return lambda time: balls.sin_cos(kinematics.jet(name, time)[0])[1] - small

        def within(name: str, sign: int) -> Callable[[Number], Number]:
            return lambda time: balls.pi / 2 - kinematics.jet(name, time)[0] * sign

        def latitude(time: Number) -> Number:
            return kinematics.place(time).latitude[1] - small

        def square(time: Number) -> Number:
            east, north, _ = kinematics.place(time).velocity
            return east * east + north * north

        moving = "latitude" if motion.kind == "track" else "speed"
        heights = f"must stay between {_LOWEST:g} and {_HIGHEST:g} m"
        conditions = (
            ("altitude", heights, lambda time: altitude(time) - _LOWEST),
            ("altitude", heights, lambda time: _HIGHEST - altitude(time)),
            ("latitude", f"the motion comes within {CLEARANCE:g} rad of a pole", latitude),
            ("pitch", f"comes within {CLEARANCE:g} rad of a right angle", cosine("pitch")),
            *(
                (name, "must lie between -pi/2 and pi/2", within(name, x))
                for name in ("latitude", "pitch")
                for x in (1, -1)
            ),
            *(
                (("speed", "must be greater than 0 m/s", lambda time: kinematics.jet("speed", time)[0] - SLOWEST),)
                if motion.kind == "great_circle"
                else ()
            ),
            (moving, f"the absolute speed falls below {SLOWEST:g} m/s", lambda time: square(time) - slowest),
            (moving, "the absolute speed reaches sqrt(gravity*radius)", lambda time: fastest - square(time)),
        )
        for field, message, excess in conditions:
            try:
                time = first_failure(excess, end)
            except UndecidedTimeError as error:
                return "duration", f"is too long to decide that the {field} is admissible at all times", error.time
            if time is not None:
                return field, message, time
    return None
