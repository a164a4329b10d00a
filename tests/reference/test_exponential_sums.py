"""Blocks of epochs by products of ball matrices against evaluation epoch by epoch."""

import pytest
from flint import acb, arb
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic
from sinsref.equator import EquatorModel, homogeneous
from sinsref.exact import ExactNumber
from sinsref.exponential_sums import ExponentialSum, ExponentialSumArithmetic, NotAnExponentialSumError, Table
from sinsref.precession import DualPrecession, increments, solution

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=12)
BITS = 192


def agree(formula, interval, first, count, places, radius):
    """Tabulate, and compare some rows with direct evaluation at a higher precision."""
    with ExponentialSumArithmetic(BITS) as ar:
        table = Table(ar, formula(ar, ar.time), ar.number(interval))
        columns = table.balls(first, count)
    assert {len(column) for column in columns} == {count}
    for place in places:
        with BallArithmetic(2 * BITS) as balls:
            exact = formula(balls, balls.number(interval) * (first + place))
            for column, value in zip(columns, exact, strict=True):
                value = value if isinstance(value, arb) else balls.number(value)
                assert column[place].overlaps(value)
                assert abs(column[place] - value) < radius * (1 + abs(value))


def precession(values):
    numbers = [ExactNumber(x) for x in values]
    motion = DualPrecession(*numbers[:5], tuple(numbers[5:9]), tuple(numbers[9:12]))

    def formula(ar, time):
        attitude, inertial, body = solution(ar, motion, time)
        angle, velocity = increments(ar, motion, time, ar.number("0.01"))
        return [*attitude, *inertial, *body, *angle, *velocity]

    return formula


rates = st.floats(-10, 10).filter(lambda x: abs(x) > 1e-3)


