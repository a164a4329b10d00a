"""Scores of estimators of the mast's antenna: errors of known size, what cannot be observed, consistency, strangers."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sinsbench.scoring.mast import FIELDS, LIMITS, error_history, score_mast, settled
from sinsbench.scoring.mast_errors import (
    BLOCKS,
    COLUMNS,
    QUANTITIES,
    Estimates,
    checked_estimates,
    error_vectors,
    gauge_free_errors,
    inputs_of,
    nees,
    start_of,
)
from sinsbench.scoring.mast_summary import SUMMARY_FIELDS, nees_band, summary
from sinsbench.scoring.running import RunError
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.mast import subjects
from sinsbench.subjects.mast.contract import MastInputs, MastStart
from sinsbench.subjects.registry import Subject
from sinsdata.cases import MastCase
from sinsdata.tiers import cases_of
from sinsdata.truth.mast import MastMotion, sampled
from sinsref.exact import ExactNumber

Array = NDArray[np.float64]
Result = dict[str, Any]
SECONDS = 4


@pytest.fixture(scope="module")
def case() -> MastCase:
    return MastCase("brief", str(SECONDS), "0.01")


@pytest.fixture(scope="module")
def truth(case: MastCase) -> MastMotion:
    return sampled(case)


def exact(truth: MastMotion) -> Result:
    """Return the truth in the form of an estimator's result, a row a second."""
    stride = 2 * round(1 / truth.interval)
    names = {name: "lam" if name == "lambda" else name for name in ("time", *COLUMNS)}
    return {name: getattr(truth, attribute)[::stride].copy() for name, attribute in names.items()}


def subject(function: Callable[[MastInputs, MastStart], Any], name: str = "mine") -> LoadedSubject:
    return LoadedSubject(Subject(name, None, "", ""), function)


def built_in(name: str) -> LoadedSubject:
    return subject(getattr(subjects, name), name)


def multiplied(a: Array, b: Array) -> Array:
    """Hamilton product of arrays of quaternions."""
    scalar = a[:, :1] * b[:, :1] - np.sum(a[:, 1:] * b[:, 1:], axis=1, keepdims=True)
    return np.hstack([scalar, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])])


def turn(vector: list[float], count: int) -> Array:
    angle = float(np.linalg.norm(vector))
    quaternion = [np.cos(angle / 2), *(np.sin(angle / 2) / (angle or 1) * np.array(vector))]
    return np.tile(quaternion, (count, 1))


def errors_of(result: Result, truth: MastMotion) -> dict[str, float]:
    return {name: float(x.max()) for name, x in gauge_free_errors(checked_estimates(result, truth), truth).items()}


def test_the_truth_has_no_error(truth: MastMotion) -> None:
    # Products of three quaternions round to a few units of 1e-16; the mast's direction is a difference of such.
    assert max(errors_of(exact(truth), truth).values()) < 2e-15
    assert np.abs(error_vectors(checked_estimates(exact(truth), truth), truth)).max() < 2e-15


@pytest.mark.parametrize("size", [1e-12, 1e-6, 0.5, 3.0])
def test_turns_of_known_size(truth: MastMotion, size: float) -> None:
    """A turn of mu is one of the antenna in inertial space, of eta one relative to the vehicle too."""
    vector = [0.36 * size, 0.48 * size, -0.8 * size]
    for name, seen in (("mu", {"mu", "chi", "antenna"}), ("eta", {"nu", "chi", "antenna"})):
        result = exact(truth)
        result[name] = multiplied(result[name], turn(vector, len(result["time"])))
        found = errors_of(result, truth)
        for quantity in ("mu", "nu", "chi", "antenna", "mast"):
            expected = size if quantity in seen else 0.0
            assert found[quantity] == pytest.approx(expected, rel=1e-9, abs=3e-15), (name, quantity)


def test_a_tilt_of_the_mast(truth: MastMotion) -> None:
    result = exact(truth)
    tilt = turn([3e-4, 4e-4, 0], len(result["time"]))
    result["lambda"] = multiplied(result["lambda"], tilt)
    result["eta"] = multiplied(tilt * [1, -1, -1, -1], result["eta"])
    found = errors_of(result, truth)
    assert found["mast"] == pytest.approx(5e-4, rel=1e-9)
    assert found["nu"] < 1e-15  # lambda o eta is as before


