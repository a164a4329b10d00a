"""The content hash: its definition written out a second time, independence of how rows arrive, sensitivity."""

from __future__ import annotations

import hashlib
import json
import math
import struct
from itertools import pairwise
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.format.content_hash import PAGE_ROWS, ContentHash, combined

SCHEMA = pa.schema(
    [
        pa.field("case", pa.string(), metadata={"description": "name, é"}),
        pa.field("sample", pa.int64()),
        pa.field("time", pa.float64(), metadata={"unit": "s", "accuracy": "exact"}),
        pa.field("time_exact", pa.string()),
    ]
)
ROWS = 2 * PAGE_ROWS + 77


def _columns() -> dict[str, list[Any]]:
    rng = np.random.default_rng(5)
    times: list[float | None] = list(rng.standard_normal(ROWS) * 10.0 ** rng.integers(-300, 300, ROWS))
    times[3], times[5], times[7], times[PAGE_ROWS], times[PAGE_ROWS + 1] = None, 0.0, -0.0, math.nan, math.inf
    texts = [("", "pi/18", None, "½ π")[k % 4] if k >= PAGE_ROWS else "1/3" for k in range(ROWS)]
    return {
        "case": ["fighter"] * 700 + ["transport, naïve"] * (ROWS - 700),
        "sample": [None if k == ROWS - 1 else (-1) ** k * k for k in range(ROWS)],
        "time": times,
        "time_exact": texts,
    }


def _table(columns: dict[str, list[Any]] | None = None, schema: pa.Schema = SCHEMA) -> pa.Table:
    return pa.table(columns or _columns(), schema=schema)


def _by_the_definition(columns: dict[str, list[Any]], schema: pa.Schema) -> str:
    """Hash value by value, as the definition reads."""
    metadata = [{k.decode(): v.decode() for k, v in (f.metadata or {}).items()} for f in schema]
    fields = [{"metadata": m, "name": f.name, "type": str(f.type)} for m, f in zip(metadata, schema, strict=True)]
    text = json.dumps(fields, ensure_ascii=False, sort_keys=True)
    whole = hashlib.sha256(text.encode()).digest()
    rows = len(columns["case"])
    for start in range(0, rows, 1024):
        page = b""
        for values in columns.values():
            here = values[start : start + 1024]
            nulls = any(value is None for value in here)
            page += b"\1" + bytes(value is not None for value in here) if nulls else b"\0"
            for value in here:
                if values is columns["case"] or values is columns["time_exact"]:
                    encoded = (value or "").encode()
                    page += len(encoded).to_bytes(8, "little") + encoded
                elif values is columns["sample"]:
                    page += (value or 0).to_bytes(8, "little", signed=True)
                elif value is not None and math.isnan(value):
                    page += bytes.fromhex("000000000000f87f")
                else:
                    page += struct.pack("<d", 0.0 if value is None else value)
        whole += hashlib.sha256(page).digest()
    return hashlib.sha256(whole).hexdigest()


def _hash(table: pa.Table) -> str:
    digest = ContentHash(table.schema)
    digest.update(table)
    return digest.hexdigest()


@pytest.mark.parametrize("rows", [0, 1, PAGE_ROWS - 1, PAGE_ROWS, PAGE_ROWS + 1, ROWS])
def test_it_is_the_hash_of_the_definition(rows: int) -> None:
    columns = {name: values[:rows] for name, values in _columns().items()}
    assert _hash(_table(columns)) == _by_the_definition(columns, SCHEMA)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.lists(st.integers(0, ROWS), max_size=8), st.booleans())
def test_it_does_not_depend_on_how_rows_arrive(ends: list[int], batches: bool) -> None:
    table, digest = _table(), ContentHash(SCHEMA)
    cuts = [0, *sorted(ends), ROWS]
    for start, end in pairwise(cuts):
        for part in table.slice(start, end - start).to_batches() if batches else [table.slice(start, end - start)]:
            digest.update(part)
            digest.pages()  # to look is not to touch
    assert digest.hexdigest() == _hash(table)


def test_rows_one_by_one() -> None:
    table, digest = _table(), ContentHash(SCHEMA)
    for row in range(ROWS):
        digest.update(table.slice(row, 1))
    assert digest.hexdigest() == _hash(table)


@pytest.mark.parametrize("cuts", [[PAGE_ROWS], [2 * PAGE_ROWS], [PAGE_ROWS, 2 * PAGE_ROWS]])
def test_parts_hashed_apart_combine(cuts: list[int]) -> None:
    table, pages = _table(), []
    ends = [0, *cuts, ROWS]
    for start, end in pairwise(ends):
        part = ContentHash(SCHEMA)
        part.update(table.slice(start, end - start))
        pages.append(part.pages())
    assert combined(SCHEMA, pages) == _hash(table)
    assert combined(SCHEMA, pages[::-1]) != _hash(table)


