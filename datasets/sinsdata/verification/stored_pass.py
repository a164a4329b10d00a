"""The rows of a stored dataset, checked in one pass: order, pairs, relations, and some of them computed again."""

from __future__ import annotations

import multiprocessing
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from decimal import Context
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from sinsdata.cases import Case
from sinsdata.format.content_hash import ContentHash
from sinsdata.format.schema import arrow_schema
from sinsdata.generation.digits import DIGITS, decimal_text
from sinsdata.generation.specification import Specification
from sinsdata.generation.tables import Segment, TableGroup
from sinsdata.generation.workers import follow_parent
from sinsdata.truth.irregular import PARTS, shifts
from sinsdata.verification.double_double import DoubleDouble
from sinsdata.verification.invariants import CASE_INVARIANTS, INVARIANTS
from sinsdata.verification.recompute import (
    Wanted,
    Worst,
    computed_columns,
    largest_errors,
    pair_columns,
    python_row,
    rows_to_recompute,
)
from sinsdata.verification.residuals import Invariant, Residual, interval_of
from sinsdata.verification.stored_rows import Places, Stretch, TableCursor, TableLayout, Window, stretches
from sinsref.rounding import RoundingTally

#: Cases that are looked at together in tables with a row per case.
_CASES = 2**10
#: Parts of tables that wait to be computed again, for each worker.
_AHEAD = 4
#: Tables whose times are not whole intervals.
OFF_GRID = ("nonuniform", "nonuniform_truth")
#: Lines of ``digits.csv``: (table, case) -> row -> (column, value).
SpotLines: TypeAlias = Mapping[tuple[str, str], Mapping[int, Sequence[tuple[str, str]]]]
#: Table, or tables, and property -> the largest error; up to 1 is none.
Findings: TypeAlias = dict[tuple[str, str], Worst]


class UnreadableError(ValueError):
    """A table cannot be decoded; the message says which and why."""


class StoredTable:
    """A table on its way through the pass.

    Parameters
    ----------
    dataset, name : str
    group : TableGroup
        The group that makes it.
    paths : sequence of Path
        Its files.
    """

    def __init__(self, dataset: str, name: str, group: TableGroup, paths: Sequence[Path]) -> None:
        self.name = name
        self.layout = TableLayout(name, group)
        self.spot_limit = group.spot_limit
        self.pairs = pair_columns(dataset, name)
        values = [column.name for column in computed_columns(dataset, name) if column.kind == "value"]
        self.values = values
        self.halves = [*(half for name in self.pairs for half in (name, f"{name}_lo")), *values]
        self.digest = ContentHash(arrow_schema(dataset, name))
        self._cursor = TableCursor(paths)
        self._last: pa.RecordBatch | None = None

    @property
    def timed(self) -> bool:
        """Whether its rows belong to epochs; otherwise it has one row a case."""
        return "time" in self.pairs

    def spans(self, parts: Sequence[Stretch]) -> list[tuple[int, int]]:
        """Return first row, and row after the last, of each stretch."""
        return [self.layout.span(part) if self.timed else (0, 1) for part in parts]

    def held(self, parts: tuple[Stretch, ...]) -> tuple[Stretch, ...]:
        """Return the stretches of cases that have rows here."""
        return tuple(part for part in parts if self.layout.rows(part.case)) if self.timed else parts

    def read(self, parts: Sequence[Stretch]) -> pa.RecordBatch:
        """Return the next rows: those of some stretches.

        Raises
        ------
        UnreadableError
            If they cannot be decoded.
        """
        rows = sum(end - first for first, end in self.spans(parts))
        try:
            batch = self._cursor.take(rows)
        except (OSError, ValueError, pa.ArrowException) as error:
            raise UnreadableError(f"{self.name}: {(str(error) or type(error).__name__).splitlines()[0]}") from None
        if batch is None or batch.num_rows != rows:
            raise UnreadableError(f"{self.name}: its files end too early")
        self.digest.update(batch)
        return batch

    def with_first_epoch(self, batch: pa.RecordBatch, parts: Sequence[Stretch]) -> pa.RecordBatch:
        """Return the rows of stretches, with the last row before them where the first goes on from it."""
        last, self._last = self._last, batch.slice(batch.num_rows - 1)
        if last is None or not parts[0].start or not self.layout.per_epoch(parts[0].case):
            return batch
        return pa.concat_batches([last, batch])

    def order(self, batch: pa.RecordBatch, parts: Sequence[Stretch]) -> tuple[NDArray[np.bool_], Residual | None]:
        """Return which rows are those of their case and number, and how far each is from its time."""
        spans = self.spans(parts)
        counts = [end - first for first, end in spans]
        names = {name: code for code, name in enumerate(batch["case"].dictionary.to_pylist())}
        codes = np.repeat([names.get(part.case.name, -2) for part in parts], counts)
        right: NDArray[np.bool_] = batch["case"].indices.fill_null(-1).to_numpy(zero_copy_only=False) == codes
        if not self.timed:
            return right, None
        numbers = [self.layout.epochs(part.case, np.arange(*span)) for part, span in zip(parts, spans, strict=True)]
        epochs = np.concatenate(numbers)
        if "sample" in batch.schema.names:
            right &= batch["sample"].fill_null(-1).to_numpy(zero_copy_only=False) == epochs
        times = epochs.astype(np.float64)
        if self.name in OFF_GRID:
            off = [shifts(part.case.samples, own) for part, own in zip(parts, numbers, strict=True)]
            times += np.concatenate(off) / PARTS  # exact: PARTS is a power of two
        places = Places(np.repeat(np.arange(len(parts)), counts), epochs)
        window = Window(tuple(parts), {self.name: batch})
        (interval,) = window.constants(interval_of, places)
        time = DoubleDouble(times, np.zeros(len(times)))
        return right, Residual(places, window.column(self.name, "time") - interval * time)


