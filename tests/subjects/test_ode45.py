"""The ode45 twin: its tableau by the order conditions, its step control by counts, its errors by truth."""

from fractions import Fraction

import numpy as np
import pytest

from sinsbench.subjects import ode45 as module
from sinsbench.subjects.equator_model import EquatorMotion
from sinsbench.subjects.ode45 import EMBEDDED, INTERPOLANT, STAGES, TOLERANCES, ode45

INITIAL = (0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7)  # the initial errors (24) of the paper
END_STATE = np.array(  # the errors 7200 s later at v = 600 m/s, H = 10 km, to 15 digits
    [
        -0.0092549881661631,
        1674.40565162338,
        -124.066129403951,
        966589.390922939,
        5.04941049361772e-7,
        -0.0194136630509409,
    ]
)

MATRIX = [[Fraction(0)] * 7] + [[*map(Fraction, row), *[Fraction(0)] * (7 - len(row))] for row in STAGES]
ABSCISSAE = [sum(row) for row in MATRIX]


def apply(vector):
    return [sum(a * x for a, x in zip(row, vector, strict=True)) for row in MATRIX]


def times(*vectors):
    return [np.prod(values) for values in zip(*vectors, strict=True)]


def elementary_weights():
    """The trees up to order 5: (order, density, the vector that the weights are multiplied with)."""
    c, one = ABSCISSAE, [Fraction(1)] * 7
    c2, c3 = times(c, c), times(c, c, c)
    ac, ac2, aac = apply(c), apply(c2), apply(apply(c))
    return [
        (1, 1, one),
        (2, 2, c),
        (3, 3, c2),
        (3, 6, ac),
        (4, 4, c3),
        (4, 8, times(c, ac)),
        (4, 12, ac2),
        (4, 24, aac),
        (5, 5, times(c2, c2)),
        (5, 10, times(c2, ac)),
        (5, 15, times(c, ac2)),
        (5, 30, times(c, aac)),
        (5, 20, times(ac, ac)),
        (5, 20, apply(c3)),
        (5, 40, apply(times(c, ac))),
        (5, 60, apply(ac2)),
        (5, 120, apply(aac)),
    ]


def product(weights, vector):
    return sum(w * x for w, x in zip(weights, vector, strict=True))


def test_abscissae():
    assert [0, Fraction(1, 5), Fraction(3, 10), Fraction(4, 5), Fraction(8, 9), 1, 1] == ABSCISSAE


def test_solution_has_order_five_and_estimate_order_four():
    embedded = [*map(Fraction, EMBEDDED)]
    for order, density, vector in elementary_weights():
        assert product(MATRIX[6], vector) == Fraction(1, density)
        if order < 5:
            assert product(embedded, vector) == Fraction(1, density)
    # The estimate must differ from the solution, or there is no error to control.
    assert any(product(embedded, vector) != Fraction(1, density) for _, density, vector in elementary_weights())


def test_interpolant_has_order_four_everywhere_and_joins_smoothly():
    columns = [[Fraction(row[power]) for row in INTERPOLANT] for power in range(4)]
    for order, density, vector in elementary_weights():
        if order < 5:
            expected = [Fraction(1, density) if power == order - 1 else 0 for power in range(4)]
            assert [product(column, vector) for column in columns] == expected
    assert [sum(column[stage] for column in columns) for stage in range(7)] == MATRIX[6]
    slopes = [sum((power + 1) * columns[power][stage] for power in range(4)) for stage in range(7)]
    assert slopes == [0, 0, 0, 0, 0, 0, 1]
    assert columns[0] == [1, 0, 0, 0, 0, 0, 0]


def paper(relative, absolute, times=(0.0, 7200.0)):
    matrix = EquatorMotion.at(600.0, 10000.0).matrix()
    return ode45(lambda _, state: matrix @ state, times, INITIAL, relative, absolute)


