"""What `sinsbench generate` prints."""

from __future__ import annotations

from pathlib import Path

from sinsbench.cli.output import Output, certified
from sinsdata.generation.generate import Generated


def show_generated(made: Generated, output: Output, json: Path | None) -> None:
    """Print the tables of a dataset that was made, or what is missing to it, and write the rows as JSON."""
    if made.missing:
        output.json(json, [])
        output.line(
            f"{made.folder}: {made.shards - made.missing} of {made.shards} files are there; "
            "the job that adds the last ones completes the dataset"
        )
        return
    rows = [
        {
            "table": table,
            "rows": entry["rows"],
            "files": len(entry["files"]),
            "bytes": sum(file["bytes"] for file in entry["files"]),
            "content_sha256": entry["content_sha256"],
        }
        for table, entry in made.manifest["tables"].items()
    ]
    output.json(json, rows)
    output.table(rows, title=f"{made.folder}")
    if made.reused == made.shards:
        output.line("It was there already, byte for byte.")
    elif made.reused:
        output.line(f"{made.reused} of {made.shards} files were there from an earlier run.")
    output.line(certified(made.manifest["certification"]))
