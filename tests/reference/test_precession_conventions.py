"""Other forms of the inputs of one motion: integrals, means, and increments resolved in a frame that does not turn."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.exact import ExactNumber
from sinsref.exponential_sums import ExponentialSumArithmetic, Table
from sinsref.precession import (
    DualPrecession,
    accumulated,
    angular_rate_and_specific_force,
    body_rotation,
    increments,
    mean_rates,
    resolved_increments,
    solution,
)
from sinsref.quaternion import conjugate, product, rotate
from sinsref.series import SeriesArithmetic

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=30)
few = settings(derandomize=True, deadline=None, database=None, max_examples=6)
AR = MpArithmetic(60)
velocities = st.floats(-100, 100)


@st.composite
def motions(draw):
    ratio = draw(st.one_of(st.sampled_from([0.0, 1.0, -1.0, 1e-12]), st.floats(-2, 2)))
    nutation = draw(st.one_of(st.sampled_from(["0", "pi", "pi/2", "1e-20", "pi - 1e-15"]), st.floats(1e-6, 3.1)))
    attitude = tuple(draw(st.floats(low, 1)) for low in (0.1, -1, -1, -1))
    return DualPrecession(
        *(ExactNumber(x) for x in (draw(st.floats(0.1, 7)), ratio, nutation, draw(velocities), draw(velocities))),
        tuple(map(ExactNumber, attitude)),
        tuple(ExactNumber(draw(velocities)) for _ in range(3)),
    )


PAPER = DualPrecession(
    *map(ExactNumber, ("2*pi", "1/2", "pi/18", "10", "100")),
    tuple(map(ExactNumber, "1000")),
    tuple(map(ExactNumber, ("20", "35", "40"))),
)
times, intervals = st.floats(-50, 100).map(AR.number), st.floats(1e-3, 1).map(AR.number)


def near(a, b, tolerance="1e-45"):
    """Within the tolerance of the largest component, and of 1."""
    scale = max([1, *(abs(x) for x in (*a, *b))])
    return all(abs(x - y) <= AR.number(tolerance) * scale for x, y in zip(a, b, strict=True))


def minus(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


@deterministic
@given(motions(), times, intervals)
@example(PAPER, AR.number(100), AR.number("0.01"))
def test_increments_are_differences_of_integrals_and_multiples_of_means(motion, t, h):
    before, after = accumulated(AR, motion, t - h), accumulated(AR, motion, t)
    means = mean_rates(AR, motion, t, h)
    for part, increment in enumerate(increments(AR, motion, t, h)):
        assert near(minus(after[part], before[part]), increment)
        assert near([x * h for x in means[part]], increment)


@deterministic
@given(motions(), times)
def test_the_integrals_start_from_zero_and_have_the_rates_as_derivative(motion, t):
    angle, velocity = accumulated(AR, motion, AR.number(0))
    assert near([*angle, *velocity], [0] * 6, "1e-57")
    series = SeriesArithmetic(AR)
    integrals = accumulated(series, motion, series.variable(t))
    for integral, rate in zip(integrals, angular_rate_and_specific_force(AR, motion, t), strict=True):
        assert near([x[1] for x in integral], rate)


@deterministic
@given(motions(), times, intervals)
@example(PAPER, AR.number(100), AR.number("0.01"))
def test_resolved_increments_are_the_change_of_the_inertial_velocity(motion, t, h):
    (before, w_before, _), (after, w_after, _) = (solution(AR, motion, x) for x in (t - h, t))
    change = minus(w_after, w_before)
    start, end = resolved_increments(AR, motion, t, h)
    assert near(rotate(before, start), change)
    assert near(rotate(after, end), change)
    turn = body_rotation(AR, motion.principal(AR), t, h)
    assert near(turn, product(conjugate(before), after))
    assert near(rotate(turn, end), start)


@deterministic
@given(motions(), st.integers(1, 12))
def test_resolved_increments_add_up_along_the_motion(motion, samples):
    h = AR.number("0.3")
    total = [AR.number(x) for x in motion.initial_velocity]
    for k in range(samples):
        start, _ = resolved_increments(AR, motion, h * (k + 1), h)
        gain = rotate(solution(AR, motion, h * k)[0], start)
        total = [x + y for x, y in zip(total, gain, strict=True)]
    assert near(total, solution(AR, motion, h * samples)[1])


@few
@given(motions(), st.floats(-20, 20), st.floats(0.01, 0.5))
def test_resolved_increments_are_integrals_of_the_turned_force(motion, t, h):
    start, end = AR.number(t), AR.number(t) + AR.number(h)
    frames = [conjugate(solution(AR, motion, x)[0]) for x in (start, end)]

    def force(tau, frame):
        attitude, _, _ = solution(AR, motion, tau)
        return rotate(product(frame, attitude), angular_rate_and_specific_force(AR, motion, tau)[1])

    for frame, resolved in zip(frames, resolved_increments(AR, motion, end, end - start), strict=True):
        integral = [AR.context.quad(lambda tau, i=i, f=frame: force(tau, f)[i], [start, end]) for i in range(3)]
        assert near(integral, resolved)


@pytest.mark.parametrize("values", [angular_rate_and_specific_force, accumulated, mean_rates, resolved_increments])
def test_tables_of_exponential_sums_hold_the_same_values(values):
    """Time as a symbol gives what numbers of time give."""

    def row(ar, time, h):
        extra = (h,) if values in (mean_rates, resolved_increments) else ()
        first, second = values(ar, PAPER, time, *extra)
        return [*first, *second]

    with ExponentialSumArithmetic(192) as symbolic:
        h = symbolic.number("0.01")
        table = Table(symbolic, row(symbolic, symbolic.time, h), h).balls(9990, 11)
    with BallArithmetic(256) as balls:
        h = balls.number("0.01")
        for k in range(11):
            expected = row(balls, h * (9990 + k), h)
            for column, value in zip(table, expected, strict=True):
                assert column[k].overlaps(value)
                assert float(column[k].rad()) < 1e-45 * (1 + float(abs(value)))
