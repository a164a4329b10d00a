"""The dataset `mast_antenna`: check values, differential equations, second path, noise, arrays, files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from flint import arb
from numpy.typing import NDArray

from sinsdata.cases import MastCase
from sinsdata.format.mast_columns import ATTITUDE_ACCURACY
from sinsdata.generation.generate import generate
from sinsdata.generation.tables import GROUPS, Segment
from sinsdata.truth import mast_blocks as blocks_of_rows
from sinsdata.truth.mast import SENSORS, MastMotion, sampled, start_estimate
from sinsdata.truth.mast_blocks import GridModel, mast_blocks
from sinsdata.verification.recompute import computed_columns, largest_errors
from sinsdata.verification.verify import verify
from sinsref.arithmetic import BallArithmetic
from sinsref.exact import ExactNumber
from sinsref.mast import exponential
from sinsref.mast_random import Stream, normals
from sinsref.quaternion import product
from sinsref.rounding import RoundingTally

Array = NDArray[np.float64]
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
_PAPER = MastCase.from_mapping({"name": "N4_G1", "duration": "1000", "interval": "0.01"})


def case(**given: Any) -> MastCase:
    return MastCase.from_mapping({"name": "mine", "duration": "0.4", "interval": "0.01", **given})


@pytest.fixture(scope="module")
def paper() -> MastMotion:
    """The paper's 1000 s."""
    return sampled(_PAPER)


def test_check_values_at_the_start(paper: MastMotion) -> None:
    near = 6e-13
    assert paper.specific_force1[0] == pytest.approx([-0.010157918812, 0.036962429660, 9.791491502946], abs=near)
    assert paper.specific_force2[0] == pytest.approx([0.228397847689, 0.314175612945, 7.925138769713], abs=near)
    assert paper.mast_rate[0].tolist() == [0.53, 0.301]
    carried = paper.rate2_right[0] - paper.antenna_rate[0]
    assert carried == pytest.approx([0.541722884248, 0.279718908502, -0.004432708935], abs=near)
    assert paper.range_rate[0, 0] == pytest.approx(87.77324125363, abs=6e-12)
    assert paper.range[0, 0] == pytest.approx(20327374.2785, abs=6e-5)


def test_check_values_at_the_end(paper: MastMotion) -> None:
    """To twelve digits; readings to 2e-11: what an error of 1e-12 rad of mu does, on which these were computed."""
    for found, wanted in (
        (paper.mu, (0.893702533854, -0.366247044509, 0.239629600625, 0.098673896628)),
        (paper.lam, (0.997134401394, -0.039471777278, -0.052438982642, -0.037618046934)),
        (paper.eta, (0.999695599245, 0.024140198363, -0.003736588843, -0.003463751957)),
    ):
        assert found[-1] == pytest.approx(wanted, abs=1e-12)
    assert paper.latitude[-1] == pytest.approx(0.801098924468622, abs=5e-16)
    assert paper.longitude[-1] == paper.longitude[0]
    assert paper.height[-1] == pytest.approx(3 + 1.5 * np.sin(1000), abs=1e-15)
    assert paper.specific_force1[-1] == pytest.approx([0.422954958898, 0.231898010846, 8.538104101230], abs=2e-11)
    assert paper.specific_force2[-1] == pytest.approx([5.450483502599, -1.863042187219, 8.046745171584], abs=2e-11)
    assert paper.range_rate[-1, 0] == pytest.approx(172.5772880753, abs=6e-11)
    assert paper.range[-1, 0] == pytest.approx(20459181.5168, abs=6e-5)


def test_attitudes_after_1000_seconds_are_those_of_a_series_in_160_bits(paper: MastMotion) -> None:
    """Taylor series of order 38 in balls, steps of 0.25 and 0.5 s; recorded, because it takes a minute."""
    mu = "0.89370253385401187072 -0.36624704450895737815 0.23962960062479896635 0.09867389662809463692"
    lam = "0.99713440139375110880 -0.03947177727823668910 -0.05243898264190554575 -0.03761804693368401748"
    for text, found in ((mu, paper.mu), (lam, paper.lam)):
        for digits, value in zip(text.split(), found[-1].tolist(), strict=True):
            assert abs(Fraction(digits) - Fraction(value)) < ATTITUDE_ACCURACY / 5


