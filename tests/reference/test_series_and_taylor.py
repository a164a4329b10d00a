"""Power series over an arithmetic, and the integration of differential equations with them."""

from fractions import Fraction
from math import comb, factorial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.dual_quaternion import transfer
from sinsref.elementary import cosine_and_sinc
from sinsref.series import Series, SeriesArithmetic
from sinsref.taylor import doubled, integrate

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=60)
AR = MpArithmetic(50)
S = SeriesArithmetic(AR)
ORDER = 24
CLOSE = AR.number("1e-45")  # rounding at 50 digits, some hundred operations
small = st.integers(-300, 300).map(lambda n: AR.number(Fraction(n, 100)))
polynomials = st.lists(small, min_size=1, max_size=6)


def series_of(coefficients):
    return Series(lambda k: AR.number(0), tuple(coefficients))


def coefficients(series, order=ORDER):
    return [series[k] for k in range(order)]


def agree(found, expected):
    scale = max([1, *map(abs, expected)])
    return all(abs(x - y) <= CLOSE * scale for x, y in zip(found, expected, strict=True))


@deterministic
@given(small)
def test_expansions_of_elementary_functions(x):
    t = S.variable(x)
    sine, cosine = AR.sin_cos(x)
    hyperbolic_sine, hyperbolic_cosine = AR.sinh_cosh(x)
    turns = [sine, cosine, -sine, -cosine]
    orders = range(ORDER)
    assert agree(coefficients(S.exp(t)), [AR.exp(x) / factorial(k) for k in orders])
    assert agree(coefficients(S.sin_cos(t)[0]), [turns[k % 4] / factorial(k) for k in orders])
    assert agree(coefficients(S.sin_cos(t)[1]), [turns[(k + 1) % 4] / factorial(k) for k in orders])
    pair = [hyperbolic_sine, hyperbolic_cosine]
    assert agree(coefficients(S.sinh_cosh(t)[0]), [pair[k % 2] / factorial(k) for k in orders])
    assert agree(coefficients(S.sinh_cosh(t)[1]), [pair[(k + 1) % 2] / factorial(k) for k in orders])


def test_square_root_and_quotients_expand_by_the_binomial_theorem():
    one_minus = 1 - S.variable(AR.number(0))
    root = [AR.number(Fraction(comb(2 * k, k), 4**k * (1 - 2 * k))) for k in range(ORDER)]
    assert agree(coefficients(S.sqrt(one_minus)), root)
    assert agree(coefficients(1 / one_minus), [AR.number(1)] * ORDER)
    assert agree(coefficients(S.number(1) / (one_minus * one_minus)), [AR.number(k + 1) for k in range(ORDER)])


@deterministic
@given(polynomials, polynomials, small)
def test_ring_operations_and_their_inverses(a, b, c):
    x, y = series_of(a), series_of([b[0] + 7, *b[1:]])
    product = [sum(x[i] * y[k - i] for i in range(k + 1)) for k in range(ORDER)]
    assert agree(coefficients(x * y), product)
    # Dividing by y can grow like its nearest zero's inverse powers; what multiplies back must be x again.
    order = 10
    assert agree(coefficients((x / y) * y, order), coefficients(x, order))
    assert agree(coefficients((c / y) * y, order), coefficients(S.constant(c), order))
    assert agree(coefficients(x + y - y), coefficients(x))
    assert agree(coefficients(c - x), coefficients(-(x - c)))
    assert agree(coefficients(c + x), coefficients(x + S.constant(c)))
    assert agree(coefficients(c * x), coefficients(x * S.constant(c)))
    assert agree(coefficients(x / (c + 4)), coefficients(x * (1 / (c + 4))))
    square = y * y + 30
    assert agree(coefficients(S.sqrt(square) * S.sqrt(square), order), coefficients(square, order))


@deterministic
@given(polynomials, st.integers(0, 12))
def test_coefficients_do_not_depend_on_the_order_in_which_they_are_asked_for(a, k):
    def build():
        x = series_of(a)
        return S.exp(x) / (x * x + 2) + S.sin_cos(x)[0] * S.sqrt(x * x + 5)

    early = build()
    late = build()
    assert early[k] == [late[i] for i in range(13)][k]
    assert early[0] == late[0]


def test_coefficients_are_computed_once_and_only_when_asked_for():
    asked = []

    def rule(k):
        asked.append(k)
        return AR.number(k)

    doubled_series = Series(rule) * 2
    assert asked == []
    assert doubled_series[2] == 4
    assert doubled_series[2] == 4
    assert sorted(asked) == [0, 1, 2]


@deterministic
@given(st.floats(0.3, 3), st.floats(-2, 2))
def test_the_first_coefficient_is_the_derivative(x, slope):
    x, slope = AR.number(x), AR.number(slope)

    def function(ar, z):
        sine, cosine = ar.sin_cos(z)
        return ar.sqrt(z * z + 1) * sine / (cosine + 3) + ar.exp(-z)

    fine = MpArithmetic(150)
    step = fine.number("1e-50")
    rise = function(fine, fine.number(x) + step)
    fall = function(fine, fine.number(x) - step)
    derivative = AR.number(0) + (rise - fall) / (2 * step)  # its error is of the order of 1e-100
    dual = function(S, S.variable(x, slope))
    assert abs(dual[1] - slope * derivative) <= CLOSE
    assert abs(dual[0] - function(AR, x)) <= CLOSE


def test_a_series_read_before_it_is_defined_is_an_error():
    with pytest.raises(RuntimeError, match="before it was defined"):
        S.unknown(AR.number(1))[1]


