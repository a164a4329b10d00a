"""The second path to the rows of `mast_antenna`: the differential equations by Taylor series, and noise by mpmath.

Nothing of `sinsdata.truth.mast_blocks` is used but what a case means: no Magnus expansion, no closed integral, no
running product, no elementary function of ours.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from sinsdata.cases.mast import MastCase
from sinsref.arithmetic import MpArithmetic, Number
from sinsref.mast import (
    Constants,
    Orbit,
    exponential,
    from_level,
    level_force,
    level_quaternion,
    mast_rates,
    position_rates,
    range_and_rate,
    receiver_position,
    resolved,
    top_force,
)
from sinsref.mast_random import Stream
from sinsref.profiles import Profile, TimeSum
from sinsref.quaternion import product
from sinsref.series import Series, SeriesArithmetic
from sinsref.taylor import integrate

_DIGITS, _ORDER = 30, 12
#: The largest change of phase, rad, in a step of the Taylor series: its terms fall below 1e-17.
_LARGEST_PHASE = 0.25
_WORD = 2**64


def uniform_word(seed: int, stream: int, index: int) -> int:
    """Return 64 random bits, by whole numbers alone (`sinsref.mast_random`)."""

    def mixed(z: int) -> int:
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 % _WORD
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB % _WORD
        return z ^ (z >> 31)

    return mixed((mixed(seed) + ((stream << 40) + index + 1) * 0x9E3779B97F4A7C15) % _WORD)


def normal(ar: MpArithmetic, seed: int, stream: int, index: int) -> Number:
    """Return a normal number: Box and Muller's transform of the same bits by mpmath."""
    words = (uniform_word(seed, stream, index - index % 2 + place) >> 11 for place in (0, 1))
    # As binary64: where 53 bits are used up the half rounds to even.
    first, second = (ar.number(Fraction(float(word) + 0.5) / 2**53) for word in words)
    sine, cosine = ar.sin_cos(2 * ar.pi * second)
    return ar.sqrt(-2 * ar.context.ln(first)) * (sine if index % 2 else cosine)