def test_the_antenna_is_turned_by_all_its_steps(paper: MastMotion) -> None:
    """eta as the product of 100,000 exponentials in 160 bits."""
    with BallArithmetic(160) as balls:
        h = balls.number("0.01")
        eta = exponential(balls, [balls.number(x) for x in ("0.03", "-0.02", "0.04")])
        for rate in paper.antenna_rate.tolist():
            turn = [arb(x) * h for x in rate]
            angle = sum((x * x for x in turn), arb(0)).sqrt()
            sine, cosine = (angle / 2).sin_cos()
            eta = [arb(x.mid()) for x in product(eta, [cosine, *(x * sine / angle for x in turn)])]
        errors = [abs(float(x - arb(y))) for x, y in zip(eta, paper.eta[-1].tolist(), strict=True)]
    assert max(errors) < ATTITUDE_ACCURACY / 5


def test_latitude_is_the_series_in_heights_over_the_radius(paper: MastMotion) -> None:
    """lat0 + I0/r0 - I1/r0^2 + I2/r0^3: the integral of V_Y/r by hand."""
    t, q, radius = paper.time[::1000], 0.02, 6371003.0
    first = 100 * t + (1 - np.cos(q * t)) / q
    second = 150 * (1 - np.cos(t)) + 0.75 * (np.sin((1 - q) * t) / (1 - q) - np.sin((1 + q) * t) / (1 + q))
    latitude = np.pi / 4 + first / radius - second / radius**2
    # The next term is 225 t/2 over the cube of the radius, 4e-16; four roundings of 1e-16.
    assert np.abs(paper.latitude[::1000] - latitude).max() < 9e-16


def test_doubled_steps_of_the_integration_change_nothing() -> None:
    """Twice and four times as many parts of half an interval, 100 s: attitudes within the accuracy that is stated."""
    short = replace(_PAPER, duration=ExactNumber("100"))
    ends = []
    for factor in (1, 2, 4):
        *_, block = mast_blocks(GridModel(short, factor * short.parts), 2 * short.samples)
        ends.append(np.array([*block.mu, *block.lam, *block.latitude[:1]]))
    for other in ends[1:]:
        assert np.abs(other - ends[0]).max() < ATTITUDE_ACCURACY


def _product(a: Array, b: Array) -> Array:
    (a0, a1, a2, a3), (b0, b1, b2, b3) = a.T, b.T
    return np.array(
        [
            a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
            a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
            a0 * b2 + a2 * b0 + a3 * b1 - a1 * b3,
            a0 * b3 + a3 * b0 + a1 * b2 - a2 * b1,
        ]
    ).T


def _resolved(q: Array, v: Array) -> Array:
    pure = np.concatenate([np.zeros((len(v), 1)), v], axis=1)
    return _product(_product(q * _CONJUGATE, pure), q)[:, 1:]


def _slope(values: Array, step: float) -> Array:
    """Return derivatives by differences of eighth order, of all but four rows at each end."""
    n = len(values) - 8
    slopes: Array = sum(
        weight * (values[4 + k : 4 + k + n] - values[4 - k : 4 - k + n])
        for k, weight in ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
    ) / step  # fmt: skip
    return slopes


#: Parts of the state in `_state` and `_field`.
_PARTS = {
    "mu": slice(0, 4), "lambda": slice(4, 8), "longitude": slice(8, 9), "latitude": slice(9, 10),
    "height": slice(10, 11), "velocity": slice(11, 14), "mast_rate": slice(14, 16),
}  # fmt: skip


def _state(motion: MastMotion) -> Array:
    angles = [x[:, None] for x in (motion.longitude, motion.latitude, motion.height)]
    return np.concatenate([motion.mu, motion.lam, *angles, motion.velocity, motion.mast_rate], axis=1)


