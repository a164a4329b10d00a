"""The command that makes one page, and figures, of results."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    results: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULT...",
            help="JSON of score, claims, mutants, verify; stored benchmark runs; folders of them, as of reproduce; "
            "case files (TOML) that were scored on.",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the page.")] = Path("sinsbench-report"),
    figures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write the charts as SVG and PNG too, for papers.")
    ] = None,
) -> None:
    """Make one page of results, with charts and tables, that needs nothing else: no network, no other file."""
    from sinsbench.cli.output import Output
    from sinsbench.report.results import read_results
    from sinsbench.report.write import write_report

    output = Output()
    read = read_results(results)
    with output.progress("making the page") as progress:
        written = write_report(read, out, figures, progress)
    output.line(f"The page is {written.page}.")
    if figures is not None:
        output.line(f"{len(written.figures)} figures are in {figures}.")
