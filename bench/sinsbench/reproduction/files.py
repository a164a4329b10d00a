"""The files of a reproduction: summary in Markdown, everything else as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sinsbench.cli.output import Output
from sinsbench.reproduction.summary import markdown

if TYPE_CHECKING:
    from sinsbench.reproduction.run import Reproduction


def write_results(result: Reproduction) -> None:
    """Write the files of a run, each whole or not at all."""
    output = Output()
    output.json(result.folder / "environment.json", result.environment)
    output.json(result.folder / "datasets.json", result.datasets)
    output.json(result.folder / "scores.json", result.scores)
    output.json(result.folder / "claims.json", result.claims)
    stories = [{"title": title, "sentence": sentence, "rows": rows} for title, rows, sentence in result.stories]
    output.json(result.folder / "stories.json", stories)
    output.text(result.folder / "summary.md", markdown(result))
