"""Truth of the error equations along a motion: proved by enclosures, and recomputed by plain Taylor series."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import islice
from math import ceil, log2

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases.error_equations import ErrorEquationCase
from sinsdata.truth.certified import Block
from sinsref.arithmetic import Arithmetic, BallArithmetic, MpArithmetic, Number
from sinsref.earth import SEMI_MAJOR_AXIS
from sinsref.enclosure import enclosed_states
from sinsref.error_equations import Earth, error_matrix, force_at_displaced_position, ideal_rates
from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic
from sinsref.quaternion import dot
from sinsref.rounding import RoundingTally, UndecidedError, pairs_at, round_balls, round_value
from sinsref.series import Series, SeriesArithmetic
from sinsref.travel import Turning, error_field, motion_rates

#: Rows that are rounded together: what bounds the memory.
BLOCK = 2048
#: Working precision of the first attempt for errors of 1e-6 of the Earth's radius, and factors of the later ones.
WORKING_BITS, ESCALATION = 256, (1, 2, 4)
#: Bits that the balls lose to remainders of Taylor series: the first attempt leaves values within 1e-40.
_GUARD_BITS = 116
#: v_N and v_E in a row.
_HORIZONTAL = (0, 2)
#: Digits and order of the second path. Smaller errors need more digits: those that a difference of solutions cancels.
_DIGITS, _ORDER = 70, 32


def turning(ar: Arithmetic, case: ErrorEquationCase) -> Turning:
    """Return how the horizontal velocity of a case turns, in an arithmetic."""
    return Turning(ar.number(case.turn_rate or 0), case.motion == "great_circle")


def initial_motion(ar: Arithmetic, case: ErrorEquationCase) -> list[Number]:
    """Return the state (v_N, v_H, v_E, H, phi, lambda) of a case at time 0, in an arithmetic."""
    climb = ar.number(case.climb_rate or 0)
    v_north, v_east = horizontal_velocity(ar, case, ar.number(0))
    return [v_north, climb, v_east, *(ar.number(x) for x in (case.height, case.latitude, case.longitude))]


def horizontal_velocity(ar: Arithmetic, case: ErrorEquationCase, time: Number) -> tuple[Number, Number]:
    """Return v_N and v_E: at every time where the heading is known in closed form, else at time 0."""
    speed, zero = ar.number(case.speed), ar.number(0)
    if case.heading is None:
        return (zero, speed) if case.motion == "parallel" else (speed, zero)
    sine, cosine = ar.sin_cos(ar.number(case.heading) + ar.number(case.turn_rate or 0) * time)
    return speed * cosine, speed * sine


def error_equation_blocks(case: ErrorEquationCase, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
    """Yield motion, linear errors, nonlinear errors and their difference at consecutive epochs: 27 columns.

    Parameters
    ----------
    case : ErrorEquationCase
    first, count : int
        Number of the first epoch and number of epochs. The integration starts at epoch 0 whatever they are; the
        pairs do not depend on them.
    tally : RoundingTally
        Counts how values were decided.

    Yields
    ------
    Block
        Columns: v_N, v_H, v_E, H, phi, lambda, a_N, a_H, a_E of the motion; the six errors of the linear theory; the
        six of the nonlinear equations; nonlinear less linear.

    Raises
    ------
    UndecidedError
        If the highest working precision leaves a value undecided.
    sinsref.enclosure.EnclosureError
        If the solution cannot be enclosed.
    """
    states = _states(case, 1, first + count - 1)
    with BallArithmetic(_bits(case, 1)):
        for _ in range(first):
            next(states)
    for start in range(first, first + count, BLOCK):
        index = np.arange(start, min(start + BLOCK, first + count))
        time, time_lo = pairs_at(lambda ar, k: [ar.number(case.interval) * k], index.tolist(), WORKING_BITS, tally)
        with BallArithmetic(_bits(case, 1)) as balls:
            high, low, decided = _rounded([_row(balls, case, state) for state in islice(states, len(index))])
        tally.values += high.size
        tally.raised += int((~decided).sum())
        # A ball proves a zero only where it holds nothing else.
        tally.exact_zeros += int((decided & (high == 0)).sum())
        _settle(case, index, high, low, decided, tally)
        yield Block(index, time[:, 0], time_lo[:, 0], high, low)


def _settle(
    case: ErrorEquationCase,
    index: NDArray[np.int64],
    high: NDArray[np.float64],
    low: NDArray[np.float64],
    decided: NDArray[np.bool_],
    tally: RoundingTally,
) -> None:
    """Decide, in place, what the first attempt has left undecided."""
    if case.turn_rate is not None:
        # A velocity that passes through 0 is exactly 0 there, or never; only its closed form can tell.
        for place, column in enumerate(_HORIZONTAL):
            for row in np.flatnonzero(~decided[:, column]).tolist():

                def component(ar: Arithmetic, place: int = place, epoch: int = int(index[row])) -> Number:
                    return horizontal_velocity(ar, case, ar.number(case.interval) * epoch)[place]

                high[row, column], low[row, column] = round_value(component, tally)
                decided[row, column] = True
    for factor in ESCALATION[1:]:
        rows = np.flatnonzero(~decided.all(axis=1))
        if not rows.size:
            return
        wanted = {int(index[row]) for row in rows}
        with BallArithmetic(_bits(case, factor)) as balls:
            states = enumerate(_states(case, factor, max(wanted)))
            found = _rounded([_row(balls, case, state) for epoch, state in states if epoch in wanted])
        news = ~decided[rows]
        tally.exact_zeros += int((news & found[2] & (found[0] == 0)).sum())
        for old, new in zip((high, low, decided), found, strict=True):
            old[rows] = np.where(news, new, old[rows])
    if not decided.all():
        row, column = np.argwhere(~decided)[0]
        raise UndecidedError(f"case {case.name}, epoch {index[row]}, column {column}: not decided")


def _bits(case: ErrorEquationCase, factor: int) -> int:
    # What the nonlinear errors have beyond the linear ones is quadratic in the errors, and a difference of rates.
    return (WORKING_BITS + 2 * max(0, ceil(log2(1e-6 / case.error_size)))) * factor


def _states(case: ErrorEquationCase, factor: int, count: int) -> Iterator[list[Number]]:
    """Return the states at the epochs 0 ... count; the caller advances it at the working precision `_bits`."""
    bits = _bits(case, factor)
    with PiMonomialArithmetic(bits) as exact:
        errors = [exact.number(x) for x in case.initial_errors]
        initial = [*initial_motion(exact, case), *errors, *[exact.number(0)] * 6]
        state = [x.ball() if isinstance(x, PiMonomial) else x for x in initial]
    with BallArithmetic(bits) as balls:
        field = error_field(Earth.krasovsky(balls), turning(balls, case))
        interval = balls.number(case.interval)
    tolerance = 2.0 ** (_GUARD_BITS - WORKING_BITS * factor)
    return enclosed_states(balls, field, state, interval, count, order=3 * bits // 16, tolerance=tolerance)


def _row(ar: Arithmetic, case: ErrorEquationCase, state: Sequence[Number]) -> list[Number]:
    """Return the 27 values of a row from a state of `error_field`."""
    motion, linear, beyond = state[:6], state[6:12], state[12:]
    force = motion_rates(ar, Earth.krasovsky(ar), turning(ar, case), motion)[1]
    return [*motion, *force, *linear, *(x + y for x, y in zip(linear, beyond, strict=True)), *beyond]


def _rounded(
    rows: Sequence[Sequence[Number]],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    high, low, decided = round_balls([value for row in rows for value in row])
    shape = (len(rows), -1)
    return high.reshape(shape), low.reshape(shape), decided.reshape(shape)


def recomputed_rows(case: ErrorEquationCase, rows: Iterable[int]) -> Iterator[list[Number]]:
    """Yield time and the 27 values of epochs by another path: plain Taylor series in mpmath, without enclosures.

    Motion, linear errors and the state of the displaced computer are integrated side by side, once for all epochs; the
    nonlinear errors are the difference of two states, and the error of the linear theory a difference of that.

    Parameters
    ----------
    case : ErrorEquationCase
    rows : iterable of int
        Numbers of the epochs, increasing. The integration goes no further than the last that is asked for.

    Yields
    ------
    list of 28 mpf
        Time, then the columns of `error_equation_blocks`.
    """
    ar = MpArithmetic(_DIGITS + 2 * max(0, ceil(-log2(case.error_size) * 0.302)))
    earth, turn, interval = Earth.krasovsky(ar), turning(ar, case), ar.number(case.interval)

    def field(series: SeriesArithmetic, state: list[Series]) -> list[Number]:
        motion, linear, computed = state[:6], state[6:12], state[12:]
        rates, force = motion_rates(series, earth, turn, motion)
        return [
            *rates,
            *(dot(row, linear) for row in error_matrix(series, earth, motion, force)),
            *ideal_rates(series, earth, computed, force_at_displaced_position(series, motion, computed, force)),
        ]

    motion = initial_motion(ar, case)
    errors = [ar.number(x) for x in case.initial_errors]
    expansion = _expanded(ar, field, [*motion, *errors, *(x + e for x, e in zip(motion, errors, strict=True))])
    # In intervals, and exact: the steps are the same whatever rows are asked for.
    step, start = Fraction(_plain_step(case) / float(case.interval)), Fraction(0)
    for index in rows:
        while index - start > step:
            expansion = _expanded(ar, field, _summed(ar, expansion, interval, step))
            start += step
        state = _summed(ar, expansion, interval, index - start)
        motion, linear, computed = state[:6], state[6:12], state[12:]
        # At the start the difference is what was given, not what is left of it after adding it to a large number.
        nonlinear = [x - y for x, y in zip(computed, motion, strict=True)] if index else errors
        force = motion_rates(ar, earth, turn, motion)[1]
        beyond = [x - y for x, y in zip(nonlinear, linear, strict=True)]
        yield [interval * index, *motion, *force, *linear, *nonlinear, *beyond]


def _expanded(
    ar: Arithmetic, field: Callable[[SeriesArithmetic, list[Series]], Sequence[Number]], state: Sequence[Number]
) -> list[Series]:
    """Return the Taylor series of the solution through a state."""
    series = SeriesArithmetic(ar)
    unknowns = [series.unknown(x) for x in state]
    for unknown, rate in zip(unknowns, field(series, unknowns), strict=True):
        series.define(unknown, rate if isinstance(rate, Series) else series.constant(rate))
    return unknowns


def _summed(ar: Arithmetic, expansion: Sequence[Series], interval: Number, part: Fraction) -> list[Number]:
    """Return the state a part of an interval after that through which the series were expanded."""
    time = interval * ar.number(part)
    return [series.evaluate(time, _ORDER) for series in expansion]


def _plain_step(case: ErrorEquationCase) -> float:
    """Return a step, s, at which a term of order 32 is below 1e-45: a part of each time in which something changes."""
    speed, turn = abs(float(case.speed)) or 1e-30, abs(float(case.turn_rate or 0)) or 1e-30
    to_the_pole = case.pole_clearance * float(SEMI_MAJOR_AXIS) / speed
    return min(100.0, 0.25 / turn, 0.03 * to_the_pole)
