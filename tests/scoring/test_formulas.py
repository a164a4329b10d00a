"""Scores of equator subjects: figures that can be worked out by hand, floors, digits."""

import numpy as np
import pytest

from sinsbench.scoring.formulas import COMPONENTS, equator_reference, score_formula
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import Subject
from sinsdata.cases import EquatorCase
from sinsdata.tiers import paper_cases

CASES = {case.name: case for case in paper_cases("equator_errors")}


@pytest.fixture(scope="module")
def reference():
    return equator_reference(CASES["fighter_check"])


def scored(function, reference, case="fighter_check"):
    loaded = LoadedSubject(Subject("mine", None, "mine", ""), function)
    [row] = score_formula(loaded, CASES[case], reference, 0)
    return row


def test_planted_errors_come_back(reference):
    truth = reference.truth.state
    planted = np.array([1e-3, -2e-3, 2e-3, 0.5, 1e-6, -3e-6])

    def wrong(time, *_):
        return truth + planted * np.where(time == 3600, 1, 0.5)[:, None]

    row = scored(wrong, reference)
    assert [row[f"error_{name}_max"] for name in COMPONENTS] == pytest.approx(np.abs(planted), rel=1e-6)
    assert row["velocity_error_max"] == pytest.approx(3e-3, rel=1e-6)
    assert row["velocity_error_end"] == pytest.approx(1.5e-3, rel=1e-6)
    end = np.abs(truth[-1])
    assert row["scd"] == pytest.approx(-np.log10(np.max(np.abs(planted) / 2 / end)), abs=1e-6)
    radius = 6378245.0 + 10000
    speed = np.sqrt(9.78049 * 6378245.0**2 / radius)
    scales = np.array([speed, speed, speed, radius, 1, 1])
    assert row["mescd"] == pytest.approx(-np.log10(np.max(np.abs(planted) / 2 / (scales + end))), abs=1e-6)


def test_ulps(reference):
    truth = reference.truth.state

    def off(*_):
        states = truth.copy()
        states[100, 3] += 1000 * np.spacing(states[100, 3])
        return states

    # The rest of the row is truth to half an ulp, but no error counts as less than that of the rounded inputs.
    inputs = np.abs(reference.input_errors[truth != 0] / np.spacing(np.abs(truth[truth != 0]))).max()
    assert scored(off, reference)["ulp_max"] == pytest.approx(max(1000, inputs), abs=1)


def test_the_truth_scores_the_floor(reference):
    row = scored(lambda *_: reference.truth.state, reference)
    assert row["at_floor"]
    assert row["velocity_error_max"] == pytest.approx(row["velocity_input_floor"], rel=1e-2)
    assert row["velocity_input_floor"] > 0


def test_input_floor_is_the_propagated_rounding():
    """Inputs that are binary64 have no floor; a rounded initial value has that of the transition matrix."""
    exact = EquatorCase("exact", 600, 10000, 7200, 60, (0, 0, 0, 1, 0, 0))
    assert not equator_reference(exact).input_errors.any()
    third = EquatorCase("third", 600, 10000, 7200, 60, (0, 0, 0, "1/3", 0, 0))
    rounding = float(1 / 3) * 3 - 1  # zero in binary64: 1/3 rounds down by 1/3 ulp(1/4) = 2^-54 / 3
    assert rounding == 0
    found = equator_reference(third).input_errors
    expected = equator_reference(exact).truth.state * (-(2.0**-54) / 3)
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-40)


def test_the_printed_row_two(reference):
    """The missing factors 2 cost mu sqrt(C5^2 + C6^2) / 2 = 4.717418e-4 m/s in dv_H alone."""
    [printed] = score_formula(resolve("equator_printed"), CASES["fighter_check"], reference, 0)
    [corrected] = score_formula(resolve("equator_corrected"), CASES["fighter_check"], reference, 0)
    # Epochs every 10 s see the crest to (mu 5 s)^2 / 2 = 2e-5 of it.
    assert printed["error_dv_up_max"] == pytest.approx(4.717418e-4, rel=2e-5)
    assert corrected["error_dv_up_max"] < 1e-11
    for name in COMPONENTS:
        if name != "dv_up":
            assert printed[f"error_{name}_max"] == corrected[f"error_{name}_max"]
    assert corrected["mescd"] > 15
    assert printed["mescd"] < 9


