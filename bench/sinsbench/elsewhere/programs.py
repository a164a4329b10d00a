"""Programs in any language as subjects: a table in, a table out."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from sinsbench.elsewhere.contracts import Arguments, Contract, contract_of
from sinsbench.elsewhere.files import FORMATS, Columns, read_columns, write_columns
from sinsbench.subjects.loading import LoadedSubject, SubjectError
from sinsbench.subjects.outcome import Outcome, OutcomeError
from sinsbench.subjects.processes import Limits, Patience, fail, private_folder, run_process
from sinsbench.subjects.registry import DUAL_PRECESSION, GYRO_SYSTEMS, Subject

__all__ = ["Program", "numbered", "program"]

_REPETITIONS = 3
_BUDGET = 0.3  # s, after which no further repetition starts
_INTERPRETERS = (
    *("python", "node", "deno", "bun", "julia", "rscript", "octave", "perl", "ruby", "lua", "java"),
    *("sh", "bash"),
)
_STEPPED = (DUAL_PRECESSION, GYRO_SYSTEMS)  # datasets whose subjects may take several samples a step
_ORDER = ("sample", "time")  # columns that tell the order of the rows, where there is one


@dataclass
class Program:
    """A command that reads a table and writes one.

    Parameters
    ----------
    words : sequence of str
        Program and arguments; ``{input}`` and ``{output}`` in them stand for files. Without ``{input}`` the table comes
        on standard input, without ``{output}`` it goes to standard output, as CSV.
    contract : Contract
    suffix : str
        Format of the files.
    limits : Limits
    """

    words: Sequence[str]
    contract: Contract
    suffix: str
    limits: Limits
    _patience: Patience = field(default_factory=Patience, init=False)

    def __call__(self, *arguments: Any, **keywords: Any) -> Outcome:
        """Run the program on what a callable would be called with.

        Returns
        -------
        Outcome
            The times are those in a column ``seconds``, if there is one. Otherwise they are the wall times of runs less
            that of the shortest run: what is left is reading, computing and writing the rows, without the start.

        Raises
        ------
        OutcomeError
            If there is no result.
        """
        return self._patience.wait(self.contract.rows(arguments), lambda: self._outcome(arguments, keywords))

    def _outcome(self, arguments: Arguments, keywords: dict[str, Any]) -> Outcome:
        with private_folder() as folder:
            source, target = (folder / f"{name}.{self._format(name)}" for name in ("input", "output"))
            write_columns(self.contract.table(arguments, keywords), source)
            rows = self.contract.rows(arguments)
            whole = [self._run(folder, source, target, rows)]
            columns = read_columns(target, self.contract.outputs, (*_ORDER, "seconds"))
            _check_order(target, columns)
            result = self.contract.result(target, columns)
            if "seconds" in columns:
                return Outcome(result, (_told(target, columns),))
            length = len(next(iter(columns.values())))
            short_arguments, part = self.contract.shortest(arguments, length)
            if not part:
                return Outcome(result)
            beginning = folder / f"beginning.{self._format('input')}"
            write_columns(self.contract.table(short_arguments, keywords), beginning)
            short: list[float] = []
            try:
                while not short or (len(short) < _REPETITIONS and sum(whole) + sum(short) < _BUDGET):
                    if short:
                        whole.append(self._run(folder, source, target, rows))
                    short.append(self._run(folder, beginning, target, 1))
            except OutcomeError:  # one that cannot do with a single step has a result all the same, but no time
                return Outcome(result)
            times = ((seconds - min(short)) / part for seconds in whole)
            return Outcome(result, tuple(seconds for seconds in times if seconds > 0))

    def _format(self, name: str) -> str:
        return self.suffix if any(f"{{{name}}}" in word for word in self.words) else "csv"

    def _run(self, folder: Path, source: Path, target: Path, rows: int) -> float:
        """Run the program once, and return its wall time, s."""
        files = {"input": source, "output": target}
        target.unlink(missing_ok=True)
        words = list(self.words)
        for name, path in files.items():
            words = [word.replace(f"{{{name}}}", str(path)) for word in words]
        stdin, stdout = (
            None if any(f"{{{name}}}" in word for word in self.words) else path for name, path in files.items()
        )
        finished = run_process(words, folder, self.limits, rows, stdin, stdout)
        if finished.status:
            fail(finished, self.limits, rows)
        if stdout and not target.stat().st_size:
            raise OutcomeError(
                "wrong shape", f"{target.name} is empty: no standard output, and the command names no {{output}}"
            )
        if not target.exists():
            complaint = f": {finished.complaint}" if finished.complaint else ""
            raise OutcomeError("error", f"exit status 0, but it wrote no {target.name}{complaint}")
        return finished.seconds


def _check_order(path: Path, columns: Columns) -> None:
    """Raise `OutcomeError` where the rows say themselves that they are out of order."""
    for name in _ORDER:
        values = columns.get(name, np.zeros(0))
        wrong = ~(np.diff(values) > 0)
        if wrong.any():
            row = int(np.argmax(wrong)) + 1
            raise OutcomeError(
                "wrong shape", f"{path.name}: rows out of order, {name} {values[row]:g} after {values[row - 1]:g}"
            )


def _told(path: Path, columns: Columns) -> float:
    """Return the computing time that a program tells itself, s."""
    values = columns["seconds"]
    if not (values.size and np.all(values == values[0]) and 0 < values[0] < np.inf):
        raise OutcomeError("wrong shape", f"{path.name}: the column seconds must hold one positive number throughout")
    return float(values[0])


def program(
    command: str,
    dataset: str,
    *,
    takes: str | None = None,
    name: str | None = None,
    suffix: str = "csv",
    samples_per_step: int | None = None,
    limits: Limits | None = None,
) -> LoadedSubject:
    """Make a subject of a command.

    Parameters
    ----------
    command : str
        Split into words as a shell does it, but run without one.
    dataset : str
    takes : str, optional
        Input convention of an integrator, by default increments; of a gyroscopic system, by default points.
    name : str, optional
        By default that of the program or, behind an interpreter, of the script.
    suffix : {"csv", "parquet", "arrow"}
        Format of the files that ``{input}`` and ``{output}`` stand for.
    samples_per_step : int, optional
        Samples that one step of an integrator or a gyroscopic system consumes: it is given whole steps alone.
    limits : Limits, optional

    Raises
    ------
    SubjectError
        If the command is empty or ends inside a quotation, there is no such format or convention, or subjects of the
        dataset have no steps of several samples.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise SubjectError(f"--command {command}: {error}") from None
    if not words:
        raise SubjectError("--command needs a program and its arguments")
    if suffix not in FORMATS:
        raise SubjectError(f"--format {suffix}: admissible are {', '.join(FORMATS)}")
    if suffix != "csv" and "{input}" not in command and "{output}" not in command:
        raise SubjectError(f"--format {suffix} is for files: write {{input}} and {{output}} into the command")
    if samples_per_step is not None and dataset not in _STEPPED:
        which = f"--samples-per-step {samples_per_step} is for {' and '.join(_STEPPED)}"
        raise SubjectError(f"{which}; on {dataset} a program is given every row")
    subject = Subject(name or _name(words), None, command, "", samples_per_step=samples_per_step, takes=takes)
    return LoadedSubject(
        subject,
        Program(words, contract_of(dataset, takes), suffix, limits or Limits()),
        elsewhere=True,
    )


def _name(words: Sequence[str]) -> str:
    """Return the name of the program or, behind an interpreter, that of the first file it is given."""
    name = Path(words[0]).name
    scripts = [Path(word).name for word in words[1:] if Path(word).is_file()]
    return scripts[0] if scripts and name.lower().startswith(_INTERPRETERS) else name


def numbered(names: Sequence[str]) -> Iterator[str]:
    """Yield names, each after its first occurrence with a number."""
    seen: Counter[str] = Counter()
    for name in names:
        seen[name] += 1
        yield name if seen[name] == 1 else f"{name} {seen[name]}"
