"""Tables as CSV, Parquet or Arrow files: written so that every digit survives, read with suspicion."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.loading import printable
from sinsbench.subjects.outcome import OutcomeError

__all__ = ["FORMATS", "Columns", "check_finite", "listed", "read_columns", "write_columns"]

FORMATS = ("csv", "parquet", "arrow")
"""Formats, which are suffixes of files too."""

#: Columns of a table by name.
Columns = dict[str, NDArray[Any]]

_LONGEST_HEADER = 1 << 16  # bytes
_SHOWN = 60  # characters of a line that is quoted
_NAMED = 12  # columns that a message names


def listed(names: Sequence[str]) -> str:
    """Return names as a message lists them: the first ones, and how many there are if not all are shown."""
    shown = ", ".join(names[:_NAMED])
    return shown if len(names) <= _NAMED else f"{shown}, ... ({len(names)} of them)"


def write_columns(columns: Mapping[str, NDArray[Any]], path: Path) -> None:
    """Write columns of one length as the file format that the suffix says.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Binary64 values are written to CSV with the fewest digits that tell them from their neighbours.
    path : Path
    """
    import pyarrow as pa

    table = pa.table(dict(columns))
    if path.suffix == ".parquet":
        import pyarrow.parquet as pq

        pq.write_table(table, path)
    elif path.suffix == ".arrow":
        with pa.OSFile(str(path), "wb") as file, pa.ipc.new_file(file, table.schema) as writer:
            writer.write_table(table)
    else:
        from pyarrow import csv as arrow_csv

        with path.open("wb") as file:
            file.write(
                (",".join(columns) + "\n").encode()
            )  # names without quotation marks, which C would have to strip
            arrow_csv.write_csv(table, file, arrow_csv.WriteOptions(include_header=False, quoting_style="none"))


def read_columns(path: Path, known: Sequence[str], also: Sequence[str] = (), texts: Sequence[str] = ()) -> Columns:
    """Read from a table the columns of known names; others are passed over.

    Parameters
    ----------
    path : Path
        Parquet or Arrow if its suffix says so, CSV otherwise.
    known : sequence of str
        Names of columns of numbers, one of which at least must be there.
    also : sequence of str
        Names of further columns of numbers.
    texts : sequence of str
        Names of columns of texts.

    Returns
    -------
    dict
        Binary64 arrays, and arrays of str; NaN where a file says so.

    Raises
    ------
    OutcomeError
        ``wrong shape`` if the file is no such table, with the line and the column where there is one; ``error`` if it
        cannot be read.
    """
    import pyarrow as pa

    if not path.is_file():
        raise OutcomeError("error", f"there is no file {path.name or path}")
    try:
        if path.suffix in (".parquet", ".arrow"):
            return _read_arrow(path, known, (*also, *texts), texts)
        return _read_csv(path, known, (*also, *texts), texts)
    except pa.ArrowException as error:
        _refuse(path, "", f"is no {path.suffix.removeprefix('.')} file: {error}")
    except OSError as error:
        raise OutcomeError("error", f"{path.name}: {error.strerror or error}") from error


def check_finite(
    path: Path, columns: Mapping[str, NDArray[Any]], names: Sequence[str], rows: NDArray[Any] | None = None
) -> None:
    """Check that columns hold finite numbers; `rows` are their numbers in the file, if it holds more.

    Raises
    ------
    OutcomeError
        ``not finite``, with the line (CSV) or row and the column.
    """
    for name in names:
        finite = np.isfinite(columns[name])
        if not finite.all():
            row = int(np.argmin(finite))
            place = _place(path, row if rows is None else int(rows[row]))
            raise OutcomeError("not finite", f"{place}, column {name}: {columns[name][row]}")


def _place(path: Path, row: int) -> str:
    """Say where a row is: lines of a CSV file count from 1, the header's."""
    return f"{path.name}, row {row}" if path.suffix in (".parquet", ".arrow") else f"{path.name}, line {row + 2}"


