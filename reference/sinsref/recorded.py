"""Formulas recorded once, and their Taylor coefficients computed as often as needed.

`sinsref.series` computes coefficients when they are asked for: the readable way. Here a formula is first written down
as a list of operations, each operation once; the coefficients then follow order by order, each from a convolution in
one call. It is what makes proved integration (`sinsref.enclosure`) quick enough to tabulate.

Source: A. Griewank, A. Walther, "Evaluating Derivatives", SIAM 2008, chapter 13 (the recurrences).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from math import inf
from operator import mul
from typing import Any, TypeAlias

from sinsref.arithmetic import Arithmetic, Number
from sinsref.exact import Exact

#: ``field(arithmetic, state)`` returns the derivative of the state, which depends on nothing else.
AutonomousField: TypeAlias = Callable[[Arithmetic, Sequence[Number]], Sequence[Number]]

_Coefficients: TypeAlias = list[Number]


class Recorded:
    """A quantity of a recorded formula.

    Parameters
    ----------
    recorder : Recorder
        Where it is recorded.
    operands : tuple of Number
        What it is made of.

    Attributes
    ----------
    series : list of Number
        The Taylor coefficients known so far.
    rule : callable
        ``rule(k)`` returns coefficient k from the operands' up to k and from its own below k.
    """

    __slots__ = ("operands", "recorder", "rule", "series")

    def __init__(self, recorder: Recorder, operands: tuple[Number, ...]) -> None:
        self.recorder = recorder
        self.operands = operands
        self.series: _Coefficients = []
        self.rule: Callable[[int], Number] = self.series.__getitem__

    def __neg__(self) -> Number:
        return self.recorder.record(_negative, self)

    def __add__(self, other: Number) -> Number:
        if isinstance(other, Recorded):
            return self.recorder.record(_sum, *_ordered(self, other))
        return self if other == 0 else self.recorder.record(_shifted, self, other)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Number:
        return self.recorder.record(_difference, self, other) if isinstance(other, Recorded) else self + (-other)

    def __rsub__(self, other: Number) -> Number:
        return -self + other

    def __mul__(self, other: Number) -> Number:
        if isinstance(other, Recorded):
            return self.recorder.record(*(_square, self) if self is other else (_product, *_ordered(self, other)))
        # A product with an exact zero is an exact zero, and is not recorded.
        return other if other == 0 else self.recorder.record(_scaled, self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Number:
        return self.recorder.record(_quotient if isinstance(other, Recorded) else _divided, self, other)

    def __rtruediv__(self, other: Number) -> Number:
        return other if other == 0 else self.recorder.record(_inverse, self) * other


def _ordered(x: Recorded, y: Recorded) -> tuple[Recorded, Recorded]:
    """Return the operands of a commutative operation, always in the same order."""
    return (x, y) if id(x) < id(y) else (y, x)


class Recorder:
    """Arithmetic that records what is done to the quantities it is given.

    Numbers stay numbers of the base arithmetic; what depends on a variable becomes `Recorded`. An operation that occurs
    twice is recorded once, and a product with an exact zero not at all.

    Parameters
    ----------
    base : Arithmetic
        Arithmetic of constants and coefficients.
    """

    def __init__(self, base: Arithmetic) -> None:
        self.base = base
        self.recorded: list[Recorded] = []
        self._known: dict[tuple[Any, ...], Recorded] = {}
        self._sqrt, self._exp = base.sqrt, base.exp  # one object each: operations are told apart by identity

    @property
    def pi(self) -> Number:
        """The ratio of a circle's circumference to its diameter."""
        return self.base.pi

    @property
    def resolution(self) -> float:
        """The relative size of one rounding."""
        return self.base.resolution

    def number(self, value: Exact) -> Number:
        """Return an exactly given value as a number of the base arithmetic."""
        return self.base.number(value)

    def sqrt(self, x: Number) -> Number:
        """Return the square root."""
        return self.record(_root, x, self._sqrt) if isinstance(x, Recorded) else self.base.sqrt(x)

    def exp(self, x: Number) -> Number:
        """Return the exponential."""
        return self.record(_exponential, x, self._exp) if isinstance(x, Recorded) else self.base.exp(x)

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        """Return sine and cosine together."""
        return self._pair(self.base.sin_cos, -1, x) if isinstance(x, Recorded) else self.base.sin_cos(x)

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        """Return hyperbolic sine and cosine together."""
        return self._pair(self.base.sinh_cosh, 1, x) if isinstance(x, Recorded) else self.base.sinh_cosh(x)

    def sign(self, x: Number) -> int:
        """Return the sign of a constant; 0 for what depends on a variable: it has no value yet."""
        return 0 if isinstance(x, Recorded) else self.base.sign(x)

    def magnitude(self, x: Number) -> float:
        """Return a bound of a constant; infinity for what depends on a variable."""
        return inf if isinstance(x, Recorded) else self.base.magnitude(x)

    def widen(self, x: Number, bound: Number) -> Number:
        """Refuse.

        Raises
        ------
        TypeError
            A bound of an error bounds none of its derivatives.
        """
        raise TypeError("a recorded formula cannot be widened: the bound of an error bounds none of its derivatives")

    def variable(self) -> Recorded:
        """Return a quantity whose coefficients come from outside."""
        return Recorded(self, ())

    def record(self, rule: Callable[..., Number], *operands: Number) -> Recorded:
        """Return the quantity that an operation makes of its operands.

        Parameters
        ----------
        rule : callable
            ``rule(own, *operands, k)`` returns coefficient k, given the quantity's own coefficients and those of its
            operands; operands that are constants are passed as they are.
        operands : Recorded or Number
        """
        key = (rule, *map(id, operands))
        if key not in self._known:
            new = Recorded(self, operands)  # keeps the operands alive, so that no other ever has their identity
            new.rule = partial(rule, new.series, *(x.series if isinstance(x, Recorded) else x for x in operands))
            self.recorded.append(new)
            self._known[key] = new
        return self._known[key]

    def _pair(
        self, values: Callable[[Number], tuple[Number, Number]], sign: int, x: Recorded
    ) -> tuple[Recorded, Recorded]:
        """Return an odd and an even function of x, the derivatives of which are the even and `sign` times the odd."""
        key = (_pair, sign, id(x))
        if key not in self._known:
            odd, even = Recorded(self, (x,)), Recorded(self, (x,))
            odd.operands, even.operands = (x, even), (x, odd)
            odd.rule = partial(_pair, lambda first: values(first)[0], x.series, even.series, 1)
            even.rule = partial(_pair, lambda first: values(first)[1], x.series, odd.series, sign)
            self.recorded += [odd, even]
            self._known[key] = odd
        odd = self._known[key]
        return odd, odd.operands[1]


