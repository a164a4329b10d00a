"""Scores of gyroscopic systems: errors, hours, order, growth, periods, responses, refusals."""

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from gyroscopic_figures import RESPONSES
from gyroscopic_motions import DEG, EARTH_RATE, SCHULER_SPEED, G, R, grid, motion
from sinsbench.scoring.gyroscopic import FIELDS, error_history, ladder, score_gyroscopic
from sinsbench.scoring.gyroscopic_errors import (
    ARCSECOND,
    angle_errors,
    angles_between,
    inputs_of,
    start_of,
    vertical_error,
)
from sinsbench.scoring.gyroscopic_responses import PERTURBATIONS, RESPONSE_FIELDS, response, score_responses
from sinsbench.subjects.gyroscopic import start_rules
from sinsbench.subjects.gyroscopic.drivers import subject
from sinsbench.subjects.gyroscopic.systems import SYSTEMS
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import Subject
from sinsdata.cases.gyroscopic import GyroCase

STEP = 2.0


@cache
def case(name, duration=14400.0, step=STEP, **options):
    m = motion(name, grid(duration, step), **options)
    return m, inputs_of(m), start_of(m, R, G)


def loaded(function, name="mine", takes="points"):
    return LoadedSubject(Subject(name, None, "", "", samples_per_step=2, takes=takes), function)


@cache
def short_case():
    return GyroCase(
        name="parallel", motion="parallel", latitude="0.9", longitude="0.5", speed="250", duration="3600", interval="5"
    )


@cache
def short_ladder():
    return ladder(short_case(), (4, 2, 1))


# Parts


def test_vertical_error_has_components_and_angle():
    m = motion("T3", np.array([0.0, 10.0, 20.0]))
    y1, y2, up = m.axes[:, 0], m.axes[:, 1], m.vertical
    tilted = up + 3e-6 * y1 - 4e-6 * y2
    error = vertical_error(tilted / np.linalg.norm(tilted, axis=1, keepdims=True), m)
    # The third order of 5e-6, and the rounding of unit vectors.
    assert error.along == pytest.approx([3e-6] * 3, abs=5e-16)
    assert error.left == pytest.approx([-4e-6] * 3, abs=5e-16)
    assert error.angle == pytest.approx([5e-6] * 3, abs=5e-16)


def test_low_parts_of_the_truth_count():
    m = motion("T3", np.array([0.0, 10.0, 20.0]))
    below = replace_low(m, 1e-17 * m.axes[:, 0])
    assert vertical_error(m.vertical, below).along == pytest.approx([-1e-17] * 3, rel=1e-9)


def replace_low(m, low):
    class Lower(type(m)):
        vertical_lo = low

    return Lower(**vars(m))


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.3, np.pi / 2, np.pi - 1e-9, np.pi])
def test_angles_between_directions(angle):
    first = np.array([[0.0, 0.0, 1.0]])
    second = np.array([[np.sin(angle), 0.0, np.cos(angle)]])
    assert angles_between(first, second)[0] == pytest.approx(angle, abs=3e-16)


def test_angle_errors_are_the_angles_added():
    """A trihedron and an attitude of another place and another motion, read out against this one."""
    m, other = motion("T3", np.array([0.0, 5.0])), motion("T2", np.array([0.0, 5.0]))
    from sinsbench.subjects.gyroscopic.start_rules import quaternions_of_axes

    errors = angle_errors({"trihedron": quaternions_of_axes(other.axes), "attitude": other.attitude}, m)
    for name, values in errors.items():
        expected = getattr(other, name) - getattr(m, name)
        assert values == pytest.approx((expected + np.pi) % (2 * np.pi) - np.pi, abs=1e-14)


@pytest.mark.parametrize("row", [row for row in RESPONSES if row[1] != "speed" or row[2] in ("bgx", "ghc")],
                         ids=lambda row: "-".join(row[:3]))  # fmt: skip
def test_responses_are_those_computed_apart(row):
    name, error, system, *figures = row
    angles = R * response(subject(SYSTEMS[system]), *case(name)[1:], PERTURBATIONS[error])
    hour = round(3600 / STEP)
    # Figures uncertain by a few 1e-6 m; the method's error at this step is 2e-4 m, and nearly the same in both runs.
    assert angles[[hour, 2 * hour, 3 * hour, 4 * hour]] == pytest.approx(figures[:4], abs=2e-5)
    assert angles[:: round(60 / STEP)].max() == pytest.approx(figures[4], abs=2e-5)


