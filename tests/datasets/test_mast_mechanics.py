"""Formulas of the antenna on a mast: frames, specific forces against inertial positions, satellites."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from sinsdata.cases import MastCase
from sinsdata.truth.mast_recomputed import ExactMast, ExactRow
from sinsref.arithmetic import MpArithmetic, Number
from sinsref.mast import from_level, level_quaternion, range_and_rate, receiver_position, resolved
from sinsref.quaternion import conjugate, dot, normalised, product, rotate
from sinsref.series import SeriesArithmetic

_AR = MpArithmetic(40)
_BASE = {"name": "short", "duration": "1", "interval": "0.01"}
#: The paper's motion, one that turns and climbs and goes east on a long mast that stands aslant, and one south of the
#: equator.
_MOTIONS: dict[str, dict[str, Any]] = {
    "paper": {},
    "all": {
        "latitude": "1", "velocity_east": "300 + 20*sin(t)", "velocity_up": "5 + 3*cos(2*t)",
        "angular_rate": ["0.3 + 0.1*sin(5*t)", "0.2*t", "-0.4"], "mast_rate": ["0.7*sin(3*t + 1)", "0.2 + 0.3*t"],
        "mast_length": "25", "vehicle_rotation": ["0.5", "-1", "2"], "mast_rotation": ["0.7", "0.4", "0"],
    },
    "south": {"latitude": "-0.2", "velocity_east": "-200", "velocity_north": "-50*cos(0.3*t)", "gravity": "9.7",
              "satellites": [["pi/6", "0"], ["0", "pi/6"], ["pi/3", "-pi/6"], ["pi/5", "pi/18"]]},
}  # fmt: skip


@cache
def _row(name: str, half_steps: int = 60) -> ExactRow:
    exact = ExactMast(MastCase.from_mapping({**_BASE, **_MOTIONS[name]}), 40)
    (row,) = exact.rows([half_steps])
    # The second path is good to 1e-17; of unit length to the last digit, it is a state as good as any.
    unit = [normalised(_AR, q) for q in (row.state[:4], row.state[4:8], row.eta)]
    return replace(row, state=[*unit[0], *unit[1], *row.state[8:]], eta=unit[2])


def _matrix(q: list[Number]) -> list[list[Number]]:
    """Return D(q) as its nine elements are written."""
    a, b, c, d = q
    return [
        [2 * a * a + 2 * b * b - 1, 2 * (b * c + a * d), 2 * (b * d - a * c)],
        [2 * (b * c - a * d), 2 * a * a + 2 * c * c - 1, 2 * (c * d + a * b)],
        [2 * (b * d + a * c), 2 * (c * d - a * b), 2 * a * a + 2 * d * d - 1],
    ]


def _apply(matrix: list[list[Number]], vector: list[Number]) -> list[Number]:
    return [dot(row, vector) for row in matrix]


def _close(found: list[Number], wanted: list[Number], within: float) -> bool:
    return all(abs(x - y) < within for x, y in zip(found, wanted, strict=True))


def test_attitudes_are_matrices_to_the_rotated_frame() -> None:
    q = [_AR.number(x) for x in ("0.1", "0.5", "0.7", "0.5")]
    vector = [_AR.number(x) for x in (1, -2, 3)]
    assert _close(resolved(q, vector), _apply(_matrix(q), vector), 1e-35)


def test_level_frame() -> None:
    """East, north and up by the matrix of sines and cosines, by the quaternion, and transposed."""
    longitude, latitude = _AR.number("0.7"), _AR.number("-1.1")
    (sl, cl), (sb, cb) = _AR.sin_cos(longitude), _AR.sin_cos(latitude)
    matrix = [[cl, 0, -sl], [-sl * sb, cb, -cl * sb], [sl * cb, sb, cl * cb]]
    vector = [_AR.number(x) for x in (2, 5, -3)]
    level = _apply(matrix, vector)
    assert _close(resolved(level_quaternion(_AR, longitude, latitude), vector), level, 1e-35)
    assert _close(from_level((sl, cl), (sb, cb), level), vector, 1e-35)


def test_the_start_of_the_paper() -> None:
    """J1 level: mu of 30 degrees of longitude and 45 of latitude, eta of a small rotation vector."""
    exact = ExactMast(MastCase.from_mapping(_BASE), 40)
    wanted = (0.892399100833, -0.369643810614, 0.239117618394, 0.099045760541)
    assert [float(x) for x in exact.start()[:4]] == pytest.approx(wanted, abs=5e-13)
    assert [float(x) for x in exact.start()[4:8]] == [1, 0, 0, 0]


@pytest.mark.parametrize("name", _MOTIONS)
def test_specific_forces_are_second_derivatives_of_inertial_positions(name: str) -> None:
    """Positions of vehicle and mast's top as power series of time: their acceleration less the attraction."""
    row = _row(name)
    exact = row.exact
    series = SeriesArithmetic(exact.ar)
    time = series.variable(row.time)
    unknowns = [series.unknown(x) for x in row.state]
    for unknown, rate in zip(unknowns, exact.field(series, time, unknowns), strict=True):
        series.define(unknown, rate)
    mu, lam, (longitude, latitude, height) = unknowns[:4], unknowns[4:8], unknowns[8:]
    (sl, cl), (sb, cb) = (
        series.sin_cos(x) for x in (longitude + time * exact.constants.rotation_rate, latitude)
    )  # fmt: skip
    distance = height + exact.constants.radius
    up = [cb * sl, sb, cb * cl]
    vehicle = [x * distance for x in up]
    zero = time * 0
    mast = rotate(mu, rotate(lam, [zero, zero, zero + exact.constants.mast_length]))
    top = [x + y for x, y in zip(vehicle, mast, strict=True)]
    gravity = [x[0] * exact.constants.gravity for x in up]
    readings = row.readings(0)
    for place, attitude, found in (
        (vehicle, row.state[:4], readings[3:6]),
        (top, product(product(row.state[:4], row.state[4:8]), row.eta), readings[9:12]),
    ):
        force = [2 * x[2] + g for x, g in zip(place, gravity, strict=True)]
        # 40 digits, less seven of the Earth's radius.
        assert _close(found, resolved(attitude, force), 1e-28)


