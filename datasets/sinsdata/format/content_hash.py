"""The content hash of a table: any machine and any library reproduce it from the data, part by part.

The rows of a table are taken in pages of 1024, the last may be shorter. The digest of a page is SHA-256 over its
columns in order, each column whole:

1. the byte 1 if a value of the column is null in this page, and then for each row a byte, 0 where it is null and
   1 elsewhere; otherwise the byte 0 alone;
2. the values. Floats and integers are 8 bytes little endian (int64, binary64), texts are UTF-8 after their length in
   8 bytes little endian. A null stands as zero or as the empty text. Every NaN is 0x7ff8000000000000; 0.0 and -0.0
   are different bytes and different content.

The hash of the table is SHA-256 over the SHA-256 of its schema (JSON with sorted keys: name, type and metadata of each
field) followed by the digests of all pages. A page depends on its own rows only: parts of a table that begin at
multiples of 1024 can be hashed anywhere, in any order, and joined by `combined`.
"""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

#: Rows of a page.
PAGE_ROWS = 1024


class ContentHash:
    """Content hash of consecutive rows, given batch by batch.

    Parameters
    ----------
    schema : pyarrow.Schema
        Columns of floats, integers and texts. Dictionary-encoded texts count as texts.

    Raises
    ------
    TypeError
        If a column is of another type.
    """

    def __init__(self, schema: pa.Schema) -> None:
        self._schema = schema
        self._types = [_canonical_type(field) for field in schema]
        self._pending: list[pa.RecordBatch] = []
        self._pending_rows = 0
        self._pages: list[bytes] = []

    def update(self, rows: pa.RecordBatch | pa.Table) -> None:
        """Add rows.

        Parameters
        ----------
        rows : pyarrow.RecordBatch or pyarrow.Table
            Any number, with the columns of the schema.
        """
        self._pending.extend(rows.to_batches() if isinstance(rows, pa.Table) else [rows])
        self._pending_rows += rows.num_rows
        if self._pending_rows < PAGE_ROWS:
            return
        joined = pa.concat_batches(self._pending) if len(self._pending) > 1 else self._pending[0]
        whole = self._pending_rows - self._pending_rows % PAGE_ROWS
        self._pages.extend(self._digests(joined.slice(0, whole)))
        self._pending_rows -= whole
        self._pending = [joined.slice(whole)] if self._pending_rows else []

    def pages(self) -> bytes:
        """Return the digests of the pages of the rows so far, 32 bytes a page, for `combined`."""
        rest = self._digests(pa.concat_batches(self._pending)) if self._pending_rows else []
        return b"".join([*self._pages, *rest])

    def hexdigest(self) -> str:
        """Return the hash of a table that consists of the rows so far."""
        return combined(self._schema, [self.pages()])

    def _digests(self, rows: pa.RecordBatch) -> list[bytes]:
        digests = [hashlib.sha256() for _ in range(0, rows.num_rows, PAGE_ROWS)]
        for column, kind in zip(rows.columns, self._types, strict=True):
            for digest, parts in zip(digests, _canonical_pages(column, kind), strict=True):
                for part in parts:
                    digest.update(part)
        return [digest.digest() for digest in digests]


def combined(schema: pa.Schema, pages: Iterable[bytes]) -> str:
    """Return the content hash of a table from the page digests of its parts.

    Parameters
    ----------
    schema : pyarrow.Schema
    pages : iterable of bytes
        `ContentHash.pages` of the parts in order; each part but the last has a multiple of 1024 rows.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    description = [
        {
            "name": field.name,
            "type": str(_canonical_type(field)),
            "metadata": {key.decode(): value.decode() for key, value in (field.metadata or {}).items()},
        }
        for field in schema
    ]
    text = json.dumps(description, sort_keys=True, ensure_ascii=False)
    whole = hashlib.sha256(hashlib.sha256(text.encode()).digest())
    for part in pages:
        whole.update(part)
    return whole.hexdigest()


def _canonical_type(field: pa.Field) -> pa.DataType:
    """Return the type as which a column is hashed."""
    kind = field.type.value_type if pa.types.is_dictionary(field.type) else field.type
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return pa.string()
    if pa.types.is_floating(kind):
        return pa.float64()
    if pa.types.is_integer(kind):
        return pa.int64()
    raise TypeError(f"column {field.name!r}: no content hash of values of type {field.type}")


def _canonical_pages(column: pa.Array, kind: pa.DataType) -> Iterator[list[bytes]]:
    """Yield the canonical bytes of a column page by page, in parts."""
    starts = range(0, len(column), PAGE_ROWS)
    present = column.is_valid().to_numpy(zero_copy_only=False).view(np.uint8) if column.null_count else None
    pages = _text_pages(column, starts) if pa.types.is_string(kind) else _number_pages(column.cast(kind), starts)
    for start, values in zip(starts, pages, strict=True):
        there = None if present is None else present[start : start + PAGE_ROWS]
        yield [b"\0", values] if there is None or there.all() else [b"\1", there.tobytes(), values]


def _number_pages(column: pa.Array, starts: Iterable[int]) -> Iterator[bytes]:
    filled = column.fill_null(0) if column.null_count else column
    values: NDArray[Any] = filled.to_numpy(zero_copy_only=False)
    if values.dtype.kind == "f" and (nan := np.isnan(values)).any():
        values = np.where(nan, np.nan, values)
    values = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
    for start in starts:
        yield values[start : start + PAGE_ROWS].tobytes()


def _text_pages(column: pa.Array, starts: Iterable[int]) -> Iterator[bytes]:
    # Few different texts, many rows: each text is encoded once.
    coded = column if pa.types.is_dictionary(column.type) else column.dictionary_encode()
    cells = [struct.pack("<q", len(text)) + text for text in (t.encode() for t in coded.dictionary.to_pylist())]
    cells.append(struct.pack("<q", 0))
    places: NDArray[Any] = coded.indices.cast(pa.int64()).fill_null(len(cells) - 1).to_numpy(zero_copy_only=False)
    for start in starts:
        here = places[start : start + PAGE_ROWS]
        if (here == here[0]).all():
            yield cells[here[0]] * len(here)
        else:
            yield b"".join([cells[place] for place in here.tolist()])
