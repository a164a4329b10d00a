"""Functions of time (`sinsref.profiles`) as columns of binary64 on a grid that starts at 0: the same bits everywhere.

The phase of an oscillation is kept in whole units of 2^-96 turn, so it is as good after hours as at the start, and the
sines come from `sinsref.mast_elementary`. Errors: below two units in the last place of the largest term.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from flint import arb

from sinsref.arithmetic import BallArithmetic
from sinsref.mast_elementary import Floats, polynomial, sin_cos_of_turns
from sinsref.profiles import Oscillation, TimeSum

#: Speed of a phase: what it gains from row to row in units of 2^-64 turn, and units of 2^-96 turn, and its start in
#: units of 2^-64 turn.
Phase: TypeAlias = tuple[int, int, int]


def derivative(terms: TimeSum) -> TimeSum:
    """Return the derivative of a sum."""
    powers = tuple(x * k for k, x in enumerate(terms.powers))[1:] or (terms.powers[0] * 0,)
    parts = (Oscillation(-p.cosine * p.rate, p.sine * p.rate, p.rate, p.phase) for p in terms.oscillations)
    return TimeSum(powers, tuple(parts))


def antiderivative(terms: TimeSum) -> TimeSum:
    """Return the integral from 0 of a sum of balls."""
    powers = [terms.powers[0] * 0, *(x / (k + 1) for k, x in enumerate(terms.powers))]
    parts = []
    for part in terms.oscillations:
        sine, cosine = part.phase.sin_cos()
        parts.append(Oscillation(part.cosine / part.rate, -part.sine / part.rate, part.rate, part.phase))
        powers[0] -= parts[-1].sine * sine + parts[-1].cosine * cosine
    return TimeSum(tuple(powers), tuple(parts))


def phase_of(balls: BallArithmetic, rate: arb, start: arb, spacing: arb) -> Phase:
    """Return the phase of an oscillation on a grid.

    Parameters
    ----------
    balls : BallArithmetic
        Entered, of at least 192 bits.
    rate, start : arb
        rad/s and rad.
    spacing : arb
        Of the grid, s.
    """
    turn = 2 * balls.pi
    gain, begin = _whole(rate * spacing / turn, 96) % 2**96, _whole(start / turn, 64) % 2**64
    return gain >> 32, gain & (2**32 - 1), begin


def _whole(x: arb, bits: int) -> int:
    whole = (x.mid() * arb(2) ** bits + 0.5).floor().mid().unique_fmpz()
    assert whole is not None  # The middle of a ball is one number.
    return int(whole)


@dataclass
class Rows:
    """Consecutive rows of a grid, and what functions on it have in common.

    Attributes
    ----------
    first, count : int
    spacing : float
        s; the nearest binary64.
    """

    first: int
    count: int
    spacing: float
    _known: dict[Phase, tuple[Floats, Floats]] = field(default_factory=dict)

    @property
    def time(self) -> Floats:
        """Time since the start, s, to the last place or so."""
        return np.arange(self.first, self.first + self.count, dtype=np.float64) * self.spacing

    def sin_cos(self, phase: Phase) -> tuple[Floats, Floats]:
        """Return sine and cosine of a phase (`phase_of`)."""
        if phase not in self._known:
            rows = np.arange(self.first, self.first + self.count, dtype=np.uint64)
            turns = rows * np.uint64(phase[0]) + ((rows * np.uint64(phase[1])) >> np.uint64(32)) + np.uint64(phase[2])
            self._known[phase] = sin_cos_of_turns(turns)
        return self._known[phase]


@dataclass(frozen=True)
class GridFunction:
    """A function of time on a grid, moved by a constant time.

    Attributes
    ----------
    powers : tuple of float
        Coefficients of the powers of the time of the row.
    oscillations : tuple of (phase, float, float)
        Phase of the row, and factors of its sine and cosine.
    """

    powers: tuple[float, ...]
    oscillations: tuple[tuple[Phase, float, float], ...]

    @classmethod
    def of(cls, balls: BallArithmetic, terms: TimeSum, spacing: arb, shift: arb | None = None) -> GridFunction:
        """Return a sum of balls as a function of the row.

        Parameters
        ----------
        balls : BallArithmetic
            Entered, of at least 192 bits.
        terms : TimeSum
        spacing : arb
            Of the grid, s.
        shift : arb, optional
            Row k stands for the time ``k * spacing + shift``.
        """
        moved = arb(0) if shift is None else shift
        found: dict[Phase, tuple[arb, arb]] = {}
        for part in terms.oscillations:
            sine, cosine = (moved * part.rate).sin_cos()
            phase = phase_of(balls, part.rate, part.phase, spacing)
            of_sine, of_cosine = found.get(phase, (arb(0), arb(0)))
            found[phase] = (
                of_sine + part.sine * cosine - part.cosine * sine,
                of_cosine + part.sine * sine + part.cosine * cosine,
            )
        powers = _shifted(terms.powers, moved)
        return cls(tuple(map(float, powers)), tuple((phase, float(s), float(c)) for phase, (s, c) in found.items()))

    def values(self, rows: Rows) -> Floats:
        """Return the values at some rows."""
        total = polynomial(self.powers, rows.time) if len(self.powers) > 1 else np.full(rows.count, self.powers[0])
        for phase, of_sine, of_cosine in self.oscillations:
            sine, cosine = rows.sin_cos(phase)
            if of_sine:
                total = total + sine * of_sine
            if of_cosine:
                total = total + cosine * of_cosine
        return total


def _shifted(powers: Sequence[arb], shift: arb) -> list[arb]:
    """Return the coefficients of a polynomial about a shifted origin."""
    moved = list(powers)
    for end in range(len(moved) - 1):
        for k in range(len(moved) - 2, end - 1, -1):
            moved[k] += shift * moved[k + 1]
    return moved
