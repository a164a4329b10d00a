"""The tables of each dataset: how many rows a case has in them, and what fills these rows.

Every row is a pure function of its case and its number there. That makes a table a list of parts that anyone can
compute, in any order, on any machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import ceil, log10
from typing import Any, TypeAlias

import numpy as np
import pyarrow as pa

from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.format.case_columns import parameters
from sinsdata.format.schema import DATASETS, arrow_schema
from sinsdata.tiers import TIERS_WITH_STRATA, stratum_name
from sinsdata.tiers.difficulty import difficulty
from sinsdata.truth import mast_recomputed, mast_tables
from sinsdata.truth.certified import Block, RowFormula, blocks
from sinsdata.truth.conventions import NONUNIFORM_TRUTH, InputTable
from sinsdata.truth.conventions import TABLES as INPUT_TABLES
from sinsdata.truth.error_equations import error_equation_blocks, recomputed_rows
from sinsdata.truth.formulas import (
    WORKING_BITS,
    equator_bits,
    equator_modes,
    equator_state,
    precession_formula,
    transition_formula,
)
from sinsdata.truth.gyroscopic import reference_blocks, sensor_blocks, truth_blocks
from sinsdata.truth.gyroscopic_recomputed import exact_reference, exact_sensors, exact_truth
from sinsref.arithmetic import MpArithmetic, Number
from sinsref.equator import EquatorModel, guard_bits
from sinsref.equator_modes import Modes, NoRealModesError, modes
from sinsref.rounding import RoundingTally


class UnknownTableError(ValueError):
    """A dataset has no such table; the message says which it has."""


#: Rows of a file of a long table.
SHARD_ROWS = 2**18
#: More than there are: a limit that is none.
ANY_ROW = 10**9


@dataclass(frozen=True)
class Segment:
    """Consecutive rows of one case.

    Attributes
    ----------
    case : Case
    first, count : int
        Number of the first row among those of the case, from 0, and number of rows.
    """

    case: Case
    first: int
    count: int


#: ``batches(tier, segments, tally)`` yields the rows of each table of a group, batch by batch.
Batches: TypeAlias = Callable[[str, Sequence[Segment], RoundingTally], Iterator[tuple[pa.RecordBatch, ...]]]

#: ``exact_rows(case, rows)`` yields the values of some rows, see `TableGroup`.
ExactRows: TypeAlias = Callable[[Any, Iterable[int]], Iterator[list[Number] | None]]


@dataclass(frozen=True)
class TableGroup:
    """Tables that share their rows and are computed in one pass.

    Attributes
    ----------
    tables : tuple of str
    rows : callable
        Number of rows of a case.
    batches : callable
        See `Batches`.
    exact_rows : callable, or None
        ``exact_rows(case, rows)`` yields, for increasing numbers of rows, the pair columns of each: those of all tables
        side by side with the time once in front, by mpmath and from the case alone; None where the row has no values.
        Nothing to compute for None.
    shard_rows : int
        Rows of a file. Costly rows make short files: these are the parts that workers share out.
    spot_limit : int
        Rows at the beginning of a case among which to look for a few: less than all where a row costs all before it.
    """

    tables: tuple[str, ...]
    rows: Callable[[Any], int]
    batches: Batches
    exact_rows: ExactRows | None
    shard_rows: int = SHARD_ROWS
    spot_limit: int = ANY_ROW


def _each(exact_row: Callable[[Any, int], list[Number] | None]) -> ExactRows:
    """Return `TableGroup.exact_rows` of rows that cost the same wherever they are."""
    return lambda case, rows: (exact_row(case, row) for row in rows)


def record_batch(dataset: str, table: str, columns: Sequence[Any]) -> pa.RecordBatch:
    """Return columns, in the order of the schema, as a batch."""
    schema = arrow_schema(dataset, table)
    arrays = [pa.array(column, type=field.type) for field, column in zip(schema, columns, strict=True)]
    return pa.RecordBatch.from_arrays(arrays, schema=schema)


def series_batches(
    dataset: str, tables: Sequence[str], blocks_of: Callable[[Any, int, int, RoundingTally], Iterator[Block]]
) -> Batches:
    """Return what fills tables with certified blocks.

    Parameters
    ----------
    dataset : str
    tables : sequence of str
        Their value columns stand side by side in the blocks.
    blocks_of : callable
        ``blocks_of(case, first, count, tally)`` yields the rows `first` ... `first + count - 1` of a case, from 0.
    """
    numbered = [any(column.name == "sample" for column in DATASETS[dataset].tables[table]) for table in tables]
    widths = [
        sum(column.kind == "pair" for column in DATASETS[dataset].tables[table]) - 1 for table in tables
    ]  # fmt: skip
    ends = np.cumsum(widths)

    def batches(tier: str, segments: Sequence[Segment], tally: RoundingTally) -> Iterator[tuple[pa.RecordBatch, ...]]:
        for segment in segments:
            for block in blocks_of(segment.case, segment.first, segment.count, tally):
                case = pa.repeat(segment.case.name, len(block.index))
                yield tuple(
                    record_batch(
                        dataset,
                        table,
                        [
                            case,
                            *([block.index] if with_sample else []),
                            block.time,
                            block.time_lo,
                            *(
                                np.ascontiguousarray(half[:, column])
                                for column in range(end - width, end)
                                for half in (block.high, block.low)
                            ),
                        ],
                    )
                    for table, with_sample, width, end in zip(tables, numbered, widths, ends, strict=True)
                )

    return batches


def _formula_group(
    dataset: str,
    table: str,
    formula: Callable[[Any], RowFormula],
    bits: Callable[[Any], int],
    arithmetic: Callable[[Any], MpArithmetic],
) -> TableGroup:
    def blocks_of(case: Case, first: int, count: int, tally: RoundingTally) -> Iterator[Block]:
        return blocks(formula(case), case.interval, first, count, bits(case), tally)

    def exact_row(case: Case, row: int) -> list[Number]:
        ar = arithmetic(case)
        time = ar.number(case.interval) * row
        return [time, *formula(case)(ar, time)]

    batches = series_batches(dataset, [table], blocks_of)
    return TableGroup((table,), lambda case: case.samples + 1, batches, _each(exact_row))


def _equator_arithmetic(case: EquatorCase) -> MpArithmetic:
    # 80 digits leave 1e-30 of the smallest value; on top comes what phases of many turns and cancelling series lose.
    ar = MpArithmetic(30)
    model = EquatorModel.at(ar, case.v_east, case.height)
    return MpArithmetic(80 + ceil(guard_bits(ar, model, ar.number(case.duration)) * log10(2)))


def _precession_arithmetic(case: DualPrecessionCase) -> MpArithmetic:
    turns = abs(float(case.spin_rate) * float(case.duration)) * (1 + abs(float(case.precession_ratio)))
    return MpArithmetic(80 + ceil(log10(1 + turns)))


def _rank(dataset: str, tier: str, case: Case) -> dict[str, Any]:
    """Return stratum and difficulty of a case, in tiers that have strata."""
    stratum = stratum_name(dataset, case.name) if tier in TIERS_WITH_STRATA else None
    measured = stratum is not None and isinstance(case, EquatorCase | DualPrecessionCase)
    known = difficulty(case) if measured else None
    return {"stratum": stratum, **(asdict(known) if known is not None else {})}


def _case_cells(dataset: str, tier: str, case: Case) -> Iterator[Any]:
    values = {"case": case.name, **_rank(dataset, tier, case), **parameters(case)}
    for column in DATASETS[dataset].tables["cases"]:
        value = values.get(column.name)
        if column.kind != "parameter":
            yield value
        else:
            yield from (None, None) if value is None else (float(value), value.text)


def _cases_group(dataset: str) -> TableGroup:
    def batches(tier: str, segments: Sequence[Segment], tally: RoundingTally) -> Iterator[tuple[pa.RecordBatch, ...]]:
        rows = [list(_case_cells(dataset, tier, segment.case)) for segment in segments]
        yield (record_batch(dataset, "cases", list(zip(*rows, strict=True))),)

    return TableGroup(("cases",), lambda case: 1, batches, None, shard_rows=2**14)


def _modes_batches(
    tier: str, segments: Sequence[Segment], tally: RoundingTally
) -> Iterator[tuple[pa.RecordBatch, ...]]:
    rows = []
    for segment in segments:
        assert isinstance(segment.case, EquatorCase)
        pairs = equator_modes(segment.case, tally).values()
        rows.append([segment.case.name, *(part for pair in pairs for part in (pair or (None, None)))])
    yield (record_batch("equator_errors", "modes", list(zip(*rows, strict=True))),)


def _exact_modes(case: EquatorCase, row: int) -> list[Number] | None:
    ar = _equator_arithmetic(case)
    try:
        constants = modes(ar, EquatorModel.at(ar, case.v_east, case.height))
    except NoRealModesError:
        return None
    return [getattr(constants, name) for name in Modes.__dataclass_fields__]


def _equator_group(table: str, formula: Callable[[EquatorCase], RowFormula]) -> TableGroup:
    return _formula_group("equator_errors", table, formula, equator_bits, _equator_arithmetic)


def _input_group(table: InputTable) -> TableGroup:
    return TableGroup(
        (table.name,),
        table.rows,
        series_batches("dual_precession", [table.name], table.blocks),
        _each(lambda case, row: table.exact_row(_precession_arithmetic(case), case, row)),
    )


def _gyro_group(
    table: str,
    blocks_of: Callable[[Any, int, int, RoundingTally], Iterator[Block]],
    exact_rows: ExactRows,
    spot_limit: int = ANY_ROW,
) -> TableGroup:
    batches = series_batches("gyro_systems", [table], blocks_of)
    return TableGroup((table,), lambda case: case.samples + 1, batches, exact_rows, 2**16, spot_limit)


def _mast_group(table: str, rows: Callable[[Any], int] = mast_tables.own_epochs) -> TableGroup:
    """Return what makes a table of values without rests."""
    names = {"sensors": "sensor", "satellites": "satellite", "measurements": "measurement", "truth": "truth"}
    blocks_of = getattr(mast_tables, f"{names[table]}_blocks")
    with_sample = table == "sensors"

    def batches(tier: str, segments: Sequence[Segment], tally: RoundingTally) -> Iterator[tuple[pa.RecordBatch, ...]]:
        for segment in segments:
            for block in blocks_of(segment.case, segment.first, segment.count, tally):
                index = [block.index] if with_sample else []
                front = [pa.repeat(segment.case.name, len(block.index)), *index, block.time, block.time_lo]
                yield (record_batch("mast_antenna", table, [*front, *np.ascontiguousarray(block.high.T)]),)

    # Each row from the one before: late rows cost all before them.
    return TableGroup((table,), rows, batches, getattr(mast_recomputed, f"exact_{table}"), spot_limit=16)


_INTEGRATED = ("motion", "truth", "nonlinear", "linearisation")

#: Dataset -> its groups of tables, ``cases`` first.
GROUPS: Mapping[str, tuple[TableGroup, ...]] = {
    "equator_errors": (
        _cases_group("equator_errors"),
        TableGroup(("modes",), lambda case: 1, _modes_batches, _each(_exact_modes), shard_rows=2**14),
        _equator_group("truth", equator_state),
        _equator_group("transition", transition_formula),
    ),
    "dual_precession": (
        _cases_group("dual_precession"),
        _formula_group(
            "dual_precession", "truth", precession_formula, lambda case: WORKING_BITS, _precession_arithmetic
        ),
        *map(_input_group, INPUT_TABLES.values()),
        _input_group(NONUNIFORM_TRUTH),
    ),
    "error_equations": (
        _cases_group("error_equations"),
        # One integration fills all four tables, each row from the one before: a case that is cut costs twice.
        TableGroup(
            _INTEGRATED,
            lambda case: case.samples + 1,
            series_batches("error_equations", _INTEGRATED, error_equation_blocks),
            recomputed_rows,
            shard_rows=2**10,
            spot_limit=4,
        ),
    ),
    "gyro_systems": (
        _cases_group("gyro_systems"),
        _gyro_group("sensors", sensor_blocks, exact_sensors),
        _gyro_group("truth", truth_blocks, exact_truth),
        # Each row from the one before: a case that is cut costs more, and its late rows cost all before them.
        _gyro_group("reference", reference_blocks, exact_reference, spot_limit=64),
    ),
    "mast_antenna": (
        _cases_group("mast_antenna"),
        _mast_group("sensors", mast_tables.own_samples),
        _mast_group("satellites"),
        _mast_group("measurements", lambda case: case.samples + 1),
        _mast_group("truth"),
    ),
}


def groups_of(dataset: str, tables: Sequence[str] | None = None) -> tuple[TableGroup, ...]:
    """Return the groups that make some tables of a dataset, ``cases`` always among them.

    Parameters
    ----------
    dataset : str
    tables : sequence of str, optional
        All by default. Tables of one group come together.

    Raises
    ------
    UnknownTableError
        If the dataset has no such table.
    """
    known = [table for group in GROUPS[dataset] for table in group.tables]
    for table in tables or ():
        if table not in known:
            raise UnknownTableError(f"{dataset} has no table {table!r}; admissible: {', '.join(known)}")
    wanted = {"cases", *(known if tables is None else tables)}
    return tuple(group for group in GROUPS[dataset] if wanted & set(group.tables))
