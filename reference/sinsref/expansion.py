r"""Functions of time tabulated by Taylor polynomials with proved remainders, and their integrals.

A formula of time is expanded once for many epochs: in arithmetic of power series (python-flint's ``arb_series``) about
the middle of a piece, to order n, and once more over the whole piece as one wide ball, to order n + 1. The last
coefficient of the latter encloses Lagrange's remainder, so every value and every integral is a ball that holds the
exact one. Order and length of the pieces decide only how narrow it is.

Source: R. E. Moore, "Interval Analysis", Prentice-Hall 1966.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from math import ceil, floor, inf
from types import TracebackType
from typing import Self, TypeAlias

import flint
from flint import arb, arb_mat, arb_series, fmpq

from sinsref.arithmetic import Arithmetic, BallArithmetic, Number
from sinsref.enclosure import EnclosureError, multiple, rounded_step

#: ``formula(arithmetic, time)`` returns the values of some functions of time.
Functions: TypeAlias = Callable[[Arithmetic, Number], Sequence[Number]]

#: Working precision over a whole piece: balls that are wide need no more.
_WIDE_BITS = 64
#: The shortest piece, in intervals.
SHORTEST = Fraction(1, 2**30)


class BallSeriesArithmetic(BallArithmetic):
    """Balls and power series of balls; the length of series belongs to the process as the precision does.

    Parameters
    ----------
    bits : int
        Working precision.
    order : int
        Highest power that is kept.
    """

    def __init__(self, bits: int, order: int) -> None:
        super().__init__(bits)
        self.order = order
        self._outer_caps: list[int] = []

    def __enter__(self) -> Self:
        super().__enter__()
        self._outer_caps.append(flint.ctx.cap)
        flint.ctx.cap = self.order + 1
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        flint.ctx.cap = self._outer_caps.pop()
        super().__exit__(kind, error, trace)

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        """Return sine and cosine together."""
        return (x.sin(), x.cos()) if isinstance(x, arb_series) else super().sin_cos(x)

    def expanded(self, functions: Functions, time: arb) -> list[list[arb]]:
        """Return the Taylor coefficients 0 ... order of functions at a time, one list each."""
        variable = arb_series([time, arb(1)], self.order + 1)
        return [self._coefficients(value) for value in functions(self, variable)]

    def _coefficients(self, value: Number) -> list[arb]:
        if not isinstance(value, arb_series):
            return [arb(value), *[arb(0)] * self.order]
        return [value[k] for k in range(self.order + 1)]


class Expander:
    """Taylor coefficients of functions of time at an instant, and bounds of them over a piece of time.

    Its two arithmetics stay the same, so that functions may keep what does not depend on time for each.

    Parameters
    ----------
    functions : callable
        ``functions(arithmetic, time)``.
    bits : int
        Working precision at an instant.
    order : int
        Order of the polynomials.
    """

    def __init__(self, functions: Functions, bits: int, order: int) -> None:
        self._functions = functions
        self._narrow = BallSeriesArithmetic(bits, order)
        self._wide = BallSeriesArithmetic(_WIDE_BITS, order + 1)

    def at(self, time: arb) -> list[list[arb]]:
        """Return the coefficients 0 ... order at a time."""
        with self._narrow as balls:
            return balls.expanded(self._functions, time)

    def over(self, middle: arb, half: arb) -> list[list[arb]]:
        """Return balls that contain the coefficients 0 ... order + 1 everywhere in a piece of time.

        None, an empty list, if some divisor may be zero there.
        """
        with self._wide as balls:
            try:
                return balls.expanded(self._functions, middle + arb(0, half.abs_upper()))
            except (ValueError, ZeroDivisionError):  # how arb_series refuses such a divisor
                return []


def values_at(polynomials: Sequence[Sequence[arb]], unit: arb, times: Sequence[Fraction]) -> Iterator[list[arb]]:
    """Yield the values of polynomials at some times, all in one product of matrices.

    Parameters
    ----------
    polynomials : sequence of sequence of arb
        Their coefficients.
    unit : arb
        Unit of the times.
    times : sequence of Fraction
        Small multiples of the unit.
    """
    if not times:
        return
    length, width = max(map(len, polynomials)), len(polynomials)
    scaled = [arb(0)] * (length * width)
    for column, terms in enumerate(polynomials):
        power = arb(1)
        for k, x in enumerate(terms):
            scaled[k * width + column] = x * power
            power *= unit
    powers: list[arb] = []
    for time in times:
        factor, power = arb(fmpq(time.numerator, time.denominator)), arb(1)
        for _ in range(length):
            powers.append(power)
            power *= factor
    entries = (arb_mat(len(times), length, powers) * arb_mat(length, width, scaled)).entries()
    for place in range(0, len(entries), width):
        yield entries[place : place + width]


def tabulated(
    balls: BallArithmetic,
    functions: Functions,
    interval: arb,
    first: int,
    last: int,
    *,
    order: int,
    tolerance: float,
) -> Iterator[tuple[list[arb], list[arb]]]:
    """Yield functions of time at the epochs first * interval ... last * interval, and their integrals since the first.

    Parameters
    ----------
    balls : BallArithmetic
        Entered; its precision is the working precision.
    functions : callable
        ``functions(arithmetic, time)``, analytic during all of the time.
    interval : arb
        Distance of the epochs.
    first, last : int
        Numbers of epochs.
    order : int
        Order of the polynomials.
    tolerance : float
        Largest remainder of a function, relative to the largest term of its polynomial.

    Raises
    ------
    EnclosureError
        If pieces become too short: a function may not be analytic there.
    """
    expander = Expander(functions, balls.bits, order)
    position, size, done = Fraction(first), Fraction(1), first - 1
    total: list[arb] = []
    while done < last:
        size = max(min(size, last - position), SHORTEST)
        middle, half = position + size / 2, multiple(interval, size / 2)
        at_middle = multiple(interval, middle)
        narrow, wide = expander.at(at_middle), expander.over(at_middle, half)
        excess = _excess(narrow, wide, half, tolerance)
        if excess > 1:
            size = rounded_step(size * Fraction(max(0.9 * excess ** (-1 / (order + 1)), 1 / 16)))
            if size < SHORTEST:
                raise EnclosureError(
                    f"no expansion beyond t = {float(multiple(interval, position)):g} s: singular there?"
                )
            continue
        values = [[*terms, rest[-1]] for terms, rest in zip(narrow, wide, strict=True)]
        # From the start of the piece on, and so that the first of them goes on from the piece before.
        integrals = [[arb(0), *(x / (k + 1) for k, x in enumerate(terms))] for terms in values]
        (base,) = values_at(integrals, half, [Fraction(-1)])
        for terms, before, x in zip(integrals, base, total or [arb(0)] * len(base), strict=True):
            terms[0] = x - before
        epochs = range(max(done + 1, ceil(position)), min(last, floor(position + size)) + 1)
        times = [(epoch - middle) / (size / 2) for epoch in epochs]
        for row in values_at([*values, *integrals], half, times):
            yield row[: len(values)], row[len(values) :]
        done += len(epochs)
        (total,) = values_at(integrals, half, [Fraction(1)])
        position += size
        size = rounded_step(size * Fraction(min(0.95 * max(excess, 1e-300) ** (-1 / (order + 1)), 4.0)))


def _excess(narrow: Sequence[Sequence[arb]], wide: Sequence[Sequence[arb]], half: arb, tolerance: float) -> float:
    """Return the largest remainder at the ends of a piece, in units of the tolerance."""
    if not wide:
        return inf
    with BallArithmetic(_WIDE_BITS):
        powers = [half**k for k in range(len(wide[0]))]
        worst = arb(0)
        for terms, rest in zip(narrow, wide, strict=True):
            if not rest[-1].is_zero():
                largest = max(x.abs_upper() * power for x, power in zip(terms, powers, strict=False))
                worst = worst.max(abs(rest[-1]) * powers[-1] / (largest * tolerance))
        return float(worst.abs_upper()) if worst.is_finite() else inf
