"""Cases in memory: what a subject is given and what it is measured against, as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases import CaseError, DualPrecessionCase, EquatorCase, whole_intervals
from sinsdata.truth.certified import Block, blocks
from sinsdata.truth.conventions import TABLES, Convention, known_convention, nonuniform_time
from sinsdata.truth.formulas import WORKING_BITS, equator_blocks, precession_formula
from sinsref.arithmetic import Arithmetic, Number
from sinsref.exact import ExactNumber
from sinsref.rounding import RoundingTally, pairs_at, round_value

_Array = NDArray[np.float64]


@dataclass(frozen=True)
class SampledMotion:
    """Inputs of a dual precession in one convention, and truth.

    Attributes
    ----------
    case_name : str
    convention : Convention
        What `first` and `second` mean.
    interval, interval_lo : float
        Sampling interval, s: nearest binary64 and rest.
    samples : int
        Number n of samples.
    ends : ndarray of int, shape (r+1,)
        Numbers of the samples that the r input rows end with, 0 before them: 0 ... n unless some are dropped.
    end_times : ndarray, shape (r+1,)
        Their times, s.
    first, first_lo, second, second_lo : ndarray, shape (r, 3) or (r+1, 3)
        The two vectors that a subject is given and their rests; r+1 rows where the convention has one for the start.
    angle, angle_lo : ndarray, shape (n, 3)
        Integrals of the body angular rate over every sample, rad, whatever the convention.
    velocity, velocity_lo : ndarray, shape (n, 3)
        Integrals of the specific force in body axes, m/s.
    checkpoints : ndarray of int, shape (m,)
        Samples at the end of which truth is given, equidistant; the first is 0.
    time : ndarray, shape (m,)
        Their times, s.
    attitude, attitude_lo : ndarray, shape (m, 4)
        Quaternion, body to inertial.
    velocity_inertial, velocity_inertial_lo, velocity_body, velocity_body_lo : ndarray, shape (m, 3)
        Apparent velocity, m/s.
    """

    case_name: str
    convention: Convention
    interval: float
    interval_lo: float
    samples: int
    ends: NDArray[np.int64]
    end_times: _Array
    first: _Array
    first_lo: _Array
    second: _Array
    second_lo: _Array
    angle: _Array
    angle_lo: _Array
    velocity: _Array
    velocity_lo: _Array
    checkpoints: NDArray[np.int64]
    time: _Array
    attitude: _Array
    attitude_lo: _Array
    velocity_inertial: _Array
    velocity_inertial_lo: _Array
    velocity_body: _Array
    velocity_body_lo: _Array


@dataclass(frozen=True)
class EquatorTruth:
    """Errors along the equator.

    Attributes
    ----------
    case_name : str
    time : ndarray, shape (n,)
        s.
    state, state_lo : ndarray, shape (n, 6)
        dv_N, dv_H, dv_E (m/s), dH (m), dphi, dlambda (rad): nearest binary64 and rest.
    """

    case_name: str
    time: _Array
    state: _Array
    state_lo: _Array


def _collect(parts: Iterable[Block]) -> Block:
    columns = zip(*((part.index, part.time, part.time_lo, part.high, part.low) for part in parts), strict=True)
    return Block(*map(np.concatenate, columns))


def sample(
    case: DualPrecessionCase,
    refinement: Fraction = Fraction(1),
    checkpoint_interval: ExactNumber | None = None,
    convention: str = "increments",
) -> SampledMotion:
    """Sample a case at its own interval or at a multiple of it.

    Parameters
    ----------
    case : DualPrecessionCase
    refinement : Fraction, default 1
        The sampling interval in units of the case's.
    checkpoint_interval : ExactNumber, optional
        Distance of the epochs at which truth is given, a whole number of samples, s; every sample by default. Where
        samples lie off the grid, so does the truth at their ends.
    convention : str, default "increments"
        A name of `sinsdata.truth.conventions.CONVENTIONS`.

    Raises
    ------
    CaseError
        If the duration is not a whole number of the intervals asked for.
    ValueError
        If there is no such convention.
    """
    wanted = known_convention(convention)
    interval = _multiple(case.interval, refinement)
    samples = _whole(case.duration, interval)
    every = 1 if checkpoint_interval is None else _whole(checkpoint_interval, interval)
    checkpoints = np.arange(_whole(case.duration, _multiple(interval, Fraction(every))) + 1) * every
    # Inputs do not depend on initial values: cases that differ in these alone share them.
    still = replace(
        case, name="inputs", interval=interval, initial_attitude=None, initial_velocity=(ExactNumber(0),) * 3
    )
    (rows, first, first_lo), (_, second, second_lo) = (
        _vector(still, *place) for place in (wanted.first, wanted.second)
    )
    # The start has a row of its own where values are those of instants.
    own_start = int(rows.index[0] == 0)
    ends, end_times = np.append([0], rows.index[own_start:]), np.append([0.0], rows.time[own_start:])
    scattered = convention == "nonuniform"
    whole = "nonuniform" if scattered else "increments"
    (_, angle, angle_lo), (_, velocity, velocity_lo) = (_vector(still, whole, stem) for stem in TABLES[whole].vectors)
    truth = _truth(replace(case, interval=interval), checkpoints, scattered)
    attitude, inertial, body = slice(0, 4), slice(4, 7), slice(7, 10)
    return SampledMotion(
        case.name,
        wanted,
        *round_value(lambda ar: ar.number(interval)),
        samples,
        ends,
        end_times,
        first,
        first_lo,
        second,
        second_lo,
        angle,
        angle_lo,
        velocity,
        velocity_lo,
        checkpoints,
        truth.time,
        *(half[:, part].copy() for part in (attitude, inertial, body) for half in (truth.high, truth.low)),
    )


@lru_cache(maxsize=12)  # a ladder of six intervals, in a convention and in increments
def _inputs(case: DualPrecessionCase, table: str) -> Block:
    """Return all rows of an input table."""
    return _collect(TABLES[table].blocks(case, 0, TABLES[table].rows(case), RoundingTally()))


def _vector(case: DualPrecessionCase, table: str, stem: str) -> tuple[Block, _Array, _Array]:
    """Return an input table, and one of its two vectors with its rests."""
    rows = _inputs(case, table)
    first = rows.high.shape[1] - 6 + 3 * TABLES[table].vectors.index(stem)
    return rows, rows.high[:, first : first + 3].copy(), rows.low[:, first : first + 3].copy()


def _truth(case: DualPrecessionCase, epochs: NDArray[np.int64], scattered: bool) -> Block:
    """Return attitude and apparent velocity at the ends of some equidistant samples, the first of them the start."""
    formula, tally = precession_formula(case), RoundingTally()
    if not scattered:
        spacing = _multiple(case.interval, Fraction(int(epochs[1])))
        return _collect(blocks(formula, spacing, 0, len(epochs), WORKING_BITS, tally))

    def at(ar: Arithmetic, epoch: int) -> Sequence[Number]:
        time = nonuniform_time(case, ar, epoch)
        return [time, *formula(ar, time)]

    high, low = pairs_at(at, epochs.tolist(), WORKING_BITS, tally)
    return Block(epochs, high[:, 0], low[:, 0], high[:, 1:], low[:, 1:])


def _multiple(number: ExactNumber, factor: Fraction) -> ExactNumber:
    return number if factor == 1 else ExactNumber(f"({number.text})*{factor.numerator}/{factor.denominator}")


def _whole(duration: ExactNumber, interval: ExactNumber) -> int:
    count = whole_intervals(duration, interval)
    if count is None:
        raise CaseError("interval", interval, f"does not divide {duration.text} s into whole samples")
    return count


def equator_truth(case: EquatorCase) -> EquatorTruth:
    """Return the certified errors of a case at its epochs."""
    rows = _collect(equator_blocks(case, RoundingTally()))
    return EquatorTruth(case.name, rows.time, rows.high, rows.low)
