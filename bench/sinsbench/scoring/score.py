"""Score subjects on a dataset."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from sinsbench.peers.subjects import loaded_peer
from sinsbench.scoring import gyroscopic, mast
from sinsbench.scoring.formulas import EquatorReference, equator_reference, score_formula
from sinsbench.scoring.gyroscopic_errors import KINDS, known_kind
from sinsbench.scoring.gyroscopic_responses import score_responses
from sinsbench.scoring.integrators import LADDER, Rung, ladder, score_integrator
from sinsbench.scoring.rows import SCORE_FIELDS
from sinsbench.subjects.loading import LoadedSubject, SubjectError, resolve
from sinsbench.subjects.registry import DUAL_PRECESSION, EQUATOR_ERRORS, GYRO_SYSTEMS, MAST_ANTENNA, subjects_of
from sinsdata.cases import CASE_CLASSES, Case, DualPrecessionCase, EquatorCase, GyroCase, MastCase
from sinsdata.tiers import known_dataset, paper_cases
from sinsdata.truth import mast as mast_truth
from sinsdata.truth.conventions import known_convention
from sinsdata.truth.gyroscopic import GyroMotion, sampled

__all__ = ["SCORE_FIELDS", "Progress", "Reference", "convention_of", "loaded_subjects", "prepare", "responses", "score"]

#: What an integrator is fed that declares nothing.
DEFAULT_CONVENTION = "increments"

#: Dataset -> what its subjects are fed that declare nothing, and a function that refuses any other name.
_FED: Mapping[str, tuple[str, Callable[[str], object]]] = {
    DUAL_PRECESSION: (DEFAULT_CONVENTION, known_convention),
    GYRO_SYSTEMS: (KINDS[0], known_kind),
}

#: Called with the number of parts done, the number of all, and what comes next.
Progress: TypeAlias = Callable[[int, int, str], None]

#: What the subjects of a case are given and measured against; for integrators by input convention.
Reference: TypeAlias = (
    Mapping[str, tuple[Rung, ...]] | EquatorReference | tuple[GyroMotion, ...] | mast_truth.MastMotion
)

#: The built-in ``map``, or one like it that works in several processes.
Mapper: TypeAlias = Callable[[Callable[[Case], Reference], Iterable[Case]], Iterable[Reference]]


def prepare(
    case: Case, factors: Sequence[Fraction] | None = None, conventions: Sequence[str] = (DEFAULT_CONVENTION,)
) -> Reference:
    """Compute the truth that a case is scored against, with the floors of its inputs.

    Parameters
    ----------
    case : EquatorCase, DualPrecessionCase, GyroCase or MastCase
    factors : sequence of Fraction, optional
        Ladder of sampling intervals in units of the case's, by default that of `sinsbench.scoring.integrators` or of
        `sinsbench.scoring.gyroscopic`.
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
        wanted = LADDER if factors is None else factors
        return {convention: ladder(case, wanted, convention) for convention in conventions}
    if isinstance(case, GyroCase):
        return gyroscopic.ladder(case, gyroscopic.LADDER if factors is None else factors)
    if isinstance(case, MastCase):
        return mast_truth.sampled(case)
    raise _no_contract(case)


def _no_contract(case: Case) -> ValueError:
    datasets = ", ".join((EQUATOR_ERRORS, *_FED, MAST_ANTENNA))
    return ValueError(f"{case.name} is no case to score on; datasets with subjects: {datasets}")


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
    if dataset not in _FED:
        if takes is not None:
            raise SubjectError(f"input conventions belong to {' and '.join(_FED)}, not to {dataset}")
        return loaded
    if takes is not None and all(one.subject.dataset for one in loaded):
        raise SubjectError("built-in subjects declare what they take; another convention is for subjects of your own")
    return tuple(_fed(one, dataset, takes) for one in loaded)


def _fed(one: LoadedSubject, dataset: str, takes: str | None) -> LoadedSubject:
    """Return a subject with the convention that it takes, an admissible one."""
    subject = one.subject
    if subject.takes is None and takes is not None:
        subject = replace(subject, takes=takes)
    elif takes not in (None, subject.takes) and subject.dataset is None:
        raise SubjectError(f"{subject.name} declares that it takes {subject.takes}, not {takes}")
    default, known = _FED[dataset]
    try:
        known(subject.takes or default)
    except ValueError as error:
        raise SubjectError(f"{subject.name}: {error}") from None
    return replace(one, subject=subject)


def _looked_up(one: LoadedSubject, case: Case) -> LoadedSubject:
    """Return what runs on a case: of results computed beforehand, those of the case."""
    return one if one.of_case is None else one.of_case(case.name, float(case.interval))


