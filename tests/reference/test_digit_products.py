"""Products of matrices of balls by digits: enclosures, exactness, range."""

from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref import digit_products
from sinsref.arithmetic import BallArithmetic
from sinsref.digit_products import ALL_DIGITS, FEW_DIGITS, OutOfRangeError, Product, cut_row, stacked
from sinsref.exponential_sums import FINE, ExponentialSumArithmetic, Table
from sinsref.rounding import round_balls

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=40)
BITS = 192


def exactly(point):
    mantissa, exponent = (int(x) for x in point.man_exp())
    return mantissa * Fraction(2) ** exponent


def product(left, right, places=ALL_DIGITS):
    return Product(left, right).rows(slice(None), places)


def rows_of_digits(rows):
    return stacked([cut_row(row) for row in rows])


@st.composite
def ball(draw):
    """A ball of any size, precision and radius: exact integers, full mantissas, balls around zero, zero."""
    scale = Fraction(2) ** draw(st.integers(-60, 60))
    kind = draw(st.sampled_from(["full", "full", "integer", "around zero", "zero", "wide"]))
    value = Fraction(draw(st.integers(-(2**190), 2**190)), 2**190) * scale
    if kind == "integer":
        return arb(draw(st.integers(-(2**40), 2**40)))
    if kind == "zero":
        return arb(0)
    radius = arb(2) ** draw(st.integers(-260, -180 if kind != "wide" else -20)) * arb(
        fmpq(scale.numerator, scale.denominator)
    )
    middle = arb(0) if kind == "around zero" else arb(fmpq(value.numerator, value.denominator)).mid()
    return middle + arb(0, radius)


@deterministic
@given(st.data(), st.integers(1, 4), st.integers(1, 6), st.integers(1, 4), st.sampled_from([3, FEW_DIGITS, ALL_DIGITS]))
def test_the_bound_encloses_the_product(data, m, k, n, places):
    with BallArithmetic(BITS):
        left = [[data.draw(ball()) for _ in range(k)] for _ in range(m)]
        right = [[data.draw(ball()) for _ in range(n)] for _ in range(k)]
        head, rest, bound = product(left, rows_of_digits(right), places)
        assert head.shape == rest.shape == bound.shape == (m, n)
        # The farthest corners of the balls: every combination of ends is in the range of the sum of these.
        for i in range(m):
            for j in range(n):
                middle = radius = Fraction(0)
                for x, y in zip(left[i], (row[j] for row in right), strict=True):
                    a, b, r, s = (exactly(z) for z in (x.mid(), y.mid(), x.rad(), y.rad()))
                    middle += a * b
                    radius += abs(a) * s + abs(b) * r + r * s
                found = Fraction(head[i, j]) + Fraction(rest[i, j])
                assert abs(found - middle) + radius <= Fraction(bound[i, j])
                assert abs(rest[i, j]) <= np.spacing(abs(head[i, j])) / 2


@pytest.mark.parametrize(
    ("places", "small"),
    [
        # What the third binary64 would hold, at most half an ulp of the second.
        (ALL_DIGITS, 2.0**-105),
        # The same, on top of 39 terms of ten units of 2^-140 of a product, which the sum of 39 may be smaller than.
        (FEW_DIGITS, 2.0**-105 + 390 * 8 * 2.0**-140),
    ],
)
def test_the_bound_is_small_for_accurate_balls(places, small):
    with BallArithmetic(BITS):
        left = [[arb(k + i).sqrt() for k in range(1, 40)] for i in range(5)]
        right = [[arb(k * 7 + j).sin() for j in range(11)] for k in range(1, 40)]
        head, _, bound = product(left, rows_of_digits(right), places)
    assert (bound < small * np.abs(head).max()).all()


def test_some_rows_are_those_of_the_whole():
    with BallArithmetic(BITS):
        left = [[(arb(2) ** (40 * i) * k).sqrt() for k in range(1, 6)] for i in range(5)]
        made = Product(left, rows_of_digits([[arb(k * 7 + j).sin() for j in range(11)] for k in range(1, 6)]))
    for whole, part in zip(made.rows(slice(None)), made.rows(slice(1, 3)), strict=True):
        assert np.array_equal(whole[1:3], part)


def test_exact_integers_come_out_exactly():
    rng = np.random.default_rng(1)
    a, b = rng.integers(-(2**20), 2**20, (6, 30)), rng.integers(-(2**20), 2**20, (30, 7))
    head, rest, bound = product(
        [list(map(arb, row)) for row in a.tolist()], rows_of_digits([list(map(arb, row)) for row in b.tolist()])
    )
    assert (head == (a @ b)).all()
    assert (rest == 0).all()
    assert (bound < 1e-40).all()


