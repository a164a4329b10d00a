"""What a filter's step does, run as plain Python: against matrices, differences and the textbook."""

import numpy as np
import pytest

from mast_motion import errors, simulated
from mast_python import python_modules
from sinsbench.subjects.mast.running import composite_covariance, prepared, separate_covariance
from sinsbench.subjects.mast.terms import CORRECTED

PYTHON = python_modules()
STEPS, STATES, CONTINUOUS = PYTHON["steps"], PYTHON["error_state"], PYTHON["continuous"]
RANDOM = np.random.default_rng(7)
COORDINATES = (0.0, 1.0)


@pytest.fixture(scope="module")
def problem():
    run = simulated(1.0)
    return prepared(run.inputs, run.start, CORRECTED)


@pytest.fixture
def covariance(problem):
    """Correlated, with the variances of the problem."""
    factor = RANDOM.normal(size=(17, 17)) * np.sqrt(np.diag(problem.covariance))[:, None]
    return factor @ factor.T


def moved(state, error, composite):
    out = np.zeros(20)
    STATES.corrected(state, error, composite, out)
    return out


@pytest.mark.parametrize("composite", COORDINATES)
@pytest.mark.parametrize("size", [3.0, 1e-3, 1e-7, 0.0])
def test_an_error_is_what_a_state_is_corrected_by(problem, composite, size):
    """To the rounding of quaternions, and of numbers of the size of the velocity."""
    error, found = size * RANDOM.uniform(-0.5, 0.5, 17), np.zeros(17)
    STATES.difference(moved(problem.state, error, composite), problem.state, composite, found)
    assert np.abs(found - error).max() < 1e-13


@pytest.mark.parametrize("composite", COORDINATES)
def test_spread_is_the_derivative_of_the_correction_and_reduced_its_inverse(problem, composite):
    matrix, back = np.zeros((20, 17)), np.zeros((17, 17))
    STATES.spread(problem.state, composite, matrix)
    for j, column in enumerate(np.eye(17) * 1e-5):
        slope = (moved(problem.state, column, composite) - moved(problem.state, -column, composite)) / 2e-5
        assert np.abs(slope - matrix[:, j]).max() < 1e-8  # 1e-11 of truncation, 1e-14/1e-5 of rounding at 100 m/s
    STATES.reduced(problem.state, matrix, composite, back)
    assert np.abs(back - np.eye(17)).max() < 1e-15


def test_covariances_change_coordinates_and_back(problem, covariance):
    """By differences: the two coordinates of one displaced state."""
    state = problem.state
    for column in np.eye(17)[9:15] * 1e-6:
        separate, composite = np.zeros(17), np.zeros(17)
        other = moved(state, column, 1.0)
        STATES.difference(other, state, 0.0, separate)
        STATES.difference(other, state, 1.0, composite)
        found = separate_covariance(state, np.outer(composite, composite), 0.0)
        assert np.abs(found - np.outer(separate, separate)).max() < 1e-17  # of 1e-12, to the second order left out
    again = composite_covariance(state, separate_covariance(state, covariance, 0.0), 0.0)
    assert np.allclose(again, covariance, rtol=1e-12, atol=1e-24)
    assert np.array_equal(composite_covariance(state, covariance, 1.0), covariance)


def options(composite=1.0, constraint=1.0):
    return STEPS.Options(composite, constraint)


@pytest.mark.parametrize("composite", COORDINATES)
def test_the_transition_matrix_is_the_derivative_of_a_step(problem, composite):
    work, matrix = STEPS.new_workspace(), np.zeros((17, 17))

    def stepped(error):
        state = moved(problem.state, error, composite)
        STEPS.propagate(state, problem.data, 3, options(composite), CORRECTED, problem.constants, matrix, work)
        return state

    end = stepped(np.zeros(17))
    transition = matrix.copy()
    size = 1e-5
    for j in range(17):
        ends, displaced = [stepped(sign * size * np.eye(17)[j]) for sign in (1, -1)], [np.zeros(17), np.zeros(17)]
        for state, found in zip(ends, displaced, strict=True):
            STATES.difference(state, end, composite, found)
        slope = (displaced[0] - displaced[1]) / (2 * size)
        # 1e-10 of truncation; a velocity of 100 m/s is rounded by 1e-14 m/s.
        assert np.abs(slope - transition[:, j]).max() < 1e-8


def test_measurement_rows_are_derivatives(problem):
    work, rows, residual, variance = STEPS.new_workspace(), np.zeros((12, 17)), np.zeros(12), np.zeros(12)

    def residuals(error):
        state = moved(problem.state, error, 1.0)
        arguments = (state, problem.data, 0, problem.variances, options(), CORRECTED, problem.constants)
        assert STEPS.measure(*arguments, rows, residual, variance, work) == 12
        return residual.copy()

    residuals(np.zeros(17))
    linear, expected = rows.copy(), problem.variances
    assert variance[:2].tolist() == [expected.range_rate, expected.range]
    assert np.allclose(variance[8:11], expected.antenna + expected.rate2, rtol=1e-15)
    assert variance[11] == pytest.approx((expected.force1 + expected.force2) * (1 + 1e4), rel=1e-12)
    for j in range(17):
        size = 1e-7 if j in (3, 4) else 1e-5  # 0.6 m on the Earth
        slope = (residuals(-size * np.eye(17)[j]) - residuals(size * np.eye(17)[j])) / (2 * size)
        # Ranges of 2e7 m are rounded by 4e-9 m.
        assert np.abs(slope - linear[:, j]).max() < 1e-6 + 1e-8 / size


