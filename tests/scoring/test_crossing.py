"""Where errors fall below a level for good: interpolation, extrapolation, and reasons for neither."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.scoring.crossing import crossing, interpolated

INTERVALS = [0.02 / 2**k for k in range(6)]


@given(st.floats(0.5, 10), st.floats(0.02 / 31, 0.0199), st.floats(1e-6, 1e3))
@settings(derandomize=True, deadline=None)
def test_on_a_power_law_the_crossing_is_exact(order, interval, level):
    errors = [level * (h / interval) ** order for h in INTERVALS]
    found = crossing(INTERVALS, errors, level)
    assert found.note == ""
    assert found.interval == pytest.approx(interval, rel=1e-9)


@given(st.lists(st.floats(1e-12, 1e3), min_size=6, max_size=6), st.floats(1e-9, 1e2))
@settings(derandomize=True, deadline=None)
def test_every_finer_interval_is_below_the_level(errors, level):
    found = crossing(INTERVALS, errors, level)
    if found.interval is not None:
        assert all(e <= level for h, e in zip(INTERVALS, errors, strict=True) if h <= found.interval)
        coarser = [e for h, e in zip(INTERVALS, errors, strict=True) if h > found.interval]
        assert coarser
        assert coarser[-1] > level


def test_a_dip_through_zero_is_no_crossing():
    errors = [1.0, 1e-6, 0.5, 0.1, 1e-3, 1e-4]
    found = crossing(INTERVALS, errors, 1e-2)
    assert INTERVALS[4] < found.interval < INTERVALS[3]


def test_missing_rungs_are_bridged():
    errors = [16.0, np.nan, np.nan, 16 / 8.0**4, np.nan, np.nan]
    assert crossing(INTERVALS, errors, 1.0).interval == pytest.approx(0.01)


def test_beyond_the_finest_interval_the_order_leads():
    errors = [h**2 for h in INTERVALS]
    found = crossing(INTERVALS, errors, 1e-8, order=2.0)
    assert found.interval == pytest.approx(1e-4)
    assert found.note == "extrapolated from 0.000625 s along order 2.00"


@pytest.mark.parametrize(
    ("errors", "order", "floor", "note"),
    [
        ([np.nan] * 6, 2.0, 0.0, "no errors"),
        ([1.0] * 6, None, 0.0, "no order"),
        ([1.0] * 6, -0.1, 0.0, "no order"),
        (INTERVALS, 1.0, 1e-5, "the floor is above"),
        ([1e-9] * 6, 2.0, 0.0, "at every interval up to 0.02 s"),
        ([0.0] * 6, None, 0.0, "at every interval up to 0.02 s"),
    ],
)
def test_where_the_ladder_does_not_tell(errors, order, floor, note):
    found = crossing(INTERVALS, errors, 1e-6, order, floor)
    assert found.interval is None
    assert note in found.note


def test_an_error_of_zero_has_no_logarithm():
    assert crossing([2.0, 1.0], [1.0, 0.0], 1e-3).interval == 1.0


def test_one_rung():
    assert crossing([0.01], [1.0], 0.1, order=None).interval is None
    assert crossing([0.01], [1.0], 0.01, order=2.0).interval == pytest.approx(0.001)


def test_straight_lines_in_logarithms():
    assert interpolated(10.0, 1.0, 1.0, 100.0, 1e4) == pytest.approx(100.0)
