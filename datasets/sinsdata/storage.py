"""Parquet files, hashes, and folders that are either whole or not there.

Two hashes go with each table. SHA-256 of the file finds flipped bytes; it depends on the version of the
library that wrote the file. The content hash covers the canonical bytes of schema and columns: any machine
and any library reproduce it from the data.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import struct
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq


class ContentHash:
    """SHA-256 over schema and values of a table, row group by row group.

    The bytes hashed: the schema as JSON with sorted keys (name, type, metadata of each field); then, for
    every column on its own, all values in order: floats and integers as 8 bytes little endian (each NaN as
    0x7ff8000000000000), texts as UTF-8 after their length in 8 bytes, nulls as the byte 0 and present
    values after the byte 1. The digests of the columns are hashed after that of the schema.

    Parameters
    ----------
    schema : pyarrow.Schema
    """

    def __init__(self, schema: pa.Schema) -> None:
        description = [
            {
                "name": field.name,
                "type": str(field.type),
                "metadata": {k.decode(): v.decode() for k, v in (field.metadata or {}).items()},
            }
            for field in schema
        ]
        self._schema = json.dumps(description, sort_keys=True, ensure_ascii=False).encode()
        self._columns = [hashlib.sha256() for _ in schema]

    def update(self, batch: pa.RecordBatch | pa.Table) -> None:
        """Add rows."""
        for digest, column in zip(self._columns, batch.columns, strict=True):
            digest.update(_canonical(column))

    def hexdigest(self) -> str:
        """Return the hash of what was added so far."""
        whole = hashlib.sha256(hashlib.sha256(self._schema).digest())
        for digest in self._columns:
            whole.update(digest.digest())
        return whole.hexdigest()


def _canonical(column: pa.Array | pa.ChunkedArray) -> bytes:
    if pa.types.is_string(column.type):
        parts = []
        for value in column.to_pylist():
            text = b"" if value is None else value.encode()
            parts.append(b"\0" if value is None else b"\1" + struct.pack("<q", len(text)) + text)
        return b"".join(parts)
    present = column.is_valid().to_numpy(zero_copy_only=False)
    values = column.fill_null(0).to_numpy(zero_copy_only=False)
    if pa.types.is_floating(column.type):
        values = np.where(np.isnan(values), np.nan, values).astype("<f8")
    else:
        values = values.astype("<i8")
    cells = np.zeros(len(values), dtype=[("present", "u1"), ("value", "V8")])
    cells["present"], cells["value"] = present, values.view("V8")
    if present.all():
        return cells.tobytes()
    return b"".join(cell.tobytes() if there else b"\0" for cell, there in zip(cells, present, strict=True))


def write_table(path: Path, schema: pa.Schema, batches: Iterable[pa.RecordBatch]) -> dict[str, Any]:
    """Write a table batch by batch; memory holds one batch.

    Parameters
    ----------
    path : Path
    schema : pyarrow.Schema
    batches : iterable of pyarrow.RecordBatch

    Returns
    -------
    dict
        ``file``, ``rows``, ``sha256``, ``content_sha256``: the entry of the manifest.
    """
    digest, rows = ContentHash(schema), 0
    texts = [field.name for field in schema if pa.types.is_string(field.type)]
    with pq.ParquetWriter(path, schema, compression="zstd", use_dictionary=texts, store_schema=True) as writer:
        for batch in batches:
            writer.write_batch(batch)
            digest.update(batch)
            rows += batch.num_rows
    return {"file": path.name, "rows": rows, "sha256": file_hash(path), "content_sha256": digest.hexdigest()}


def content_hash(path: Path) -> str:
    """Return the content hash of a Parquet file."""
    with pq.ParquetFile(path) as file:
        digest = ContentHash(file.schema_arrow)
        for batch in file.iter_batches():
            digest.update(batch)
    return digest.hexdigest()


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_json(path: Path, value: Mapping[str, Any] | list[Any]) -> None:
    """Write JSON, keys in the order given, with a newline at the end."""
    path.write_text(json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a temporary folder that takes the place of `target` when the block ends without an error.

    Whoever looks for `target` finds the old folder, the new one, or for the instant between two renames none;
    never a part of one. After an error or an interrupt the old one is there. So it is after a kill, but for
    a kill in that instant: then old and new stand whole beside the target, under names that begin with
    ``.old-`` and ``.partial-``. Of several writers the last to finish stays.

    Parameters
    ----------
    target : Path

    Yields
    ------
    Path
        The temporary folder, beside the target.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    mark = f"{target.name}.{os.getpid()}.{uuid.uuid4().hex[:8]}"
    partial, old = target.parent / f".partial-{mark}", target.parent / f".old-{mark}"
    partial.mkdir()
    try:
        yield partial
        for path in partial.iterdir():
            with path.open("rb") as file:
                os.fsync(file.fileno())
        while True:
            try:
                partial.rename(target)
                break
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
            # The target exists: it steps aside, and the place is tried again. Another writer may be faster
            # each time.
            shutil.rmtree(old, ignore_errors=True)
            with suppress(FileNotFoundError):
                target.rename(old)
    except BaseException:
        # Between the two renames nothing is in the place: the old folder returns, unless another writer was faster.
        with suppress(OSError):
            old.rename(target)
        raise
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
