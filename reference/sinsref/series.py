r"""Truncated power series over any arithmetic, for Taylor expansions and derivatives, and dual numbers.

A `Series` holds the coefficients of :math:`x_0 + x_1 s + x_2 s^2 + \dots` and computes them one by one when
they are asked for, each from the coefficients of its operands up to the same power. Two uses:

* `s` is time: a differential equation whose right-hand side is written in series yields the coefficients of its
  solution one after the other (`sinsref.taylor`);
* `s` is a perturbation: the coefficient of `s` is a derivative (`sinsref.error_equations`).

A `DualNumber` has :math:`s^2 = 0`: the transfer principle of Kotelnikov and Study turns a formula for rotation into the
formula for the screw motion, and the coefficient of `s` is the dual part (`sinsref.precession`).
"""

from __future__ import annotations

from collections.abc import Callable

from sinsref.arithmetic import Arithmetic, Number
from sinsref.exact import Exact


class Series:
    """A power series whose coefficients are computed on demand and kept.

    Parameters
    ----------
    rule : callable
        ``rule(k)`` returns coefficient k; it may read coefficients below k of the series itself.
    first : sequence of Number, optional
        Coefficients already known.
    """

    __slots__ = ("_known", "_rule")

    def __init__(self, rule: Callable[[int], Number], first: tuple[Number, ...] = ()) -> None:
        self._rule = rule
        self._known: list[Number] = list(first)

    def __getitem__(self, k: int) -> Number:
        known = self._known
        while len(known) <= k:
            known.append(self._rule(len(known)))
        return known[k]

    def __neg__(self) -> Series:
        return Series(lambda k: -self[k])

    def __add__(self, other: Number) -> Series:
        if isinstance(other, Series):
            return Series(lambda k: self[k] + other[k])
        return Series(lambda k: self[k], (self[0] + other,))

    __radd__ = __add__

    def __sub__(self, other: Number) -> Series:
        if isinstance(other, Series):
            return Series(lambda k: self[k] - other[k])
        return Series(lambda k: self[k], (self[0] - other,))

    def __rsub__(self, other: Number) -> Series:
        return (-self).__add__(other)

    def __mul__(self, other: Number) -> Series:
        if isinstance(other, Series):
            return Series(lambda k: _convolve(self, other, k, 0))
        return Series(lambda k: self[k] * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Series:
        if not isinstance(other, Series):
            return Series(lambda k: self[k] / other)
        quotient = Series(
            lambda k: (self[k] - _convolve(other, quotient, k, 1)) / other[0] if k else self[0] / other[0]
        )
        return quotient

    def __rtruediv__(self, other: Number) -> Series:
        quotient: Series = Series(lambda k: -_convolve(self, quotient, k, 1) / self[0], (other / self[0],))
        return quotient

    def evaluate(self, step: Number, order: int) -> Number:
        """Return the sum of the terms up to the power `order` at `step`, by Horner's scheme."""
        total = self[order]
        for k in range(order - 1, -1, -1):
            total = total * step + self[k]
        return total


def _convolve(a: Series, b: Series, k: int, first: int) -> Number:
    """Return the sum of ``a[i] * b[k - i]`` over ``first <= i <= k``; k >= first."""
    total = a[first] * b[k - first]
    for i in range(first + 1, k + 1):
        total = total + a[i] * b[k - i]
    return total


class SeriesArithmetic:
    """Arithmetic of power series over a base arithmetic.

    Parameters
    ----------
    base : Arithmetic
        The arithmetic of the coefficients.
    """

    def __init__(self, base: Arithmetic) -> None:
        self.base = base
        self._zero = base.number(0)

    def constant(self, value: Number) -> Series:
        """Return a number of the base arithmetic as a series."""
        return Series(lambda k: self._zero, (value,))

    def variable(self, value: Number, slope: Number = 1) -> Series:
        """Return ``value + slope * s``."""
        return Series(lambda k: self._zero, (value, self._zero + slope))

    def unknown(self, value: Number) -> Series:
        """Return a series of which only the first coefficient is known; `define` gives the others."""

        def undefined(k: int) -> Number:
            raise RuntimeError("a series was read before it was defined")

        return Series(undefined, (value,))

    @staticmethod
    def define(unknown: Series, derivative: Series) -> None:
        """Let `unknown` be the series with the given derivative with respect to s."""
        unknown._rule = lambda k: derivative[k - 1] / k

    @property
    def pi(self) -> Number:
        return self.constant(self.base.pi)

    @property
    def resolution(self) -> float:
        return self.base.resolution

    def number(self, value: Exact) -> Number:
        return self.constant(self.base.number(value))

    def sqrt(self, x: Number) -> Number:
        root = Series(lambda k: (x[k] - _middle(root, k)) / (root[0] * 2), (self.base.sqrt(x[0]),))
        return root

    def exp(self, x: Number) -> Number:
        value = Series(lambda k: _chain(x, value, k), (self.base.exp(x[0]),))
        return value

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        first = self.base.sin_cos(x[0])
        sine = Series(lambda k: _chain(x, cosine, k), (first[0],))
        cosine = Series(lambda k: -_chain(x, sine, k), (first[1],))
        return sine, cosine

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        first = self.base.sinh_cosh(x[0])
        sine = Series(lambda k: _chain(x, cosine, k), (first[0],))
        cosine = Series(lambda k: _chain(x, sine, k), (first[1],))
        return sine, cosine

    def sign(self, x: Number) -> int:
        return self.base.sign(x[0])

    def magnitude(self, x: Number) -> float:
        return self.base.magnitude(x[0])

    def widen(self, x: Number, bound: Number) -> Number:
        # The bound holds for the value alone. Tables of truth take derivatives and dual parts only through
        # functions that are not cut off, so nothing that is certified rests on a coefficient left as it is.
        return Series(lambda k: x[k], (self.base.widen(x[0], bound[0] if isinstance(bound, Series) else bound),))


class DualNumber:
    """The number ``principal + s * dual`` with s^2 = 0.

    Parameters
    ----------
    principal, dual : Number
        Numbers of one arithmetic.
    """

    __slots__ = ("dual", "principal")

    def __init__(self, principal: Number, dual: Number) -> None:
        self.principal = principal
        self.dual = dual

    def __neg__(self) -> DualNumber:
        return DualNumber(-self.principal, -self.dual)

    def __add__(self, other: Number) -> DualNumber:
        if isinstance(other, DualNumber):
            return DualNumber(self.principal + other.principal, self.dual + other.dual)
        return DualNumber(self.principal + other, self.dual)

    __radd__ = __add__

    def __sub__(self, other: Number) -> DualNumber:
        if isinstance(other, DualNumber):
            return DualNumber(self.principal - other.principal, self.dual - other.dual)
        return DualNumber(self.principal - other, self.dual)

    def __rsub__(self, other: Number) -> DualNumber:
        return DualNumber(other - self.principal, -self.dual)

    def __mul__(self, other: Number) -> DualNumber:
        if isinstance(other, DualNumber):
            return DualNumber(
                self.principal * other.principal, self.principal * other.dual + self.dual * other.principal
            )
        return DualNumber(self.principal * other, self.dual * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> DualNumber:
        if not isinstance(other, DualNumber):
            return DualNumber(self.principal / other, self.dual / other)
        quotient = self.principal / other.principal
        return DualNumber(quotient, (self.dual - quotient * other.dual) / other.principal)

    def __rtruediv__(self, other: Number) -> DualNumber:
        quotient = other / self.principal
        return DualNumber(quotient, -(quotient * self.dual) / self.principal)


class DualArithmetic:
    """Arithmetic of dual numbers over a base arithmetic.

    A `Series` cut off after its second coefficient gives the same numbers; pairs that are computed at
    once cost a third.

    Parameters
    ----------
    base : Arithmetic
        The arithmetic of both parts.
    """

    def __init__(self, base: Arithmetic) -> None:
        self.base = base
        self._zero = base.number(0)

    def constant(self, value: Number) -> DualNumber:
        """Return a number of the base arithmetic as a dual number."""
        return DualNumber(value, self._zero)

    @property
    def pi(self) -> Number:
        return self.constant(self.base.pi)

    @property
    def resolution(self) -> float:
        return self.base.resolution

    def number(self, value: Exact) -> Number:
        return self.constant(self.base.number(value))

    def sqrt(self, x: Number) -> Number:
        root = self.base.sqrt(x.principal)
        return DualNumber(root, x.dual / (root * 2))

    def exp(self, x: Number) -> Number:
        value = self.base.exp(x.principal)
        return DualNumber(value, x.dual * value)

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        sine, cosine = self.base.sin_cos(x.principal)
        return DualNumber(sine, x.dual * cosine), DualNumber(cosine, -(x.dual * sine))

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        sine, cosine = self.base.sinh_cosh(x.principal)
        return DualNumber(sine, x.dual * cosine), DualNumber(cosine, x.dual * sine)

    def sign(self, x: Number) -> int:
        return self.base.sign(x.principal)

    def magnitude(self, x: Number) -> float:
        return self.base.magnitude(x.principal)

    def widen(self, x: Number, bound: Number) -> Number:
        # The bound holds for the principal part alone. Tables of truth take dual parts only through functions that
        # are not cut off, so nothing that is certified rests on a dual part left as it is.
        return DualNumber(self.base.widen(x.principal, bound.principal), x.dual)


def _chain(x: Series, outer: Series, k: int) -> Number:
    """Return coefficient k >= 1 of the integral of ``outer * x'``."""
    total = x[1] * outer[k - 1]
    for i in range(2, k + 1):
        total = total + x[i] * outer[k - i] * i
    return total / k


def _middle(root: Series, k: int) -> Number:
    """Return the part of coefficient k of ``root * root`` that does not contain ``root[k]``."""
    total = root[0] * 0
    for i in range(1, k):
        total = total + root[i] * root[k - i]
    return total