def test_exact_numbers_signs_and_widening():
    assert agree(coefficients(S.pi, 3), [AR.pi, AR.number(0), AR.number(0)])
    assert agree(coefficients(S.number("1/3"), 2), [AR.number("1/3"), AR.number(0)])
    negative = S.variable(AR.number(-2), 5)
    assert (S.sign(negative), S.magnitude(negative), S.resolution) == (-1, S.base.magnitude(negative[0]), AR.resolution)
    with BallArithmetic(100) as balls:
        series = SeriesArithmetic(balls)
        wide = series.widen(series.number(1), series.number("0.5"))
        assert wide[0].contains(1.4999)
        assert not wide[0].contains(1.51)
        assert wide[1].is_zero()


@deterministic
@given(st.floats(0.3, 3), st.floats(-2, 2), st.floats(-2, 2))
def test_dual_numbers_are_series_cut_off_after_the_first_power(x, slope, other):
    def function(ar, z, w):
        (sine, cosine), (sinh, cosh) = ar.sin_cos(z), ar.sinh_cosh(w)
        quotient = (1 - ar.sqrt(z * z + 1)) / (cosine * ar.pi - 4) + 2 / z + z / 3
        return [
            quotient * sinh - ar.exp(-z) * cosh,
            sine - ar.number("1/3") * w,
            2 - w,
            z - 1,
            cosh + ar.constant(AR.pi),
        ]

    given_series = S.variable(AR.number(x), AR.number(slope)), S.variable(AR.number(other), AR.number(1))
    series = function(S, *given_series)
    principal, dual = transfer(
        AR, lambda ar, p: function(ar, *p), [AR.number(x), AR.number(other)], [AR.number(slope), AR.number(1)]
    )
    for value, part, expected in zip(principal, dual, series, strict=True):
        assert abs(value - expected[0]) <= CLOSE * (1 + abs(expected[0]))
        assert abs(part - expected[1]) <= CLOSE * (1 + abs(expected[1]))


@deterministic
@given(st.floats(0, 3).map(lambda x: x * x), st.integers(0, 40))
def test_cosine_and_sinc_are_smooth_through_zero(square, halvings):
    square = AR.number(square) / AR.number(4) ** halvings
    cosine, sinc = cosine_and_sinc(S, S.variable(square))
    exact = MpArithmetic(160).number(square)
    # cos(sqrt(z)) and sin(sqrt(z))/sqrt(z) by their power series in z, and the derivatives by the same series.
    terms = range(60)
    powers = [exact**k for k in terms]
    even = [Fraction((-1) ** k, factorial(2 * k)) for k in terms]
    odd = [Fraction((-1) ** k, factorial(2 * k + 1)) for k in terms]
    for found, rule in ((cosine, even), (sinc, odd)):
        value = sum(c.numerator * z / c.denominator for c, z in zip(rule, powers, strict=True))
        slope = sum(k * rule[k].numerator * powers[k - 1] / rule[k].denominator for k in terms[1:])
        assert abs(found[0] - value) < CLOSE
        assert abs(found[1] - slope) < CLOSE


def test_balls_of_cosine_and_sinc_enclose():
    for square in ("1e-80", "1e-9", "0.06", "0.07", "3"):
        with BallArithmetic(80) as coarse:
            low = cosine_and_sinc(coarse, coarse.number(square))
        with BallArithmetic(400) as fine:
            root = fine.sqrt(fine.number(square))
            sine, cosine = fine.sin_cos(root)
            assert low[0].overlaps(cosine)
            assert low[1].overlaps(sine / root)
            assert low[0].rad() < 1e-22


@pytest.mark.parametrize(
    ("field", "initial", "exact"),
    [
        (lambda ar, t, y: [y[1], -y[0]], (0, 1), lambda t: AR.sin_cos(t)),
        (lambda ar, t, y: [y[0] * y[0]], ("0.2",), lambda t: [1 / (5 - t)]),
        (lambda ar, t, y: [t * y[0]], (1,), lambda t: [AR.exp(t * t / 2)]),
        (lambda ar, t, y: [1 / (y[0] * 2)], (1,), lambda t: [AR.sqrt(1 + t)]),
        (lambda ar, t, y: [ar.base.number(3)], (1,), lambda t: [1 + 3 * t]),
    ],
    ids=["oscillator", "Riccati", "Gauss", "square root", "constant"],
)
def test_known_solutions(field, initial, exact):
    end = AR.number(2)
    start = [AR.number(x) for x in initial]
    found, difference = doubled(AR, field, start, AR.number(0), end, steps=16, order=50)
    assert agree(found, exact(end))
    assert difference < 1e-40


@pytest.mark.parametrize("order", [3, 4, 7])
def test_the_error_falls_with_the_order_as_power_of_the_step(order):
    def error(steps):
        state = integrate(
            AR, lambda ar, t, y: [-y[0] * t], [AR.number(1)], AR.number(0), AR.number(1), steps=steps, order=order
        )
        return abs(state[0] - AR.exp(AR.number("-1/2")))

    ratio = error(256) / error(512)
    assert abs(float(ratio) / 2**order - 1) < 0.05  # the next power of the step is left, 1/512 of it times some 10


def test_the_start_of_the_time_counts():
    (found,) = integrate(AR, lambda ar, t, y: [2 * t], [AR.number(0)], AR.number(3), AR.number(5), steps=3, order=4)
    assert abs(found - 16) < CLOSE
