"""The cases of the papers, and cases from a file."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from sinsdata.cases import CASE_CLASSES, Case, CaseError, DualPrecessionCase, EquatorCase
from sinsref.exact import ExactNumber


class CaseFileError(ValueError):
    """A case file cannot be used; the message says which file, where in it, and what would do."""


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


def paper_cases(dataset: str) -> tuple[Case, ...]:
    """Return the tier ``paper`` of a dataset: exactly the papers' cases.

    Parameters
    ----------
    dataset : {"equator_errors", "dual_precession"}
    """
    return {"equator_errors": _loginov2013, "dual_precession": _lebedev1989}[known_dataset(dataset)]()


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


def cases_from_toml(dataset: str, path: Path) -> tuple[Case, ...]:
    """Read the cases of a file with ``[[case]]`` tables.

    Parameters
    ----------
    dataset : str
        Decides which keys a case has.
    path : Path
        TOML file. A number means the binary64 it parses to, a string what it says: ``"pi/18"``, ``"1/3"``,
        ``"0.01"``.

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
    unknown = sorted(set(given) - {"case"})
    entries = given.get("case")
    if unknown or not isinstance(entries, list) or not entries:
        what = f"unknown key {unknown[0]!r}" if unknown else "no case"
        raise CaseFileError(f"{path}: {what}; a case file holds [[case]] tables and nothing else")
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
    return tuple(cases.values())
