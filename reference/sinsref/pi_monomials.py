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

_HALF = fmpq(1, 2)
#: Angles of which sine and cosine are kept.
_KEPT_ANGLES = 1024


class PiMonomial:
    """The number ``coefficient * pi**power`` with a rational coefficient; zero has power 0."""

    __slots__ = ("_coefficient", "power")

    def __init__(self, coefficient: Fraction | int, power: int = 0) -> None:
        self._coefficient = fmpq(coefficient.numerator, coefficient.denominator)
        self.power = power if coefficient else 0

    @property
    def coefficient(self) -> Fraction:
        """The rational factor."""
        return Fraction(int(self._coefficient.p), int(self._coefficient.q))

    def ball(self) -> arb:
        """Return an enclosing ball at the present working precision."""
        value = arb(self._coefficient)
        return value if self.power == 0 else value * arb.pi() ** self.power

    def __neg__(self) -> PiMonomial:
        # Most of what meets here is zero, in this as in the other operations.
        if not self._coefficient:
            return self
        return _monomial(-self._coefficient, self.power)

    def __add__(self, other: Number) -> Number:
        if isinstance(other, arb):
            return self.ball() + other if self._coefficient else other
        right = _as_monomial(other)
        if right is None:
            return NotImplemented
        if not self._coefficient:
            return right
        if not right._coefficient:
            return self
        if right.power == self.power:
            return _monomial(self._coefficient + right._coefficient, self.power)
        return self.ball() + right.ball()

    __radd__ = __add__

    def __sub__(self, other: Number) -> Number:
        return self + (-other)

    def __rsub__(self, other: Number) -> Number:
        if isinstance(other, arb):
            return other - self.ball() if self._coefficient else other
        return (-self) + other

    def __mul__(self, other: Number) -> Number:
        if isinstance(other, arb):
            # Zero times a finite ball is zero, whatever the ball holds.
            return self.ball() * other if self._coefficient or not other.is_finite() else self
        right = _as_monomial(other)
        if right is None:
            return NotImplemented
        if not self._coefficient:
            return self
        return _monomial(self._coefficient * right._coefficient, self.power + right.power)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Number:
        if isinstance(other, arb):
            return self.ball() / other if self._coefficient or other.contains(0) else self
        right = _as_monomial(other)
        if right is None:
            return NotImplemented
        return _monomial(self._coefficient / right._coefficient, self.power - right.power)

    def __rtruediv__(self, other: Number) -> Number:
        return PiMonomial(other) / self if isinstance(other, int) else other / self.ball()

    def __abs__(self) -> PiMonomial:
        return _monomial(abs(self._coefficient), self.power)

    def __float__(self) -> float:
        return float(self.ball())

    def __repr__(self) -> str:
        return f"PiMonomial({self.coefficient}, {self.power})"


def _monomial(coefficient: fmpq, power: int) -> PiMonomial:
    """Return a monomial whose coefficient is a fraction of python-flint already, ten times as fast as Python's."""
    value = PiMonomial.__new__(PiMonomial)
    value._coefficient = coefficient
    value.power = power if coefficient else 0
    return value


def _as_monomial(value: Number) -> PiMonomial | None:
    if isinstance(value, PiMonomial):
        return value
    return PiMonomial(value) if isinstance(value, int) else None


class PiMonomialArithmetic(BallArithmetic):
    """Balls in which rational multiples of powers of pi stay exact.

    Slower than `BallArithmetic`, for the few values that plain balls cannot tell from zero.
    """

    def __init__(self, bits: int = 256) -> None:
        super().__init__(bits)
        # Rows of a table share their parameters, and many of their angles.
        self._numbers: dict[str, Number] = {}
        self._angles: dict[tuple[int, int], tuple[Number, Number]] = {}

    @property
    def pi(self) -> Number:
        return PiMonomial(1, 1)

    def number(self, value: Exact) -> Number:
        if not isinstance(value, str | ExactNumber):
            return PiMonomial(value if isinstance(value, int) else Fraction(value))
        text = value if isinstance(value, str) else value.text
        if text not in self._numbers:
            self._numbers[text] = ExactNumber(value).evaluate(self)
        return self._numbers[text]

    def sqrt(self, x: Number) -> Number:
        if isinstance(x, PiMonomial):
            numerator, denominator = int(x._coefficient.p), int(x._coefficient.q)
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
            turns = x._coefficient
            key = int(turns.p), int(turns.q)
            if key not in self._angles:
                if len(self._angles) >= _KEPT_ANGLES:
                    self._angles.clear()
                sine, cosine = arb.sin_cos_pi_fmpq(turns)
                self._angles[key] = _recognise(sine, turns - _HALF), _recognise(cosine, turns)
            return self._angles[key]
        sine, cosine = _ball(x).sin_cos()
        return sine, cosine

    def sinh_cosh(self, x: Number) -> tuple[Number, Number]:
        return (PiMonomial(0), PiMonomial(1)) if _is_zero(x) else _ball(x).sinh_cosh()

    def sign(self, x: Number) -> int:
        if isinstance(x, PiMonomial):
            return int(x._coefficient > 0) - int(x._coefficient < 0)
        return super().sign(x)

    def magnitude(self, x: Number) -> float:
        return super().magnitude(_ball(x))

    def widen(self, x: Number, bound: Number) -> Number:
        return x if _is_zero(bound) else super().widen(_ball(x), _ball(bound))


def _ball(x: Number) -> arb:
    return x.ball() if isinstance(x, PiMonomial) else x


def _is_zero(x: Number) -> bool:
    return isinstance(x, PiMonomial) and not x._coefficient


def _recognise(cosine: arb, turns: fmpq) -> Number:
    """Return cos(pi * turns) as a fraction where it is one: by Niven's theorem only 0, 1/2 and 1 up to sign."""
    if turns.q in (1, 2, 3):
        return PiMonomial(Fraction(round(2 * float(cosine)), 2))
    return cosine