def _field(motion: MastMotion, state: Array, rows: Any) -> Array:
    """Return the derivatives of states, from the readings without noise and eta at rows of the half grid."""
    mu, lam, longitude, latitude, height, velocity, rate = (state[:, part] for part in _PARTS.values())
    rate1, force1, force2 = (getattr(motion, name)[rows] for name in ("rate1", "specific_force1", "specific_force2"))
    u, zeros, distance = _resolved(lam, rate1), 0 * height, motion.radius + height
    own = np.concatenate([rate - u[:, :2], zeros], axis=1)
    sine, cosine, east = np.sin(latitude), np.cos(latitude), velocity[:, :1] / distance
    turning = [-velocity[:, 1:2] / distance, 2 * motion.rotation_rate * cosine + east]
    turning.append(2 * motion.rotation_rate * sine + east * sine / cosine)
    swing = motion.rotation_rate**2 * distance * cosine
    gravity = np.concatenate([zeros, -swing * sine, swing * cosine - motion.gravity], axis=1)
    half = (longitude + motion.rotation_rate * motion.time[rows, None]) / 2
    level = _product(
        np.concatenate([np.cos(half), zeros, np.sin(half), zeros], axis=1),
        np.concatenate([np.cos(latitude / 2), -np.sin(latitude / 2), zeros, zeros], axis=1),
    )
    # S to J1: C = D(mu) B^T, so that C^T f1 turns back.
    force = _resolved(_product(mu * _CONJUGATE, level), force1)
    delta = _resolved(motion.eta[rows] * _CONJUGATE, force2) - _resolved(lam, force1)
    return np.concatenate(
        [
            _product(mu, np.concatenate([zeros, rate1], axis=1)) / 2,
            _product(lam, np.concatenate([zeros, own], axis=1)) / 2,
            east / cosine,
            velocity[:, 1:2] / distance,
            velocity[:, 2:],
            force - np.cross(np.concatenate(turning, axis=1), velocity) + gravity,
            np.stack([-delta[:, 1], delta[:, 0]], axis=1) / motion.mast_length
            + np.stack([rate[:, 1], -rate[:, 0]], axis=1) * u[:, 2:],
        ],
        axis=1,
    )


def test_the_differential_equations_hold_at_every_row() -> None:
    """|dY/dt - F(Y, t)| by differences of 0.001 s; their own rounding is 1e-16 of the state over 1e-3 s."""
    motion = sampled(case(duration="0.2", interval="0.002", velocity_east="20*sin(t)", mast_rotation=[0.3, -0.2, 0.1]))
    state = _state(motion)
    residual = np.abs(_slope(state, motion.interval / 2) - _field(motion, state, slice(None))[4:-4]).max(axis=0)
    limits = (1e-12, 1e-12, 1e-12, 1e-12, 5e-12, 1e-10, 2e-12)
    for (name, part), within in zip(_PARTS.items(), limits, strict=True):
        assert residual[part].max() < within, name


