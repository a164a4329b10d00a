"""The differential equations behind `mast_antenna`: attitudes from rates, Newton's equation, Kepler's of satellites.

What is integrated knows the programs of velocity and rates and where the motion starts. The place of the vehicle comes
out of its specific force, so force and place confirm each other; the specific force at the top of the mast is the
second derivative of its inertial position, range rates are those of inertial velocities: no formula of a rotating frame
but that of the vehicle's specific force is used. The antenna is turned, and readings are moved, by the normal numbers
of the case, computed anew from their bits.

Sources: Sokolov, Pogorelov, Reshetnikova 2024, eq. (3.1), (3.2), (3.6), (3.10), (3.15)-(3.17), corrected
(`sinsref.mast`); G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958) 610-611.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import pi

from sinsdata.cases import MastCase
from sinsdata.truth.mast_blocks import constants_of, start_attitudes
from sinsdata.truth.mast_recomputed import uniform_word
from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.elementary import angle
from sinsref.mast import (
    GRAVITATIONAL_PARAMETER,
    Orbit,
    exponential,
    from_level,
    level_force,
    receiver_position,
    resolved,
)
from sinsref.mast_random import Stream
from sinsref.profiles import TimeSum
from sinsref.quaternion import Vector, conjugate, cross, dot, product, rotate

#: Tables that are filled, with a row per epoch and with a row per step.
PER_EPOCH, PER_STEP = ("satellites", "measurements", "truth"), "sensors"
#: Places of mu, lambda, the vehicle's position and velocity in the state; satellites follow, six numbers each.
_MU, _LAMBDA, _PLACE, _SPEED, _SATELLITES = slice(1, 5), slice(5, 9), slice(9, 12), slice(12, 15), range(15, 39, 6)


def _plus(*vectors: Vector) -> list[Number]:
    return [sum(parts[1:], parts[0]) for parts in zip(*vectors, strict=True)]


def _times(factor: Number, vector: Vector) -> list[Number]:
    return [factor * x for x in vector]


@dataclass(frozen=True)
class _Readings:
    """Noise-free readings at an instant, but for the antenna's own turning."""

    rate_1: Vector
    force_1: Vector
    carried: Vector
    force_2: Vector

    def with_antenna(self, rate: Vector) -> list[Number]:
        return [*self.rate_1, *self.force_1, *_plus(self.carried, rate), *self.force_2]