class RecordedField:
    """The Taylor coefficients of the solutions of x' = f(x).

    Parameters
    ----------
    ar : Arithmetic
        Arithmetic of the constants of the field.
    field : callable
        ``field(arithmetic, state)`` returns the derivative of the state.
    dimension : int
        Number n of components.
    """

    def __init__(self, ar: Arithmetic, field: AutonomousField, dimension: int) -> None:
        recorder = Recorder(ar)
        self._zero = ar.number(0)
        self._state = [recorder.variable() for _ in range(dimension)]
        self._rates = [
            rate if isinstance(rate, Recorded) else self._zero + rate for rate in field(recorder, self._state)
        ]
        needed: set[int] = set()
        waiting = [x for x in self._rates if isinstance(x, Recorded)]
        while waiting:
            quantity = waiting.pop()
            if id(quantity) not in needed:
                needed.add(id(quantity))
                waiting += [x for x in quantity.operands if isinstance(x, Recorded)]
        self._operations = [x for x in recorder.recorded if id(x) in needed]

    def coefficients(self, state: Sequence[Number], order: int) -> list[list[Number]]:
        """Return the coefficients 0 ... order of the solution through a state, one list a component.

        Over balls, coefficient k encloses that of every solution through a point of the state.

        Parameters
        ----------
        state : sequence of n Number
        order : int
        """
        for quantity in self._operations:
            quantity.series.clear()
        for variable, value in zip(self._state, state, strict=True):
            variable.series[:] = [value]
        operations = [(quantity.series.append, quantity.rule) for quantity in self._operations]
        for k in range(order):
            for append, rule in operations:
                append(rule(k))
            for variable, rate in zip(self._state, self._rates, strict=True):
                term = rate.series[k] if isinstance(rate, Recorded) else self._zero if k else rate
                variable.series.append(term / (k + 1))
        return [list(variable.series) for variable in self._state]


def _convolution(a: _Coefficients, b: _Coefficients, k: int, first: int = 0) -> Number:
    """Return the sum of ``a[i] * b[k - i]`` over ``first <= i <= k``; 0 if there is none."""
    return sum(map(mul, a[first:], b[k - first :: -1])) if k >= first else 0  # the shorter operand ends the sum


def _self_convolution(a: _Coefficients, k: int, first: int = 0) -> Number:
    """Return the sum of ``a[i] * a[k - i]`` over ``first <= i <= k - first``; each product is formed once."""
    total = sum(map(mul, a[first:], a[k - first : k // 2 : -1])) * 2
    return total if k % 2 or k // 2 < first else total + a[k // 2] * a[k // 2]


def _negative(_: _Coefficients, a: _Coefficients, k: int) -> Number:
    return -a[k]


def _sum(_: _Coefficients, a: _Coefficients, b: _Coefficients, k: int) -> Number:
    return a[k] + b[k]


def _difference(_: _Coefficients, a: _Coefficients, b: _Coefficients, k: int) -> Number:
    return a[k] - b[k]


def _shifted(_: _Coefficients, a: _Coefficients, constant: Number, k: int) -> Number:
    return a[k] if k else a[0] + constant


def _scaled(_: _Coefficients, a: _Coefficients, constant: Number, k: int) -> Number:
    return a[k] * constant


def _divided(_: _Coefficients, a: _Coefficients, constant: Number, k: int) -> Number:
    return a[k] / constant


def _product(_: _Coefficients, a: _Coefficients, b: _Coefficients, k: int) -> Number:
    return _convolution(a, b, k)


def _square(_: _Coefficients, a: _Coefficients, k: int) -> Number:
    return _self_convolution(a, k)


def _quotient(own: _Coefficients, a: _Coefficients, b: _Coefficients, k: int) -> Number:
    return (a[k] - _convolution(b, own, k, 1)) / b[0]


def _inverse(own: _Coefficients, b: _Coefficients, k: int) -> Number:
    return -_convolution(b, own, k, 1) / b[0] if k else 1 / b[0]


def _root(own: _Coefficients, a: _Coefficients, value: Callable[[Number], Number], k: int) -> Number:
    return (a[k] - _self_convolution(own, k, 1)) / (own[0] * 2) if k else value(a[0])


def _exponential(own: _Coefficients, a: _Coefficients, value: Callable[[Number], Number], k: int) -> Number:
    return _pair(value, a, own, 1, k)


def _pair(value: Callable[[Number], Number], a: _Coefficients, other: _Coefficients, sign: int, k: int) -> Number:
    """Return coefficient k of a function of the series a whose derivative is ``sign * other * a'``."""
    if not k:
        return value(a[0])
    slopes = map(mul, count(1), a[1:])
    return sum(map(mul, slopes, other[k - 1 :: -1])) * sign / k
