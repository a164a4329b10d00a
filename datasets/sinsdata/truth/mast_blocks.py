"""Motion, sensors and satellites of an antenna on a mast, block by block on the half grid, in binary64.

Row i is the time i h/2. Functions of time, satellites and noise are functions of the row alone; attitudes, latitude and
longitude go on from block to block (`sinsref.mast_running`). Blocks begin at multiples of a fixed number of rows, so a
row has the same bits whoever asks for which rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from sinsdata.cases.mast import MastCase
from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.mast import (
    Constants,
    Orbit,
    SineCosine,
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
from sinsref.mast_elementary import sin_cos
from sinsref.mast_functions import GridFunction, Phase, Rows, antiderivative, derivative, phase_of
from sinsref.mast_random import Stream, normals
from sinsref.mast_running import NODES, WEIGHTS, RunningProduct, RunningSum, small_rotation, step_rotation
from sinsref.profiles import TimeSum
from sinsref.quaternion import product

Array: TypeAlias = NDArray[np.float64]

#: Half steps of a block: what bounds the memory.
BLOCK = 2**15
_BITS = 192
_ROOT_15 = sqrt(15.0)
#: The Gauss method of three stages: position at a node from the rates at all three.
_STAGES = (
    (5 / 36, 2 / 9 - _ROOT_15 / 15, 5 / 36 - _ROOT_15 / 30),
    (5 / 36 + _ROOT_15 / 24, 2 / 9, 5 / 36 - _ROOT_15 / 24),
    (5 / 36 + _ROOT_15 / 30, 2 / 9 + _ROOT_15 / 15, 5 / 36),
)


def constants_of(ar: Arithmetic, case: MastCase) -> Constants:
    """Return the constants of a case as numbers of an arithmetic."""
    given = (case.radius, case.gravity, case.rotation_rate, case.mast_length)
    return Constants(*(ar.number(x) for x in given))


def start_attitudes(ar: Arithmetic, case: MastCase) -> list[list[Number]]:
    """Return mu, eta and lambda at time 0."""

    def turned(rotation: Sequence[ExactNumber]) -> list[Number]:
        return exponential(ar, [ar.number(x) for x in rotation])

    level = level_quaternion(ar, ar.number(case.longitude), ar.number(case.latitude))
    return [product(level, turned(case.vehicle_rotation)), turned(case.antenna_rotation), turned(case.mast_rotation)]


def _pair(x: arb) -> tuple[float, float]:
    high = float(x.mid())
    return high, float((x - arb(high)).mid())


class GridModel:
    """The functions of time of a case on its half grid.

    Parameters
    ----------
    case : MastCase
    parts : int, optional
        Into how many steps of the integration half an interval is cut; the case's by default.
    """

    def __init__(self, case: MastCase, parts: int | None = None) -> None:
        self.case, self.parts = case, parts or case.parts
        with BallArithmetic(_BITS) as balls:
            spacing = balls.number(case.interval) / 2
            self.half_step = float(spacing.mid())
            velocity = [profile.terms(balls) for profile in (case.velocity_east, case.velocity_north, case.velocity_up)]
            climbed = antiderivative(velocity[2])
            height = TimeSum((climbed.powers[0] + balls.number(case.height), *climbed.powers[1:]), climbed.oscillations)
            rates = [profile.terms(balls) for profile in (*case.angular_rate, *case.mast_rate)]
            # Height last: what the nodes of a step need beside the rates.
            self._moving = self._compiled(balls, [*velocity, height], spacing)
            self._slopes = self._compiled(balls, [derivative(x) for x in [*velocity, *rates]], spacing)
            self._rates = self._compiled(balls, rates, spacing)
            shifts = [
                spacing * (balls.number(node) + part) / self.parts for part in range(self.parts) for node in NODES
            ]
            self._at_nodes = [self._compiled(balls, [*velocity[:2], height, *rates], spacing, x) for x in shifts]
            exact = constants_of(balls, case)
            self.constants = Constants(*(float(x) for x in vars(exact).values()))
            orbit = Orbit.at(balls, exact.rotation_rate)
            sine, cosine = orbit.inclination
            self.orbit = Orbit(
                float(orbit.radius), float(orbit.motion), (float(sine), float(cosine)), self.constants.rotation_rate
            )
            self.orbit_phases = [
                tuple(
                    phase_of(balls, speed, balls.number(angle), spacing)
                    for speed, angle in zip((-exact.rotation_rate, orbit.motion), pair, strict=True)
                )
                for pair in case.satellites
            ]
            self.earth_phase = phase_of(balls, exact.rotation_rate, balls.number(0), spacing)
            attitudes = [[_pair(x) for x in attitude] for attitude in start_attitudes(balls, case)]
            self.starts = [[x for x, _ in attitude] for attitude in attitudes]
            self.rests = [[x for _, x in attitude] for attitude in attitudes]
            self.longitude, self.latitude = (_pair(balls.number(x)) for x in (case.longitude, case.latitude))
        self.moves_east = any(self._moving[0].powers) or bool(self._moving[0].oscillations)

    @staticmethod
    def _compiled(
        balls: BallArithmetic, terms: Sequence[TimeSum], spacing: arb, shift: arb | None = None
    ) -> list[GridFunction]:
        return [GridFunction.of(balls, x, spacing, shift) for x in terms]

    def at_rows(self, rows: Rows) -> list[Array]:
        """Return velocity (3) and height at rows."""
        return [function.values(rows) for function in self._moving]

    def rates(self, rows: Rows) -> list[Array]:
        """Return the rates of J1 (3) and of the mast (2) at rows."""
        return [function.values(rows) for function in self._rates]

    def slopes(self, rows: Rows) -> list[Array]:
        """Return the derivatives of velocity (3), rates of J1 (3) and of the mast (2) at rows."""
        return [function.values(rows) for function in self._slopes]

    def at_node(self, node: int, rows: Rows) -> list[Array]:
        """Return velocity east and north, height, rates of J1 (3) and of the mast (2) at a Gauss node after rows."""
        return [function.values(rows) for function in self._at_nodes[node]]

    def antenna_rates(self, first: int, last: int) -> Array:
        """Return the rates of the antenna relative to the mast in steps `first` ... `last`, shape (m, 3), rad/s."""
        return self._samples(Stream.ANTENNA_RATE, self.case.antenna_rate_sd, first, last - first + 1)

    def noise(self, sensor: str, first: int, count: int) -> Array:
        """Return what readings of a sensor differ by from the truth, in some steps: noise and fault, shape (count, 3).

        Parameters
        ----------
        sensor : {"rate1", "specific_force1", "rate2", "specific_force2"}
        first, count : int
            Steps.
        """
        stream, deviation = {
            "rate1": (Stream.RATE_1, self.case.gyro_sd),
            "specific_force1": (Stream.FORCE_1, self.case.accelerometer_sd),
            "rate2": (Stream.RATE_2, self.case.gyro_sd),
            "specific_force2": (Stream.FORCE_2, self.case.accelerometer_sd),
        }[sensor]
        noise = self._samples(stream, deviation, first, count)
        noise[:, 0] += self._bias(sensor, first, count)
        return noise

    def measurement_noise(self, first: int, count: int) -> tuple[Array, Array]:
        """Return the same of range rates and ranges at some epochs, each of shape (count, 4)."""
        case = self.case
        numbers = normals(_whole(case.seed), Stream.SATELLITES, 8 * first, 8 * count).reshape(count, 4, 2)
        rates, ranges = numbers[:, :, 0] * float(case.range_rate_sd), numbers[:, :, 1] * float(case.range_sd)
        rates[:, 0] += self._bias("range_rate", first, count)
        ranges[:, 0] += self._bias("range", first, count)
        return rates, ranges

    def _samples(self, stream: Stream, deviation: ExactNumber, first: int, count: int) -> Array:
        return normals(_whole(self.case.seed), stream, 3 * first, 3 * count).reshape(count, 3) * float(deviation)

    def _bias(self, what: str, first: int, count: int) -> Array:
        if self.case.fault != what:
            return np.zeros(count)
        # Half an interval's tenth before: the fault begins in the step that its time names, however that is rounded.
        begin = (float(self.case.fault_time) - 0.1 * self.half_step) / (2 * self.half_step)
        return np.where(np.arange(first, first + count) >= begin, float(self.case.fault_size), 0.0)


def _whole(seed: ExactNumber) -> int:
    return int(seed.fraction or 0)


@dataclass(frozen=True)
class MastBlock:
    """Consecutive rows of the half grid, the first and the last of them whole steps; columns are lists of arrays.

    Attributes
    ----------
    model : GridModel
    rows : Rows
    longitude, latitude : tuple of ndarray
        rad, and what binary64 lacks.
    mu, eta, lam : list of four ndarray
    """

    model: GridModel
    rows: Rows
    longitude: tuple[Array, Array]
    latitude: tuple[Array, Array]
    mu: list[Array]
    eta: list[Array]
    lam: list[Array]

    @cached_property
    def steps(self) -> slice:
        """Numbers of the steps."""
        return slice(self.rows.first // 2, (self.rows.first + self.rows.count) // 2)

    @cached_property
    def nu(self) -> list[Array]:
        """Attitude of J2 relative to J1."""
        return product(self.lam, self.eta)

    @cached_property
    def velocity(self) -> list[Array]:
        """East, north, up, m/s."""
        return self._moving[:3]

    @property
    def height(self) -> Array:
        """Height, m."""
        return self._moving[3]

    @cached_property
    def _moving(self) -> list[Array]:
        return self.model.at_rows(self.rows)

    @cached_property
    def rates(self) -> list[Array]:
        """Absolute rate of J1 in J1 (3), and of the mast relative to it in Q (2), rad/s."""
        return self.model.rates(self.rows)

    @cached_property
    def mast_rate(self) -> list[Array]:
        """Absolute rate of Q in Q (3), rad/s."""
        return mast_rates(self.lam, self.rates[:3], self.rates[3:])[1]

    @cached_property
    def _slopes(self) -> list[Array]:
        return self.model.slopes(self.rows)

    @cached_property
    def _places(self) -> tuple[SineCosine, SineCosine]:
        return sin_cos(*self.longitude), sin_cos(*self.latitude)

    @cached_property
    def force_1(self) -> list[Array]:
        """Specific force of the vehicle, in J1, m/s^2."""
        (sine, cosine), latitude = self._places
        sine_e, cosine_e = self.rows.sin_cos(self.model.earth_phase)
        inertial = sine * cosine_e + cosine * sine_e, cosine * cosine_e - sine * sine_e
        force = level_force(self.model.constants, self.velocity, self._slopes[:3], self.height, latitude)
        return resolved(self.mu, from_level(inertial, latitude, force))

    @cached_property
    def force_2(self) -> list[Array]:
        """Specific force of the antenna, in J2, m/s^2."""
        top = top_force(
            self.model.constants, self.lam, self.force_1, self.rates[:3], self._slopes[3:6], self.rates[3:],
            self._slopes[6:],
        )  # fmt: skip
        return resolved(self.eta, top)

    @cached_property
    def carried_rate_2(self) -> list[Array]:
        """Absolute rate of Q, in J2: that of J2 less the antenna's own, rad/s."""
        return resolved(self.eta, self.mast_rate)

    @cached_property
    def antenna_rates(self) -> Array:
        """Rates of the antenna relative to the mast, shape (steps + 2, 3): from the step before to that after."""
        last = self.model.case.samples - 1
        known = self.model.antenna_rates(max(self.steps.start - 1, 0), min(self.steps.stop, last))
        # At the start there is no step before, at the end none after: the one that there is.
        before, after = int(self.steps.start == 0), int(self.steps.stop > last)
        return np.concatenate([known[:1].repeat(before, 0), known, known[-1:].repeat(after, 0)])

    def satellite(self, number: int) -> tuple[list[Array], list[Array]]:
        """Return position and Earth-relative velocity of a satellite, from 0, in G, m and m/s."""
        node, argument = self.model.orbit_phases[number]
        return self.model.orbit.place(self.rows.sin_cos(node), self.rows.sin_cos(argument))

    def range_and_rate(self, number: int) -> tuple[Array, Array]:
        """Return distance of a satellite, m, and its rate, m/s."""
        longitude, latitude = self._places
        place = receiver_position(self.model.constants, longitude, latitude, self.height)
        return range_and_rate(
            np.sqrt, place, from_level(longitude, latitude, self.velocity), *self.satellite(number)
        )  # fmt: skip


