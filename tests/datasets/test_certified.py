"""The certified tables: correct rounding against mpmath, exact zeros, and independence of how a table is cut."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import sinsdata.truth.certified
import sinsref.exponential_sums
from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.truth.certified import Block, blocks
from sinsdata.truth.formulas import (
    TRANSITION_ELEMENTS,
    WORKING_BITS,
    equator_bits,
    equator_blocks,
    equator_modes,
    equator_state,
    increment_blocks,
    precession_blocks,
    transition_formula,
)
from sinsref.arithmetic import Arithmetic, MpArithmetic, Number
from sinsref.equator import EquatorModel, transition
from sinsref.equator_modes import modes
from sinsref.exact import ExactNumber
from sinsref.precession import increments, solution
from sinsref.rounding import RoundingTally

EXAMPLES = settings(derandomize=True, deadline=None, max_examples=25)

#: What a pair promises: the value within 1e-30, relatively.
PAIR = 1e-30
# mpmath at 80 digits leaves this, relative to the largest value of a row, where the exact value is 0: 80 digits less
# those that the growth of the errors (e^12 here) and phases of 1000 rad cost twice.
NOISE = 1e-60


def _floats(bound: float) -> st.SearchStrategy[float]:
    """Numbers that a case admits: 0, or not too small.

    With generic mantissas: a short one can put an irrational-looking value exactly half-way between two binary64,
    which no ball decides.
    """
    return st.floats(-bound, bound).map(lambda x: x * 0.8414709848078965 if abs(x) > 1e-20 else 0.0)


_speeds = _floats(9000) | st.sampled_from([0, 7446, "7446.951262516", "-7.29e-5*6378245", 600, "-8376.9"])
_angles = _floats(4) | st.sampled_from(["pi/18", "pi/2", "pi", "pi/3"])
_intervals = st.sampled_from(["1/100", "1/8", "0.01"]) | st.floats(1e-4, 1)


def _vectors(length: int) -> st.SearchStrategy[list[float]]:
    return st.lists(_floats(1), min_size=length, max_size=length)


_equator_cases = st.builds(
    lambda interval, **given: EquatorCase.from_mapping(
        {"name": "any", "interval": interval, "duration": interval * 40, **given}
    ),
    interval=st.floats(0.001, 150),
    v_east=_speeds,
    height=_floats(1e5),
    initial_errors=_vectors(6),
    misalignment=st.none() | st.lists(_vectors(3), min_size=3, max_size=3),
    inertial_longitude=_angles,
)
_precession_cases = st.builds(
    lambda interval, **given: DualPrecessionCase.from_mapping(
        {"name": "any", "interval": interval, "duration": f"({ExactNumber(interval).text})*40", **given}
    ),
    interval=_intervals,
    spin_rate=st.sampled_from(["2*pi", "-pi", 1]) | st.floats(0.01, 30),
    precession_ratio=st.sampled_from([-1, 1, 0, "1/2", "-1/3"]) | st.floats(0.01, 3),
    nutation=_angles,
    spin_rate_dual=_floats(1),
    nutation_dual=_floats(1),
    initial_velocity=_vectors(3),
    initial_attitude=st.sampled_from([None, (1, 0, 0, 0), (0, 0, 0, -1), (0.6, 0, 0.8, 0), ("1/3", "2/3", "-2/3", 0)]),
)


def _whole(parts: Iterator[Block]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return high and low parts, time first."""
    columns = [(np.column_stack([p.time, p.high]), np.column_stack([p.time_lo, p.low])) for p in parts]
    return np.concatenate([high for high, _ in columns]), np.concatenate([low for _, low in columns])


def _assert_certified(high: NDArray[np.float64], low: NDArray[np.float64], exact: list[Number]) -> None:
    """Check one row: x is the binary64 nearest to the value, x_lo the rest, together within 1e-30."""
    largest = max(abs(value) for value in exact)
    for x, x_lo, value in zip(high.tolist(), low.tolist(), exact, strict=True):
        if abs(value) <= NOISE * largest:
            assert (x, x_lo) == (0, 0)
            continue
        error = abs(value - x)
        assert all(error <= abs(value - math.nextafter(x, side)) for side in (-math.inf, math.inf))
        assert abs(value - x - x_lo) <= PAIR * abs(value)


