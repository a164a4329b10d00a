"""Relations between the tables of `mast_antenna`: rigid-body kinematics, orbits, measurements.

Values have no rests, so each relation states what the accuracy of its columns may do to it.

Source: Sokolov, Pogorelov, Reshetnikova 2024, eq. (3.6), (3.9)-(3.17), corrected: `sinsref.mast`.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases import MastCase
from sinsdata.format.mast_columns import SATELLITES
from sinsdata.truth.mast_blocks import constants_of, start_attitudes
from sinsdata.verification.double_double import DoubleDouble, nearest
from sinsdata.verification.residuals import CACHED_CASES, DIGITS, Invariant, Residual, Residuals
from sinsdata.verification.stored_rows import Places, Window
from sinsref.arithmetic import MpArithmetic
from sinsref.mast import ORBIT_RADIUS, Constants, from_level, range_and_rate, receiver_position, resolved
from sinsref.mast_running import small_rotation
from sinsref.quaternion import Quaternion, Vector, conjugate, cross, dot, product

Floats = NDArray[np.float64]

#: What a few roundings, and the accuracy of a few columns, do relative to the largest term.
_FEW = 2e-14
_QUATERNIONS = ("mu", "lambda", "eta", "nu")


def _residual(places: Places, value: Floats, allowed: Floats | float) -> Residual:
    zeros = np.zeros_like(value)
    return Residual(places, DoubleDouble(value, zeros), zeros + allowed)


def _columns(window: Window, table: str, stem: str, components: str = "xyz") -> list[Floats]:
    return [column.high for column in window.vector(table, stem, components)]


def _quaternion(window: Window, name: str) -> list[Floats]:
    return _columns(window, "truth", name, "wxyz")


def _size(vector: Vector) -> Floats:
    size: Floats = np.sqrt(dot(vector, vector))
    return size


def _take(vector: Vector, rows: NDArray[np.int64]) -> list[Floats]:
    return [x[rows] for x in vector]


def _unit_quaternions(window: Window) -> Residuals:
    for name in _QUATERNIONS:
        quaternion = _quaternion(window, name)
        yield _residual(window.epochs, dot(quaternion, quaternion) - 1, _FEW)


def _composition(window: Window) -> Residuals:
    """Compare nu with lambda o eta."""
    mu_lam = product(_quaternion(window, "lambda"), _quaternion(window, "eta"))
    for x, y in zip(mu_lam, _quaternion(window, "nu"), strict=True):
        yield _residual(window.epochs, x - y, _FEW)


def _starts(window: Window) -> Residuals:
    """Compare the first row with the case."""
    rows = window.starts
    places = window.epochs[rows]
    names = [f"{name}_{c}" for name in ("mu", "eta", "lambda") for c in "wxyz"]
    stored = [window.column("truth", name).high[rows] for name in (*names, "longitude", "latitude", "height")]
    for x, y in zip(stored, window.constants(_start, places), strict=True):
        yield _residual(places, x - y.high, np.maximum(_FEW / 10, 4e-16 * np.abs(y.high)))


@lru_cache(CACHED_CASES)
def _start(case: MastCase) -> DoubleDouble:
    ar = MpArithmetic(DIGITS)
    attitudes = [x for attitude in start_attitudes(ar, case) for x in attitude]
    return nearest([*attitudes, *(ar.number(x) for x in (case.longitude, case.latitude, case.height))])


def _continuity(window: Window) -> Residuals:
    """Compare readings that do not jump with those at the end of the step before: the same numbers."""
    stretch = window.samples.stretch
    later = np.flatnonzero(stretch[1:] == stretch[:-1]) + 1
    places = window.samples[later]
    for name in ("angular_rate1", "specific_force1", "specific_force2"):
        ends, starts = _columns(window, "sensors", f"end_{name}"), _columns(window, "sensors", f"start_{name}")
        for end, start in zip(ends, starts, strict=True):
            yield _residual(places, end[later - 1] - start[later], 0.0)


def _mast_rate(window: Window, rows: NDArray[np.int64], node: str) -> list[Floats]:
    """Return the absolute rate of Q at samples: its third component is that of the vehicle's."""
    carried = resolved(_take(_quaternion(window, "lambda"), rows), _columns(window, "sensors", f"{node}_angular_rate1"))
    return [*(window.column("truth", f"mast_absolute_rate_{c}").high[rows] for c in "xy"), carried[2]]