def test_the_largest_digits_in_the_longest_sum_stay_exact():
    terms = digit_products._MAXIMUM_TERMS
    with BallArithmetic(400):
        # All ones in binary, the largest digits there are, of either sign.
        ones = arb(1) - arb(2) ** -150
        left, right = [[ones] * terms, [-ones] * terms], [[ones, -ones]] * terms
        head, rest, bound = product(left, rows_of_digits(right))
        exact = terms * ones * ones
        for i, j, sign in ((0, 0, 1), (0, 1, -1), (1, 0, -1), (1, 1, 1)):
            assert abs(exact * sign - arb(head[i, j]) - arb(rest[i, j])) <= arb(bound[i, j])
    assert (bound < 1e-29).all()
    with pytest.raises(OutOfRangeError, match=str(terms + 1)):
        product([[ones] * (terms + 1)], rows_of_digits([[ones]] * (terms + 1)))


@pytest.mark.parametrize("value", [arb(2) ** 600, arb(2) ** 2000, arb("nan"), arb("inf"), arb(1, "inf")])
def test_what_is_out_of_range_is_refused(value):
    one = rows_of_digits([[arb(1)]])
    with pytest.raises(OutOfRangeError):
        product([[value]], one)
    with pytest.raises(OutOfRangeError):
        rows_of_digits([[value]])


def columns(ar):
    t = ar.time
    sine, cosine = ar.sin_cos(ar.number("sqrt(2)") * t + 1)
    return [t, sine * t * t - cosine / 3, ar.exp(t / 90) * cosine, ar.number(7), ar.number(0), sine * 1e-30, t - t]


@pytest.mark.parametrize("count", [1, FINE, 3 * FINE + 1])
def test_pairs_are_those_of_the_balls(count):
    with ExponentialSumArithmetic(BITS) as ar:
        table = Table(ar, columns(ar), ar.number("1/7"))
        high, low, decided = table.pairs(5, count)
        balls = [round_balls(column) for column in table.balls(5, count)]
    assert high.shape == low.shape == decided.shape == (count, 7)
    for place, (x, x_lo, sure) in enumerate(balls):
        both = sure & decided[:, place]
        assert both.sum() >= 0.98 * count - 1
        assert (high[both, place] == x[both]).all()
        assert (low[both, place] == x_lo[both]).all()


@pytest.mark.parametrize("few", [3, ALL_DIGITS])
def test_pairs_do_not_depend_on_how_many_digits_come_first(monkeypatch, few):
    found = []
    for places in (FEW_DIGITS, few):
        monkeypatch.setattr(digit_products, "FEW_DIGITS", places)
        with ExponentialSumArithmetic(BITS) as ar:
            found.append(Table(ar, columns(ar), ar.number("1/7")).pairs(5, 3 * FINE + 1))
    both = found[0][2] & found[1][2]
    assert both.mean() > 0.8  # the last of the seven columns is zero, which balls do not decide
    for first, second in zip(found[0][:2], found[1][:2], strict=True):
        assert np.array_equal(first[both], second[both])


@pytest.mark.parametrize(("interval", "hard"), [("1/8", {0}), ("1/1000", set())])
def test_values_that_few_digits_do_not_decide_get_more(interval, hard):
    """Seven digits do not prove that a rest is negligible: for each time here, or for one in 125."""
    count = 20_000
    with ExponentialSumArithmetic(BITS) as ar:
        table = Table(ar, [ar.time * ar.number(4)], ar.number(interval) / 4)
        high, low, decided = table.pairs(0, count)
    assert table._hard == hard
    assert decided.all()
    times = [k * Fraction(interval) for k in range(count)]
    assert high[:, 0].tolist() == [float(t) for t in times]
    rests = [float(t - Fraction(float(t))) for t in times]
    assert low[:, 0].tolist() == rests


def test_columns_beyond_the_range_of_digits_fall_back_to_balls():
    with ExponentialSumArithmetic(BITS) as ar:
        table = Table(ar, [ar.exp(ar.time), ar.time], ar.number(2))
        high, _, decided = table.pairs(0, 300)
    assert decided[1:].all()
    np.testing.assert_array_max_ulp(high[:, 0], np.exp(2.0 * np.arange(300)), 1)