@pytest.mark.parametrize("row", [row for row in RESPONSES if row[1] == "speed" and "equilibrium" in row[2]],
                         ids=lambda row: "-".join(row[:3]))  # fmt: skip
def test_axes_inclined_by_a_speed_error_answer_as_computed_apart(row):
    """The figures incline the axes at equilibrium by 1/V; a start in error takes the equilibrium of its own speed."""
    name, _, system, *figures = row
    _, inputs, start = case(name)

    def inclined(start, constants):
        positive, negative = start_rules.equilibrium_inclination(start, constants)
        return positive - 1 / SCHULER_SPEED, negative + 1 / SCHULER_SPEED

    rule = start_rules.pendulum if system == "gp_equilibrium" else start_rules.pendulum_pair
    verticals = (subject(one)(inputs, start)["vertical"] for one in
                 (SYSTEMS[system], replace(SYSTEMS[system], start=rule(inclined))))  # fmt: skip
    angles, hour = R * angles_between(*verticals), round(3600 / STEP)
    assert angles[[hour, 2 * hour, 3 * hour, 4 * hour]] == pytest.approx(figures[:4], abs=2e-5)
    assert angles[:: round(60 / STEP)].max() == pytest.approx(figures[4], abs=2e-5)


def test_speed_error_of_a_gyropendulum_stays_what_it_is():
    """Isometry: the angle between two solutions is constant; a speed error of 1 m/s inclines the axis by 1/V."""
    _, inputs, start = case("T3")
    angles = response(subject(SYSTEMS["gp_paper"]), inputs, start, PERTURBATIONS["speed"])
    assert angles * SCHULER_SPEED == pytest.approx(np.ones(len(angles)), abs=1e-6)


def test_bias_of_increments_is_integrated():
    inputs = replace(case("T3")[1], kind="increments")
    changed = PERTURBATIONS["both_biases"].inputs(inputs)
    difference = (changed.rate - inputs.rate)[0, 0]
    assert difference == pytest.approx(inputs.interval * 0.01 * DEG / 3600, rel=1e-6)


# Rows


def test_rows_of_an_exact_system():
    rows = score_gyroscopic(loaded(subject(SYSTEMS["ghc"])), short_case(), short_ladder())
    assert [row["interval"] for row in rows] == [20.0, 10.0, 5.0]
    for row in rows:
        assert list(row) == [field.name for field in FIELDS]
        assert (row["status"], row["samples_per_step"], row["case"]) == ("ok", 2, "parallel")
        assert row["vertical_error_2h_m"] is None
        assert row["ns_per_step"] > 0
        assert row["vertical_error_max_arcsec"] == pytest.approx(row["vertical_error_max_m"] / R / ARCSECOND)
    errors = [row["vertical_error_max_m"] for row in rows]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.3)


def test_history_of_an_error_is_what_the_scores_sum_up():
    truth = short_ladder()[2]
    found = error_history(loaded(subject(SYSTEMS["bg_paper"])), short_case(), truth)
    (row,) = score_gyroscopic(loaded(subject(SYSTEMS["bg_paper"])), short_case(), (truth,), repetitions=0)
    assert found["time"][[0, -1]] == pytest.approx([0, 3600])
    assert found["angle"].max() == pytest.approx(row["vertical_error_max_m"])
    assert found["angle"][-1] == pytest.approx(row["vertical_error_1h_m"])
    assert np.abs(found["left"]).max() == pytest.approx(row["vertical_error_left_max_m"])
    # A small error is the square root of the sum of its squares.
    assert np.hypot(found["along"], found["left"]) == pytest.approx(found["angle"], rel=1e-6, abs=1e-6)


def test_order_is_that_of_the_step_even_where_the_system_errs():
    rungs = ladder(short_case(), (4, 2, 1, Fraction(1, 2)))
    rows = score_gyroscopic(loaded(subject(SYSTEMS["gp_paper"])), short_case(), rungs, repetitions=0)
    assert rows[0]["observed_order"] == pytest.approx(4, abs=0.3)
    assert rows[0]["order_points"] == 3
    assert rows[0]["vertical_error_max_m"] == pytest.approx(rows[3]["vertical_error_max_m"], rel=1e-3)


def test_increments_are_scored_alike():
    rows = score_gyroscopic(loaded(subject(SYSTEMS["ghc"]), takes="increments"), short_case(), short_ladder(), 0)
    assert [(row["takes"], row["samples_per_step"], row["ns_per_step"]) for row in rows] == [
        ("increments", 4, None)
    ] * 3
    assert rows[2]["vertical_error_max_m"] < rows[1]["vertical_error_max_m"] / 10


