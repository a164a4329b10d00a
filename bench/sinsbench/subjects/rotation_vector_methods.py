"""Rotation-vector attitude methods as data: exact coefficients, and nothing that computes with them.

A method turns the r angle increments p_1 ... p_r of one step into the rotation vector of the step,

    phi = sum p_i + sum K_ij p_i x p_j + sum K_ijk p_i x (p_j x p_k) + sum K_ijkl (p_i . p_j) p_k x p_l,

and is therefore the three sets of rational numbers K. Indices run from 1 to r; 0, -1, ... are the samples before
the step, which a method with a history remembers and which the sum leaves out. The dual part of the step (apparent
velocity) has no coefficients of its own: the Kotelnikov-Study transfer gives it from the same K, exactly or, in the
classical velocity updates, up to a power of the rotation angle.

Here are the nested methods of orders 2, 4 and 6 of Lebedev, Panov 1989, eq. (2.2), with r = 4; the others stand in
`sinsbench.subjects.published_methods`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import factorial
from typing import Any, NamedTuple, TypeVar

__all__ = [
    "COSINE_SERIES",
    "DUAL_SERIES",
    "METHODS",
    "PANOV_2",
    "PANOV_4",
    "PANOV_6",
    "SERIES_LIMIT",
    "SINE_SERIES",
    "VELOCITY_RULES",
    "Coefficients",
    "RotationVectorMethod",
    "binary64_coefficients",
]


VELOCITY_RULES = {
    "transfer": (Fraction(0), Fraction(0)),
    "second order": (Fraction(1, 2), Fraction(0)),
    "third order": (Fraction(1, 2), Fraction(1, 6)),
}
"""How the velocity gained in a step is resolved in the axes of its start.

``transfer`` takes it from the biquaternion of the step, exactly. The others add to the dual part of the rotation
vector, that is to the velocity increment with its sculling correction, the first or the first two terms of the
rotation correction K_1 P x B + K_2 P x (P x B), where P and B are the sums of the increments of the step.
"""


@dataclass(frozen=True, eq=False)
class RotationVectorMethod:
    """Exact coefficients of one rotation-vector method. Samples are numbered from 1, as in the papers.

    Parameters
    ----------
    name : str
        Short name, a valid identifier.
    order : int
        Order of convergence of the largest attitude error, in general motion; of velocity too, with the rule
        ``transfer``.
    samples_per_step : int
        Number r of increments that one step consumes.
    pairs : mapping of (i, j) to Fraction
        K of the terms K p_i x p_j.
    triples : mapping of (i, j, k) to Fraction
        K of the terms K p_i x (p_j x p_k).
    quartics : mapping of (i, j, k, l) to Fraction
        K of the terms K (p_i . p_j) p_k x p_l.
    source : str
        Where the method was published.
    summary : str
        What it is, in one line.
    history : int
        Number of samples before the step that it remembers.
    velocity_rule : str
        One of `VELOCITY_RULES`.
    order_velocity : int or None
        Order of the velocity error, where that is another.
    order_drift : int or None
        Order of the secular part of the attitude error on regular precession, where that is another.
    order_coning : int or None
        Order of the drift on pure coning in the limit of a narrow cone, to the square of its half-angle, where that
        is another still. Coefficients optimised for coning have it; what they leave over is of `order_drift`, and
        small as the fourth power of the half-angle.

    Raises
    ------
    ValueError
        If an index has the wrong length or is not one of 1 - history ... samples_per_step, or there is no such
        velocity rule.
    """

    name: str
    order: int
    samples_per_step: int
    pairs: Mapping[tuple[int, int], Fraction]
    triples: Mapping[tuple[int, int, int], Fraction]
    quartics: Mapping[tuple[int, int, int, int], Fraction]
    source: str
    summary: str = ""
    history: int = 0
    velocity_rule: str = "transfer"
    order_velocity: int | None = None
    order_drift: int | None = None
    order_coning: int | None = None

    def __post_init__(self) -> None:
        first = 1 - self.history
        for length, table in ((2, self.pairs), (3, self.triples), (4, self.quartics)):
            for index in table:
                if len(index) != length or not all(first <= i <= self.samples_per_step for i in index):
                    wanted = f"{length} sample numbers in {first}..{self.samples_per_step}"
                    raise ValueError(f"{self.name}: index {index} is not {wanted}")
        if self.velocity_rule not in VELOCITY_RULES:
            raise ValueError(
                f"{self.name}: velocity rule {self.velocity_rule!r} is none of {', '.join(VELOCITY_RULES)}"
            )

    @property
    def window(self) -> int:
        """Number of samples that one step looks at: those it remembers, then those it consumes."""
        return self.history + self.samples_per_step


_PANOV = "Lebedev, Panov 1989, eq. (2.2), order {}, r = 4"
_NESTED = Fraction(2, 3)  # (2/3) (p1+p2) x (p3+p4): what order 4 adds to order 2, and order 6 keeps
_SIXTH = _NESTED - Fraction(8, 9)  # order 6 subtracts (8/9) of the same product

PANOV_2 = RotationVectorMethod("panov2", 2, 4, {}, {}, {}, _PANOV.format(2))

PANOV_4 = RotationVectorMethod(
    "panov4", 4, 4, {(i, j): _NESTED for i in (1, 2) for j in (3, 4)}, {}, {}, _PANOV.format(4)
)

PANOV_6 = RotationVectorMethod(
    name="panov6",
    order=6,
    samples_per_step=4,
    pairs={
        (1, 3): _SIXTH + Fraction(32, 15),
        (1, 4): _SIXTH,
        (2, 3): _SIXTH - Fraction(64, 45),
        (2, 4): _SIXTH + Fraction(32, 15),
    },
    triples={(1, 2, 4): Fraction(32, 45), (4, 1, 3): Fraction(-32, 45)},
    quartics={(2, 3, 2, 3): Fraction(64, 45)},
    source=_PANOV.format(6),
)

METHODS = {method.name: method for method in (PANOV_2, PANOV_4, PANOV_6)}
"""The built-in methods by name."""

SERIES_LIMIT = 1.0
"""Largest squared rotation angle, rad^2, at which the power series below replace the closed forms.

