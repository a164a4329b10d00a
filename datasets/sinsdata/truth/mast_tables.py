"""Rows of the tables of `mast_antenna`, block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from sinsdata.cases.mast import MastCase
from sinsdata.truth.certified import Block, blocks
from sinsdata.truth.formulas import WORKING_BITS
from sinsdata.truth.mast import SENSORS, rate_2_limits
from sinsdata.truth.mast_blocks import Array, GridModel, MastBlock, mast_blocks
from sinsref.rounding import RoundingTally

#: Satellites whose measurements are stored, used or not.
_SATELLITES = range(4)


def own_samples(case: MastCase) -> int:
    """Return how many steps of a case are stored: none of one that shares another's."""
    return 0 if case.run is not None else case.samples


def own_epochs(case: MastCase) -> int:
    """Return how many epochs of a case are stored: none of one that shares another's."""
    return 0 if case.run is not None else case.samples + 1


def sensor_blocks(case: MastCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield readings without noise at start, middle and end of steps, and what noisy ones differ by: 48 columns."""

    def columns(block: MastBlock) -> Array:
        left, right = rate_2_limits(block)
        readings = [np.stack(x, axis=1) for x in (block.rates[:3], block.force_1)]
        force_2 = np.stack(block.force_2, axis=1)
        starts, middles, ends = slice(None, -1, 2), slice(1, None, 2), slice(2, None, 2)
        nodes = [
            part
            for rows, rate_2 in ((starts, right), (middles, right), (ends, left))
            for part in (*(x[rows] for x in readings), rate_2[rows], force_2[rows])
        ]
        steps = block.steps
        noise = [block.model.noise(sensor, steps.start, steps.stop - steps.start) for sensor in SENSORS]
        return np.concatenate([*nodes, *noise], axis=1)

    yield from _blocks(case, columns, first, count, tally, epochs=False)


def satellite_blocks(case: MastCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield position, velocity, range rate and range of four satellites: 32 columns."""

    def columns(block: MastBlock) -> Array:
        values = []
        for n in _SATELLITES:
            distance, rate = block.range_and_rate(n)
            position, velocity = block.satellite(n)
            values += [*position, *velocity, rate, distance]
        return np.stack(values, axis=1)[::2]

    yield from _blocks(case, columns, first, count, tally)


def measurement_blocks(case: MastCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield measured range rate and range of four satellites: 8 columns."""

    def columns(block: MastBlock) -> Array:
        steps = block.steps
        noise = block.model.measurement_noise(steps.start, steps.stop - steps.start + 1)
        values = []
        for n in _SATELLITES:
            distance, rate = block.range_and_rate(n)
            values += [rate[::2] + noise[0][:, n], distance[::2] + noise[1][:, n]]
        return np.stack(values, axis=1)

    yield from _blocks(case, columns, first, count, tally)


def truth_blocks(case: MastCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield mu, lambda, eta, nu, longitude, latitude, height, velocity and the mast's absolute rates: 24 columns."""

    def columns(block: MastBlock) -> Array:
        values = [
            *block.mu, *block.lam, *block.eta, *block.nu, block.longitude[0], block.latitude[0], block.height,
            *block.velocity, *block.mast_rate[:2],
        ]  # fmt: skip
        return np.stack(values, axis=1)[::2]

    yield from _blocks(case, columns, first, count, tally)


def _blocks(
    case: MastCase,
    columns: Callable[[MastBlock], Array],
    first: int,
    count: int,
    tally: RoundingTally,
    epochs: bool = True,
) -> Iterator[Block]:
    """Yield rows of epochs first ... , or of steps first + 1 ..., of what the blocks of the half grid give.

    Blocks before the first row cost their attitudes only.
    """
    offset, end = int(not epochs), first + count
    for block in mast_blocks(GridModel(case), 2 * end):
        steps = block.steps
        # The epoch at the end of a block opens the next one, where there is one.
        last = epochs and steps.stop == case.samples
        start, stop = max(first, steps.start), min(end, steps.stop + last)
        if start >= stop:
            continue
        values = columns(block)[start - steps.start : stop - steps.start]
        times = blocks(lambda ar, time: [time], case.interval, start + offset, stop - start, WORKING_BITS, tally)
        done = 0
        for part in times:
            size = len(part.index)
            own = values[done : done + size]
            yield Block(part.index, part.time, part.time_lo, own, np.empty((size, 0)))
            done += size
