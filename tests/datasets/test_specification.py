"""A specification: its key changes with all that the files depend on, its shards cover every row once."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rehearsals import SHARD_ROWS, TABLES, cone, ended, make, small_shards, sound
from sinsdata.format.content_hash import PAGE_ROWS
from sinsdata.generation import specification, tables
from sinsdata.generation.specification import Specification
from sinsdata.generation.tables import UnknownTableError
from sinsdata.tiers.grid import GridCases

SWEEP = ("dual_precession", "sweep")


def _key(*cases: Any, dataset: str = "dual_precession", tier: str = "sweep", only: Any = None) -> str:
    return Specification(dataset, tier, cases or [cone(1)], only).key


def test_the_key_changes_with_everything_that_the_files_depend_on(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = [
        _key(),
        _key(tier="paper"),
        _key(only=("truth",)),
        _key(cone(2)),
        _key(cone(1, "other")),
        _key(replace(cone(1), initial_attitude=(1, 0, 0, 0))),
        _key(cone(1), cone(1, "other")),
        _key(cone(1, "other"), cone(1)),
    ]
    with small_shards():
        keys.append(_key())
    with monkeypatch.context() as patched:
        patched.setattr(specification, "makers", lambda: {"sinsbench": "0.0.1"})
        keys.append(_key())
    assert len(set(keys)) == len(keys)
    assert _key() == keys[0]
    assert _key(only=("truth", "cases")) == _key(only=("cases", "truth")) == keys[2]


def test_an_unknown_table() -> None:
    with pytest.raises(UnknownTableError, match="has no table 'trooth'; admissible: cases, "):
        _key(only=("trooth",))


def test_shards_begin_at_pages() -> None:
    """Otherwise the content hash of a table could not be joined from those of its files."""
    for groups in tables.GROUPS.values():
        for group in groups:
            assert group.shard_rows % PAGE_ROWS == 0


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.lists(st.integers(min_value=1, max_value=30), min_size=1, max_size=6))
def test_shards_hold_every_row_once(seconds: list[int]) -> None:
    cases = [cone(duration, f"case-{number}") for number, duration in enumerate(seconds)]
    with small_shards():
        whole = Specification(*SWEEP, cases)
        for number, group in enumerate(whole.groups):
            expected = [(case.name, row) for case in cases for row in range(group.rows(case))]
            tasks = [whole.task(shard) for shard in whole.shards if shard.group == number]
            assert [task.rows for task in tasks[:-1]] == [SHARD_ROWS] * (len(tasks) - 1)
            assert 0 < tasks[-1].rows <= SHARD_ROWS
            found = [
                (segment.case.name, row)
                for task in tasks
                for segment in task.segments
                for row in range(segment.first, segment.first + segment.count)
            ]
            assert found == expected


def test_names_of_files() -> None:
    with small_shards():
        shards = Specification(*SWEEP, [cone(20)], TABLES).shards
    assert sorted(shard.files for shard in shards) == [
        ("cases.parquet",),
        ("increments-00000-of-00002.parquet",),
        ("increments-00001-of-00002.parquet",),
        ("truth-00000-of-00002.parquet",),
        ("truth-00001-of-00002.parquet",),
    ]


def test_some_tables_only(tmp_path: Path) -> None:
    made = make(tmp_path, 1, tables=["truth"])
    assert list(made.manifest["tables"]) == ["cases", "truth"]
    assert sound(made.folder)
    # Another choice is another dataset: it takes the place of the first.
    assert list(make(tmp_path, 1, tables=["increments"]).manifest["tables"]) == ["cases", "increments"]


MEMORY = """
import resource, sys
from pathlib import Path
import sinsdata.truth.certified
from rehearsals import TABLES, cone
from sinsdata.generation.generate import generate

sinsdata.truth.certified.BLOCK = 8192
made = generate("dual_precession", "sweep", [cone(int(sys.argv[2]))], Path(sys.argv[1]), tables=TABLES)
rows = sum(made.manifest["tables"][table]["rows"] for table in ("increments", "truth"))
print(rows, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024))
"""


def test_memory_does_not_grow_with_the_number_of_rows(start_python: Any, tmp_path: Path) -> None:
    """150,000 and 600,000 rows: the peak is that of a row group of 65,536 rows and of one block, here of 8192.

    The 450,000 rows more are 68 MB of bare numbers (15 and 23 columns), and several times that while they are balls.
    Allowed are 34 MB: the footers of the row groups, and what allocators keep between blocks.
    """
    durations = {150_001: 750, 600_001: 3000}
    processes = [start_python(MEMORY, tmp_path / str(rows), duration) for rows, duration in durations.items()]
    (few, small), (many, large) = (map(int, ended(process).split()) for process in processes)
    assert [few, many] == list(durations)
    assert large - small < 34e6


def test_many_cases_are_walked_case_by_case() -> None:
    """Of a grid nothing is held but a number a case and table; a task is built from its own cases."""
    shared = {"precession_ratio": -1, "spin_rate_dual": 0.5, "nutation_dual": 10, "initial_velocity": [10, 0, 0]}
    axes = {"spin_rate": {"from": 1, "to": 3, "count": 20}, "nutation": {"from": "0.1", "to": "0.199", "count": 100}}
    shared |= {"interval": "0.01", "duration": "0.02"}
    with small_shards():
        whole = Specification(*SWEEP, GridCases("dual_precession", shared, axes), TABLES)
        whole.task(whole.shards[0])  # loads what is loaded once, and caches the values of the axes
        del whole.__dict__["_walked"]
        tracemalloc.start()
        try:
            tasks = [whole.task(shard).rows for shard in whole.shards]
            held, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert sum(tasks) == 2000 * (1 + 2 + 3)
    # Three numbers of 8 bytes for each of 2000 cases are 48 kB. A case is some 4 kB, so a task of 1024 cases is 4 MB;
    # all cases at once would be 8 MB.
    assert held < 0.5e6
    assert peak < 6e6
