"""What the fixtures hand out, and what they say of scores: on motions short enough for a test."""

import re
from typing import Any

import numpy as np
import pytest

from sinsbench.pytest_plugin.cases import SuppliedCase, UnknownCaseError, supplied_case
from sinsbench.pytest_plugin.scores import ScoreFailureError, scores_of
from sinsbench.subjects.integrators import INTEGRATORS
from sinsdata.cases import CaseError

MOTION = {
    "name": "mine", "spin_rate": 5, "precession_ratio": "1/3", "nutation": "pi/9", "spin_rate_dual": 1,
    "nutation_dual": 2, "initial_velocity": [3, 0, 0], "interval": "0.02", "duration": "1.28",
}  # fmt: skip
SAMPLES = 64


@pytest.fixture(scope="module")
def motion() -> SuppliedCase:
    return supplied_case("dual_precession", MOTION)


def test_inputs_make_a_call_and_truth_stands_at_every_sample(motion: SuppliedCase) -> None:
    assert list(motion.inputs) == ["angle", "velocity", "interval", "attitude0", "velocity0"]
    computed = INTEGRATORS["panov6"](*motion.inputs.values())
    assert motion.truth["sample"].tolist() == list(range(SAMPLES + 1))
    # Steps of four samples; order 6 leaves 1e-8 on this motion, a slip in a convention leaves 1e-2.
    for name in ("attitude", "velocity_inertial", "velocity_body"):
        np.testing.assert_allclose(computed[name], motion.truth[name][::4], rtol=0, atol=1e-5, err_msg=name)
    np.testing.assert_array_equal(motion.inputs["attitude0"], motion.truth["attitude"][0])
    assert 0 < np.abs(motion.truth["attitude_lo"]).max() < 2.0**-53


MAST = {"name": "brief", "duration": "3", "interval": "0.01"}


def test_a_mast_case_is_what_an_estimator_is_given_and_returns() -> None:
    mast = supplied_case("mast_antenna", MAST)
    assert list(mast.inputs) == ["inputs", "start"]
    assert mast.inputs["inputs"].range.shape == (300, 3, 4)
    assert {name: values.shape for name, values in mast.truth.items()} == {
        **dict.fromkeys(("time", "longitude", "latitude", "height"), (301,)),
        **dict.fromkeys(("mu", "eta", "lambda", "nu"), (301, 4)),
        "velocity": (301, 3),
        "mast_rate": (301, 2),
    }
    # Products of unit quaternions round to a few units of 1e-16; 1e-16 of the radius is a nanometre.
    scores_of(mast, mast.truth).require("mu_max_late<1e-14", "antenna_max_late<1e-14", "position_max_late<1e-8")

    def stands_still(inputs: Any, start: Any) -> dict[str, Any]:
        names = {"lambda": "lambda_", **{name: name for name in mast.truth if name not in ("time", "nu", "lambda")}}
        still = {name: np.array([getattr(start, attribute)] * 4) for name, attribute in names.items()}
        return still | {"time": inputs.time[::100]}

    with pytest.raises(
        ScoreFailureError, match=r"stands_still on brief at 0.01 s: velocity_max_late is \d.*required <"
    ):
        scores_of(mast, stands_still).require("velocity_max_late<0.1")
    with pytest.raises(ScoreFailureError, match=r"result on brief: not finite: mu holds NaN .* first at t = 1 s"):
        scores_of(mast, mast.truth | {"mu": np.where(mast.truth["time"][:, None] < 1, mast.truth["mu"], np.nan)})


@pytest.mark.parametrize(
    ("dataset", "case", "name"), [("gyro_systems", "stop_0.1", "rate"), ("mast_antenna", MAST, "rate1")]
)
def test_objects_among_the_inputs_are_copies_too(dataset: str, case: Any, name: str) -> None:
    getattr(supplied_case(dataset, case).inputs["inputs"], name)[:] = np.nan
    assert np.isfinite(getattr(supplied_case(dataset, case).inputs["inputs"], name)).all()


def test_a_test_that_spoils_its_arrays_spoils_no_other(motion: SuppliedCase) -> None:
    spoiled = supplied_case("dual_precession", MOTION)
    spoiled.inputs["angle"][:] = np.nan
    spoiled.truth["attitude"][:] = np.nan
    again = supplied_case("dual_precession", MOTION)
    np.testing.assert_array_equal(again.inputs["angle"], motion.inputs["angle"])
    np.testing.assert_array_equal(again.truth["attitude"], motion.truth["attitude"])


@pytest.mark.parametrize(
    ("takes", "names", "rows"),
    [
        ("rates", ["angular_rate", "specific_force", "interval"], SAMPLES + 1),
        ("resolved_end", ["angle", "velocity_end", "interval"], SAMPLES),
        ("nonuniform", ["angle", "velocity", "times"], SAMPLES),
    ],
)
def test_other_conventions_name_what_they_hold(takes: str, names: list[str], rows: int) -> None:
    case = supplied_case("dual_precession", MOTION, takes)
    assert list(case.inputs) == [*names, "attitude0", "velocity0"]
    assert case.inputs[names[0]].shape == case.inputs[names[1]].shape == (rows, 3)
    assert case.takes == takes


