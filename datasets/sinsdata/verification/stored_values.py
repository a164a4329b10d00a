"""Rows of one case of a stored table as Python's numbers, reading only the parts of the files in which they are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sinsdata.verification.recompute import computed_columns, pair_columns

#: Rows that are Python's numbers at a time.
_FEW = 2**10


def pair_rows(
    dataset: str, table: str, paths: Sequence[Path], first: int, count: int
) -> Iterator[list[tuple[float, float]]]:
    """Yield the pairs of rows, the times left out.

    Parameters
    ----------
    dataset, table : str
    paths : sequence of Path
        The files of the table.
    first, count : int
        Which rows, counted over all files.
    """
    names = [name for name in pair_columns(dataset, table) if name != "time"]
    columns = [half for name in names for half in (name, f"{name}_lo")]
    for data in slices(paths, columns, first, count):
        numbers = np.column_stack([data[name].to_numpy() for name in columns])
        for row in numbers.reshape(len(numbers), -1, 2).tolist():
            yield list(map(tuple, row))


def value_rows(
    dataset: str, table: str, paths: Sequence[Path], first: int, count: int
) -> Iterator[dict[str, float | None]]:
    """Yield rows of pairs and values by the names of their columns; parameters as for `pair_rows`."""
    pairs = {f"{name}_lo" for name in pair_columns(dataset, table)}
    columns = [*(column.name for column in computed_columns(dataset, table)), *pairs]
    for data in slices(paths, columns, first, count):
        for batch in data.to_batches(max_chunksize=_FEW):
            yield from batch.to_pylist()


def slices(paths: Sequence[Path], columns: Sequence[str], first: int, count: int) -> Iterator[pa.Table]:
    """Yield some columns of rows, piece by piece."""
    passed, end = 0, first + count
    for path in paths:
        with pq.ParquetFile(path) as file:
            for part in range(file.num_row_groups):
                rows = file.metadata.row_group(part).num_rows
                start, stop = max(first, passed) - passed, min(end, passed + rows) - passed
                if start < stop:
                    yield file.read_row_group(part, columns=columns).slice(start, stop - start)
                passed += rows
