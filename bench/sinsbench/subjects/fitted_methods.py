"""Methods that fit polynomials to the increments of a step, as data: exact coefficients, and nothing that computes.

A method takes the N increments of a step as integrals of polynomials of degree N - 1, one for the angular rate
and one for the specific force, and follows the motion that these have. In the time tau of the step, which runs
from -1 to 1 while H seconds pass, the polynomial w(tau) = (H/4) omega obeys

    integral of w over sample i = p_i / 2,        dLambda/dtau = Lambda o w,

so that no coefficient depends on the interval. The same holds for the force with the velocity increments, and
the Kotelnikov-Study transfer gives the velocity: no coefficients are added for it.

The flow of the polynomials is found by the power series of the solution about the middle of the step, by
functional (Picard) iteration in Chebyshev polynomials, or by the Magnus expansion. What the first leaves is the
error of the fit alone, and that is of order N + 2 for even N, N + 1 for odd N: the increments fix the mean of
the rate, and for even N symmetry makes its first moment one order better.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Literal, NamedTuple

__all__ = [
    "FITTED_METHODS",
    "Fit",
    "FittedMethod",
    "Flow",
    "chebyshev_fit",
    "chebyshev_integrals",
    "iterate_degree",
    "magnus_weights",
    "power_fit",
]

Flow = Literal["power series", "functional iteration", "Magnus 4", "Magnus 6"]
Matrix = tuple[tuple[Fraction, ...], ...]
Polynomial = tuple[Fraction, ...]
"""Coefficients in powers of tau, constant term first."""


@dataclass(frozen=True)
class FittedMethod:
    """A method of polynomial fit.

    Attributes
    ----------
    name : str
        Short name, a valid identifier.
    flow : {"power series", "functional iteration", "Magnus 4", "Magnus 6"}
        How the motion of the fitted polynomials is followed.
    samples_per_step : int
        Number N of increments that one step consumes.
    order : int
        Order of convergence of the global error.
    summary : str
        What it is, in one line.
    source : str
        Where the method was published.
    order_coning : int or None
        Order on pure coning where that is another.
    state_bytes : int
        Size of what is carried from one step to the next: attitude and inertial velocity with their carried
        rounding errors, 14 numbers.
    """

    name: str
    flow: Flow
    samples_per_step: int
    order: int
    summary: str
    source: str
    order_coning: int | None = None
    state_bytes: int = 14 * 8


class Fit(NamedTuple):
    """How the coefficients of a polynomial follow from the N increments of a step, by symmetry about its middle.

    Even coefficients depend on the sums e_i = p_i + p_(N+1-i) of opposite increments alone (the middle one of an
    odd number counts as e = 2 p), odd ones on the differences o_i = p_(N+1-i) - p_i alone.

    Attributes
    ----------
    even : matrix of Fraction
        Coefficients 2, 4, ... from e_i - e_innermost, outermost first.
    odd : matrix of Fraction
        Coefficients 1, 3, ... from o_i, outermost first.
    mean : tuple of Fraction
        Means over the step of the basis polynomials 2, 4, ...: coefficient 0 is what these leave of the mean.
    """

    even: Matrix
    odd: Matrix
    mean: tuple[Fraction, ...]


def _powers(count: int) -> list[Polynomial]:
    return [(Fraction(0),) * j + (Fraction(1),) for j in range(count)]


def _chebyshev(count: int) -> list[Polynomial]:
    """Chebyshev polynomials of the first kind, from T_(j+1) = 2 tau T_j - T_(j-1)."""
    result = _powers(2)
    while len(result) < count:
        earlier = (*result[-2], Fraction(0), Fraction(0))
        shifted = (Fraction(0), *(2 * x for x in result[-1]))
        result.append(tuple(x - y for x, y in zip(shifted, earlier, strict=True)))
    return result[:count]


def _integral(polynomial: Polynomial, start: Fraction, end: Fraction) -> Fraction:
    terms = (c * (end ** (j + 1) - start ** (j + 1)) / (j + 1) for j, c in enumerate(polynomial))
    return sum(terms, start=Fraction(0))


def _inverse(matrix: Sequence[Sequence[Fraction]]) -> Matrix:
    """Inverse by Gauss-Jordan elimination; exact numbers need pivots that are not zero, and no others."""
    size = len(matrix)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(size))] for i, row in enumerate(matrix)]
    for i, row in enumerate(rows):
        rows[i] = normal = [x / row[i] for x in row]
        for k, other in enumerate(rows):
            if k != i:
                rows[k] = [x - other[i] * y for x, y in zip(other, normal, strict=True)]
    return tuple(tuple(row[size:]) for row in rows)


def _fit(basis: list[Polynomial]) -> Fit:
    samples = len(basis)
    edges = [Fraction(2 * i - samples, samples) for i in range(samples + 1)]
    integrals = [[_integral(b, *ends) for b in basis] for ends in pairwise(edges)]
    inner = (samples - 1) // 2
    # Opposite samples have equal integrals of even polynomials and opposite ones of odd polynomials.
    even = [[4 * (x - y) for x, y in zip(row, integrals[inner], strict=True)][2::2] for row in integrals[:inner]]
    odd = [[-4 * x for x in row[1::2]] for row in integrals[: samples // 2]]
    mean = tuple(_integral(b, Fraction(-1), Fraction(1)) / 2 for b in basis[2::2])
    return Fit(_inverse(even), _inverse(odd), mean)


def power_fit(samples: int) -> Fit:
    """Fit of a polynomial of degree `samples` - 1 in powers of tau."""
    return _fit(_powers(samples))


def chebyshev_fit(samples: int) -> Fit:
    """Fit of a polynomial of degree `samples` - 1 in Chebyshev polynomials of the first kind."""
    return _fit(_chebyshev(samples))


def iterate_degree(samples: int) -> int:
    """Degree at which functional iteration cuts off its Chebyshev series, one more than the number of samples.

    What is cut off is of the order of the error of the fit.
    """
    return samples + 1


def chebyshev_integrals(samples: int) -> Matrix:
    """Integrals over tau from -1 to 1 of T_m T_n, for m up to the degree of (iterate times fit), n up to an iterate's.

    Entries with m = 0 or n = 0 are halved, both a quarter: the coefficients that they multiply are doubled, see
    `sinsbench.subjects.fitted_iteration_kernels.chebyshev_product`.
    """

    def entry(m: int, n: int) -> Fraction:
        if (m + n) % 2:
            return Fraction(0)
        whole = Fraction(1, 1 - (m + n) ** 2) + Fraction(1, 1 - (m - n) ** 2)
        return whole / ((1 if m else 2) * (1 if n else 2))

    degree = iterate_degree(samples)
    return tuple(tuple(entry(m, n) for n in range(degree + 1)) for m in range(degree + samples))


def magnus_weights(samples: int) -> tuple[Fraction, ...]:
    """Weights of the coefficients w_j of `power_fit` in the generators of the Magnus expansion.

    With the moments A_i = H^-i integral of (t - t_middle)^i omega dt over the step, the generators are
    alpha_1 = A_0 - alpha_3/12, alpha_2 = 12 A_1 and alpha_3 = 180 A_2 - 15 A_0 (Blanes, Casas, Oteo, Ros 2009).

    Parameters
    ----------
    samples : int
        Number N of samples of a step.

    Returns
    -------
    tuple of Fraction
        N weights: alpha_2 is the weighted sum of the odd coefficients and alpha_3 that of the even ones. The
        constant coefficient has weight 0.
    """
    return tuple(Fraction(24, j + 2) if j % 2 else Fraction(180, j + 3) - Fraction(60, j + 1) for j in range(samples))


_SAMPLES = range(2, 11)


def _order(samples: int) -> int:
    return samples + 2 if samples % 2 == 0 else samples + 1


def _magnus(name: str, flow: Flow, samples: int, order: int) -> FittedMethod:
    return FittedMethod(
        name=name,
        flow=flow,
        samples_per_step=samples,
        order=order,
        summary=f"polynomial fit to {samples} samples, {flow}",
        source="Iserles, Norsett 1999; Blanes, Casas, Oteo, Ros 2009; velocity by Kotelnikov-Study transfer",
    )


_METHODS = (
    *(
        FittedMethod(
            name=f"taylor{samples}",
            flow="power series",
            samples_per_step=samples,
            order=_order(samples),
            summary=f"polynomial fit to {samples} samples, power series of attitude and apparent velocity",
            source="Wu, Litmanovich 2020; velocity by Kotelnikov-Study transfer",
        )
        for samples in _SAMPLES
    ),
    *(
        FittedMethod(
            name=f"quatfiter{samples}",
            flow="functional iteration",
            samples_per_step=samples,
            order=_order(samples),
            summary=f"polynomial fit to {samples} samples, functional iteration in Chebyshev polynomials",
            source="Wu 2018 (RodFIter); Wu, Yan 2019 (QuatFIter); Wu 2020 (iNavFIter)",
        )
        for samples in _SAMPLES
    ),
    _magnus("magnus4", "Magnus 4", 2, 4),
    _magnus("magnus6_three_samples", "Magnus 6", 3, 4),
    _magnus("magnus6", "Magnus 6", 4, 6),
)

FITTED_METHODS: dict[str, FittedMethod] = {method.name: method for method in _METHODS}
"""The built-in methods of polynomial fit by name."""