def mast_blocks(model: GridModel, last: int) -> Iterator[MastBlock]:
    """Yield the rows 0 ... `last` or a few more of the half grid, block by block.

    Each block repeats the last row of the one before.

    Parameters
    ----------
    model : GridModel
    last : int
        Number of a row.
    """
    half_steps = min(2 * model.case.samples, last + last % 2)
    attitudes = RunningProduct(model.starts, model.rests)
    latitudes, longitudes = RunningSum(*model.latitude), RunningSum(*model.longitude)
    for first in range(0, max(half_steps, 1), BLOCK):
        count = min(BLOCK, half_steps - first)
        rows = Rows(first, count + 1, model.half_step)
        # The nodes after the last row belong to the next block.
        nodes = [[x[:-1] for x in model.at_node(n, rows)] for n in range(3 * model.parts)]
        steps = first // 2, (first + count) // 2
        antenna = model.antenna_rates(steps[0], steps[1] - 1) * model.half_step
        eta = small_rotation(list(antenna.repeat(2, axis=0).T))
        zero = np.zeros(count)
        mu = step_rotation([at[3:6] for at in nodes], model.half_step, model.parts)
        lam = step_rotation([[*at[6:], zero] for at in nodes], model.half_step, model.parts)
        quaternions = attitudes.advance([mu, eta, lam])
        latitude, longitude = _positions(model, nodes, latitudes, longitudes)
        yield MastBlock(model, rows, longitude, latitude, *quaternions)


