"""Relations between the tables of `equator_errors` and of `error_equations`.

Source: Loginov, Tkachenko, Chelnokov 2013, sections 2 to 4.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sinsdata.cases import EquatorCase
from sinsdata.cases.error_equations import ErrorEquationCase
from sinsdata.verification.double_double import DoubleDouble, nearest
from sinsdata.verification.residuals import (
    CACHED_CASES,
    DIGITS,
    Invariant,
    Residual,
    Residuals,
    differences,
    pair_names,
    values,
)
from sinsdata.verification.stored_rows import Places, Window
from sinsref.arithmetic import MpArithmetic
from sinsref.equator import EquatorModel


@lru_cache(CACHED_CASES)
def _initial_errors(case: EquatorCase | ErrorEquationCase) -> DoubleDouble:
    ar = MpArithmetic(DIGITS)
    return nearest([ar.number(x) for x in case.initial_errors])


def _starts_with_errors(window: Window) -> Residuals:
    rows = window.starts
    places = window.epochs[rows]
    stored = [x[rows] for x in values(window, "equator_errors", "truth")]
    yield from differences(places, stored, window.constants(_initial_errors, places))


def _transition_from_identity(window: Window) -> Residuals:
    rows = window.starts
    for name in pair_names("equator_errors", "transition"):
        element = window.column("transition", name)[rows]
        yield Residual(window.epochs[rows], element - int(name[1] == name[2]))


def _superposition(window: Window) -> Residuals:
    """Errors without misalignment are P(t) x(0)."""
    free = np.array([part.case.misalignment is None for part in window.parts if isinstance(part.case, EquatorCase)])
    rows = np.flatnonzero(free[window.epochs.stretch])
    places = window.epochs[rows]
    initial = window.constants(_initial_errors, places)
    for i, stored in enumerate(values(window, "equator_errors", "truth")):
        terms = [
            window.column("transition", name)[rows] * initial[int(name[2]) - 1]
            for name in pair_names("equator_errors", "transition")
            if int(name[1]) == i + 1
        ]
        yield Residual(places, sum(terms[1:], terms[0]) - stored[rows])


@lru_cache(CACHED_CASES)
def _model_constants(case: EquatorCase) -> DoubleDouble:
    ar = MpArithmetic(DIGITS)
    m = EquatorModel.at(ar, case.v_east, case.height)
    names = ("p", "q", "a24", "frame_rate", "coriolis_rate", "specific_force")
    return nearest([*(getattr(m, name) for name in names), m.gravity / m.radius])


def _modes(window: Window) -> Residuals:
    """Relations between the constants of (17): roots, rates and eigenvectors; one row a case."""
    present = np.flatnonzero(~np.isnan(window.column("modes", "omega").high))
    places = Places(np.arange(len(window.parts)), np.zeros(len(window.parts), np.int64))[present]
    known = {name: window.column("modes", name)[present] for name in pair_names("equator_errors", "modes")}
    p, q, a24, frame, coriolis, force, ratio = window.constants(_model_constants, places)
    rho1, rho2, beta, mu = (known[name] for name in ("rho1", "rho2", "beta3", "mu"))
    growing, swinging = known["alpha3_growing"], known["alpha3_swinging"]
    for residual in (
        beta * beta - rho1,
        mu * mu + rho2,
        known["omega"] * known["omega"] - ratio,
        rho1 + rho2 + p,
        rho1 * rho2 + q,
        growing * frame * 2 - (rho1 - a24),
        swinging * frame * 2 - (rho2 - a24),
        known["alpha6"] * force + beta * (coriolis + growing),
        known["nu"] * force + mu * (coriolis + swinging),
    ):
        yield Residual(places, residual)


def _linearisation(window: Window) -> Residuals:
    """Return what linearisation errors differ by from nonlinear errors less linear ones."""
    linear, nonlinear, beyond = (
        values(window, "error_equations", table) for table in ("truth", "nonlinear", "linearisation")
    )
    yield from differences(window.epochs, [x - y for x, y in zip(nonlinear, linear, strict=True)], beyond)


def _general_starts(window: Window) -> Residuals:
    rows = window.starts
    places = window.epochs[rows]
    stored = [x[rows] for x in values(window, "error_equations", "truth")]
    yield from differences(places, stored, window.constants(_initial_errors, places))


def _motion_starts(window: Window) -> Residuals:
    """Position at the start, and the square of the speed."""
    rows = window.starts
    places = window.epochs[rows]
    v_north, _, v_east, *position = (x[rows] for x in values(window, "error_equations", "motion")[:6])
    speed, *given = window.constants(_initial_position, places)
    yield from differences(places, position, given)
    yield Residual(places, v_north * v_north + v_east * v_east - speed * speed)


@lru_cache(CACHED_CASES)
def _initial_position(case: ErrorEquationCase) -> DoubleDouble:
    ar = MpArithmetic(DIGITS)
    return nearest([ar.number(x) for x in (case.speed, case.height, case.latitude, case.longitude)])


INVARIANTS = (
    Invariant(("truth",), "initial errors of the case", _starts_with_errors),
    Invariant(("transition",), "P(0) = I", _transition_from_identity),
    Invariant(("truth", "transition"), "errors without misalignment are P(t) x(0)", _superposition),
)
"""Relations between tables with a row per epoch."""

GENERAL_INVARIANTS = (
    Invariant(("motion",), "start of the motion", _motion_starts),
    Invariant(("truth",), "initial errors of the case", _general_starts),
    Invariant(("truth", "nonlinear", "linearisation"), "linearisation errors are a difference", _linearisation),
)
"""The same of `error_equations`."""

CASE_INVARIANTS = (Invariant(("modes",), "roots, rates and eigenvectors", _modes),)
"""Relations between the columns of a table with a row per case."""
