"""Cases of an antenna on a mast on a moving vehicle, whose navigation parameters are estimated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from math import ceil
from typing import Any, ClassVar

import numpy as np

from sinsdata.cases.base import CaseError, SampledCase, check_positive, checked_number, checked_vector
from sinsdata.cases.gyroscopic import checked_profile, first_failure
from sinsref.arithmetic import BallArithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.mast import Orbit, from_level
from sinsref.mast_functions import GridFunction, Rows, antiderivative
from sinsref.profiles import Profile, TimeSum

#: What a fault may be added to: axis x of a sensor, or the first satellite.
FAULTS = ("rate1", "specific_force1", "rate2", "specific_force2", "range_rate", "range")
#: How near to a pole longitude is still used, rad, and heights, m.
_CLEARANCE, _LOWEST, _HIGHEST = 1e-3, -1e4, 1e6
#: What a step of the integration may turn, rad, where its error is a few units of 1e-20 (`sinsref.mast_running`), and
#: into how many such steps half an interval is cut at most.
_SMALL_TURN, _MOST_PARTS = 0.0175, 64
#: The largest standard deviation of the antenna's turn in an interval, rad: seven times as much is a small rotation.
_LARGEST_TURN = 0.05
#: Times at which the path is looked at.
_LOOKS = 2000

#: What cases that share sensors need not have in common.
_OWN = ("name", "run", "satellites_used", "range_rate_sd", "range_sd")
_PROFILES = ("velocity_east", "velocity_north", "velocity_up")
_POSITIVE = {"radius": "m", "mast_length": "m"}
_DEVIATIONS = (
    "antenna_rate_sd", "gyro_sd", "accelerometer_sd", "range_rate_sd", "range_sd",
    "attitude_error_sd", "position_error_sd", "velocity_error_sd", "mast_rate_error_sd",
)  # fmt: skip
_VECTORS = {"vehicle_rotation": 3, "mast_rotation": 3, "antenna_rotation": 3}
#: Longitude of the ascending node from the zero meridian and argument of latitude at time 0.
_CONSTELLATION = (("0", "pi/3"), ("pi/3", "pi/18"), ("11*pi/6", "5*pi/9"), ("25*pi/18", "7*pi/9"))


#: What the paper gives, and what its readers need besides.
_PAPER = {
    name: ExactNumber(text)
    for name, text in {
        "longitude": "pi/6",
        "latitude": "pi/4",
        "height": "3",
        "mast_length": "5",
        "antenna_rate_sd": "0.01",
        "gyro_sd": "5e-8",
        "accelerometer_sd": "1e-4",
        "range_rate_sd": "0.1",
        "range_sd": "5",
        "satellites_used": "4",
        "seed": "20240001",
        "error_seed": "1",
        "attitude_error_sd": "0.01/sqrt(3)",
        "position_error_sd": "3",
        "velocity_error_sd": "0.05",
        "mast_rate_error_sd": "0.005",
        "fault_time": "0",
        "fault_size": "0",
        "radius": "6371000",
        "gravity": "9.81",
        "rotation_rate": "7.292115e-5",
    }.items()
}
_STILL = Profile(0)
_NORTH, _UP = Profile("100 + sin(0.02*t)"), Profile("1.5*cos(t)")
_ANGULAR_RATE = (Profile("0.1*cos(3*t)"), Profile("0.001*cos(4*t)"), Profile("0.015*cos(7*t)"))
_MAST_RATE = (Profile("0.43*cos(2.45*t)"), Profile("0.3*cos(2.7*t)"))


def _numbers(*texts: str) -> tuple[ExactNumber, ...]:
    return tuple(map(ExactNumber, texts))


_NO_TURN, _ANTENNA_TURN = _numbers("0", "0", "0"), _numbers("0.03", "-0.02", "0.04")
_SATELLITES = tuple(_numbers(*pair) for pair in _CONSTELLATION)


@dataclass(frozen=True)
class MastCase(SampledCase):
    """Antenna on a mast on a moving vehicle: a case of `mast_antenna`.

    Functions of time are given as text with the variable ``t``, in s (`sinsref.profiles.Profile`). Everything but name,
    duration and interval has the paper's value by default.

    Attributes
    ----------
    name : str
    duration, interval : ExactNumber
        s. The interval is the step h at which sensors are read; noise is held over it.
    run : str, optional
        Name of the case whose sensors, satellites and truth this one shares: it differs from that in
        `satellites_used`, `range_rate_sd` and `range_sd` alone. Its own by default.
    longitude, latitude, height : ExactNumber
        At time 0; rad, spherical, and m.
    velocity_east, velocity_north, velocity_up : Profile
        Over the Earth, m/s.
    angular_rate : tuple of three Profile
        Absolute rate of the vehicle, in J1, rad/s.
    mast_rate : tuple of two Profile
        Rate of the mast relative to the vehicle about the axes X and Y of Q, rad/s.
    mast_length : ExactNumber
        m.
    vehicle_rotation, mast_rotation, antenna_rotation : tuple of three ExactNumber
        Rotation vectors at time 0, from S to J1, J1 to Q and Q to J2, rad.
    antenna_rate_sd, gyro_sd : ExactNumber
        Of a sample, rad/s: rate of the antenna relative to the mast, and noise of both triads of gyros.
    accelerometer_sd : ExactNumber
        Of a sample, m/s^2.
    range_rate_sd, range_sd : ExactNumber
        Of a measurement, m/s and m.
    satellites : tuple of four pairs of ExactNumber
        Longitude of the ascending node and argument of latitude at time 0, rad.
    satellites_used : ExactNumber
        1 to 4: the first ones.
    seed, error_seed : ExactNumber
        Of the samples, and of the errors of the initial estimate: whole numbers below 2^64.
    attitude_error_sd, position_error_sd, velocity_error_sd, mast_rate_error_sd : ExactNumber
        Of each component of the initial estimate, rad, m, m/s and rad/s.
    fault : {"rate1", "specific_force1", "rate2", "specific_force2", "range_rate", "range"}, optional
        What has a bias from `fault_time`, s, on: axis x of that sensor, or the first satellite; of `fault_size`.
    fault_time, fault_size : ExactNumber
    radius, gravity, rotation_rate : ExactNumber
        Of the sphere, m; attraction, the same at all heights, m/s^2; rate of the Earth, rad/s.

    Raises
    ------
    CaseError
        For values out of range and functions that are not of the kind above; if at some time the vehicle comes within
        1e-3 rad of a pole, its height leaves -10 to 1000 km, or a satellite that is used goes below the horizon, with
        the time; if rates are too fast for the interval.
    """

    name: str
    duration: ExactNumber
    interval: ExactNumber
    run: str | None = None
    longitude: ExactNumber = _PAPER["longitude"]
    latitude: ExactNumber = _PAPER["latitude"]
    height: ExactNumber = _PAPER["height"]
    velocity_east: Profile = _STILL
    velocity_north: Profile = _NORTH
    velocity_up: Profile = _UP
    angular_rate: tuple[Profile, ...] = _ANGULAR_RATE
    mast_rate: tuple[Profile, ...] = _MAST_RATE
    mast_length: ExactNumber = _PAPER["mast_length"]
    vehicle_rotation: tuple[ExactNumber, ...] = _NO_TURN
    mast_rotation: tuple[ExactNumber, ...] = _NO_TURN
    antenna_rotation: tuple[ExactNumber, ...] = _ANTENNA_TURN
    antenna_rate_sd: ExactNumber = _PAPER["antenna_rate_sd"]
    gyro_sd: ExactNumber = _PAPER["gyro_sd"]
    accelerometer_sd: ExactNumber = _PAPER["accelerometer_sd"]
    range_rate_sd: ExactNumber = _PAPER["range_rate_sd"]
    range_sd: ExactNumber = _PAPER["range_sd"]
    satellites: tuple[tuple[ExactNumber, ...], ...] = _SATELLITES
    satellites_used: ExactNumber = _PAPER["satellites_used"]
    seed: ExactNumber = _PAPER["seed"]
    error_seed: ExactNumber = _PAPER["error_seed"]
    attitude_error_sd: ExactNumber = _PAPER["attitude_error_sd"]
    position_error_sd: ExactNumber = _PAPER["position_error_sd"]
    velocity_error_sd: ExactNumber = _PAPER["velocity_error_sd"]
    mast_rate_error_sd: ExactNumber = _PAPER["mast_rate_error_sd"]
    fault: str | None = None
    fault_time: ExactNumber = _PAPER["fault_time"]
    fault_size: ExactNumber = _PAPER["fault_size"]
    radius: ExactNumber = _PAPER["radius"]
    gravity: ExactNumber = _PAPER["gravity"]
    rotation_rate: ExactNumber = _PAPER["rotation_rate"]

    _optional: ClassVar[frozenset[str]] = frozenset()

    def __post_init__(self) -> None:
        for field in fields(self):
            self._convert(**{field.name: _checked(field.name, getattr(self, field.name))})
        self._check_name_and_sampling()
        for name, unit in _POSITIVE.items():
            check_positive(name, getattr(self, name), unit)
        for name in (*_DEVIATIONS, "fault_time"):
            if float(getattr(self, name)) < 0:
                raise CaseError(name, getattr(self, name), "must not be negative")
        if self.run is not None and (not isinstance(self.run, str) or self.run == self.name):
            raise CaseError("run", self.run, "must be the name of another case")
        if self.fault is not None and self.fault not in FAULTS:
            raise CaseError("fault", self.fault, f"must be one of {', '.join(FAULTS)}")
        turn = float(self.antenna_rate_sd) * float(self.interval)
        if turn > _LARGEST_TURN:
            limit = _LARGEST_TURN / float(self.interval)
            given = self.antenna_rate_sd
            raise CaseError("antenna_rate_sd", given, f"must be at most {limit:g} rad/s for the interval")
        refused = _first_refused(self.path, self.duration, self.interval)
        if refused is not None:
            field_name, message = refused
            raise CaseError(field_name, getattr(self, field_name), message)

    @property
    def path(self) -> Path:
        """What the motion depends on."""
        return Path(
            (self.longitude, self.latitude, self.height),
            (self.velocity_east, self.velocity_north, self.velocity_up),
            (*self.angular_rate, *self.mast_rate),
            self.satellites[: self.satellite_count],
            (self.radius, self.gravity, self.rotation_rate, self.mast_length),
        )

    @property
    def satellite_count(self) -> int:
        """How many satellites are used."""
        return int(float(self.satellites_used))

    @cached_property
    def parts(self) -> int:
        """Into how many steps of the integration half an interval is cut."""
        return ceil(float(self.interval) / 2 * _quickest(self.path, self.duration) / _SMALL_TURN) or 1


MastCase._optional = frozenset(field.name for field in fields(MastCase)) - {"name", "duration", "interval"}


def refused_run(case: MastCase, others: Mapping[str, MastCase]) -> str | None:
    """Return why a case cannot share the sensors of the case that it names, of those in a dataset; None if it can."""
    if case.run is None:
        return None
    other = others.get(case.run)
    if other is None:
        return f"run = {case.run!r}: no such case beside it"
    if other.run is not None:
        return f"run = {case.run!r}: that case shares the sensors of {other.run!r}; name that one"
    for field in fields(case):
        if field.name not in _OWN and getattr(case, field.name) != getattr(other, field.name):
            return f"run = {case.run!r}: that case has another {field.name}; only {', '.join(_OWN[2:])} may differ"
    return None


@dataclass(frozen=True)
class Path:
    """Motion and satellites of a case.

    Attributes
    ----------
    start : tuple of ExactNumber
        Longitude, latitude, rad, and height, m, at time 0.
    velocity, rates : tuple of Profile
        East, north and up, m/s; absolute rates of the vehicle and relative ones of the mast, rad/s.
    satellites : tuple of pairs of ExactNumber
        Those that are used.
    constants : tuple of ExactNumber
        Radius, gravity, rate of the Earth, length of the mast.
    """

    start: tuple[ExactNumber, ...]
    velocity: tuple[Profile, ...]
    rates: tuple[Profile, ...]
    satellites: tuple[tuple[ExactNumber, ...], ...]
    constants: tuple[ExactNumber, ...]


def _checked(name: str, value: Any) -> Any:
    """Return a field of a case as what it is kept as."""
    if name in ("name", "run", "fault"):
        return value
    if name in _PROFILES:
        return checked_profile(name, value)
    if name in ("angular_rate", "mast_rate"):
        count = 3 if name == "angular_rate" else 2
        if isinstance(value, str) or not isinstance(value, list | tuple) or len(value) != count:
            raise CaseError(name, value, f"must be a list of {count} functions of time")
        return tuple(checked_profile(f"{name}[{i}]", x) for i, x in enumerate(value))
    if name == "satellites":
        if isinstance(value, str) or not isinstance(value, list | tuple) or len(value) != len(_CONSTELLATION):
            raise CaseError(name, value, "must be a list of 4 pairs: longitude of the node, argument of latitude")
        return tuple(checked_vector(f"{name}[{i}]", pair, 2) for i, pair in enumerate(value))
    if name in _VECTORS:
        return checked_vector(name, value, _VECTORS[name])
    number = checked_number(name, value)
    if name in ("satellites_used", "seed", "error_seed"):
        low, high = (1, len(_CONSTELLATION)) if name == "satellites_used" else (0, 2**64 - 1)
        whole = number.fraction
        if whole is None or whole.denominator != 1 or not low <= whole <= high:
            raise CaseError(name, number, f"must be a whole number, {low} to {high if high < 9 else '2^64 - 1'}")
    return number


@lru_cache(maxsize=256)
def _quickest(path: Path, duration: ExactNumber) -> float:
    """Return the highest rate at which an attitude, its rate, or a velocity changes, rad/s."""
    quickest, span = 0.0, float(duration)
    with BallArithmetic(64) as balls:
        groups = [
            [profile.terms(balls) for profile in group] for group in (path.rates[:3], path.rates[3:], path.velocity)
        ]
        for sums in groups[:2]:
            quickest = max(quickest, 2 * sum(_bound(terms, span) for terms in sums))
        swings = (abs(float(part.rate)) for sums in groups for terms in sums for part in terms.oscillations)
        return max(quickest, *swings, 0.0)


def _bound(terms: TimeSum, span: float) -> float:
    """Return a bound of the magnitude of a sum from time 0 on."""
    powers = sum(abs(float(x)) * span**k for k, x in enumerate(terms.powers))
    return powers + sum(abs(float(part.sine)) + abs(float(part.cosine)) for part in terms.oscillations)


@lru_cache(maxsize=256)
def _first_refused(path: Path, duration: ExactNumber, interval: ExactNumber) -> tuple[str, str] | None:
    """Return field and message of the first condition that a motion breaks."""
    longest = 2 * _MOST_PARTS * _SMALL_TURN / max(_quickest(path, duration), 1e-30)
    if float(interval) > longest:
        return "interval", f"must be at most {longest:.3g} s where the motion changes so quickly"
    with BallArithmetic(64) as balls:
        terms, end = antiderivative(path.velocity[2].terms(balls)), balls.number(duration)
        start = balls.number(path.start[2])
        heights = f"the height must stay between {_LOWEST:g} and {_HIGHEST:g} m"

        def height(time: Number) -> Number:
            return start + terms.jet(balls, time)[0]

        for excess in (lambda time: height(time) - _LOWEST, lambda time: _HIGHEST - height(time)):
            time = first_failure(excess, end)
            if time is not None:
                return "height" if time == 0 else "velocity_up", f"{heights}; t = {time:.6g} s"
    return _refused_place(path, float(duration))


def _refused_place(path: Path, duration: float) -> tuple[str, str] | None:
    """Look along the way for poles and horizons: binary64, where a metre or so does not matter."""
    rows = Rows(0, _LOOKS + 1, duration / _LOOKS)
    times = rows.time
    with BallArithmetic(192) as balls:
        moved = [antiderivative(profile.terms(balls)) for profile in path.velocity]
        integrals = [GridFunction.of(balls, terms, balls.number(rows.spacing)).values(rows) for terms in moved]
        orbit = Orbit.at(balls, balls.number(path.constants[2]))
        motion, rate = float(orbit.motion), float(orbit.rotation_rate)
        inclination = float(orbit.inclination[0]), float(orbit.inclination[1])
        numbers = Orbit(float(orbit.radius), motion, inclination, rate)
    longitude, latitude, height = (float(x) for x in path.start)
    distance = float(path.constants[0]) + height + integrals[2]
    middle = (distance[1:] + distance[:-1]) / 2
    latitudes = latitude + np.concatenate([[0.0], np.cumsum(np.diff(integrals[1]) / middle)])
    near = np.flatnonzero(np.abs(latitudes) > np.pi / 2 - _CLEARANCE)
    if len(near):
        where = f"comes within {_CLEARANCE:g} rad of a pole; t = {times[near[0]]:.6g} s"
        return ("latitude", where) if near[0] == 0 else ("velocity_north", f"the vehicle {where}")
    between = np.cos((latitudes[1:] + latitudes[:-1]) / 2)
    longitudes = longitude + np.concatenate([[0.0], np.cumsum(np.diff(integrals[0]) / middle / between)])
    pairs = (np.sin(longitudes), np.cos(longitudes)), (np.sin(latitudes), np.cos(latitudes))
    zero = np.zeros_like(times)
    up = from_level(*pairs, [zero, zero, zero + 1.0])
    for number, (node, argument) in enumerate(path.satellites, start=1):
        turned, along = float(node) - rate * times, float(argument) + motion * times
        place, _ = numbers.place((np.sin(turned), np.cos(turned)), (np.sin(along), np.cos(along)))
        below = np.flatnonzero(sum(x * y for x, y in zip(place, up, strict=True)) < distance)
        if len(below):
            return "satellites", f"satellite {number} is below the horizon; t = {times[below[0]]:.6g} s"
    return None
