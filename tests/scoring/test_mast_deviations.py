"""What a covariance predicts of the errors that are scored: single errors, and normal ones, whose covariance it is."""

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from mast_estimates import SIZES, shifted
from sinsbench.scoring.mast import error_history
from sinsbench.scoring.mast_deviations import deviations
from sinsbench.scoring.mast_errors import QUANTITIES, Estimates, error_vectors, gauge_free_errors, nees
from sinsbench.scoring.running import RunError
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import Subject
from sinsdata.cases import MastCase
from sinsdata.tiers import cases_of
from sinsdata.truth.mast import MastMotion, sampled

Array = NDArray[np.float64]

RUNS = 4000
#: Where no attitude is near to none: the case is turned about every axis, and far north.
_ROW = 61


@pytest.fixture(scope="module")
def truth() -> MastMotion:
    (case,) = (case for case in cases_of("mast_antenna", "short") if case.name == "brief_fault")
    assert isinstance(case, MastCase)
    return sampled(case)


def estimates(truth: MastMotion, errors: Array, covariance: Array | None) -> Estimates:
    rows = np.full(len(errors), _ROW)
    values = shifted(truth, rows, errors)
    del values["time"]
    return Estimates(rows, values, covariance, None, None)


def covariance_of_its_own() -> tuple[Array, Array]:
    """Return a covariance with large correlations, and normal errors of it."""
    random = np.random.default_rng(20)
    factor = SIZES[:, None] * random.normal(size=(17, 17)) / 17**0.5
    return np.tile(factor @ factor.T, (RUNS, 1, 1)), random.normal(size=(RUNS, 17)) @ factor.T


def test_a_single_error_is_its_own_deviation(truth: MastMotion) -> None:
    """A covariance e e^T allows one error, e: its deviation is what is scored of it, to first order."""
    random = np.random.default_rng(21)
    errors = SIZES * np.vstack([np.eye(17), random.uniform(-1, 1, (60, 17))])
    given = estimates(truth, errors, errors[:, :, None] * errors[:, None, :])
    assert error_vectors(given, truth) == pytest.approx(errors, rel=1e-6, abs=1e-9)
    predicted, found = deviations(given, truth), gauge_free_errors(given, truth)
    assert set(predicted) == set(QUANTITIES) == set(found)
    for name, values in found.items():
        # The second order is 1e-5 of the first; sums of several errors may cancel to a tenth of them. Errors that are
        # none are rounding: 1e-15 of angles, 1e-9 of metres.
        assert predicted[name] == pytest.approx(values, rel=1e-3, abs=2e-9 if name == "position" else 1e-14), name


def test_normal_errors_have_the_predicted_root_mean_square_and_seldom_exceed_three_of_it(truth: MastMotion) -> None:
    covariance, errors = covariance_of_its_own()
    given = estimates(truth, errors, covariance)
    predicted, found = deviations(given, truth), gauge_free_errors(given, truth)
    # Mean squares of so many runs scatter by at most sqrt(2/RUNS), if one direction dominates; four times that.
    scatter = 4 * (2 / RUNS) ** 0.5
    for name, values in found.items():
        assert np.mean(values**2) == pytest.approx(np.mean(predicted[name] ** 2), rel=scatter), name
        # 0.27 per cent is the most that norms of normal errors exceed it; four standard deviations of that count.
        exceeded = np.count_nonzero(values > 3 * predicted[name])
        assert exceeded <= 0.0027 * RUNS + 4 * (0.0027 * RUNS) ** 0.5, name
    assert np.mean(nees(given, truth)["joint"]) == pytest.approx(16, abs=4 * (32 / RUNS) ** 0.5)


def test_the_twist_of_the_mast_predicts_nothing(truth: MastMotion) -> None:
    covariance, errors = covariance_of_its_own()
    before = deviations(estimates(truth, errors[:3], covariance[:3]), truth)
    covariance[:, 14] = covariance[:, :, 14] = 1.0
    after = deviations(estimates(truth, errors[:3], covariance[:3]), truth)
    for name, values in before.items():
        assert (after[name] == values).all(), name


def test_without_a_covariance_there_is_none(truth: MastMotion) -> None:
    with pytest.raises(RunError, match="holds no covariance"):
        deviations(estimates(truth, np.zeros((2, 17)), None), truth)


def test_the_history_of_an_estimator_holds_them(truth: MastMotion) -> None:
    rows = np.arange(0, len(truth.time), 20)

    def estimator(inputs: object, start: object) -> Mapping[str, Array]:
        return shifted(truth, rows, np.tile(SIZES, (len(rows), 1))) | {
            "covariance": np.tile(np.diag(SIZES**2), (len(rows), 1, 1))
        }

    history = error_history(LoadedSubject(Subject("mine", None, "", ""), estimator), truth)
    assert {f"deviation_{name}" for name in QUANTITIES} < set(history)
    for name in QUANTITIES:
        assert history[f"deviation_{name}"].shape == history["time"].shape
    # Independent errors of three components: 0.1 m/s and 1e-5 rad each.
    assert history["deviation_velocity"] == pytest.approx(0.1 * 3**0.5, rel=1e-12)
    assert history["deviation_chi"] == pytest.approx(1e-5 * 6**0.5, rel=1e-12)
