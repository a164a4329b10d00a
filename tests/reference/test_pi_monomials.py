"""The arithmetic that knows exact zeros."""

from fractions import Fraction

import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic
from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=150)
fractions = st.fractions(min_value=-20, max_value=20, max_denominator=60)
powers = st.integers(-3, 3)
HALF, ROOT = Fraction(1, 2), None  # None: not rational

#: cos of multiples of pi/6: rational by Niven's theorem, or not.
COSINES = [1, ROOT, HALF, 0, -HALF, ROOT, -1, ROOT, -HALF, 0, HALF, ROOT]


def is_monomial(x, coefficient, power):
    return isinstance(x, PiMonomial) and (x.coefficient, x.power) == (coefficient, power if coefficient else 0)


@deterministic
@given(fractions, powers, fractions, powers)
def test_products_and_quotients_are_those_of_the_field(a, m, b, n):
    x, y = PiMonomial(a, m), PiMonomial(b, n)
    assert is_monomial(x * y, a * b, m + n if a * b else 0)
    if b:
        assert is_monomial(x / y, a / b, (m if a else 0) - n)
    else:
        with pytest.raises(ZeroDivisionError):
            x / y


@deterministic
@given(fractions, fractions, powers, st.integers(-9, 9))
def test_sums_of_the_same_power_stay_exact(a, b, n, k):
    x, y = PiMonomial(a, n), PiMonomial(b, n)
    assert is_monomial(x + y, a + b, n)
    assert is_monomial(x - y, a - b, n)
    assert is_monomial(-x, -a, n)
    assert is_monomial(abs(x), abs(a), n)
    assert is_monomial(PiMonomial(a) + k, a + k, 0)
    assert is_monomial(k - PiMonomial(a), k - a, 0)
    assert is_monomial(k * x, k * a, n)
    if k and a:
        assert is_monomial(x / k, a / k, n)
        assert is_monomial(k / x, k / a, -n)


@deterministic
@given(fractions, fractions)
def test_exact_zero_stays_exact(a, b):
    with PiMonomialArithmetic(100) as ar:
        zero, ball = ar.number(0), ar.sqrt(ar.number(2)) + ar.number(a)
        product = zero * ball
        for x in (product, ball * zero, zero / ar.sqrt(ar.number(2)), product * ar.number(b), zero + zero):
            assert is_monomial(x, 0, 0)
        assert (zero + ball).overlaps(ball)
        assert all(is_monomial(x, n, 0) for n, x in enumerate(ar.sin_cos(zero)))
        assert ar.sign(zero) == 0
        assert is_monomial(ar.exp(zero), 1, 0)
        assert is_monomial(ar.sinh_cosh(zero)[0], 0, 0)
        assert is_monomial(ar.widen(zero, zero), 0, 0)


@pytest.mark.parametrize("k", range(-14, 27))
def test_sines_and_cosines_of_multiples_of_a_sixth_of_pi(k):
    with PiMonomialArithmetic(100) as ar:
        sine, cosine = ar.sin_cos(ar.pi * k / 6)
        for value, expected in ((cosine, COSINES[k % 12]), (sine, COSINES[(k - 3) % 12])):
            if expected is None:
                assert isinstance(value, arb)
                assert (value * value - arb("0.75")).contains(0)
            else:
                assert is_monomial(value, Fraction(expected), 0)


@deterministic
@given(fractions)
def test_sines_and_cosines_of_multiples_of_pi_are_never_wrong(turns):
    with PiMonomialArithmetic(100) as ar:
        x = ar.pi * PiMonomial(turns)
        ball = PiMonomial(turns).ball() * arb.pi()
        for value, expected in zip(ar.sin_cos(x), ball.sin_cos(), strict=True):
            enclosure = value.ball() if isinstance(value, PiMonomial) else value
            assert enclosure.overlaps(expected)
            # Exact where it is rational, which Niven's theorem limits to 0, 1/2 and 1.
            assert isinstance(value, PiMonomial) == any(
                (expected - s).contains(0) for s in (-1, arb(-0.5), 0, arb(0.5), 1)
            )


@deterministic
@given(st.fractions(min_value=0, max_value=50, max_denominator=50), powers)
def test_square_roots_are_exact_where_they_are_rational(a, n):
    with PiMonomialArithmetic(100) as ar:
        assert is_monomial(ar.sqrt(PiMonomial(a * a, 2 * n)), a, n)
        root = ar.sqrt(PiMonomial(a, n))
        enclosure = root.ball() if isinstance(root, PiMonomial) else root
        assert enclosure.overlaps(PiMonomial(a, n).ball().sqrt())


# Random expressions: the same tree in plain balls and in this arithmetic must enclose the same number.
leaves = st.sampled_from(["0", "1", "-2", "1/3", "pi", "pi/2", "-pi/6", "sqrt(2)", "5*pi"])
trees = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(st.sampled_from("+-*"), inner, inner),
        st.tuples(st.sampled_from(["sin", "cos", "exp", "sinh", "sqrt of square"]), inner),
    ),
    max_leaves=8,
)


def evaluate(ar, tree):
    if isinstance(tree, str):
        return ar.number(tree)
    operator, *operands = tree
    x, *rest = (evaluate(ar, operand) for operand in operands)
    match operator:
        case "+":
            return x + rest[0]
        case "-":
            return x - rest[0]
        case "*":
            return x * rest[0]
        case "sin":
            return ar.sin_cos(x)[0]
        case "cos":
            return ar.sin_cos(x)[1]
        case "exp":
            return ar.exp(ar.sin_cos(x)[0])
        case "sinh":
            return ar.sinh_cosh(ar.sin_cos(x)[1])[0]
        case _:
            return ar.sqrt(x * x + ar.number(1))


@deterministic
@given(trees)
def test_expressions_agree_with_plain_balls(tree):
    with PiMonomialArithmetic(120) as ar:
        value = evaluate(ar, tree)
        enclosure = value.ball() if isinstance(value, PiMonomial) else value
        with BallArithmetic(200) as balls:
            plain = evaluate(balls, tree)
        assert enclosure.overlaps(plain)
        assert ar.magnitude(value) >= 0.999 * float(plain.abs_lower())
        assert ar.sign(value) in {0, 1 if plain > 0 else -1} or plain.contains(0)