@pytest.mark.parametrize(
    ("name", "steps", "dv_up", "d_height"),
    [
        ("ode45_1e3", 14, 2.22e-1, 1.28e2),
        ("ode45_1e6", 59, 2.01e-3, 1.16),
        ("ode45_1e9", 244, 2.04e-6, 1.18e-3),
        ("ode45_1e12", 954, 2.24e-9, 1.29e-6),
        ("ode45_tightest", 2173, 4.05e-11, 2.33e-8),
    ],
)
def test_steps_and_end_errors_under_the_conditions_of_the_paper(name, steps, dv_up, d_height):
    result = paper(*TOLERANCES[name])
    assert (result.steps, result.rejected, result.evaluations) == (steps, 0, 6 * steps + 1)
    assert result.time[-1] == 7200.0
    assert result.time.size == steps + 1
    # Three digits are known; at 1e-12 rounding takes one of them, at the tightest tolerance it is the error.
    rtol, factor = (0.005, 1) if name in ("ode45_1e3", "ode45_1e6", "ode45_1e9") else (0.02, 1)
    if name == "ode45_tightest":
        rtol, factor = 0.0, 3
    error = result.state[-1] - END_STATE
    for actual, known in ((error[1], dv_up), (error[3], d_height)):
        assert known / factor * (1 - rtol) <= actual <= known * factor * (1 + rtol)


@pytest.mark.parametrize(
    ("relative", "absolute", "steps"), [(1e-13, 1e-13, 1513), (1e-14, 1e-6, 340), (1e-14, 1e-14, 2045)]
)
def test_other_tolerances(relative, absolute, steps):
    # Relative tolerances below 100 eps are raised to it.
    assert paper(relative, absolute).steps == steps


def test_subjects_are_made_of_the_table():
    for name, (relative, absolute) in TOLERANCES.items():
        subject = getattr(module, name)
        assert subject.__name__ == name
        expected = paper(relative, absolute).state[-1]
        actual = subject([0.0, 7200.0], 600.0, 10000.0, INITIAL)
        np.testing.assert_array_equal(actual[-1], expected)
        np.testing.assert_array_equal(actual[0], INITIAL)


def test_subject_at_any_instants():
    time = np.array([0.0, 0.0, 100.0, 250.0, 7200.0])
    errors = module.ode45_1e9(time, 600.0, 10000.0, INITIAL)
    np.testing.assert_array_equal(errors[0], errors[1])
    np.testing.assert_array_equal(errors[2:], module.ode45_1e9(time[2:], 600.0, 10000.0, INITIAL))
    assert module.ode45_1e9([0.0], 600.0, 10000.0, INITIAL).shape == (1, 6)
    assert module.ode45_1e9([], 600.0, 10000.0, INITIAL).shape == (0, 6)


def test_interpolated_output_lies_on_the_solution():
    instants = np.linspace(0.0, 10.0, 4001)
    result = ode45(lambda _, y: np.array([y[1], -y[0]]), instants, [0.0, 1.0], 1e-9, 1e-12)
    assert result.steps < 400
    np.testing.assert_array_equal(result.time, instants)
    error = np.abs(result.state[:, 0] - np.sin(instants))
    steps = ode45(lambda _, y: np.array([y[1], -y[0]]), (0.0, 10.0), [0.0, 1.0], 1e-9, 1e-12)
    at_steps = np.abs(steps.state[:, 0] - np.sin(steps.time)).max()
    # The interpolant has the order of the estimate, one below the solution: its error stays near the
    # tolerance.
    assert error.max() < 2 * at_steps + 1e-9


def test_interpolant_is_exact_for_polynomials_of_its_order():
    instants = np.linspace(0.0, 2.0, 37)
    result = ode45(lambda t, y: np.array([4 * t**3]), instants, [1.0])
    np.testing.assert_allclose(result.state[:, 0], 1 + instants**4, rtol=1e-14)


