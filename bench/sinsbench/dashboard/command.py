"""The command that compares stored benchmark runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sinsbench.cli.options import JsonFile

if TYPE_CHECKING:
    from sinsbench.dashboard.runs import Run

_SHORT = 10  # digits of a commit


def benchmarks(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(metavar="RUN...", help="Files or folders of pytest-benchmark; .benchmarks by default."),
    ] = None,
    factor: Annotated[float, typer.Option(min=1.0, help="Ratio of times from which on there is a change.")] = 1.1,
    json: JsonFile = None,
) -> None:
    """Compare stored benchmark runs: what became slower or faster, at which commit.

    Runs of one machine are compared, in order of time. Exit status 1 if a benchmark became slower and not faster again.
    """
    from sinsbench.cli.output import Output
    from sinsbench.dashboard.comparison import compared, standing_regressions
    from sinsbench.dashboard.runs import read_runs

    output = Output()
    output.check(json)
    stored = read_runs(runs or [Path(".benchmarks")])
    rows = compared(stored, factor)
    output.json(json, rows)
    output.table(_runs(stored), title="runs")
    output.table(_latest(rows), title="the latest run of each benchmark, compared with its baseline")
    changes = [row for row in rows if row["verdict"] in ("slower", "faster", "undecided")]
    output.table([_told(row) for row in changes], title="changes")
    standing = standing_regressions(rows)
    for row in standing:
        output.line(
            f"slower: {row['benchmark']} takes {row['ratio_median']:.3g} times as long (minimum "
            f"{row['ratio_minimum']:.3g}) since {_commit(row)}, compared with {row['baseline_commit'][:_SHORT]}"
        )
    raise typer.Exit(1 if standing else 0)


def _commit(row: Mapping[str, Any]) -> str:
    return (row["commit"][:_SHORT] or "no commit") + (" with changes" if row["dirty"] else "")


def _runs(stored: Sequence[Run]) -> list[dict[str, Any]]:
    return [
        {
            "run": run.file,
            "time": run.time[:19],
            "commit": run.commit[:_SHORT],
            "with changes": run.dirty,
            "benchmarks": len(run.timings),
            "machine": run.machine,
        }
        for run in stored
    ]


def _told(row: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "benchmark": row["benchmark"].rpartition("/")[2],
        "commit": _commit(row),
        "minimum, s": row["minimum"],
        "median, s": row["median"],
        "rounds": row["rounds"],
        "since": (row["baseline_commit"] or "")[:_SHORT],
        "ratio of minima": row["ratio_minimum"],
        "of medians": row["ratio_median"],
        "of the machine": row["ratio_calibration"],
        "p": row["p_value"],
        "verdict": row["verdict"],
    }


def _latest(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [_told(row) for row in {(row["machine"], row["benchmark"]): row for row in rows}.values()]
