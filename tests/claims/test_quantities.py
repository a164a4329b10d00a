"""Rounding and units on cases made by hand."""

from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import MPContext

from sinsbench.claims.quantities import (
    Enclosure,
    Quantity,
    Relation,
    hull,
    interval_rounding_to,
    printed_number,
    printed_relation,
    round_significant,
    rounds_to,
    written_like,
)

context = MPContext()
context.dps = 60

nonzero = st.fractions(min_value=Fraction(-(10**9)), max_value=Fraction(10**9)).filter(bool)


@pytest.mark.parametrize(
    ("value", "printed", "expected"),
    [
        ("0.45", "0.45", True),
        ("0.454999", "0.45", True),
        ("0.455", "0.46", True),  # a tie goes away from zero
        ("0.455", "0.45", False),
        ("0.445", "0.45", True),
        ("-0.445", "-0.45", True),
        ("-0.445", "-0.44", False),
        ("0.44", "-0.44", False),
        ("1.005e-5", "1.01e-5", True),  # binary64 would say 1.00: its 1.005e-5 is below the tie
        ("1.005e-5", "1.00e-5", False),
        ("9.96e-6", "1.00e-5", False),  # three digits of 9.96e-6 are 9.96e-6
        ("9.996e-6", "1.00e-5", True),
        ("9.996e-6", "1e-5", True),
        ("7446.95", "7440", False),
        ("7440.4", "7440", True),
        ("258.4", "258", True),
        ("0.9997", "1", True),
        ("0", "0", True),
        ("0", "0.00", True),
        ("1e-30", "0", False),
        ("0", "1", False),
        ("-5.2e-6", "-5e-6", True),
        ("-5.2e-6", "-5e-5", False),
    ],
)
def test_rounds_to(value: str, printed: str, expected: bool) -> None:
    assert rounds_to(Enclosure.exact(value), printed) is expected


@pytest.mark.parametrize(
    ("value", "printed", "expected"),
    [("pi/2", "pi/2", True), ("pi/2", "0", False), ("0", "0", True), ("dv_H", "dv_E", False)],
)
def test_words_must_be_equal(value: str, printed: str, expected: bool) -> None:
    assert rounds_to(value, printed) is expected


def test_a_number_is_no_word() -> None:
    assert not rounds_to(Enclosure.exact("1.5707963"), "pi/2")


def test_an_interval_rounds_only_if_both_ends_do() -> None:
    assert rounds_to(Enclosure(Fraction("0.445"), Fraction("0.454")), "0.45")
    assert not rounds_to(Enclosure(Fraction("0.444"), Fraction("0.454")), "0.45")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("= 0", Relation("=", Fraction(0))),
        ("< 1", Relation("<", Fraction(1))),
        ("> -2.5e-3", Relation(">", Fraction(-25, 10000))),
        ("0", None),
        ("=0", None),
        ("= pi", None),
        ("<= 1", None),
        ("l = -l", None),
    ],
)
def test_printed_relations(text: str, expected: Relation | None) -> None:
    assert printed_relation(text) == expected


@pytest.mark.parametrize(
    ("lower", "upper", "printed", "within", "expected"),
    [
        ("0", "0", "= 0", "0", True),
        ("0", "1e-40", "= 0", "0", False),
        ("0", "1e-40", "= 0", "1e-30", True),
        ("-1e-31", "1e-30", "= 0", "1e-30", True),
        ("-2e-30", "1e-40", "= 0", "1e-30", False),
        ("0", "1e-40", "= 2", "1e-30", False),
        ("0.9", "1.1", "= 1", "0.1", True),
        ("0.8", "0.99", "< 1", "0", True),
        ("0.8", "1", "< 1", "0", False),  # one of the numbers is not smaller
        ("0.8", "1.2", "< 1", "1", False),  # only equalities are eased
        ("0", "1", "> 0", "0", False),
        ("1e-9", "1", "> 0", "0", True),
    ],
)
def test_relations(lower: str, upper: str, printed: str, within: str, expected: bool) -> None:
    assert rounds_to(Enclosure(Fraction(lower), Fraction(upper)), printed, Fraction(within)) is expected


def test_a_word_has_no_relation() -> None:
    assert not rounds_to("pi/2", "= 0", Fraction(1))


