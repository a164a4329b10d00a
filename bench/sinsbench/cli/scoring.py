"""The command that scores subjects, built-in or a user's own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sinsbench.cli.options import JsonFile

if TYPE_CHECKING:
    from sinsdata.cases import Case


def score(
    subjects: Annotated[
        list[str] | None,
        typer.Argument(metavar="SUBJECT...", help="Built-in name, package.module:name or path/file.py:name."),
    ] = None,
    on: Annotated[str | None, typer.Option(metavar="DATASET", help="Name or folder of a dataset.")] = None,
    case: Annotated[list[str] | None, typer.Option(metavar="CASE", help="Only this case; may be repeated.")] = None,
    takes: Annotated[
        str | None, typer.Option(metavar="CONVENTION", help="Input convention of integrators that declare none.")
    ] = None,
    ladder: Annotated[bool, typer.Option("--ladder", help="Show every sampling interval, not only the own.")] = False,
    figure: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw errors over the intervals too: .svg or .png.")
    ] = None,
    json: JsonFile = None,
) -> None:
    """Score subjects, built-in or your own, against certified truth. Without a subject: every built-in one.

    Of a dataset's folder the cases are taken; their truth is computed anew, at a ladder of sampling intervals.
    """
    from sinsbench.cli.choices import cases_to_score, datasets_to_score
    from sinsbench.cli.output import Output
    from sinsbench.cli.scores import score_tables
    from sinsbench.figures import check_figure, ladder_figure
    from sinsbench.scoring.score import loaded_subjects
    from sinsbench.scoring.score import score as score_subjects

    output = Output()
    output.check(json, figure)
    rows: list[dict[str, Any]] = []
    scored: list[Case] = []
    chosen = [
        cases_to_score(dataset, case) for dataset in ([on] if on is not None else datasets_to_score(subjects, case))
    ]
    check_figure(figure, [name for name, _ in chosen])
    for name, cases in chosen:
        scored += cases
        loaded = loaded_subjects(subjects or None, name, takes)
        with output.progress(f"scoring on {name}") as progress:
            rows += score_subjects(loaded, cases, progress)
    output.json(json, rows)
    if figure is not None:
        ladder_figure(rows, figure)
    for title, table in score_tables(rows, scored, whole_ladder=ladder):
        output.table(table, title=title)
    broken = [row for row in rows if row["status"] not in ("ok", "not applicable")]
    raise typer.Exit(1 if broken else 0)