def test_a_runge_kutta_method_follows_the_truth() -> None:
    """Steps of 0.01 s from the exact start, without noise: the errors of the method, and what becomes of them.

    The mast's errors grow like exp(1.4 t); after 5 s they are some hundred times those after 1 s.
    """
    motion = sampled(case(duration="5"))
    state, h = _state(motion), motion.interval
    y = state[:1]
    found = {}
    for k in range(500):
        start, middle, end = ([2 * k + node] for node in range(3))
        k1 = _field(motion, y, start)
        k2 = _field(motion, y + h / 2 * k1, middle)
        k3 = _field(motion, y + h / 2 * k2, middle)
        k4 = _field(motion, y + h * k3, end)
        y = y + h / 6 * (k1 + 2 * (k2 + k3) + k4)
        if k in (99, 499):
            error = np.abs(y - state[end])[0]
            found[(k + 1) // 100] = {name: error[part].max() for name, part in _PARTS.items()}
    # What another program finds, to one digit and for some norm: within a factor of two.
    limits = {
        1: {"mu": 5e-12, "latitude": 1e-16, "velocity": 2e-10, "height": 1e-11, "lambda": 1.6e-10, "mast_rate": 6e-10},
        5: {"mu": 5e-12, "latitude": 2e-16, "velocity": 2e-10, "height": 2e-10, "lambda": 4e-8, "mast_rate": 1.2e-7},
    }
    for time, known in limits.items():
        for name, size in known.items():
            assert found[time][name] < 2 * size, (time, name)
    assert found[5]["lambda"] > 50 * found[1]["lambda"]


def test_the_mast_does_not_spin_and_the_equation_along_it_holds(paper: MastMotion) -> None:
    """Delta_Z = -R (w_X^2 + w_Y^2): algebraic, and nowhere used to make the data."""
    delta = _resolved(paper.eta * _CONJUGATE, paper.specific_force2) - _resolved(paper.lam, paper.specific_force1)
    turning = paper.mast_length * (paper.mast_rate**2).sum(axis=1)
    assert np.abs(delta[:, 2] + turning).max() < 5e-14


def test_readings_are_truth_and_noise(paper: MastMotion) -> None:
    readings, n = paper.readings(), paper.steps
    for sensor in SENSORS:
        noise = getattr(paper, f"{sensor}_noise")
        found = getattr(readings, sensor)
        assert found.shape == (n, 3, 3)
        before = getattr(paper, sensor if sensor != "rate2" else "rate2_right")
        after = getattr(paper, sensor if sensor != "rate2" else "rate2_left")
        for k in (0, 1, 54321, n - 1):
            for node, clean in enumerate((before[2 * k], before[2 * k + 1], after[2 * k + 2])):
                assert found[k, node].tolist() == (clean + noise[k]).tolist()
    assert readings.range[7, 2].tolist() == (paper.range[16] + paper.range_noise[7]).tolist()
    assert readings.range_rate_last.tolist() == (paper.range_rate[-1] + paper.range_rate_noise[-1]).tolist()
    assert np.array_equal(readings.satellite_position[9, 1], paper.satellite_position[19])


def test_gyro_2_jumps_at_the_ends_of_steps_alone(paper: MastMotion) -> None:
    jump = paper.rate2_right - paper.rate2_left
    assert not jump[1::2].any()
    assert np.abs(jump[2:-1:2] - np.diff(paper.antenna_rate, axis=0)).max() < 5e-16
    assert not jump[[0, -1]].any()


def test_noise_has_its_streams_and_deviations(paper: MastMotion) -> None:
    streams = (Stream.RATE_1, Stream.FORCE_1, Stream.RATE_2, Stream.FORCE_2)
    for sensor, stream, sd in zip(SENSORS, streams, (5e-8, 1e-4, 5e-8, 1e-4), strict=True):
        noise = getattr(paper, f"{sensor}_noise")
        assert noise[70:72].ravel().tolist() == (normals(20240001, stream, 210, 6) * sd).tolist()
        # Five standard deviations of a variance of 300,000 numbers.
        assert noise.std() == pytest.approx(sd, rel=5 / np.sqrt(2 * noise.size))
    of_satellites = normals(20240001, Stream.SATELLITES, 80, 8)
    assert paper.range_rate_noise[10].tolist() == (of_satellites[::2] * 0.1).tolist()
    assert paper.range_noise[10].tolist() == (of_satellites[1::2] * 5).tolist()


def test_a_fault_is_a_bias_from_its_time_on() -> None:
    for what in (*SENSORS, "range_rate", "range"):
        fault = {"fault": what, "fault_time": "0.2", "fault_size": 3}
        sound, broken = sampled(case()), sampled(case(**fault))
        for name in (*SENSORS, "range_rate", "range"):
            change = getattr(broken, f"{name}_noise") - getattr(sound, f"{name}_noise")
            wanted = np.zeros_like(change)
            if name == what:
                wanted[20:, 0] = 3
            assert np.abs(change - wanted).max() < 2e-15, (what, name)


def test_the_start_is_the_truth_with_errors(paper: MastMotion) -> None:
    """By the errors that it states; standard deviations of the initial errors, none about the mast."""
    start = paper.start
    angle, place = [0.01 / 3**0.5], 3 / 6371000
    assert start.sds == pytest.approx([*angle * 3, place * 2**0.5, place, *[0.05] * 3, 3, *angle * 5, 0, 0.005, 0.005])
    assert start.errors.tolist() == (normals(1, Stream.START, 0, 17) * start.sds).tolist()
    nu = _product(start.lam[None], start.eta[None])
    for estimate, truth, first in ((start.mu[None], paper.mu, 0), (nu, paper.nu, 9), (start.lam[None], paper.lam, 12)):
        turn = _product(truth[:1] * _CONJUGATE, estimate)[0]
        size = 2 * np.arctan2(np.linalg.norm(turn[1:]), turn[0])
        assert turn[1:] / np.linalg.norm(turn[1:]) * size == pytest.approx(start.errors[first : first + 3], abs=1e-15)
    moved = [start.longitude, start.latitude, *start.velocity, start.height, *start.mast_rate]
    true = [paper.longitude[0], paper.latitude[0], *paper.velocity[0], paper.height[0], *paper.mast_rate[0]]
    assert np.subtract(moved, true) == pytest.approx([*start.errors[3:9], *start.errors[15:]], abs=1e-13)
    large = start_estimate(replace(_PAPER, attitude_error_sd=ExactNumber("0.1/sqrt(3)")))
    assert large.errors[:3] == pytest.approx(10 * start.errors[:3], rel=1e-15)


_OTHER = {
    "velocity_east": "300 + 20*sin(t)", "latitude": 1, "mast_length": 25, "vehicle_rotation": [0.5, -1, 2],
    "mast_rotation": [0.7, 0.4, 0], "angular_rate": ["0.3 + 0.1*sin(5*t)", "0.2*t", "-0.4"], "fault": "range",
    "fault_size": 50, "seed": 5, "range_sd": 1,
}  # fmt: skip


@pytest.mark.parametrize("given", [{}, _OTHER], ids=["paper", "other"])
def test_rows_are_those_of_the_second_path(given: dict[str, Any]) -> None:
    """Taylor series and mpmath against Magnus, running products and our own sines: every column of every table."""
    made = case(**given)
    for group in GROUPS["mast_antenna"][1:]:
        (table,) = group.tables
        rows = [0, 3, 11]
        found = [batch for (batch,) in group.batches("test", [Segment(made, 0, 12)], RoundingTally())]
        assert len(found) == 1
        errors = largest_errors("mast_antenna", made, rows, {table: found[0].take(rows)})
        assert errors[table].count == len(rows) * len(computed_columns("mast_antenna", table))
        assert errors[table].size < 1, errors[table].where


def _rows(made: MastCase, table: str, first: int, count: int) -> Iterator[list[Any]]:
    (group,) = [group for group in GROUPS["mast_antenna"] if group.tables == (table,)]
    for (batch,) in group.batches("test", [Segment(made, first, count)], RoundingTally()):
        yield from batch.to_pylist()


@pytest.mark.parametrize("table", ["sensors", "satellites", "measurements", "truth"])
def test_rows_do_not_depend_on_segments_and_blocks(table: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made = case(duration="8", **_OTHER)
    whole = list(_rows(made, table, 0, 800))
    for first, count in ((0, 1), (255, 3), (797, 3)):
        assert list(_rows(made, table, first, count)) == whole[first : first + count]
    # Blocks are whole chunks of running products, of 256 half steps.
    monkeypatch.setattr(blocks_of_rows, "BLOCK", 512)
    assert list(_rows(made, table, 0, 800)) == whole


def test_a_longer_run_begins_as_a_shorter_one() -> None:
    short, long = (sampled(case(duration=duration)) for duration in ("0.4", "3"))
    for name in ("mu", "eta", "lam", "latitude", "specific_force2", "range", "rate2_right"):
        assert np.array_equal(getattr(short, name)[:-1], getattr(long, name)[: 2 * short.steps]), name


def test_files_of_cases_that_share_a_run(tmp_path: Path) -> None:
    """Sensors, satellites and truth once; measurements for each: generated, verified, and a defect found."""
    shared = {"run": "mine", "satellites_used": 1, "range_sd": "0.1"}
    cases = [case(), case(name="one", **shared), case(name="other", **{**_OTHER, "interval": "0.02"})]
    folder = generate("mast_antenna", "sweep", cases, tmp_path).folder
    assert [check for check in verify(folder) if not check.holds] == []
    for table in ("truth", "sensors", "satellites"):
        assert pq.read_table(folder / f"{table}.parquet")["case"].unique().to_pylist() == ["mine", "other"]
    rows = dict(list(pq.read_table(folder / "measurements.parquet").to_pandas().groupby("case")))
    assert len(rows["one"]) == len(rows["mine"]) == 41
    assert np.array_equal(rows["one"]["range_rate1"], rows["mine"]["range_rate1"])
    noise = normals(20240001, Stream.SATELLITES, 1, 1)[0]
    difference = rows["mine"]["range1"].iloc[0] - rows["one"]["range1"].iloc[0]
    assert difference == pytest.approx((5 - 0.1) * noise, abs=1e-8)
