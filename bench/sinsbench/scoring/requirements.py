"""Thresholds on scores: conditions such as ``drift_deg_per_h<1e-3`` that every row must meet."""

import difflib
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from sinsbench.scoring import gyroscopic, mast
from sinsbench.scoring.gyroscopic_responses import RESPONSE_FIELDS
from sinsbench.scoring.rows import SCORE_FIELDS

__all__ = ["Requirement", "RequirementError", "parse_requirement", "violations"]

_OPERATORS: Mapping[str, Callable[[Any, Any], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "<": operator.lt,
    ">": operator.gt,
}
_PATTERN = re.compile(r"\s*(\w+)\s*(<=|>=|==|<|>)\s*(.*?)\s*")
_KNOWN = tuple(
    dict.fromkeys([*SCORE_FIELDS, *(field.name for field in (*gyroscopic.FIELDS, *RESPONSE_FIELDS, *mast.FIELDS))])
)
_WORDS = {"true": True, "yes": True, "false": False, "no": False}


class RequirementError(ValueError):
    """A threshold cannot be understood; the message says what is admissible."""


@dataclass(frozen=True)
class Requirement:
    """A condition on a field of a row.

    Attributes
    ----------
    text : str
        As it was given.
    field : str
    comparison : str
        One of ``<``, ``<=``, ``>``, ``>=``, ``==``.
    value : float, bool or str
        Text and logical values with ``==`` only.
    """

    text: str
    field: str
    comparison: str
    value: float | bool | str

    def holds(self, row: Mapping[str, Any]) -> bool:
        """Return whether a row meets the condition; a field without a value does not."""
        found = row.get(self.field)
        if found is None:
            return False
        if isinstance(self.value, float) and not isinstance(self.value, bool):
            numerical = isinstance(found, int | float) and not isinstance(found, bool)
            return numerical and _OPERATORS[self.comparison](found, self.value)
        return bool(found == self.value)


def parse_requirement(text: str) -> Requirement:
    """Return the condition that a text such as ``drift_deg_per_h<1e-3`` or ``status==ok`` means.

    Raises
    ------
    RequirementError
        For another form, an unknown field, or a value that cannot be compared.
    """
    found = _PATTERN.fullmatch(text)
    if not found or not found[3]:
        raise RequirementError(f"--require {text!r}: write FIELD<NUMBER, with one of {' '.join(_OPERATORS)}")
    field, comparison, given = found.groups()
    if field not in _KNOWN:
        near = difflib.get_close_matches(field, _KNOWN, n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}?" if near else "see the fields of `sinsbench score --json`"
        raise RequirementError(f"--require {text!r}: there is no field {field!r}; {hint}")
    try:
        value: float | bool | str = float(given)
    except ValueError:
        if comparison != "==":
            raise RequirementError(f"--require {text!r}: {given!r} is no number") from None
        value = _WORDS.get(given.lower(), given)
    if isinstance(value, float) and not isfinite(value):
        raise RequirementError(f"--require {text!r}: the number must be finite")
    return Requirement(text, field, comparison, value)


def violations(requirements: Sequence[Requirement], rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return a line for each condition that a row does not meet: subject, case, field, value and threshold."""
    return [
        f"does not hold: {row['subject']} on {row['case']} at {row['interval']:g} s: "
        f"{one.field} {_shown(row, one.field)}, required {one.comparison} {one.value}"
        for row in rows
        for one in requirements
        if not one.holds(row)
    ]


def _shown(row: Mapping[str, Any], field: str) -> str:
    value = row.get(field)
    if value in (None, ""):
        return "has no value" + (f" ({row['status']})" if row["status"] != "ok" else "")
    return f"is {value:.6g}" if isinstance(value, float) else f"is {value}"
