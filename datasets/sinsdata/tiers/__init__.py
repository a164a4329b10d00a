"""The cases of the tiers: of the papers, of the strata, and from a file."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, TypeAlias

from sinsdata.cases import CASE_CLASSES, Case, CaseError, DualPrecessionCase, EquatorCase
from sinsdata.cases.mast import MastCase, refused_run
from sinsdata.tiers.error_equations import (
    ERROR_EQUATION_SHORT,
    ERROR_EQUATION_STRATA,
    error_equation_paper_cases,
    error_equation_standard_cases,
)
from sinsdata.tiers.grid import CaseFileError, GridCases
from sinsdata.tiers.gyroscopic import GYRO_SHORT, gyro_paper_cases, gyro_standard_cases, gyro_strata
from sinsdata.tiers.mast import MAST_SHORT, mast_paper_cases, mast_standard_cases, mast_strata
from sinsdata.tiers.strata import STRATA, Stratum
from sinsref.exact import ExactNumber

#: What makes the cases of a tier.
_CasesOfTier: TypeAlias = Callable[[], tuple[Case, ...]]

__all__ = [
    "TIERS_WITH_STRATA",
    "CaseFileError",
    "cases_from_toml",
    "cases_of",
    "checked_cases",
    "known_dataset",
    "paper_cases",
    "short_cases",
    "standard_cases",
    "strata_of",
    "stratum_name",
    "stratum_of",
    "tiers_of",
]  # fmt: skip


#: Tiers whose cases belong to strata.
TIERS_WITH_STRATA = ("standard", "short")


def known_dataset(name: str) -> str:
    """Return the name of a dataset.

    Raises
    ------
    CaseFileError
        If there is no such dataset.
    """
    if name not in CASE_CLASSES:
        raise CaseFileError(f"unknown dataset {name!r}; admissible: {', '.join(CASE_CLASSES)}")
    return name


def cases_of(dataset: str, tier: str) -> tuple[Case, ...]:
    """Return the cases of a tier of a dataset.

    Parameters
    ----------
    dataset : str
    tier : {"paper", "standard", "short"}

    Raises
    ------
    CaseFileError
        If there is no such dataset, or it has no such tier.
    """
    tiers = _TIERS[known_dataset(dataset)]
    if tier not in tiers:
        raise CaseFileError(f"{dataset} has no tier {tier!r}; admissible: {', '.join(tiers)}")
    return tiers[tier]()


def tiers_of(dataset: str) -> tuple[str, ...]:
    """Return the names of the declared tiers of a dataset."""
    return tuple(_TIERS[known_dataset(dataset)])


def strata_of(dataset: str) -> tuple[tuple[str, int, str], ...]:
    """Return the strata of the tier ``standard``: name, number of cases, rule."""
    if dataset == "error_equations":
        counts = Counter(stratum for _, stratum in error_equation_standard_cases())
        return tuple((name, counts[name], rule) for name, rule in ERROR_EQUATION_STRATA.items())
    if dataset == "gyro_systems":
        return gyro_strata()
    if dataset == "mast_antenna":
        return mast_strata()
    return tuple((stratum.name, stratum.count, stratum.rule) for stratum in STRATA[dataset])


def paper_cases(dataset: str) -> tuple[Case, ...]:
    """Return the tier ``paper`` of a dataset: exactly the papers' cases."""
    return cases_of(dataset, "paper")


def standard_cases(dataset: str) -> tuple[Case, ...]:
    """Return the tier ``standard`` of a dataset: all cases of its strata (`sinsdata.tiers.strata`)."""
    return cases_of(dataset, "standard")


def short_cases(dataset: str) -> tuple[Case, ...]:
    """Return the tier ``short`` of a dataset: one case with few rows from each of some strata, most of them hard."""
    return cases_of(dataset, "short")