def test_a_condition_that_breaks_is_a_row_that_says_so():
    def still(inputs, start):
        return subject(SYSTEMS["ghc"])(inputs, replace(start, velocity=np.zeros(3)))

    (row,) = score_gyroscopic(loaded(still), short_case(), short_ladder()[2:])
    assert (row["status"], row["message"]) == ("not applicable", "absolute speed > 0 does not hold, first at t = 0 s")
    rows = score_responses(loaded(still), short_case(), short_ladder()[2])
    assert {(row["status"], row["response_max_m"]) for row in rows} == {("not applicable", None)}


def test_angles_that_do_not_exist_leave_the_vertical_scored():
    def polar(inputs, start):
        result = subject(SYSTEMS["ghc"])(inputs, start)
        result["trihedron"][5] = [np.cos(np.pi / 4), -np.sin(np.pi / 4), 0, 0]
        return result

    (row,) = score_gyroscopic(loaded(polar), short_case(), short_ladder()[2:])
    assert row["status"] == "ok"
    assert row["message"] == "no angles: latitude away from the poles does not hold, first at t = 50 s"
    assert row["latitude_error_max_arcsec"] is None
    assert row["vertical_error_max_m"] < 1


@pytest.mark.parametrize(
    ("function", "status", "message"),
    [
        (lambda i, s: 1 / 0, "error", "ZeroDivisionError"),
        (lambda i, s: {"attitude": np.ones((361, 4))}, "wrong shape", "no vertical"),
        (lambda i, s: np.ones((361, 4)), "wrong shape", "vertical has shape"),
        (lambda i, s: ["a"], "wrong shape", "real numbers"),
        (lambda i, s: np.full((361, 3), np.nan), "not finite", "row 0"),
        (lambda i, s: np.ones((361, 3)), "error", "unit vectors"),
        (lambda i, s: {"vertical": np.ones((361, 3)), "speed": np.ones(721)}, "wrong shape", "differ"),
    ],
)
def test_results_of_another_form_are_told(function, status, message):
    (row,) = score_gyroscopic(loaded(function), short_case(), short_ladder()[2:])
    assert row["status"] == status
    assert message in row["message"]


def test_a_subject_may_write_into_what_it_is_given():
    truth = short_ladder()[2]
    before = truth.rate.copy()

    def destructive(inputs, start):
        result = subject(SYSTEMS["ghc"])(inputs, start)
        inputs.rate[:] = 0.0
        return result

    score_gyroscopic(loaded(destructive), short_case(), (truth,), repetitions=0)
    assert np.array_equal(truth.rate, before)


def test_rows_of_responses():
    rows = score_responses(loaded(subject(SYSTEMS["ghc"])), short_case(), short_ladder()[2])
    assert [row["error"] for row in rows] == list(PERTURBATIONS)
    assert all(list(row) == [field.name for field in RESPONSE_FIELDS] and row["status"] == "ok" for row in rows)
    by_error = {row["error"]: row for row in rows}
    # R tilt (1 - part of a Schuler oscillation): the tilt is largest at the start.
    assert by_error["tilt"]["response_max_m"] == pytest.approx(637.1, rel=1e-6)


def test_coarser_rungs_are_what_sampling_at_their_interval_gives():
    thinned, direct = short_ladder()[0], ladder(short_case(), (4,))[0]
    assert thinned.interval == direct.interval
    assert np.array_equal(thinned.time, direct.time)
    assert np.array_equal(thinned.attitude_lo, direct.attitude_lo)
    for name in ("angle_increment", "velocity_increment"):
        # Three additions of parts no larger than the sum.
        assert getattr(thinned, name) == pytest.approx(getattr(direct, name), rel=1e-15, abs=1e-16 * 200)


def test_ladder_keeps_whole_steps_of_four_and_refuses_none():
    assert [len(rung.time) - 1 for rung in short_ladder()] == [180, 360, 720]
    with pytest.raises(ValueError, match="whole steps of four"):
        ladder(short_case(), (7,))


def test_the_earth_turns_under_the_case_at_rest():
    """The motions of these tests are those of the cases: same Earth rate."""
    assert short_ladder()[2].speed[0] == pytest.approx(250 + EARTH_RATE * R * np.cos(0.9), rel=1e-12)
