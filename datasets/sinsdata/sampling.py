"""Cases in memory: what a subject is given and what it is measured against, as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases import CaseError, DualPrecessionCase, EquatorCase, whole_intervals
from sinsdata.certified import Block
from sinsdata.truth import equator_blocks, increment_blocks, precession_blocks
from sinsref.exact import ExactNumber
from sinsref.rounding import RoundingTally

_Array = NDArray[np.float64]


@dataclass(frozen=True)
class SampledMotion:
    """Increments and truth of a dual precession.

    Attributes
    ----------
    case_name : str
    interval : float
        Sampling interval, s.
    samples : int
        Number n of increments.
    angle, angle_lo : ndarray, shape (n, 3)
        Integrals of the body angular rate over each sample, rad: nearest binary64 and rest.
    velocity, velocity_lo : ndarray, shape (n, 3)
        Integrals of the specific force in body axes, m/s.
    checkpoints : ndarray of int, shape (m,)
        Samples at the end of which truth is given; the first is 0.
    time : ndarray, shape (m,)
        Their times, s.
    attitude, attitude_lo : ndarray, shape (m, 4)
        Quaternion, body to inertial.
    velocity_inertial, velocity_inertial_lo, velocity_body, velocity_body_lo : ndarray, shape (m, 3)
        Apparent velocity, m/s.
    """

    case_name: str
    interval: float
    samples: int
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


def _collect(blocks: Iterator[Block]) -> tuple[_Array, _Array, _Array]:
    parts = list(blocks)
    return (
        np.concatenate([part.time for part in parts]),
        np.concatenate([part.high for part in parts]),
        np.concatenate([part.low for part in parts]),
    )


def sample(
    case: DualPrecessionCase,
    refinement: Fraction = Fraction(1),
    checkpoint_interval: ExactNumber | None = None,
) -> SampledMotion:
    """Sample a case at its own interval or at a multiple of it.

    Parameters
    ----------
    case : DualPrecessionCase
    refinement : Fraction, default 1
        The sampling interval in units of the case's.
    checkpoint_interval : ExactNumber, optional
        Distance of the epochs at which truth is given, a whole number of samples, s; every sample by default.

    Raises
    ------
    CaseError
        If the duration is not a whole number of the intervals asked for.
    """
    interval = _multiple(case.interval, refinement)
    samples = _whole(case.duration, interval)
    every = 1 if checkpoint_interval is None else _whole(checkpoint_interval, interval)
    count = _whole(case.duration, _multiple(interval, Fraction(every)))
    # Increments do not depend on initial values: cases that differ in these alone share them.
    still = replace(case, name="increments", initial_attitude=None, initial_velocity=(ExactNumber(0),) * 3)
    high, low = _increments(still, interval)
    time, truth, truth_lo = _collect(precession_blocks(case, RoundingTally(), _multiple(interval, Fraction(every))))
    return SampledMotion(
        case.name,
        float(interval),
        samples,
        high[:, :3].copy(),
        low[:, :3].copy(),
        high[:, 3:].copy(),
        low[:, 3:].copy(),
        np.arange(count + 1) * every,
        time,
        truth[:, :4].copy(),
        truth_lo[:, :4].copy(),
        truth[:, 4:7].copy(),
        truth_lo[:, 4:7].copy(),
        truth[:, 7:].copy(),
        truth_lo[:, 7:].copy(),
    )


@lru_cache(maxsize=8)
def _increments(case: DualPrecessionCase, interval: ExactNumber) -> tuple[_Array, _Array]:
    _, high, low = _collect(increment_blocks(case, RoundingTally(), interval))
    return high, low


def _multiple(number: ExactNumber, factor: Fraction) -> ExactNumber:
    return number if factor == 1 else ExactNumber(f"({number.text})*{factor.numerator}/{factor.denominator}")


def _whole(duration: ExactNumber, interval: ExactNumber) -> int:
    count = whole_intervals(duration, interval)
    if count is None:
        raise CaseError("interval", interval, f"does not divide {duration.text} s into whole samples")
    return count


def equator_truth(case: EquatorCase) -> EquatorTruth:
    """Return the certified errors of a case at its epochs."""
    return EquatorTruth(case.name, *_collect(equator_blocks(case, RoundingTally())))
