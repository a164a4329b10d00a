"""Named slips of the pen, each a small function that is checked and not believed.

A slip takes the recomputed value, or the right form of an equation, and returns what its author would have printed, had
that slip been made; None where it could not have been made. It explains what is printed only if that result is it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import floor
from typing import Protocol

from sinsbench.claims.quantities import Enclosure, Quantity, interval_rounding_to, printed_number


class Printed(Protocol):
    """What a slip needs to know of another claim."""

    @property
    def printed(self) -> str:
        """What is printed."""

    @property
    def unit(self) -> str:
        """Its unit."""


@dataclass(frozen=True)
class Setting:
    """What surrounds a slip.

    Attributes
    ----------
    printed, unit : str
        Of the claim in question.
    radius : Fraction or None
        Radius of the arc that turns its angle into a length, m.
    claim : callable
        Returns another claim by id.
    reproduced : callable
        Tells by id whether another claim's recomputed value rounds to its print.
    """

    printed: str
    unit: str
    radius: Fraction | None
    claim: Callable[[str], Printed]
    reproduced: Callable[[str], bool]

    def converted(self, value: Enclosure, unit: str) -> Enclosure | None:
        """Convert a value of another unit to the unit of the claim; None where units do not convert."""
        try:
            result = Quantity(value, unit, self.radius).in_unit(self.unit)
        except ValueError:
            return None
        return result if isinstance(result, Enclosure) else None


def sign_dropped(value: Enclosure, setting: Setting) -> Enclosure | None:
    """Give the magnitude of a negative value, as the linear measures of the tables are."""
    return -value if value.upper < 0 else None


def wrong_exponent(value: Enclosure, setting: Setting, *, shift: int) -> Enclosure | None:
    """Write the right digits with a power of ten that is off by `shift`."""
    return value * Enclosure.exact(Fraction(10) ** shift) if shift else None


def converted_from_rounded(value: Enclosure, setting: Setting, *, of: str) -> Enclosure | None:
    """Convert the rounded number of the companion `of` in another unit, in place of the value itself."""
    companion = setting.claim(of)
    number = printed_number(companion.printed)
    if number is None or companion.unit == setting.unit or not setting.reproduced(of):
        return None
    return setting.converted(Enclosure.exact(Fraction(number)), companion.unit)


def contradicts_companion(value: Enclosure, setting: Setting, *, of: str) -> Enclosure | None:
    """Print a number that the companion `of`, the same quantity in another unit and right, rules out.

    No value rounds to both prints. How the digits went wrong is left open: the result is the printed number itself.
    """
    companion = setting.claim(of)
    if companion.unit == setting.unit or not setting.reproduced(of):
        return None
    implied = setting.converted(interval_rounding_to(companion.printed), companion.unit)
    own = interval_rounding_to(setting.printed)
    if implied is None or not (own.upper < implied.lower or implied.upper < own.lower):
        return None
    return Enclosure.exact(setting.printed)


def copied_from(value: Enclosure, setting: Setting, *, of: str) -> Enclosure | None:
    """Repeat the number of another cell `of` of the same unit."""
    other = setting.claim(of)
    number = printed_number(other.printed)
    return None if number is None or other.unit != setting.unit else Enclosure.exact(Fraction(number))


def rounded_down(value: Enclosure, setting: Setting, *, step: str) -> Enclosure | None:
    """Keep the last multiple of `step` that the value reaches, as a scan in such steps does."""
    size = Fraction(step)
    return Enclosure(floor(value.lower / size) * size, floor(value.upper / size) * size)


def symbols_lost(text: str, setting: Setting, *, right: str, wrong: str) -> str | None:
    """Leave out some symbols of the part `right` of an equation, so that `wrong` is left of it."""
    characters = iter(right)
    shortened = len(wrong) < len(right) and all(character in characters for character in wrong)
    return symbols_misread(text, setting, right=right, wrong=wrong) if shortened else None


def symbols_misread(text: str, setting: Setting, *, right: str, wrong: str) -> str | None:
    """Write `wrong` in place of the part `right` of an equation, which occurs once in it."""
    return text.replace(right, wrong) if text.count(right) == 1 and right != wrong else None


SLIPS: Mapping[str, Callable[..., Enclosure | None]] = {
    "sign dropped": sign_dropped,
    "wrong exponent": wrong_exponent,
    "converted from a rounded value": converted_from_rounded,
    "contradicts its companion": contradicts_companion,
    "copied from another cell": copied_from,
    "rounded down to a step": rounded_down,
}
"""The kinds of slips of numbers by name."""

TEXT_SLIPS: Mapping[str, Callable[..., str | None]] = {
    "symbols lost": symbols_lost,
    "symbols misread": symbols_misread,
}
"""The kinds of slips of equations by name."""
