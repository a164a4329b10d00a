"""The defects of many subjects, planted in several processes."""

from collections.abc import Callable, Sequence
from itertools import groupby

from sinsbench.mutants.runner import KINDS, Planting, plantings
from sinsbench.reproduction.parallel import Part, run_parts
from sinsbench.subjects.loading import SubjectError, resolve
from sinsbench.subjects.registry import BUILT_IN, DUAL_PRECESSION, EQUATOR_ERRORS

__all__ = ["DATASETS", "SUBJECTS", "campaign"]

DATASETS = (EQUATOR_ERRORS, DUAL_PRECESSION)
"""Datasets on whose subjects there are trials; the tests plant in those of the others."""
SUBJECTS = tuple(name for name, subject in BUILT_IN.items() if subject.dataset in DATASETS)
"""Built-in subjects that defects are planted in."""

#: Planted last: most of the defects in its terms have then been planted in a quicker subject.
_SLOWEST = "radau"


def _family(name: str) -> tuple[str, str]:
    """Return what subjects have in common that share most of their terms: the module, and in it the kind of method."""
    if name not in BUILT_IN:
        return name, ""
    module = BUILT_IN[name].target.partition(":")[0]
    if module.endswith(".fitted_integrators"):
        return module, name.rstrip("0123456789").partition("6")[0]
    return module, ""


def _planted(names: tuple[str, ...], dataset: str, kinds: tuple[str, ...]) -> list[Planting]:
    return plantings([resolve(name) for name in names], dataset, kinds)


def campaign(
    names: Sequence[str] | None = None,
    dataset: str = DUAL_PRECESSION,
    kinds: Sequence[str] = KINDS,
    report: Callable[[int, int, str], None] = lambda done, total, what: None,
) -> list[Planting]:
    """Plant the defects of subjects and judge each.

    Parameters
    ----------
    names : sequence of str, optional
        As `sinsbench.subjects.loading.resolve` takes them; `SUBJECTS` by default.
    dataset : str
        Dataset whose contract users' subjects obey, one of `DATASETS`.
    kinds : sequence of str
        Kinds of defects to plant, of `sinsbench.mutants.runner.KINDS`.
    report : callable
        ``report(done, total, what)``.

    Returns
    -------
    list of Planting
        In the order of the names. Subjects of one family are worked on in one process, so that the terms which they
        share need be planted in the first only.

    Raises
    ------
    SubjectError
        If a subject cannot be loaded, or has no Python source.
    ValueError
        If there is no such kind.
    """
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise ValueError(f"there is no kind {unknown[0]!r} of defects; admissible: {', '.join(KINDS)}")
    wanted = list(dict.fromkeys(SUBJECTS if names is None else names))
    for name in wanted:
        if name in BUILT_IN and name not in SUBJECTS:
            raise SubjectError(f"{name}: defects are planted in subjects of {' and '.join(DATASETS)}")
        if resolve(name).subject.takes not in (None, "increments"):
            raise SubjectError(f"{name}: defects are planted in integrators that take increments")
    families = [
        tuple(group)
        for _, group in groupby(sorted(wanted, key=lambda name: (_family(name), name == _SLOWEST)), _family)
    ]
    parts = [
        Part(
            family[0] if len(family) == 1 else f"{family[0]} to {family[-1]}", _planted, (family, dataset, tuple(kinds))
        )
        for family in sorted(families, key=len, reverse=True)
    ]
    found = {one.subject: one for result in run_parts(parts, report) for one in result}
    return [found[resolve(name).subject.name] for name in wanted]
