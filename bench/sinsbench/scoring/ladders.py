"""Ladders of sampling intervals: a case sampled at each, with truth at instants that all have in common."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import lcm

from sinsbench.scoring.inputs import InputErrors, input_errors
from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.sampling import SampledMotion, sample
from sinsref.exact import ExactNumber

__all__ = ["LADDER", "Rung", "coarser_rungs", "ladder"]

LADDER = tuple(Fraction(2) / 2**k for k in range(6))
"""Sampling intervals of a ladder, in units of the case's own."""

_MOST_SAMPLES = 400_000  # on a rung: its arrays grow with the samples, and so does what computes them
_USUAL_SAMPLES_PER_STEP = 4
# Above a ladder, in units of its coarsest interval: close together, as high orders fall to the floor in few halvings.
_COARSER = tuple(map(Fraction, ("5/4", "3/2", "2", "5/2", "3", "4", "5", "6", "8")))


@dataclass(frozen=True)
class Rung:
    """A case sampled at one interval, and what the rounding of these samples does.

    Attributes
    ----------
    motion : SampledMotion
    inputs : InputErrors
    factor : Fraction
        The interval in units of the case's own.
    """

    motion: SampledMotion
    inputs: InputErrors
    factor: Fraction


def ladder(
    case: DualPrecessionCase, factors: Sequence[Fraction] = LADDER, convention: str = "increments"
) -> tuple[Rung, ...]:
    """Sample a case at a ladder of intervals, coarsest first.

    Parameters
    ----------
    case : DualPrecessionCase
    factors : sequence of Fraction
        Intervals in units of the case's. Left out are those that do not divide the duration into whole samples and
        those that divide it into more than 400,000, which would fill the memory; never the case's own interval, 1.
    convention : str, default "increments"
        What the samples hold: a name of `sinsdata.truth.conventions.CONVENTIONS`.

    Returns
    -------
    tuple of Rung
        Checkpoints are as far apart as a step of four samples at the coarsest interval, where that divides
        the duration.

    Raises
    ------
    ValueError
        If no interval is left, or there is no such convention.
    """
    used = sorted((x for x in map(Fraction, factors) if (case.samples / x).denominator == 1), reverse=True)
    if not used:
        raise ValueError(f"none of the intervals asked for divides {case.duration.text} s into whole samples")
    used = [x for x in used if x == 1 or case.samples / x <= _MOST_SAMPLES]
    if not used:
        raise ValueError(
            f"the intervals asked for divide {case.duration.text} s into more than {_MOST_SAMPLES} samples"
        )
    common = used[0]
    for factor in used:  # the least common multiple of fractions; it divides the duration as each of them does
        numerators = common.numerator * factor.denominator, factor.numerator * common.denominator
        common = Fraction(lcm(*numerators), common.denominator * factor.denominator)
    step = common * _USUAL_SAMPLES_PER_STEP
    spacing = step if (case.samples / step).denominator == 1 else common
    distance = ExactNumber(f"({case.interval.text})*{spacing.numerator}/{spacing.denominator}")
    motions = ((sample(case, factor, distance, convention), factor) for factor in used)
    return tuple(Rung(motion, input_errors(motion), factor) for motion, factor in motions)


@lru_cache(maxsize=24)
def _single(case: DualPrecessionCase, factor: Fraction, convention: str) -> Rung:
    return ladder(case, (factor,), convention)[0]


def coarser_rungs(case: DualPrecessionCase, rungs: Sequence[Rung]) -> Iterator[Rung]:
    """Yield rungs above a ladder, one after the other, up to eight times its coarsest interval.

    Each has checkpoints of its own, so that those of the ladder stay where they are. Those that do not divide the
    duration into whole samples are left out.

    Parameters
    ----------
    case : DualPrecessionCase
    rungs : sequence of Rung
        What `ladder` returned for the case.
    """
    for factor in (rungs[0].factor * coarser for coarser in _COARSER):
        if (case.samples / factor).denominator == 1:
            yield _single(case, factor, rungs[0].motion.convention.name)
