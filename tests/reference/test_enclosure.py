"""Proved integration: the enclosures contain exact solutions, are narrow, and a planted defect is caught."""

import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsref import enclosure
from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.enclosure import EnclosureError, enclosed_states
from sinsref.recorded import RecordedField, Recorder
from sinsref.series import SeriesArithmetic

deterministic = settings(derandomize=True, deadline=None, database=None, max_examples=25)
BITS = 256
#: Wide enough that a short series needs its remainder, narrow enough that a step has several terms.
LOOSE = {"order": 3, "tolerance": 1e-6}
SHARP = {"order": 40, "tolerance": 1e-50}


def oscillator(ar, state):
    return [state[1], -state[0]]


def logistic(ar, state):
    return [state[0] * (1 - state[0])]


def reciprocal(ar, state):
    return [-(state[0] * state[0])]


def tangent(ar, state):
    return [state[0] * state[0] + 1]


def elementary(ar, state):
    """Every operation that can be recorded: x = (t + 1, sqrt, log, sin, sinh, 1 / (t + 1)) of t + 1."""
    t = state[0]
    root, (sine, cosine), (sinh, cosh) = ar.sqrt(t), ar.sin_cos(t), ar.sinh_cosh(t)
    unit = sine * sine + cosine * cosine + (cosh * cosh - sinh * sinh) - ar.exp(-state[2]) * t
    return [ar.number(1), 1 / (2 * root), unit / t, cosine * unit, t / t * cosh, -1 / (t * t) - (t - 3 - (-3 + t)) / 7]


#: Field, initial state, interval, and the solution at a time.
PROBLEMS = {
    "oscillator": (oscillator, ["0.6", "0.8"], "1/3", lambda ar, t: rotated(ar, t)),
    "logistic": (logistic, ["0.2"], "1/4", lambda ar, t: [1 / (1 + 4 * ar.exp(-t))]),
    "reciprocal": (reciprocal, ["2"], "1/2", lambda ar, t: [2 / (1 + 2 * t)]),
    "tangent": (tangent, ["0"], "0.1", lambda ar, t: [quotient(ar.sin_cos(t))]),
    "elementary": (
        elementary,
        ["1", "1", "0", "sin(1)", None, "1"],
        "1/4",
        lambda ar, t: [
            1 + t, ar.sqrt(1 + t), (1 + t).log(), ar.sin_cos(1 + t)[0], ar.sinh_cosh(1 + t)[0], 1 / (1 + t),
        ],
    ),
}  # fmt: skip


def rotated(ar, t):
    sine, cosine = ar.sin_cos(t)
    return [(3 * cosine + 4 * sine) / 5, (4 * cosine - 3 * sine) / 5]


def quotient(pair):
    return pair[0] / pair[1]


def solved(problem, count=8, **setting):
    """Balls of the solution, and the exact solution in balls far narrower, epoch by epoch."""
    field, initial, interval, exact = PROBLEMS[problem]
    with BallArithmetic(2 * BITS) as ar:
        truth = [exact(ar, ar.number(interval) * k) for k in range(count + 1)]
    with BallArithmetic(BITS) as ar:
        start = [ar.sinh_cosh(ar.number(1))[0] if x is None else ar.number(x) for x in initial]
        return list(enclosed_states(ar, field, start, ar.number(interval), count, **setting)), truth


def contained(found, truth):
    return all(x.contains(y) for xs, ys in zip(found, truth, strict=True) for x, y in zip(xs, ys, strict=True))


def width(states):
    return max(float(x.rad()) for state in states for x in state)


@pytest.mark.parametrize("setting", [LOOSE, SHARP], ids=["loose", "sharp"])
@pytest.mark.parametrize("problem", PROBLEMS)
def test_enclosures_contain_the_exact_solution(problem, setting):
    found, truth = solved(problem, **setting)
    with BallArithmetic(2 * BITS):
        assert contained(found, truth)
        # Widths are sums of remainders, relative 1e-6 or 1e-50 a step, amplified by at most the growth of a solution.
        assert width(found) < 1e4 * setting["tolerance"]


@deterministic
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.01, 3), st.integers(2, 30), st.floats(1e-12, 1e-2))
def test_enclosures_contain_the_oscillation_whatever_order_and_tolerance(x, v, interval, order, tolerance):
    with BallArithmetic(BITS) as ar:
        states = list(
            enclosed_states(ar, oscillator, [arb(x), arb(v)], arb(interval), 4, order=order, tolerance=tolerance)
        )
        for k, (found, rate) in enumerate(states):
            sine, cosine = ar.sin_cos(arb(interval) * k)
            assert found.overlaps(x * cosine + v * sine)
            assert rate.overlaps(v * cosine - x * sine)
            # The energy is constant: a ball that misses the solution misses it too.
            assert (found * found + rate * rate).overlaps(arb(x) ** 2 + arb(v) ** 2)