class StoredPass:
    """One pass through the tables of a dataset.

    Parameters
    ----------
    specification : Specification
        Of the cases that the dataset holds.
    tables : mapping of str to sequence of Path
        The files of each table that is sound.
    recompute : int, "all" or "few"
        Rows of each case and table to compute again.
    lines : mapping
        Rows of ``digits.csv``.
    progress : callable
        ``progress(rows done, rows in all, what)``.
    workers : int
        Processes that compute rows again; with one, this process does.

    Attributes
    ----------
    findings : dict
    recomputed, spots : dict of str to Worst
        By table.
    """

    def __init__(
        self,
        specification: Specification,
        tables: Mapping[str, Sequence[Path]],
        recompute: Wanted,
        lines: SpotLines,
        progress: Callable[[int, int, str], None],
        workers: int,
    ) -> None:
        self._specification = specification
        self._cases, self._dataset = specification.cases, specification.dataset
        self._groups = [group for group in specification.groups if set(group.tables) & set(tables)]
        self.tables = {
            name: StoredTable(self._dataset, name, group, tables[name])
            for group in self._groups
            for name in group.tables
            if name in tables
        }
        self._recompute, self._lines, self._progress = recompute, lines, progress
        self._workers, self._done = workers, 0
        self._pool: ProcessPoolExecutor | None = None
        self._open: deque[tuple[Future[dict[str, Worst]], int, Case]] = deque()
        self._context = Context(prec=DIGITS)
        self.findings: Findings = defaultdict(Worst)
        self.recomputed: dict[str, Worst] = defaultdict(Worst)
        self.spots: dict[str, Worst] = defaultdict(Worst)

    def run(self) -> None:
        """Read all rows.

        Raises
        ------
        UnreadableError
            If a table cannot be decoded.
        """
        timed = [table for table in self.tables.values() if table.timed]
        others = [table for table in self.tables.values() if not table.timed]
        # What is stored may be anything: numbers that overflow are found, not warned of.
        with np.errstate(all="ignore"), self._processes():
            for start in range(0, len(self._cases), _CASES):
                parts = tuple(Stretch(case, 0, case.samples) for case in self._cases[start : start + _CASES])
                self._look(parts, others, CASE_INVARIANTS.get(self._dataset, ()))
            for parts in stretches(self._cases) if timed else ():
                self._look(parts, timed, INVARIANTS.get(self._dataset, ()))
            self._collect(0)

    @contextmanager
    def _processes(self) -> Iterator[None]:
        if self._workers < 2:
            yield
            return
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(self._workers, mp_context=context, initializer=follow_parent) as self._pool:
            try:
                yield
            finally:
                # Whatever stops the pass, it does not wait for what nobody reads any more.
                self._pool.shutdown(wait=False, cancel_futures=True)

    def _look(self, parts: tuple[Stretch, ...], tables: Sequence[StoredTable], known: Sequence[Invariant]) -> None:
        batches: dict[str, pa.RecordBatch] = {}
        rows: dict[str, pa.RecordBatch] = {}
        held = {table.name: own for table in tables if (own := table.held(parts))}
        for table in tables:
            if table.name not in held:
                continue
            own = held[table.name]
            batches[table.name] = batch = table.read(own)
            self._order(table, batch, own)
            if table.name == "cases":
                self._parameters(batch, own)
            else:
                self._pairs(table, batch, own)
                rows[table.name] = table.with_first_epoch(batch, own) if table.timed else batch
        windows: dict[tuple[Stretch, ...], Window] = {}
        for invariant in known:
            if set(invariant.tables) <= set(rows):
                worst = self.findings[" and ".join(invariant.tables), invariant.name]
                own = held[invariant.tables[0]]
                window = windows.setdefault(own, Window(own, rows))
                for residual in invariant.residuals(window):
                    _take(worst, residual, own)
        self._values(held, batches)

    def _order(self, table: StoredTable, batch: pa.RecordBatch, parts: tuple[Stretch, ...]) -> None:
        right, time = table.order(batch, parts)
        worst = self.findings[table.name, "rows of the cases in order"]
        wrong = np.flatnonzero(~right)
        worst.take(float(len(wrong)) * 2, self._where(table, parts, wrong), len(right))
        if time is not None:
            _take(self.findings[table.name, "times of the epochs"], time, parts)

    def _pairs(self, table: StoredTable, batch: pa.RecordBatch, parts: tuple[Stretch, ...]) -> None:
        """Check that numbers are there, finite, and x_lo at most half a unit in the last place of x."""
        bad = np.zeros(batch.num_rows, bool)
        for name in table.pairs:
            high, low = (batch[half] for half in (name, f"{name}_lo"))
            x, rest = (column.to_numpy(zero_copy_only=False) for column in (high, low))
            sound = np.isfinite(x) & (np.abs(rest) <= np.spacing(np.abs(x)) / 2)
            if table.name == "modes" and high.null_count:
                # Where there are no real modes there is no number; recomputation tells where.
                sound |= ~high.is_valid().to_numpy(zero_copy_only=False) & ~low.is_valid().to_numpy(
                    zero_copy_only=False
                )
            bad |= ~sound
        for name in table.values:
            bad |= ~np.isfinite(batch[name].to_numpy(zero_copy_only=False))
        wrong = np.flatnonzero(bad)
        self.findings[table.name, "finite pairs, x_lo at most half a unit in the last place of x"].take(
            float(len(wrong)) * 2, self._where(table, parts, wrong), len(bad)
        )

    def _parameters(self, batch: pa.RecordBatch, parts: tuple[Stretch, ...]) -> None:
        """Check that the table of the cases is what their exact texts say."""
        group = self._specification.groups[0]
        segments = [Segment(part.case, 0, 1) for part in parts]
        expected = pa.Table.from_batches(
            [made for (made,) in group.batches(self._specification.tier, segments, RoundingTally())]
        )
        stored = pa.Table.from_batches([batch]).cast(expected.schema)
        differing = [name for name in expected.column_names if not stored[name].equals(expected[name])]
        place = f"{parts[0].case.name} ... {parts[-1].case.name}: {', '.join(differing)}"
        self.findings["cases", "numbers are those of the exact texts"].take(2.0 * len(differing), place, len(parts))

    def _values(self, held: Mapping[str, tuple[Stretch, ...]], batches: Mapping[str, pa.RecordBatch]) -> None:
        """Compute rows again and compare the lines of ``digits.csv``."""
        for group in self._groups:
            there = [name for name in group.tables if name in batches]
            if not there:
                continue
            offset, parts = 0, held[there[0]]
            for part, (first, end) in zip(parts, self.tables[there[0]].spans(parts), strict=True):
                rows = rows_to_recompute(group, part.case, self._recompute, first, end)
                places = pa.array([offset + row - first for row in rows], pa.int64())
                stored = {name: batches[name].select(self.tables[name].halves).take(places) for name in there}
                self._compute_again(part.case, rows, stored, (end - first) * len(there))
                for name in there:
                    self._spots(name, part.case, first, end, batches[name], offset)
                offset += end - first

    def _compute_again(self, case: Case, rows: Sequence[int], stored: Mapping[str, pa.RecordBatch], read: int) -> None:
        """Compute rows of a case again, here or on the pool; `read` rows have been read for them."""
        if not rows:
            self._finish({}, read, case)
        elif self._pool is None:
            self._finish(largest_errors(self._dataset, case, rows, stored), read, case)
        else:
            self._open.append((self._pool.submit(largest_errors, self._dataset, case, rows, stored), read, case))
            self._collect(self._workers * _AHEAD)

    def _collect(self, waiting: int) -> None:
        """Wait for what the pool computes until no more than `waiting` parts are open."""
        while len(self._open) > waiting:
            future, read, case = self._open.popleft()
            self._finish(future.result(), read, case)

    def _finish(self, found: Mapping[str, Worst], read: int, case: Case) -> None:
        for table, worst in found.items():
            self.recomputed[table].take(worst.size, worst.where, worst.count)
        self._done += read
        self._progress(self._done, self._specification.all_rows, f"rows of {case.name}")

    def _spots(self, table: str, case: Case, first: int, end: int, batch: pa.RecordBatch, offset: int) -> None:
        for row, lines in self._lines.get((table, case.name), {}).items():
            if first <= row < end:
                stored = python_row(batch, offset + row - first)
                for column, text in lines:
                    same = text == decimal_text(self._context, stored, column)
                    self.spots[table].take(0.0 if same else 2.0, f"{case.name}, row {row}, {column}")

    def _where(self, table: StoredTable, parts: Sequence[Stretch], wrong: NDArray[np.int64]) -> str:
        if not len(wrong):
            return ""
        spans = table.spans(parts)
        ends = np.cumsum([end - first for first, end in spans])
        part = int(np.searchsorted(ends, wrong[0], side="right"))
        return f"{parts[part].case.name}, row {spans[part][1] - int(ends[part] - wrong[0])}"


def _take(worst: Worst, residual: Residual, parts: Sequence[Stretch]) -> None:
    excess = residual.excess
    if len(excess):
        row = int(excess.argmax())
        case = parts[residual.places.stretch[row]].case.name
        worst.take(float(excess[row]), f"{case}, epoch {residual.places.epoch[row]}", len(excess))


def read_lines(text: str) -> SpotLines:
    """Return the lines of ``digits.csv`` by table and case, then by row."""
    lines: dict[tuple[str, str], dict[int, list[tuple[str, str]]]] = {}
    for line in text.splitlines()[1:]:
        table, case, row, column, _, value = line.split(",")
        lines.setdefault((table, case), {}).setdefault(int(row), []).append((column, value))
    return lines