@pytest.mark.parametrize(
    ("lower", "upper", "expected"),
    [("2", "2", "2"), ("0.5", "2061.8430869", "0.5 to 2061.84"), ("0", "7.44e-7", "below 7.4e-07")],
)
def test_intervals_are_written_by_their_ends(lower: str, upper: str, expected: str) -> None:
    assert written_like(Enclosure(Fraction(lower), Fraction(upper)), "= 0") == expected


@given(nonzero, st.integers(1, 8))
def test_rounding_is_to_nearest_with_that_many_digits(value: Fraction, digits: int) -> None:
    rounded = round_significant(value, digits)
    assert len(rounded.as_tuple().digits) == digits
    assert rounds_to(Enclosure.exact(value), str(rounded))
    unit = Fraction(10) ** int(rounded.as_tuple().exponent)
    assert abs(Fraction(rounded) - value) <= unit / 2


@given(nonzero, st.integers(1, 8))
def test_what_is_within_the_interval_of_a_print_is_within_half_a_unit(value: Fraction, digits: int) -> None:
    interval = interval_rounding_to(str(round_significant(value, digits)))
    assert interval.lower <= value <= interval.upper


@pytest.mark.parametrize("printed", ["0", "pi/2"])
def test_no_interval_rounds_to_zero_or_a_word(printed: str) -> None:
    with pytest.raises(ValueError, match="no interval"):
        interval_rounding_to(printed)


@pytest.mark.parametrize("text", ["pi/2", "", "nan", "inf", "dv_H", "1,5"])
def test_what_is_no_number(text: str) -> None:
    assert printed_number(text) is None


@pytest.mark.parametrize(
    ("value", "printed", "expected"),
    [
        ("-0.0134264", "-1.3e-3", "-1.3e-2"),
        ("8.9954e-6", "8.97e-6", "9.00e-6"),
        ("84.3617", "84.6", "84.4"),
        ("-33.19", "33", "-33"),
        ("7446.95", "7440", "7447"),
        ("-5.195e-6", "5e-6", "-5e-6"),
        ("0.0001311", "0", "0.0001311"),
    ],
)
def test_written_like(value: str, printed: str, expected: str) -> None:
    assert written_like(Enclosure.exact(value), printed) == expected


def test_degrees_agree_with_mpmath() -> None:
    value = Quantity(Enclosure.exact("1.57e-7"), "rad").in_unit("deg")
    assert isinstance(value, Enclosure)
    truth = context.mpf("1.57e-7") * 180 / context.pi
    lower, upper = (context.mpf(end.numerator) / end.denominator for end in (value.lower, value.upper))
    # 1e-55 is the rounding of 60 digits with a margin; the enclosure is narrower still.
    assert abs(lower - truth) < truth * 1e-55
    assert abs(upper - truth) < truth * 1e-55
    assert value.lower < value.upper


def test_arcs_and_minutes_are_exact() -> None:
    assert Quantity(Enclosure.exact("2e-7"), "rad", Fraction(6_000_000)).in_unit("m") == Enclosure.exact("1.2")
    assert Quantity(Enclosure.exact("5062"), "s").in_unit("min") == Enclosure.exact(Fraction(5062, 60))
    back = Quantity(Enclosure.exact("1.2"), "m", Fraction(6_000_000)).in_unit("rad")
    assert back == Enclosure.exact("2e-7")


@pytest.mark.parametrize(("unit", "other"), [("rad", "s"), ("m/s", "m"), ("rad", "m")])
def test_units_that_do_not_convert(unit: str, other: str) -> None:
    with pytest.raises(ValueError, match="no conversion"):
        Quantity(Enclosure.exact("1"), unit).in_unit(other)


def test_hull_and_products_hold_all_values() -> None:
    a, b = Enclosure(Fraction(-1), Fraction(2)), Enclosure(Fraction(3), Fraction(5))
    assert hull(a, b) == Enclosure(Fraction(-1), Fraction(5))
    assert a * b == Enclosure(Fraction(-5), Fraction(10))
    assert a / b == Enclosure(Fraction(-1, 3), Fraction(2, 3))
    assert -a == Enclosure(Fraction(-2), Fraction(1))


def test_round_significant_of_zero() -> None:
    assert round_significant(Fraction(0), 3) == Decimal(0)
