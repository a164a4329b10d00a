"""Normal numbers that anyone can regenerate, bit for bit: counters through SplitMix64, then Box and Muller's transform.

A number is a function of seed, stream and index alone: no state, so that any part of a stream can be made anywhere.

Sources: G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014, 453-472
(the output function); G. E. P. Box, M. E. Muller, "A note on the generation of random normal deviates", Ann. Math.
Stat. 29 (1958) 610-611.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from sinsref.mast_elementary import Floats, Words, logarithm, sin_cos_of_turns

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


class Stream(IntEnum):
    """What the streams of a seed are for; the number of an index is step times width plus component."""

    ANTENNA_RATE = 1
    RATE_1 = 2
    FORCE_1 = 3
    RATE_2 = 4
    FORCE_2 = 5
    SATELLITES = 6
    START = 7


def mixed(words: Words) -> Words:
    """Return the output function of SplitMix64."""
    z = (words ^ (words >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


def words_of(seed: int, stream: int, first: int, count: int) -> Words:
    """Return 64 random bits each of the indices `first` ... of a stream.

    Parameters
    ----------
    seed : int
        0 ... 2^64 - 1.
    stream : int
        0 ... 2^24 - 1.
    first, count : int
        Indices are below 2^40.
    """
    counters = np.arange(first + 1, first + 1 + count, dtype=np.uint64) + np.uint64(stream << 40)
    return mixed(mixed(np.array([seed], np.uint64)) + counters * _GOLDEN)


def normals(seed: int, stream: int, first: int, count: int) -> Floats:
    """Return normal numbers of mean 0 and variance 1: those of the indices `first` ... of a stream.

    Numbers 2j and 2j+1 are sqrt(-2 ln u_2j) times cosine and sine of 2 pi u_2j+1, with
    u = ((x >> 11) + 0.5) / 2^53 in binary64 of the 64 bits x.

    Parameters
    ----------
    seed, stream, first, count : int
        See `words_of`.
    """
    begin = first - first % 2
    pairs = (first + count + 1) // 2 - begin // 2
    # Nearest binary64: where 53 bits are used up the half rounds to even.
    uniform = (words_of(seed, stream, begin, 2 * pairs) >> np.uint64(11)).astype(np.float64) + 0.5
    radius = np.sqrt(-2.0 * logarithm(uniform[::2] * 2.0**-53))
    # Exact: whole units of 2^-64 turn; a whole turn, 2^64, is none.
    turns = (uniform[1::2] * 2.0).astype(np.uint64) << np.uint64(10)
    sine, cosine = sin_cos_of_turns(turns)
    both = np.stack([radius * cosine, radius * sine], axis=1).reshape(-1)
    return both[first - begin : first - begin + count]
