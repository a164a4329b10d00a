"""The rows of a stored dataset in one pass: all tables side by side, window by window, in flat memory.

A window holds consecutive epochs of one case or of several whole cases. Tables with a row per epoch give a stretch its
first epoch too, also where it goes on from the window before; tables with a row per sample give the samples that end in
it. So row by row the samples stand beside the epochs at their start and at their end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from sinsdata.cases import Case
from sinsdata.generation.tables import TableGroup
from sinsdata.truth.irregular import arrived, arrived_count
from sinsdata.verification.double_double import DoubleDouble

#: Epochs of a window.
WINDOW = 2**14
#: Cases of a window.
_CASES = 2**10


@dataclass(frozen=True)
class Stretch:
    """Consecutive epochs of one case.

    Attributes
    ----------
    case : Case
    start, end : int
        Numbers of the first and the last epoch.
    """

    case: Case
    start: int
    end: int


def stretches(cases: Sequence[Case]) -> Iterator[tuple[Stretch, ...]]:
    """Yield the stretches of one window after the other."""
    waiting: list[Stretch] = []
    room = WINDOW
    for case in cases:
        start = 0
        while start < case.samples:
            end = min(case.samples, start + room)
            waiting.append(Stretch(case, start, end))
            room -= end - start
            start = end
            if room == 0 or len(waiting) == _CASES:
                yield tuple(waiting)
                waiting, room = [], WINDOW
    if waiting:
        yield tuple(waiting)


def _arrived_until(samples: int, sample: int) -> int:
    """Return how many of the samples 1 ... `sample` arrive, of n in all."""
    return arrived_count(samples) if sample == samples else arrived_count(sample + 1) - 1


def arrivals(samples: int, start: int, end: int) -> NDArray[np.int64]:
    """Return which of the samples start + 1 ... `end` arrive, of n in all."""
    return arrived(samples, np.arange(_arrived_until(samples, start), _arrived_until(samples, end)))


class TableLayout:
    """Which rows of a table belong to which epochs.

    Parameters
    ----------
    name : str
        Of the table.
    group : TableGroup
        The group that makes it.
    """

    def __init__(self, name: str, group: TableGroup) -> None:
        self.name = name
        self.rows = group.rows

    def per_epoch(self, case: Case) -> bool:
        """Return whether the table has a row for the start of a case."""
        return self.rows(case) > case.samples

    def until(self, case: Case, epoch: int) -> int:
        """Return how many rows of a case belong to the epochs 0 ... `epoch`: none where it has no rows here."""
        if not self.rows(case):
            return 0
        if self.name == "dropped":
            return _arrived_until(case.samples, epoch)
        return epoch + self.per_epoch(case)

    def span(self, stretch: Stretch) -> tuple[int, int]:
        """Return the numbers of the first row of a stretch that was in none before, and of the row after its last."""
        first = self.until(stretch.case, stretch.start) if stretch.start else 0
        return first, self.until(stretch.case, stretch.end)

    def epochs(self, case: Case, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the epoch, or the number of the sample, of rows counted from 0."""
        if self.name == "dropped":
            return arrived(case.samples, rows)
        return rows + (not self.per_epoch(case))


class TableCursor:
    """Reads a table from its files, in order and once.

    Parameters
    ----------
    paths : sequence of Path
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self._batches = _batches(paths)
        self._waiting: list[pa.RecordBatch] = []
        self._ready = 0

    def take(self, rows: int) -> pa.RecordBatch | None:
        """Return the next rows; fewer at the end of the table, None after it."""
        while self._ready < rows and (batch := next(self._batches, None)) is not None:
            self._waiting.append(batch)
            self._ready += batch.num_rows
        if not self._ready:
            return None
        joined = pa.concat_batches(self._waiting) if len(self._waiting) > 1 else self._waiting[0]
        taken = joined.slice(0, rows)
        self._ready -= taken.num_rows
        self._waiting = [joined.slice(rows)] if self._ready else []
        return taken


def _batches(paths: Sequence[Path]) -> Iterator[pa.RecordBatch]:
    for path in paths:
        # Few names, many rows: as a dictionary they cost next to nothing.
        with pq.ParquetFile(path, read_dictionary=["case"]) as file:
            yield from file.iter_batches(batch_size=WINDOW)


@dataclass(frozen=True)
class Places:
    """Where rows are: the number of the stretch in its window, and the epoch."""

    stretch: NDArray[np.int64]
    epoch: NDArray[np.int64]

    def __getitem__(self, rows: NDArray[np.int64] | NDArray[np.bool_]) -> Places:
        return Places(self.stretch[rows], self.epoch[rows])


class Window:
    """Rows of several tables for the same stretches.

    Parameters
    ----------
    parts : tuple of Stretch
    tables : mapping of str to RecordBatch
        Those per epoch with the first epoch of each stretch.
    """

    def __init__(self, parts: tuple[Stretch, ...], tables: Mapping[str, pa.RecordBatch]) -> None:
        self.parts = parts
        self.tables = tables

    def _places(self, first: int) -> Places:
        starts = np.array([part.start + first for part in self.parts])
        counts = np.array([part.end - part.start + 1 - first for part in self.parts])
        stretch = np.repeat(np.arange(len(self.parts)), counts)
        offsets = np.cumsum(counts) - counts
        return Places(stretch, np.arange(counts.sum()) - np.repeat(offsets - starts, counts))

    @cached_property
    def epochs(self) -> Places:
        """The rows of tables with a row per epoch."""
        return self._places(0)

    @cached_property
    def samples(self) -> Places:
        """The rows of tables with a row per sample."""
        return self._places(1)

    @cached_property
    def after(self) -> NDArray[np.int64]:
        """For each sample the row of the epoch at its end."""
        first = np.diff(self.epochs.stretch, prepend=-1) != 0
        return np.flatnonzero(~first)

    @property
    def before(self) -> NDArray[np.int64]:
        """For each sample the row of the epoch at its start."""
        return self.after - 1

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """Rows of the epochs 0."""
        return np.flatnonzero(self.epochs.epoch == 0)

    def column(self, table: str, name: str) -> DoubleDouble:
        """Return a column: a pair, or a value without a rest."""
        batch = self.tables[table]
        high = _floats(batch[name])
        rest = f"{name}_lo"
        return DoubleDouble(high, _floats(batch[rest]) if rest in batch.schema.names else np.zeros_like(high))

    def vector(self, table: str, stem: str, components: str = "xyz") -> list[DoubleDouble]:
        """Return the columns ``<stem>_<component>``."""
        return [self.column(table, f"{stem}_{c}") for c in components]

    def constants(self, of_case: Callable[[Any], DoubleDouble], places: Places) -> list[DoubleDouble]:
        """Return constants of the cases, each as a column beside the rows of `places`.

        Parameters
        ----------
        of_case : callable
            ``of_case(case)`` returns them as one array.
        places : Places
        """
        known = [of_case(part.case) for part in self.parts]
        high, low, majorant = (
            np.array([getattr(values, half) for values in known])[places.stretch].T
            for half in ("high", "low", "majorant")
        )
        return [DoubleDouble(*map(np.ascontiguousarray, halves)) for halves in zip(high, low, majorant, strict=True)]


def _floats(column: pa.Array) -> NDArray[np.float64]:
    values: NDArray[np.float64] = column.to_numpy(zero_copy_only=False)
    return values
