"""What is asked for, and its parts: a dataset is a list of shards, each a pure function of specification and index."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases import Case
from sinsdata.format.case_columns import texts
from sinsdata.format.manifest import makers
from sinsdata.format.schema import DATASETS, FORMAT
from sinsdata.generation.tables import Segment, TableGroup, groups_of


@dataclass(frozen=True)
class Shard:
    """One file of each table of a group, by name.

    Attributes
    ----------
    group, index : int
        Number of the group, and of the shard in it.
    tables, files : tuple of str
        Tables of the group and their files.
    """

    group: int
    index: int
    tables: tuple[str, ...]
    files: tuple[str, ...]

    @property
    def receipt(self) -> str:
        """Name under which its receipt is kept."""
        return f"{self.files[0]}.receipt"


@dataclass(frozen=True)
class ShardTask:
    """All that a worker needs to know to make a shard.

    Attributes
    ----------
    dataset, tier : str
    tables : tuple of str
        Of the group.
    files : tuple of str
        Their file names.
    segments : tuple of Segment
        The rows.
    """

    dataset: str
    tier: str
    tables: tuple[str, ...]
    files: tuple[str, ...]
    segments: tuple[Segment, ...]

    @property
    def receipt(self) -> str:
        """Name under which its receipt is kept."""
        return f"{self.files[0]}.receipt"

    @property
    def rows(self) -> int:
        """Rows of each of the files."""
        return sum(segment.count for segment in self.segments)


@dataclass(frozen=True)
class Specification:
    """A dataset to be made.

    Attributes
    ----------
    dataset, tier : str
    cases : sequence of Case
        May build its cases as they are asked for.
    tables : tuple of str, or None
        None for all tables.
    """

    dataset: str
    tier: str
    cases: Sequence[Case]
    tables: tuple[str, ...] | None = None

    @cached_property
    def groups(self) -> tuple[TableGroup, ...]:
        """The groups of tables."""
        return groups_of(self.dataset, self.tables)

    @cached_property
    def _walked(self) -> tuple[str, list[NDArray[np.int64]]]:
        """Key and, per group, the numbers of rows before each case: of one walk through the cases, kept small."""
        digest = hashlib.sha256()
        # Versions are part of it: what another version has begun is not gone on with, so that all files of a
        # dataset are of one make.
        about = [
            FORMAT, self.dataset, DATASETS[self.dataset].version, self.tier,
            [(group.tables, group.shard_rows) for group in self.groups],
            list(makers().values()),
        ]  # fmt: skip
        digest.update(json.dumps(about).encode())
        rows = [np.zeros(len(self.cases) + 1, dtype=np.int64) for _ in self.groups]
        for number, case in enumerate(self.cases):
            digest.update(json.dumps([case.name, texts(case)]).encode())
            for counts, group in zip(rows, self.groups, strict=True):
                counts[number + 1] = group.rows(case)
        return digest.hexdigest(), [np.cumsum(counts) for counts in rows]

    @property
    def key(self) -> str:
        """SHA-256 of everything that the files depend on."""
        return self._walked[0]

    def rows(self, group: int) -> int:
        """Return the number of rows of the tables of a group."""
        return int(self._walked[1][group][-1])

    @property
    def all_rows(self) -> int:
        """Rows of all tables together."""
        return sum(self.rows(number) * len(group.tables) for number, group in enumerate(self.groups))

    @cached_property
    def shards(self) -> tuple[Shard, ...]:
        """All shards, without their rows."""
        found = []
        for number, group in enumerate(self.groups):
            count = max(1, -(-self.rows(number) // group.shard_rows))
            for index in range(count):
                suffix = "" if count == 1 else f"-{index:05d}-of-{count:05d}"
                found.append(
                    Shard(number, index, group.tables, tuple(f"{name}{suffix}.parquet" for name in group.tables))
                )
        return tuple(found)

    def task(self, shard: Shard) -> ShardTask:
        """Return all that a worker needs to make a shard."""
        group, rows, starts = self.groups[shard.group], self.rows(shard.group), self._walked[1][shard.group]
        first = shard.index * group.shard_rows
        segments = tuple(self._segments(starts, first, min(first + group.shard_rows, rows)))
        return ShardTask(self.dataset, self.tier, shard.tables, shard.files, segments)

    def _segments(self, starts: NDArray[np.int64], first: int, end: int) -> Iterator[Segment]:
        case = int(np.searchsorted(starts, first, side="right")) - 1
        while first < end:
            stop = min(end, int(starts[case + 1]))
            if stop > first:
                yield Segment(self.cases[case], first - int(starts[case]), stop - first)
            first, case = stop, case + 1
