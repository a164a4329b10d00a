"""The path that computes stored rows again by mpmath, from the case alone."""

from __future__ import annotations

from itertools import pairwise
from math import inf, nan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.generation.tables import Segment, TableGroup, groups_of
from sinsdata.verification.recompute import Worst, errors, pair_columns, python_row, rows_to_recompute
from sinsref.rounding import RoundingTally


def _case(dataset: str, mapping: Any, **changes: Any) -> Case:
    return CASE_CLASSES[dataset].from_mapping(mapping(dataset, **changes))


def _group(rows: int, limit: int = 10**9) -> TableGroup:
    return TableGroup(("t",), lambda case: rows, lambda *given: iter(()), lambda case, rows: iter(()), spot_limit=limit)


# Which rows.


@settings(derandomize=True, deadline=None)
@given(
    rows=st.integers(1, 500),
    wanted=st.integers(0, 600) | st.sampled_from(["all", "few"]),
    limit=st.integers(1, 600),
    cuts=st.lists(st.integers(0, 500)),
)
def test_rows_to_recompute_are_the_ends_and_between(rows: int, wanted: Any, limit: int, cuts: list[int]) -> None:
    """Of all rows, unless few are wanted: those are looked for where they cost little."""
    group: Any = _group(rows, limit)
    case: Any = None
    chosen = list(rows_to_recompute(group, case, wanted, 0, rows))
    reachable = min(rows, limit) if wanted == "few" else rows
    assert len(chosen) == min({"all": rows, "few": 3}.get(wanted, wanted), reachable)
    assert chosen == sorted(set(chosen))
    assert not chosen or chosen[0] == 0
    assert len(chosen) < 2 or chosen[-1] == reachable - 1
    gaps = [b - a for a, b in pairwise(chosen)]
    assert not gaps or max(gaps) - min(gaps) <= 1
    # The same rows whatever the pieces in which they are looked for.
    ends = [0, *sorted({cut for cut in cuts if cut < rows}), rows]
    pieces = [row for first, end in pairwise(ends) for row in rows_to_recompute(group, case, wanted, first, end)]
    assert pieces == chosen


def test_some_groups_have_nothing_to_compute() -> None:
    case: Any = None
    assert list(rows_to_recompute(groups_of("dual_precession")[0], case, "all", 0, 1)) == []


# What counts as an error.


@pytest.mark.parametrize("dataset", ["dual_precession", "equator_errors"])
def test_stored_rows_agree_and_changed_ones_do_not(dataset: str, mapping: Any) -> None:
    case = _case(dataset, mapping)
    for group in groups_of(dataset):
        if group.exact_rows is None:
            continue
        row = group.rows(case) - 1
        (batches,) = group.batches("test", [Segment(case, row, 1)], RoundingTally())
        stored = [python_row(batch, 0) for batch in batches]
        assert max(error for *_, error in errors(dataset, group, case, [row], [stored])) < 1e-32
        for number, table in enumerate(group.tables):
            name = max(pair_columns(dataset, table), key=lambda name: abs(stored[number][name]))
            for changed, least in (
                (stored[number][name] * 1e-29, 9e-30), (nan, inf), (inf, inf), (None, inf),
            ):  # fmt: skip
                row_values = [dict(values) for values in stored]
                low = row_values[number][f"{name}_lo"]
                row_values[number][f"{name}_lo"] = None if changed is None else low + changed
                found = {(t, c): error for _, t, c, error in errors(dataset, group, case, [row], [row_values])}
                assert found.pop((table, name)) >= least
                assert max(found.values()) < 1e-32


def test_modes_that_do_not_exist_must_be_null(mapping: Any) -> None:
    case = _case("equator_errors", mapping, v_east=9000.0)
    group = next(group for group in groups_of("equator_errors") if group.tables == ("modes",))
    (batches,) = group.batches("test", [Segment(case, 0, 1)], RoundingTally())
    stored = python_row(batches[0], 0)
    assert set(stored.values()) == {None, case.name}
    assert max(error for *_, error in errors("equator_errors", group, case, [0], [[stored]])) == 0
    assert max(error for *_, error in errors("equator_errors", group, case, [0], [[{**stored, "mu": 0.0}]])) == inf


def test_the_worst_remembers_where() -> None:
    worst = Worst()
    for size, where in ((1e-3, "a"), (nan, "b"), (5.0, "c")):
        worst.take(size, where)
    assert (worst.size, worst.where, worst.count) == (inf, "b", 3)
