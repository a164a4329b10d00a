"""The commands. What they need is imported when they run: ``--help`` answers at once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sinsbench.cli import mutants, peers, publishing, report, scoring
from sinsbench.cli.errors import UsageError
from sinsbench.cli.options import JsonFile
from sinsbench.dashboard.command import benchmarks

if TYPE_CHECKING:
    from sinsdata.verification.recompute import Wanted

app = typer.Typer(
    name="sinsbench",
    help="Ground truth and honest scores for the numerical algorithms of strapdown inertial navigation.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from sinsbench import __version__

        typer.echo(f"sinsbench {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_show_version, help="Show the version and exit.")
    ] = False,
) -> None:
    pass


@app.command("list")
def list_(
    what: Annotated[str, typer.Argument(help="datasets, cases, strata, subjects, papers, or all.")] = "all",
    json: JsonFile = None,
) -> None:
    """List datasets, cases, strata, subjects and papers."""
    from sinsbench.cli.inventory import INVENTORIES
    from sinsbench.cli.output import Output

    if what != "all" and what not in INVENTORIES:
        raise UsageError(f"cannot list {what!r}; admissible: {', '.join(INVENTORIES)}, all")
    wanted = list(INVENTORIES) if what == "all" else [what]
    output = Output()
    output.check(json)
    everything = {name: INVENTORIES[name]() for name in wanted}
    output.json(json, everything if what == "all" else everything[what])
    for name, rows in everything.items():
        output.table(rows, title=name)


@app.command()
def generate(
    dataset: Annotated[str, typer.Argument(help="A dataset, as `sinsbench list datasets` names them.")],
    tier: Annotated[str | None, typer.Option(help="Cases to generate: paper (the default), standard or short.")] = None,
    cases: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Your own cases or a grid of them (TOML) in place of a tier.")
    ] = None,
    out: Annotated[
        str, typer.Option(metavar="DIR", help="Folder, or URI such as s3://bucket/data, to write DATASET/TIER to.")
    ] = "sinsbench-data",
    tables: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Only these tables, with commas between them.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = 1,
    shard: Annotated[
        str | None, typer.Option(metavar="I/N", help="Only the I-th of N parts: for array jobs, all with the same DIR.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Compute on a Dask cluster, such as tcp://127.0.0.1:8786.")
    ] = None,
    json: JsonFile = None,
) -> None:
    """Generate a certified dataset: Parquet tables, digits as text, and a manifest with hashes.

    A run that was interrupted goes on where it stopped when the same command is given again.
    """
    from sinsbench.cli.choices import cases_to_generate, part_of
    from sinsbench.cli.generation import show_generated
    from sinsbench.cli.output import Output
    from sinsdata.generation.generate import generate as generate_dataset

    name, chosen = cases_to_generate(dataset, tier, cases)
    part = part_of(shard)
    output = Output()
    output.check(json)
    with output.progress(f"generating {dataset}", unit="rows") as progress:
        made = generate_dataset(
            dataset,
            name,
            chosen,
            out,
            progress,
            tables=None if tables is None else [table.strip() for table in tables.split(",")],
            workers=workers,
            part=part,
            scheduler=scheduler,
        )
    show_generated(made, output, json)


@app.command()
def verify(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A dataset, or a folder of datasets.")],
    recompute: Annotated[
        str,
        typer.Option(
            metavar="N|all|few",
            help="Rows of each case and table to compute again by mpmath. Few: three, where a row costs all before it"
            " of the first four.",
        ),
    ] = "few",
    integrate: Annotated[
        bool, typer.Option("--integrate", help="Integrate the differential equations too, and compare every row.")
    ] = False,
    workers: Annotated[int, typer.Option(min=1, help="Processes that compute rows again and integrate.")] = 1,
    json: JsonFile = None,
) -> None:
    """Check bytes, schema, rows and relations of a dataset, and compute some of its values again."""
    from dataclasses import asdict

    from sinsbench.cli.output import Output
    from sinsdata.verification.stored_cases import find_datasets
    from sinsdata.verification.verify import verify as verify_dataset

    words: dict[str, Wanted] = {"all": "all", "few": "few"}
    if recompute not in words and not (recompute.isascii() and recompute.isdigit()):
        raise UsageError(f"--recompute {recompute!r}: must be a number of rows, all or few")
    wanted = words[recompute] if recompute in words else int(recompute)
    output = Output()
    output.check(json)
    checks: list[dict[str, Any]] = []
    summary = []
    with output.progress("verifying") as progress:
        for found in find_datasets(folder):
            own = [asdict(check) for check in verify_dataset(found, wanted, progress, workers)]
            if integrate and all(check["holds"] for check in own):
                from sinsdata.verification.integrate import integrate as integrate_dataset

                own += [asdict(check) for check in integrate_dataset(found, workers, progress)]
            bad = sum(not check["holds"] for check in own)
            summary.append(f"{found}: {len(own) - bad} checks hold, {bad} do not")
            checks += own
    failed = [check for check in checks if not check["holds"]]
    output.json(json, checks)
    output.table(failed, title="does not hold", columns=("where", "what", "detail"))
    for line in summary:
        output.line(line)
    raise typer.Exit(1 if failed else 0)


app.command()(publishing.publish)
app.command()(publishing.fetch)
app.command()(publishing.export)


app.command()(scoring.score)
app.command()(mutants.mutants)
app.command()(report.report)
app.command()(benchmarks)
app.add_typer(peers.app, name="peers")


@app.command()
def claims(
    papers: Annotated[
        list[str] | None,
        typer.Argument(metavar="PAPER...", help="loginov2013, lebedev1989, chelnokov1991, sokolov2024."),
    ] = None,
    verdict: Annotated[str | None, typer.Option(help="Only claims with this verdict.")] = None,
    stories: Annotated[bool, typer.Option(help="Tell also what lies behind the cells that differ.")] = True,
    json: JsonFile = None,
) -> None:
    """Recompute every number and statement that the papers print, each with a verdict."""
    from sinsbench.cli.claims import (
        changed_verdicts,
        check_verdict,
        claim_rows,
        claim_table,
        story_tables,
        verdict_counts,
    )
    from sinsbench.cli.output import Output

    output = Output()
    output.check(json)
    check_verdict(verdict)
    with output.progress("recomputing") as progress:
        rows = claim_rows(papers or None, progress)
        told = story_tables(papers or None, progress) if stories else []
    output.json(json, [row for row in rows if verdict in (None, row["verdict"])])
    output.table(claim_table(rows, verdict), title="what the papers print")
    output.table(verdict_counts(rows), title="verdicts of all of them")
    for title, table, sentence in told:
        output.table(table, title=title)
        output.line(sentence)
    changed = changed_verdicts(rows)
    for line in changed:
        output.line(line)
    raise typer.Exit(1 if changed else 0)


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for summary, tables and data.")] = Path(
        "sinsbench-results"
    ),
) -> None:
    """Generate, verify, score and judge the papers' own cases, and sum up what holds, on a page too."""
    from sinsbench.cli.output import Output
    from sinsbench.reproduction.run import reproduce as reproduce_all
    from sinsbench.reproduction.summary import show

    output = Output()
    with output.progress("reproducing the papers") as progress:
        result = reproduce_all(out, progress)
    show(result, output)
    raise typer.Exit(0 if result.holds else 1)


@app.command()
def cite(
    what: Annotated[list[str] | None, typer.Argument(metavar="NAME...", help="A paper, dataset or subject.")] = None,
) -> None:
    """Print BibTeX for the benchmark and the papers behind it."""
    from sinsbench.cli.citations import citations

    typer.echo("\n\n".join(citations(what or [])))