@deterministic
@given(
    st.tuples(
        rates, st.one_of(st.sampled_from([0.0, 1.0, -1.0, 1e-9]), st.floats(-2, 2)), st.floats(0, 3.2), rates, rates,
        st.floats(0.1, 1), *[st.floats(-1, 1)] * 3, *[st.floats(-100, 100)] * 3,
    ),
    st.integers(0, 10**6),
    st.integers(1, 600),
)  # fmt: skip
def test_random_motions(values, first, count):
    # 192 bits, phases up to 1e5 rad, velocities up to 1e5 m/s.
    agree(precession(values), "1/100", first, count, {0, count // 2, count - 1}, 1e-42)


@pytest.mark.parametrize("count", [1, 255, 256, 257, 512, 513])
@pytest.mark.parametrize("first", [0, 1, 255, 256, 1000])
def test_the_ends_of_blocks(first, count):
    def formula(ar, time):
        sine, cosine = ar.sin_cos(ar.number("sqrt(2)") * time + ar.number(1))
        return [time, sine * time * time - cosine / 3, ar.exp(time / 100) * cosine, ar.number(7)]

    places = {place for place in (0, 1, 254, 255, 256, 257, 511, 512) if place < count}
    agree(formula, "1/7", first, count, places, 1e-45)


@pytest.mark.parametrize("v_east", ["600", "-464.98", "7440", "7700", "12000", "-9000"])
def test_the_equator(v_east):
    def formula(ar, time):
        model = EquatorModel.at(ar, ExactNumber(v_east), ExactNumber("10000"))
        return homogeneous(ar, model, [ar.number(x) for x in ("0.01", "0.02", "-0.01", "1", "1e-7", "2e-7")], time)

    agree(formula, "7", 0, 700, {0, 1, 256, 699}, 1e-35)  # the errors grow by exp(10)


def test_sums_keep_the_laws_of_a_ring():
    with ExponentialSumArithmetic(BITS) as ar:
        t = ar.time
        sine, cosine = ar.sin_cos(t * 3 + 1)
        sinh, cosh = ar.sinh_cosh(t / 5 - 2)
        half_sine, half_cosine = ar.sin_cos(t * ar.number("3/2"))
        sums = [
            sine * sine + cosine * cosine - 1,
            cosh * cosh - sinh * sinh - 1,
            (sine + cosh) * t - t * cosh - sine * t,
            2 - (1 - sine) - sine - 1,
            ar.exp(t) * ar.exp(-t) - 1,
            (half_sine * half_cosine - half_cosine * half_sine) * 2,
            ar.sin_cos(t * 0)[1] - 1,
            t / 4 - t * ar.number("1/4"),
        ]
        columns = Table(ar, sums, ar.number(2)).balls(0, 50)
        assert all(value.contains(0) and value.rad() < 1e-40 for column in columns for value in column)


def test_a_rate_counts_once_whatever_its_sign():
    with ExponentialSumArithmetic(BITS) as ar:
        for slope in ("1/3", "-1/3"):
            ar.sin_cos(ar.number(slope) * ar.time)
            ar.exp(ar.number(slope) * ar.time)
        assert len(ar.rates) == 2
        assert ar.rates[0].real == 0
        # Close is not equal: another number gets a rate of its own.
        ar.exp((ar.number("1/3") + ar.number("1e-55")) * ar.time)
        assert len(ar.rates) == 3


@pytest.mark.parametrize(
    "formula",
    [
        lambda ar, t: ar.sin_cos(t * t),
        lambda ar, t: ar.exp(ar.exp(t)),
        lambda ar, t: ar.sqrt(t),
        lambda ar, t: 1 / (t + 1),
        lambda ar, t: t / (ar.sin_cos(t)[0] + 2),
        lambda ar, t: ar.sinh_cosh(ar.sin_cos(t)[0]),
        lambda ar, t: ar.magnitude(t),
        lambda ar, t: ar.sign(t - 1),
        lambda ar, t: ar.widen(1, t),
    ],
)
def test_formulas_that_are_no_exponential_sums_are_refused(formula):
    with ExponentialSumArithmetic(BITS) as ar, pytest.raises(NotAnExponentialSumError):
        formula(ar, ar.time)


def test_constants_pass_for_numbers():
    with ExponentialSumArithmetic(BITS) as ar:
        three = ar.time * 0 + 3
        assert ar.sqrt(three).overlaps(arb(3).sqrt())
        assert ar.sign(-three) == -1
        assert 3 <= ar.magnitude(three) < 3.001
        assert (12 / three).terms[(0, ())].overlaps(acb(4))


def uncertain(ar, radius):
    """One, and terms with coefficients that contain zero: growing, falling, oscillating with a power of time."""
    error = acb(arb(0, radius), arb(0, radius))
    column = ExponentialSum.of(arb(1))
    for term in (ar.exp(ar.time / 10), ar.exp(-ar.time / 10), ar.sin_cos(ar.time)[0] * ar.time):
        column = column + term * error
    return column


def test_what_cancelled_terms_may_be_is_in_the_balls():
    with ExponentialSumArithmetic(BITS) as ar:
        table = Table(ar, [uncertain(ar, 1e-20)], ar.number("1/2"))
        for first in (-200, 0, 200):
            for place, value in enumerate(table.balls(first, 100)[0]):
                t = arb(first + place) / 2
                worst = arb(1e-20) * ((t / 10).exp() + (-t / 10).exp() + abs(t)) * arb("0.999")
                assert value.contains(1 + worst)
                assert value.contains(1 - worst)


@pytest.mark.parametrize(("radius", "decided"), [(1e-20, False), (1e-60, True)])
def test_what_cancelled_terms_may_be_counts_in_rounding(radius, decided):
    with ExponentialSumArithmetic(BITS) as ar:
        third, wave = ar.number("1/3"), ar.sin_cos(ar.time * 2)[1]
        small = uncertain(ar, radius)
        for column in (small * third, small + wave, wave * third + (small - 1)):
            _, _, sure = Table(ar, [column], ar.number("1/2")).pairs(1, 300)
            assert sure.all() if decided else not sure.any()


def test_terms_that_cancel_cost_nothing():
    """Of the 116 factors of attitude and velocities in both axes a third is left."""
    values = (6.28, 0.5, 0.17, 10.0, 100.0, 1.0, 0.0, 0.0, 0.0, 100.0, 0.0, 0.0)
    numbers = [ExactNumber(x) for x in values]
    motion = DualPrecession(*numbers[:5], None, tuple(numbers[9:]))
    with ExponentialSumArithmetic(BITS) as ar:
        columns = [x for part in solution(ar, motion, ar.time) for x in part]
        table = Table(ar, columns, ar.number("1/100"))
        assert sum(len(rows) for _, rows in table._products(0, 1)) < 40
    agree(lambda ar, time: [x for part in solution(ar, motion, time) for x in part], "1/100", 7, 900, {0, 899}, 1e-42)
