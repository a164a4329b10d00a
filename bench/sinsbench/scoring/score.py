"""Score subjects on a dataset."""

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from sinsbench.scoring.formulas import EquatorReference, equator_reference, score_formula
from sinsbench.scoring.integrators import LADDER, Rung, ladder, score_integrator
from sinsbench.scoring.rows import SCORE_FIELDS
from sinsbench.subjects.loading import LoadedSubject, SubjectError, resolve
from sinsbench.subjects.registry import subjects_of
from sinsdata.cases import CASE_CLASSES, Case, DualPrecessionCase, EquatorCase
from sinsdata.tiers import known_dataset, paper_cases

__all__ = ["SCORE_FIELDS", "Progress", "Reference", "loaded_subjects", "prepare", "score"]

#: Called with the number of parts done, the number of all, and what comes next.
Progress: TypeAlias = Callable[[int, int, str], None]

#: What the subjects of a case are given and measured against.
Reference: TypeAlias = tuple[Rung, ...] | EquatorReference

#: The built-in ``map``, or one like it that works in several processes.
Mapper: TypeAlias = Callable[[Callable[[Case], Reference], Iterable[Case]], Iterable[Reference]]


def prepare(case: Case, factors: Sequence[Fraction] = LADDER) -> Reference:
    """Compute the truth that a case is scored against, with the floors of its inputs.

    Parameters
    ----------
    case : EquatorCase or DualPrecessionCase
    factors : sequence of Fraction
        Ladder of sampling intervals in units of the case's.
    """
    return equator_reference(case) if isinstance(case, EquatorCase) else ladder(case, factors)


def loaded_subjects(subjects: Iterable[str | LoadedSubject] | None, dataset: str) -> tuple[LoadedSubject, ...]:
    """Load subjects for a dataset; None stands for all built-in ones.

    Raises
    ------
    SubjectError
        If a subject cannot be loaded, or obeys the contract of another dataset.
    """
    wanted = [subject.name for subject in subjects_of(dataset)] if subjects is None else list(subjects)
    loaded = tuple(resolve(subject) if isinstance(subject, str) else subject for subject in wanted)
    for subject in (one.subject for one in loaded):
        if subject.dataset not in (None, dataset):
            raise SubjectError(f"{subject.name} is a subject of {subject.dataset}, not of {dataset}")
    return loaded


def score(
    subjects: Iterable[str | LoadedSubject] | None = None,
    on: str | Sequence[Case] = "dual_precession",
    progress: Progress | None = None,
    factors: Sequence[Fraction] = LADDER,
    repetitions: int = 3,
    mapper: Mapper = map,
) -> list[dict[str, Any]]:
    """Score subjects: one row for each subject and case and, for integrators, each sampling interval.

    Parameters
    ----------
    subjects : iterable of str or LoadedSubject, optional
        As `sinsbench.subjects.loading.resolve` takes them; all built-in subjects of the dataset by default.
    on : str or sequence of cases
        A dataset, for its tier ``paper``, or cases of one dataset.
    progress : callable, optional
        ``progress(done, total, what)``.
    factors : sequence of Fraction
        Ladder of sampling intervals in units of the case's.
    repetitions : int, default 3
        Timed calls at most; 0 for no times.
    mapper : callable
        How the truth of the cases is computed: ``map``, or the ``map`` of a `concurrent.futures.ProcessPoolExecutor`,
        which computes ahead in other processes. Subjects always run in this process, one at a time.

    Returns
    -------
    list of dict
        Rows with the fields `SCORE_FIELDS`, of values that JSON can hold. A subject that fails has rows that
        say so; the others are scored all the same.

    Raises
    ------
    SubjectError
        If a subject cannot be loaded or is one of another dataset.
    ValueError
        If the dataset is unknown, or the cases are none or of several datasets.
    """
    cases = paper_cases(known_dataset(on)) if isinstance(on, str) else tuple(on)
    datasets = [name for name, kind in CASE_CLASSES.items() if cases and all(isinstance(x, kind) for x in cases)]
    if len(datasets) != 1:
        raise ValueError("the cases to score on must be of one dataset, at least one")
    loaded = loaded_subjects(subjects, datasets[0])
    rows: list[dict[str, Any]] = []
    total, done = len(cases) * (len(loaded) + 1), 0

    def report(what: str) -> None:
        nonlocal done
        if progress is not None:
            progress(done, total, what)
        done += 1

    references = iter(mapper(partial(prepare, factors=tuple(factors)), cases))
    for number, case in enumerate(cases):
        report(f"truth of {case.name}")
        reference = next(references)
        for one in loaded:
            report(f"{one.subject.name} on {case.name}")
            if isinstance(case, EquatorCase) and isinstance(reference, EquatorReference):
                rows += score_formula(one, case, reference, repetitions, warm=number > 0)
            elif isinstance(case, DualPrecessionCase) and isinstance(reference, tuple):
                rows += score_integrator(one, case, reference, repetitions, warm=number > 0)
    report("done")
    return rows
