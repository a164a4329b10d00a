"""Order and floor of made-up ladders whose order and floor are known."""

import numpy as np
import pytest

from sinsbench.scoring.convergence import convergence

INTERVALS = [0.02 / 2**k for k in range(6)]
NO_FLOOR = [0.0] * 6
TINY_BOUND = [1e-11] * 6


def power_law(order, first=1e-3):
    return np.array([first / 2 ** (order * k) for k in range(6)])


@pytest.mark.parametrize("order", [1, 2, 2.5, 6])
def test_a_power_law_has_its_order(order):
    fit = convergence(INTERVALS, power_law(order), NO_FLOOR, [0.0] * 6)
    assert fit.order == pytest.approx(order, abs=1e-12)
    assert fit.residual == pytest.approx(0, abs=1e-12)
    assert fit.points == 6
    assert fit.local_orders[0] is None
    assert fit.local_orders[1:] == pytest.approx([order] * 5)
    assert not fit.at_floor.any()


@pytest.mark.parametrize("sign", [1, -1], ids=["above", "below"])
def test_rounding_is_measured_and_kept_out_of_the_order(sign):
    rounding = np.array([0, 0, 0, 0, sign * 1.5e-13, 3e-12])
    fit = convergence(INTERVALS, power_law(6, 1e-5) + rounding, NO_FLOOR, TINY_BOUND)
    assert fit.order == pytest.approx(6, abs=1e-9)
    assert fit.points == 4
    assert fit.floors == pytest.approx([1.5e-13] * 5 + [3e-12], rel=1e-6)
    assert fit.at_floor.tolist() == [False] * 5 + [True]


def test_a_change_of_order_too_large_for_rounding_stays_in_the_fit():
    errors = power_law(6) + power_law(2, 1e-6)
    fit = convergence(INTERVALS, errors, NO_FLOOR, TINY_BOUND)
    assert fit.points == 6
    assert fit.residual > 1
    assert not fit.at_floor.any()
    assert fit.floors == pytest.approx(NO_FLOOR)


def test_points_within_ten_times_the_input_floor_do_not_count():
    errors = power_law(4)
    fit = convergence(INTERVALS, errors, [float(errors[4])] * 6, [0.0] * 6)
    assert fit.points == 4
    assert fit.at_floor.tolist() == [False] * 4 + [True] * 2


@pytest.mark.parametrize("errors", [[1e-13] * 6, [1e-13, 6e-14, 1.2e-13, 3e-13, 2e-13, 4e-13]], ids=["flat", "noisy"])
def test_an_exact_method_has_no_order(errors):
    fit = convergence(INTERVALS, errors, NO_FLOOR, TINY_BOUND)
    assert fit.order is None
    assert fit.residual is None
    assert fit.points < 3
    assert fit.at_floor[2:].all()


def test_missing_rungs_are_left_out():
    errors = power_law(4)
    errors[[0, 3]] = np.nan
    fit = convergence(INTERVALS, errors, NO_FLOOR, TINY_BOUND)
    assert fit.order == pytest.approx(4)
    assert fit.points == 4
    assert fit.local_orders[1] is None
    nothing = convergence(INTERVALS, [np.nan] * 6, NO_FLOOR, TINY_BOUND)
    assert (nothing.order, nothing.points) == (None, 0)


def test_zero_errors_have_no_logarithm():
    fit = convergence(INTERVALS, [0.0] * 6, NO_FLOOR, TINY_BOUND)
    assert (fit.order, fit.points) == (None, 0)
    assert fit.at_floor.all()