def stratum_of(dataset: str, name: str) -> Stratum | None:
    """Return the stratum of a case of the tiers ``standard`` and ``short``, None for any other case.

    Parameters
    ----------
    dataset : str
    name : str
        Of the case, such as ``"coning_007"``.
    """
    stem, _, index = name.rpartition("_")
    if not (index.isascii() and index.isdigit()):
        return None
    strata = STRATA.get(dataset, ())
    return next(
        (s for s in strata if s.name == stem and name == s.case_name(int(index)) and int(index) < s.count), None
    )


def stratum_name(dataset: str, name: str) -> str | None:
    """Return the name of the stratum of a case of the tiers ``standard`` and ``short``, None for any other case."""
    if dataset == "error_equations":
        return {case.name: stratum for case, stratum in error_equation_standard_cases()}.get(name)
    if dataset == "gyro_systems":
        return {case.name: stratum for case, stratum in gyro_standard_cases()}.get(name)
    if dataset == "mast_antenna":
        return {case.name: stratum for case, stratum in mast_standard_cases()}.get(name)
    stratum = stratum_of(dataset, name)
    return None if stratum is None else stratum.name


def _cases_of_strata(dataset: str, short: bool) -> tuple[Case, ...]:
    numbered = (
        (stratum, index)
        for stratum in STRATA[dataset]
        for index in range(stratum.count)
        if not short or index == stratum.short
    )
    build = CASE_CLASSES[dataset].from_mapping
    return tuple(build(stratum.mapping(dataset, index)) for stratum, index in numbered)


def _loginov2013() -> tuple[Case, ...]:
    """Loginov, Tkachenko, Chelnokov 2013: initial errors (24) for two hours, and sets I-III of Table 1 for one."""
    sets = {
        "check": ("7200", ("0.01", "0.01", "0.01", "1", "1.57e-7", "1.57e-7")),
        "set1": ("3600", ("0", "0", "0", "1", "0", "0")),
        "set2": ("3600", ("0", "0", "0", "0", "1.57e-7", "0")),
        "set3": ("3600", ("0", "0", "0", "0", "0", "1.57e-7")),
    }
    return tuple(
        EquatorCase(
            name=f"{vehicle}_{name}",
            v_east=ExactNumber(v_east),
            height=ExactNumber(height),
            duration=ExactNumber(duration),
            interval=ExactNumber("10"),
            initial_errors=_exact(*errors),
        )
        for vehicle, v_east, height in (("fighter", "600", "10000"), ("ship", "10", "0"))
        for name, (duration, errors) in sets.items()
    )


def _lebedev1989() -> tuple[Case, ...]:
    """Lebedev, Panov 1989, section 6: three variants, each with coning and with general precession (eps = 1/2)."""
    variants = (
        ("variant1", ("0.5", "10"), ("10", "0", "0"), None),
        ("variant2", ("10", "100"), ("100", "0", "0"), None),
        ("variant3", ("10", "100"), ("20", "35", "40"), _exact("1", "0", "0", "0")),
    )
    # Variants 1 and 2 start at {cos theta/2, sin theta/2, 0, 0}, which is the attitude of the precession
    # frame: None.
    return tuple(
        DualPrecessionCase(
            name=f"{name}_{motion}",
            spin_rate=ExactNumber("2*pi"),
            precession_ratio=ExactNumber(eps),
            nutation=ExactNumber("pi/18"),
            spin_rate_dual=ExactNumber(duals[0]),
            nutation_dual=ExactNumber(duals[1]),
            initial_velocity=_exact(*velocity),
            interval=ExactNumber("0.01"),
            duration=ExactNumber("100"),
            initial_attitude=attitude,
        )
        for name, duals, velocity, attitude in variants
        for motion, eps in (("coning", "-1"), ("general", "1/2"))
    )


def _exact(*texts: str) -> tuple[ExactNumber, ...]:
    return tuple(ExactNumber(text) for text in texts)


def _of_strata(dataset: str) -> Mapping[str, _CasesOfTier]:
    # Cached: a case takes milliseconds to draw and check, and a tier is asked for again and again.
    return {tier: cache(partial(_cases_of_strata, dataset, tier == "short")) for tier in ("standard", "short")}


