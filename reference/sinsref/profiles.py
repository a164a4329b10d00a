r"""Functions of time given exactly: sums of powers of time, sines and cosines, written as text.

``"0.8 + pi/90*sin(2*pi*t/3000)"`` is a profile. Such sums have closed derivatives and a closed integral, in every
arithmetic and at every time, complex ones included: nothing that a motion makes of them can fail between two samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from typing import Any

from sinsref.arithmetic import Arithmetic, Number
from sinsref.exact import GRAMMAR, Exact, ExactNumber, ExpressionError, evaluated, parsed
from sinsref.series import SeriesArithmetic

#: Name of the time in the text of a profile.
VARIABLE = "t"
ADMISSIBLE = f"a sum of powers of {VARIABLE} and of sin() and cos() of a linear function of {VARIABLE}; {GRAMMAR}"


@dataclass(frozen=True)
class Oscillation:
    """The function ``sine * sin(rate t + phase) + cosine * cos(rate t + phase)``.

    Attributes
    ----------
    sine, cosine : Number
        Amplitudes.
    rate, phase : Number
        1/s, rad.
    """

    sine: Number
    cosine: Number
    rate: Number
    phase: Number

    def times(self, factor: Number) -> Oscillation:
        """Return the product with a constant."""
        return Oscillation(self.sine * factor, self.cosine * factor, self.rate, self.phase)


@dataclass(frozen=True)
class TimeSum:
    """A sum of powers of time and oscillations whose constants are numbers of one arithmetic.

    Attributes
    ----------
    powers : tuple of Number
        Coefficients of 1, t, t^2, ...; at least one.
    oscillations : tuple of Oscillation
    """

    powers: tuple[Number, ...]
    oscillations: tuple[Oscillation, ...] = ()

    def __neg__(self) -> TimeSum:
        return self * -1

    def __add__(self, other: Number) -> TimeSum:
        if not isinstance(other, TimeSum):
            return TimeSum((self.powers[0] + other, *self.powers[1:]), self.oscillations)
        pairs = zip_longest(self.powers, other.powers)
        powers = tuple(x if y is None else y if x is None else x + y for x, y in pairs)
        return TimeSum(powers, (*self.oscillations, *other.oscillations))

    __radd__ = __add__

    def __sub__(self, other: Number) -> TimeSum:
        return self.__add__(-other)

    def __rsub__(self, other: Number) -> TimeSum:
        return (-self).__add__(other)

    def __mul__(self, other: Number) -> TimeSum:
        if not isinstance(other, TimeSum):
            scaled = tuple(part.times(other) for part in self.oscillations)
            return TimeSum(tuple(x * other for x in self.powers), scaled)
        if self.oscillations or other.oscillations:
            raise ExpressionError(f"a product of two functions of time must be one of powers; admissible: {ADMISSIBLE}")
        powers: list[Number] = [None] * (len(self.powers) + len(other.powers) - 1)
        for i, x in enumerate(self.powers):
            for j, y in enumerate(other.powers):
                powers[i + j] = x * y if powers[i + j] is None else powers[i + j] + x * y
        return TimeSum(tuple(powers))

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> TimeSum:
        return self.__mul__(1 / _constant(other))

    def __rtruediv__(self, other: Number) -> TimeSum:
        raise ExpressionError(f"a function of time cannot be a divisor; admissible: {ADMISSIBLE}")

    def lifted(self, constant: Callable[[Number], Number]) -> TimeSum:
        """Return the sum with its constants as numbers of another arithmetic."""
        parts = ((part.sine, part.cosine, part.rate, part.phase) for part in self.oscillations)
        return TimeSum(tuple(map(constant, self.powers)), tuple(Oscillation(*map(constant, part)) for part in parts))

    @property
    def is_constant(self) -> bool:
        """Whether it has the form of a constant."""
        return len(self.powers) == 1 and not self.oscillations

    def jet(self, ar: Arithmetic, time: Number) -> tuple[Number, Number, Number]:
        """Return value, first and second derivative.

        Parameters
        ----------
        ar : Arithmetic
            One in which `time` and the constants are numbers.
        time : Number
            s.
        """
        value, slope, curvature = (_polynomial(powers, time) for powers in self._derivatives)
        for part in self.oscillations:
            sine, cosine = ar.sin_cos(time * part.rate + part.phase)
            swing = sine * part.sine + cosine * part.cosine
            value = value + swing
            slope = slope + (cosine * part.sine - sine * part.cosine) * part.rate
            curvature = curvature - swing * (part.rate * part.rate)
        return value, slope, curvature

    @cached_property
    def _derivatives(self) -> tuple[tuple[Number, ...], ...]:
        """Coefficients of the powers, and of their first and second derivative; a zero where none is left."""
        slopes = tuple(x * k for k, x in enumerate(self.powers))[1:] or (self.powers[0] * 0,)
        curvatures = tuple(x * k for k, x in enumerate(slopes))[1:] or (self.powers[0] * 0,)
        return self.powers, slopes, curvatures

    def integral(self, ar: Arithmetic, time: Number) -> Number:
        """Return the integral from 0 to a time."""
        total = _polynomial([x / (k + 1) for k, x in enumerate(self.powers)], time) * time
        for part in self.oscillations:
            sine, cosine = ar.sin_cos(time * part.rate + part.phase)
            sine_0, cosine_0 = ar.sin_cos(part.phase)
            change = (cosine_0 - cosine) * part.sine + (sine - sine_0) * part.cosine
            total = total + change / part.rate
        return total


def _polynomial(powers: Sequence[Number], time: Number) -> Number:
    total = powers[-1]
    for x in reversed(powers[:-1]):
        total = time * total + x
    return total


def _constant(value: Number) -> Number:
    if not isinstance(value, TimeSum):
        return value
    if not value.is_constant:
        raise ExpressionError(f"a function of time stands where a constant must; admissible: {ADMISSIBLE}")
    return value.powers[0]


class _TimeSumArithmetic:
    """Arithmetic in which time is a symbol: numbers of a base arithmetic, and `TimeSum`.

    Only what the grammar of profiles needs is here: it is no `Arithmetic`.
    """

    def __init__(self, base: Arithmetic) -> None:
        self._base = base
        self.pi = base.pi

    def number(self, value: Exact) -> Number:
        return self._base.number(value)

    def sqrt(self, x: Number) -> Number:
        return self._base.sqrt(_constant(x))

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        if not isinstance(x, TimeSum) or x.is_constant:
            return self._base.sin_cos(_constant(x))
        if x.oscillations or len(x.powers) != 2:
            raise ExpressionError(f"the argument of sin() or cos() must be linear in time; admissible: {ADMISSIBLE}")
        zero, one = self._base.number(0), self._base.number(1)
        phase, rate = x.powers
        if self._base.sign(rate) == 0:
            raise ExpressionError("the argument of sin() or cos() is multiplied by 0 times the time")
        return TimeSum((zero,), (Oscillation(one, zero, rate, phase),)), TimeSum(
            (zero,), (Oscillation(zero, one, rate, phase),)
        )


class Profile:
    """A function of time, given exactly.

    Parameters
    ----------
    value : int, float, str, Fraction, ExactNumber or Profile
        A string is an expression of the grammar of `sinsref.exact` in which ``t`` is the time in s: a sum of powers
        of t and of sines and cosines of linear functions of t, with constant factors. Anything else is a constant.

    Raises
    ------
    ExpressionError
        If the text is outside the grammar, or a constant in it has no finite value.

    Examples
    --------
    >>> Profile("300 + 100*sin(2*pi*t/1800)").text
    '300 + 100*sin(2*pi*t/1800)'
    >>> Profile("sin(t*t)")
    Traceback (most recent call last):
    ...
    sinsref.exact.ExpressionError: the argument of sin() or cos() must be linear in time; admissible: a sum of powers \
