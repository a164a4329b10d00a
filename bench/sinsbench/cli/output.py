"""Tables, lines, JSON files and the progress bar."""

from __future__ import annotations

import json
import os
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

#: ``progress(done, total, what)``.
Progress: TypeAlias = Callable[[int, int, str], None]

#: Width of a table that goes to a file or a pipe, where nobody can widen the window.
_PIPE_WIDTH = 180
#: Longest cell that is kept on one line, and the least width of longer ones.
_LONGEST_CELL, _PROSE = 64, 40
#: Space between two columns.
_GAP = 3


class Output:
    """Where the commands write: tables and lines to standard output, progress to standard error."""

    def __init__(self) -> None:
        from rich.console import Console

        width = None if sys.stdout.isatty() or "COLUMNS" in os.environ else _PIPE_WIDTH
        self._console = Console(highlight=False, soft_wrap=False, width=width)

    def table(self, rows: Sequence[Mapping[str, Any]], title: str = "", columns: Sequence[str] = ()) -> None:
        """Print rows as a table; the keys of the first row are the columns unless they are named.

        A table that is wider than the window is printed in parts, each with the first column.
        """
        if not rows:
            return
        names = tuple(columns) or tuple(rows[0])
        cells = {name: [cell(row.get(name)) for row in rows] for name in names}
        widths = {name: _width(heading(name), cells[name]) for name in names}
        for number, part in enumerate(_parts(names, widths, self._console.width)):
            self._part({name: cells[name] for name in part}, widths, "" if number else title)

    def _part(self, cells: Mapping[str, Sequence[str]], widths: Mapping[str, int], title: str) -> None:
        from rich import box
        from rich.table import Table

        table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for name, values in cells.items():
            justify: Any = "right" if any(map(_is_number, values)) else "left"
            title = "\n".join(textwrap.wrap(heading(name), widths[name]))
            if max(map(len, values)) > widths[name]:  # prose takes the room that is left
                table.add_column(title, justify=justify, overflow="fold", min_width=widths[name], ratio=1)
            else:
                table.add_column(title, justify=justify, width=widths[name])
        for row in zip(*cells.values(), strict=True):
            table.add_row(*row)
        self._console.print(table)

    def line(self, text: str) -> None:
        """Print a line of prose."""
        self._console.print(text, markup=False)

    def json(self, path: Path | None, value: Any) -> None:
        """Write a value as JSON, whole or not at all; None for no file."""
        if path is not None:
            self.text(path, json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n")

    def text(self, path: Path, text: str) -> None:
        """Write a text file, whole or not at all."""
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            temporary.write_text(text, encoding="utf-8")
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)

    @contextmanager
    def progress(self, title: str) -> Iterator[Progress]:
        """Show a progress bar on standard error while a person watches, nothing otherwise."""
        if not sys.stderr.isatty():
            yield lambda done, total, what: None
            return
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[what]}"),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(title, total=None, what="")

            def update(done: int, total: int, what: str) -> None:
                bar.update(task, completed=done, total=total, what=what)

            yield update


def _parts(names: Sequence[str], widths: Mapping[str, int], limit: int) -> Iterator[list[str]]:
    """Yield groups of columns that fit, the first column in each."""
    first, *others = names
    part, used = [first], widths[first] + _GAP
    for name in others:
        if used + widths[name] + _GAP > limit and len(part) > 1:
            yield part
            part, used = [first], widths[first] + _GAP
        part.append(name)
        used += widths[name] + _GAP
    yield part


def _width(head: str, values: Sequence[str]) -> int:
    """Return the width of a column: cells whole, as a name broken over two lines cannot be copied, but prose folded."""
    words = [len(word) for word in head.split()]
    return max(*words, 1, *(len(value) if len(value) <= _LONGEST_CELL else _PROSE for value in values))


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", ""))
    except ValueError:
        return False
    return True


def heading(name: str) -> str:
    """Return the heading of a column from its key."""
    return name.replace("_", " ")


def cell(value: Any) -> str:
    """Return a value as people read it: 4 significant digits, nothing for None."""
    from rich.markup import escape

    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value)
    if isinstance(value, int):
        return f"{value:,}"
    return escape(str(value))


def number(value: float) -> str:
    """Return a number with 4 significant digits."""
    if value == 0:
        return "0"
    return f"{value:.4g}" if 1e-3 <= abs(value) < 1e6 else f"{value:.3e}"
