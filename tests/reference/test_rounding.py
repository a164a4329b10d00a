"""Pairs of binary64: correct rounding, what decides it, what is counted."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq
from hypothesis import example, given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic
from sinsref.exact import ExactNumber
from sinsref.rounding import (
    ESCALATION,
    NEGLIGIBLE,
    RoundingTally,
    UndecidedError,
    decide,
    nearest_float,
    pairs_at,
    round_balls,
    round_value,
)

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=200)


def expected_pair(value):
    """The pair by Python's own rounding of fractions, which is correct (to nearest, ties to even)."""
    high = float(value)
    return high, float(value - Fraction(high))


def ball_of(value):
    return arb(fmpq(value.numerator, value.denominator))


def exactly(point):
    mantissa, exponent = (int(x) for x in point.man_exp())
    return mantissa * Fraction(2) ** exponent


# Around what makes rounding hard: the ends of binades, halfway points, and neighbours at tiny distances.
hard = st.builds(
    lambda power, ulps, halves, distance, sign: (
        sign * Fraction(2) ** power * (1 + ulps * Fraction(2) ** -53 + halves * Fraction(2) ** -54)
        + sign * distance * Fraction(2) ** (power - 90)
    ),
    st.integers(-200, 200),
    st.integers(-8, 8),
    st.integers(-1, 1),
    st.integers(-3, 3),
    st.sampled_from([1, -1]),
)
ordinary = st.fractions(max_denominator=10**30).filter(bool)


@deterministic
@given(st.one_of(ordinary, hard))
@example(Fraction(2**53 + 1))  # ties to even, down and up
@example(Fraction(2**53 + 3))
@example(1 - Fraction(1, 2**54))  # the gap below a power of two is half the gap above
@example(1 - Fraction(1, 2**54) + Fraction(1, 2**150))
@example(Fraction(3, 2**1074))  # subnormal
@example(Fraction(1, 10**310))
@example(Fraction(2**53 - 1, 2**1074) / 3)
@example(Fraction(1, 10**400))  # a rational that rounds to 0
def test_rationals_round_exactly(value):
    tally = RoundingTally()
    pair = round_value(lambda ar: ar.number(value), tally)
    assert pair == expected_pair(value)
    assert tally == RoundingTally()
    assert nearest_float(lambda ar: ar.number(value)) == pair[0]


@deterministic
@given(st.lists(st.one_of(ordinary, hard), min_size=1, max_size=8), st.integers(160, 300))
def test_a_decided_ball_is_rounded_correctly(values, bits):
    with BallArithmetic(bits):
        high, low, decided = round_balls([ball_of(value) for value in values])
    for value, x, x_lo, sure in zip(values, high, low, decided, strict=True):
        if sure:
            expected, rest = expected_pair(value)
            assert x == expected
            # 0 stands for a rest below NEGLIGIBLE too.
            assert x_lo == rest or (x_lo == 0 and abs(rest) < NEGLIGIBLE * abs(x))


@deterministic
@given(st.one_of(ordinary, hard), st.integers(30, 120))
def test_a_wide_ball_is_never_decided_wrongly(value, bits):
    """Every number of a decided ball has the same pair: try its ends."""
    with BallArithmetic(bits):
        ball = ball_of(value) * (1 + arb(0, 2.0 ** (1 - bits)))
        high, low, decided = round_balls([ball])
        middle, radius = (exactly(x) for x in (ball.mid(), ball.rad()))
    for end in (middle - radius, middle, middle + radius) if decided[0] else ():
        expected, rest = expected_pair(end)
        assert high[0] == expected
        assert low[0] == rest or abs(rest) < NEGLIGIBLE * abs(expected)


def test_deciding_by_numbers():
    nan, inf, tiny = math.nan, math.inf, 5e-324
    rows = [
        # high, low, what is left, low then, decided
        (1.0, 1e-17, 1e-40, 1e-17, True),
        (1.0, 2.0**-54, 1e-40, 2.0**-54, False),  # half the gap below 1
        (1.5, 2.0**-54, 1e-40, 2.0**-54, True),
        (1.0, 1e-17, 1e-33, 1e-17, False),
        (-1.0, -1e-50, 1e-52, 0.0, True),  # negligible
        (1.0, 0.0, 0.0, 0.0, True),
        (0.0, 0.0, 0.0, 0.0, True),
        (0.0, 0.0, 1e-300, 0.0, False),
        (tiny, 0.0, 0.0, 0.0, True),
        (tiny, 0.0, tiny, 0.0, False),
        (nan, nan, nan, nan, False),
        (inf, nan, nan, nan, False),
    ]
    high, low, left, expected, sure = (np.array(column) for column in zip(*rows, strict=True))
    found = decide(high, low, left)
    assert np.array_equal(found[0], high, equal_nan=True)
    assert np.array_equal(found[1], expected, equal_nan=True)
    assert np.array_equal(found[2], sure)


def test_ordinary_values_are_decided_at_once():
    with BallArithmetic(192) as balls:
        _, _, decided = round_balls([balls.sqrt(balls.number(k)) for k in range(2, 500)])
    assert decided.all()


