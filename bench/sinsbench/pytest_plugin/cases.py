"""Cases as a test takes them: what the code under test is given, and the truth."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.cost import inputs_of as integrator_inputs
from sinsbench.scoring.formulas import equator_reference
from sinsbench.scoring.gyroscopic_errors import inputs_of as sensors_of
from sinsbench.scoring.gyroscopic_errors import start_of
from sinsbench.scoring.mast_errors import COLUMNS as ESTIMATES
from sinsbench.scoring.mast_errors import inputs_of as readings_of
from sinsbench.scoring.mast_errors import start_of as estimate_of
from sinsdata.cases import CASE_CLASSES, Case, DualPrecessionCase, EquatorCase, GyroCase, MastCase
from sinsdata.tiers import cases_of, tiers_of
from sinsdata.truth import mast
from sinsdata.truth.conventions import known_convention
from sinsdata.truth.gyroscopic import sampled
from sinsdata.truth.sampling import sample

__all__ = ["SuppliedCase", "UnknownCaseError", "mast_motion", "supplied_case"]

Array = NDArray[np.float64]


class UnknownCaseError(ValueError):
    """There is no such case, or nothing to feed it to; the message says what there is."""


@dataclass(frozen=True)
class SuppliedCase:
    """Inputs and truth of a case.

    Attributes
    ----------
    dataset, name : str
    takes : str
        Input convention: of `sinsdata.truth.conventions.CONVENTIONS` for ``dual_precession``, ``points`` or
        ``increments`` for ``gyro_systems``, empty for ``equator_errors`` and ``mast_antenna``.
    inputs : dict
        The arguments of the dataset's contract, by name, in their order: ``function(*case.inputs.values())``. Arrays
        are copies.
    truth : dict of str to ndarray
        Columns by name, each ``x`` with its rest ``x_lo`` except numbers of samples and on ``mast_antenna``; SI units
        and radians. Copies.
    case : Case
        What it was made from.
    """

    dataset: str
    name: str
    takes: str
    inputs: dict[str, Any] = field(repr=False)
    truth: dict[str, Array] = field(repr=False)
    case: Case = field(repr=False)


def supplied_case(dataset: str, case: str | Mapping[str, Any], takes: str | None = None) -> SuppliedCase:
    """Return a case with its certified truth.

    Parameters
    ----------
    dataset : str
        ``dual_precession``, ``equator_errors``, ``gyro_systems`` or ``mast_antenna``.
    case : str or mapping
        Name of a case of the tier ``paper`` or ``standard``, or its unambiguous beginning (of a paper's variant the
        name alone is that of the general motion, not of its coning); or the keys of a case of your own, as in a case
        file.
    takes : str, optional
        What the inputs hold: an input convention of ``dual_precession`` (``increments`` by default), ``points`` (the
        default) or ``increments`` for ``gyro_systems``.

    Returns
    -------
    SuppliedCase
        ``dual_precession``: inputs ``angle`` (n, 3), rad, ``velocity`` (n, 3), m/s, ``interval``, s, ``attitude0``
        (4,), ``velocity0`` (3,), m/s (other conventions name and shape the first three as their tables do); truth
        ``sample`` and ``time`` (m,), ``attitude`` (m, 4), ``velocity_inertial`` and ``velocity_body`` (m, 3).
        ``equator_errors``: inputs ``time`` (n,), ``v_east``, ``height``, ``initial_errors`` (6,) and, where the case
        has them, ``misalignment`` (3, 3) and ``inertial_longitude``; truth ``time``, ``state`` (n, 6).
        ``gyro_systems``: ``inputs`` and ``start`` of `sinsbench.subjects.gyroscopic.contract`; truth the arrays of
        `sinsdata.truth.gyroscopic.GyroMotion`.
        ``mast_antenna``: ``inputs`` and ``start`` of `sinsbench.subjects.mast.contract`; truth, at the ends of the n
        steps and the start, ``time``, ``mu``, ``eta``, ``lambda``, ``nu`` (n+1, 4), ``longitude``, ``latitude``,
        ``height``, ``velocity`` (n+1, 3) and ``mast_rate`` (n+1, 2).

    Raises
    ------
    UnknownCaseError
        If there is no such dataset or case, or no such convention.
    sinsdata.cases.CaseError
        If the keys of your own case are not admissible.
    """
    __tracebackhide__ = True  # of pytest: the test that asked is the place to look at
    if dataset not in _SUPPLIERS:
        raise UnknownCaseError(f"no dataset {dataset!r} to test on; admissible: {', '.join(_SUPPLIERS)}")
    found = _named(dataset, case) if isinstance(case, str) else CASE_CLASSES[dataset].from_mapping(case)
    convention, inputs, truth = _SUPPLIERS[dataset](found, takes)
    # The computed arrays are kept: whoever writes into his own spoils no other test.
    return SuppliedCase(dataset, found.name, convention, deepcopy(dict(inputs)), deepcopy(dict(truth)), found)


@lru_cache(maxsize=64)
def _named(dataset: str, name: str) -> Case:
    __tracebackhide__ = True
    # The paper's cases first: nothing of the other tiers is drawn for them.
    known: dict[str, Case] = {}
    for tier in (tier for tier in ("paper", "standard") if tier in tiers_of(dataset)):
        known |= {case.name: case for case in cases_of(dataset, tier) if case.name not in known}
        if name in known:
            return known[name]
    begun = [full for full in known if full.startswith(name)]
    if len(begun) == 1:
        return known[begun[0]]
    # A paper's variant is a motion; its coning is the special case of it.
    if f"{name}_general" in begun:
        return known[f"{name}_general"]
    near = begun or difflib.get_close_matches(name, known, n=4, cutoff=0.5) or list(known)
    more = f" ... ({len(near)} of them)" if len(near) > 8 else ""
    raise UnknownCaseError(f"{dataset} has no case {name!r}; admissible: {', '.join(near[:8])}{more}")


def _motion(case: Case, takes: str | None) -> tuple[str, Mapping[str, Any], Mapping[str, Any]]:
    if not isinstance(case, DualPrecessionCase):
        raise TypeError(f"{case.name} is no motion")
    try:
        convention = known_convention(takes or "increments")
    except ValueError as error:
        raise UnknownCaseError(str(error)) from None
    motion = sample(case, convention=convention.name)
    names = (convention.first[1], convention.second[1], "times" if convention.times else "interval")
    values = integrator_inputs(motion, len(motion.ends) - 1)
    truth = ("time", *(f"{name}{half}" for name in _COMPARED for half in ("", "_lo")))
    return (
        convention.name,
        dict(zip((*names, "attitude0", "velocity0"), values, strict=True)),
        {"sample": motion.checkpoints, **{name: getattr(motion, name) for name in truth}},
    )


_COMPARED = ("attitude", "velocity_inertial", "velocity_body")


def _equator(case: Case, takes: str | None) -> tuple[str, Mapping[str, Any], Mapping[str, Any]]:
    if not isinstance(case, EquatorCase):
        raise TypeError(f"{case.name} is no case of the equator")
    if takes is not None:
        raise UnknownCaseError(f"takes = {takes!r}: equator_errors has no input conventions")
    reference = equator_reference(case)
    names = ("time", "v_east", "height", "initial_errors")
    truth = reference.truth
    return (
        "",
        {**dict(zip(names, reference.arguments, strict=True)), **reference.keywords},
        {"time": truth.time, "state": truth.state, "state_lo": truth.state_lo},
    )


def _gyroscopic(case: Case, takes: str | None) -> tuple[str, Mapping[str, Any], Mapping[str, Any]]:
    if not isinstance(case, GyroCase):
        raise TypeError(f"{case.name} is no case of gyroscopic systems")
    convention = takes or "points"
    if convention not in ("points", "increments"):
        raise UnknownCaseError(f"takes = {takes!r}: admissible for gyro_systems: points, increments")
    motion = sampled(case)
    arrays = {one.name: getattr(motion, one.name) for one in fields(motion)}
    return (
        convention,
        {
            "inputs": sensors_of(motion, increments=convention == "increments"),
            "start": start_of(motion, float(case.radius), float(case.gravity)),
        },
        {name: value for name, value in arrays.items() if isinstance(value, np.ndarray)},
    )


@lru_cache(maxsize=2)  # 0.25 GB each for 1000 s
def mast_motion(case: MastCase) -> mast.MastMotion:
    """Return the motion of a case of ``mast_antenna``, computed once for several tests in a row."""
    return mast.sampled(case)


def _mast(case: Case, takes: str | None) -> tuple[str, Mapping[str, Any], Mapping[str, Any]]:
    if not isinstance(case, MastCase):
        raise TypeError(f"{case.name} is no case of the antenna on a mast")
    if takes is not None:
        raise UnknownCaseError(f"takes = {takes!r}: mast_antenna has no input conventions")
    motion = mast_motion(case)
    names = {name: "lam" if name == "lambda" else name for name in ("time", *ESTIMATES, "nu")}
    return (
        "",
        {"inputs": readings_of(motion), "start": estimate_of(motion.start)},
        {name: getattr(motion, attribute)[::2] for name, attribute in names.items()},
    )


_SUPPLIERS: Mapping[str, Callable[[Case, str | None], tuple[str, Mapping[str, Any], Mapping[str, Any]]]] = {
    **{
        dataset: lru_cache(maxsize=16)(supplier)
        for dataset, supplier in (
            ("dual_precession", _motion),
            ("equator_errors", _equator),
            ("gyro_systems", _gyroscopic),
        )
    },
    "mast_antenna": _mast,
}
