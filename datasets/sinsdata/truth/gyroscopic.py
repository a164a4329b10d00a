"""Truth of the gyroscopic systems: motion, sensors, and the solutions of gyropendulum and bi-gyro; proved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import islice
from math import ceil, log, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases.base import CaseError, whole_intervals
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.certified import Block
from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.expansion import tabulated
from sinsref.gyroscopic import Kinematics, kinematics_of
from sinsref.gyroscopic_systems import bisector, enclosed_axes, start
from sinsref.rounding import TINY, RoundingTally, UndecidedError, pairs_at, round_balls

#: Rows that are rounded together: what bounds the memory.
BLOCK = 2048
#: Working precision of the first attempt at what is expanded in series, and factors of the later ones.
WORKING_BITS, ESCALATION = 192, (1, 2, 4, 8)
#: Bits that remainders may take: the first attempt leaves values within 2^-140.
_GUARD_BITS = 52

#: ``rows(balls, tolerance)`` yields the rows of values at consecutive epochs.
_Rows: TypeAlias = Callable[[BallArithmetic, float], Iterator[Sequence[Number]]]
_Array = NDArray[np.float64]


def truth_row(ar: Arithmetic, kinematics: Kinematics, time: Number) -> list[Number]:
    """Return the 23 columns of the table ``truth`` at a time, in the order of `GyroMotion`."""
    place = kinematics.place(time)
    latitude, longitude = kinematics.coordinates(place, time)
    return [
        latitude,
        longitude,
        longitude - kinematics.rotation_rate * time,
        *place.radius[:2],
        kinematics.speed(place),
        *place.from_local(place.velocity),
        *place.vertical,
        *(kinematics.jet(name, time)[0] for name in ("heading", "pitch", "roll")),
        *kinematics.attitude(place, time),
        *kinematics.darboux(place),
    ]


def truth_blocks(case: GyroCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield the rows of the table ``truth`` at consecutive epochs: 23 columns (`truth_row`)."""
    of = kinematics_of(case.model)

    def row(ar: Arithmetic, epoch: int) -> list[Number]:
        time = ar.number(case.interval) * epoch
        return [time, *truth_row(ar, of(ar), time)]

    for begin in range(first, first + count, BLOCK):
        index = np.arange(begin, min(begin + BLOCK, first + count))
        high, low = pairs_at(row, index.tolist(), WORKING_BITS, tally)
        yield Block(index, high[:, 0], low[:, 0], high[:, 1:], low[:, 1:])


