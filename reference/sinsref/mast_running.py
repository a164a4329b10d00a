"""Attitudes from rates, and sums of increments, over long grids of binary64 without loss of digits.

Rotations of one step come from Magnus's expansion of sixth order over three Gauss nodes. Their products run in chunks
of fixed length: inside a chunk the quaternion carries the rounding errors of its sums along, from chunk to chunk it is
kept in whole units of 2^-112. A step rounds only its own small rotation, so that after 200,000 steps the attitude is
good to a few units of 1e-16. Everything is elementwise arithmetic in fixed order: the same bits on every machine.

Sources: S. Blanes, F. Casas, J. A. Oteo, J. Ros, "The Magnus expansion and some of its applications", Phys. Rep. 470
(2009) 151-238, section 5 (sixth order); T. J. Dekker, Numer. Math. 18 (1971) 224-242 (exact sums).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial, ldexp

import numpy as np

from sinsref.mast_elementary import Floats, polynomial, two_sum
from sinsref.quaternion import Quaternion, Vector, cross, product

#: Gauss nodes of three points in a step of length 1, and their weights.
NODES = ("1/2 - sqrt(15)/10", "1/2", "1/2 + sqrt(15)/10")
WEIGHTS = (5 / 18, 4 / 9, 5 / 18)
#: Steps whose product is computed side by side with that of other chunks.
CHUNK = 256
#: Bits after the point of what is carried from chunk to chunk.
_BITS = 112
#: Bits after the point of sums that are exact.
_SUM_BITS = 56
_ROOT_15 = 3.872983346207417
#: Coefficients of sin(x)/x and of (cos(x) - 1)/x^2 by powers of x^2, enough up to x = 1/4.
_SINC = [(-1.0) ** k / factorial(2 * k + 1) for k in range(8)]
_VERSINE = [(-1.0) ** (k + 1) / factorial(2 * k + 2) for k in range(8)]
#: The largest rotation of a step, rad.
LARGEST_ROTATION = 0.5


def small_rotation(rotation: Vector) -> list[Floats]:
    """Return the quaternion of a rotation vector of at most `LARGEST_ROTATION`, less 1."""
    x, y, z = (0.5 * component for component in rotation)
    square = x * x + y * y + z * z
    sinc = polynomial(_SINC, square)
    return [square * polynomial(_VERSINE, square), x * sinc, y * sinc, z * sinc]


def composed(first: Quaternion, second: Quaternion) -> list[Floats]:
    """Return the product of two quaternions, less 1, of factors that are given less 1."""
    return [x + y + z for x, y, z in zip(product(first, second), first, second, strict=True)]


def magnus_rotation(rates: Sequence[Vector], step: float) -> list[Floats]:
    """Return the rotation vector of a step from the rates at its three Gauss nodes, in axes that turn.

    Parameters
    ----------
    rates : sequence of three Vector
        rad/s.
    step : float
        s.
    """
    # conj(q)' = A conj(q) with A = -w/2; quaternions commute as [a, b] = 2 a x b.
    first, middle, last = ([-0.5 * x for x in rate] for rate in rates)
    a1 = [step * x for x in middle]
    a2 = [_ROOT_15 * step / 3 * (z - x) for x, z in zip(first, last, strict=True)]
    a3 = [10 * step / 3 * (z - 2 * y + x) for x, y, z in zip(first, middle, last, strict=True)]
    c1 = _bracket(a1, a2)
    c2 = [x / -60 for x in _bracket(a1, [2 * x + y for x, y in zip(a3, c1, strict=True)])]
    left = [z - 20 * x - y for x, y, z in zip(a1, a3, c1, strict=True)]
    right = [x + y for x, y in zip(a2, c2, strict=True)]
    return [
        -2 * (x + y / 12 + z / 240) for x, y, z in zip(a1, a3, _bracket(left, right), strict=True)
    ]  # fmt: skip


def _bracket(a: Vector, b: Vector) -> list[Floats]:
    return [2 * x for x in cross(a, b)]


class RunningProduct:
    """Attitudes at the rows of a grid, block by block from the start.

    Parameters
    ----------
    starts : sequence of sequence of float
        The attitudes at the first row: unit quaternions, side by side.
    rests : sequence of sequence of float
        What their binary64 lack.
    """

    def __init__(self, starts: Sequence[Sequence[float]], rests: Sequence[Sequence[float]]) -> None:
        self._starts = [
            [_units(x) + _units(y) for x, y in zip(q, rest, strict=True)] for q, rest in zip(starts, rests, strict=True)
        ]

    def advance(self, steps: Sequence[Sequence[Floats]]) -> list[list[Floats]]:
        """Return the attitudes before each of some steps, and after the last.

        Parameters
        ----------
        steps : sequence of sequence of ndarray
            For each attitude the four components of the quaternions of the steps, less 1. Blocks but the last hold a
            whole number of `CHUNK` steps.
        """
        count = len(steps[0][0])
        chunks = -(-count // CHUNK)
        padded = np.zeros((4, len(steps), chunks * CHUNK))
        for place, quaternion in enumerate(steps):
            padded[:, place, :count] = quaternion
        high, low = _prefixes(padded.reshape(4, len(steps) * chunks, CHUNK).transpose(0, 2, 1).copy())
        found = []
        for place, start in enumerate(self._starts):
            inside = slice(place * chunks, (place + 1) * chunks)
            fronts = np.empty((4, chunks))
            for chunk in range(chunks):
                fronts[:, chunk] = [ldexp(x, -_BITS) for x in start]
                end = place * chunks + chunk
                pairs = zip(high[:, -1, end].tolist(), low[:, -1, end].tolist(), strict=True)
                step = [_units(x) + _units(y) for x, y in pairs]
                start = [x >> _BITS for x in product(start, step)]
            self._starts[place] = start
            values = product([x[:, None] for x in fronts], list(high[:, :-1, inside].transpose(0, 2, 1)))
            # The row after a whole chunk opens the next one; in a chunk that is cut it is a row as any other.
            closing = [ldexp(x, -_BITS) for x in start]
            rows = [np.append(x.reshape(-1), end) for x, end in zip(values, closing, strict=True)]
            found.append([x[: count + 1] for x in rows])
        return found


def _units(x: float) -> int:
    """Return a binary64 in whole units of 2^-112, downwards; exact but for what is smaller."""
    mantissa, exponent = x.as_integer_ratio()
    return (mantissa << _BITS) // exponent


def _prefixes(steps: Floats) -> tuple[Floats, Floats]:
    """Return the products of the first 0, 1, ... steps of chunks, and what their binary64 lack.

    Parameters
    ----------
    steps : ndarray, shape (4, c, m)
        Steps, less 1, of m chunks.
    """
    components, length, chunks = steps.shape
    high, low = np.zeros((components, length + 1, chunks)), np.zeros((components, length + 1, chunks))
    high[0, 0] = 1.0
    for row in range(length):
        # The rest is below 1e-16: times a small step it is nothing.
        change = product(list(high[:, row]), list(steps[:, row]))
        total, error = two_sum(high[:, row], np.stack(change))
        # What is carried stays below the last place, so that it adds up exactly enough.
        high[:, row + 1], low[:, row + 1] = two_sum(total, low[:, row] + error)
    return high, low


class RunningSum:
    """Sums of increments at the rows of a grid, block by block from the start: exact but for 2^-110 a step.

    Parameters
    ----------
    start, rest : float
        The value at the first row, and what its binary64 lacks.
    """

    def __init__(self, start: float, rest: float) -> None:
        self._start, self._whole, self._rest = start, 0, rest

    def advance(self, steps: Floats) -> tuple[Floats, Floats]:
        """Return the sums before each of some steps and after the last, and what their binary64 lack."""
        scaled = np.rint(steps * 2.0**_SUM_BITS)
        whole = self._whole + np.concatenate([[0], np.cumsum(scaled.astype(np.int64))])
        rest = self._rest + np.concatenate([[0.0], np.cumsum(steps - scaled * 2.0**-_SUM_BITS)])
        self._whole, self._rest = int(whole[-1]), float(rest[-1])
        # Whole units of up to 63 bits: in two halves each is a binary64.
        upper = (whole >> 30) << 30
        total, error = two_sum(*(half.astype(np.float64) * 2.0**-_SUM_BITS for half in (upper, whole - upper)))
        total, second = two_sum(np.full_like(total, self._start), total)
        return two_sum(total, second + error + rest)


def step_rotation(rates: Sequence[Vector], step: float, parts: int) -> list[Floats]:
    """Return the quaternions of steps, less 1, each of several parts.

    Parameters
    ----------
    rates : sequence of Vector
        rad/s, at the Gauss nodes of all parts of the steps, in order of time.
    step : float
        s.
    parts : int
        Into which a step is cut.
    """
    whole: list[Floats] = []
    for part in range(parts):
        own = small_rotation(magnus_rotation(rates[3 * part : 3 * part + 3], step / parts))
        whole = composed(whole, own) if whole else own
    return whole