def test_position_velocity_and_level(truth: MastMotion) -> None:
    for name, size, metres in (("longitude", 1e-6, np.cos(truth.latitude[::200]).max()), ("latitude", -1e-6, 1.0)):
        result = exact(truth)
        result[name] = result[name] + size
        found = errors_of(result, truth)
        # 1e-10 of an angle of 1e-6 is the spacing of angles around 1.
        assert found["position"] == pytest.approx(1e-6 * truth.radius * metres, rel=1e-9)
        assert found["antenna"] == pytest.approx(1e-6, rel=1e-8)  # local level turns with the place
        assert found[name] == pytest.approx(1e-6, rel=1e-9)
        assert found["chi"] < 1e-15
    result = exact(truth)
    result["velocity"] = result["velocity"] + [0.02, 0.03, 0.06]
    result["height"] = result["height"] - 7.0
    found = errors_of(result, truth)
    assert found["velocity"] == pytest.approx(0.07, rel=1e-9)
    assert found["position"] == pytest.approx(7.0, rel=1e-9)


@given(st.floats(-3, 3), st.lists(st.floats(-0.3, 0.3), min_size=9, max_size=9))
@settings(derandomize=True, deadline=None, max_examples=25)
def test_the_twist_of_the_mast_changes_no_error(truth: MastMotion, twist: float, turns: list[float]) -> None:
    result = exact(truth)
    count = len(result["time"])
    for k, name in enumerate(("mu", "eta", "lambda")):
        result[name] = multiplied(result[name], turn(turns[3 * k : 3 * k + 3], count))
    before = errors_of(result, truth)
    psi = turn([0, 0, twist], count)
    result["lambda"] = multiplied(result["lambda"], psi)
    result["eta"] = multiplied(psi * [1, -1, -1, -1], result["eta"])
    after = errors_of(result, truth)
    # arctan2 of two unit vectors' sum and difference loses nothing; products of quaternions a few units of 1e-16.
    assert after == pytest.approx(before, rel=1e-14, abs=1e-14)


def test_errors_in_the_order_of_the_covariance(truth: MastMotion) -> None:
    """The initial estimate is the truth [+] d, so that the truth is the estimate [+] -d."""
    start = start_of(truth.start)
    result = exact(truth)
    names = {name: f"{name}_" if name == "lambda" else name for name in COLUMNS}
    for name, attribute in names.items():
        result[name][0] = getattr(start, attribute)
    errors = error_vectors(checked_estimates(result, truth), truth)
    # A metre of height in 3 m, an angle of 1 rad and a velocity of 100 m/s are known to their spacings.
    assert errors[0] == pytest.approx(-truth.start.errors, abs=2e-14, rel=1e-9)
    assert np.abs(errors[1:]).max() < 2e-15


def test_nees_of_normal_errors(truth: MastMotion) -> None:
    """Errors L z of a covariance L L^T give z^T z, over all numbers but the twist, and over any block alone."""
    random = np.random.default_rng(7)
    result = exact(truth)
    result["mu"] = multiplied(result["mu"], turn([1e-3, -2e-3, 5e-4], len(result["time"])))
    result["velocity"] = result["velocity"] + 0.1
    result["mast_rate"] = result["mast_rate"] - 0.01
    errors = error_vectors(checked_estimates(result, truth), truth)
    units = 10.0 ** random.integers(-8, 3, 17)
    factor = units[:, None] * random.normal(size=(17, 17))
    result["covariance"] = np.tile(factor @ factor.T, (len(errors), 1, 1))
    result["covariance"][:, 14] = result["covariance"][:, :, 14] = 0  # a twist that is known exactly
    found = nees(checked_estimates(result, truth), truth)
    assert {name: len(places) for name, places in BLOCKS.items()} == {
        "joint": 16, "navigation": 9, "antenna": 3, "mast": 4,
    }  # fmt: skip
    for name, places in BLOCKS.items():
        part = (factor @ factor.T)[np.ix_(places, places)]
        scale = units[list(places)]
        weighted = np.linalg.solve(part / np.outer(scale, scale), (errors[:, places] / scale).T).T
        expected = np.sum(errors[:, places] / scale * weighted, axis=1)
        assert found[name] == pytest.approx(expected, rel=1e-6)  # the covariances' conditions are up to 1e6
        assert found[name].min() >= 0