def test_equator_and_gyroscopic_cases_have_the_arguments_of_their_contracts() -> None:
    equator = supplied_case("equator_errors", "ship_set1")
    assert list(equator.inputs) == ["time", "v_east", "height", "initial_errors"]
    np.testing.assert_array_equal(equator.truth["state"][0], equator.inputs["initial_errors"])
    assert scores_of(equator, equator.truth["state"])["scd"] > 15
    gyroscopic = supplied_case("gyro_systems", "stop_0.1")
    assert list(gyroscopic.inputs) == ["inputs", "start"]
    perfect = {name: gyroscopic.truth[name] for name in ("vertical", "attitude")}
    # A rounding of the unit vector is a nanometre on the Earth.
    scores_of(gyroscopic, perfect).require("vertical_error_max_m<1e-8", "attitude_error_max<=1e-15")
    with pytest.raises(ScoreFailureError, match=r"vertical_error_max_m is \d+, required < 1\.0"):
        scores_of(gyroscopic, perfect | {"vertical": perfect["vertical"][::-1]}).require("vertical_error_max_m<1")


@pytest.mark.parametrize(
    ("dataset", "case", "takes", "says"),
    [
        ("precession", "x", None, "admissible: dual_precession, equator_errors, gyro_systems, mast_antenna"),
        (
            "dual_precession",
            "variant",
            None,
            "no case 'variant'; admissible: variant1_coning, variant1_general, variant2",
        ),
        ("dual_precession", "varaint2_coning", None, "admissible: variant2_coning"),
        ("dual_precession", MOTION, "rate", "rate"),
        ("equator_errors", "ship_set1", "rates", "has no input conventions"),
        ("gyro_systems", "stop_0.1", "rates", "admissible for gyro_systems: points, increments"),
        ("mast_antenna", MAST, "rates", "mast_antenna has no input conventions"),
    ],
)
def test_what_is_not_there_is_said_in_one_line(dataset: str, case: Any, takes: str | None, says: str) -> None:
    with pytest.raises(UnknownCaseError, match=re.escape(says)) as refused:
        supplied_case(dataset, case, takes)
    assert "\n" not in str(refused.value)


def test_an_inadmissible_case_of_ones_own_is_refused_as_in_a_case_file() -> None:
    with pytest.raises(CaseError, match="interval"):
        supplied_case("dual_precession", MOTION | {"interval": 0})


def test_the_beginning_of_a_name_is_enough_where_one_case_has_it() -> None:
    assert supplied_case("equator_errors", "ship_ch").name == "ship_check"


def test_a_variant_of_the_paper_is_its_general_motion() -> None:
    assert supplied_case("dual_precession", "variant2").name == "variant2_general"


def test_a_function_has_an_order_and_a_result_has_none(motion: SuppliedCase) -> None:
    function = INTEGRATORS["panov4"]
    scores = scores_of(motion, function).require("observed_order>3.8", "velocity_error_max<1e-3")
    assert scores["subject"] == function.__name__
    assert len(scores.rows) > 3
    result = scores_of(motion, function(*motion.inputs.values()), name="recorded")
    assert result["subject"] == "recorded"
    assert result["attitude_error_max"] == pytest.approx(scores["attitude_error_max"], rel=1e-9)
    with pytest.raises(ScoreFailureError, match="observed_order has no value"):
        result.require("observed_order>3.8")


class StandsStill:
    takes = "rates"

    def __call__(self, rate: Any, force: Any, interval: float, attitude0: Any, velocity0: Any) -> Any:
        assert len(rate) % 2 == 1  # a row for the start
        return np.repeat(attitude0[None], len(rate), axis=0)


def test_a_function_is_fed_what_it_declares(motion: SuppliedCase) -> None:
    assert scores_of(motion, StandsStill())["takes"] == "rates"


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (lambda *_: 1 / 0, r"error: ZeroDivisionError: division by zero \(test_supplied_cases.py, line \d+\)"),
        (np.zeros((7, 4)), "wrong shape: "),
        (np.full((SAMPLES + 1, 4), np.nan), "not finite: "),
        (None, "wrong shape: the result holds none of attitude"),
    ],
)
def test_what_cannot_be_scored_fails_with_the_reason(motion: SuppliedCase, answer: Any, says: str) -> None:
    with pytest.raises(ScoreFailureError, match=f" on mine: {says}"):
        scores_of(motion, answer)


def test_a_failure_tells_the_scores_with_their_units_and_a_misread_convention(motion: SuppliedCase) -> None:
    conjugate = motion.truth["attitude"] * [1, -1, -1, -1]
    with pytest.raises(ScoreFailureError) as failed:
        scores_of(motion, conjugate).require("drift_deg_per_h<1", "samples_per_step==1")
    first, hint, *values = str(failed.value).splitlines()
    assert first.startswith("result on mine at 0.02 s: drift_deg_per_h is ")
    assert "the quaternions look inertial to body" in hint
    assert any(re.fullmatch(r"  attitude_error_max = \S+ rad", line) for line in values)


def test_conditions_and_fields_that_do_not_exist_are_named(motion: SuppliedCase) -> None:
    scores = scores_of(motion, motion.truth["attitude"])
    assert repr(scores).startswith("<Scores of result on mine: ok, attitude_error_max ")
    with pytest.raises(ValueError, match=r"^'drift<1': there is no field 'drift'; did you mean"):
        scores.require("drift<1")
    with pytest.raises(KeyError, match="drift_deg_per_h"):
        scores["drift_deg_h"]