class MastProblem:
    """Field, start and rows of a case; the state is time, mu, lambda, position and velocity of vehicle and satellites.

    Positions and velocities are inertial.

    Parameters
    ----------
    ar : BallArithmetic
        Entered.
    case : MastCase

    Attributes
    ----------
    initial : list of Number
    """

    def __init__(self, ar: BallArithmetic, case: MastCase) -> None:
        self._ar, self._case = ar, case
        self._constants = constants_of(ar, case)
        self._velocity = [x.terms(ar) for x in (case.velocity_east, case.velocity_north, case.velocity_up)]
        self._rates = [x.terms(ar) for x in (*case.angular_rate, *case.mast_rate)]
        self._interval, self._seed = ar.number(case.interval), int(case.seed.fraction or 0)
        self._turning = [ar.number(0), self._constants.rotation_rate, ar.number(0)]
        zero = ar.number(0)
        mu, self._eta, lam = start_attitudes(ar, case)
        self._longitude = ar.number(case.longitude)
        longitude, latitude = ar.sin_cos(self._longitude), ar.sin_cos(ar.number(case.latitude))
        place = receiver_position(self._constants, longitude, latitude, ar.number(case.height))
        velocity = from_level(longitude, latitude, self._jets(ar, self._velocity, zero)[0])
        self.initial = [zero, *mu, *lam, *place, *_plus(velocity, cross(self._turning, place))]
        orbit = Orbit.at(ar, self._constants.rotation_rate)
        for pair in case.satellites:
            position, motion = orbit.place(*(ar.sin_cos(ar.number(x)) for x in pair))
            self.initial += [*position, *_plus(motion, cross(self._turning, position))]
        self._normals = lru_cache(maxsize=64)(self._pair)

    @staticmethod
    def _jets(ar: Arithmetic, sums: Sequence[TimeSum], time: Number) -> tuple[list[Number], list[Number]]:
        jets = [x.jet(ar, time) for x in sums]
        return [jet[0] for jet in jets], [jet[1] for jet in jets]

    def _force(self, ar: Arithmetic, state: Sequence[Number]) -> list[Number]:
        """Return the specific force of the vehicle in inertial axes: eq. (3.2) at the place of the state."""
        x, y, z = place = state[_PLACE]
        level = ar.sqrt(x * x + z * z)
        distance = ar.sqrt(dot(place, place))
        latitude, longitude = (y / distance, level / distance), (x / level, z / level)
        height = distance - self._constants.radius
        velocity, acceleration = self._jets(ar, self._velocity, state[0])
        force = level_force(self._constants, velocity, acceleration, height, latitude)
        return from_level(longitude, latitude, force)

    def field(self, ar: Arithmetic, state: Sequence[Number]) -> list[Number]:
        """Return the derivative of a state."""
        zero = ar.number(0)
        rates = self._jets(ar, self._rates, state[0])[0]
        place = state[_PLACE]
        pull = -self._constants.gravity / ar.sqrt(dot(place, place))
        derivative = [
            ar.number(1),
            *(x / 2 for x in product(state[_MU], [zero, *rates[:3]])),
            *(x / 2 for x in product(state[_LAMBDA], [zero, *rates[3:], zero])),
            *state[_SPEED],
            *_plus(self._force(ar, state), _times(pull, place)),
        ]
        attraction = -ar.number(GRAVITATIONAL_PARAMETER)
        for first in _SATELLITES:
            position = state[first : first + 3]
            square = dot(position, position)
            derivative += [*state[first + 3 : first + 6], *_times(attraction / (square * ar.sqrt(square)), position)]
        return derivative

    @staticmethod
    def states_per_step(tables: Collection[str]) -> int:
        """Return how many states of a step are needed to fill tables: readings are of its middle, too."""
        return 2 if PER_STEP in tables else 1

    def rows(
        self, states: Iterable[Sequence[Number]], tables: Collection[str]
    ) -> Iterator[Mapping[str, Sequence[Number]]]:
        """Yield the rows of the epochs, time first; no reading at the start.

        Parameters
        ----------
        states : iterable of sequence of Number
            From the start on, `states_per_step` of them a step.
        tables : collection of str
            Those that are wanted of `PER_EPOCH` and `PER_STEP`.
        """
        ar, eta, longitude, parts = self._ar, self._eta, self._longitude, self.states_per_step(tables)
        antenna: list[Number] = []
        turn: list[Number] = []
        nodes: list[Number] = []
        for number, state in enumerate(states):
            if turn:
                eta = product(eta, turn)
            seen = self._readings(state, eta) if PER_STEP in tables else None
            if seen and number:
                nodes += seen.with_antenna(antenna)
            if number % parts:
                continue
            step, time, found = number // parts, state[0], dict[str, Sequence[Number]]()
            if seen and number:
                found[PER_STEP] = [time, *nodes, *self._noise(step - 1)]
            if "truth" in tables:
                truth = self._truth(state, eta, longitude)
                longitude, found["truth"] = truth[16], [time, *truth]
            if {"satellites", "measurements"} & set(tables):
                values = [self._satellite(state, first) for first in _SATELLITES]
                found["satellites"] = [time, *(x for value in values for x in value)]
                measured = [x for value in values for x in value[6:]]
                found["measurements"] = [time, *_plus(measured, self._measurement_noise(step))]
            yield {table: row for table, row in found.items() if table in tables}
            if {PER_STEP, "truth"} & set(tables):
                antenna = self._samples(Stream.ANTENNA_RATE, step, ar.number(self._case.antenna_rate_sd))
                turn = exponential(ar, _times(self._interval / parts, antenna))
            nodes = seen.with_antenna(antenna) if seen else []

    def _readings(self, state: Sequence[Number], eta: Sequence[Number]) -> _Readings:
        zero, one = self._ar.number(0), self._ar.number(1)
        rates, slopes = self._jets(self._ar, self._rates, state[0])
        mu, lam = state[_MU], state[_LAMBDA]
        # Of chi = mu o lambda, the mast's attitude in inertial axes, two derivatives.
        mu_1, mu_2 = _turned(mu, [zero, *rates[:3]], [zero, *slopes[:3]])
        lam_1, lam_2 = _turned(lam, [zero, *rates[3:], zero], [zero, *slopes[3:], zero])
        chi = product(mu, lam)
        chi_1 = _plus(product(mu_1, lam), product(mu, lam_1))
        chi_2 = _plus(product(mu_2, lam), _times(2, product(mu_1, lam_1)), product(mu, lam_2))
        axis = [zero, zero, zero, one]
        swing = _plus(
            product(product(chi_2, axis), conjugate(chi)),
            _times(2, product(product(chi_1, axis), conjugate(chi_1))),
            product(product(chi, axis), conjugate(chi_2)),
        )[1:]
        force = self._force(self._ar, state)
        top = _plus(force, _times(self._constants.mast_length, swing))
        absolute = _times(2, product(conjugate(chi), chi_1))[1:]
        return _Readings(rates[:3], resolved(mu, force), resolved(eta, absolute), resolved(product(chi, eta), top))

    def _truth(self, state: Sequence[Number], eta: Sequence[Number], before: Number) -> list[Number]:
        """Return the 24 values of a row; whole turns of the longitude are those nearest to the epoch before."""
        ar = self._ar
        mu, lam, place = state[_MU], state[_LAMBDA], state[_PLACE]
        level = ar.sqrt(place[0] * place[0] + place[2] * place[2])
        distance = ar.sqrt(dot(place, place))
        inertial = angle(ar, place[0] / level, place[2] / level) - self._constants.rotation_rate * state[0]
        longitude = inertial + 2 * ar.pi * round(float(before - inertial) / (2 * pi))
        latitude = angle(ar, place[1] / distance, level / distance)
        x, y, z = _plus(state[_SPEED], _times(-1, cross(self._turning, place)))
        (sin_l, cos_l), (sin_b, cos_b) = (place[0] / level, place[2] / level), (place[1] / distance, level / distance)
        outward = x * sin_l + z * cos_l
        velocity = [x * cos_l - z * sin_l, y * cos_b - outward * sin_b, y * sin_b + outward * cos_b]
        rates = self._jets(ar, self._rates, state[0])[0]
        absolute = _plus(rates[3:], resolved(lam, rates[:3])[:2])
        height = distance - self._constants.radius
        return [*mu, *lam, *eta, *product(lam, eta), longitude, latitude, height, *velocity, *absolute]

    def _satellite(self, state: Sequence[Number], first: int) -> list[Number]:
        """Return position and Earth-relative velocity in Earth-fixed axes, range rate and range."""
        position, motion = state[first : first + 3], state[first + 3 : first + 6]
        line = _plus(position, _times(-1, state[_PLACE]))
        distance = self._ar.sqrt(dot(line, line))
        rate = dot(line, _plus(motion, _times(-1, state[_SPEED]))) / distance
        sine, cosine = self._ar.sin_cos(self._constants.rotation_rate * state[0] / 2)
        earth = [cosine, sine * 0, sine, sine * 0]
        relative = _plus(motion, _times(-1, cross(self._turning, position)))
        return [*rotate(conjugate(earth), position), *rotate(conjugate(earth), relative), rate, distance]

    def _noise(self, step: int) -> list[Number]:
        """Return what readings of a step differ by: noise, and the fault of axis x."""
        gyro, accelerometer = (self._ar.number(x) for x in (self._case.gyro_sd, self._case.accelerometer_sd))
        sensors = (
            ("rate1", Stream.RATE_1, gyro),
            ("specific_force1", Stream.FORCE_1, accelerometer),
            ("rate2", Stream.RATE_2, gyro),
            ("specific_force2", Stream.FORCE_2, accelerometer),
        )
        found: list[Number] = []
        for name, stream, deviation in sensors:
            x, *others = self._samples(stream, step, deviation)
            found += [x + self._bias(name, step), *others]
        return found

    def _measurement_noise(self, step: int) -> list[Number]:
        """Return the same of range rate and range of each satellite."""
        deviations = [self._ar.number(x) for x in (self._case.range_rate_sd, self._case.range_sd)]
        noise = [deviations[n % 2] * self._normal(Stream.SATELLITES, 8 * step + n) for n in range(8)]
        return [noise[0] + self._bias("range_rate", step), noise[1] + self._bias("range", step), *noise[2:]]

    def _bias(self, what: str, step: int) -> Number:
        # A twentieth of a step early: the fault begins in the step that its time names, however that is rounded.
        early = self._interval * step < self._ar.number(self._case.fault_time) - self._interval / 20
        return self._ar.number(0 if early or self._case.fault != what else self._case.fault_size)

    def _samples(self, stream: Stream, step: int, deviation: Number) -> list[Number]:
        return [deviation * self._normal(stream, 3 * step + axis) for axis in range(3)]

    def _normal(self, stream: Stream, index: int) -> Number:
        return self._normals(stream, index // 2)[index % 2]

    def _pair(self, stream: Stream, number: int) -> tuple[Number, Number]:
        """Return normal numbers 2j and 2j + 1 of a stream, by Box and Muller's transform."""
        words = (uniform_word(self._seed, stream, 2 * number + place) >> 11 for place in (0, 1))
        # As binary64: where 53 bits are used up the half rounds to even.
        first, second = (self._ar.number(Fraction(float(word) + 0.5) / 2**53) for word in words)
        sine, cosine = self._ar.sin_cos(2 * self._ar.pi * second)
        radius = self._ar.sqrt(-2 * first.log())
        return radius * cosine, radius * sine


def _turned(quaternion: Vector, rate: Vector, slope: Vector) -> tuple[list[Number], list[Number]]:
    """Return both derivatives of a quaternion that turns at a rate, given with its slope as pure quaternions."""
    first = _times(0.5, product(quaternion, rate))
    second = _times(0.5, _plus(product(first, rate), product(quaternion, slope)))
    return first, second
