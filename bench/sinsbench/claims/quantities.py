"""Enclosed values, units, and the rounding that decides whether a value is the one printed.

A recomputed value is an interval with rational ends that contains it. Everything here is exact rational
arithmetic: no binary64 decides a half-way case. What is printed is a number, a relation such as ``= 0``, where a paper
states one without figures, or a word.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import cache
from math import floor

from flint import arb

from sinsref.arithmetic import BallArithmetic, Number
from sinsref.pi_monomials import PiMonomial

#: Units that convert into each other, as multiples of the first of each row; "m" along an arc needs a radius.
ANGLE_UNITS = ("rad", "deg", "m")
TIME_UNITS = ("s", "min")

_BITS = 256


@dataclass(frozen=True)
class Enclosure:
    """A real number known to lie between two fractions.

    Attributes
    ----------
    lower, upper : Fraction
        The ends; equal for a number that is known exactly.
    """

    lower: Fraction
    upper: Fraction

    @classmethod
    def exact(cls, value: Fraction | float | str) -> "Enclosure":
        """Enclose a number without width; a float means the binary64 it is, a string its decimal."""
        number = Fraction(value)
        return cls(number, number)

    @classmethod
    def of(cls, number: Number) -> "Enclosure":
        """Enclose a ball, or a rational number that was kept exact; call it at the precision of the ball."""
        if isinstance(number, PiMonomial):
            if number.power == 0:
                return cls.exact(number.coefficient)
            number = number.ball()
        return cls(_fraction(number.lower()), _fraction(number.upper()))

    def __mul__(self, other: "Enclosure") -> "Enclosure":
        ends = [x * y for x in (self.lower, self.upper) for y in (other.lower, other.upper)]
        return Enclosure(min(ends), max(ends))

    def __truediv__(self, other: "Enclosure") -> "Enclosure":
        return self * Enclosure(1 / other.upper, 1 / other.lower)

    def __neg__(self) -> "Enclosure":
        return Enclosure(-self.upper, -self.lower)

    @property
    def middle(self) -> Fraction:
        """The middle of the interval."""
        return (self.lower + self.upper) / 2


def hull(*parts: Enclosure) -> Enclosure:
    """Return the smallest interval that contains all the given ones."""
    return Enclosure(min(part.lower for part in parts), max(part.upper for part in parts))


def _fraction(end: arb) -> Fraction:
    mantissa, exponent = end.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


@cache
def _pi() -> Enclosure:
    with BallArithmetic(_BITS) as balls:
        return Enclosure.of(balls.pi)


@dataclass(frozen=True)
class Quantity:
    """A value with its unit: a number, or a word where the paper prints one.

    Attributes
    ----------
    value : Enclosure or str
    unit : str
    radius : Fraction, optional
        Radius of the arc that turns an angle into a length, m.
    findings : mapping of str to str
        Of each word in question what was found, for the note.
    """

    value: Enclosure | str
    unit: str
    radius: Fraction | None = None
    findings: Mapping[str, str] = field(default_factory=dict)

    def in_unit(self, unit: str) -> Enclosure | str:
        """Return the value in another unit: among rad, deg and m along the arc, or among s and min.

        Raises
        ------
        ValueError
            If the units do not convert into each other.
        """
        if isinstance(self.value, str) or unit == self.unit:
            return self.value
        for units in (ANGLE_UNITS, TIME_UNITS):
            if self.unit in units and unit in units and (self.radius is not None or "m" not in (unit, self.unit)):
                return self.value * self._factor(unit) / self._factor(self.unit)
        raise ValueError(f"no conversion from {self.unit!r} to {unit!r}")

    def _factor(self, unit: str) -> Enclosure:
        """How many of the unit make one rad or one s."""
        if unit == "deg":
            return Enclosure.exact(Fraction(180)) / _pi()
        if unit == "m" and self.radius is not None:
            return Enclosure.exact(self.radius)
        return Enclosure.exact(Fraction(1, 60) if unit == "min" else Fraction(1))


def printed_number(text: str) -> Decimal | None:
    """Return what a printed string says, or None if it is not a finite decimal number."""
    try:
        number = Decimal(text)
    except InvalidOperation:
        return None
    return number if number.is_finite() else None


def significant_digits(number: Decimal) -> int:
    """Return how many significant digits a printed number has; trailing zeros count."""
    return len(number.as_tuple().digits)


def round_significant(value: Fraction, digits: int) -> Decimal:
    """Round to a number of significant digits, exact ties away from zero, as one rounds by hand.

    Examples
    --------
    >>> round_significant(Fraction("0.12345"), 4)
    Decimal('0.1235')
    """
    if not value:
        return Decimal(0)
    size, exponent = abs(value), len(str(abs(value).numerator)) - len(str(value.denominator)) - digits
    while size >= Fraction(10) ** (exponent + digits):
        exponent += 1
    while size < Fraction(10) ** (exponent + digits - 1):
        exponent -= 1
    units = floor(size / Fraction(10) ** exponent + Fraction(1, 2))
    if units == 10**digits:  # 9.996 with three digits becomes 10.0
        units, exponent = units // 10, exponent + 1
    return Decimal((int(value < 0), tuple(map(int, str(units))), exponent))


@dataclass(frozen=True)
class Relation:
    """A printed relation to a number.

    Attributes
    ----------
    sign : {"=", "<", ">"}
    number : Fraction
    """

    sign: str
    number: Fraction

    def holds(self, value: Enclosure, within: Fraction) -> bool:
        """Tell whether every number of an interval has the relation, an equality up to a difference `within`."""
        if self.sign == "<":
            return value.upper < self.number
        if self.sign == ">":
            return value.lower > self.number
        return self.number - within <= value.lower and value.upper <= self.number + within


def printed_relation(text: str) -> Relation | None:
    """Return the relation that a printed string such as ``< 1`` states, or None if it states none.

    Examples
    --------
    >>> printed_relation("= 0")
    Relation(sign='=', number=Fraction(0, 1))
    """
    sign, _, rest = text.partition(" ")
    number = printed_number(rest) if sign in ("=", "<", ">") else None
    return None if number is None else Relation(sign, Fraction(number))


def rounds_to(value: Enclosure | str, printed: str, within: Fraction = Fraction(0)) -> bool:
    """Tell whether a value, rounded to the printed number of significant digits, is what is printed.

    A printed zero has no significant digit: only the number zero rounds to it. An interval rounds to the print if both
    of its ends do. A printed relation must hold, an equality up to a difference `within`. A word must be the same word.
    """
    relation = printed_relation(printed)
    if isinstance(value, Enclosure) and relation is not None:
        return relation.holds(value, within)
    number = printed_number(printed)
    if isinstance(value, str) or number is None:
        return value == printed
    if not number:
        return value.lower == value.upper == 0
    digits = significant_digits(number)
    return all(round_significant(end, digits) == number for end in (value.lower, value.upper))


def interval_rounding_to(printed: str) -> Enclosure:
    """Return the interval of values that round to a printed number, ends included.

    Raises
    ------
    ValueError
        If nothing but itself rounds to it: a word, or zero.
    """
    number = printed_number(printed)
    if number is None or not number:
        raise ValueError(f"no interval rounds to {printed!r}")
    half = Fraction(10) ** int(number.as_tuple().exponent) / 2
    return Enclosure(Fraction(number) - half, Fraction(number) + half)


def written_like(value: Enclosure | str, printed: str) -> str:
    """Write a value with as many digits as a printed number has, and in its style; of a wide interval both ends.

    Examples
    --------
    >>> written_like(Enclosure.exact("-0.0134264"), "-1.3e-3")
    '-1.3e-2'
    """
    number = printed_number(printed)
    if isinstance(value, str):
        return value
    if number is None:
        return _ends(value)
    digits = significant_digits(number) if number else 4
    rounded = round_significant(value.middle, digits)
    if "e" not in printed:
        return f"{rounded:f}"
    sign, figures, _ = rounded.as_tuple()
    mantissa = ".".join(part for part in (str(figures[0]), "".join(map(str, figures[1:]))) if part)
    return f"{'-' * sign}{mantissa}e{rounded.adjusted()}"


def _ends(value: Enclosure) -> str:
    """Write an interval with six digits, or its ends where these differ, or how small it is."""
    lower, upper = (f"{float(end):.6g}" for end in (value.lower, value.upper))
    if lower == upper:
        return lower
    return f"{lower} to {upper}" if value.lower else f"below {float(value.upper):.1e}"