def transition_blocks(case: EquatorCase, tally: RoundingTally) -> Iterator[Block]:
    return blocks(transition_formula(case), case.interval, 0, case.samples + 1, equator_bits(case), tally)


Table: TypeAlias = tuple[
    Callable[[Any, RoundingTally], Iterator[Block]], Callable[[Any, Arithmetic, int], list[Number]], int
]


def _truth_row(case: DualPrecessionCase, ar: Arithmetic, index: int) -> list[Number]:
    time = ar.number(case.interval) * index
    attitude, inertial, body = solution(ar, case.motion, time)
    return [time, *attitude, *inertial, *body]


def _increment_row(case: DualPrecessionCase, ar: Arithmetic, index: int) -> list[Number]:
    step = ar.number(case.interval)
    angle, velocity = increments(ar, case.motion, step * index, step)
    return [step * index, *angle, *velocity]


def _state_row(case: EquatorCase, ar: Arithmetic, index: int) -> list[Number]:
    time = ar.number(case.interval) * index
    return [time, *equator_state(case)(ar, time)]


def _transition_row(case: EquatorCase, ar: Arithmetic, index: int) -> list[Number]:
    time = ar.number(case.interval) * index
    matrix = transition(ar, EquatorModel.at(ar, case.v_east, case.height), time)
    return [time, *(matrix[i - 1][j - 1] for i, j in TRANSITION_ELEMENTS)]


PRECESSION_TABLES: list[Table] = [(precession_blocks, _truth_row, 0), (increment_blocks, _increment_row, 1)]
EQUATOR_TABLES: list[Table] = [(equator_blocks, _state_row, 0), (transition_blocks, _transition_row, 0)]


def _compare_with_mpmath(case: Case, tables: list[Table], row: int) -> None:
    ar = MpArithmetic(80)
    for blocks_of, formula, first in tables:
        high, low = _whole(blocks_of(case, RoundingTally()))
        assert len(high) == case.samples + 1 - first
        for place in {0, min(row, len(high) - 1), len(high) - 1}:
            _assert_certified(high[place], low[place], formula(case, ar, place + first))


@EXAMPLES
@given(case=_precession_cases, row=st.integers(0, 40))
def test_precession_is_rounded_correctly(case: DualPrecessionCase, row: int) -> None:
    _compare_with_mpmath(case, PRECESSION_TABLES, row)


@EXAMPLES
@given(case=_equator_cases, row=st.integers(0, 40))
def test_equator_is_rounded_correctly(case: EquatorCase, row: int) -> None:
    _compare_with_mpmath(case, EQUATOR_TABLES, row)


def test_modes_are_rounded_correctly(mapping: Any) -> None:
    case = EquatorCase.from_mapping(mapping("equator_errors"))
    ar = MpArithmetic(80)
    exact = modes(ar, EquatorModel.at(ar, case.v_east, case.height))
    for name, pair in equator_modes(case, RoundingTally()).items():
        assert pair is not None
        _assert_certified(np.array(pair[:1]), np.array(pair[1:]), [getattr(exact, name)])


@pytest.mark.parametrize("v_east", [7500, -8400, 9000, "-7.29e-5*6383245"])
def test_there_are_no_modes_beyond_the_limits_and_at_rest_in_inertial_space(mapping: Any, v_east: Any) -> None:
    case = EquatorCase.from_mapping(mapping("equator_errors", v_east=v_east))
    assert set(equator_modes(case, RoundingTally()).values()) == {None}


def _bytes(parts: Iterator[Block]) -> tuple[bytes, bytes]:
    high, low = _whole(parts)
    return high.tobytes(), low.tobytes()


Tables: TypeAlias = list[tuple[Callable[[Any, RoundingTally], Iterator[Block]], Case]]


