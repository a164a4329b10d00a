"""Which samples are taken off the grid, by how much, and which never arrive: counter-based, the same for every case.

Draw k of a purpose is the first eight bytes of the SHA-256 of its name and k, so that any program reproduces it; draws
repeat after `PERIOD` samples, so that sample k of a long case is found without counting through those before it.
"""

from __future__ import annotations

from functools import cache
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

__all__ = ["LONGEST_BURST", "LONGEST_SHIFT", "PARTS", "PERIOD", "arrived", "arrived_count", "shifts"]

#: Samples after which the patterns repeat.
PERIOD = 2**16
#: Parts of a sampling interval by which an epoch is shifted.
PARTS = 1024
#: Most parts that an epoch is shifted by, either way: 3/8 of the interval keeps the epochs in order.
LONGEST_SHIFT = 384
#: Samples that one burst of losses drops at most.
LONGEST_BURST = 4
#: One sample in so many starts a burst, which drops 2.5 on average: 2 % altogether.
_BURST_EVERY = 128


def _draws(purpose: str) -> NDArray[np.uint64]:
    """Return the draws 0 ... PERIOD - 1: big-endian, of the text ``"<purpose> <k>"``."""
    heads = b"".join(sha256(f"{purpose} {k}".encode()).digest()[:8] for k in range(PERIOD))
    return np.frombuffer(heads, ">u8").astype(np.uint64)


@cache
def _shift_pattern() -> NDArray[np.int64]:
    return (_draws("nonuniform") % np.uint64(2 * LONGEST_SHIFT + 1)).astype(np.int64) - LONGEST_SHIFT


def shifts(samples: int, epochs: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return by how many parts of an interval epochs lie off the grid: 1024 j_k in t_k = h (k + j_k).

    Parameters
    ----------
    samples : int
        Number n of samples of the motion; the epochs 0 and n lie on the grid.
    epochs : ndarray of int
        Numbers k, from 0 to n.
    """
    inner = (epochs != 0) & (epochs != samples)
    return np.where(inner, _shift_pattern()[epochs % PERIOD], 0)


@cache
def _arrival_pattern() -> NDArray[np.bool_]:
    """Return which of PERIOD consecutive samples arrive; as the draws are, the first does."""
    draws = _draws("dropped")
    lengths = np.where(draws % np.uint64(_BURST_EVERY) == 0, 1 + (draws >> np.uint64(8)) % np.uint64(LONGEST_BURST), 0)
    lost = np.zeros(PERIOD, np.bool_)
    for reach in range(LONGEST_BURST):
        lost |= np.roll(lengths > reach, reach)
    return ~lost


@cache
def _arrival_places() -> NDArray[np.int64]:
    return np.flatnonzero(_arrival_pattern())


def arrived_count(samples: int) -> int:
    """Return how many of the samples 1 ... n arrive, the first and the last among them."""
    periods, rest = divmod(samples - 1, PERIOD)
    return int(periods * len(_arrival_places()) + _arrival_pattern()[:rest].sum()) + 1


def arrived(samples: int, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the numbers, from 1, of samples that arrive.

    Parameters
    ----------
    samples : int
        Number n of samples of the motion.
    rows : ndarray of int
        Which of those that arrive, from 0.
    """
    periods, rest = np.divmod(rows, len(_arrival_places()))
    numbers = 1 + periods * PERIOD + _arrival_places()[rest]
    return np.where(rows == arrived_count(samples) - 1, samples, numbers)
