r"""Proved solutions of ordinary differential equations: Taylor series with an enclosed remainder.

A step of length h from a state x, a box of balls, has two parts:

* the *a-priori enclosure*, a box B that contains the solution during the whole step. By Picard's theorem every box with
  :math:`x + [0, h]\,f(B) \subseteq B` is one;
* the *Taylor series* of the solution through x up to order n. Lagrange's remainder is :math:`t^{n+1}` times coefficient
  n + 1 of the solution through some point of B: computed over all of B, that coefficient encloses it.

All operations are on balls, so that the result encloses the exact solution whatever step and order are: these decide
only how narrow it is. That boxes grow when they are turned (wrapping) multiplies radii of 1e-75 by some power of ten
that the working precision can spare.

Sources: R. E. Moore, "Interval Analysis", Prentice-Hall 1966; R. J. Lohner, "Enclosing the solutions of ordinary
initial and boundary value problems", in "Computerarithmetic", Teubner 1987.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import floor, log2

from flint import arb, arb_poly, fmpq

from sinsref.arithmetic import BallArithmetic, Number
from sinsref.recorded import AutonomousField, RecordedField

#: Working precision over a box: balls that are wide need no more.
_BOX_BITS = 64
#: How much wider than an iterate of Picard the next box is tried.
_INFLATION = 1.25
_PICARD_ITERATIONS = 10
#: The shortest step, relative to the time so far: on the way to a singularity steps shrink without end.
_SHORTEST = 2.0**-30


class EnclosureError(ArithmeticError):
    """No step, however short, has an a-priori enclosure: the solution may leave the domain of the field."""


def enclosure(field: RecordedField, state: Sequence[Number], step: Number) -> list[Number] | None:
    """Return a box that contains the solution from a state during a whole step, None if none was found.

    Parameters
    ----------
    field : RecordedField
    state : sequence of n arb
    step : arb
        Greater than 0.
    """
    times = arb(0).union(step)
    box = list(state)
    for _ in range(_PICARD_ITERATIONS):
        increments = [times * series[1] for series in field.coefficients(box, 1)]
        image = [x + dx for x, dx in zip(state, increments, strict=True)]
        if not all(x.is_finite() for x in image):
            return None
        if all(old.contains(new) for old, new in zip(box, image, strict=True)):
            return image
        # A component that does not change at all stays as narrow as it is: exact zeros stay exact.
        box = [x + dx + arb(0, dx.rad() * (_INFLATION - 1)) for x, dx in zip(state, increments, strict=True)]
    return None


def enclosed_states(
    balls: BallArithmetic,
    field: AutonomousField,
    initial: Sequence[Number],
    interval: Number,
    count: int,
    *,
    order: int,
    tolerance: float,
) -> Iterator[list[Number]]:
    """Yield balls that contain the solution at the times 0, interval, ..., count * interval.

    Parameters
    ----------
    balls : BallArithmetic
        Entered; its precision is the working precision.
    field : callable
        ``field(arithmetic, state)`` returns the derivative of the state.
    initial : sequence of n arb
        State at time 0.
    interval : arb
        Distance of the epochs.
    count : int
        Number of intervals.
    order : int
        Order of the Taylor series.
    tolerance : float
        Largest remainder of a component, relative to the largest term of its series: what the steps are chosen for.
        It decides how narrow the balls are, not whether they hold.

    Raises
    ------
    EnclosureError
        If steps become too short: the solution may not exist as long as that.
    """
    recorded = RecordedField(balls, field, len(initial))
    state = list(initial)
    yield state
    position, size = Fraction(0), Fraction(1)  # in intervals: exact, so that every epoch is certainly in one step
    while position < count:
        series = recorded.coefficients(state, order)
        while True:
            size = min(rounded_step(size), count - position)
            step = multiple(interval, size)
            remainder = _remainder(recorded, state, step, order)
            excess = _excess(series, remainder, step, tolerance) if remainder else float(2 ** (order + 1))
            if excess <= 1:
                break
            size *= Fraction(max(0.9 * excess ** (-1 / (order + 1)), 1 / 16))
            if size < _SHORTEST * max(Fraction(1), position):
                raise EnclosureError(f"no enclosure of the solution beyond {float(multiple(interval, position)):g}")
        polynomials = [arb_poly([*x, r]) for x, r in zip(series, remainder, strict=True)]
        for epoch in range(floor(position) + 1, floor(position + size) + 1):
            state = _at(polynomials, multiple(interval, epoch - position))
            yield state
        state = _at(polynomials, step)
        position += size
        # The remainder grows with step^(order + 1); the margin saves most second attempts.
        size *= Fraction(min(0.95 * max(excess, 1e-300) ** (-1 / (order + 1)), 4.0))


def multiple(interval: Number, factor: Fraction) -> Number:
    """Return a rational multiple of a ball."""
    return interval * arb(fmpq(factor.numerator, factor.denominator))


def _at(polynomials: Sequence[arb_poly], time: Number) -> list[Number]:
    return [polynomial(time) for polynomial in polynomials]


def rounded_step(size: Fraction) -> Fraction:
    """Return a step of at most `size` whose fraction stays short, however many steps are added up."""
    unit = Fraction(2) ** (floor(log2(size)) - 6)
    return floor(size / unit) * unit


def _remainder(field: RecordedField, state: Sequence[Number], step: Number, order: int) -> list[Number]:
    """Return balls that contain coefficient order + 1 of the solution everywhere in a step; none without enclosure."""
    with BallArithmetic(_BOX_BITS):
        box = enclosure(field, state, step)
        if box is None:
            return []
        remainder = [series[-1] for series in field.coefficients(box, order + 1)]
    return remainder if all(x.is_finite() for x in remainder) else []


def _excess(series: Sequence[Sequence[Number]], remainder: Sequence[Number], step: Number, tolerance: float) -> float:
    """Return the largest remainder at the end of a step, in units of the tolerance."""
    with BallArithmetic(_BOX_BITS):
        powers = [step**k for k in range(len(series[0]))]
        worst = 0.0
        for coefficients, last in zip(series, remainder, strict=True):
            largest = max(x.abs_upper() * power for x, power in zip(coefficients, powers, strict=True))
            if largest > 0 and not last.is_zero():  # a series without terms gives no scale
                ratio = last.abs_upper() * powers[-1] * step / (largest * tolerance)
                worst = max(worst, float(ratio.abs_upper()))
    return worst