@deterministic
@given(st.floats(0.01, 0.99), st.floats(1e-10, 1e-3))
def test_a_wide_start_gives_a_box_that_holds_every_solution_through_it(value, radius):
    with BallArithmetic(BITS) as ar:
        *_, (last,) = enclosed_states(ar, logistic, [arb(value, radius)], arb(0.5), 6, **LOOSE)
        for start in (value - radius, value, value + radius):
            inside = arb(start)
            # Rounding of value +- radius may leave the ball by an ulp: the box must hold what is in it.
            if arb(value, radius).contains(inside):
                assert last.contains(inside / (inside + (1 - inside) * ar.exp(ar.number(-3))))


def test_exact_zeros_stay_exact():
    with BallArithmetic(BITS) as ar:

        def field(series, state):
            return [state[0] * state[1], state[0], series.number(0)]

        for state in enclosed_states(ar, field, [arb(0), arb(2), arb(3)], arb(1), 3, **SHARP):
            assert [x.is_exact() for x in state] == [True] * 3
            assert [float(x) for x in state] == [0, 2, 3]


def test_a_solution_that_ceases_to_exist_is_refused():
    """tan(t) has a pole at pi/2: it is enclosed at 1.5, and nothing is claimed beyond the pole."""
    with BallArithmetic(BITS) as ar:
        states = enclosed_states(ar, tangent, [arb(0)], ar.number("0.1"), 16, **SHARP)
        found = [next(states) for _ in range(16)]
        assert found[15][0].contains(quotient(ar.sin_cos(ar.number("1.5"))))
        with pytest.raises(EnclosureError, match=r"beyond 1\.5[67]"):
            list(states)


@pytest.mark.parametrize("problem", ["oscillator", "logistic", "reciprocal", "tangent"])
def test_a_remainder_of_zero_is_caught(problem, monkeypatch):
    monkeypatch.setattr(enclosure, "_remainder", lambda field, state, step, order: [arb(0)] * len(state))
    found, truth = solved(problem, **LOOSE)
    with BallArithmetic(2 * BITS):
        assert not contained(found, truth)


@pytest.mark.parametrize("problem", ["oscillator", "logistic", "reciprocal", "tangent"])
def test_a_remainder_taken_at_the_start_alone_is_caught(problem, monkeypatch):
    """Without the a-priori enclosure the remainder is that of one point, not of the step."""
    monkeypatch.setattr(enclosure, "enclosure", lambda field, state, step: list(state))
    found, truth = solved(problem, **LOOSE)
    with BallArithmetic(2 * BITS):
        assert not contained(found, truth)


def test_a_box_that_picard_does_not_confirm_is_none():
    with BallArithmetic(BITS) as ar:
        field = RecordedField(ar, tangent, 1)
        assert enclosure.enclosure(field, [arb(0)], arb(2)) is None  # the solution does not exist up to 2
        (box,) = enclosure.enclosure(field, [arb(0)], arb("0.25"))
        assert box.contains(0)
        assert box.contains(quotient(ar.sin_cos(arb("0.25"))))
        assert box.contains(quotient(ar.sin_cos(arb("0.125"))))


@pytest.mark.parametrize("name", ["sqrt", "exp"])
def test_a_recorded_constant_stays_a_number(name):
    with BallArithmetic(BITS) as ar:
        assert getattr(Recorder(ar), name)(arb(2)).overlaps(getattr(ar, name)(arb(2)))


def test_recorded_coefficients_are_those_of_the_lazy_series():
    """Two implementations of the recurrences, in mpmath: every operation, 12 orders."""
    ar = MpArithmetic(50)
    start = [ar.number(x) for x in ("1.3", "1.1", "0.2", "0.7", "1.4", "0.9")]
    recorded = RecordedField(ar, elementary, 6).coefficients(start, 12)
    series = SeriesArithmetic(ar)
    unknowns = [series.unknown(x) for x in start]
    for unknown, rate in zip(unknowns, elementary(series, unknowns), strict=True):
        series.define(unknown, rate)
    for found, expected in zip(recorded, unknowns, strict=True):
        assert all(abs(x - expected[k]) < 1e-45 * (1 + abs(x)) for k, x in enumerate(found))


def test_what_is_not_known_yet_is_not_decided():
    with BallArithmetic(BITS) as ar:
        recorder = Recorder(ar)
        x = recorder.variable()
        assert (recorder.sign(x), recorder.magnitude(x)) == (0, float("inf"))
        assert (recorder.sign(arb(-2)), recorder.magnitude(arb(-2)) >= 2) == (-1, True)
        assert recorder.resolution == ar.resolution
        assert recorder.pi.overlaps(ar.pi)
        with pytest.raises(TypeError, match="cannot be widened"):
            recorder.widen(x, arb(1))