def _rows(one: LoadedSubject, case: Case, reference: Reference, repetitions: int, warm: bool) -> list[dict[str, Any]]:
    """Score a subject on a case; results computed beforehand have the case's own sampling interval alone."""
    subject, own = _looked_up(one, case), float(case.interval)
    if isinstance(case, EquatorCase) and isinstance(reference, EquatorReference):
        return score_formula(subject, case, reference, repetitions, warm=warm)
    if isinstance(case, DualPrecessionCase) and isinstance(reference, Mapping):
        rungs = [rung for rung in reference[convention_of(one)] if one.of_case is None or rung.motion.interval == own]
        return score_integrator(subject, case, rungs, repetitions, warm=warm)
    if isinstance(case, GyroCase) and isinstance(reference, tuple):
        motions = [motion for motion in reference if one.of_case is None or motion.interval == own]
        return gyroscopic.score_gyroscopic(subject, case, motions, repetitions, warm=warm)
    if isinstance(case, MastCase) and isinstance(reference, mast_truth.MastMotion):
        return mast.score_mast(subject, case, reference, repetitions, warm=warm)
    raise _no_contract(case)


def _of_one_dataset(on: str | Sequence[Case]) -> tuple[str, tuple[Case, ...]]:
    """Return the dataset of cases, and the cases; of a dataset's name, those of its tier ``paper``.

    Raises
    ------
    ValueError
        If the dataset is unknown, or the cases are none or of several datasets.
    """
    cases = paper_cases(known_dataset(on)) if isinstance(on, str) else tuple(on)
    datasets = [name for name, kind in CASE_CLASSES.items() if cases and all(isinstance(x, kind) for x in cases)]
    if len(datasets) != 1:
        raise ValueError("the cases to score on must be of one dataset, at least one")
    return datasets[0], cases


def score(
    subjects: Iterable[str | LoadedSubject] | None = None,
    on: str | Sequence[Case] = "dual_precession",
    progress: Progress | None = None,
    factors: Sequence[Fraction] | None = None,
    repetitions: int = 3,
    mapper: Mapper = map,
) -> list[dict[str, Any]]:
    """Score subjects: one row for each subject and case and, but for formulas, each sampling interval.

    Parameters
    ----------
    subjects : iterable of str or LoadedSubject, optional
        As `sinsbench.subjects.loading.resolve` takes them; all built-in subjects of the dataset by default.
    on : str or sequence of cases
        A dataset, for its tier ``paper``, or cases of one dataset.
    progress : callable, optional
        ``progress(done, total, what)``.
    factors : sequence of Fraction, optional
        As `prepare` takes them.
    repetitions : int, default 3
        Timed calls at most; 0 for no times.
    mapper : callable
        How the truth of the cases is computed: ``map``, or the ``map`` of a `concurrent.futures.ProcessPoolExecutor`,
        which computes ahead in other processes. Subjects always run in this process, one at a time.

    Returns
    -------
    list of dict
        Rows with the fields `SCORE_FIELDS`, on `gyro_systems` `sinsbench.scoring.gyroscopic.FIELDS`, on
        `mast_antenna` `sinsbench.scoring.mast.FIELDS`, of values that JSON can hold. A subject that
        fails has rows that say so; the others are scored all the same.

    Raises
    ------
    SubjectError
        If a subject cannot be loaded, is one of another dataset, or takes an unknown input convention.
    ValueError
        If the dataset is unknown, or the cases are none or of several datasets.
    """
    dataset, cases = _of_one_dataset(on)
    loaded = loaded_subjects(subjects, dataset)
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
    references = iter(mapper(partial(prepare, factors=factors, conventions=conventions), cases))
    for number, case in enumerate(cases):
        report(f"truth of {case.name}")
        reference = next(references)
        for one in loaded:
            report(f"{one.subject.name} on {case.name}")
            rows += _rows(one, case, reference, repetitions, number > 0)
    report("done")
    return rows


def responses(
    subjects: Iterable[str | LoadedSubject] | None = None,
    on: str | Sequence[Case] = GYRO_SYSTEMS,
    progress: Progress | None = None,
) -> list[dict[str, Any]]:
    """Tell how gyroscopic systems answer to errors of the sensors and of the start, at the cases' own intervals.

    Parameters
    ----------
    subjects, on, progress
        As for `score`.

    Returns
    -------
    list of dict
        Rows with the fields `sinsbench.scoring.gyroscopic_responses.RESPONSE_FIELDS`, one for each subject, case and
        error.

    Raises
    ------
    SubjectError
        As for `score`, and for results computed beforehand, which answer to nothing.
    ValueError
        If the cases are not of `gyro_systems`.
    """
    dataset, cases = _of_one_dataset(on)
    if dataset != GYRO_SYSTEMS:
        raise SubjectError(f"responses are those of the subjects of {GYRO_SYSTEMS}, not of {dataset}")
    loaded = loaded_subjects(subjects, dataset)
    for one in loaded:
        if one.of_case is not None:
            raise SubjectError(f"{one.subject.name}: results computed beforehand do not answer to other inputs")
    rows: list[dict[str, Any]] = []
    for number, case in enumerate(case for case in cases if isinstance(case, GyroCase)):
        if progress is not None:
            progress(number, len(cases), f"responses on {case.name}")
        truth = sampled(case)
        for one in loaded:
            rows += score_responses(one, case, truth)
    return rows