def test_uncoupled_components_stay_out_of_the_digits():
    case = CASES["ship_set2"]  # the errors of height and of east stay exactly zero
    [row] = score_formula(resolve("equator_corrected"), case, equator_reference(case), 0)
    assert row["error_d_height_max"] == 0
    assert row["scd"] > 14
    assert np.isfinite(row["ulp_max"])


def test_a_zero_component_that_is_missed_has_no_digits():
    reference = equator_reference(CASES["ship_set2"])
    row = scored(lambda *_: reference.truth.state + 1e-9, reference, "ship_set2")
    assert row["scd"] is None
    assert row["mescd"] > 8


@pytest.fixture(scope="module")
def tilted():
    misalignment = [[0, "1e-5", 0], ["-1e-5", 0, 0], [0, 0, 0]]
    case = EquatorCase("tilted", 600, 10000, 3600, 60, (0,) * 6, misalignment, inertial_longitude="pi/6")
    return case, equator_reference(case)


def test_misalignment_is_passed_on(tilted):
    case, reference = tilted
    [row] = score_formula(resolve("equator_robust"), case, reference, 0)
    assert row["status"] == "ok"
    assert row["velocity_error_max"] < 1e-12
    assert np.abs(reference.truth.state[:, 0]).max() > 1e-2
    [printed] = score_formula(resolve("equator_printed"), case, reference, 0)
    assert printed["status"] == "not applicable"
    assert printed["message"]


@pytest.mark.parametrize(
    ("function", "status"),
    [
        (lambda *_: 1 / 0, "error"),
        (lambda *_: np.zeros((721, 5)), "wrong shape"),
        (lambda time, *_: np.zeros((6, len(time))), "wrong shape"),
        (lambda time, *_: np.full((len(time), 6), np.nan), "not finite"),
        (lambda *_: None, "wrong shape"),
    ],
)
def test_bad_subjects(function, status, reference):
    row = scored(function, reference)
    assert row["status"] == status
    assert row["message"]
    assert row["velocity_error_max"] is None


def four(time, v_east, height, initial_errors):
    return resolve("equator_robust").function(time, v_east, height, initial_errors)


def positional(time, v_east, height, initial_errors, misalignment=None, inertial_longitude=0.0, /):
    return four(time, v_east, height, initial_errors)


def test_a_solver_of_four_arguments(reference, tilted):
    assert scored(four, reference)["status"] == "ok"
    loaded = LoadedSubject(Subject("mine", None, "mine", ""), four)
    [row] = score_formula(loaded, *tilted, 0)
    assert (row["status"], row["message"]) == ("not applicable", "takes no misalignment")


@pytest.mark.parametrize(
    ("function", "status", "message"),
    [
        (positional, "not applicable", "takes no misalignment"),
        (lambda t, v, h, x, misalignment: None, "not applicable", "takes no inertial_longitude"),
        (
            lambda *_, **named: np.full((61, 6), float(sorted(named) == ["inertial_longitude", "misalignment"])),
            "ok",
            None,
        ),
        (lambda t, v, h, x, *, inertial_longitude, misalignment: 0 * t[:, None] + misalignment[0, 1] + x, "ok", None),
    ],
)
def test_misalignment_goes_by_name(function, status, message, tilted):
    [row] = score_formula(LoadedSubject(Subject("mine", None, "mine", ""), function), *tilted, 0)
    assert (row["status"], row["message"]) == (status, message)


@pytest.mark.parametrize("column", range(6))
def test_errors_beyond_the_range_of_float64(column, reference):
    def huge(*_):
        states = reference.truth.state.copy()
        states[7, column] = 1e308
        return states

    row = scored(huge, reference)
    assert row["status"] == "not finite"
    assert row["message"].endswith("first in row 7")


def test_tiny_states_are_scored(reference):
    row = scored(lambda *_: np.full(reference.truth.state.shape, 1e-320), reference)
    assert row["status"] == "ok"
    assert row["velocity_error_max"] > 0


def test_a_transposed_result_gets_a_hint(reference):
    assert scored(lambda *_: reference.truth.state.T, reference)["message"].endswith("transposed?")
