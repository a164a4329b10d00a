"""Result files of the other commands, told apart by what they hold."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

from sinsbench.dashboard import Run, is_run, read_runs
from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.tiers import CaseFileError, cases_from_toml

__all__ = ["ReportError", "Results", "Row", "positive", "read_results", "real"]

Row: TypeAlias = Mapping[str, Any]

#: Kind of rows -> keys that tell them, and keys of what a later file replaces as a whole. The first that fits is taken.
_KINDS: dict[str, tuple[frozenset[str], tuple[str, ...]]] = {
    "responses": (frozenset({"subject", "case", "error", "response_max_m"}), ("subject", "case")),
    "scores": (frozenset({"subject", "dataset", "case", "interval", "status"}), ("dataset", "subject", "case")),
    "claims": (frozenset({"paper", "id", "printed", "computed", "verdict"}), ("paper", "id")),
    "mutants": (frozenset({"subject", "kind", "defect", "verdict"}), ("subject",)),
    "stories": (frozenset({"title", "sentence", "rows"}), ("title",)),
    "datasets": (frozenset({"dataset", "checks that hold", "checks that fail"}), ("dataset",)),
    "checks": (frozenset({"where", "what", "holds"}), ("where",)),
}
#: Cases of a file that are looked at: a sweep may have millions.
_MOST_CASES = 10_000
_ENVIRONMENT = {"python", "machine", "system", "sinsbench"}
_ADMISSIBLE = (
    "what score, claims, mutants, verify and reproduce write as JSON, stored benchmark runs, and case files (TOML)"
)


class ReportError(ValueError):
    """A report cannot be made; the message says in one line which file is at fault and what would do."""


@dataclass(frozen=True)
class Results:
    """What the result files hold.

    Attributes
    ----------
    scores, responses, claims, mutants, stories, datasets, checks : list of mapping
        Rows as the commands write them.
    runs : list of sinsbench.dashboard.Run
        Stored benchmark runs.
    environment : mapping of str to str
        Machine and versions of a reproduction.
    cases : mapping of str to mapping of str to Case
        Dataset, then name: cases from files that were scored on.
    """

    scores: list[Row] = field(default_factory=list)
    responses: list[Row] = field(default_factory=list)
    claims: list[Row] = field(default_factory=list)
    mutants: list[Row] = field(default_factory=list)
    stories: list[Row] = field(default_factory=list)
    datasets: list[Row] = field(default_factory=list)
    checks: list[Row] = field(default_factory=list)
    runs: list[Run] = field(default_factory=list)
    environment: Mapping[str, str] = field(default_factory=dict)
    cases: Mapping[str, Mapping[str, Case]] = field(default_factory=dict)


def real(row: Row, name: str) -> float | None:
    """Return a finite number of a row, None for anything else."""
    value = row.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)


def positive(row: Row, name: str) -> float | None:
    """Return a positive number of a row, which alone has a place on a logarithmic axis; None for anything else."""
    value = real(row, name)
    return value if value is not None and value > 0 else None


def read_results(paths: Iterable[Path]) -> Results:
    """Read result files.

    Parameters
    ----------
    paths : iterable of Path
        JSON files, or folders: of these every result below them is read, and other JSON files are passed over. Where
        two files hold results of the same thing, the later file counts. TOML files are of cases that were scored on.

    Returns
    -------
    Results

    Raises
    ------
    ReportError
        If a file or folder is missing, is no JSON, or holds no result, or a case file fits no dataset that was scored.
    """
    found: dict[str, dict[tuple[Any, ...], list[Row]]] = {kind: {} for kind in _KINDS}
    runs: list[Path] = []
    environment: dict[str, str] = {}
    listed = list(paths)
    case_files = [path for path in listed if path.suffix == ".toml" and path.is_file()]
    for path in listed:
        if path in case_files:
            continue
        files = _files(path)
        known = 0
        for file in files:
            document = _parsed(file)
            kind = _kind(document)
            if is_run(document):
                runs.append(file)
            elif kind is not None:
                found[kind] |= _grouped(document, kind)
            elif isinstance(document, dict) and document.keys() >= _ENVIRONMENT:
                environment |= {str(name): str(value) for name, value in document.items()}
            elif document != []:
                continue
            known += 1
        if not known:
            raise ReportError(f"{path}: {'no file in it' if path.is_dir() else 'it'} is a result: {_ADMISSIBLE}")
    rows: dict[str, list[Row]] = {
        kind: [row for group in groups.values() for row in group] for kind, groups in found.items()
    }
    cases = _cases(case_files, rows["scores"])
    return Results(**rows, runs=read_runs(dict.fromkeys(runs)), environment=environment, cases=cases)


def _cases(files: Iterable[Path], scores: Iterable[Row]) -> dict[str, dict[str, Case]]:
    """Return those cases of files that were scored on; a file is of whichever dataset its cases are admissible in."""
    names: dict[str, set[str]] = {}
    for row in scores:
        names.setdefault(row["dataset"], set()).add(row["case"])
    found: dict[str, dict[str, Case]] = {}
    for file in files:
        complaint = f"{file}: a case file, but nothing was scored on a dataset"
        for dataset in (name for name in names if name in CASE_CLASSES):
            try:
                cases = cases_from_toml(dataset, file)
            except CaseFileError as error:
                complaint = str(error)
                continue
            known = {case.name: case for case in islice(cases, _MOST_CASES) if case.name in names[dataset]}
            found[dataset] = found.get(dataset, {}) | known
            break
        else:
            raise ReportError(complaint)
    return found


def _files(path: Path) -> Sequence[Path]:
    if path.is_dir():
        return sorted(file for file in path.rglob("*.json") if file.is_file())
    if not path.exists():
        raise ReportError(f"{path}: there is no such file; admissible: {_ADMISSIBLE}, or a folder of them")
    return [path]


def _parsed(file: Path) -> Any:
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ReportError(f"{file}: not JSON: {' '.join(str(error).split())}") from None


def _kind(document: Any) -> str | None:
    """Return the kind that all rows of a document are of."""
    if not isinstance(document, list) or not document or not all(isinstance(row, dict) for row in document):
        return None
    common = frozenset.intersection(*(frozenset(row) for row in document))
    return next((kind for kind, (keys, _) in _KINDS.items() if keys <= common), None)


def _grouped(rows: Iterable[Row], kind: str) -> dict[tuple[Any, ...], list[Row]]:
    groups: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(str(row[name]) for name in _KINDS[kind][1]), []).append(row)
    return groups
