"""From a ball to the pair of binary64 numbers that a dataset stores.

The pair of a value v is ``(x, x_lo)``: x the binary64 nearest to v, x_lo the binary64 nearest to v - x.
Whether the ball decides both is itself decided in exact comparisons; what a ball cannot decide is computed
again, in more bits and with exact zeros known (`sinsref.pi_monomials`).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import arb
from numpy.typing import NDArray

from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic

#: Where v - x is proved smaller than this, relative to v, x_lo is 0: the pair still holds v within 1e-48.
NEGLIGIBLE = 2.0**-160
#: Working precisions, in bits, tried in turn for a value that block evaluation left undecided.
ESCALATION = (256, 1024, 4096)
#: A value that 4096 bits cannot tell from zero and that is proved below this is stored as 0 and counted.
TINY = 1e-300
#: The bits of the largest binary64.
_LARGEST_BITS = np.array(np.finfo(np.float64).max).view(np.int64).item()


class UndecidedError(ArithmeticError):
    """No working precision decided which binary64 is nearest to a value."""


@dataclass
class RoundingTally:
    """How the values of a table were decided.

    Attributes
    ----------
    values : int
        All values.
    raised : int
        Values for which the working precision had to be raised.
    exact_zeros : int
        Values known to be exactly zero, by exact arithmetic and not by a ball.
    bounded_zeros : int
        Values proved smaller than 1e-300 but not known to be zero; stored as 0.
    bounded_ties : int
        Values that 4096 bits do not tell from the middle between two binary64; stored as the even one and its rest.
    """

    values: int = 0
    raised: int = 0
    exact_zeros: int = 0
    bounded_zeros: int = 0
    bounded_ties: int = 0


def round_balls(
    balls: Sequence[Number],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Round balls to pairs of binary64.

    Parameters
    ----------
    balls : sequence of arb
        n values; the working precision must be that at which they were computed.

    Returns
    -------
    high, low : ndarray, shape (n,)
        Nearest binary64, and nearest binary64 to the rest.
    decided : ndarray of bool, shape (n,)
        Whether the ball proves both.
    """
    # Nearest to the midpoint; the checks below then hold for the whole ball.
    heads = list(map(float, balls))
    rests = list(map(operator.sub, balls, heads))
    tails = list(map(float, rests))
    high, low = np.array(heads), np.array(tails)
    left = np.array(list(map(float, map(arb.abs_upper, map(operator.sub, rests, tails)))))
    high, low, decided = decide(high, low, left)
    # A remainder below the smallest binary64 has underflowed to 0 without being 0.
    for place in np.flatnonzero(decided & (left == 0)):
        decided[place] = (rests[place] - float(low[place])).is_zero() or rests[place].abs_upper() < NEGLIGIBLE * abs(
            arb(float(high[place]))
        )
    return high, low, decided