def test_update_is_the_textbook_s(covariance):
    rows, innovation, variance = RANDOM.normal(size=(5, 17)), RANDOM.normal(size=5), RANDOM.uniform(0.5, 2, 5)
    error = RANDOM.normal(size=17)
    square = rows @ covariance @ rows.T + np.diag(variance)
    gain = np.linalg.solve(square, rows @ covariance).T
    z = innovation - rows @ error
    mean, reduced = error + gain @ z, covariance - gain @ rows @ covariance
    total = STEPS.update(
        covariance, error, rows, innovation, variance, 5, np.zeros((5, 17)), np.zeros(5), STEPS.new_workspace()
    )
    assert total == pytest.approx(z @ np.linalg.solve(square, z), rel=1e-11)
    assert np.allclose(error, mean, rtol=0, atol=1e-12)
    scale = np.sqrt(np.diag(reduced))
    scale[14] = 1.0  # the twist is known exactly
    assert np.abs((covariance - reduced) / np.outer(scale, scale)).max() < 1e-11


def test_update_refuses_what_is_no_variance(covariance):
    work = STEPS.new_workspace()
    rows, one = np.ones((1, 17)), np.ones(1)
    for broken in (-covariance, np.full((17, 17), np.nan)):
        arguments = (broken, np.zeros(17), rows, one.copy(), one, 1, np.zeros((1, 17)), np.zeros(1), work)
        assert np.isnan(STEPS.update(*arguments))


def test_covariance_is_carried(problem, covariance):
    transition, gain, noise = RANDOM.normal(size=(17, 17)), np.zeros((20, 12)), np.zeros((17, 12))
    PYTHON["disturbances"].noise_gain(problem.state, 0.3, 1.0, CORRECTED, problem.constants, gain)
    STATES.reduced(problem.state, gain, 1.0, noise)
    v = problem.variances
    densities = np.repeat([v.rate1, v.force1, v.force2, v.rate2], 3) * 0.02**2
    expected = transition @ covariance @ transition.T + noise * densities @ noise.T
    STEPS.carry(
        covariance, transition, problem.state, 0.3, 0.02, v, options(), CORRECTED, problem.constants,
        STEPS.new_workspace(),
    )  # fmt: skip
    assert np.allclose(covariance, expected, rtol=1e-11, atol=0)


@pytest.mark.parametrize("missing", [0.0, 1.0])
def test_rates_of_the_continuous_filter(problem, missing):
    """(3.18) as matrices; the missing derivative by differences of Theta S^-1, all of it."""
    factor = 1e-3 * RANDOM.normal(size=(20, 20))
    covariance, slopes = factor @ factor.T, CONTINUOUS.new_slopes(4)
    state, v, h = problem.state, problem.variances, problem.data.step
    arguments = (0.0, problem.data, 0, 0, v)
    parts = CONTINUOUS.new_slopes(4)
    for out in (slopes, parts):
        CONTINUOUS.linearise(state, *arguments, CORRECTED, problem.constants, out)
    CONTINUOUS.rates(covariance, h, v, missing, slopes)
    inverse = np.zeros((11, 11))
    inverse[:3, :3] = parts.inverse
    inverse[3:, 3:] = np.diag(1 / np.tile([v.range_rate * h, v.range * h], 4))
    theta = np.hstack([parts.theta, np.zeros((20, 8))])
    gain = (covariance @ parts.row.T + theta) @ inverse
    assert np.allclose(slopes.state, parts.state + gain @ parts.innovation, rtol=1e-12, atol=1e-12)
    a = parts.derivative - theta @ inverse @ parts.row
    if missing:
        for j in range(20):
            coupled = []
            for sign in (1, -1):
                other, there = state.copy(), CONTINUOUS.new_slopes(4)
                other[j] += sign * 1e-6
                CONTINUOUS.linearise(other, *arguments, CORRECTED, problem.constants, there)
                coupled.append(there.coupled)
            a[:, j] += (coupled[0] - coupled[1]) / 2e-6 @ parts.innovation[:3]
    densities = h * np.repeat([v.rate1, v.force1, v.force2, v.antenna], 3)
    weighted = covariance @ parts.row.T
    expected = a @ covariance + covariance @ a.T + parts.gain * densities @ parts.gain.T
    expected -= theta @ inverse @ theta.T + weighted @ inverse @ weighted.T
    # Differences of 1e-6 in numbers of 1, times innovations of 0.01 and variances of 1e-5.
    assert np.abs(slopes.covariance - expected).max() < (1e-13 if missing else 1e-14) + 1e-12 * np.abs(expected).max()


def test_innovation_square(problem):
    factor = 1e-3 * RANDOM.normal(size=(20, 20))
    covariance, slopes, v = factor @ factor.T, CONTINUOUS.new_slopes(4), problem.variances
    CONTINUOUS.linearise(problem.state, 0.0, problem.data, 0, 0, v, CORRECTED, problem.constants, slopes)
    CONTINUOUS.rates(covariance, problem.data.step, v, 0.0, slopes)
    total = CONTINUOUS.innovation_square(slopes, v)
    noise = np.diag([v.antenna + v.rate2] * 3 + [v.range_rate, v.range] * 4)
    square = slopes.row @ covariance @ slopes.row.T + noise
    assert total == pytest.approx(slopes.innovation @ np.linalg.solve(square, slopes.innovation), rel=1e-9)


def test_the_simulation_starts_at_the_errors_that_it_says():
    run = simulated(1.0)
    result = {name: values[:1] for name, values in run.truth.items()}
    assert np.abs(errors(run, result)).max() < 1e-15
