"""Attitudes and sums over long grids of binary64, and functions of time on them."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from flint import arb
from numpy.typing import NDArray

from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.mast_functions import GridFunction, Rows, antiderivative, derivative
from sinsref.mast_running import (
    CHUNK,
    LARGEST_ROTATION,
    NODES,
    RunningProduct,
    RunningSum,
    composed,
    magnus_rotation,
    small_rotation,
    step_rotation,
)
from sinsref.profiles import Profile
from sinsref.quaternion import product
from sinsref.series import Series, SeriesArithmetic
from sinsref.taylor import integrate

_AR = MpArithmetic(40)
_MP = _AR.context
_RANDOM = np.random.default_rng(7)


def _exponential(vector: list[mpmath.mpf]) -> list[mpmath.mpf]:
    angle = _MP.sqrt(sum(x * x for x in vector))
    return [_MP.cos(angle / 2), *(x * _MP.sin(angle / 2) / angle for x in vector)]


def test_small_rotations_are_those_of_the_exponential() -> None:
    """Relative to the rotation: this is what keeps long products exact."""
    for size in (1e-9, 1e-4, 1e-2, LARGEST_ROTATION):
        vector = [size * x for x in (0.48, -0.6, 0.64)]
        found = small_rotation([np.array([x]) for x in vector])
        exact = _exponential([_MP.mpf(x) for x in vector])
        assert float(abs(_MP.mpf(found[0][0]) - (exact[0] - 1))) < 1e-15 * size**2
        for x, y in zip(found[1:], exact[1:], strict=True):
            assert float(abs(_MP.mpf(x[0]) - y)) < 3e-16 * size


def test_composition_of_small_rotations() -> None:
    a, b = ([np.array([x]) for x in vector] for vector in ([1e-3, 2e-3, -1e-3], [-3e-3, 1e-3, 2e-3]))
    found = composed(small_rotation(a), small_rotation(b))
    exact = product(*(_exponential([_MP.mpf(float(x[0])) for x in vector]) for vector in (a, b)))
    for x, y, whole in zip(found, exact, (1, 0, 0, 0), strict=True):
        assert float(abs(_MP.mpf(x[0]) + whole - y)) < 1e-18


def _turn(profiles: list[Profile], begin: str, end: str) -> list[mpmath.mpf]:
    """Return the quaternion of the turn between two times by a Taylor series of high order."""

    def field(series: SeriesArithmetic, time: Series, state: list[Series]) -> list[Series]:
        rates = [profile.terms(series).jet(series, time)[0] for profile in profiles]
        return [x / 2 for x in product(state, [time * 0, *rates])]

    one = [_AR.number(x) for x in (1, 0, 0, 0)]
    return integrate(_AR, field, one, _AR.number(begin), _AR.number(end), steps=4, order=24)


_PROFILES = [Profile("0.1*cos(3*t)"), Profile("0.5 + 0.2*sin(4*t)"), Profile("0.3*cos(7*t + 1)")]


def _magnus_error(step: str, parts: int) -> float:
    """Return the largest error of the turn of one step from 0.2 s on."""
    end = f"0.2 + {step}"
    rates = []
    with BallArithmetic(192) as balls:
        for part in range(parts):
            for node in NODES:
                time = balls.number(f"0.2 + {step}/{parts}*({part} + {node})")
                values = [profile.terms(balls).jet(balls, time)[0] for profile in _PROFILES]
                rates.append([np.array([float(x.mid())]) for x in values])
    found = step_rotation(rates, float(_AR.number(step)), parts)
    exact = _turn(_PROFILES, "0.2", end)
    return max(float(abs(_MP.mpf(x[0]) + whole - y)) for x, y, whole in zip(found, exact, (1, 0, 0, 0), strict=True))


def test_the_expansion_is_of_sixth_order() -> None:
    """An error of a step of seventh power: halved steps leave 1/128 of it, in two parts 1/64."""
    coarse, fine, halved = _magnus_error("0.2", 1), _magnus_error("0.1", 1), _magnus_error("0.2", 2)
    assert 80 < coarse / fine < 200
    assert 40 < coarse / halved < 100


def test_a_step_of_the_usual_length_is_exact_to_its_last_place() -> None:
    # The turn is of 3e-3 rad, so a unit in its last place is 4e-19; truncation is below 1e-20.
    assert _magnus_error("0.005", 2) < 1e-18


def test_a_constant_rate_turns_about_its_axis() -> None:
    rate = [np.array([x]) for x in (0.3, -0.2, 0.1)]
    assert [float(x[0]) for x in magnus_rotation([rate, rate, rate], 0.01)] == pytest.approx(
        [0.003, -0.002, 0.001], abs=1e-18
    )


@pytest.mark.parametrize("blocks", [(1000,), (CHUNK, CHUNK, 488), (2 * CHUNK, 488)])
def test_running_products_keep_their_digits(blocks: tuple[int, ...]) -> None:
    """A thousand steps of 1e-3 rad against mpmath: no error that grows with their number."""
    vectors = 1e-3 * _RANDOM.standard_normal((2, 3, 1000))
    steps = [small_rotation(list(vector)) for vector in vectors]
    starts = [[0.8, 0.0, 0.6, 0.0], [1.0, 0.0, 0.0, 0.0]]
    running = RunningProduct(starts, [[0.0] * 4] * 2)
    found: list[list[NDArray[np.float64]]] = [[], []]
    begin = 0
    for count in blocks:
        parts = running.advance([[x[begin : begin + count] for x in step] for step in steps])
        begin += count
        for rows, part in zip(found, parts, strict=True):
            values = np.array(part).T
            if rows:
                # The row between two blocks is the same in both.
                assert np.array_equal(rows[-1][-1], values[0])
            rows.append(values)
    for place, start in enumerate(starts):
        q = [_MP.mpf(x) for x in start]
        for n in range(1000):
            q = product(q, [_MP.mpf(float(x[n])) + whole for x, whole in zip(steps[place], (1, 0, 0, 0), strict=True)])
        assert max(float(abs(x - float(y))) for x, y in zip(q, found[place][-1][-1], strict=True)) < 4e-16


def test_rows_do_not_depend_on_how_many_follow() -> None:
    steps = [small_rotation(list(1e-3 * _RANDOM.standard_normal((3, 700))))]
    start = ([[1.0, 0.0, 0.0, 0.0]], [[0.0] * 4])
    (whole,) = RunningProduct(*start).advance(steps)
    for count in (1, 10, CHUNK - 1, CHUNK, CHUNK + 1, 600):
        (part,) = RunningProduct(*start).advance([[x[:count] for x in steps[0]]])
        assert all(np.array_equal(x[: count + 1], y) for x, y in zip(whole, part, strict=True))


def test_running_sums_are_exact() -> None:
    steps = 1e-7 * _RANDOM.standard_normal(5000)
    running = RunningSum(0.7, 3e-17)
    high, low = running.advance(steps[:3000])
    more, rest = running.advance(steps[3000:])
    assert (high[-1], low[-1]) == (more[0], rest[0])
    exact = Fraction(0.7) + Fraction(3e-17) + sum(map(Fraction, steps.tolist()))
    assert abs(Fraction(float(more[-1])) + Fraction(float(rest[-1])) - exact) < Fraction(1, 10**29)
    assert abs(rest[-1]) <= np.spacing(more[-1]) / 2


# Functions of time.

#: Functions, and the largest of their terms beside powers of time.
_FUNCTIONS = (("0.43*cos(2.45*t)", 1), ("100 + sin(0.02*t) - 3*cos(7*t + 1)", 100), ("0.1*t*t - t + 2", 2), ("7", 7))


@pytest.mark.parametrize(("text", "largest"), _FUNCTIONS)
@pytest.mark.parametrize("first", [0, 10**8])
def test_functions_of_time_are_good_after_days(text: str, largest: float, first: int) -> None:
    """A row 5.8 days from the start is as good as the first: its phase is kept in whole units."""
    with BallArithmetic(192) as balls:
        spacing, shift = balls.number("0.005"), balls.number("0.002")
        terms = Profile(text).terms(balls)
        sums = {"value": terms, "slope": derivative(terms), "integral": antiderivative(terms)}
        for name, known in sums.items():
            for moved in (None, shift):
                function = GridFunction.of(balls, known, spacing, moved)
                for row, value in zip(range(first, first + 3), function.values(Rows(first, 3, 0.005)), strict=True):
                    time = spacing * row + (arb(0) if moved is None else moved)
                    exact = (
                        terms.integral(balls, time) if name == "integral" else terms.jet(balls, time)[name == "slope"]
                    )
                    # Powers of time are evaluated at the binary64 nearest to it; phases are not.
                    size = max(largest, float(time) ** 2 if "t*t" in text else 0.0)
                    size *= max(1.0, float(time)) if name == "integral" else 1.0
                    assert abs(float(exact - arb(float(value)))) < 2e-15 * size, (name, row)
