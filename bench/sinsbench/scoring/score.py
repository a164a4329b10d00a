"""Score subjects on a dataset."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from sinsbench.peers.subjects import loaded_peer
from sinsbench.scoring.formulas import EquatorReference, equator_reference, score_formula
from sinsbench.scoring.integrators import LADDER, Rung, ladder, score_integrator
from sinsbench.scoring.rows import SCORE_FIELDS
from sinsbench.subjects.loading import LoadedSubject, SubjectError, resolve
from sinsbench.subjects.registry import DUAL_PRECESSION, EQUATOR_ERRORS, subjects_of
from sinsdata.cases import CASE_CLASSES, Case, DualPrecessionCase, EquatorCase
from sinsdata.tiers import known_dataset, paper_cases
from sinsdata.truth.conventions import known_convention

__all__ = ["SCORE_FIELDS", "Progress", "Reference", "convention_of", "loaded_subjects", "prepare", "score"]

#: What an integrator is fed that declares nothing.
DEFAULT_CONVENTION = "increments"

#: Called with the number of parts done, the number of all, and what comes next.
Progress: TypeAlias = Callable[[int, int, str], None]

#: What the subjects of a case are given and measured against; for integrators by input convention.
Reference: TypeAlias = Mapping[str, tuple[Rung, ...]] | EquatorReference

#: The built-in ``map``, or one like it that works in several processes.
Mapper: TypeAlias = Callable[[Callable[[Case], Reference], Iterable[Case]], Iterable[Reference]]


def prepare(
    case: Case, factors: Sequence[Fraction] = LADDER, conventions: Sequence[str] = (DEFAULT_CONVENTION,)
) -> Reference:
    """Compute the truth that a case is scored against, with the floors of its inputs.

    Parameters
    ----------
    case : EquatorCase or DualPrecessionCase
    factors : sequence of Fraction
        Ladder of sampling intervals in units of the case's.
    conventions : sequence of str
        Input conventions in which integrators are to be fed.

    Raises
    ------
    ValueError
        If subjects have no contract for cases of this kind.
    """
    if isinstance(case, EquatorCase):
        return equator_reference(case)
    if isinstance(case, DualPrecessionCase):
        return {convention: ladder(case, factors, convention) for convention in conventions}
    raise ValueError(f"{case.name} is no case to score on; datasets with subjects: {EQUATOR_ERRORS}, {DUAL_PRECESSION}")


def convention_of(loaded: LoadedSubject) -> str:
    """Return the input convention that an integrator takes."""
    return loaded.subject.takes or DEFAULT_CONVENTION


def loaded_subjects(
    subjects: Iterable[str | LoadedSubject] | None, dataset: str, takes: str | None = None
) -> tuple[LoadedSubject, ...]:
    """Load subjects for a dataset.

    Parameters
    ----------
    subjects : iterable of str or LoadedSubject, or None
        None stands for all built-in ones.
    dataset : str
    takes : str, optional
        Input convention of the subjects that declare none themselves.

    Raises
    ------
    SubjectError
        If a subject cannot be loaded or obeys the contract of another dataset, if it takes an unknown input convention,
        or if it declares another one than `takes`. Built-in subjects keep theirs.
    """
    wanted = [subject.name for subject in subjects_of(dataset)] if subjects is None else list(subjects)
    loaded = tuple((loaded_peer(one) or resolve(one)) if isinstance(one, str) else one for one in wanted)
    for subject in (one.subject for one in loaded):
        if subject.dataset not in (None, dataset):
            raise SubjectError(f"{subject.name} is a subject of {subject.dataset}, not of {dataset}")
    if dataset != DUAL_PRECESSION:
        if takes is not None:
            raise SubjectError(f"input conventions belong to {DUAL_PRECESSION}, not to {dataset}")
        return loaded
    if takes is not None and all(one.subject.dataset for one in loaded):
        raise SubjectError("built-in subjects declare what they take; another convention is for subjects of your own")
    return tuple(_fed(one, takes) for one in loaded)


def _fed(one: LoadedSubject, takes: str | None) -> LoadedSubject:
    """Return a subject with the convention that it takes, an admissible one."""
    subject = one.subject
    if subject.takes is None and takes is not None:
        subject = replace(subject, takes=takes)
    elif takes not in (None, subject.takes) and subject.dataset is None:
        raise SubjectError(f"{subject.name} declares that it takes {subject.takes}, not {takes}")
    try:
        known_convention(subject.takes or DEFAULT_CONVENTION)
    except ValueError as error:
        raise SubjectError(f"{subject.name}: {error}") from None
    return replace(one, subject=subject)


def _on_case(
    one: LoadedSubject, case: DualPrecessionCase, rungs: Sequence[Rung]
) -> tuple[LoadedSubject, Sequence[Rung]]:
    """Return what runs on a case, and on which rungs: results computed beforehand have the case's own interval."""
    if one.of_case is None:
        return one, rungs
    own = float(case.interval)
    return one.of_case(case.name, own), [rung for rung in rungs if rung.motion.interval == own]


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
        If a subject cannot be loaded, is one of another dataset, or takes an unknown input convention.
    ValueError
        If the dataset is unknown, or the cases are none or of several datasets.
    """
    cases = paper_cases(known_dataset(on)) if isinstance(on, str) else tuple(on)
    datasets = [name for name, kind in CASE_CLASSES.items() if cases and all(isinstance(x, kind) for x in cases)]
    if len(datasets) != 1:
        raise ValueError("the cases to score on must be of one dataset, at least one")
    loaded = loaded_subjects(subjects, datasets[0])
    if all(one.of_case is not None for one in loaded):
        factors = (Fraction(1),)
    rows: list[dict[str, Any]] = []
    total, done = len(cases) * (len(loaded) + 1), 0

    def report(what: str) -> None:
        nonlocal done
        if progress is not None:
            progress(done, total, what)
        done += 1

    conventions = tuple(dict.fromkeys(map(convention_of, loaded)))
    references = iter(mapper(partial(prepare, factors=tuple(factors), conventions=conventions), cases))
    for number, case in enumerate(cases):
        report(f"truth of {case.name}")
        reference = next(references)
        for one in loaded:
            report(f"{one.subject.name} on {case.name}")
            if isinstance(case, EquatorCase) and isinstance(reference, EquatorReference):
                subject = one if one.of_case is None else one.of_case(case.name, float(case.interval))
                rows += score_formula(subject, case, reference, repetitions, warm=number > 0)
            elif isinstance(case, DualPrecessionCase) and isinstance(reference, Mapping):
                subject, rungs = _on_case(one, case, reference[convention_of(one)])
                rows += score_integrator(subject, case, rungs, repetitions, warm=number > 0)
    report("done")
    return rows