def test_steps_grow_at_most_fivefold_up_to_a_tenth_of_the_interval():
    # The error is zero; the first step comes from |f| / threshold = 1000.
    sizes = np.diff(ode45(lambda t, y: np.ones(1), (0.0, 1.0), [0.0]).time)
    first = 0.8 * 1e-3**0.2 / 1000
    np.testing.assert_allclose(sizes[:6], first * np.array([1, 5, 25, 125, 0.1 / first, 0.1 / first]))
    assert sizes.max() == pytest.approx(0.1)


def test_last_step_is_stretched_by_at_most_a_tenth():
    for end in np.linspace(1.0, 2.0, 23):
        sizes = np.diff(ode45(lambda t, y: -y, (0.0, end), [1.0], 1e-5, 1e-8).time)
        assert sizes[-1] > 0
        assert sizes.sum() == pytest.approx(end)
        assert sizes[-1] > sizes[-2] * 0.09


def test_first_step():
    # |f| / max(|y|, threshold) = 4, so h = 0.8 rtol^(1/5) / 4 unless a tenth of the interval is less.
    result = ode45(lambda t, y: 4 * y, (0.0, 10.0), [1.0], 1e-5, 1e-12)
    assert result.rejected == 0
    assert result.time[1] == pytest.approx(0.8 * 1e-5**0.2 / 4)


def test_rejected_steps_shrink_by_error_then_halve():
    visited = []

    def jump(t, y):
        visited.append(t)
        return np.array([0.0 if t < 0.5 else 1e4])

    result = ode45(jump, (0.0, 1.0), [1.0], 1e-3, 1e-6)
    assert result.evaluations == len(visited) == 1 + 6 * (result.steps + result.rejected)
    attempts = np.reshape(visited[1:], (-1, 6))  # stages 2 to 7 of each attempt, at 1/5 to 1 of the step
    sizes = (attempts[:, 5] - attempts[:, 0]) / 0.8
    starts = attempts[:, 5] - sizes
    accepted = np.diff(starts, append=1.0) > 0.5 * sizes
    assert accepted.sum() == result.steps
    ratios = {"halved": [], "shrunk": [], "kept": []}
    for k in range(1, len(sizes) - 2):  # the last step is cut to the end of the interval
        if not accepted[k]:
            ratios["shrunk" if accepted[k - 1] else "halved"].append(sizes[k + 1] / sizes[k])
        elif not accepted[k - 1]:
            ratios["kept"].append(sizes[k + 1] / sizes[k])
    halved, shrunk, kept = ratios.values()
    assert len(halved) > 3
    assert len(shrunk) > 0
    assert len(kept) > 0
    np.testing.assert_allclose(halved, 0.5, rtol=1e-6)
    np.testing.assert_allclose(kept, 1.0, rtol=1e-6)
    assert all(0.1 - 1e-9 <= ratio <= 0.8 for ratio in shrunk)
    # The ramp that remains is integrated exactly, up to the tolerance spent on the jump.
    assert result.state[-1, 0] == pytest.approx(1 + 5e3, rel=1e-2)


def test_blow_up_is_reported():
    with pytest.raises(RuntimeError, match="meets the tolerance"):
        ode45(lambda t, y: y**2, (0.0, 2.0), [1.0])


@pytest.mark.parametrize("times", [[0.0], [0.0, 0.0], [1.0, 0.0], [[0.0, 1.0]], [0.0, np.nan]])
def test_bad_times(times):
    with pytest.raises(ValueError, match="ascending"):
        ode45(lambda t, y: y, times, [1.0])


@pytest.mark.parametrize("tolerances", [(0.0, 1e-6), (1e-3, 0.0), (np.nan, 1e-6)])
def test_bad_tolerances(tolerances):
    with pytest.raises(ValueError, match="tolerances"):
        ode45(lambda t, y: y, (0.0, 1.0), [1.0], *tolerances)