@pytest.fixture(scope="module")
def tables(mapping: Any) -> Tables:
    """Sums of exponentials with powers of time, hyperbolic functions, and a table that no such sum describes."""
    precession = DualPrecessionCase.from_mapping(mapping("dual_precession", duration=30))
    turned = DualPrecessionCase.from_mapping(mapping("dual_precession", duration=30, initial_attitude=[0.6, 0, 0.8, 0]))
    equator = EquatorCase.from_mapping(mapping("equator_errors", interval=2))
    tilted = EquatorCase.from_mapping(mapping("equator_errors", misalignment=[[1e-6, 2e-6, 0]] * 3, interval=30))
    return [
        (precession_blocks, precession),
        (precession_blocks, turned),
        (increment_blocks, precession),
        (equator_blocks, equator),
        (transition_blocks, equator),
        (equator_blocks, tilted),
    ]


@pytest.fixture(scope="module")
def expected(tables: Tables) -> list[tuple[bytes, bytes]]:
    return [_bytes(blocks_of(case, RoundingTally())) for blocks_of, case in tables]


@pytest.mark.parametrize(("block", "fine"), [(7, 2), (40, 256), (64, 5), (65536, 1), (300, 1000)])
def test_values_do_not_depend_on_how_a_table_is_cut(
    tables: Tables, expected: list[tuple[bytes, bytes]], monkeypatch: pytest.MonkeyPatch, block: int, fine: int
) -> None:
    monkeypatch.setattr(sinsdata.truth.certified, "BLOCK", block)
    monkeypatch.setattr(sinsref.exponential_sums, "FINE", fine)
    assert [_bytes(blocks_of(case, RoundingTally())) for blocks_of, case in tables] == expected


