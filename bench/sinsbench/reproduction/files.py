"""The files of a reproduction: summary in Markdown, everything else as JSON."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sinsbench.cli.output import Output
from sinsbench.reproduction.summary import markdown

if TYPE_CHECKING:
    from sinsbench.reproduction.run import Reproduction


def write_results(result: Reproduction) -> list[Path]:
    """Write the files of a run, each whole or not at all.

    Returns
    -------
    list of Path
        The JSON files, of which the page is made.
    """
    output = Output()
    contents = {
        "environment": result.environment,
        "datasets": result.datasets,
        "scores": result.scores,
        "claims": result.claims,
        "stories": [{"title": title, "sentence": sentence, "rows": rows} for title, rows, sentence in result.stories],
    }
    files = []
    for name, content in contents.items():
        files.append(result.folder / f"{name}.json")
        output.json(files[-1], content)
    output.text(result.folder / "summary.md", markdown(result))
    return files