#: The tiers of each dataset.
_TIERS: Mapping[str, Mapping[str, _CasesOfTier]] = {
    "equator_errors": {"paper": _loginov2013, **_of_strata("equator_errors")},
    "dual_precession": {"paper": _lebedev1989, **_of_strata("dual_precession")},
    "error_equations": {
        "paper": cache(error_equation_paper_cases),
        "standard": cache(lambda: tuple(case for case, _ in error_equation_standard_cases())),
        "short": cache(
            lambda: tuple(case for case, _ in error_equation_standard_cases() if case.name in ERROR_EQUATION_SHORT)
        ),
    },
    "gyro_systems": {
        "paper": gyro_paper_cases,
        "standard": cache(lambda: tuple(case for case, _ in gyro_standard_cases())),
        "short": cache(lambda: tuple(case for case, _ in gyro_standard_cases() if case.name in GYRO_SHORT)),
    },
    "mast_antenna": {
        "paper": mast_paper_cases,
        "standard": cache(lambda: tuple(case for case, _ in mast_standard_cases())),
        "short": cache(lambda: tuple(case for case, _ in mast_standard_cases() if case.name in MAST_SHORT)),
    },
}


def cases_from_toml(dataset: str, path: Path) -> Sequence[Case]:
    """Read the cases of a file: one ``[[case]]`` table each, or a ``[grid]`` and a ``[case]`` with what they share.

    Parameters
    ----------
    dataset : str
        Decides which keys a case has.
    path : Path
        TOML file. A number means the binary64 it parses to, a string what it says: ``"pi/18"``, ``"1/3"``,
        ``"0.01"``. An axis of the grid is a list of values or a range ``{from = ..., to = ..., count = ...}``,
        with ``spacing = "logarithmic"`` where it is wanted.

    Returns
    -------
    sequence of Case
        Of a grid: `sinsdata.tiers.grid.GridCases`, which builds each case when it is asked for.

    Raises
    ------
    CaseFileError
        For a file that cannot be read, is not TOML, holds no case, or holds an inadmissible one.
    """
    known_dataset(dataset)
    try:
        given = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CaseFileError(f"{path}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        # Besides TOMLDecodeError and UnicodeDecodeError: integers too long to read, lists nested too deeply.
        raise CaseFileError(f"{path}: not TOML: {error}") from None
    unknown = sorted(set(given) - {"case", "grid"})
    entries, grid = given.get("case"), given.get("grid")
    if not unknown and isinstance(grid, dict) and isinstance(entries, dict | None):
        return GridCases(dataset, entries or {}, grid, str(path))
    if unknown or grid is not None or not isinstance(entries, list) or not entries:
        what = f"unknown key {unknown[0]!r}" if unknown else "no case" if grid is None else "cases beside a grid"
        raise CaseFileError(f"{path}: {what}; a case file holds [[case]] tables, or one [case] and a [grid]")
    return checked_cases(dataset, entries, str(path))


def checked_cases(dataset: str, entries: Iterable[Any], where: str) -> tuple[Case, ...]:
    """Build cases from mappings, each name once.

    Raises
    ------
    CaseFileError
        With `where`, the place of the case, the field, the value and what is admissible.
    """
    cases: dict[str, Case] = {}
    for number, entry in enumerate(entries, start=1):
        place = f"{where}: case {number}"
        if not isinstance(entry, dict):
            raise CaseFileError(f"{place}: must be a table")
        if isinstance(name := entry.get("name"), str):
            place += f" ({name[:64] if name.isprintable() else repr(name[:64])})"
        try:
            case = CASE_CLASSES[dataset].from_mapping(entry)
        except CaseError as error:
            raise CaseFileError(f"{place}: {error}") from None
        if case.name in cases:
            raise CaseFileError(f"{place}: the name occurs twice; every case needs its own")
        cases[case.name] = case
    sharing = {name: case for name, case in cases.items() if isinstance(case, MastCase)}
    for case in sharing.values():
        if (reason := refused_run(case, sharing)) is not None:
            raise CaseFileError(f"{where}: case {list(cases).index(case.name) + 1} ({case.name}): {reason}")
    return tuple(cases.values())