@pytest.mark.parametrize("name", _MOTIONS)
def test_rates_are_those_of_the_attitudes(name: str) -> None:
    """The rate of J2 in J2 is that of chi = mu o nu: 2 conj(chi) o chi', the antenna held."""
    row = _row(name)
    exact = row.exact
    series = SeriesArithmetic(exact.ar)
    unknowns = [series.unknown(x) for x in row.state]
    for unknown, rate in zip(unknowns, exact.field(series, series.variable(row.time), unknowns), strict=True):
        series.define(unknown, rate)
    chi = product(product(unknowns[:4], unknowns[4:8]), [series.constant(x) for x in row.eta])
    rate = [2 * x for x in product(conjugate([x[0] for x in chi]), [x[1] for x in chi])]
    own = exact.antenna_rate(30)
    found = [x - y for x, y in zip(row.readings(30)[6:9], own, strict=True)]
    assert abs(rate[0]) < 1e-30
    assert _close(found, rate[1:], 1e-30)


@pytest.mark.parametrize("name", _MOTIONS)
def test_range_rates_are_derivatives_of_ranges(name: str) -> None:
    """Distances of the satellites from the vehicle as power series of time, and their speeds from their places."""
    row = _row(name)
    exact = row.exact
    series = SeriesArithmetic(exact.ar)
    time = series.variable(row.time)
    unknowns = [series.unknown(x) for x in row.state]
    for unknown, rate in zip(unknowns, exact.field(series, time, unknowns), strict=True):
        series.define(unknown, rate)
    place = receiver_position(
        exact.constants, series.sin_cos(unknowns[8]), series.sin_cos(unknowns[9]), unknowns[10]
    )  # fmt: skip
    for pair, values in zip(exact.case.satellites, row.satellites(), strict=True):
        node, argument = (exact.ar.number(x) for x in pair)
        angles = time * -exact.constants.rotation_rate + node, time * exact.orbit.motion + argument
        position, velocity = exact.orbit.place(*(series.sin_cos(angle) for angle in angles))
        assert _close(values[:3], [x[0] for x in position], 1e-25)
        assert _close(values[3:6], [x[1] for x in position], 1e-25)
        still = [time * 0] * 3
        distance, _ = range_and_rate(series.sqrt, place, still, position, velocity)
        assert _close(values[6:], [distance[1], distance[0]], 1e-25)


def test_satellites_fall_freely() -> None:
    """Acceleration of the position in inertial axes: GM/a^2 towards the centre."""
    series = SeriesArithmetic(_AR)
    exact = ExactMast(MastCase.from_mapping(_BASE), 40)
    orbit = exact.orbit
    time = series.variable(_AR.number(100))
    node, argument = _AR.number(1), time * orbit.motion + 2
    position, _ = orbit.place(series.sin_cos(series.constant(node)), series.sin_cos(argument))
    for x in position:
        assert abs(2 * x[2] + x[0] * orbit.motion**2) < 1e-25
    assert float(dot([x[0] for x in position], [x[0] for x in position])) == pytest.approx(26560000.0**2, rel=1e-15)