def _positions(
    model: GridModel, nodes: Sequence[Sequence[Array]], latitudes: RunningSum, longitudes: RunningSum
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return latitude and longitude at the rows of a block, from what is known at the nodes of its steps."""
    step = model.half_step / model.parts
    unit = np.ones(len(nodes[0][0]))
    north = [position_rates(model.constants, at[:2], at[2], (unit, unit))[1] for at in nodes]
    latitude = latitudes.advance(_quadrature(north, step))
    if not model.moves_east:
        return latitude, longitudes.advance(0.0 * unit)
    east, begin = [], latitude[0][:-1]
    for part in range(model.parts):
        own = north[3 * part : 3 * part + 3]
        for n, stage in enumerate(_STAGES):
            angle = begin + step * (stage[0] * own[0] + stage[1] * own[1] + stage[2] * own[2])
            at = nodes[3 * part + n]
            east.append(position_rates(model.constants, at[:2], at[2], sin_cos(angle))[0])
        begin = begin + _quadrature(own, step)
    return latitude, longitudes.advance(_quadrature(east, step))


def _quadrature(rates: Sequence[Array], step: float) -> Array:
    """Return the integrals over steps of what is known at their Gauss nodes, part by part."""
    total = np.zeros_like(rates[0])
    for n, rate in enumerate(rates):
        total = total + WEIGHTS[n % 3] * rate
    return total * step


__all__ = ["BLOCK", "Array", "GridModel", "MastBlock", "Phase", "constants_of", "mast_blocks", "start_attitudes"]
