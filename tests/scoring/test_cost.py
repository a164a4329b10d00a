"""Costs of subjects in rows: times against a fixed workload, operations, bytes of state; and work against precision."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sinsbench.scoring.calibration import calibration_unit
from sinsbench.scoring.cost import time_fields
from sinsbench.scoring.integrators import ladder, score_integrator
from sinsbench.scoring.rows import row
from sinsbench.scoring.running import Timed, run
from sinsbench.scoring.work_precision import LEVELS, Level, cheapest, cost_at
from sinsbench.subjects.integrators import panov4
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.outcome import Outcome
from sinsbench.subjects.registry import Subject
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

CASES = {case.name: case for case in paper_cases("dual_precession")}


@pytest.fixture(scope="module")
def short():
    case = replace(CASES["variant2_general"], duration=ExactNumber("0.64"))
    return case, ladder(case, (Fraction(1), Fraction(1, 2)))


def user(function, **fields):
    return LoadedSubject(Subject("mine", None, "mine", "", **fields), function)


def test_times_are_least_and_median_over_a_unit_of_the_same_run():
    fields = time_fields(Timed(None, (3e-3, 1e-3, 8e-3)), samples=1000)
    assert fields["ns_per_sample"] == pytest.approx(1000.0)
    assert fields["ns_per_sample_median"] == pytest.approx(3000.0)
    assert fields["relative_cost"] == pytest.approx(1000.0 / fields["calibration_ns"])
    assert time_fields(Timed(None, ()), samples=1000) == {}


def test_the_unit_is_the_time_of_28_operations():
    """Between 0.1 and 1000 ns: a quaternion product on anything from a machine of the future to one of the past."""
    assert 0.1 < calibration_unit() < 1000


def test_what_runs_elsewhere_brings_its_times_and_is_not_counted(short):
    case, rungs = short

    def program(*inputs):
        return Outcome(panov4(*inputs), seconds=(4e-3, 2e-3, 3e-3), version="program 1.0")

    assert run(program, (np.zeros((4, 3)), np.zeros((4, 3)), 0.01, [1, 0, 0, 0], np.zeros(3))).elsewhere
    found = score_integrator(user(program), case, rungs)
    for one, samples in zip(found, (64, 128), strict=True):
        assert one["ns_per_sample"] == pytest.approx(2e-3 / samples * 1e9)
        assert one["ns_per_sample_median"] == pytest.approx(3e-3 / samples * 1e9)
        assert one["ns_per_second"] == pytest.approx(one["ns_per_sample"] / one["interval"])
        assert (one["flops_per_sample"], one["flops_note"], one["state_bytes"]) == (None, "not run here", None)
        assert one["version"] == "program 1.0"


def test_a_user_s_callable_is_counted_and_declares_its_state(short):
    case, rungs = short

    def mine(angle, velocity, interval, attitude0, velocity0):
        vector = np.cumsum(angle, axis=0) * 0.5
        scalar = np.ones((len(angle), 1))
        return np.vstack([attitude0, np.hstack([scalar, vector])])

    mine.state_bytes = 24
    for one in score_integrator(user(mine), case, rungs, repetitions=0):
        # Three sums and three halves a sample.
        assert (one["flops_per_sample"], one["flops_note"]) == (6.0, None)
        assert one["flops_per_second"] == pytest.approx(6.0 / one["interval"])
        assert one["state_bytes"] == 24
        assert one["ns_per_sample"] is None

    mine.state_bytes = "many"
    assert score_integrator(user(mine), case, rungs, repetitions=0)[0]["state_bytes"] is None


def test_what_leaves_python_has_no_count_but_a_note(short):
    case, rungs = short

    def composed(angle, *_):
        total, quaternions = Rotation.identity(), [np.array([1.0, 0, 0, 0])]
        for one in angle:
            total = total * Rotation.from_rotvec(one)
            quaternions.append(np.roll(total.as_quat(), 1))
        return np.array(quaternions)

    for one in score_integrator(user(composed), case, rungs, repetitions=0):
        assert (one["status"], one["flops_per_sample"], one["flops_per_second"]) == ("ok", None, None)
        assert "scipy" in one["flops_note"]


def test_too_few_samples_to_count(short):
    case, _ = short
    brief = replace(case, duration=ExactNumber("0.08"))
    [one] = score_integrator(user(panov4), brief, ladder(brief, (Fraction(1),)), repetitions=0)
    assert one["flops_per_sample"] is None
    assert one["flops_note"] == "counting takes 5 steps of 4 samples; there are 8"


def test_built_in_counts_do_not_depend_on_the_case(short):
    case, rungs = short
    other = replace(CASES["variant1_coning"], duration=ExactNumber("0.32"))
    found = [
        score_integrator(resolve("panov6"), *where, repetitions=0)[0]
        for where in ((case, rungs), (other, ladder(other, (Fraction(2),))))
    ]
    assert found[0]["flops_per_sample"] == found[1]["flops_per_sample"] > 0
    assert found[0]["state_bytes"] >= 8 * 7  # a quaternion and a velocity at least


def made(subject, order, cost, first=1.0):
    """A made-up ladder: errors of an order, cost in proportion to the sampling rate."""
    intervals = [0.02 / 2**k for k in range(6)]
    return [
        row(
            subject=subject,
            case="cone",
            interval=h,
            status="ok",
            attitude_error_max=first * (h / 0.02) ** order,
            flops_per_second=cost / h,
            ns_per_second=None if subject == "elsewhere" else 10 * cost / h,
        )
        for h in intervals
    ]


def test_costs_are_interpolated_along_the_ladder():
    """An error of 2^-10 at order 4 takes an interval 2^2.5 times finer, and that many times the cost."""
    found = cost_at(made("fourth", 4, 1.0), Level("attitude_error_max", 2.0**-10, "rad"), "flops_per_second")
    assert found.value == pytest.approx(50 * 2**2.5)
    assert (found.subject, found.at_most, found.shown) == ("fourth", False, "282.8")
    easy = cost_at(made("fourth", 4, 1.0), Level("attitude_error_max", 2.0, "rad"), "flops_per_second")
    assert (easy.value, easy.shown) == (50.0, "<= 50")
    assert cost_at(made("fourth", 4, 1.0), Level("attitude_error_max", 1e-9, "rad"), "flops_per_second").subject == ""


def test_the_cheapest_changes_with_the_error():
    rows = [*made("second", 2, 1.0), *made("sixth", 6, 4.0), *made("elsewhere", 6, 3.0)]
    found = cheapest(rows, [Level("attitude_error_max", x, "rad") for x in (0.3, 1e-5, 1e-9, 1e-12)])
    assert [one.by_flops.subject for one in found] == ["second", "elsewhere", "elsewhere"]
    assert [one.by_time.subject for one in found] == ["second", "sixth", "sixth"]
    assert [one.reached_by for one in found] == [3, 2, 2]


def test_failures_and_missing_rungs_do_not_disturb():
    rows = made("fourth", 4, 1.0)
    rows[2] = row(subject="fourth", case="cone", interval=0.005, status="error", message="out of fuel")
    [one] = cheapest(rows, [Level("attitude_error_max", 2.0**-10, "rad")])
    assert one.by_flops.value == pytest.approx(50 * 2**2.5)
    assert cheapest([rows[2]]) == []
    assert len({(level.field, level.value) for level in LEVELS}) == len(LEVELS) == 14
