"""Exact coefficients of the methods of polynomial fit, against polynomials whose integrals are known."""

from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.subjects.fitted_methods import (
    FITTED_METHODS,
    chebyshev_fit,
    chebyshev_integrals,
    iterate_degree,
    magnus_weights,
    power_fit,
)

samples = st.integers(2, 10)
rationals = st.fractions(min_value=-3, max_value=3, max_denominator=20)


def chebyshev(j, x):
    """T_j(x) by its recurrence, on numbers or on polynomials' values."""
    previous, current = Fraction(1), x
    for _ in range(j):
        previous, current = current, 2 * x * current - previous
    return previous


def power_integral(j, start, end):
    return (end ** (j + 1) - start ** (j + 1)) / (j + 1)


def chebyshev_integral(j, start, end):
    """The antiderivative of T_j is T_(j+1)/(2(j+1)) - T_(j-1)/(2(j-1)) from j = 2 on."""
    if j < 2:
        return power_integral(j, start, end)
    upper, lower = (chebyshev(j + 1, x) / (2 * (j + 1)) - chebyshev(j - 1, x) / (2 * (j - 1)) for x in (end, start))
    return upper - lower


FITS = {"power": (power_fit, power_integral), "chebyshev": (chebyshev_fit, chebyshev_integral)}


@pytest.mark.parametrize("basis", FITS)
@settings(derandomize=True, deadline=None, max_examples=30)
@given(data=st.data(), n=samples)
def test_fit_gives_the_polynomial_back(basis, data, n):
    """Increments twice the integrals of a polynomial of degree N - 1: its own coefficients are the answer."""
    fit, integral = FITS[basis]
    coefficients = data.draw(st.lists(rationals, min_size=n, max_size=n))
    edges = [Fraction(2 * i, n) - 1 for i in range(n + 1)]
    increments = [2 * sum(c * integral(j, *ends) for j, c in enumerate(coefficients)) for ends in pairwise(edges)]
    tables = fit(n)
    sums = [x + y for x, y in zip(increments, reversed(increments), strict=True)][: (n + 1) // 2]
    differences = [y - x for x, y in zip(increments, reversed(increments), strict=True)][: n // 2]
    even = [sum(k * (e - sums[-1]) for k, e in zip(row, sums, strict=False)) for row in tables.even]
    odd = [sum(k * o for k, o in zip(row, differences, strict=True)) for row in tables.odd]
    constant = sum(increments) / 4 - sum(m * c for m, c in zip(tables.mean, even, strict=True))
    assert [constant, *even] == coefficients[::2]
    assert odd == coefficients[1::2]


@settings(derandomize=True, deadline=None)
@given(n=samples, m=st.integers(0, 20), k=st.integers(0, 11))
def test_integrals_of_chebyshev_products(n, m, k):
    """T_m T_k = (T_(m+k) + T_|m-k|)/2."""
    table = chebyshev_integrals(n)
    m, k = min(m, len(table) - 1), min(k, iterate_degree(n))
    whole = (
        chebyshev_integral(m + k, Fraction(-1), Fraction(1)) + chebyshev_integral(abs(m - k), Fraction(-1), Fraction(1))
    ) / 2
    assert table[m][k] == whole / ((2 if m == 0 else 1) * (2 if k == 0 else 1))


def test_integrals_reach_the_degrees_of_both_factors():
    for n in range(2, 11):
        table = chebyshev_integrals(n)
        assert len(table) - 1 == iterate_degree(n) + n - 1
        assert {len(row) for row in table} == {iterate_degree(n) + 1}


@settings(derandomize=True, deadline=None)
@given(n=samples, data=st.data())
def test_magnus_generators_are_those_of_the_moments(n, data):
    """alpha_2 = 12 A_1, alpha_3 = 180 A_2 - 15 A_0; omega dt = 2 w dtau and (t - t_middle)/H = tau/2."""
    w = data.draw(st.lists(rationals, min_size=n, max_size=n))
    moments = [
        sum(2 * c * power_integral(j + i, Fraction(-1), Fraction(1)) for j, c in enumerate(w)) / 2**i for i in range(3)
    ]
    weights = magnus_weights(n)
    assert sum(a * c for a, c in zip(weights[1::2], w[1::2], strict=True)) == 12 * moments[1]
    assert sum(a * c for a, c in zip(weights[::2], w[::2], strict=True)) == 180 * moments[2] - 15 * moments[0]


def test_methods_are_complete_and_named_after_their_samples():
    for n in range(2, 11):
        for family in ("taylor", "quatfiter"):
            method = FITTED_METHODS[f"{family}{n}"]
            assert method.samples_per_step == n
            assert method.order == 2 * (n // 2) + 2
    assert [FITTED_METHODS[name].order for name in ("magnus4", "magnus6_three_samples", "magnus6")] == [4, 4, 6]
    for name, method in FITTED_METHODS.items():
        assert name == method.name
        assert name.isidentifier()
        assert method.summary
        assert method.source
        # Attitude 4, velocity 3, and as many carried errors.
        assert method.state_bytes == 8 * 2 * (4 + 3)
