"""Arithmetics in which the formulas of this package are evaluated.

A formula is written once, with ``+ - * /`` between the numbers of an arithmetic and with the elementary
functions that the arithmetic offers. Which arithmetic is at work decides what comes out:

MpArithmetic
    mpmath numbers of a stated number of digits: the readable path.
BallArithmetic
    balls of python-flint (midpoint and proven radius): the path that proves digits.

Further arithmetics build on these: `sinsref.pi_monomials` (exact zeros), `sinsref.series` (Taylor series,
dual numbers, derivatives) and `sinsref.exponential_sums` (whole blocks of epochs at once).

References
----------
F. Johansson, "Arb: efficient arbitrary-precision midpoint-radius interval arithmetic", IEEE Trans. Computers
66 (2017) 1281-1292.
"""

from __future__ import annotations

import threading
from fractions import Fraction
from types import TracebackType
from typing import Any, Protocol, Self, TypeAlias

import flint
import mpmath
from flint import arb, fmpq

from sinsref.exact import Exact, ExactNumber

#: A number of whichever arithmetic is at work.
Number: TypeAlias = Any

# python-flint keeps one working precision for the whole process, so two computations in balls take turns.
_flint_lock = threading.RLock()


class Arithmetic(Protocol):
    """What a formula may ask of an arithmetic besides ``+ - * /``."""

    @property
    def pi(self) -> Number:
        """The ratio of a circle's circumference to its diameter."""

    def number(self, value: Exact) -> Number:
        """Return an exactly given value (integer, fraction, binary64, expression) as a number."""

    def sqrt(self, x: Number) -> Number:
        """Return the square root."""

    def exp(self, x: Number) -> Number:
        """Return the exponential."""

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        """Return sine and cosine together."""

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        """Return hyperbolic sine and cosine together."""

    def sign(self, x: Number) -> int:
        """Return 1 or -1 where the sign is certain, 0 where the number is zero or cannot be told from it."""

    def magnitude(self, x: Number) -> float:
        """Return a float not smaller than the absolute value."""

    def widen(self, x: Number, bound: Number) -> Number:
        """Return the number with an error of at most `bound` added to what it may stand for."""

    @property
    def resolution(self) -> float:
        """The relative size of one rounding."""


class MpArithmetic:
    """mpmath at a stated number of decimal digits, in a context of its own.

    The global ``mpmath.mp`` is shared by all threads and is never used. The numbers must not leave the
    process: pickling an ``mpf`` rounds it to the precision of the receiver.

    Parameters
    ----------
    digits : int, default 50
        Decimal digits of the working precision.
    """

    def __init__(self, digits: int = 50) -> None:
        self.context = mpmath.MPContext()
        self.context.dps = digits

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    @property
    def pi(self) -> Number:
        return +self.context.pi

    @property
    def resolution(self) -> float:
        return float(self.context.eps)

    def number(self, value: Exact) -> Number:
        if isinstance(value, str):
            value = ExactNumber(value)
        if isinstance(value, ExactNumber):
            return value.evaluate(self)
        if isinstance(value, Fraction):
            return self.context.mpf(value.numerator) / value.denominator
        return self.context.mpf(value)

    def sqrt(self, x: Number) -> Number:
        return self.context.sqrt(x)

    def exp(self, x: Number) -> Number:
        return self.context.exp(x)

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        cosine, sine = self.context.cos_sin(x)
        return sine, cosine

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        return self.context.sinh(x), self.context.cosh(x)

    def sign(self, x: Number) -> int:
        return int(self.context.sign(x))

    def magnitude(self, x: Number) -> float:
        return float(abs(x)) * (1 + 2.0**-52)

    def widen(self, x: Number, bound: Number) -> Number:
        return x


class BallArithmetic:
    """Balls of python-flint at a stated working precision: every result encloses the exact value.

    The working precision of python-flint belongs to the process; it holds inside the ``with`` block only,
    and other threads wait meanwhile.

    Parameters
    ----------
    bits : int, default 256
        Working precision in bits.

    Examples
    --------
    >>> with BallArithmetic(128) as balls:
    ...     third = balls.number("1/3")
    ...     bool(third.rad() < 1e-38)
    True
    """

    def __init__(self, bits: int = 256) -> None:
        self.bits = bits
        self._outer: list[int] = []

    def __enter__(self) -> Self:
        _flint_lock.acquire()
        self._outer.append(flint.ctx.prec)
        flint.ctx.prec = self.bits
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        flint.ctx.prec = self._outer.pop()
        _flint_lock.release()

    @property
    def pi(self) -> Number:
        return arb.pi()

    @property
    def resolution(self) -> float:
        return float(2.0 ** -min(self.bits, 1000))

    def number(self, value: Exact) -> Number:
        if isinstance(value, ExactNumber):
            return value.evaluate(self)
        if isinstance(value, Fraction):
            return arb(fmpq(value.numerator, value.denominator))
        if isinstance(value, str):
            return ExactNumber(value).evaluate(self)
        return arb(value)

    def sqrt(self, x: Number) -> Number:
        return x.sqrt()

    def exp(self, x: Number) -> Number:
        return x.exp()

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        sine, cosine = x.sin_cos()
        return sine, cosine

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        sine, cosine = x.sinh_cosh()
        return sine, cosine

    def sign(self, x: Number) -> int:
        return 1 if x > 0 else -1 if x < 0 else 0

    def magnitude(self, x: Number) -> float:
        return float(x.abs_upper()) * (1 + 2.0**-52)

    def widen(self, x: Number, bound: Number) -> Number:
        return x + arb(0, bound.abs_upper() if isinstance(bound, arb) else bound)