def test_the_band_of_the_nees() -> None:
    assert nees_band(16, 8) == pytest.approx((12.3, 20.2), abs=0.05)
    assert nees_band(1, 1)[1] == pytest.approx(5.0239, abs=1e-4)  # tables of chi-square
    with pytest.raises(ValueError, match="no band"):
        nees_band(16, 0)


def test_settling() -> None:
    time = np.arange(5.0)
    assert settled(time, np.array([3, 2, 0.5, 0.5, 0.1]), 1.0) == 2
    assert settled(time, np.array([3, 0.5, 2, 0.5, 0.1]), 1.0) == 3
    assert settled(time, np.array([0.5, 0.5, 0.5, 0.5, 2]), 1.0) is None
    assert settled(time, np.zeros(5), 1.0) == 0


def test_a_row_of_scores(case: MastCase, truth: MastMotion) -> None:
    (row,) = score_mast(built_in("mekf_nu_az"), case, truth)
    assert list(row) == [field.name for field in FIELDS]
    json.dumps(row, allow_nan=False)
    assert (row["status"], row["satellites"], row["interval"], row["duration"]) == ("ok", 4, 0.01, SECONDS)
    assert row["us_per_step"] > 0
    assert row["mu_rms_50_200"] is None
    assert row["nees_joint_10s"] is None
    history = error_history(built_in("mekf_nu_az"), truth)
    late = history["time"] >= SECONDS / 2
    for name in QUANTITIES:
        assert row[f"{name}_max_late"] == history[name][late].max()
        assert row[f"{name}_rms_late"] == pytest.approx(np.sqrt(np.mean(history[name][late] ** 2)), rel=1e-12)
    # 12 innovations a step; 0.3 is 15 standard deviations of chi-square over its degrees of freedom.
    assert abs(row["nis_ratio"] - 1) < 0.3
    (again,) = score_mast(built_in("mekf_nu_az"), case, truth, repetitions=0)
    assert again == row | {"us_per_step": None}


def test_a_filter_that_breaks_down(case: MastCase, truth: MastMotion) -> None:
    (row,) = score_mast(built_in("cekf_printed_313"), case, truth, repetitions=0)
    assert row["status"] == "not finite"
    assert row["failed_at"] is not None
    assert f"first at t = {row['failed_at']:g} s" in row["message"]


def _with(**changes: Any) -> Callable[[Result], Any]:
    return lambda result: result | changes


def _nan_from_two_seconds(result: Result) -> Result:
    result["velocity"][2:, 1] = np.nan
    result["mu"][3:] = np.nan
    return result


@pytest.mark.parametrize(
    ("spoil", "status", "says"),
    [
        (_nan_from_two_seconds, "not finite", "velocity holds NaN or infinity, first at t = 2 s"),
        (lambda result: {**result, "eta": 2 * result["eta"]}, "error", "eta is no unit quaternion, first at t = 0 s"),
        (lambda result: {**result, "mu": result["mu"].T}, "wrong shape", "mu has shape (4, 5); (5, 4) is needed"),
        (lambda result: {name: result[name] for name in result if name != "eta"}, "wrong shape", "holds no eta"),
        (lambda result: result["mu"], "wrong shape", "a mapping of arrays is needed"),
        (_with(latitude=["north"] * 5), "wrong shape", "latitude is not an array of real numbers"),
        (lambda r: {**r, "time": r["time"] + 0.004}, "wrong shape", "time 0.004 s is not the end of a step of 0.01 s"),
        (lambda r: {**r, "time": r["time"][::-1]}, "wrong shape", "time does not increase"),
        (lambda r: {name: x[:3] for name, x in r.items()}, "wrong shape", "do not span the motion of 0 ... 4 s"),
        (lambda r: {**r, "time": r["time"] + 1}, "wrong shape", "time 5 s is not the end of a step"),
        (_with(covariance=np.eye(17)), "wrong shape", "covariance has shape (17, 17); (5, 17, 17) is needed"),
        (
            _with(covariance=np.stack([np.diag([1.0] * 16 + [1.0 - k]) for k in range(5)])),
            "error",
            "covariance is not positive, first at t = 1 s",
        ),
    ],
)
def test_what_strangers_return(
    case: MastCase, truth: MastMotion, spoil: Callable[[Result], Any], status: str, says: str
) -> None:
    (row,) = score_mast(subject(lambda inputs, start: spoil(exact(truth))), case, truth, repetitions=0)
    assert row["status"] == status
    assert says in row["message"]
    if "first at t" in says:
        assert f"{row['failed_at']:g} s" in says


