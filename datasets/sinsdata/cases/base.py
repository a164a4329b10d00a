"""What the cases of all datasets share: exact numbers, admissible values, whole numbers of intervals."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, ClassVar, Self

from sinsref.exact import ExactNumber, ExpressionError
from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic
from sinsref.profiles import Profile

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,63}")
_MAXIMUM_SAMPLES = 10**9
#: Magnitudes of numbers other than 0. The few that meet in a formula then have a product far inside the range of
#: binary64, rests included.
_SMALLEST, _LARGEST = 1e-30, 1e30


class CaseError(ValueError):
    """A case is not admissible; the message says which field, which value, and what would do."""

    def __init__(self, field: str, value: object, admissible: str) -> None:
        super().__init__(f"{field if _is_plain(field) else _short(field)} = {_short(value)}: {admissible}")
        self.field = field


def _is_plain(text: str) -> bool:
    return len(text) <= 60 and text.isprintable()


def _short(value: object) -> str:
    if isinstance(value, int) and abs(value) > _LARGEST:  # Python refuses to print very long integers
        return f"(an integer of {value.bit_length()} bits)"
    text = _text(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _text(value: object) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_text, value))}]"
    return value.text if isinstance(value, ExactNumber | Profile) and value.text.isprintable() else repr(value)


def checked_number(field: str, value: Any) -> ExactNumber:
    """Return a number that a case was given, exactly.

    Raises
    ------
    CaseError
        If it is none, or out of range.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str | ExactNumber):
        raise CaseError(field, value, 'must be a number, or a string such as "pi/18"')
    admitted = _admitted(type(value).__name__, value)
    if isinstance(admitted, str):
        raise CaseError(field, value, admitted)
    return admitted


# Cached: the cases of a sweep repeat the values of its axes, and reading one takes longer than all the rest of a case.
# The type is part of the key: 1, 1.0 and True are equal.
@lru_cache(maxsize=4096)
def _admitted(kind: str, value: float | str | ExactNumber) -> ExactNumber | str:
    """Return the number, or what would be admissible instead."""
    out_of_range = f"must be 0, or {_SMALLEST:g} to {_LARGEST:g} in magnitude"
    if isinstance(value, int) and abs(value) > _LARGEST:
        return out_of_range
    try:
        number = ExactNumber(value)
    except ExpressionError as error:
        return str(error)
    # The arithmetic of exact zeros tells 0 from what binary64 cannot.
    with PiMonomialArithmetic(256) as arithmetic:
        exact = number.evaluate(arithmetic)
        zero = isinstance(exact, PiMonomial) and not exact.coefficient
        admissible = zero or _SMALLEST <= arithmetic.magnitude(exact) * (1 + 1e-9) <= _LARGEST * (1 + 3e-9)
    return number if admissible else out_of_range


def checked_vector(field: str, value: Any, length: int) -> tuple[ExactNumber, ...]:
    """Return the numbers of a list that a case was given, exactly.

    Raises
    ------
    CaseError
        If it is no list of `length` admissible numbers.
    """
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise CaseError(field, value, f"must be a list of {length} numbers")
    if len(value) != length:
        raise CaseError(field, list(value), f"must have {length} elements, not {len(value)}")
    return tuple(checked_number(f"{field}[{i}]", x) for i, x in enumerate(value))


def check_positive(field: str, value: ExactNumber, unit: str) -> None:
    """Raise `CaseError` unless a number is greater than 0."""
    if not float(value) > 0:
        raise CaseError(field, value, f"must be greater than 0 {unit}")


def whole_intervals(duration: ExactNumber, interval: ExactNumber) -> int | None:
    """Return how many intervals a duration holds, None where that is no whole number, or less than 1 or above 1e9.

    Whole within 1e-9 of itself: 100.0 s hold 10,000 intervals of the binary64 nearest to 0.01 s.
    """
    ratio = float(duration) / float(interval)
    if not ratio < 2 * _MAXIMUM_SAMPLES:
        return None
    count = round(ratio)
    return count if 1 <= count <= _MAXIMUM_SAMPLES and abs(ratio - count) <= 1e-9 * ratio else None


class SampledCase:
    """What the cases of all datasets share: building from a mapping, name, whole number of intervals."""

    name: str
    interval: ExactNumber
    duration: ExactNumber
    _optional: ClassVar[frozenset[str]]
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @classmethod
    def from_mapping(cls, given: Mapping[str, Any]) -> Self:
        """Build a case from the keys of a case file.

        Raises
        ------
        CaseError
            For unknown or missing keys and for inadmissible values.
        """
        known = [field.name for field in fields(cls)]
        for key in given:
            if key not in known:
                near = get_close_matches(key, known, 1)
                hint = f"did you mean {near[0]!r}?" if near else f"admissible keys: {', '.join(known)}"
                raise CaseError(key, given[key], f"unknown key; {hint}")
        for key in known:
            if key not in given and key not in cls._optional:
                raise CaseError(key, "(missing)", f"is required; keys: {', '.join(known)}")
        return cls(**given)

    def _convert(self, **values: Any) -> None:
        for field, value in values.items():
            object.__setattr__(self, field, value)

    def _check_name_and_sampling(self) -> None:
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise CaseError("name", self.name, "must be 1 to 64 letters, digits, or _ . + -")
        check_positive("interval", self.interval, "s")
        check_positive("duration", self.duration, "s")
        if whole_intervals(self.duration, self.interval) is None:
            ratio = float(self.duration) / float(self.interval)
            whole = min(max(1, round(ratio)), _MAXIMUM_SAMPLES) * float(self.interval)
            raise CaseError(
                "duration",
                self.duration,
                f"must be a whole number of intervals, at most 1e9; near it: {whole:.12g} s",
            )

    @property
    def samples(self) -> int:
        """The number n of intervals; epochs are k * interval, exactly, for k = 0 ... n."""
        return whole_intervals(self.duration, self.interval) or 0
