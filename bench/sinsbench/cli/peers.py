"""The commands for published packages: install, list, score."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from sinsbench.cli.options import JsonFile

app = typer.Typer(
    help="Published packages as subjects, each in a process and an environment of its own.", rich_markup_mode=None
)

Names = Annotated[
    list[str] | None, typer.Argument(metavar="NAME...", help="Packages or subjects, as `peers list` names them.")
]
Into = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Folder of the environments: SINSBENCH_PEERS or the cache.")
]

#: Heading -> field, for each case.
_OF_CASE = {
    "drift, deg/h": "drift_deg_per_h",
    "order": "observed_order",
    "velocity, m/s": "velocity_error_max",
    "velocity order": "velocity_observed_order",
}
#: Heading -> field, of the last case.
_OF_ALL = {
    "ns a sample": "ns_per_sample",
    "quaternion products": "relative_cost",
    "version": "version",
    "status": "status",
    "message": "message",
}


@app.command()
def install(names: Names = None, into: Into = None, json: JsonFile = None) -> None:
    """Install packages, each by itself, into environments with the newest NumPy and with NumPy before 2."""
    from dataclasses import asdict

    from sinsbench.cli.output import Output
    from sinsbench.peers.catalogue import known_packages, packages
    from sinsbench.peers.environments import environments_folder
    from sinsbench.peers.environments import install as install_packages

    output = Output()
    output.check(json)
    chosen = known_packages(names or (), packages())
    folder = into or environments_folder()
    with output.progress("installing") as progress:
        rows = [asdict(row) for row in install_packages(chosen, folder, progress)]
    output.json(json, rows)
    output.table(rows, title=f"packages in {folder}")
    raise typer.Exit(1 if any(row["status"] != "installed" for row in rows) else 0)


@app.command("list")
def list_(names: Names = None, into: Into = None, json: JsonFile = None) -> None:
    """List packages and subjects: version, convention, order, documentation."""
    from sinsbench.cli.output import Output
    from sinsbench.peers.catalogue import packages, peers_of
    from sinsbench.peers.environments import environments_folder, installed_versions

    output = Output()
    output.check(json)
    folder = into or environments_folder()
    chosen = peers_of(names or (), packages())
    versions = installed_versions([package for package, _ in chosen], folder)
    rows = [
        {
            "subject": peer.name,
            "package": package.distribution,
            "version": versions[package.distribution],
            "environment": package.environment,
            "takes": peer.takes,
            "method": peer.method,
            "order": peer.order,
            "order_coning": peer.order_coning,
            "velocity": peer.velocity,
            "convention": peer.convention,
            "documentation": package.documentation,
        }
        for package, peer in chosen
    ]
    output.json(json, rows)
    output.table(rows, title="published packages")


@app.command()
def score(
    names: Names = None,
    case: Annotated[
        list[str] | None, typer.Option(metavar="CASE", help="Case of dual_precession; may be repeated.")
    ] = None,
    beside: Annotated[
        list[str] | None, typer.Option(metavar="SUBJECT", help="Subject to score too; may be repeated.")
    ] = None,
    rungs: Annotated[
        int, typer.Option(min=2, max=6, help="Sampling intervals: twice the case's own, its own, half of it, ...")
    ] = 3,
    timeout: Annotated[float, typer.Option(help="Longest time of a process, s.")] = 120.0,
    into: Into = None,
    markdown: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the table as Markdown too.")] = None,
    json: JsonFile = None,
) -> None:
    """Score published packages beside built-in subjects, on coning and on general precession."""
    from sinsbench.cli.choices import cases_to_score
    from sinsbench.cli.output import Output, markdown_table
    from sinsbench.cli.scores import native
    from sinsbench.peers.catalogue import packages
    from sinsbench.peers.subjects import loaded_peers
    from sinsbench.scoring.integrators import LADDER
    from sinsbench.scoring.score import score as score_subjects
    from sinsbench.subjects.processes import Limits
    from sinsbench.subjects.registry import DUAL_PRECESSION

    output = Output()
    output.check(json, markdown)
    _, cases = cases_to_score(DUAL_PRECESSION, case or ["variant1_coning", "variant1_general"])
    peers = loaded_peers(names or (), folder=into, limits=Limits(timeout))
    with output.progress("scoring packages") as progress:
        rows = score_subjects(
            [*(beside or ("panov2", "panov4", "panov6")), *peers], cases, progress, factors=LADDER[:rungs]
        )
    methods = {peer.name: peer.method for package in packages() for peer in package.subjects}
    table = _compared(native(rows, cases), methods)
    output.json(json, rows)
    if markdown is not None:
        output.text(markdown, markdown_table(table) + "\n")
    output.table(table, title="published packages on dual_precession, at the cases' own interval")
    raise typer.Exit(1 if any(row["status"] not in ("ok", "not applicable") for row in rows) else 0)


def _compared(rows: Sequence[Mapping[str, Any]], methods: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return one row a subject, its cases side by side, with the headings people read."""
    table: dict[str, dict[str, Any]] = {}
    for row in rows:
        line = table.setdefault(row["subject"], {"subject": row["subject"], "method": methods.get(row["subject"])})
        for heading, name in _OF_CASE.items():
            order = name.endswith("order") and row[name] is not None
            line[f"{row['case']}: {heading}"] = f"{row[name]:.2f}" if order else row[name]
        if line.get("status", "ok") == "ok":  # what went wrong is not covered up by the next case
            line |= {heading: row[name] for heading, name in _OF_ALL.items()}
    first = next(iter(table.values()))
    used = [name for name in first if any(line[name] not in (None, "") for line in table.values())]
    used = [name for name in used if name != "status" or any(line[name] != "ok" for line in table.values())]
    tail = [name for name in used if name in _OF_ALL]
    columns = [name for name in used if name not in tail] + tail
    return [{name: line[name] for name in columns} for line in table.values()]