@pytest.mark.parametrize(
    "text",
    [
        "pi*1e-299",
        "pi*1e-305",
        "-pi*1e-310",
        "sqrt(2)*1e-300",
        "sqrt(2)*1e-323",
        "-pi/3",
        "pi*3e307",
        "1 + pi*3e-17",
        "-1 - pi*3e-17",
        "1 - pi*1e-17",
        "1 + 0.0009765625*(1 + pi*3e-17)",
        "2 + pi*4e-17",
    ],
)
def test_irrational_values_round_as_a_close_rational_does(text):
    with BallArithmetic(5000) as balls:
        close = exactly(balls.number(text).mid())
    assert round_value(ExactNumber(text).evaluate) == expected_pair(close)


def test_undecided_values_raise_the_precision():
    # 1 + 2^-53 +- 2^-400 lies next to a tie, which 256 bits do not see.
    bits = []

    def formula(ar, index):
        bits.append(ar.bits)
        one = ar.exp(ar.number(0)) * ar.sqrt(ar.number(2)) / ar.sqrt(ar.number(2))
        sign = 1 if index else -1
        return [one + ar.number(Fraction(1, 2**53)) + ar.number(Fraction(sign, 2**400)), ar.sqrt(ar.number(3))]

    tally = RoundingTally()
    high, low = pairs_at(formula, [0, 1], 192, tally)
    assert high[:, 0].tolist() == [1, 1 + 2.0**-52]
    assert low[:, 0].tolist() == [2.0**-53, -(2.0**-53)]
    assert (high[:, 1] == math.sqrt(3)).all()
    assert max(bits) == ESCALATION[1]
    assert (tally.values, tally.raised) == (4, 2)
    assert (tally.exact_zeros, tally.bounded_zeros) == (0, 0)


def test_exact_zeros_and_bounded_zeros_are_told_apart():
    tally = RoundingTally()
    pair = round_value(lambda ar: ar.sin_cos(ar.pi * 3)[0], tally)
    assert pair == (0, 0)
    assert (tally.exact_zeros, tally.bounded_zeros) == (1, 0)

    def identity(ar):  # sqrt(2) sqrt(3) - sqrt(6), zero, but the arithmetic does not know
        return ar.sqrt(ar.number(2)) * ar.sqrt(ar.number(3)) - ar.sqrt(ar.number(6))

    pair = round_value(identity, tally)
    assert [math.copysign(1, x) for x in pair] == [1, 1]
    assert pair == (0, 0)
    assert (tally.exact_zeros, tally.bounded_zeros) == (1, 1)
    # Not zero, but below every binary64: the same, and counted.
    assert round_value(lambda ar: -ar.exp(ar.number(-1000)) * ar.exp(ar.number(-1000)), tally) == (0, 0)
    assert tally.bounded_zeros == 2


def test_block_evaluation_does_not_take_an_underflow_for_a_zero():
    with BallArithmetic(192):
        tiny = arb(2) ** -1200
        high, low, decided = round_balls([tiny, -tiny, arb(0), arb(1) + tiny, arb(0, 1e-320), 1 + arb(0, tiny)])
    assert decided.tolist() == [False, False, True, True, False, True]
    assert (high == [0, 0, 0, 1, 0, 1]).all()
    assert not low[decided].any()


def test_a_value_that_no_precision_decides_is_an_error():
    with pytest.raises(UndecidedError, match="4096 bits do not decide"):
        round_value(lambda ar: ar.number(1) + ar.widen(ar.number(0), ar.number("1e-17")))
    with pytest.raises(UndecidedError):
        round_value(lambda ar: ar.sqrt(-ar.pi))  # not a number


def test_settle_changes_undecided_places_only():
    asked = []

    def formula(ar, index):
        asked.append(index)
        # In the third row the first value is an identity that balls cannot tell from zero.
        zero = ar.sin_cos(ar.pi * index)[0] if index == 2 else ar.sqrt(ar.number(index + 1))
        return [zero, ar.number(index) / ar.number(3)]

    tally = RoundingTally()
    high, low = pairs_at(formula, range(4), 192, tally)
    assert asked == [0, 1, 2, 3, 2]
    assert (high[:, 0] == [1, math.sqrt(2), 0, 2]).all()
    assert (high[:, 1] == np.arange(4) / 3).all()
    assert low[1, 1] == expected_pair(Fraction(1, 3))[1]
    assert (tally.values, tally.raised, tally.exact_zeros) == (8, 1, 1)


@pytest.mark.parametrize(
    ("text", "pair"),
    [
        # 2 cos(pi/3) is 1, and sqrt(2)^2 is 2, but no ball knows: what is added is half a unit in the last place.
        ("sqrt(2)*sqrt(2)/2 + 1.1102230246251565404236316680908203125e-16", (1.0, 2.0**-53)),
        ("sqrt(2)*sqrt(2)/2 + 3*1.1102230246251565404236316680908203125e-16", (1.0 + 2.0**-51, -(2.0**-53))),
        ("-sqrt(2)*sqrt(2)/2 - 1.1102230246251565404236316680908203125e-16", (-1.0, -(2.0**-53))),
        ("sqrt(2)*sqrt(2)/2", (1.0, 0.0)),
    ],
)
def test_a_tie_that_no_precision_decides_goes_to_the_even_neighbour(text: str, pair: tuple[float, float]) -> None:
    assert round_value(ExactNumber(text).evaluate) == pair