of t and of sin() and cos() of a linear function of t; decimal numbers, pi, + - * /, parentheses, sqrt(), sin(), cos()
    """

    def __init__(self, value: Exact | Profile) -> None:
        if isinstance(value, Profile):
            self.text: str = value.text
            self._tree: Any = value._tree
            return
        self.text = value.strip() if isinstance(value, str) else ExactNumber(value).text
        self._tree = parsed(self.text, VARIABLE)
        self._check()

    def _check(self) -> None:
        from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic

        try:
            with PiMonomialArithmetic(256) as exact:
                terms = self.terms(exact)
                constants = [*terms.powers]
                for part in terms.oscillations:
                    constants += [part.sine, part.cosine, part.rate, part.phase]
                balls = [x.ball() if isinstance(x, PiMonomial) else x for x in constants]
                finite = all(x.is_finite() for x in balls)
        except (ZeroDivisionError, OverflowError):
            finite = False
        if not finite:
            raise ExpressionError(f"{self.text!r} has no finite real value")

    def terms(self, ar: Arithmetic) -> TimeSum:
        """Return the function with its constants in an arithmetic."""
        # Series know how to multiply by what they take for a number; the symbol of time is none.
        base = ar.base if isinstance(ar, SeriesArithmetic) else ar
        arithmetic: Any = _TimeSumArithmetic(base)
        value = evaluated(self._tree, arithmetic, TimeSum((base.number(0), base.number(1))))
        terms = value if isinstance(value, TimeSum) else TimeSum((value,))
        return terms.lifted(ar.constant) if isinstance(ar, SeriesArithmetic) else terms

    @cached_property
    def constant(self) -> ExactNumber | None:
        """The value, where the text does not contain the time; else None."""
        return ExactNumber(self.text) if VARIABLE not in _names(self._tree) else None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Profile) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __repr__(self) -> str:
        return f"Profile({self.text!r})"


def _names(tree: Any) -> set[str]:
    if isinstance(tree, tuple):
        return set().union(*(_names(operand) for operand in tree[1:]))
    return {tree} if isinstance(tree, str) else set()
