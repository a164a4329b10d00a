"""The command that scores subjects, built-in or a user's own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sinsbench.cli.errors import UsageError
from sinsbench.cli.options import JsonFile

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from sinsbench.cli.choices import Guests
    from sinsdata.cases import Case

#: Into how many parts a worker's share of many cases is cut, so that all end together.
_PARTS = 8


def score(
    subjects: Annotated[
        list[str] | None,
        typer.Argument(metavar="SUBJECT...", help="Built-in name, package.module:name or path/file.py:name."),
    ] = None,
    on: Annotated[str | None, typer.Option(metavar="DATASET", help="Name or folder of a dataset.")] = None,
    case: Annotated[list[str] | None, typer.Option(metavar="CASE", help="Only this case; may be repeated.")] = None,
    cases: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Your own cases (TOML) of the dataset named by --on.")
    ] = None,
    command: Annotated[
        list[str] | None,
        typer.Option(metavar="COMMAND", help='A program, such as "./prog {input} {output}"; may be repeated.'),
    ] = None,
    result: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE", help="Results computed beforehand: .parquet, .arrow or .csv; may be repeated."),
    ] = None,
    name: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Name of the program or file of results; may be repeated.")
    ] = None,
    format_: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="Files of a program: csv, parquet or arrow.")
    ] = "csv",
    samples_per_step: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Give programs whole steps of N samples.")
    ] = None,
    isolate: Annotated[bool, typer.Option("--isolate", help="Run callables in processes of their own.")] = False,
    timeout: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Stop a program or callable after this time.")
    ] = None,
    memory: Annotated[int | None, typer.Option(metavar="MB", help="Most memory of a program or callable.")] = None,
    takes: Annotated[
        str | None, typer.Option(metavar="CONVENTION", help="Input convention of integrators that declare none.")
    ] = None,
    ladder: Annotated[bool, typer.Option("--ladder", help="Show every sampling interval, not only the own.")] = False,
    responses: Annotated[
        bool,
        typer.Option(
            "--responses", help="In place of scores: how gyroscopic systems answer to errors of sensors and start."
        ),
    ] = False,
    work_precision: Annotated[
        bool, typer.Option("--work-precision", help="Show cost against error, and who is cheapest at an error.")
    ] = False,
    require: Annotated[
        list[str] | None,
        typer.Option(metavar="CONDITION", help='Condition on the rows shown, "drift_deg_per_h<1e-3"; may be repeated.'),
    ] = None,
    figure: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw errors over the intervals too: .svg or .png.")
    ] = None,
    workers: Annotated[
        int, typer.Option(min=1, help="Processes that share the cases; times are best taken in one.")
    ] = 1,
    json: JsonFile = None,
) -> None:
    """Score subjects, built-in or your own, against certified truth. Without a subject: every built-in one.

    Of a dataset's folder the cases are taken; their truth is computed anew, at a ladder of sampling intervals.
    """
    from sinsbench.cli.choices import Guests, cases_to_score, datasets_to_score
    from sinsbench.cli.output import Output
    from sinsbench.cli.scores import native, response_tables, score_tables, work_precision_tables
    from sinsbench.figures import check_figure, ladder_figure
    from sinsbench.scoring.requirements import parse_requirement, violations
    from sinsbench.subjects.processes import Limits

    output = Output()
    output.check(json, figure)
    requirements = [parse_requirement(text) for text in require or ()]
    if responses and (ladder or work_precision or figure is not None):
        raise UsageError("--responses is for one table of its own: without --ladder, --work-precision and --figure")
    guests = Guests(
        tuple(command or ()),
        tuple(result or ()),
        tuple(name or ()),
        takes,
        format_,
        samples_per_step,
        isolated=isolate or timeout is not None or memory is not None,
        limits=Limits(timeout, None if memory is None else memory * 1_000_000),
    )
    rows: list[dict[str, Any]] = []
    scored: list[Case] = []
    if cases is not None and on is None and not subjects:
        raise UsageError(f"--cases {cases}: say of which dataset these cases are, with --on")
    on = "gyro_systems" if on is None and responses else on
    datasets = [on] if on is not None else datasets_to_score(subjects, case, guests.texts)
    chosen = [cases_to_score(dataset, case, cases) for dataset in datasets]
    check_figure(figure, [dataset for dataset, _ in chosen])
    for dataset, held in chosen:
        scored += held
        with output.progress(f"scoring on {dataset}") as progress:
            rows += _rows(guests, subjects or (), dataset, held, responses, progress, workers)
    output.json(json, rows)
    if figure is not None:
        ladder_figure(rows, figure)
    for title, table in response_tables(rows) if responses else score_tables(rows, scored, whole_ladder=ladder):
        output.table(table, title=title)
    for title, table in work_precision_tables(rows) if work_precision else ():
        output.table(table, title=title)
    missed = violations(requirements, rows if ladder else native(rows, scored))
    for line in missed:
        output.line(line)
    broken = [row for row in rows if row["status"] not in ("ok", "not applicable")]
    raise typer.Exit(1 if broken or missed else 0)


def _rows(
    guests: Guests,
    subjects: Sequence[str],
    dataset: str,
    cases: Sequence[Case],
    responses: bool,
    progress: Callable[[int, int, str], None] | None,
    workers: int = 1,
    only: slice = slice(None),
) -> list[dict[str, Any]]:
    """Score on cases of a dataset, or on some of them; with several workers each takes some after the other."""
    from sinsbench.reproduction.parallel import Part, run_parts
    from sinsbench.scoring.score import loaded_subjects
    from sinsbench.scoring.score import responses as score_responses
    from sinsbench.scoring.score import score as score_subjects

    loaded = loaded_subjects(guests.subjects(subjects, dataset, cases), dataset, guests.takes)
    if workers > 1 and len(cases) > 1 and progress is not None:
        # A process loads the subjects itself: functions and programs do not travel, their names do.
        size = max(1, len(cases) // (_PARTS * workers))
        parts = [
            Part(
                f"scoring from {cases[first].name} on",
                _rows,
                (guests, subjects, dataset, cases, responses, None, 1, slice(first, first + size)),
            )
            for first in range(0, len(cases), size)
        ]
        return [row for rows in run_parts(parts, progress, workers) for row in rows]
    chosen = cases[only]
    return score_responses(loaded, chosen, progress) if responses else score_subjects(loaded, chosen, progress)