def _along_the_mast(window: Window) -> Residuals:
    """Check the algebraic equation along the mast, (E^T f2 - L f1)_Z = -R (w_X^2 + w_Y^2)."""
    (length,) = (x.high for x in window.constants(_length, window.samples))
    for node, rows in (("start", window.before), ("end", window.after)):
        lam, eta = (_take(_quaternion(window, name), rows) for name in ("lambda", "eta"))
        force_1, force_2 = (_columns(window, "sensors", f"{node}_specific_force{n}") for n in "12")
        rate = _mast_rate(window, rows, node)
        value = resolved(conjugate(eta), force_2)[2] - resolved(lam, force_1)[2]
        turning = length * (rate[0] * rate[0] + rate[1] * rate[1])
        allowed = 1e-12 + _FEW * (_size(force_1) + _size(force_2) + turning)
        yield _residual(window.samples, value + turning, allowed)


@lru_cache(CACHED_CASES)
def _length(case: MastCase) -> DoubleDouble:
    return nearest([MpArithmetic(DIGITS).number(case.mast_length)])


def _antenna(window: Window) -> Residuals:
    """Check that gyro 2 less the mast's rate is the same at both ends of a step, and turns eta."""
    own = {}
    for node, rows in (("start", window.before), ("end", window.after)):
        eta, rate = _take(_quaternion(window, "eta"), rows), _mast_rate(window, rows, node)
        reading = _columns(window, "sensors", f"{node}_angular_rate2")
        carried = resolved(eta, rate)
        own[node] = eta, [x - y for x, y in zip(reading, carried, strict=True)], _size(rate)
    (before, rate, size), (after, other, _) = own["start"], own["end"]
    (interval,) = (x.high for x in window.constants(_interval, window.samples))
    for x, y in zip(rate, other, strict=True):
        yield _residual(window.samples, x - y, _FEW * (1 + size))
    turned = product(conjugate(before), after)
    step = small_rotation([x * interval for x in rate])
    for x, y, whole in zip(turned, step, (1.0, 0.0, 0.0, 0.0), strict=True):
        yield _residual(window.samples, x - whole - y, _FEW)


@lru_cache(CACHED_CASES)
def _interval(case: MastCase) -> DoubleDouble:
    return nearest([MpArithmetic(DIGITS).number(case.interval)])


def _vehicle_turns(window: Window) -> Residuals:
    """Compare the turn of mu in a step with Simpson's rule and the first term of coning."""
    rates = [_columns(window, "sensors", f"{node}_angular_rate1") for node in ("start", "middle", "end")]
    mu = _quaternion(window, "mu")
    step, quickest = (x.high for x in window.constants(_pace, window.samples))
    yield from _turned(window.samples, _take(mu, window.before), _take(mu, window.after), rates, step, quickest)


def _mast_turns(window: Window) -> Residuals:
    """Compare the turn of mu o lambda in two steps with Simpson's rule, by the mast's absolute rates."""
    lam = _quaternion(window, "lambda")
    chi = product(_quaternion(window, "mu"), lam)
    stretch = window.samples.stretch
    second = np.flatnonzero(stretch[1:] == stretch[:-1]) + 1
    first = second - 1
    begins, middles = _mast_rate(window, window.before, "start"), _mast_rate(window, window.after, "end")
    rates = [_take(begins, first), _take(middles, first), _take(middles, second)]
    places = window.samples[second]
    step, quickest = (x.high for x in window.constants(_pace, places))
    yield from _turned(
        places, _take(chi, window.before[first]), _take(chi, window.after[second]), rates, 2 * step, quickest
    )


