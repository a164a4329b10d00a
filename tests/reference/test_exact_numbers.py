"""Exactly given numbers and the arithmetics that evaluate them."""

import math
import threading
from fractions import Fraction

import flint
import mpmath
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.exact import ExactNumber, ExpressionError

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=100)

ACCEPTED = {
    "1": Fraction(1),
    "-7.29e-5": Fraction(-729, 10**7),
    "0.1": Fraction(1, 10),
    ".5": Fraction(1, 2),
    "3.": Fraction(3),
    "1E2": Fraction(100),
    " 1/3 + 1/6 ": Fraction(1, 2),
    "-(2 - 5)*+4": Fraction(12),
    "2*7.29e-5*6378245": 2 * Fraction("7.29e-5") * 6378245,
    "sqrt(2.25)": Fraction(3, 2),
    "sin(pi/6)": Fraction(1, 2),
    "cos(pi)": Fraction(-1),
    "pi/pi": Fraction(1),
    "pi - pi": Fraction(0),
}


@pytest.mark.parametrize(("text", "value"), ACCEPTED.items())
def test_rational_expressions_are_exact(text, value):
    assert ExactNumber(text).fraction == value
    assert float(ExactNumber(text)) == float(value)


@pytest.mark.parametrize("text", ["pi", "pi/18", "sqrt(2)", "sin(1)", "cos(pi/5)", "pi + 1"])
def test_irrational_expressions_are_not_taken_for_fractions(text):
    assert ExactNumber(text).fraction is None


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        ("2**3", "2**3"),
        ("1 + exp(2)", "exp(2)"),
        ("x", "'x'"),
        ("sin(1, 2)", "sin(1, 2)"),
        ("sin(x=1)", "sin(x=1)"),
        ("1j", "1j"),
        ("True", "True"),
        ("'1'", "'1'"),
        ("0x10", "0x10"),
        ("1_000", "1_000"),
        ("[1]", "[1]"),
        ("__import__('os')", "__import__"),
        ("1 if 1 else 2", "1 if 1 else 2"),
        ("1e99999999", "1e99999999"),  # the integer would fill the memory
    ],
)
def test_the_message_names_the_piece_that_is_outside_the_grammar(text, piece):
    with pytest.raises(ExpressionError) as caught:
        ExactNumber(text)
    assert piece in str(caught.value)
    assert "admissible: decimal numbers, pi" in str(caught.value)


@pytest.mark.parametrize("text", ["", "1 +", "pi pi", "\x00", "(" * 90 + "1", "1" * 900, "-" * 201 + "1"])
def test_what_cannot_be_read_is_refused(text):
    with pytest.raises(ExpressionError):
        ExactNumber(text)


@pytest.mark.parametrize(
    "value", ["1/0", "1/(pi - pi)", "1/sin(pi)", "sqrt(-1)", "sqrt(1 - pi)", "1e400", math.inf, -math.inf, math.nan]
)
def test_what_has_no_finite_real_value_is_refused(value):
    with pytest.raises(ExpressionError, match="finite"):
        ExactNumber(value)


@deterministic
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_float_is_the_binary64_it_is_and_its_text_reads_back(x):
    number = ExactNumber(x)
    assert number.fraction == Fraction(x)
    assert float(number) == x
    assert ExactNumber(number.text).fraction == Fraction(x)


@deterministic
@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=-1000000, max_value=1000000))
def test_a_decimal_is_the_decimal_and_not_its_binary64(x):
    text = f"{x:f}"
    assert ExactNumber(text).fraction == Fraction(text)


@deterministic
@given(st.fractions(max_denominator=10**9))
def test_a_fraction_reads_back(x):
    assert ExactNumber(x).fraction == x
    assert ExactNumber(ExactNumber(x).text).fraction == x


def test_equality_goes_by_the_text():
    assert ExactNumber("pi/18") == ExactNumber(ExactNumber(" pi/18"))
    assert hash(ExactNumber(0.5)) == hash(ExactNumber("0.5"))
    assert ExactNumber("1/2") != ExactNumber("0.5")
    assert ExactNumber(1) != 1
    assert repr(ExactNumber("pi")) == "ExactNumber('pi')"


@deterministic
@given(st.sampled_from([*ACCEPTED, "pi/18", "sqrt(2)", "-sin(1)*cos(2)", "sqrt(pi)/3"]), st.integers(64, 300))
def test_all_arithmetics_agree_on_an_expression(text, bits):
    digits = int(bits / 3.4)
    readable = MpArithmetic(digits).number(text)
    with BallArithmetic(bits) as balls:
        ball = balls.number(text)
        difference = abs(ball - arb(mpmath.libmp.to_str(readable._mpf_, digits + 5)))
        # Six roundings at most in each expression.
        assert difference < 10 * (1 + abs(ball)) * 10.0 ** (1 - digits)


def test_the_global_context_of_mpmath_stays_as_it_is():
    before = mpmath.mp.dps
    arithmetic = MpArithmetic(80)
    arithmetic.sin_cos(arithmetic.number("pi/18"))
    assert mpmath.mp.dps == before
    assert arithmetic.context is not mpmath.mp


def test_threads_at_different_precisions_do_not_disturb_one_another():
    digits = {30: None, 200: None}
    barrier = threading.Barrier(2)

    def work(count):
        arithmetic = MpArithmetic(count)
        wrong = 0
        for _ in range(50):
            barrier.wait()
            root = arithmetic.sqrt(arithmetic.number(2))
            wrong += abs(root * root - 2) > 10 * arithmetic.resolution or arithmetic.context.dps != count
            with BallArithmetic(4 * count) as balls:
                radius = balls.sqrt(balls.number(2)).rad()
                wrong += not (2.0 ** (-4 * count - 8) < radius < 2.0 ** (4 - 4 * count))
        digits[count] = wrong

    threads = [threading.Thread(target=work, args=(count,)) for count in digits]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert digits == {30: 0, 200: 0}


def test_ball_arithmetic_restores_the_precision():
    outside = flint.ctx.prec
    arithmetic = BallArithmetic(300)
    with arithmetic:
        assert flint.ctx.prec == 300
        with BallArithmetic(77):
            assert flint.ctx.prec == 77
        with arithmetic:  # the same one again
            assert flint.ctx.prec == 300
        assert flint.ctx.prec == 300

    def fail():
        with BallArithmetic(999), BallArithmetic(111):
            raise LookupError

    with pytest.raises(LookupError):
        fail()
    assert flint.ctx.prec == outside


def test_signs_and_magnitudes():
    with BallArithmetic(100) as balls:
        around_zero = balls.widen(balls.number(0), balls.number("1e-9"))
        assert [balls.sign(x) for x in (balls.pi, -balls.pi, around_zero)] == [1, -1, 0]
        assert around_zero.contains(arb("1e-9") * 0.999)
        assert balls.magnitude(balls.pi) >= math.pi
        assert 1e-9 <= balls.magnitude(around_zero) < 1.001e-9
    readable = MpArithmetic(40)
    assert [readable.sign(readable.number(x)) for x in (2, 0, "-pi")] == [1, 0, -1]
    assert readable.magnitude(-readable.pi) >= math.pi
