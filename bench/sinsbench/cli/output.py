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
#: Least room beside the key columns.
_LEAST = 20
#: Space between two columns.
_GAP = 3


class OutputError(ValueError):
    """A file cannot be written; the message says which and why."""


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
        keys = 2 if names[1:2] == ("case",) else 1
        for number, widths in enumerate(layout(cells, keys, self._console.width)):
            self._part({name: cells[name] for name in widths}, widths, "" if number else title)

    def _part(self, cells: Mapping[str, Sequence[str]], widths: Mapping[str, int], title: str) -> None:
        from rich import box
        from rich.table import Table
        from rich.text import Text

        table = Table(title=Text(title) if title else None, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for name, values in cells.items():
            justify: Any = "right" if any(map(_is_number, values)) else "left"
            head = "\n".join(textwrap.wrap(heading(name), widths[name]))
            table.add_column(Text(head), justify=justify, overflow="fold", width=widths[name])
        for row in zip(*cells.values(), strict=True):
            table.add_row(*map(Text, row))
        self._console.print(table)

    def line(self, text: str) -> None:
        """Print a line of prose."""
        self._console.print(text, markup=False, soft_wrap=True)

    def json(self, path: Path | None, value: Any) -> None:
        """Write a value as JSON, whole or not at all; None for no file."""
        if path is not None:
            text = json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
            self.text(path, text.encode("utf-8", "replace").decode())

    def text(self, path: Path, text: str) -> None:
        """Write a text file, whole or not at all."""
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        try:
            temporary.write_text(text, encoding="utf-8")
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)

    @staticmethod
    def check(*paths: Path | None) -> None:
        """See, before anything is computed, that files can be written.

        Raises
        ------
        OutputError
            If a name is no file's, or its folder is not there.
        """
        for path in paths:
            if path is not None and (not path.name or path.is_dir()):
                raise OutputError(f"{str(path)!r} is not the name of a file")
            if path is not None and not path.parent.is_dir():
                raise OutputError(f"{path}: there is no folder {path.parent}")

    @contextmanager
    def progress(self, title: str, unit: str = "") -> Iterator[Progress]:
        """Show a progress bar on standard error while a person watches, nothing otherwise.

        Parameters
        ----------
        title : str
        unit : str, optional
            What is counted: its rate is shown too.
        """
        if not sys.stderr.isatty():
            yield lambda done, total, what: None
            return
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[what]}"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
        )
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(title, total=None, what="")

            def update(done: int, total: int, what: str) -> None:
                speed = bar.tasks[0].speed
                counted = f"{done:,} of {total:,} {unit}" + (f", {speed:,.0f} a second" if speed else "")
                bar.update(task, completed=done, total=total or None, what=counted if unit and total else what)

            yield update


def layout(cells: Mapping[str, Sequence[str]], keys: int, limit: int) -> list[dict[str, int]]:
    """Return the columns of each part of a table, with their widths: nothing is cut off, whatever the window.

    Parameters
    ----------
    cells : mapping of str to sequence of str
        Columns.
    keys : int
        How many of the first columns stand in each part.
    limit : int
        Width of the window.
    """
    names = list(cells)
    wanted = {name: max(map(len, [*heading(name).split(), *cells[name], "?"])) for name in names}
    # Cells stay whole, as a name broken over two lines cannot be copied; prose and what no window holds are folded.
    widths = {name: min(width, _PROSE if width > _LONGEST_CELL else width, limit - 2) for name, width in wanted.items()}
    head = names[:keys] if sum(widths[name] + _GAP for name in names[:keys]) <= limit // 2 else names[:1]
    room = limit - sum(widths[name] + _GAP for name in head)
    if room < _LEAST:  # a window as narrow as a name: one column after the other
        head, room = [], limit
    parts: list[dict[str, int]] = []
    for name in names[len(head) :]:
        widths[name] = min(widths[name], room - 2)
        used = sum(width + _GAP for width in parts[-1].values()) if parts else limit + 1
        if used + widths[name] + _GAP > limit:
            parts.append({key: widths[key] for key in head})
        parts[-1][name] = widths[name]
    for part in parts:
        # Prose takes the room that is left.
        left = limit - sum(width + _GAP for width in part.values())
        for name in part:
            more = min(left, wanted[name] - part[name])
            part[name] += max(more, 0)
            left -= max(more, 0)
    return parts or [{name: widths[name] for name in head}]


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", ""))
    except ValueError:
        return False
    return True


def certified(known: Mapping[str, Any]) -> str:
    """Return what is proved of the values of a dataset, from the entry ``certification`` of its manifest."""
    if not str(known.get("method", "ball")).startswith("ball"):
        return f"{known['method']}."
    bounded, ties = known["bounded_zeros"], known["bounded_ties"]
    text = (
        f"{known['values']:,} values: nearest binary64 and rest, together within 1e-30, proved by ball arithmetic; "
        f"{known['exact_zeros']:,} exact zeros among them"
    )
    if bounded:
        text += f"; {bounded:,} stored as 0 are proved below 1e-300, not zero"
    if ties:
        text += f"; {ties:,} ties are proved to 4096 bits"
    return text + "."


def heading(name: str) -> str:
    """Return the heading of a column from its key; one with a unit behind a comma, such as dv_H, m/s, is a heading."""
    return name if "," in name else name.replace("_", " ")


def cell(value: Any) -> str:
    """Return a value as people read it: 4 significant digits, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value)
    if isinstance(value, int):
        return f"{value:,}"
    return str(value)


def number(value: float) -> str:
    """Return a number with 4 significant digits."""
    if value == 0:
        return "0"
    return f"{value:.4g}" if 1e-3 <= abs(value) < 1e6 else f"{value:.3e}"


def markdown_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows as a table in Markdown, with the headings and numbers of `Output.table`."""
    names = list(rows[0])
    lines = ["| " + " | ".join(heading(name).strip() for name in names) + " |", "|" + "---|" * len(names)]
    lines += ["| " + " | ".join(cell(row.get(name)).replace("|", "\\|") for name in names) + " |" for row in rows]
    return "\n".join(lines)
