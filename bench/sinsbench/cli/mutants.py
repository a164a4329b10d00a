"""The command that validates the suite itself: defects planted in the subjects, and what the score sees of them."""

from __future__ import annotations

from typing import Annotated

import typer

from sinsbench.cli.errors import UsageError
from sinsbench.cli.options import JsonFile


def mutants(
    subjects: Annotated[
        list[str] | None,
        typer.Argument(metavar="SUBJECT...", help="Built-in name, package.module:name or path/file.py:name."),
    ] = None,
    on: Annotated[
        str, typer.Option(metavar="DATASET", help="Dataset whose contract your own subjects obey.")
    ] = "dual_precession",
    kind: Annotated[
        list[str] | None,
        typer.Option(help="Only these defects: coefficient, series, source or formula; may be repeated."),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Plant defects in every coefficient and term of the subjects, and see which of them the score tells apart.

    Without a subject: all built-in ones. Exit status 1 if a defect that changes results escapes the score, or one in a
    built-in subject makes no difference for a reason that nobody has given.
    """
    from dataclasses import asdict

    from sinsbench.cli.output import Output
    from sinsbench.mutants.campaign import DATASETS, campaign
    from sinsbench.mutants.runner import KINDS
    from sinsbench.mutants.tables import TITLES, counts, grouped
    from sinsbench.subjects.registry import BUILT_IN

    if on not in DATASETS:
        raise UsageError(f"--on {on}: admissible: {', '.join(DATASETS)}")
    for one in kind or ():
        if one not in KINDS:
            raise UsageError(f"--kind {one}: admissible: {', '.join(KINDS)}")
    output = Output()
    output.check(json)
    with output.progress("planting defects") as progress:
        planted = campaign(subjects, on, kind or KINDS, progress)
    everything = [mutant for one in planted for mutant in one.mutants]
    output.json(json, [asdict(mutant) for mutant in everything])
    output.table(counts(planted), title="defects planted in the subjects, and what the score sees of them")
    for verdict, title in TITLES.items():
        output.table(grouped(everything, verdict), title=title)
    failed = [
        x for x in everything if x.verdict == "survivor" or (x.verdict == "unexplained" and x.subject in BUILT_IN)
    ]
    raise typer.Exit(1 if failed else 0)
