"""Results that were computed beforehand, as subjects: a file with the rows of each case."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from sinsbench.elsewhere.contracts import Contract, SolverContract, contract_of
from sinsbench.elsewhere.files import FORMATS, Columns, read_columns
from sinsbench.subjects.loading import LoadedSubject, SubjectError
from sinsbench.subjects.outcome import Outcome, OutcomeError
from sinsbench.subjects.registry import Subject

__all__ = ["ResultFile", "result_file"]

_SAME_TIME = 1e-3  # of an interval: times of rows may be decimals, or sums of intervals


@dataclass(frozen=True)
class ResultFile:
    """A table of results with a column ``case``.

    Attributes
    ----------
    path : Path
    columns : dict
        The columns of the file that matter.
    contract : Contract
    subject : Subject
    """

    path: Path
    columns: Columns
    contract: Contract
    subject: Subject

    def of_case(self, case: str, interval: float) -> LoadedSubject:
        """Return the results of a case as a subject that looks them up.

        Parameters
        ----------
        case : str
        interval : float
            Its sampling interval, s.
        """
        rows = np.flatnonzero(self.columns["case"] == case)
        here = {name: values[rows] for name, values in self.columns.items() if name != "case"}

        def looked_up(*arguments: Any, **keywords: Any) -> Outcome:
            if not rows.size:
                raise OutcomeError("not applicable", f"{self.path.name} holds no case {case}")
            self._check(case, here, self.contract.epochs(arguments))
            return Outcome(self.contract.result(self.path, here, rows))

        subject = replace(self.subject, samples_per_step=self._step(here, interval))
        return LoadedSubject(subject, looked_up, elsewhere=True)

    def _step(self, here: Columns, interval: float) -> int | None:
        """Return how many samples lie between the first two rows, if they tell."""
        if isinstance(self.contract, SolverContract):
            return None
        number = here["sample"] if "sample" in here else here.get("time", np.zeros(0)) / interval
        step = number[1] - number[0] if number.size > 1 else np.nan
        return round(step) if 0.5 < step < np.inf else None

    def _check(self, case: str, here: Columns, epochs: NDArray[Any]) -> None:
        """Raise `OutcomeError` unless the rows are those of equal steps, each once and in order.

        `epochs` are the times at which a row may stand.
        """
        name = "sample" if "sample" in here and self.contract.numbered else "time"
        if name not in here:
            either = "sample or time" if self.contract.numbered else "time"
            raise OutcomeError("wrong shape", f"{self.path.name} has no column {either}")
        given = here[name]

        def refuse(why: str) -> NoReturn:
            raise OutcomeError("wrong shape", f"{self.path.name}, case {case}: {why}")

        wrong = ~(np.diff(given) > 0)
        if wrong.any():
            row = int(np.argmax(wrong)) + 1
            if given[row] == given[row - 1]:
                refuse(f"{name} {given[row]:.12g} stands twice")
            refuse(f"rows out of order, {name} {given[row]:.12g} after {given[row - 1]:.12g}")
        labels = np.arange(len(epochs)) if name == "sample" else epochs
        place = _places(given, labels)
        if (place < 0).any():
            refuse(
                f"{name} {given[np.argmin(place)]:.12g} is none of this case's, {labels[0]:.12g} to {labels[-1]:.12g}"
            )
        step = 1 if isinstance(self.contract, SolverContract) or place.size < 2 else int(place[1] - place[0])
        wanted = np.arange(0, len(epochs), step)
        for which, some in (("missing", np.setdiff1d(wanted, place)), ("surplus", np.setdiff1d(place, wanted))):
            if some.size:
                rows = f"{some.size} row{'s' * (some.size > 1)} {which} of {wanted.size}"
                refuse(f"{rows}, the first of them {name} {labels[some[0]]:.12g}")


def _places(given: NDArray[Any], labels: NDArray[Any]) -> NDArray[np.intp]:
    """Return which of the ascending labels each value means, -1 for none."""
    after = np.clip(np.searchsorted(labels, given), 0, len(labels) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(given - labels[before]) < np.abs(given - labels[after]), before, after)
    spacing = np.diff(labels).min() if len(labels) > 1 else 1.0
    near = np.abs(given - labels[nearest]) <= _SAME_TIME * spacing
    result: NDArray[np.intp] = np.where(near, nearest, -1)
    return result


def result_file(
    path: Path, dataset: str, cases: Collection[str], *, takes: str | None = None, name: str | None = None
) -> LoadedSubject:
    """Make a subject of a file of results.

    Parameters
    ----------
    path : Path
        Parquet, Arrow or CSV by suffix. Columns: ``case``; ``sample`` (whole numbers, 0 at the start) or ``time`` (s);
        those of the truth that were computed.
    dataset : str
    cases : collection of str
        Names of the cases to be scored on.
    takes : str, optional
        Input convention that the results were computed from, by default that of `contract_of`.
    name : str, optional
        By default that of the file.

    Raises
    ------
    SubjectError
        If the file is none of that kind, or holds none of the cases.
    """
    contract = contract_of(dataset, takes)
    if path.is_file() and path.suffix.removeprefix(".") not in FORMATS:
        raise SubjectError(f"{path}: the suffix must be {', '.join(f'.{one}' for one in FORMATS)}")
    try:
        columns = read_columns(path, contract.outputs, ("sample", "time"), ("case",))
    except OutcomeError as error:
        raise SubjectError(str(error)) from None
    if "case" not in columns:
        raise SubjectError(f"{path.name} has no column case")
    held = list(dict.fromkeys(columns["case"].tolist()))
    if not set(held) & set(cases):
        shown = ", ".join(map(str, held[:8]))
        raise SubjectError(f"{path.name} holds none of the cases to score on ({', '.join(cases)}); it holds {shown}")
    subject = Subject(name or path.name, None, str(path), "results computed beforehand", takes=takes)
    results = ResultFile(path, columns, contract, subject)

    def unknown_case(*arguments: Any, **keywords: Any) -> Outcome:
        raise OutcomeError("not applicable", f"{path.name} is for the cases it holds")

    return LoadedSubject(subject, unknown_case, elsewhere=True, of_case=results.of_case)