def test_an_estimator_that_raises_and_one_that_writes_into_its_inputs(case: MastCase, truth: MastMotion) -> None:
    def raising(inputs: MastInputs, start: MastStart) -> Result:
        raise KeyError("no such state")

    (row,) = score_mast(subject(raising), case, truth)
    assert row["status"] == "error"
    assert "KeyError" in row["message"]

    def writing(inputs: MastInputs, start: MastStart) -> Result:
        for name, array in (*vars(inputs).items(), *vars(start).items()):
            if isinstance(array, np.ndarray):
                array[...] = np.nan
                assert name
        return exact(truth)

    (row,) = score_mast(subject(writing), case, truth)
    assert row["status"] == "ok"
    assert row["antenna_max_late"] < 1e-14
    assert np.isfinite(inputs_of(truth).satellite_position).all()


def test_rows_at_every_step_are_taken_too(truth: MastMotion) -> None:
    names = {name: "lam" if name == "lambda" else name for name in ("time", *COLUMNS)}
    result = {name: getattr(truth, attribute)[::2] for name, attribute in names.items()}
    estimates = checked_estimates(result, truth)
    assert isinstance(estimates, Estimates)
    assert len(estimates.rows) == 100 * SECONDS + 1
    assert max(x.max() for x in gauge_free_errors(estimates, truth).values()) < 3e-15
    with pytest.raises(RunError, match="holds no covariance"):
        nees(estimates, truth)


@pytest.mark.slow
def test_eight_seeds_as_an_independent_program_found_them() -> None:
    """Mean NEES at 10, 50, 100 s and NIS of the filter with the mast's length, of a prototype that shares no code."""
    seeds = [x for x in cases_of("mast_antenna", "standard") if isinstance(x, MastCase) and x.name.startswith("seed_")]
    rows = [row for one in seeds for row in score_mast(built_in("mekf_nu_az"), one, sampled(one), 0, warm=True)]
    (told,) = summary(rows)
    assert list(told) == [field.name for field in SUMMARY_FIELDS]
    assert (told["family"], told["cases"], told["failed"]) == ("seed", 8, 0)
    # One decimal is known of each; the filters integrate alike, but round differently.
    for block, expected in {
        "joint": (10.9, 21.9, 23.6),
        "navigation": (7.7, 6.5, 9.9),
        "antenna": (0.6, 2.6, 3.4),
        "mast": (0.7, 4.1, 4.1),
    }.items():
        assert [told[f"nees_{block}_{when}s"] for when in (10, 50, 100)] == pytest.approx(expected, abs=0.1), block
    # How the prototype counts the first seconds is not known: an inflated variance hides one innovation in 12 there, so
    # that each of them makes 1/1200 of the sum.
    assert told["nis_ratio"] == pytest.approx(11.840 / 12, rel=2 / 1200)
    assert told["nees_joint_100s"] > told["nees_joint_high"]
    assert told["mu_rms_late"] == np.median([row["mu_rms_late"] for row in rows])
    failed = [row | {"status": "error"} for row in rows]
    assert summary(failed)[0]["failed"] == 8
    assert summary(failed)[0]["mu_rms_late"] is None


def test_windows_of_a_long_motion(case: MastCase) -> None:
    """An error that grows with time, on a coarse motion of 200 s: the windows take what they say."""
    long = replace(case, duration=ExactNumber("200"), interval=ExactNumber("0.1"))
    truth = sampled(long)

    def drifting(inputs: MastInputs, start: MastStart) -> Result:
        result = exact(truth)
        result["height"] = result["height"] + 0.01 * result["time"]
        return result

    (row,) = score_mast(subject(drifting), long, truth)
    assert row["position_max_50_200"] == pytest.approx(2.0, rel=1e-9)
    assert row["position_rms_50_200"] == pytest.approx(0.01 * np.sqrt(np.mean(np.arange(50.0, 201) ** 2)), rel=1e-9)
    assert row["position_rms_late"] == pytest.approx(0.01 * np.sqrt(np.mean(np.arange(100.0, 201) ** 2)), rel=1e-9)
    assert row["position_max_200_500"] is None
    assert row["position_settled"] is None
    assert row["velocity_settled"] == 0
    assert set(LIMITS) <= set(QUANTITIES)
