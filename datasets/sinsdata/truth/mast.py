"""Sensors and truth of an antenna on a mast as arrays, and what an estimator may see of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from sinsdata.cases.mast import MastCase
from sinsdata.truth.mast_blocks import Array, GridModel, MastBlock, mast_blocks, start_attitudes
from sinsref.arithmetic import BallArithmetic, Number
from sinsref.mast import exponential, mast_rates
from sinsref.mast_random import Stream, normals
from sinsref.quaternion import conjugate, product

SENSORS = ("rate1", "specific_force1", "rate2", "specific_force2")
_BITS = 192


@dataclass(frozen=True)
class StartEstimate:
    """The initial estimate of a case, and how uncertain it is.

    Attributes
    ----------
    mu, eta, lam : ndarray, shape (4,)
    longitude, latitude, height : float
        rad, m.
    velocity : ndarray, shape (3,)
        m/s.
    mast_rate : ndarray, shape (2,)
        Absolute rates of Q about its axes X and Y, rad/s.
    errors, sds : ndarray, shape (17,)
        What it differs from the truth by, and standard deviations, in the order turn of mu (3), longitude, latitude,
        velocity (3), height, turn of nu (3), turn of lambda (3; none about the mast), mast rate (2). Turns are to the
        right: ``mu <- mu o exp(turn)``.
    """

    mu: Array
    longitude: float
    latitude: float
    velocity: Array
    height: float
    eta: Array
    lam: Array
    mast_rate: Array
    errors: Array
    sds: Array


@dataclass(frozen=True)
class Readings:
    """What an estimator may see: noisy readings in each step, at its start, middle and end.

    Attributes
    ----------
    time : ndarray, shape (n+1,)
        Starts of the steps, and the end, s.
    rate1, specific_force1, rate2, specific_force2 : ndarray, shape (n, 3, 3)
        By step, node and axis, rad/s and m/s^2. Where a reading jumps, at the ends of steps, these are the limits from
        inside the step.
    range_rate, range : ndarray, shape (n, 3, N)
        By step, node and satellite, m/s and m; the first node is the measurement at the start of the step.
    range_rate_last, range_last : ndarray, shape (N,)
        Measurement at the end.
    satellite_position, satellite_velocity : ndarray, shape (n, 3, N, 3)
        In G, m and m/s.
    """

    time: Array
    rate1: Array
    specific_force1: Array
    rate2: Array
    specific_force2: Array
    range_rate: Array
    range: Array
    range_rate_last: Array
    range_last: Array
    satellite_position: Array
    satellite_velocity: Array


@dataclass(frozen=True)
class MastMotion:
    """Sensors and truth of a case of n steps, on the half grid: row i is the time i h/2.

    Attributes
    ----------
    case_name : str
    interval : float
        h, s.
    radius, gravity, rotation_rate, mast_length : float
        m, m/s^2, rad/s, m.
    gyro_sd, accelerometer_sd, antenna_rate_sd, range_rate_sd, range_sd : float
        Of a sample; rad/s, m/s^2, m/s, m.
    time, longitude, latitude, height : ndarray, shape (2n+1,)
        s, rad, m.
    mu, eta, lam, nu : ndarray, shape (2n+1, 4)
    velocity : ndarray, shape (2n+1, 3)
        East, north, up, m/s.
    mast_rate : ndarray, shape (2n+1, 2)
        Absolute rates of Q about its axes X and Y, rad/s.
    rate1, specific_force1, specific_force2 : ndarray, shape (2n+1, 3)
        Without noise, rad/s and m/s^2.
    rate2_left, rate2_right : ndarray, shape (2n+1, 3)
        Without noise; limits from before and after, which differ at the ends of steps.
    antenna_rate : ndarray, shape (n, 3)
        Rate of the antenna relative to the mast in each step, rad/s.
    rate1_noise, specific_force1_noise, rate2_noise, specific_force2_noise : ndarray, shape (n, 3)
        What readings in each step differ by: noise and fault.
    satellite_position, satellite_velocity : ndarray, shape (2n+1, N, 3)
        In G, m and m/s.
    range_rate, range : ndarray, shape (2n+1, N)
        Without noise, m/s and m.
    range_rate_noise, range_noise : ndarray, shape (n+1, N)
        Of the measurements at the ends of steps.
    start : StartEstimate
    """

    case_name: str
    interval: float
    radius: float
    gravity: float
    rotation_rate: float
    mast_length: float
    gyro_sd: float
    accelerometer_sd: float
    antenna_rate_sd: float
    range_rate_sd: float
    range_sd: float
    time: Array
    mu: Array
    eta: Array
    lam: Array
    nu: Array
    longitude: Array
    latitude: Array
    height: Array
    velocity: Array
    mast_rate: Array
    rate1: Array
    specific_force1: Array
    specific_force2: Array
    rate2_left: Array
    rate2_right: Array
    antenna_rate: Array
    rate1_noise: Array
    specific_force1_noise: Array
    rate2_noise: Array
    specific_force2_noise: Array
    satellite_position: Array
    satellite_velocity: Array
    range_rate: Array
    range: Array
    range_rate_noise: Array
    range_noise: Array
    start: StartEstimate

    @property
    def steps(self) -> int:
        """The number n of steps."""
        return len(self.antenna_rate)

    def readings(self) -> Readings:
        """Return what an estimator may see."""
        nodes = self._nodes
        rate2 = np.stack([self.rate2_right[:-1:2], self.rate2_right[1::2], self.rate2_left[2::2]], axis=1)
        return Readings(
            self.time[::2],
            self.rate1[nodes] + self.rate1_noise[:, None],
            self.specific_force1[nodes] + self.specific_force1_noise[:, None],
            rate2 + self.rate2_noise[:, None],
            self.specific_force2[nodes] + self.specific_force2_noise[:, None],
            self.range_rate[nodes] + self.range_rate_noise[:-1, None],
            self.range[nodes] + self.range_noise[:-1, None],
            self.range_rate[-1] + self.range_rate_noise[-1],
            self.range[-1] + self.range_noise[-1],
            self.satellite_position[nodes],
            self.satellite_velocity[nodes],
        )

    @cached_property
    def _nodes(self) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
        return 2 * np.arange(self.steps)[:, None] + np.arange(3)


def sampled(case: MastCase) -> MastMotion:
    """Return sensors and truth of a case as arrays: 1000 s at 100 Hz in about 2 s, 0.25 GB."""
    model, steps = GridModel(case), case.samples
    arrays = _joined(mast_blocks(model, 2 * steps), 2 * steps + 1, case.satellite_count)
    rate_noise, range_noise = model.measurement_noise(0, steps + 1)
    names = ("gyro_sd", "accelerometer_sd", "antenna_rate_sd", "range_rate_sd", "range_sd")
    found: dict[str, Any] = {
        "interval": float(case.interval),
        **vars(model.constants),
        **{name: float(getattr(case, name)) for name in names},
        **arrays,
        "antenna_rate": model.antenna_rates(0, steps - 1),
        **{f"{sensor}_noise": model.noise(sensor, 0, steps) for sensor in SENSORS},
        "range_rate_noise": rate_noise[:, : case.satellite_count],
        "range_noise": range_noise[:, : case.satellite_count],
    }
    return MastMotion(case.name, start=start_estimate(case), **found)


def rate_2_limits(block: MastBlock) -> tuple[Array, Array]:
    """Return the absolute rate of J2 in J2 at the rows of a block, shape (rows, 3): limits from before and after."""
    carried = np.stack(block.carried_rate_2, axis=1)
    rows = np.arange(block.rows.count)
    return carried + block.antenna_rates[(rows + 1) // 2], carried + block.antenna_rates[rows // 2 + 1]


def _joined(blocks: Iterable[MastBlock], count: int, satellites: int) -> dict[str, Array]:
    """Return the columns of blocks in one piece each, of `count` rows; one block is in memory at a time."""
    whole: dict[str, Array] = {}
    for block in blocks:
        # The last row of a block is the first of the next, which decides.
        rows = slice(block.rows.first, block.rows.first + block.rows.count)
        left, right = rate_2_limits(block)
        places = [block.satellite(n) for n in range(satellites)]
        ranges = [block.range_and_rate(n) for n in range(satellites)]
        own = {
            "time": block.rows.time,
            **{name: np.stack(getattr(block, name), axis=1) for name in ("mu", "eta", "lam", "nu", "velocity")},
            "longitude": block.longitude[0],
            "latitude": block.latitude[0],
            "height": block.height,
            "mast_rate": np.stack(block.mast_rate[:2], axis=1),
            "rate1": np.stack(block.rates[:3], axis=1),
            "specific_force1": np.stack(block.force_1, axis=1),
            "specific_force2": np.stack(block.force_2, axis=1),
            "rate2_left": left,
            "rate2_right": right,
            "satellite_position": np.stack([np.stack(place, axis=1) for place, _ in places], axis=1),
            "satellite_velocity": np.stack([np.stack(rate, axis=1) for _, rate in places], axis=1),
            "range": np.stack([distance for distance, _ in ranges], axis=1),
            "range_rate": np.stack([rate for _, rate in ranges], axis=1),
        }
        for name, values in own.items():
            if name not in whole:
                whole[name] = np.empty((count, *values.shape[1:]))
            whole[name][rows] = values
    return whole


def start_estimate(case: MastCase) -> StartEstimate:
    """Return the initial estimate of a case: truth, moved by normal errors (`StartEstimate.errors`)."""
    with BallArithmetic(_BITS) as balls:
        attitude, position = balls.number(case.attitude_error_sd), balls.number(case.position_error_sd)
        cosine = balls.sin_cos(balls.number(case.latitude))[1]
        radius = balls.number(case.radius)
        deviations = [
            *[attitude] * 3, position / (radius * cosine), position / radius,
            *[balls.number(case.velocity_error_sd)] * 3, position,
            *[attitude] * 5, balls.number(0), *[balls.number(case.mast_rate_error_sd)] * 2,
        ]  # fmt: skip
        sds = [float(x.mid()) for x in deviations]
        errors = [float(x) for x in normals(int(case.error_seed.fraction or 0), Stream.START, 0, 17) * np.array(sds)]
        moved = [balls.number(x) for x in errors]
        mu, eta, lam = start_attitudes(balls, case)
        zero = balls.number(0)
        rates = [profile.terms(balls).jet(balls, zero)[0] for profile in (*case.angular_rate, *case.mast_rate)]
        velocity = [
            profile.terms(balls).jet(balls, zero)[0]
            for profile in (case.velocity_east, case.velocity_north, case.velocity_up)
        ]
        mast_rate = mast_rates(lam, rates[:3], rates[3:])[1][:2]
        turn_mu, turn_nu, turn_lam = (exponential(balls, moved[place : place + 3]) for place in (0, 9, 12))

        def column(values: list[Number], errors: list[Number] | None = None) -> Array:
            sums = values if errors is None else [x + y for x, y in zip(values, errors, strict=True)]
            return np.array([float(x.mid()) for x in sums])

        place = column([balls.number(x) for x in (case.longitude, case.latitude, case.height)], [*moved[3:5], moved[8]])
        return StartEstimate(
            column(product(mu, turn_mu)),
            float(place[0]),
            float(place[1]),
            column(velocity, moved[5:8]),
            float(place[2]),
            column(product(product(conjugate(turn_lam), eta), turn_nu)),
            column(product(lam, turn_lam)),
            column(mast_rate, moved[15:]),
            np.array(errors),
            np.array(sds),
        )
