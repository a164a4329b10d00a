"""The input conventions of one motion: what gyros and accelerometers are said to deliver, as certified tables.

Every table holds the same dual precession. They differ in what a row means: values at an instant, means or integrals
over a sample, integrals since the start, integrals resolved in a frame that does not turn, samples off the grid,
samples that were lost on the way, counts of a sensor of finite resolution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.certified import BLOCK, Block, RowFormula, blocks
from sinsdata.truth.formulas import WORKING_BITS, increment_formula, precession_formula
from sinsdata.truth.irregular import PARTS, arrived, arrived_count, shifts
from sinsdata.truth.scattered import ScatteredTable
from sinsref.arithmetic import Arithmetic, BallArithmetic, MpArithmetic, Number
from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic
from sinsref.precession import (
    DualPrecession,
    accumulated,
    angular_rate_and_specific_force,
    increments,
    mean_rates,
    resolved_increments,
)
from sinsref.rounding import ESCALATION, RoundingTally, UndecidedError, round_balls, settle

__all__ = [
    "CONVENTIONS",
    "NONUNIFORM_TRUTH",
    "QUANTA",
    "TABLES",
    "Convention",
    "InputTable",
    "known_convention",
    "nonuniform_time",
]

#: ``blocks(case, first, count, tally)`` yields the rows `first` ... `first + count - 1` of a case, counted from 0.
RowBlocks: TypeAlias = Callable[[DualPrecessionCase, int, int, RoundingTally], Iterator[Block]]

#: What one count of the quantised sensors means: 2^-20 rad (0.2 seconds of arc) and 2^-12 m/s.
QUANTA = (2.0**-20,) * 3 + (2.0**-12,) * 3


@dataclass(frozen=True)
class InputTable:
    """A table of inputs.

    Attributes
    ----------
    name : str
    vectors : tuple of 2 str
        Stems of its two vectors: the last six value columns are ``<stem>_x``, ``_y``, ``_z`` of each.
    first_sample : int
        Number of the epoch of its first row: 0 for values at instants, 1 for what samples end with.
    rows : callable
        Number of rows of a case.
    blocks : callable
        See `RowBlocks`. `Block.index` holds sample numbers, `Block.high` and `low` the value columns.
    exact_row : callable
        ``exact_row(arithmetic, case, row)`` returns time and values of row `row`, from 0, by mpmath.
    """

    name: str
    vectors: tuple[str, str]
    first_sample: int
    rows: Callable[[DualPrecessionCase], int]
    blocks: RowBlocks
    exact_row: Callable[[MpArithmetic, DualPrecessionCase, int], list[Number]]


def _uniform(
    name: str, vectors: tuple[str, str], first_sample: int, formula: Callable[[DualPrecessionCase], RowFormula]
) -> InputTable:
    """Return a table of a formula at equidistant epochs."""

    def rows_of(case: DualPrecessionCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
        return blocks(formula(case), case.interval, first_sample + first, count, WORKING_BITS, tally)

    def exact_row(ar: MpArithmetic, case: DualPrecessionCase, row: int) -> list[Number]:
        time = ar.number(case.interval) * (first_sample + row)
        return [time, *formula(case)(ar, time)]

    return InputTable(name, vectors, first_sample, lambda case: case.samples + 1 - first_sample, rows_of, exact_row)


def _at_instants(
    values: Callable[[Arithmetic, DualPrecession, Number], tuple[list[Number], list[Number]]],
) -> Callable[[DualPrecessionCase], RowFormula]:
    """Return, for each case, the formula of two vectors at a time."""

    def of(case: DualPrecessionCase) -> RowFormula:
        def formula(ar: Arithmetic, time: Number) -> Sequence[Number]:
            first, second = values(ar, case.motion, time)
            return [*first, *second]

        return formula

    return of


def _over_samples(
    values: Callable[[Arithmetic, DualPrecession, Number, Number], tuple[list[Number], list[Number]]],
) -> Callable[[DualPrecessionCase], RowFormula]:
    """Return, for each case, the formula of two vectors over the sample that ends at a time."""

    def of(case: DualPrecessionCase) -> RowFormula:
        def formula(ar: Arithmetic, time: Number) -> Sequence[Number]:
            first, second = values(ar, case.motion, time, ar.number(case.interval))
            return [*first, *second]

        return formula

    return of


# Samples off the grid.


def nonuniform_time(case: DualPrecessionCase, ar: Arithmetic, epoch: int) -> Number:
    """Return the time t_k = h (k + j_k) of an epoch of the samples off the grid, s."""
    shift = int(shifts(case.samples, np.array([epoch]))[0])
    return ar.number(case.interval) * ar.number(Fraction(PARTS * epoch + shift, PARTS))


def _nonuniform_row(case: DualPrecessionCase, ar: Arithmetic, sample: int) -> list[Number]:
    """Return time, length and increments of a sample whose ends lie off the grid."""
    start, end = (nonuniform_time(case, ar, epoch) for epoch in (sample - 1, sample))
    angle, velocity = increments(ar, case.motion, end, end - start)
    return [end, end - start, *angle, *velocity]


def _nonuniform_blocks(case: DualPrecessionCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    formula = _at_instants(accumulated)(case)
    table = ScatteredTable(lambda ar, time: [time, *formula(ar, time)], case.interval, PARTS, WORKING_BITS)
    for start in range(first, first + count, BLOCK):
        epochs = np.arange(start, min(start + BLOCK, first + count) + 1)
        with BallArithmetic(WORKING_BITS):
            ends = table.balls(start, shifts(case.samples, epochs))
            values = [
                (after[0], *(x - y for x, y in zip(after, before, strict=True))) for before, after in pairwise(ends)
            ]
            shape = len(values), len(values[0])
            pairs = round_balls([x for row in values for x in row])
        high, low, decided = pairs[0].reshape(shape), pairs[1].reshape(shape), pairs[2].reshape(shape)
        index = epochs[1:]
        settle(partial(_nonuniform_row, case), index.tolist(), high, low, decided, tally)
        yield Block(index, high[:, 0], low[:, 0], high[:, 1:], low[:, 1:])


def _true_row(case: DualPrecessionCase, ar: Arithmetic, epoch: int) -> list[Number]:
    """Return time, attitude and velocities at an epoch off the grid."""
    time = nonuniform_time(case, ar, epoch)
    return [time, *precession_formula(case)(ar, time)]


def _true_blocks(case: DualPrecessionCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    formula = precession_formula(case)
    table = ScatteredTable(lambda ar, time: [time, *formula(ar, time)], case.interval, PARTS, WORKING_BITS)
    for start in range(first, first + count, BLOCK):
        epochs = np.arange(start, min(start + BLOCK, first + count))
        with BallArithmetic(WORKING_BITS):
            values = table.balls(start, shifts(case.samples, epochs))
            shape = len(values), len(values[0])
            pairs = round_balls([x for row in values for x in row])
        high, low, decided = pairs[0].reshape(shape), pairs[1].reshape(shape), pairs[2].reshape(shape)
        settle(partial(_true_row, case), epochs.tolist(), high, low, decided, tally)
        yield Block(epochs, high[:, 0], low[:, 0], high[:, 1:], low[:, 1:])


# Samples that never arrive.


def _dropped_blocks(case: DualPrecessionCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    # The increments of the samples in between are computed, tallied and left out: they cost 2 %, bookkeeping more.
    samples = arrived(case.samples, np.arange(first, first + count))
    between = int(samples[-1] - samples[0]) + 1
    for block in blocks(increment_formula(case), case.interval, int(samples[0]), between, WORKING_BITS, tally):
        kept = np.isin(block.index, samples)
        yield Block(block.index[kept], block.time[kept], block.time_lo[kept], block.high[kept], block.low[kept])


def _dropped_row(ar: MpArithmetic, case: DualPrecessionCase, row: int) -> list[Number]:
    time = ar.number(case.interval) * int(arrived(case.samples, np.array([row]))[0])
    return [time, *increment_formula(case)(ar, time)]


# Counts.


def _nearest_count(value: Callable[[Arithmetic], Number]) -> int:
    """Return the integer nearest to a value, the even one at a tie, raising the precision until it is decided."""
    for bits in ESCALATION:
        with PiMonomialArithmetic(bits) as ar:
            exact = value(ar)
            if isinstance(exact, PiMonomial):
                if exact.power == 0:
                    return round(exact.coefficient)
                exact = exact.ball()
            nearest = (exact + arb(0.5)).floor().unique_fmpz()
            tie = (exact * 2).unique_fmpz()
            if nearest is not None and tie is None:
                return int(nearest)
    if tie is None:
        raise UndecidedError(f"{bits} bits do not decide which count is nearest")
    # The precision does not tell the value from a tie: it is taken for one, as `sinsref.rounding` does.
    return round(Fraction(int(tie), 2))


def _counts(case: DualPrecessionCase, block: Block) -> NDArray[np.object_]:
    """Return the accumulated integrals in whole quanta, rounded half to even, as integers.

    Both halves of a pair are correct roundings. So the first decides, unless it is half way between two counts: then
    the sign of the second does. What remains, ties and counts that binary64 does not hold, goes to the balls.
    """
    scaled = block.high / QUANTA  # exact: the quanta are powers of two
    with np.errstate(invalid="ignore"):
        counts = np.rint(scaled)
        beyond = scaled - counts
    half_way = np.abs(beyond) == 0.5
    counts += np.where(half_way & (block.low * beyond > 0), np.sign(beyond), 0)
    undecided = (half_way & (block.low == 0)) | (np.abs(scaled) >= 2.0**53)
    whole = np.where(undecided, 0.0, counts).astype(np.int64).astype(object)
    formula = _at_instants(accumulated)(case)

    def in_quanta(ar: Arithmetic, epoch: int, place: int) -> Number:
        return formula(ar, ar.number(case.interval) * epoch)[place] * ar.number(Fraction(1 / QUANTA[place]))

    for row, place in np.argwhere(undecided).tolist():
        whole[row, place] = _nearest_count(partial(in_quanta, epoch=int(block.index[row]), place=place))
    return whole


def _quantised_blocks(case: DualPrecessionCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    before: NDArray[np.object_] | None = None
    # One epoch more than rows: a row is the difference of the counts at its ends.
    for block in blocks(_at_instants(accumulated)(case), case.interval, first, count + 1, WORKING_BITS, tally):
        counts = _counts(case, block)
        steps = np.diff(counts if before is None else np.vstack([before, counts]), axis=0)
        before = counts[-1:]
        high = steps.astype(np.float64)
        # Zero unless a sample holds more than 2^53 counts.
        low = (steps - np.frompyfunc(int, 1, 1)(high)).astype(np.float64)
        rows = slice(len(counts) - len(steps), None)
        yield Block(block.index[rows], block.time[rows], block.time_lo[rows], high * QUANTA, low * QUANTA)


def _quantised_row(ar: MpArithmetic, case: DualPrecessionCase, row: int) -> list[Number]:
    interval = ar.number(case.interval)
    start, end = (_at_instants(accumulated)(case)(ar, interval * epoch) for epoch in (row, row + 1))
    steps = (
        (ar.context.nint(y / quantum) - ar.context.nint(x / quantum)) * quantum
        for x, y, quantum in zip(start, end, QUANTA, strict=True)
    )
    return [interval * (row + 1), *steps]


_RATES, _INTEGRALS = ("angular_rate", "specific_force"), ("angle", "velocity")

TABLES: Mapping[str, InputTable] = {
    table.name: table
    for table in (
        _uniform("increments", _INTEGRALS, 1, increment_formula),
        _uniform("rates", _RATES, 0, _at_instants(angular_rate_and_specific_force)),
        _uniform("mean_rates", _RATES, 1, _over_samples(mean_rates)),
        _uniform("accumulated", _INTEGRALS, 0, _at_instants(accumulated)),
        _uniform("resolved", ("velocity_start", "velocity_end"), 1, _over_samples(resolved_increments)),
        InputTable(
            "nonuniform",
            _INTEGRALS,
            1,
            lambda case: case.samples,
            _nonuniform_blocks,
            lambda ar, case, row: _nonuniform_row(case, ar, row + 1),
        ),
        InputTable("dropped", _INTEGRALS, 1, lambda case: arrived_count(case.samples), _dropped_blocks, _dropped_row),
        InputTable("quantised", _INTEGRALS, 1, lambda case: case.samples, _quantised_blocks, _quantised_row),
    )
}
"""The input tables of `dual_precession` by name."""


NONUNIFORM_TRUTH = InputTable(
    "nonuniform_truth",
    ("w_inertial", "w_body"),
    0,
    lambda case: case.samples + 1,
    _true_blocks,
    lambda ar, case, row: _true_row(case, ar, row),
)
"""Attitude and velocities at the times of ``nonuniform``, the start included: no input, but made as one."""


@dataclass(frozen=True)
class Convention:
    """What an integrator may take: f(first, second, interval or times, attitude0, velocity0).

    Attributes
    ----------
    name : str
    first, second : tuple of 2 str
        Table and stem of the vector that is each argument.
    times : bool
        Whether the third argument holds the start and the ends of the samples, s, in place of their common interval.
    meaning : str
    """

    name: str
    first: tuple[str, str]
    second: tuple[str, str]
    meaning: str
    times: bool = False


def _own(table: str, meaning: str, times: bool = False) -> Convention:
    """Return the convention that reads one table."""
    first, second = TABLES[table].vectors
    return Convention(table, (table, first), (table, second), meaning, times)


def _resolved(at: str) -> Convention:
    return Convention(
        f"resolved_{at}",
        ("increments", "angle"),
        ("resolved", f"velocity_{at}"),
        f"angle increments, and velocity increments resolved in the body axes of the sample's {at}",
    )


CONVENTIONS: Mapping[str, Convention] = {
    convention.name: convention
    for convention in (
        _own("increments", "integrals over each sample of angular rate and specific force in body axes"),
        _own("rates", "angular rate and specific force at the ends of the samples, the start included"),
        _own("mean_rates", "their means over each sample"),
        _own("accumulated", "their integrals since the start, at the ends of the samples, the start included"),
        _resolved("start"),
        _resolved("end"),
        _own("nonuniform", "increments over samples of different lengths", times=True),
        _own("dropped", "increments, of which some samples never arrive", times=True),
        _own("quantised", "increments of integrals that are rounded to whole quanta"),
    )
}
"""The conventions that a subject may take, by name."""


def known_convention(name: str) -> Convention:
    """Return a convention by its name.

    Raises
    ------
    ValueError
        If there is none; the message lists the admissible names.
    """
    if name not in CONVENTIONS:
        raise ValueError(f"there is no input convention {name!r}; admissible: {', '.join(CONVENTIONS)}")
    return CONVENTIONS[name]