def decide(
    high: NDArray[np.float64], low: NDArray[np.float64], left: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Prove that pairs are correct roundings, from a bound of what they leave.

    Parameters
    ----------
    high, low, left : ndarray, shape (n,)
        The exact values are within `left` of high + low; 0 says that they are equal.

    Returns
    -------
    high, low : ndarray, shape (n,)
        As given, low 0 where it is negligible.
    decided : ndarray of bool, shape (n,)
        Whether high is certainly the nearest binary64 and low the nearest to the rest.
    """
    # v lies within |low| + left of high, and within left of high + low. Twice these, rounded up by one part in 2^48,
    # far more than their few roundings, are compared with the gaps and with 2 NEGLIGIBLE |high|.
    size, rest = np.abs(high), np.abs(low)
    twice_left = left * (2 * (1 + 2.0**-48))
    twice_distance = (rest + left) * (2 * (1 + 2.0**-48))
    head_decided = twice_distance < _gap(size)
    decided = head_decided & (twice_left < _gap(rest))
    negligible = head_decided & (twice_distance < (2 * NEGLIGIBLE) * size)
    if negligible.any():
        low = np.where(negligible, 0.0, low)
        decided |= negligible
    if not left.all():
        decided |= (left == 0) & (head_decided | (low == 0))
    return high, low, decided


def _gap(magnitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of numbers that are not negative to the next binary64 towards zero, exactly; 0 for 0."""
    # Their bits, read as integers, are in order: one less is the neighbour. Zero has none, and one less than the bits
    # of NaN would be a signalling NaN.
    below = magnitude.view(np.int64) - 1
    np.maximum(below, 0, out=below)
    np.minimum(below, _LARGEST_BITS, out=below)
    gap: NDArray[np.float64] = magnitude - below.view(np.float64)
    return gap


def round_value(formula: Callable[[Arithmetic], Number], tally: RoundingTally | None = None) -> tuple[float, float]:
    """Round one value to its pair, raising the working precision until it is decided.

    Parameters
    ----------
    formula : callable
        Takes an arithmetic and returns the value in it.
    tally : RoundingTally, optional
        Counts what happened.

    Returns
    -------
    high, low : float

    Raises
    ------
    UndecidedError
        If 4096 bits do not decide the value, nor prove it below 1e-300, nor at a tie.
    """
    return _escalated(lambda arithmetic, _: [formula(arithmetic)], {0: [0]}, tally or RoundingTally())[0, 0]


def nearest_float(formula: Callable[[Arithmetic], Number]) -> float:
    """Return the binary64 nearest to the value of a formula (the first of `round_value`)."""
    return round_value(formula)[0]


def _escalated(
    formula: Callable[[Arithmetic, int], Sequence[Number]], wanted: Mapping[int, Sequence[int]], tally: RoundingTally
) -> dict[tuple[int, int], tuple[float, float]]:
    """Return the pairs of some values, by index and place, all rows in one precision before the next.

    Parameters
    ----------
    formula : callable
        ``formula(arithmetic, index)`` returns the values of a row.
    wanted : mapping
        The places that are wanted, by index.
    tally : RoundingTally
        Counts what happened.
    """
    pairs: dict[tuple[int, int], tuple[float, float]] = {}
    waiting = dict(wanted)
    for bits in ESCALATION:
        undecided: dict[int, Sequence[int]] = {}
        # One arithmetic for all rows: it keeps what does not depend on time.
        with PiMonomialArithmetic(bits) as arithmetic:
            for index, places in waiting.items():
                values = formula(arithmetic, index)
                for place in places:
                    pair = _pair(values[place], tally)
                    if pair is None and bits == ESCALATION[-1]:
                        pair = _last_resort(values[place], tally)
                    if pair is not None:
                        pairs[index, place] = pair
                if left := [place for place in places if (index, place) not in pairs]:
                    undecided[index] = left
        waiting = undecided
        if not waiting:
            break
    return pairs


def _last_resort(value: Number, tally: RoundingTally) -> tuple[float, float]:
    """Return the pair of a value that the highest precision does not decide: zero, or a tie."""
    ball = value.ball() if isinstance(value, PiMonomial) else value
    if float(ball.abs_upper()) < TINY:
        tally.bounded_zeros += 1
        return 0.0, 0.0
    tie = _tie(ball)
    if tie is None:
        raise UndecidedError(f"{ESCALATION[-1]} bits do not decide the binary64 nearest to {ball.str(20)}")
    tally.bounded_ties += 1
    return tie


def _tie(value: Number) -> tuple[float, float] | None:
    """Return the pair of a value that no precision tells from a tie, to the even neighbour; None where it is no tie.

    Ties come about where an exact value is reached through irrational numbers, as 2 cos(pi/3) is.
    """
    if not value.is_finite():
        return None
    with BallArithmetic(ESCALATION[-1]):
        head = _even(float(value), value)
        rest = value - head
        tail = _even(float(rest), rest)
        left = float((rest - tail).abs_upper())
    ulp_of_tail = float(np.spacing(abs(tail)))
    return (head, tail) if left <= ulp_of_tail * (0.5 + 2.0**-40) else None


def _even(nearest: float, value: Number) -> float:
    """Return, of two neighbours that the value lies between half way, the one with an even significand."""
    side = np.inf if value - nearest > 0 else -np.inf
    other = float(np.nextafter(nearest, side))
    half_way = (arb(nearest) + arb(other)) / 2
    if not value.contains(half_way.mid()) and not (value - half_way).contains(0):
        return nearest
    return nearest if np.float64(nearest).view(np.int64) % 2 == 0 else other


def _pair(value: Number, tally: RoundingTally) -> tuple[float, float] | None:
    """Return the pair of a value, None where the ball does not decide it."""
    if isinstance(value, PiMonomial):
        if value.power == 0:
            exact = value.coefficient
            tally.exact_zeros += not exact
            nearest = float(exact)  # rationals round exactly, ties included
            return nearest, float(exact - Fraction(nearest))
        value = value.ball()
    # As in `round_balls`, but compared as balls and each side by itself: this also decides subnormal numbers
    # and numbers just above a power of two.
    high = float(value)
    rest = value - high
    low = float(rest)
    if not (rest.is_zero() or (high and _rounds_to(high, rest))):
        return None
    if high and abs(rest) < abs(arb(high)) * NEGLIGIBLE:
        return high, 0.0
    left = rest - low
    return (high, low + 0.0) if left.is_zero() or _rounds_to(low, left) else None


def _rounds_to(x: float, rest: arb) -> bool:
    """Return whether x is certainly the binary64 nearest to x + rest."""
    above, below = math.nextafter(x, math.inf) - x, x - math.nextafter(x, -math.inf)
    return bool(-arb(below) < rest * 2 < arb(above))


def pairs_at(
    formula: Callable[[Arithmetic, int], Sequence[Number]],
    indices: Sequence[int],
    bits: int,
    tally: RoundingTally,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Certify a vector formula index by index: first in plain balls, then value by value where those do not decide.

    Parameters
    ----------
    formula : callable
        ``formula(arithmetic, index)`` returns the w values of a row.
    indices : sequence of int
        The n rows.
    bits : int
        Working precision of the first attempt.
    tally : RoundingTally
        Counts what happened.

    Returns
    -------
    high, low : ndarray, shape (n, w)
    """
    with BallArithmetic(bits) as balls:
        rows = [formula(balls, index) for index in indices]
        width = len(rows[0])
        high, low, decided = round_balls([value for row in rows for value in row])
    settle(formula, indices, high.reshape(-1, width), low.reshape(-1, width), decided.reshape(-1, width), tally)
    return high.reshape(-1, width), low.reshape(-1, width)


def settle(
    formula: Callable[[Arithmetic, int], Sequence[Number]],
    indices: Sequence[int],
    high: NDArray[np.float64],
    low: NDArray[np.float64],
    decided: NDArray[np.bool_],
    tally: RoundingTally,
) -> None:
    """Compute again, in place, the values of a table that are not decided yet.

    Parameters
    ----------
    formula : callable
        ``formula(arithmetic, index)`` returns the w values of a row.
    indices : sequence of int
        The n row indices.
    high, low, decided : ndarray, shape (n, w)
        As `round_balls` returns them; changed in place.
    tally : RoundingTally
        Counts what happened.
    """
    tally.values += high.size
    tally.raised += int((~decided).sum())
    rows = {
        indices[row]: (row, np.flatnonzero(~decided[row]).tolist())
        for row in np.flatnonzero(~decided.all(axis=1)).tolist()
    }
    wanted = {index: places for index, (_, places) in rows.items()}
    for (index, place), (head, rest) in _escalated(formula, wanted, tally).items():
        row, _ = rows[index]
        high[row, place], low[row, place] = head, rest
