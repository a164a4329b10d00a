"""Which cases are made, and on which a score is taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from sinsbench.cli.errors import UsageError
from sinsbench.peers.subjects import loaded_peer
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import BUILT_IN
from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.tiers import cases_from_toml, cases_of, paper_cases
from sinsdata.verification.stored_cases import find_datasets, load_cases

if TYPE_CHECKING:
    from sinsbench.subjects.processes import Limits


@dataclass(frozen=True)
class Guests:
    """The subjects of a command line that are not built in, as it names them.

    Attributes
    ----------
    commands : tuple of str
        Programs.
    results : tuple of Path
        Files of results.
    names : tuple of str
        Names of programs and files of results, in this order; those left over are named after the files.
    takes : str or None
        Input convention.
    suffix : str
        Format of the programs' tables.
    samples_per_step : int or None
        Samples that a step of the programs consumes.
    isolated : bool
        Whether callables run in processes of their own.
    limits : Limits
    """

    commands: tuple[str, ...]
    results: tuple[Path, ...]
    names: tuple[str, ...]
    takes: str | None
    suffix: str
    samples_per_step: int | None
    isolated: bool
    limits: Limits

    def __post_init__(self) -> None:
        named = len(self.commands) + len(self.results)
        if len(self.names) > named:
            raise UsageError(f"--name {self.names[named]}: there are {named} programs and files of results to name")
        if self.commands:
            return
        if self.samples_per_step is not None:
            which = "a callable has it as an attribute"
            raise UsageError(f"--samples-per-step {self.samples_per_step} is for programs (--command); {which}")
        if self.suffix != "csv":
            raise UsageError(f"--format {self.suffix} is for programs (--command)")

    @property
    def texts(self) -> tuple[str, ...]:
        """Programs and files of results, as the command line has them."""
        return (*self.commands, *map(str, self.results))

    def subjects(self, texts: Sequence[str], dataset: str, cases: Sequence[Case]) -> list[str | LoadedSubject] | None:
        """Return the subjects that a command line asks for; None for all built-in ones.

        Raises
        ------
        sinsbench.subjects.loading.SubjectError
            If one cannot be had.
        """
        from sinsbench.elsewhere.programs import numbered, program
        from sinsbench.elsewhere.results import result_file
        from sinsbench.subjects.isolated import isolated_subject

        if not texts and not self.texts:
            return None
        chosen: list[str | LoadedSubject] = [
            isolated_subject(text, self.limits) if self.isolated and ":" in text else text for text in texts
        ]
        names = [*self.names, *[None] * (len(self.texts) - len(self.names))]
        made = [
            program(
                command,
                dataset,
                takes=self.takes,
                name=name,
                suffix=self.suffix,
                samples_per_step=self.samples_per_step,
                limits=self.limits,
            )
            for command, name in zip(self.commands, names, strict=False)
        ]
        held = [case.name for case in cases]
        made += [
            result_file(path, dataset, held, takes=self.takes, name=name)
            for path, name in zip(self.results, names[len(self.commands) :], strict=True)
        ]
        unique = list(numbered([*texts, *(one.subject.name for one in made)]))[len(texts) :]
        return chosen + [
            replace(one, subject=replace(one.subject, name=name)) for one, name in zip(made, unique, strict=True)
        ]


def cases_to_generate(dataset: str, tier: str | None, file: Path | None) -> tuple[str, Sequence[Case]]:
    """Return the tier that is made, and its cases: those of a declared tier, or a file's, which are the tier ``sweep``.

    Raises
    ------
    UsageError
        If both a tier and a file are given.
    sinsdata.tiers.CaseFileError
        For an unknown dataset or tier, and for a file that cannot be used.
    """
    if file is None:
        return tier or "paper", cases_of(dataset, tier or "paper")
    if tier not in (None, "sweep"):
        raise UsageError("--cases and --tier exclude one another: your own cases are the tier sweep")
    return "sweep", cases_from_toml(dataset, file)


def part_of(text: str | None) -> tuple[int, int] | None:
    """Return which part of how many is meant by ``I/N``.

    Raises
    ------
    UsageError
        If it is no such thing.
    """
    if text is None:
        return None
    first, slash, second = text.partition("/")
    if not (slash and first.isdecimal() and second.isdecimal() and 1 <= int(first) <= int(second)):
        raise UsageError(f"--shard {text}: must be I/N with whole numbers, 1 <= I <= N, such as 3/16")
    return int(first), int(second)


def _scored_datasets() -> list[str]:
    """Return the datasets that there are subjects for."""
    return list(dict.fromkeys(str(subject.dataset) for subject in BUILT_IN.values()))


def _which(subject: str) -> str:
    return (
        f"say what to score {subject} on: --on dual_precession (integrators), --on equator_errors (solvers), "
        "--on gyro_systems (gyroscopic systems) or --on mast_antenna (estimators)"
    )


def datasets_to_score(
    subjects: Sequence[str] | None, cases: Sequence[str] | None, guests: Sequence[str] = ()
) -> list[str]:
    """Return the datasets that built-in subjects belong to; without a subject, those that hold the cases, or all.

    Raises
    ------
    UsageError
        If a subject is not built in, so that its dataset must be said, or if they belong to several.
    sinsbench.subjects.loading.SubjectError
        If a name is neither a built-in subject nor a place in a file or module.
    """
    scored = _scored_datasets()
    for text in guests:
        raise UsageError(_which(text))
    if not subjects:
        holding = [dataset for dataset in scored if {case.name for case in paper_cases(dataset)} & set(cases or ())]
        return holding or scored
    found: set[str] = set()
    for name in subjects:
        subject = BUILT_IN.get(name) or (None if ":" in name else (loaded_peer(name) or resolve(name)).subject)
        if subject is None or subject.dataset is None:
            raise UsageError(_which(name))
        found.add(subject.dataset)
    if len(found) > 1:
        raise UsageError(f"the subjects belong to several datasets ({', '.join(sorted(found))}): score them one by one")
    return sorted(found)


def cases_to_score(dataset: str, names: Sequence[str] | None, file: Path | None = None) -> tuple[str, tuple[Case, ...]]:
    """Return dataset and cases for a dataset name or a folder, or for a dataset name and a file of cases.

    Raises
    ------
    UsageError
        For an unknown dataset or case, one that no subject is scored on, or a folder with several datasets.
    sinsdata.format.manifest.DatasetError
        For a folder that is not a dataset of this version.
    sinsdata.tiers.CaseFileError
        For a file that cannot be used.
    """
    admissible = ", ".join(_scored_datasets())
    if file is not None and dataset not in CASE_CLASSES:
        raise UsageError(f"--cases {file}: say of which dataset these cases are: --on {admissible}")
    if file is not None:
        name, cases = dataset, tuple(cases_from_toml(dataset, file))
    elif dataset in CASE_CLASSES:
        name, cases = dataset, paper_cases(dataset)
    else:
        folder = Path(dataset)
        if not folder.exists() and "://" not in dataset:
            raise UsageError(f"unknown dataset {dataset!r}; admissible: {admissible}, or a dataset's folder")
        found = find_datasets(folder)
        if len(found) > 1:
            raise UsageError(f"{folder} holds several datasets; admissible: {', '.join(map(str, found))}")
        name, cases = load_cases(found[0])
    if name not in _scored_datasets():
        raise UsageError(f"no subjects are scored on {name} yet; admissible: {admissible}")
    if not names:
        return name, cases
    known = {case.name: case for case in cases}
    for wanted in names:
        if wanted not in known:
            raise UsageError(f"unknown case {wanted!r} of {dataset}; admissible: {', '.join(known)}")
    return name, tuple(known[wanted] for wanted in dict.fromkeys(names))
