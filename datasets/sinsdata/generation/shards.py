"""A shard: from its rows to Parquet files with a receipt, by which a later run knows them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from sinsdata.format.content_hash import ContentHash
from sinsdata.format.schema import arrow_schema
from sinsdata.format.storage import file_hash
from sinsdata.generation.destination import Destination
from sinsdata.generation.specification import ShardTask
from sinsdata.generation.tables import groups_of
from sinsref.rounding import RoundingTally

#: Rows that are encoded together: what readers can take without the rest.
ROW_GROUP = 2**16


@dataclass(frozen=True)
class FileReceipt:
    """A file that is whole.

    Attributes
    ----------
    table, file : str
    rows, size : int
        Rows and bytes.
    sha256 : str
        Of the file.
    pages : bytes
        Digests of its pages of rows (`sinsdata.format.content_hash`).
    """

    table: str
    file: str
    rows: int
    size: int
    sha256: str
    pages: bytes


@dataclass(frozen=True)
class ShardReceipt:
    """A shard that is whole.

    Attributes
    ----------
    files : tuple of FileReceipt
    tally : RoundingTally
        How its values were decided.
    reused : bool
        Whether an earlier run had finished it.
    """

    files: tuple[FileReceipt, ...]
    tally: RoundingTally
    reused: bool


def complete(task: ShardTask, place: Destination, report: Callable[[int], None] = lambda rows: None) -> ShardReceipt:
    """Make a shard, unless a run of the same specification has made it and its files are as that left them.

    Parameters
    ----------
    task : ShardTask
    place : Destination
    report : callable, optional
        Called with the number of rows, over all tables, that were added.
    """
    done = _finished(task, place)
    if done is not None:
        report(task.rows * len(task.tables))
        return done
    made = _made(task, place, report)
    place.put_receipt(task.receipt, _receipt_text(made))
    return made


def _receipt_text(receipt: ShardReceipt) -> str:
    """Return a receipt as text that shows any change to it: the SHA-256 of the rest stands first."""
    files = [{**asdict(file), "pages": file.pages.hex()} for file in receipt.files]
    text = json.dumps({"files": files, "tally": asdict(receipt.tally)})
    return f"{_seal(text)}\n{text}"


def _seal(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _finished(task: ShardTask, place: Destination) -> ShardReceipt | None:
    """Return the receipt of a shard that is there and whole, None where it is not."""
    seal, _, text = (place.receipt(task.receipt) or "").partition("\n")
    if seal != _seal(text):
        return None
    content = json.loads(text)
    files = tuple(FileReceipt(**{**file, "pages": bytes.fromhex(file["pages"])}) for file in content["files"])
    if any(place.digest(file.file) != file.sha256 for file in files):
        return None
    return ShardReceipt(files, RoundingTally(**content["tally"]), reused=True)


def _made(task: ShardTask, place: Destination, report: Callable[[int], None]) -> ShardReceipt:
    (group,) = groups_of(task.dataset, task.tables)[-1:]
    tally = RoundingTally()
    with ExitStack() as stack:
        paths = [stack.enter_context(place.write(file)) for file in task.files]
        files = [_TableFile(path, task, table) for path, table in zip(paths, task.tables, strict=True)]
        try:
            for batches in group.batches(task.tier, task.segments, tally):
                for file, batch in zip(files, batches, strict=True):
                    file.write(batch)
                report(len(batches) * batches[0].num_rows)
            for file in files:
                file.finish()
        finally:
            for file in files:
                file.close()
        receipts = tuple(
            FileReceipt(table, name, task.rows, path.stat().st_size, file_hash(path), file.pages)
            for table, name, path, file in zip(task.tables, task.files, paths, files, strict=True)
        )
    return ShardReceipt(receipts, tally, reused=False)


class _TableFile:
    """A Parquet file that is written batch by batch; memory holds one row group."""

    def __init__(self, path: Path, task: ShardTask, table: str) -> None:
        self._schema = arrow_schema(task.dataset, table)
        self._hash = ContentHash(self._schema)
        self._waiting: list[pa.RecordBatch] = []
        self._rows = 0
        self._writer = pq.ParquetWriter(path, self._schema, **_settings(self._schema))

    @property
    def pages(self) -> bytes:
        return self._hash.pages()

    def write(self, batch: pa.RecordBatch) -> None:
        self._hash.update(batch)
        self._waiting.append(batch)
        self._rows += batch.num_rows
        if self._rows >= ROW_GROUP:
            self._flush(self._rows - self._rows % ROW_GROUP)

    def _flush(self, rows: int) -> None:
        table = pa.Table.from_batches(self._waiting).replace_schema_metadata(self._schema.metadata)
        self._writer.write_table(table.slice(0, rows), row_group_size=ROW_GROUP)
        rest = table.slice(rows)
        self._waiting, self._rows = rest.to_batches(), rest.num_rows

    def finish(self) -> None:
        if self._rows:
            self._flush(self._rows)

    def close(self) -> None:
        self._writer.close()


def _settings(schema: pa.Schema) -> dict[str, object]:
    """Return how tables are encoded: bytes of equal weight side by side, which is what zstd can shorten."""
    texts = [field.name for field in schema if pa.types.is_string(field.type)]
    integers = [field.name for field in schema if pa.types.is_integer(field.type)]
    doubles = [field.name for field in schema if pa.types.is_floating(field.type)]
    return {
        "compression": "zstd",
        # Level 3 saves 0.3 % and costs a quarter more time.
        "compression_level": 1,
        "use_dictionary": texts,
        "column_encoding": {
            **dict.fromkeys(doubles, "BYTE_STREAM_SPLIT"),
            **dict.fromkeys(integers, "DELTA_BINARY_PACKED"),
        },
        # Of values nobody asks smallest and largest; of these readers do, to find rows.
        "write_statistics": [*texts, *integers, *(name for name in doubles if name == "time")],
        "store_schema": True,
    }
