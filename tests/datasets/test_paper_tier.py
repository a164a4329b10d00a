"""Tier `paper`: exactly the cases of the papers."""

from __future__ import annotations

import math

import pytest

from sinsdata.cases import DualPrecessionCase, EquatorCase
from sinsdata.tiers import CaseFileError, paper_cases
from sinsref.exact import ExactNumber


def _texts(*numbers: ExactNumber) -> str:
    return " ".join(number.text for number in numbers)


def test_the_cases_of_loginov2013() -> None:
    """Two vehicles; (24) for two hours and the sets I-III of Table 1 for one, exactly the decimals of the print."""
    vehicles = {"fighter": "600 10000", "ship": "10 0"}
    sets = {
        "check": ("7200 10", "0.01 0.01 0.01 1 1.57e-7 1.57e-7"),
        "set1": ("3600 10", "0 0 0 1 0 0"),
        "set2": ("3600 10", "0 0 0 0 1.57e-7 0"),
        "set3": ("3600 10", "0 0 0 0 0 1.57e-7"),
    }
    cases = {case.name: case for case in paper_cases("equator_errors")}
    assert set(cases) == {f"{vehicle}_{name}" for vehicle in vehicles for name in sets}
    for vehicle, place in vehicles.items():
        for name, (sampling, errors) in sets.items():
            case = cases[f"{vehicle}_{name}"]
            assert isinstance(case, EquatorCase)
            assert _texts(case.v_east, case.height) == place
            assert _texts(case.duration, case.interval) == sampling
            assert _texts(*case.initial_errors) == errors
            assert case.misalignment is None
            assert case.inertial_longitude.text == "0"


def test_the_cases_of_lebedev1989() -> None:
    """Section 6: three variants, each with eps = -1 and eps = 1/2; 2500 steps of four samples."""
    duals = {"variant1": "0.5 10", "variant2": "10 100", "variant3": "10 100"}
    velocities = {"variant1": "10 0 0", "variant2": "100 0 0", "variant3": "20 35 40"}
    cases = {case.name: case for case in paper_cases("dual_precession")}
    assert set(cases) == {f"{variant}_{motion}" for variant in duals for motion in ("coning", "general")}
    for name, case in cases.items():
        assert isinstance(case, DualPrecessionCase)
        variant, motion = name.split("_")
        assert case.precession_ratio.fraction == ExactNumber({"coning": "-1", "general": "0.5"}[motion]).fraction
        assert _texts(case.spin_rate, case.nutation, case.interval, case.duration) == "2*pi pi/18 0.01 100"
        assert case.samples == 4 * 2500
        assert _texts(case.spin_rate_dual, case.nutation_dual) == duals[variant]
        assert _texts(*case.initial_velocity) == velocities[variant]
        # Variants 1 and 2 start at {cos theta/2, sin theta/2, 0, 0}: that is None; variant 3 at {1, 0, 0, 0}.
        if variant == "variant3":
            assert case.initial_attitude is not None
            assert _texts(*case.initial_attitude) == "1 0 0 0"
        else:
            assert case.initial_attitude is None


def test_the_start_of_the_precession_frame_is_that_of_the_paper() -> None:
    """What None stands for: Lambda(0) = {cos theta/2, sin theta/2, 0, 0}."""
    from sinsdata.truth.sampling import sample

    case = paper_cases("dual_precession")[0]
    assert isinstance(case, DualPrecessionCase)
    motion = sample(case, checkpoint_interval=case.duration)
    half = math.radians(5)
    # One rounding of the argument, one of the function: 2 ulp of 1.
    assert motion.attitude[0] == pytest.approx([math.cos(half), math.sin(half), 0, 0], abs=4.5e-16, rel=0)


def test_an_unknown_dataset_is_refused() -> None:
    with pytest.raises(CaseFileError, match="unknown dataset 'x'; admissible: equator_errors, dual_precession"):
        paper_cases("x")
