"""How hard a case is: its condition, and the digits that the formulas of the papers lose in binary64.

Both are measured against the same scale: each quantity (a component of the errors on the equator, a quaternion, a
velocity) in units of its own largest size over some epochs of the case, the first, the middle and the last.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

from flint import arb

from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.truth.certified import RowFormula
from sinsdata.truth.formulas import WORKING_BITS, equator_bits, equator_state, precession_formula
from sinsref.arithmetic import Arithmetic, BallArithmetic, MpArithmetic, Number
from sinsref.equator_literal import solution as literal_solution
from sinsref.equator_modes import NoRealModesError
from sinsref.exact import ExactNumber
from sinsref.pi_monomials import PiMonomialArithmetic

#: Relative change of a parameter in a difference quotient: its square is far below two significant digits, and the
#: working precision leaves 30 digits of the difference.
_CHANGE = "1e-25"
#: Decimal digits for which mpmath works with exactly the 53 bits of binary64.
_BINARY64_DIGITS = 15
_BINARY64_BITS = 53
#: What is written where the literal formula is defined, but in binary64 divides by zero or finds no modes.
_ALL_DIGITS = 16.0


@dataclass(frozen=True)
class Difficulty:
    """How hard a case is; both numbers to two significant digits.

    Attributes
    ----------
    condition : float
        Largest change of a quantity, in units of its size, per relative change of one parameter: the worst over
        parameters, quantities and epochs. The interval between the epochs is a parameter, zeros are not changed.
    digits_lost : float or None
        Decimal digits lost by the formulas of the paper in arithmetic of 53 bits, log10(error / 2**-53), at least 0; 16
        where they break down in that arithmetic. None where they are not defined.
    """

    condition: float
    digits_lost: float | None


@dataclass(frozen=True)
class _Formulas:
    """Formulas of a dataset, exact and literal, which columns make one quantity, and the working precision."""

    exact: Callable[[Any], RowFormula]
    literal: Callable[[Any], RowFormula]
    quantities: tuple[slice, ...]
    bits: Callable[[Any], int]


_FORMULAS: Mapping[type[Any], _Formulas] = {
    EquatorCase: _Formulas(
        equator_state,
        partial(equator_state, solved=literal_solution),
        tuple(slice(i, i + 1) for i in range(6)),
        equator_bits,
    ),
    # (4.4) and (4.5) are the solution itself: its literal form is the exact one.
    DualPrecessionCase: _Formulas(
        precession_formula, precession_formula, (slice(0, 4), slice(4, 7), slice(7, 10)), lambda case: WORKING_BITS
    ),
}


def difficulty(case: Case) -> Difficulty:
    """Return how hard a case is.

    Parameters
    ----------
    case : Case
        Of `equator_errors` or `dual_precession`.
    """
    formulas = _FORMULAS[type(case)]
    epochs = sorted({1, (case.samples + 1) // 2, case.samples})
    literal = _literal(formulas, case, epochs)
    # Balls for their speed: the precision is far beyond what is needed, and the middles alone go on.
    with BallArithmetic(formulas.bits(case)) as ar:
        exact = _middles(_rows(ar, formulas.exact, case, epochs))
        scales = [max(_norm(row[part]) for row in exact) for part in formulas.quantities]

        def distance(rows: Sequence[Sequence[Number]]) -> Number:
            """Return the largest distance from the exact rows, in units of the scales."""
            return max(
                (
                    _norm([x - y for x, y in zip(row[part], true[part], strict=True)]) / scale
                    for row, true in zip(rows, exact, strict=True)
                    for part, scale in zip(formulas.quantities, scales, strict=True)
                    if scale > 0
                ),
                default=ar.number(0),
            )

        changes = (distance(_middles(_rows(ar, formulas.exact, changed, epochs))) for changed in _changed(case))
        condition = max(changes) / ar.number(_CHANGE)
        return Difficulty(_rounded(condition), None if literal is None else _digits(literal, distance))


def _middles(rows: Sequence[Sequence[Number]]) -> list[list[Number]]:
    return [[x.mid() for x in row] for row in rows]


def _rows(
    ar: Arithmetic, formula: Callable[[Any], RowFormula], case: Case, epochs: Sequence[int]
) -> list[list[Number]]:
    interval = ar.number(case.interval)
    return [list(formula(case)(ar, interval * epoch)) for epoch in epochs]


def _literal(formulas: _Formulas, case: Case, epochs: Sequence[int]) -> list[list[Number]] | str | None:
    """Return the rows of a literal formula in 53 bits; None where it is not defined, "" where that breaks down."""
    # Whether a divisor vanishes is decided with exact zeros and proven bounds, not in rounded arithmetic. The exact
    # formula is defined everywhere.
    try:
        if formulas.literal is not formulas.exact:
            with PiMonomialArithmetic(512) as balls:
                _rows(balls, formulas.literal, case, epochs[:1])
    except (NoRealModesError, ZeroDivisionError):
        return None
    try:
        return _rows(MpArithmetic(_BINARY64_DIGITS), formulas.literal, case, epochs)
    except (NoRealModesError, ZeroDivisionError):
        return ""


def _digits(literal: Any, distance: Callable[[Sequence[Sequence[Number]]], Number]) -> float:
    if literal == "":
        return _ALL_DIGITS
    units = distance([[arb(float(x)) for x in row] for row in literal]) * 2**_BINARY64_BITS
    return max(0.0, _rounded(units.log() / arb(10).log())) if units > 0 else 0.0


def _norm(vector: Sequence[Number]) -> Number:
    """Return the length of a vector of exact numbers; the radius, of a last place, is of no account."""
    return sum((x * x for x in vector), arb(0)).mid().sqrt().mid()


def _rounded(x: Number) -> float:
    return float(f"{float(x):.1e}")


def _changed(case: Case) -> Iterator[Case]:
    """Yield the case with one parameter changed at a time; what is 0 has no relative change."""
    for field in fields(case):
        if field.name in ("name", "duration"):
            continue
        for value in _one_changed(getattr(case, field.name)):
            # Around the checks: the change of an attitude leaves its norm by less than any check would notice.
            changed = copy(case)
            object.__setattr__(changed, field.name, value)
            yield changed


def _one_changed(value: Any) -> Iterator[Any]:
    if isinstance(value, tuple):
        for i, element in enumerate(value):
            yield from ((*value[:i], changed, *value[i + 1 :]) for changed in _one_changed(element))
    elif value is not None and float(value):
        yield ExactNumber(f"({value.text})*(1 + {_CHANGE})")