def _refuse(path: Path, place: str, why: str) -> NoReturn:
    raise OutcomeError("wrong shape", f"{path.name}{place} {why}")


def _chosen(path: Path, place: str, header: Sequence[str], known: Sequence[str], also: Sequence[str]) -> list[str]:
    """Return the names of a header that are known, in its order."""
    chosen = [name for name in header if name in known or name in also]
    twice = sorted({name for name in chosen if chosen.count(name) > 1})
    if twice:
        _refuse(path, place, f"names a column twice: {', '.join(twice)}")
    if not any(name in known for name in chosen):
        given = printable(",".join(header))
        hint = "; are the cells separated by commas?" if len(header) == 1 and path.suffix == ".csv" else ""
        shown = given if len(given) <= _SHOWN else f"{given[:_SHOWN]}..."
        _refuse(path, place, f"names no column of {listed(known)}; it says {shown!r}{hint}")
    return chosen


def _read_arrow(path: Path, known: Sequence[str], also: Sequence[str], texts: Sequence[str]) -> Columns:
    import pyarrow as pa

    if path.suffix == ".parquet":
        import pyarrow.parquet as pq

        with pq.ParquetFile(path) as file:
            names = _chosen(path, "", file.schema_arrow.names, known, also)
            table = file.read(columns=names)
    else:
        with pa.OSFile(str(path)) as file:
            table = pa.ipc.open_file(file).read_all()
        table = table.select(_chosen(path, "", table.schema.names, known, also))
    columns: Columns = {}
    for name in table.column_names:
        column = table.column(name)
        if column.null_count:
            row = column.is_null().index(True).as_py()
            _refuse(path, f", row {row}, column {name}", "holds nothing")
        try:
            columns[name] = column.cast(pa.string() if name in texts else pa.float64(), safe=False).to_numpy()
        except pa.ArrowException:
            _refuse(path, f", column {name}", f"holds {column.type}, not {'texts' if name in texts else 'numbers'}")
    return columns


def _read_csv(path: Path, known: Sequence[str], also: Sequence[str], texts: Sequence[str]) -> Columns:
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    with path.open("rb") as file:
        first = file.readline(_LONGEST_HEADER)
    if not first.strip():
        _refuse(path, "", "is empty" if not first else "begins with a blank line, not with a header")
    header = [cell.strip().strip('"') for cell in first.decode("utf-8-sig", "replace").split(",")]
    names = _chosen(path, ", line 1,", header, known, also)
    try:
        table = arrow_csv.read_csv(
            path,
            arrow_csv.ReadOptions(column_names=header, skip_rows=1),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=names,
                column_types={name: pa.string() if name in texts else pa.float64() for name in names},
                null_values=[],
            ),
        )
    except (pa.ArrowException, UnicodeError):
        return _read_line_by_line(path, header, names, texts)
    return {name: table.column(name).to_numpy() for name in names}


def _read_line_by_line(path: Path, header: Sequence[str], names: Sequence[str], texts: Sequence[str]) -> Columns:
    """Read what the fast reader does not take: more ways to write a number, or else the place of the slip."""
    places = {name: header.index(name) for name in names}
    cells: dict[str, list[Any]] = {name: [] for name in names}
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        lines = csv.reader(file)
        next(lines)
        try:
            for row in filter(None, lines):
                if len(row) != len(header):
                    _refuse(path, f", line {lines.line_num}", f"has {len(row)} cells; the header has {len(header)}")
                for name, place in places.items():
                    cells[name].append(row[place].strip() if name in texts else _number(path, lines, name, row[place]))
        except csv.Error as error:
            _refuse(path, f", line {lines.line_num}:", printable(str(error)))
    return {name: np.array(values, dtype=object if name in texts else np.float64) for name, values in cells.items()}


def _number(path: Path, lines: Any, name: str, cell: str) -> float:
    try:
        return float(cell.replace("D", "e").replace("d", "e"))  # Fortran writes 1.5D+00
    except ValueError:
        _refuse(path, f", line {lines.line_num}, column {name}:", f"{printable(cell[:_SHOWN])!r} is no number")
