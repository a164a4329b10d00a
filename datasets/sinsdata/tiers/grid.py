"""Sweeps: every combination of the values of some axes, built case by case as they are asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from decimal import Context, Decimal
from difflib import get_close_matches
from functools import cached_property, lru_cache
from math import prod
from typing import Any, overload

from sinsdata.cases import CASE_CLASSES, Case, CaseError
from sinsdata.cases.base import checked_number
from sinsref.arithmetic import MpArithmetic
from sinsref.exact import ExactNumber, ExpressionError

MAXIMUM_CASES = 10**7
#: Values of a range that are tried before the first case is asked for, both ends among them.
_TRIED = 1000
#: Contexts of logarithms, and of the 17 significant digits of the values between the ends of a logarithmic range.
_LOGARITHM, _SHOWN = Context(prec=50), Context(prec=17)
_SPACINGS = ("linear", "logarithmic")
_RANGE_KEYS = ("from", "to", "count", "spacing")
_RANGE = "{from = ..., to = ..., count = ...}"


class CaseFileError(ValueError):
    """A case file cannot be used; the message says which file, where in it, and what would do."""


@dataclass(frozen=True)
class ListAxis:
    """An axis of listed values.

    Attributes
    ----------
    values : tuple
        As a case file gives them: numbers, strings, or lists of them for keys that take lists.
    """

    values: tuple[Any, ...]

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: int) -> Any:
        return self.values[index]


@dataclass(frozen=True)
class _Range(ABC):
    """Values between two ends.

    Attributes
    ----------
    start, end : ExactNumber
    count : int
    """

    start: ExactNumber
    end: ExactNumber
    count: int

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, index: int) -> ExactNumber:
        place = range(self.count)[index]
        if place in (0, self.count - 1):
            return self.start if place == 0 else self.end
        return _between(self, place)

    @abstractmethod
    def between(self, index: int) -> ExactNumber:
        """Return a value other than the ends."""


# Cached: walking a grid asks for the values of its axes over and over.
@lru_cache(maxsize=8192)
def _between(axis: _Range, index: int) -> ExactNumber:
    return axis.between(index)


@dataclass(frozen=True)
class LinearAxis(_Range):
    """Equidistant values, each exact: fractions of the ends, not sums of steps."""

    def between(self, index: int) -> ExactNumber:
        """Return the weighted mean of the ends: a fraction where they are, else an expression."""
        a, b, last = self.start.fraction, self.end.fraction, self.count - 1
        if a is not None and b is not None:
            value = ExactNumber((a * (last - index) + b * index) / last)
            # The text stands in the table of cases, where it is read again.
            return value if "/" not in value.text else ExactNumber(value.text)
        return ExactNumber(f"(({self.start.text})*{last - index} + ({self.end.text})*{index})/{last}")


@dataclass(frozen=True)
class LogarithmicAxis(_Range):
    """Values in constant proportion: the ends, of one sign, exactly; between them decimals of 17 significant digits."""

    @cached_property
    def _logarithms(self) -> tuple[Decimal, Decimal]:
        """Logarithms of the magnitudes of the ends."""
        with MpArithmetic(_LOGARITHM.prec) as ar:
            texts = [ar.context.nstr(abs(ar.number(x)), _LOGARITHM.prec) for x in (self.start, self.end)]
        start, end = (Decimal(text).ln(_LOGARITHM) for text in texts)
        return start, end

    def between(self, index: int) -> ExactNumber:
        """Return the weighted geometric mean of the ends, rounded."""
        start, end = self._logarithms
        ratio = _LOGARITHM.divide(Decimal(index), Decimal(self.count - 1))
        value = _LOGARITHM.fma(_LOGARITHM.subtract(end, start), ratio, start).exp(_LOGARITHM)
        # `decimal` rounds its elementary functions correctly: the same digits on every machine.
        return ExactNumber(("-" if float(self.start) < 0 else "") + str(_SHOWN.plus(value)))


Axis = ListAxis | LinearAxis | LogarithmicAxis


def axis_from(key: str, given: Any) -> Axis:
    """Return the axis that a case file describes: a list of values, or a range.

    Raises
    ------
    CaseError
        If it is neither, or a range that cannot be walked.
    """
    if isinstance(given, list):
        if not given:
            raise CaseError(key, given, "an axis needs at least one value")
        return ListAxis(tuple(given))
    if not isinstance(given, Mapping):
        raise CaseError(key, given, f"must be a list of values or a range {_RANGE}")
    for name in given:
        if name not in _RANGE_KEYS:
            raise CaseError(
                f"{key}.{name}", given[name], f"unknown key of a range; admissible: {', '.join(_RANGE_KEYS)}"
            )
    for name in ("from", "to", "count"):
        if name not in given:
            raise CaseError(f"{key}.{name}", "(missing)", f"is required in a range {_RANGE}")
    start, end = (checked_number(f"{key}.{name}", given[name]) for name in ("from", "to"))
    count, spacing = given["count"], given.get("spacing", "linear")
    if spacing not in _SPACINGS:
        raise CaseError(f"{key}.spacing", spacing, f"must be one of: {', '.join(_SPACINGS)}")
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAXIMUM_CASES:
        raise CaseError(f"{key}.count", count, f"must be an integer from 1 to {MAXIMUM_CASES}")
    if count == 1 and start != end:
        raise CaseError(f"{key}.count", count, "must be at least 2 where the ends differ")
    if spacing == "linear":
        return LinearAxis(start, end, count)
    if not float(start) * float(end) > 0:
        raise CaseError(
            f"{key}.from", given["from"], "must have the sign of `to` on a logarithmic axis, and neither may be 0"
        )
    return LogarithmicAxis(start, end, count)


class GridCases(Sequence[Case]):
    """All combinations of the values of some axes; the last axis runs fastest.

    A case is built when it is asked for, from the specification and its number alone: the sequence needs no
    memory for its cases and is small to pickle. The cases are called ``000000``, ``000001``, ..., or
    ``name_000000``, ... where the shared keys have a name.

    Parameters
    ----------
    dataset : str
        Decides which keys a case has.
    shared : mapping
        What all cases have in common, as a case file gives it.
    axes : mapping
        Key of a case -> list of values, or range.
    where : str
        What messages begin with.

    Raises
    ------
    CaseFileError
        For unknown keys, keys given twice, axes that are none, more than 1e7 cases, and for values that are not
        admissible: each listed value, and up to 1000 of each range, is tried with the first values of the other
        axes. A combination that is not admissible raises when it is asked for.
    """

    def __init__(self, dataset: str, shared: Mapping[str, Any], axes: Mapping[str, Any], where: str = "grid") -> None:
        self._dataset, self._shared, self._where = dataset, dict(shared), where
        self._prefix = self._shared.pop("name", "")
        if not isinstance(self._prefix, str):
            raise CaseFileError(f"{where}: [case] {CaseError('name', self._prefix, 'must be a string')}")
        self._check_keys(axes)
        self._axes: dict[str, Axis] = {}
        for key, given in axes.items():
            try:
                self._axes[key] = axis_from(key, given)
            except CaseError as error:
                raise CaseFileError(f"{where}: [grid] {error}") from None
        self._count = prod(len(axis) for axis in self._axes.values())
        if self._count > MAXIMUM_CASES:
            sizes = " x ".join(f"{key} {len(axis)}" for key, axis in self._axes.items())
            raise CaseFileError(f"{where}: [grid]: {self._count} cases ({sizes}); admissible: at most {MAXIMUM_CASES}")
        self._width = max(6, len(str(self._count - 1)))
        self._check_values()

    def _check_keys(self, axes: Mapping[str, Any]) -> None:
        known = [field.name for field in fields(CASE_CLASSES[self._dataset])]
        admissible = [key for key in known if key != "name"]
        if not axes:
            raise CaseFileError(f"{self._where}: [grid]: no axis; admissible: {', '.join(admissible)}")
        for place, keys in (("[case]", self._shared), ("[grid]", axes)):
            for key in keys:
                if key not in admissible:
                    near = get_close_matches(key, admissible, 1)
                    hint = f"did you mean {near[0]!r}?" if near else f"admissible: {', '.join(admissible)}"
                    raise CaseFileError(f"{self._where}: {place} {key!r}: unknown key; {hint}")
        for key in axes:
            if key in self._shared:
                raise CaseFileError(f"{self._where}: {key} stands in [case] and in [grid]; one of them must go")

    def _check_values(self) -> None:
        first = [0] * len(self._axes)
        try:
            self._build(self._name(0), first)
        except CaseError as error:
            if error.field.split("[")[0] not in self._axes:  # else the axis is named below
                raise CaseFileError(f"{self._where}: [case] {error}") from None
        for place, (key, axis) in enumerate(self._axes.items()):
            tried = len(axis) if isinstance(axis, ListAxis) else min(len(axis), _TRIED)
            for number in range(tried):
                index = number * (len(axis) - 1) // max(1, tried - 1)
                try:
                    self._build(self._name(0), [*first[:place], index, *first[place + 1 :]])
                except (CaseError, ExpressionError) as error:
                    raise CaseFileError(f"{self._where}: [grid] {key}, value {index + 1}: {error}") from None

    def _name(self, number: int) -> str:
        return f"{self._prefix}{'_' * bool(self._prefix)}{number:0{self._width}d}"

    def _build(self, name: str, places: Sequence[int]) -> Case:
        values = {key: axis[place] for (key, axis), place in zip(self._axes.items(), places, strict=True)}
        return CASE_CLASSES[self._dataset].from_mapping({"name": name, **self._shared, **values})

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Case: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Case]: ...
    def __getitem__(self, index: int | slice) -> Case | Sequence[Case]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(self._count))]
        number = range(self._count)[index]
        name = self._name(number)
        places: list[int] = []
        for axis in reversed(self._axes.values()):
            number, place = divmod(number, len(axis))
            places.insert(0, place)
        try:
            return self._build(name, places)
        except (CaseError, ExpressionError) as error:
            raise CaseFileError(f"{self._where}: [grid] case {name}: {error}") from None

    def __iter__(self) -> Iterator[Case]:
        return (self[number] for number in range(self._count))
