"""Export of a dataset as plain CSV, for programs that read nothing else."""

from __future__ import annotations

import csv
from contextlib import suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from sinsdata.format.storage import Kind, OccupiedError, replacing
from sinsdata.publishing.loading import Dataset

#: Says of each column what CSV cannot: unit, description, frame, accuracy.
COLUMNS = "columns.csv"
_ABOUT = ("unit", "description", "frame", "accuracy")


def _own_files(folder: Path) -> set[str]:
    """Return the names of the files in a folder that an export wrote."""
    with suppress(OSError, ValueError, csv.Error), (folder / COLUMNS).open(encoding="utf-8", newline="") as lines:
        rows = csv.DictReader(lines)
        if rows.fieldnames == ["table", "column", *_ABOUT]:
            return {COLUMNS, *(f"{row['table']}.csv" for row in rows)}
    return set()


_EXPORT = Kind("export", _own_files)


def export_csv(folder: Path, out: Path) -> dict[str, int]:
    """Write the tables of a dataset as CSV to ``out/dataset/tier``, in place of an earlier export.

    Memory holds one piece at a time.
    UTF-8, a header, commas, texts in quotes where they need them. A float is written with as many digits, up to 17,
    as it takes to read the same binary64 back; a null is empty.

    Parameters
    ----------
    folder : Path
        The dataset.
    out : Path

    Returns
    -------
    dict of str to int
        Rows by name of file.

    Raises
    ------
    sinsdata.format.manifest.DatasetError
        If the folder is not a dataset of this version.
    sinsdata.format.storage.OccupiedError
        If ``out/dataset/tier`` is the dataset itself, or holds something else than an export.
    sinsdata.publishing.archives.ArchiveError
        If a file is not the one that the manifest lists.
    """
    dataset = Dataset(folder)
    rows: dict[str, int] = {}
    about: list[dict[str, str]] = []
    target = out / dataset.manifest["dataset"] / dataset.manifest["tier"]
    if target.resolve() == folder.resolve():
        raise OccupiedError(f"{target}: is the dataset itself; name another folder")
    with replacing(target, _EXPORT) as partial:
        for table in dataset.tables:
            schema = pq.read_schema(dataset.files(table)[0])
            name = f"{table}.csv"
            rows[name] = 0
            with pacsv.CSVWriter(partial / name, schema) as writer:
                for batch in dataset.batches(table):
                    writer.write_batch(batch)
                    rows[name] += batch.num_rows
            for field in schema:
                known = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
                about.append({"table": table, "column": field.name, **{key: known.get(key, "") for key in _ABOUT}})
        pacsv.write_csv(pa.Table.from_pylist(about), partial / COLUMNS)
    return rows