def test_every_value_counts() -> None:
    seen = {_hash(_table())}
    changes: list[tuple[str, int, Any]] = [
        ("time", 0, 1.0), ("time", 3, 0.0), ("time", 5, -0.0), ("time", 7, 0.0), ("time", 7, None),
        ("time", PAGE_ROWS, None), ("sample", 0, 1), ("sample", 9, None), ("sample", ROWS - 1, 0),
        ("case", 0, "Fighter"), ("case", 699, "transport, naïve"), ("case", ROWS - 1, None),
        ("time_exact", PAGE_ROWS, None), ("time_exact", PAGE_ROWS + 2, ""),
    ]  # fmt: skip
    for name, row, value in changes:
        columns = _columns()
        columns[name][row] = value
        seen.add(_hash(_table(columns)))
    swapped = _columns()
    swapped["time"][10], swapped["time"][11] = swapped["time"][11], swapped["time"][10]
    seen.add(_hash(_table(swapped)))
    assert len(seen) == len(changes) + 2


def test_text_cannot_slip_into_the_next_row() -> None:
    schema = pa.schema([("a", pa.string()), ("b", pa.string())])
    tables = [{"a": ["xy", "z"], "b": ["", ""]}, {"a": ["x", "yz"], "b": ["", ""]}, {"a": ["x", "y"], "b": ["z", ""]}]
    assert len({_hash(_table(columns, schema)) for columns in tables}) == 3


def test_the_schema_counts() -> None:
    time = SCHEMA.get_field_index("time")
    others = [
        SCHEMA.set(time, pa.field("time", pa.float64(), metadata={"unit": "min", "accuracy": "exact"})),
        SCHEMA.set(time, pa.field("instant", pa.float64(), metadata={"unit": "s", "accuracy": "exact"})),
        SCHEMA.set(time, pa.field("time", pa.float64())),
    ]
    assert len({_hash(_table().cast(SCHEMA)), *(_hash(_table().rename_columns(s.names).cast(s)) for s in others)}) == 4
    # What is said about the table as a whole is not content.
    assert _hash(_table().replace_schema_metadata({"generator": "another"})) == _hash(_table())


@pytest.mark.parametrize("kind", [pa.dictionary(pa.int32(), pa.string()), pa.large_string()])
def test_the_encoding_of_texts_does_not_count(kind: pa.DataType) -> None:
    schema = pa.schema([field.with_type(kind) if field.type == pa.string() else field for field in SCHEMA])
    assert _hash(_table().cast(schema)) == _hash(_table())
    # Batches of one column, each with a dictionary of its own.
    digest = ContentHash(schema)
    for start in range(0, ROWS, 500):
        digest.update(_table().slice(start, 500).cast(schema))
    assert digest.hexdigest() == _hash(_table())


def test_every_nan_is_the_same() -> None:
    quiet, other = (np.array([bits], np.uint64).view(np.float64) for bits in (0x7FF8 << 48, 0xFFF8_0000_0000_0123))
    schema = pa.schema([("x", pa.float64())])
    first, second = (_hash(pa.table([pa.array(x, from_pandas=False)], schema=schema)) for x in (quiet, other))
    assert first == second


def test_what_a_null_hides_does_not_count() -> None:
    schema = pa.schema([("x", pa.float64())])
    validity = pa.py_buffer(b"\x02")
    hidden = [
        pa.Array.from_buffers(pa.float64(), 2, [validity, pa.py_buffer(struct.pack("<2d", value, 7))])
        for value in (3.0, math.nan)
    ]
    assert {_hash(pa.table([x], schema=schema)) for x in hidden} == {_hash(pa.table([[None, 7.0]], schema=schema))}


def test_it_survives_parquet(tmp_path: Any) -> None:
    pq.write_table(_table(), tmp_path / "t.parquet", row_group_size=300, use_dictionary=["case"])
    with pq.ParquetFile(tmp_path / "t.parquet") as file:
        digest = ContentHash(file.schema_arrow)
        for batch in file.iter_batches(batch_size=999):
            digest.update(batch)
    assert digest.hexdigest() == _hash(_table())


def test_other_types_are_refused() -> None:
    with pytest.raises(TypeError, match=r"'day'.*date32"):
        ContentHash(pa.schema([("day", pa.date32())]))