def sensor_blocks(case: GyroCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield angular rate, specific force and their integrals over the sample that ends there: 12 columns.

    The integrals of epoch 0, at which no sample ends, are 0.
    """

    def rows(balls: BallArithmetic, tolerance: float) -> Iterator[Sequence[Number]]:
        of = kinematics_of(case.model)

        def sensors(ar: Arithmetic, time: Number) -> list[Number]:
            return of(ar).sensors(of(ar).place(time), time)

        begin, interval = max(first - 1, 0), balls.number(case.interval)
        values = tabulated(balls, sensors, interval, begin, first + count - 1, order=_order(balls), tolerance=tolerance)
        before: Sequence[Number] = ()
        for epoch, (instant, integrals) in enumerate(values, start=begin):
            if epoch >= first:
                increments = [x - y for x, y in zip(integrals, before, strict=True)] if epoch else [balls.number(0)] * 6
                yield [*instant, *increments]
            before = integrals

    yield from _proved(case, rows, WORKING_BITS, first, count, tally)


def reference_blocks(case: GyroCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield the axes of a constant-H bi-gyro and its vertical, from both starts: 18 columns.

    Raises
    ------
    UndecidedError
        If the highest working precision leaves a value undecided.
    sinsref.enclosure.EnclosureError
        If the solution cannot be enclosed.
    """

    def rows(balls: BallArithmetic, tolerance: float) -> Iterator[Sequence[Number]]:
        interval = balls.number(case.interval)
        axes = enclosed_axes(
            balls, case.model, interval, first, first + count - 1, order=_order(balls), tolerance=tolerance
        )
        for values in axes:
            yield with_verticals(balls, values)

    yield from _proved(case, rows, _reference_bits(case), first, count, tally, partial(_start_row, case))


def _order(balls: BallArithmetic) -> int:
    """Return the order of series at which pieces of a minute or so reach the tolerance, in any number of bits."""
    bits: int = balls.bits
    return 5 * bits // 24


def _reference_bits(case: GyroCase) -> int:
    # Balls of turning axes grow by a factor of about exp(3) for each radian of the Schuler oscillation.
    turned = float(case.duration) * sqrt(float(case.gravity) / float(case.radius))
    return WORKING_BITS + ceil(3 * turned / log(2))


def with_verticals(ar: Arithmetic, axes: Sequence[Number]) -> list[Number]:
    """Return the 18 columns of the table ``reference`` from the four axes."""
    pairs = (axes[:6], axes[6:])
    return [x for pair in pairs for x in (*pair, *bisector(ar, pair[:3], pair[3:]))]


def _start_row(case: GyroCase, ar: Arithmetic, epoch: int) -> list[Number]:
    """Return row 0 of ``reference``, in which exact zeros can be told."""
    begin = start(ar, case.model)
    return [
        *begin.paper,
        *begin.vertical,
        *begin.equilibrium,
        *bisector(ar, begin.equilibrium[:3], begin.equilibrium[3:]),
    ]


def _proved(
    case: GyroCase,
    rows: _Rows,
    bits: int,
    first: int,
    count: int,
    tally: RoundingTally,
    start_row: Callable[[Arithmetic, int], Sequence[Number]] | None = None,
) -> Iterator[Block]:
    """Yield blocks of rows, in more bits until the balls decide; of row 0 there may be a closed form."""
    epochs = np.arange(first, first + count)
    time, time_lo = pairs_at(lambda ar, k: [ar.number(case.interval) * k], epochs.tolist(), bits, tally)
    high = low = decided = np.empty(0)
    for factor in ESCALATION:
        with BallArithmetic(bits * factor) as balls:
            made = rows(balls, 2.0 ** -min(bits * factor - _GUARD_BITS, 1060))
            halves = list(_rounded(made, count))
        found = [np.concatenate(half) for half in zip(*halves, strict=True)]
        if factor == ESCALATION[0]:
            high, low, decided = found[:3]
            tally.values += high.size
            tally.raised += int((decided == 0).sum())
            if first == 0 and start_row is not None:
                high[:1], low[:1] = pairs_at(start_row, [0], bits, RoundingTally())
                decided[:1] = 1
        else:
            news = (decided == 0) & (found[2] != 0)
            high, low = np.where(news, found[0], high), np.where(news, found[1], low)
            decided = np.where(news, found[2], decided)
        if decided.all():
            break
    tally.exact_zeros += int(((high == 0) & (decided != 0)).sum())
    if not decided.all():
        # What is smaller than any input could make it is a sum of terms that cancel exactly.
        tiny = (decided == 0) & (found[3] < TINY)
        high, low, decided = np.where(tiny, 0.0, high), np.where(tiny, 0.0, low), decided + tiny
        tally.bounded_zeros += int(tiny.sum())
        if not decided.all():
            row, column = np.argwhere(decided == 0)[0]
            raise UndecidedError(f"case {case.name}, epoch {epochs[row]}, column {column}: not decided")
    for begin in range(0, count, BLOCK):
        part = slice(begin, begin + BLOCK)
        yield Block(epochs[part], time[part, 0], time_lo[part, 0], high[part], low[part])


def _rounded(rows: Iterator[Sequence[Number]], count: int) -> Iterator[tuple[_Array, ...]]:
    """Yield pairs, whether they are decided, and bounds of the magnitudes of what is not, block by block."""
    while count > 0:
        values = list(islice(rows, min(count, BLOCK)))
        count -= len(values)
        high, low, decided = round_balls([x for row in values for x in row])
        bound = np.zeros(len(high))
        for place in np.flatnonzero(~decided):
            row, column = divmod(int(place), len(values[0]))
            bound[place] = float(values[row][column].abs_upper())
        yield tuple(half.reshape(len(values), -1) for half in (high, low, decided.astype(float), bound))


@dataclass(frozen=True)
class GyroMotion:
    """Sensors and truth of a case at the epochs k h, k = 0 ... n; each ``x`` with the rest ``x_lo``.

    Attributes
    ----------
    case_name : str
    interval : float
        h, s.
    time : ndarray, shape (n+1,)
        s.
    rate, specific_force : ndarray, shape (n+1, 3)
        In vehicle axes (right, forward, up), rad/s and m/s^2.
    angle_increment, velocity_increment : ndarray, shape (n, 3)
        Their integrals over the samples, rad and m/s.
    latitude, longitude_absolute, longitude : ndarray, shape (n+1,)
        Geocentric, in X, and relative to the Earth, rad.
    radius, radius_rate, speed : ndarray, shape (n+1,)
        Distance from the centre, m, its rate, and the horizontal absolute speed, m/s.
    velocity, vertical : ndarray, shape (n+1, 3)
        Absolute velocity, m/s, and unit vertical in the axes X.
    heading, pitch, roll : ndarray, shape (n+1,)
        rad.
    attitude, trihedron : ndarray, shape (n+1, 4)
        Quaternions from vehicle axes, and from the Darboux trihedron, to X.
    """

    case_name: str
    interval: float
    time: _Array
    time_lo: _Array
    rate: _Array
    rate_lo: _Array
    specific_force: _Array
    specific_force_lo: _Array
    angle_increment: _Array
    angle_increment_lo: _Array
    velocity_increment: _Array
    velocity_increment_lo: _Array
    latitude: _Array
    latitude_lo: _Array
    longitude_absolute: _Array
    longitude_absolute_lo: _Array
    longitude: _Array
    longitude_lo: _Array
    radius: _Array
    radius_lo: _Array
    radius_rate: _Array
    radius_rate_lo: _Array
    speed: _Array
    speed_lo: _Array
    velocity: _Array
    velocity_lo: _Array
    vertical: _Array
    vertical_lo: _Array
    heading: _Array
    heading_lo: _Array
    pitch: _Array
    pitch_lo: _Array
    roll: _Array
    roll_lo: _Array
    attitude: _Array
    attitude_lo: _Array
    trihedron: _Array
    trihedron_lo: _Array


#: Name and width of what the columns of the tables hold.
_SENSOR_PARTS = (("rate", 3), ("specific_force", 3), ("angle_increment", 3), ("velocity_increment", 3))
_TRUTH_PARTS = (
    *((name, 1) for name in ("latitude", "longitude_absolute", "longitude", "radius", "radius_rate", "speed")),
    ("velocity", 3),
    ("vertical", 3),
    *((name, 1) for name in ("heading", "pitch", "roll")),
    ("attitude", 4),
    ("trihedron", 4),
)


def sampled(case: GyroCase, factor: Fraction | int = 1) -> GyroMotion:
    """Return sensors and truth of a case as arrays.

    Parameters
    ----------
    case : GyroCase
    factor : Fraction or int, default 1
        The sampling interval in units of the case's; 1/2 gives the half grid that a Runge-Kutta method needs.

    Raises
    ------
    CaseError
        If the duration is not a whole number of the intervals asked for.
    """
    interval = _scaled(case.interval, Fraction(factor))
    count = whole_intervals(case.duration, interval)
    if count is None:
        raise CaseError("interval", interval, f"does not divide {case.duration.text} s into whole samples")
    resampled, tally = replace(case, interval=interval), RoundingTally()
    sensors = list(sensor_blocks(resampled, 0, count + 1, tally))
    truth = list(truth_blocks(resampled, 0, count + 1, tally))
    arrays = {
        "time": np.concatenate([block.time for block in truth]),
        "time_lo": np.concatenate([block.time_lo for block in truth]),
        **_named(sensors, _SENSOR_PARTS),
        **_named(truth, _TRUTH_PARTS),
    }
    for name in ("angle_increment", "velocity_increment"):
        for suffix in ("", "_lo"):
            arrays[name + suffix] = arrays[name + suffix][1:]
    return GyroMotion(case.name, float(interval), **arrays)


def _scaled(number: ExactNumber, factor: Fraction) -> ExactNumber:
    return number if factor == 1 else ExactNumber(f"({number.text})*{factor.numerator}/{factor.denominator}")


def _named(blocks: Sequence[Block], parts: Sequence[tuple[str, int]]) -> dict[str, _Array]:
    named: dict[str, _Array] = {}
    for suffix, half in (("", "high"), ("_lo", "low")):
        columns = np.concatenate([getattr(block, half) for block in blocks])
        place = 0
        for name, width in parts:
            part = columns[:, place : place + width]
            named[name + suffix] = np.ascontiguousarray(part if width > 1 else part[:, 0])
            place += width
    return named