@lru_cache(CACHED_CASES)
def _pace(case: MastCase) -> DoubleDouble:
    """Return the interval, s, and a bound of the rates at which attitudes and their rates turn, rad/s."""
    pace = 0.035 * case.parts / float(case.interval)
    return DoubleDouble(np.array([float(case.interval), pace]), np.zeros(2))


def _turned(
    places: Places, before: Quaternion, after: Quaternion, rates: list[list[Floats]], step: Floats, quickest: Floats
) -> Residuals:
    first, middle, last = rates
    coning = cross(first, last)
    rotation = [
        step / 6 * (x + 4 * y + z) + step * step / 12 * c
        for x, y, z, c in zip(first, middle, last, coning, strict=True)
    ]
    # The error of fifth order, with the bound of rates that the case has; at most a hundredth of it in practice.
    phase = step * quickest
    allowed = _FEW + phase**5 / 500
    expected = small_rotation(rotation)
    for x, y, whole in zip(product(conjugate(before), after), expected, (1.0, 0.0, 0.0, 0.0), strict=True):
        yield _residual(places, x - whole - y, allowed)


def _orbits(window: Window) -> Residuals:
    """Check that the satellites stay on their sphere, and move along it."""
    radius = float(ORBIT_RADIUS)
    for n in SATELLITES:
        place, speed = (_columns(window, "satellites", f"satellite{n}{suffix}") for suffix in ("", "_velocity"))
        yield _residual(window.epochs, _size(place) - radius, 2e-15 * radius)
        yield _residual(window.epochs, dot(place, speed), 2e-15 * radius * _size(speed))


def _ranges(window: Window) -> Residuals:
    """Compare range and range rate with the distance from the vehicle, eq. (3.16) and (3.17)."""
    constants = constants_of_cases(window)
    longitude, latitude, height = (window.column("truth", name).high for name in ("longitude", "latitude", "height"))
    velocity = [window.column("truth", f"v_{name}").high for name in ("east", "north", "up")]
    angles = [(np.sin(x), np.cos(x)) for x in (longitude, latitude)]
    place = receiver_position(constants, angles[0], angles[1], height)
    speed = from_level(angles[0], angles[1], velocity)
    for n in SATELLITES:
        satellite = [_columns(window, "satellites", f"satellite{n}{suffix}") for suffix in ("", "_velocity")]
        distance, rate = range_and_rate(np.sqrt, place, speed, *satellite)
        stored = [window.column("satellites", f"{name}{n}").high for name in ("range", "range_rate")]
        yield _residual(window.epochs, distance - stored[0], 2e-15 * float(ORBIT_RADIUS) * 4)
        yield _residual(window.epochs, rate - stored[1], 3e-11 + 1e-14 * _size(speed))


def constants_of_cases(window: Window) -> Constants:
    """Return the constants of the cases beside the epochs of a window."""
    return Constants(*(x.high for x in window.constants(_constants, window.epochs)))


@lru_cache(CACHED_CASES)
def _constants(case: MastCase) -> DoubleDouble:
    return nearest(list(vars(constants_of(MpArithmetic(DIGITS), case)).values()))


INVARIANTS = (
    Invariant(("truth",), "unit quaternions", _unit_quaternions),
    Invariant(("truth",), "attitude of the antenna composed of two", _composition),
    Invariant(("truth",), "start of the motion", _starts),
    Invariant(("sensors",), "readings without jumps", _continuity),
    Invariant(("sensors", "truth"), "specific forces along the mast", _along_the_mast),
    Invariant(("sensors", "truth"), "rate of the antenna in a step", _antenna),
    Invariant(("sensors", "truth"), "turns of the vehicle", _vehicle_turns),
    Invariant(("sensors", "truth"), "turns of the mast", _mast_turns),
    Invariant(("satellites",), "circular orbits", _orbits),
    Invariant(("satellites", "truth"), "ranges and range rates", _ranges),
)
"""Relations between tables with a row per epoch or step."""
