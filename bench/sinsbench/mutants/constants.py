"""Defects in what a method is made of: its coefficients, its power series, its tables, as kernels are given them."""

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

__all__ = ["PARAMETERS", "Change", "changes_of", "observed"]

PARAMETERS = ("coefficients", "tables")
"""Parameters of kernels that hold what a method is made of, and not what it works on."""

#: How a number is changed.
_FACTORS: Mapping[str, float] = {"times 1.001": 1.001, "sign": -1.0, "dropped": 0.0}
#: Fields of `Coefficients` that are tables of products, and which two of their samples change places. Those of the
#: scalar product (p_i . p_j) commute.
_TABLES: Mapping[str, tuple[tuple[int, int], ...]] = {
    "pair": ((0, 1),),
    "triple": ((0, 1), (1, 2)),
    "quartic": ((2, 3), (1, 2)),
}
#: Fields that are power series. The limit up to which they serve is no coefficient of theirs.
_SERIES = ("cosine", "sine", "dual")
#: Fields of the tables of fitted methods that are numbers, and no room to work.
_NUMBERS = ("even", "odd", "mean", "half", "reciprocals", "inverses", "integrals", "weights")


@dataclass(frozen=True)
class Change:
    """A defect in a constant.

    Attributes
    ----------
    kind : {"coefficient", "series"}
    what : str
        The constant and what becomes of it.
    value : object
        What the kernels are given.
    """

    kind: str
    what: str
    value: Any


class Reading(np.ndarray[Any, np.dtype[np.float64]]):
    """An array that knows which of its elements were read one by one: tables are longer than most steps need."""

    read: set[tuple[int, ...]]

    def __getitem__(self, index: Any) -> Any:
        """Return an element, and remember that it was asked for."""
        self.read.add(index if isinstance(index, tuple) else (index,))
        return np.asarray(self)[index]


def _is_coefficients(value: Any) -> bool:
    """Whether it is a `Coefficients`, of the original module or of a copy."""
    return hasattr(value, "pair_index")


def observed(value: Any) -> Any:
    """Return the value of a parameter with arrays that know which of their elements are read."""
    if isinstance(value, np.ndarray):
        array = value.view(Reading)
        array.read = set()
        return array
    if _is_coefficients(value) or not hasattr(value, "_fields"):
        return value
    fields = zip(value._fields, value, strict=True)
    return type(value)(*(observed(x) if name in _NUMBERS or hasattr(x, "_fields") else x for name, x in fields))


def changes_of(value: Any, seen: Any) -> Iterator[Change]:
    """Return the defects that can be planted in the value of a parameter, some in each number that is not zero.

    Parameters
    ----------
    value : Coefficients or another named tuple
        Of other tuples only the fields in a list of tables are looked at; the rest is room to work.
    seen : Coefficients or another named tuple
        What `observed` made of the same, after the subject has run: what was not read is left alone.
    """
    if _is_coefficients(value):
        yield from _in_coefficients(value, (*_TABLES, "resolving", *_SERIES))
    else:
        yield from _in_tables(value, seen)


def _in_tables(tables: Any, seen: Any) -> Iterator[Change]:
    for field, value, also in zip(tables._fields, tables, seen, strict=True):
        if _is_coefficients(value):  # kept for the series of the elementary functions
            found = _in_coefficients(value, _SERIES)
        elif hasattr(value, "_fields"):
            found = _in_tables(value, also)
        elif field in _NUMBERS:
            found = _in_numbers(field, value, getattr(also, "read", None))
        else:
            continue
        for change in found:
            yield replace(change, value=tables._replace(**{field: change.value}))


def _in_numbers(name: str, value: Any, read: Container[tuple[int, ...]] | None) -> Iterator[Change]:
    numbers = np.array(value, np.float64)
    for index in map(tuple, np.argwhere(numbers).tolist()):
        if read is not None and index not in read:
            continue
        place = name + (f"[{', '.join(map(str, index))}]" if index else "")
        for what, factor in _FACTORS.items():
            other = numbers.copy()
            other[index] *= factor
            yield Change("coefficient", f"{place} {what}", other if index else float(other))
        # In a table of rows a neighbour belongs to another sample.
        after = (*index[:-1], index[-1] + 1) if len(index) > 1 else ()
        if after and after[-1] < numbers.shape[-1] and numbers[after] != numbers[index]:
            other = numbers.copy()
            other[index], other[after] = numbers[after], numbers[index]
            yield Change("coefficient", f"{place} exchanged with the next", other)


def _in_coefficients(coefficients: Any, fields: Sequence[str]) -> Iterator[Change]:
    def put(field: str, entry: int, value: Any) -> Any:
        values = list(getattr(coefficients, field))
        values[entry] = value
        return coefficients._replace(**{field: tuple(values)})

    for field in fields:
        kind = "series" if field in _SERIES else "coefficient"
        for entry, number in enumerate(getattr(coefficients, field)):
            indices = getattr(coefficients, f"{field}_index", None)
            name = f"{field}[{entry if indices is None else ', '.join(map(str, indices[entry]))}]"
            if number != 0:
                for what, factor in _FACTORS.items():
                    yield Change(kind, f"{name} {what}", put(field, entry, number * factor))
            if number != 0 and indices is not None:
                for index in _other_indices(field, indices[entry]):
                    samples = ", ".join(map(str, index))
                    yield Change(kind, f"{name} -> [{samples}]", put(f"{field}_index", entry, index))


def _other_indices(field: str, index: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Return the samples of a product with two exchanged, or one moved to its neighbour."""
    for a, b in _TABLES[field]:
        other = list(index)
        other[a], other[b] = other[b], other[a]
        if tuple(other) != index:
            yield tuple(other)
    for position, sample in enumerate(index):
        neighbour = abs(sample - 1)
        yield (*index[:position], neighbour, *index[position + 1 :])
