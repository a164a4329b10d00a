"""Exact data without symmetry, on which equations of Chelnokov 1991 are put to the test, and the definitions they obey.

Quaternions and vectors are lists of numbers of an arithmetic, as in `sinsref.quaternion`.
"""

from collections.abc import Sequence
from fractions import Fraction
from random import Random
from typing import TypeAlias

from sinsref.arithmetic import BallArithmetic, Number
from sinsref.quaternion import conjugate, cross, normalised, product, rotate
from sinsref.series import SeriesArithmetic

Quaternion: TypeAlias = Sequence[Number]
Sides: TypeAlias = tuple[Quaternion, Quaternion]
"""What the definitions give, and what a form of an equation gives."""
AS_PRINTED = "as printed"
"""The form of an equation of which nothing is in question."""


class Data:
    """Rational data: numbers without symmetry between -1 and 1, and turning frames.

    Parameters
    ----------
    balls : BallArithmetic
        Entered.
    seed : int
        What the data are drawn with.
    """

    def __init__(self, balls: BallArithmetic, seed: int) -> None:
        self.balls, self.ar, self._random = balls, SeriesArithmetic(balls), Random(seed)
        self.zero, self.one = balls.number(0), balls.number(1)
        self.mass, self.length, self.momentum, self.spin = (self.number() for _ in range(4))
        self.moment, self.arm, self.force = (self.vector() for _ in range(3))

    def number(self) -> Number:
        """Return another number."""
        return self.balls.number(Fraction(self._random.randint(100, 999), self._random.choice((-1000, 1000))))

    def vector(self) -> list[Number]:
        """Return another vector."""
        return [self.number() for _ in range(3)]

    def angle(self) -> Number:
        """Return an angle between 0 and 1."""
        return abs(self.number())

    def frame(self) -> tuple[list[Number], list[Number]]:
        """Return a unit quaternion that turns, and its derivative: the first terms of a normalised series."""
        turning = normalised(self.ar, [self.ar.variable(self.number(), self.number()) for _ in range(4)])
        return [x[0] for x in turning], [x[1] for x in turning]

    def direction(self) -> list[Number]:
        """Return a unit vector."""
        return normalised(self.balls, self.vector())


def vector(components: Sequence[Number]) -> list[Number]:
    """Return a vector as a quaternion."""
    return [components[0] * 0, *components]


def scalar(value: Number) -> list[Number]:
    """Return a number as a quaternion."""
    return [value, value * 0, value * 0, value * 0]


def total(*terms: Sequence[Number]) -> list[Number]:
    """Return the sum of vectors or quaternions."""
    return [sum(parts[1:], parts[0]) for parts in zip(*terms, strict=True)]


def times(factor: Number, components: Sequence[Number]) -> list[Number]:
    """Return a multiple of a vector or quaternion."""
    return [x * factor for x in components]


def rate_of(value: Quaternion, derivative: Quaternion) -> list[Number]:
    """Return the angular rate, in the new axes, of a quaternion that changes: by ``sum(y_k x y_k')/2`` of its axes."""
    back = conjugate(value)
    zero, one = value[0] * 0, value[0] * 0 + 1
    rate = [zero, zero, zero]
    for unit in ([zero, one, zero, zero], [zero, zero, one, zero], [zero, zero, zero, one]):
        axis = product(product(value, unit), back)
        change = total(product(product(derivative, unit), back), product(product(value, unit), conjugate(derivative)))
        rate = total(rate, times(one / 2, cross(axis[1:], change[1:])))
    return rotate(back, rate)


def moment_of_forces(data: Data, arm: Sequence[Number]) -> list[Number]:
    """Return (1.6): M + m a x l."""
    return total(data.moment, times(data.mass, cross(data.force, arm)))


def momentum_axis_rate(data: Data, axis: Sequence[Number], arm: Sequence[Number]) -> list[Number]:
    """Return (1.2): the rate of the axes whose k-th goes along the momentum."""
    turning = cross(axis, moment_of_forces(data, arm))
    return total(times(1 / data.momentum, turning), times(data.spin, axis))