def test_products_of_matrices_and_single_epochs_give_the_same_pairs(
    tables: Tables, expected: list[tuple[bytes, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sinsdata.truth.certified, "_table", lambda *_: None)
    assert [_bytes(blocks_of(case, RoundingTally())) for blocks_of, case in tables] == expected


def test_only_the_misaligned_table_is_no_sum_of_exponentials(mapping: Any) -> None:
    """Otherwise the comparison above would compare one path with itself."""
    equator = EquatorCase.from_mapping(mapping("equator_errors"))
    tilted = EquatorCase.from_mapping(mapping("equator_errors", misalignment=[[1e-6, 2e-6, 0]] * 3))
    assert sinsdata.truth.certified._table(equator_state(equator), equator.interval, WORKING_BITS, 9) is not None
    assert sinsdata.truth.certified._table(equator_state(tilted), tilted.interval, WORKING_BITS, 9) is None


@pytest.mark.parametrize(("first", "count"), [(0, 601), (1, 600), (255, 3), (256, 1), (599, 2), (123, 456)])
def test_values_do_not_depend_on_where_a_table_starts(mapping: Any, first: int, count: int) -> None:
    case = DualPrecessionCase.from_mapping(mapping("dual_precession", duration=60))

    def formula(ar: Arithmetic, time: Number) -> list[Number]:
        attitude, inertial, body = solution(ar, case.motion, time)
        return [*attitude, *inertial, *body]

    high, low = _whole(precession_blocks(case, RoundingTally()))
    part = list(blocks(formula, case.interval, first, count, WORKING_BITS, RoundingTally()))
    assert np.concatenate([block.index for block in part]).tolist() == list(range(first, first + count))
    assert _bytes(iter(part)) == (high[first : first + count].tobytes(), low[first : first + count].tobytes())


def test_exact_zeros_are_zero_and_counted(mapping: Any) -> None:
    """Spin one turn a second, eighths of a second: zeros at known epochs, and nowhere else."""
    case = DualPrecessionCase.from_mapping(
        mapping(
            "dual_precession",
            spin_rate="2*pi",
            precession_ratio=-1,
            nutation="pi/3",
            initial_velocity=[0, 0, 0],
            nutation_dual=1,
            spin_rate_dual=0,
            interval="1/8",
            duration=1,
        )
    )
    tally = RoundingTally()
    high, low = _whole(precession_blocks(case, tally))
    eighths = np.arange(9)
    # Lebedev, Panov 1989, (4.4), (4.7): Q = {c, s cos 2 pi t, -s sin 2 pi t, 0}, W_I = (cos 2 pi t - 1, -sin 2 pi t, 0)
    cosine, sine = eighths % 4 == 2, eighths % 4 == 0
    zero = np.zeros((9, 8), dtype=bool)
    zero[:, 0] = eighths == 0  # time
    zero[:, 2], zero[:, 3], zero[:, 4] = cosine, sine, True
    zero[:, 5], zero[:, 6], zero[:, 7] = eighths % 8 == 0, sine, True
    assert np.array_equal((high[:, :8] == 0) & (low[:, :8] == 0), zero)
    assert np.array_equal(high[:, :8] == 0, zero)
    assert tally.values == high.size
    # Columns that are zero throughout are known before any epoch is computed; so is time 0.
    assert tally.exact_zeros >= zero.sum() - 9 - 9 - 1
    # In W_E = conj(Q) o W_I o Q products of sin(pi/6) and cos(pi/6) cancel: proved small, not known to be zero.
    # So is, at once, a column without a value that is not zero.
    throughout = (high == 0).all(axis=0).sum() * len(high)
    assert tally.bounded_zeros <= (high[:, 8:] == 0).sum() + throughout
    assert tally.bounded_zeros + tally.exact_zeros <= (high == 0).sum()


def test_channels_that_are_not_excited_are_exactly_zero(mapping: Any) -> None:
    case = EquatorCase.from_mapping(mapping("equator_errors", initial_errors=[0, 0, 0, 1, 0, 0]))
    high, low = _whole(equator_blocks(case, RoundingTally()))
    for column in (1, 5):  # north velocity and latitude
        assert not high[:, column].any()
        assert not low[:, column].any()
    assert (high[1:, [2, 3, 4, 6]] != 0).all()


def test_no_zero_is_negative(tables: Tables) -> None:
    """-0.0 and 0.0 are the same number and different bytes: the content hash needs one of them."""
    for blocks_of, case in tables:
        for part in _whole(blocks_of(case, RoundingTally())):
            assert not np.signbit(part[part == 0]).any()


def test_a_column_of_zeros_is_proved_once(mapping: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a dual part of the spin rate nothing moves along the axis of precession, which no ball knows."""
    still = {"spin_rate_dual": 0, "initial_velocity": [100, 0, 0]}
    case = DualPrecessionCase.from_mapping(mapping("dual_precession", **still, interval="1/16", duration=2))
    tallies = RoundingTally(), RoundingTally()
    at_once = _bytes(precession_blocks(case, tallies[0]))
    monkeypatch.setattr(sinsdata.truth.certified, "_negligible_columns", lambda *_: np.zeros(11, np.bool_))
    assert _bytes(precession_blocks(case, tallies[1])) == at_once
    assert tallies[0].raised == tallies[1].raised
    # Row by row the zero of the first epoch is known exactly.
    assert [tally.bounded_zeros + tally.exact_zeros for tally in tallies] == [tallies[0].raised] * 2
    assert tallies[0].bounded_zeros >= case.samples + 1


def test_a_tiny_column_is_not_taken_for_zero(mapping: Any) -> None:
    """Three times sqrt(2), less sqrt(18), is zero; with 1e-299 added to one of them it is not."""
    case = DualPrecessionCase.from_mapping(mapping("dual_precession"))

    def formula(ar: Arithmetic, time: Number) -> list[Number]:
        zero = ar.sqrt(ar.number(2)) * 3 - ar.sqrt(ar.number(18))
        turn = ar.sin_cos(time)[1]
        return [zero * turn, zero * turn + ar.number("1e-299") * turn, (zero + ar.number("1e-900")) * turn]

    (block,) = blocks(formula, case.interval, 0, 5, WORKING_BITS, RoundingTally())
    cosine = np.cos(block.time)
    assert not block.high[:, [0, 2]].any()
    np.testing.assert_allclose(block.high[:, 1], 1e-299 * cosine, rtol=1e-15)
