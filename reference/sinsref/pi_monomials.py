r"""Arithmetic that knows exact zeros: balls, and beside them rational multiples of powers of pi.

A ball around zero never tells whether the value is zero. Navigation truth is full of exact zeros: a phase
that is a whole number of half turns, a speed at which the rate of the frame vanishes. Here a number of the
form :math:`q\,\pi^k` with rational q stays in that form as long as the operations allow; everything else
becomes a ball.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from flint import arb, fmpq

from sinsref.arithmetic import BallArithmetic, Number
from sinsref.exact import Exact, ExactNumber


class PiMonomial:
    """The number ``coefficient * pi**power`` with a rational coefficient; zero has power 0."""

    __slots__ = ("coefficient", "power")

    def __init__(self, coefficient: Fraction | int, power: int = 0) -> None:
        self.coefficient = Fraction(coefficient)
        self.power = power if self.coefficient else 0

    def ball(self) -> arb:
        """Return an enclosing ball at the present working precision."""
        value = arb(fmpq(self.coefficient.numerator, self.coefficient.denominator))
        return value if self.power == 0 else value * arb.pi() ** self.power

    def __neg__(self) -> PiMonomial:
        return PiMonomial(-self.coefficient, self.power)

    def __add__(self, other: Number) -> Number:
        if not self.coefficient:
            return _exact(other)
        if isinstance(other, int | PiMonomial):
            right = _monomial(other)
            if not right.coefficient:
                return self
            if right.power == self.power:
                return PiMonomial(self.coefficient + right.coefficient, self.power)
            return self.ball() + right.ball()
        return self.ball() + other if isinstance(other, arb) else NotImplemented

    __radd__ = __add__

    def __sub__(self, other: Number) -> Number:
        return self + (-other)

    def __rsub__(self, other: Number) -> Number:
        return (-self) + other

    def __mul__(self, other: Number) -> Number:
        if isinstance(other, int | PiMonomial):
            right = _monomial(other)
            return PiMonomial(self.coefficient * right.coefficient, self.power + right.power)
        if isinstance(other, arb):
            # Zero times a finite ball is zero, whatever the ball holds.
            return self if not self.coefficient and other.is_finite() else self.ball() * other
        return NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Number:
        if isinstance(other, int | PiMonomial):
            right = _monomial(other)
            return PiMonomial(self.coefficient / right.coefficient, self.power - right.power)
        if isinstance(other, arb):
            return self if not self.coefficient and not other.contains(0) else self.ball() / other
        return NotImplemented

    def __rtruediv__(self, other: Number) -> Number:
        return _monomial(other) / self if isinstance(other, int) else other / self.ball()

    def __abs__(self) -> PiMonomial:
        return PiMonomial(abs(self.coefficient), self.power)

    def __float__(self) -> float:
        return float(self.ball())

    def __repr__(self) -> str:
        return f"PiMonomial({self.coefficient}, {self.power})"


def _monomial(value: int | PiMonomial) -> PiMonomial:
    return value if isinstance(value, PiMonomial) else PiMonomial(value)


def _exact(value: Number) -> Number:
    return PiMonomial(value) if isinstance(value, int) else value


class PiMonomialArithmetic(BallArithmetic):
    """Balls in which rational multiples of powers of pi stay exact.

    Slower than `BallArithmetic`, for the few values that plain balls cannot tell from zero.
    """

    @property
    def pi(self) -> Number:
        return PiMonomial(1, 1)

    def number(self, value: Exact) -> Number:
        if isinstance(value, str):
            value = ExactNumber(value)
        return value.evaluate(self) if isinstance(value, ExactNumber) else PiMonomial(Fraction(value))

    def sqrt(self, x: Number) -> Number:
        if isinstance(x, PiMonomial):
            numerator, denominator = x.coefficient.numerator, x.coefficient.denominator
            if numerator >= 0 and x.power % 2 == 0:
                roots = isqrt(numerator), isqrt(denominator)
                if roots[0] ** 2 == numerator and roots[1] ** 2 == denominator:
                    return PiMonomial(Fraction(*roots), x.power // 2)
        return _ball(x).sqrt()

    def exp(self, x: Number) -> Number:
        return PiMonomial(1) if _is_zero(x) else _ball(x).exp()

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        if _is_zero(x):
            return PiMonomial(0), PiMonomial(1)
        if isinstance(x, PiMonomial) and x.power == 1:
            turns = x.coefficient
            sine, cosine = arb.sin_cos_pi_fmpq(fmpq(turns.numerator, turns.denominator))
            return _recognise(sine, turns - Fraction(1, 2)), _recognise(cosine, turns)
        sine, cosine = _ball(x).sin_cos()
        return sine, cosine

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        return (PiMonomial(0), PiMonomial(1)) if _is_zero(x) else _ball(x).sinh_cosh()

    def sign(self, x: Number) -> int:
        if isinstance(x, PiMonomial):
            return (x.coefficient > 0) - (x.coefficient < 0)
        return super().sign(x)

    def magnitude(self, x: Number) -> float:
        return super().magnitude(_ball(x))

    def widen(self, x: Number, bound: Number) -> Number:
        return x if _is_zero(bound) else super().widen(_ball(x), _ball(bound))


def _ball(x: Number) -> arb:
    return x.ball() if isinstance(x, PiMonomial) else x


def _is_zero(x: Number) -> bool:
    return isinstance(x, PiMonomial) and not x.coefficient


def _recognise(cosine: arb, turns: Fraction) -> Number:
    """Return cos(pi * turns) as a fraction where it is one: by Niven's theorem only 0, 1/2 and 1 up to sign."""
    if (2 * turns).denominator == 1 or (3 * turns).denominator == 1:
        return PiMonomial(Fraction(round(2 * float(cosine)), 2))
    return cosine