The closed form of the third function cancels: its absolute error is an ulp divided by the squared angle.
Eight terms leave a relative truncation error below 1e-17 at this limit: no accuracy is lost on either side.
"""

_TERMS = 8

COSINE_SERIES = tuple(Fraction((-1) ** k, 4**k * factorial(2 * k)) for k in range(_TERMS))
"""Coefficients of cos(n/2) in powers of n^2."""

SINE_SERIES = tuple(Fraction((-1) ** k, 2 * 4**k * factorial(2 * k + 1)) for k in range(_TERMS))
"""Coefficients of sin(n/2)/n in powers of n^2."""

DUAL_SERIES = tuple(Fraction((-1) ** k * k, 4**k * factorial(2 * k + 1)) for k in range(1, _TERMS + 1))
"""Coefficients of n^-2 (cos(n/2)/2 - sin(n/2)/n) in powers of n^2."""


class Coefficients(NamedTuple):
    """The coefficients as a compiled kernel takes them: binary64 numbers, samples numbered from 0, remembered first.

    Tables are padded with zero coefficients to a common size, so that methods share one compiled kernel; `pairs`,
    `triples` and `quartics` count the entries that matter. A step looks at `window` increments and consumes `samples`
    of them, the last ones. `resolving` holds the two coefficients of a velocity rule.
    """

    pair_index: tuple[tuple[int, int], ...]
    pair: tuple[float, ...]
    triple_index: tuple[tuple[int, int, int], ...]
    triple: tuple[float, ...]
    quartic_index: tuple[tuple[int, int, int, int], ...]
    quartic: tuple[float, ...]
    cosine: tuple[float, ...]
    sine: tuple[float, ...]
    dual: tuple[float, ...]
    series_limit: float
    resolving: tuple[float, float]
    pairs: int
    triples: int
    quartics: int
    window: int
    samples: int


_PAIRS, _TRIPLES, _QUARTICS = 10, 2, 1  # sizes of the tables: all pairs of five samples, and what order 6 needs

_Index = TypeVar("_Index", bound=tuple[int, ...])


def _table(
    table: Mapping[_Index, Fraction], length: int, size: int, earlier: int
) -> tuple[tuple[_Index, ...], tuple[float, ...]]:
    rows: list[Any] = [tuple(i - 1 + earlier for i in index) for index in table]
    padding = max(0, size - len(rows))
    values = [float(value) for value in table.values()]
    return tuple(rows + [(0,) * length] * padding), tuple(values + [0.0] * padding)


def binary64_coefficients(
    method: RotationVectorMethod,
    *,
    series_limit: float = SERIES_LIMIT,
    cosine: Sequence[Fraction] = COSINE_SERIES,
    sine: Sequence[Fraction] = SINE_SERIES,
    dual: Sequence[Fraction] = DUAL_SERIES,
) -> Coefficients:
    """Round the exact coefficients of a method, and of the power series, to binary64.

    Parameters
    ----------
    method : RotationVectorMethod
        The method.
    series_limit : float
        Squared rotation angle, rad^2, up to which the series replace the closed forms; 0 for closed forms.
    cosine, sine, dual : sequence of Fraction
        Series coefficients of cos(n/2), sin(n/2)/n and n^-2 (cos(n/2)/2 - sin(n/2)/n) in powers of n^2.

    Returns
    -------
    Coefficients
        Every coefficient correctly rounded.
    """
    earlier = method.history
    first, second = VELOCITY_RULES[method.velocity_rule]
    return Coefficients(
        *_table(method.pairs, 2, _PAIRS, earlier),
        *_table(method.triples, 3, _TRIPLES, earlier),
        *_table(method.quartics, 4, _QUARTICS, earlier),
        tuple(map(float, cosine)),
        tuple(map(float, sine)),
        tuple(map(float, dual)),
        series_limit,
        (float(first), float(second)),
        len(method.pairs),
        len(method.triples),
        len(method.quartics),
        method.window,
        method.samples_per_step,
    )
