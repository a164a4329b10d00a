"""Results made into a page and figures on disk."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sinsbench.cli.output import Output
from sinsbench.report.figures import write_figures
from sinsbench.report.page import page
from sinsbench.report.results import ReportError, Results
from sinsbench.report.sections import sections
from sinsbench.report.series import Progress

__all__ = ["PAGE", "Written", "write_report"]

PAGE = "report.html"
"""Name of the page in its folder."""


@dataclass(frozen=True)
class Written:
    """The files of a report.

    Attributes
    ----------
    page : Path
    figures : tuple of Path
    """

    page: Path
    figures: tuple[Path, ...] = ()


def write_report(
    results: Results,
    out: Path,
    figures: Path | None = None,
    progress: Progress = lambda done, total, what: None,
) -> Written:
    """Write the page of results, and their figures.

    Parameters
    ----------
    results : Results
    out : Path
        Folder for the page, made if it is not there.
    figures : Path, optional
        Folder for the charts as SVG and PNG.
    progress : callable
        ``progress(done, total, what)``.

    Raises
    ------
    ReportError
        If a folder is a file.
    """
    for folder in (out, figures):
        if folder is not None and folder.exists() and not folder.is_dir():
            raise ReportError(f"{folder}: a folder is needed, and this is a file")
    made = sections(results, progress)
    filled = page(results, made)
    out.mkdir(parents=True, exist_ok=True)
    for name, text in filled.beside.items():
        (out / name).parent.mkdir(exist_ok=True)
        Output().text(out / name, text)
    Output().text(out / PAGE, filled.html)
    drawn = () if figures is None else tuple(write_figures(made, figures))
    return Written(out / PAGE, drawn)
