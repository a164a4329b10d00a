"""The published rotation-vector methods beside those of Lebedev and Panov, as data: exact coefficients.

They stand in the order in which a reader meets them, from the simplest on. All are pairs K p_i x p_j, so on general
precession none is of a higher order than 4: the triple products of the sixth order are missing. Two properties tell
them apart.

* *Coning-optimised* coefficients annul the drift on coning to a higher power of the sampling interval, to the square of
  the cone's half-angle. Of what general motion needs they have only the lowest power.
* *Asymmetric* formulas, which remember samples or pair each sample with the last one only, have local errors of even
  powers of the interval. The largest attitude error is of order 3 then; on regular precession that part of it is
  periodic, and the drift is of order 4.
"""

from dataclasses import replace
from fractions import Fraction

from sinsbench.subjects.rotation_vector_methods import RotationVectorMethod

__all__ = ["PUBLISHED_METHODS"]

Pairs = dict[tuple[int, int], Fraction]


def _with_last(numerators: tuple[int, ...], denominator: int) -> Pairs:
    """Return the pairs of each sample with the last one, the compressed form of coning-optimised coefficients."""
    last = len(numerators) + 1
    return {(i, last): Fraction(numerator, denominator) for i, numerator in enumerate(numerators, start=1)}


def _three_samples(outer: Fraction, middle: Fraction) -> Pairs:
    """Return the pairs of ``outer p1 x p3 + middle p2 x (p3 - p1)``."""
    return {(1, 2): middle, (1, 3): outer, (2, 3): middle}


def _high_rate(samples: int) -> Pairs:
    """Return the pairs of sum 1/2 (p_1 + ... + p_(l-1) + p_(l-1)/6) x p_l, where p_0 is the last sample before."""
    pairs = {(i, j): Fraction(1, 2) for j in range(2, samples + 1) for i in range(1, j)}
    for j in range(1, samples + 1):
        pairs[j - 1, j] = pairs.get((j - 1, j), Fraction(0)) + Fraction(1, 12)
    return pairs


_TWO_SAMPLE = RotationVectorMethod(
    name="two_sample",
    order=4,
    samples_per_step=2,
    pairs=_with_last((2,), 3),
    triples={},
    quartics={},
    source="Ignagni 1996",
    summary="two samples, polynomial and coning-optimised at once",
)

_METHODS = (
    RotationVectorMethod("one_sample", 2, 1, {}, {}, {}, "Bortz 1971", "plain exponential of the angle increment"),
    RotationVectorMethod(
        name="recursive",
        order=3,
        samples_per_step=1,
        pairs=_high_rate(1),
        triples={},
        quartics={},
        source="Savage 1998, part I",
        summary="one sample and the one before, coefficient 1/12",
        history=1,
        order_drift=4,
    ),
    _TWO_SAMPLE,
    replace(
        _TWO_SAMPLE,
        name="two_sample_savage",
        source="Savage 1998, part II",
        summary="two samples, velocity with the rotation correction of second order",
        velocity_rule="second order",
        order_velocity=2,
    ),
    replace(
        _TWO_SAMPLE,
        name="two_sample_savage_third",
        source="Savage 1998, part II",
        summary="two samples, velocity with the rotation correction of third order",
        velocity_rule="third order",
        order_velocity=3,
    ),
    RotationVectorMethod(
        name="ignagni2",
        order=3,
        samples_per_step=2,
        pairs={(1, 2): Fraction(32, 45)} | {(i, j): Fraction(-1, 180) for i in (-1, 0) for j in (1, 2)},
        triples={},
        quartics={},
        source="Ignagni 1996",
        summary="two samples and the sum of the two before, coning-optimised",
        history=2,
        order_drift=4,
        order_coning=6,
    ),
    RotationVectorMethod(
        name="miller3",
        order=4,
        samples_per_step=3,
        pairs=_three_samples(Fraction(33, 80), Fraction(57, 80)),
        triples={},
        quartics={},
        source="Miller 1983",
        summary="three samples, polynomial of the rate",
    ),
    RotationVectorMethod(
        name="miller3_coning",
        order=4,
        samples_per_step=3,
        pairs=_three_samples(Fraction(9, 20), Fraction(27, 40)),
        triples={},
        quartics={},
        source="Miller 1983",
        summary="three samples, coning-optimised",
        order_coning=6,
    ),
    RotationVectorMethod(
        name="savage3",
        order=3,
        samples_per_step=3,
        pairs=_with_last((9, 27), 20),
        triples={},
        quartics={},
        source="Ignagni 1996; Savage 1998",
        summary="three samples, coning-optimised, compressed",
        order_drift=4,
        order_coning=6,
    ),
    RotationVectorMethod(
        name="savage_high_rate4",
        order=3,
        samples_per_step=4,
        pairs=_high_rate(4),
        triples={},
        quartics={},
        source="Savage 1998, parts I and II",
        summary="four samples, high-rate coning and sculling recursions",
        history=1,
        order_drift=4,
    ),
    RotationVectorMethod(
        name="lee4",
        order=3,
        samples_per_step=4,
        pairs=_with_last((54, 92, 214), 105),
        triples={},
        quartics={},
        source="Lee, Mark, Tazartes, Yoon 1990; Ignagni 1996",
        summary="four samples, coning-optimised, compressed",
        order_drift=4,
        order_coning=8,
    ),
    RotationVectorMethod(
        name="park5",
        order=3,
        samples_per_step=5,
        pairs=_with_last((250, 525, 650, 1375), 504),
        triples={},
        quartics={},
        source="Park, Kim, Lee, Chung 1999",
        summary="five samples, coning-optimised, compressed",
        order_drift=4,
        order_coning=10,
    ),
)

PUBLISHED_METHODS = {method.name: method for method in _METHODS}
"""The methods by name."""