class ExactMast:
    """A case in mpmath.

    Parameters
    ----------
    case : MastCase
    digits : int, default 30
    """

    def __init__(self, case: MastCase, digits: int = _DIGITS) -> None:
        self.case, self.ar = case, MpArithmetic(digits)
        number = self.ar.number
        self.interval = number(case.interval)
        given = (case.radius, case.gravity, case.rotation_rate, case.mast_length)
        self.constants = Constants(*(number(x) for x in given))
        self.orbit = Orbit.at(self.ar, self.constants.rotation_rate)
        self.velocity = [self._terms(x) for x in (case.velocity_east, case.velocity_north, case.velocity_up)]
        self.rates = [self._terms(x) for x in (*case.angular_rate, *case.mast_rate)]
        self.seed = int(case.seed.fraction or 0)

    def _terms(self, profile: Profile) -> TimeSum:
        return profile.terms(self.ar)

    def start(self) -> list[Number]:
        """Return mu (4), lambda (4), longitude, latitude and height at time 0."""
        number, case = self.ar.number, self.case
        longitude, latitude = number(case.longitude), number(case.latitude)
        turns = (case.vehicle_rotation, case.mast_rotation)
        vehicle, mast = (exponential(self.ar, [number(x) for x in turn]) for turn in turns)
        mu = product(level_quaternion(self.ar, longitude, latitude), vehicle)
        return [*mu, *mast, longitude, latitude, number(case.height)]

    def field(self, series: SeriesArithmetic, time: Series, state: list[Series]) -> list[Any]:
        """Return the derivative of what `start` gives: eq. (3.1), (3.6), (3.10)."""
        velocity, rates = (
            [x.lifted(series.constant).jet(series, time)[0] for x in sums] for sums in (self.velocity, self.rates)
        )
        zero = time * 0
        halves = [
            [x / 2 for x in product(state[place : place + 4], [zero, *turning])]
            for place, turning in ((0, rates[:3]), (4, [*rates[3:], zero]))
        ]
        moved = Constants(*(series.constant(x) for x in vars(self.constants).values()))
        east, north = position_rates(moved, velocity, state[10], series.sin_cos(state[9]))
        return [*halves[0], *halves[1], east, north, velocity[2]]

    def antenna_rate(self, step: int) -> list[Number]:
        """Return the rate of the antenna relative to the mast in a step."""
        return self.noise(Stream.ANTENNA_RATE, step, self.ar.number(self.case.antenna_rate_sd))

    def noise(self, stream: Stream, step: int, deviation: Number) -> list[Number]:
        """Return three normal numbers of a step."""
        return [deviation * normal(self.ar, self.seed, stream, 3 * step + axis) for axis in range(3)]

    def bias(self, what: str, step: int) -> Number:
        """Return the fault of a reading in a step."""
        late = self.interval * step < self.ar.number(self.case.fault_time) - self.interval / 20
        return self.ar.number(0 if late or self.case.fault != what else self.case.fault_size)

    def rows(self, wanted: Iterable[int]) -> Iterator[ExactRow]:
        """Yield rows of the half grid, in increasing order."""
        number = self.ar.number
        state, row = self.start(), 0
        eta = exponential(self.ar, [number(x) for x in self.case.antenna_rotation])
        quickest = max([1e-9, *(abs(float(p.rate)) for x in (*self.rates, *self.velocity) for p in x.oscillations)])
        quickest = max(quickest, 35 * self.case.parts * 1e-3 / float(self.interval))
        for target in wanted:
            begin, end = self.interval * row / 2, self.interval * target / 2
            if target > row:
                steps = int(quickest * float(end - begin) / _LARGEST_PHASE) + 1
                state = integrate(self.ar, self.field, state, begin, end, steps=steps, order=_ORDER)
            while row < target:
                turn = [x * self.interval / 2 for x in self.antenna_rate(row // 2)]
                eta, row = product(eta, exponential(self.ar, turn)), row + 1
            yield ExactRow(self, row, end, state, eta)


@dataclass(frozen=True)
class ExactRow:
    """A row of the half grid.

    Attributes
    ----------
    exact : ExactMast
    row : int
    time : Number
        s.
    state : list of Number
        See `ExactMast.start`.
    eta : list of Number
    """

    exact: ExactMast
    row: int
    time: Number
    state: list[Number]
    eta: list[Number]

    def _jets(self, sums: list[TimeSum]) -> tuple[list[Number], list[Number]]:
        jets = [x.jet(self.exact.ar, self.time) for x in sums]
        return [jet[0] for jet in jets], [jet[1] for jet in jets]

    def truth(self) -> list[Number]:
        """Return the 24 values of a row of ``truth``."""
        mu, lam, (longitude, latitude, height) = self.state[:4], self.state[4:8], self.state[8:]
        velocity, rates = self._jets(self.exact.velocity)[0], self._jets(self.exact.rates)[0]
        mast_rate = mast_rates(lam, rates[:3], rates[3:])[1][:2]
        return [*mu, *lam, *self.eta, *product(lam, self.eta), longitude, latitude, height, *velocity, *mast_rate]

    def readings(self, step: int) -> list[Number]:
        """Return the readings without noise in a step, 12 values."""
        ar, constants, lam = self.exact.ar, self.exact.constants, self.state[4:8]
        longitude, latitude = self.state[8] + constants.rotation_rate * self.time, ar.sin_cos(self.state[9])
        velocity, acceleration = self._jets(self.exact.velocity)
        rates, slopes = self._jets(self.exact.rates)
        force = level_force(constants, velocity, acceleration, self.state[10], latitude)
        force_1 = resolved(self.state[:4], from_level(ar.sin_cos(longitude), latitude, force))
        top = top_force(constants, lam, force_1, rates[:3], slopes[:3], rates[3:], slopes[3:])
        carried = resolved(self.eta, mast_rates(lam, rates[:3], rates[3:])[1])
        rate_2 = [x + y for x, y in zip(carried, self.exact.antenna_rate(step), strict=True)]
        return [*rates[:3], *force_1, *rate_2, *resolved(self.eta, top)]

    def satellites(self) -> list[list[Number]]:
        """Return position, velocity, range rate and range of each of the four satellites."""
        ar, constants, found = self.exact.ar, self.exact.constants, []
        longitude, latitude = (ar.sin_cos(x) for x in self.state[8:10])
        place = receiver_position(constants, longitude, latitude, self.state[10])
        velocity = from_level(longitude, latitude, self._jets(self.exact.velocity)[0])
        for pair in self.exact.case.satellites:
            node, argument = (ar.number(x) for x in pair)
            angles = node - constants.rotation_rate * self.time, argument + self.exact.orbit.motion * self.time
            position, speed = self.exact.orbit.place(*(ar.sin_cos(angle) for angle in angles))
            distance, rate = range_and_rate(ar.sqrt, place, velocity, position, speed)
            found.append([*position, *speed, rate, distance])
        return found


def exact_truth(case: MastCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 24 values of rows of ``truth``."""
    for row in ExactMast(case).rows(2 * epoch for epoch in rows):
        yield [row.time, *row.truth()]


def exact_satellites(case: MastCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 32 values of rows of ``satellites``."""
    for row in ExactMast(case).rows(2 * epoch for epoch in rows):
        yield [row.time, *(value for values in row.satellites() for value in values)]


def exact_measurements(case: MastCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 8 values of rows of ``measurements``."""
    exact = ExactMast(case)
    deviations = [exact.ar.number(x) for x in (case.range_rate_sd, case.range_sd)]
    for row in exact.rows(2 * epoch for epoch in rows):
        values = [row.time]
        for n, satellite in enumerate(row.satellites()):
            for place, (deviation, name) in enumerate(zip(deviations, ("range_rate", "range"), strict=True)):
                noise = deviation * normal(exact.ar, exact.seed, Stream.SATELLITES, 4 * row.row + 2 * n + place)
                fault = exact.bias(name, row.row // 2) if n == 0 else 0
                values.append(satellite[6 + place] + noise + fault)
        yield values


def exact_sensors(case: MastCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 48 values of rows of ``sensors``."""
    exact = ExactMast(case)
    gyro, accelerometer = (exact.ar.number(x) for x in (case.gyro_sd, case.accelerometer_sd))
    streams = {
        "rate1": (Stream.RATE_1, gyro),
        "specific_force1": (Stream.FORCE_1, accelerometer),
        "rate2": (Stream.RATE_2, gyro),
        "specific_force2": (Stream.FORCE_2, accelerometer),
    }
    steps = list(rows)
    found = exact.rows(2 * step + node for step in steps for node in range(3))
    for step in steps:
        values: list[Number] = []
        for _ in range(3):
            row = next(found)
            values += row.readings(step)
        for name, (stream, deviation) in streams.items():
            noise = exact.noise(stream, step, deviation)
            values += [noise[0] + exact.bias(name, step), *noise[1:]]
        yield [row.time, *values]
