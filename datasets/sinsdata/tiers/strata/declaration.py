"""What a stratum is, and where its pseudo-random numbers come from.

The numbers are short decimals, made by integer and decimal arithmetic alone: no elementary function of a C
library takes part, whose last digit may differ from machine to machine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from hashlib import sha256
from typing import Any, TypeAlias, TypeVar

#: The seed of the published tiers.
SEED = 2013

#: Significant digits of a drawn number.
DIGITS = 4
_WORKING = Context(prec=40, rounding=ROUND_HALF_EVEN)
_SHORT = Context(prec=DIGITS, rounding=ROUND_HALF_EVEN)

_T = TypeVar("_T")


def decimal_text(value: Decimal) -> str:
    """Return a decimal as text: plain within 1e-6 ... 1e9, else with an exponent."""
    plain = not value or -6 <= value.adjusted() < 9
    shortest = value.normalize(_WORKING)
    return f"{shortest:f}" if plain else f"{shortest:e}"


@dataclass(frozen=True)
class Draw:
    """The pseudo-random numbers of one case: each a pure function of the names of dataset, stratum and field.

    Attributes
    ----------
    dataset, stratum : str
    index : int
        Number of the case in its stratum, from 0.
    """

    dataset: str
    stratum: str
    index: int

    def fraction(self, field: str) -> Fraction:
        """Return a number in [0, 1): the first 64 bits of SHA-256 of "dataset/stratum/index/field/seed"."""
        text = f"{self.dataset}/{self.stratum}/{self.index}/{field}/{SEED}"
        return Fraction(int.from_bytes(sha256(text.encode()).digest()[:8], "big"), 2**64)

    def _decimal(self, field: str) -> Decimal:
        fraction = self.fraction(field)
        return _WORKING.divide(Decimal(fraction.numerator), Decimal(fraction.denominator))

    def uniform(self, field: str, low: str, high: str) -> str:
        """Return a decimal of `DIGITS` significant digits, uniform between two bounds."""
        start, end = Decimal(low), Decimal(high)
        value = _WORKING.fma(_WORKING.subtract(end, start), self._decimal(field), start)
        return decimal_text(_SHORT.plus(value))

    def log_uniform(self, field: str, low: str, high: str) -> str:
        """Return a positive decimal of `DIGITS` significant digits whose logarithm is uniform between two bounds."""
        start, end = Decimal(low).ln(_WORKING), Decimal(high).ln(_WORKING)
        value = _WORKING.fma(_WORKING.subtract(end, start), self._decimal(field), start).exp(_WORKING)
        return decimal_text(_SHORT.plus(value))

    def signed(self, field: str, low: str, high: str) -> str:
        """Return a number of either sign whose magnitude is log-uniform between two bounds."""
        sign = self.choice(f"{field}.sign", ("", "-"))
        return sign + self.log_uniform(field, low, high)

    def integer(self, field: str, low: int, high: int) -> int:
        """Return an integer, uniform from `low` to `high`, both included."""
        return low + int(self.fraction(field) * (high - low + 1))

    def choice(self, field: str, values: Sequence[_T]) -> _T:
        """Return one of some values."""
        return values[self.integer(field, 0, len(values) - 1)]


#: The keys of a case but its name, as in a case file.
Keys: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Stratum:
    """A class of cases.

    Attributes
    ----------
    name : str
        The cases are called ``name_000``, ``name_001``, ...
    count : int
        Number of cases in the tier ``standard``.
    rule : str
        One sentence that says which cases belong to it.
    keys : callable
        ``keys(draw)`` returns the keys of the case with the dataset, stratum and index of a `Draw`.
    short : int or None
        The case that stands for the stratum in the tier ``short``.
    """

    name: str
    count: int
    rule: str
    keys: Callable[[Draw], Keys]
    short: int | None = None

    def case_name(self, index: int) -> str:
        """Return the name of a case."""
        return f"{self.name}_{index:03d}"

    def mapping(self, dataset: str, index: int) -> dict[str, Any]:
        """Return a case as a case file would give it: its name and its keys."""
        return {"name": self.case_name(index), **self.keys(Draw(dataset, self.name, index))}


def sampling(interval: str, samples: int) -> dict[str, str]:
    """Return interval and duration, the latter exactly the given number of intervals."""
    return {"interval": interval, "duration": decimal_text(_WORKING.multiply(Decimal(interval), Decimal(samples)))}
