"""Leaderboards, errors over time and the stability map: numbers that can be checked otherwise."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from report_results import CASE, EQUATOR, PRECESSION
from sinsbench.report.boards import boards, own_interval, worst
from sinsbench.report.results import Results
from sinsbench.report.sections import sections
from sinsbench.report.series import error_series
from sinsbench.report.stability import stability_limits, stability_map
from sinsbench.scoring.score import score
from sinsbench.subjects.equator_formulas import modal_constants
from sinsbench.subjects.equator_model import EquatorMotion
from sinsbench.subjects.registry import BUILT_IN, Subject
from sinsdata.tiers import cases_of


def _row(subject: str, case: str, drift: float | None, status: str = "ok", interval: float = 0.01):
    names = {"subject": subject, "dataset": "dual_precession", "case": case, "interval": interval, "status": status}
    return {**names, "drift_deg_per_h": drift, "observed_order": 4.0}


def test_the_worst_case_ranks_and_failures_stand_last() -> None:
    rows = [
        *(_row("good", "x", 1.0), _row("good", "y", 3.0)),
        *(_row("better", "x", 2.0), _row("better", "y", 2.0)),
        *(_row("fails", "x", 0.1), _row("fails", "y", None, "not finite")),
    ]
    table = worst("dual_precession", rows)
    assert [(line["rank"], line["subject"], line["drift, deg/h"]) for line in table] == [
        (1, "better", 2.0),
        (2, "good", 3.0),
        (3, "fails", 0.1),
    ]
    assert [line["failures"] for line in table] == ["", "", "not finite"]


def test_only_cases_that_all_were_scored_on_are_compared() -> None:
    rows = [_row("a", "x", 1.0), _row("a", "hard", 9.0), _row("b", "x", 2.0)]
    (board,) = boards(rows)
    assert [line["subject"] for line in board.rows] == ["a", "b"]
    assert "on one case" in board.caption


def test_a_case_of_no_tier_is_taken_at_the_second_interval_that_all_share() -> None:
    ladders = {"a": (0.04, 0.02, 0.01, 0.005), "b": (0.02, 0.01, 0.005)}
    rows = [_row(name, "mine", 1.0, interval=h) for name, steps in ladders.items() for h in steps]
    assert {row["interval"] for row in own_interval(rows)} == {0.01}


def test_a_dataset_without_a_board_gets_one_of_its_largest_errors() -> None:
    rows = [{"subject": "a", "dataset": "new", "case": "x", "interval": 1.0, "status": "ok", "tilt_max": 2.0}]
    assert worst("new", rows) == [{"rank": 1, "subject": "a", "tilt max": 2.0, "cases": 1}]


def test_boards_hold_every_subject(results) -> None:
    by_name = {table.name: table for table in boards(own_interval(results.scores))}
    assert {line["subject"] for line in by_name["leaderboard_dual_precession"].rows} == set(PRECESSION)
    assert {line["subject"] for line in by_name["leaderboard_equator_errors"].rows} == set(EQUATOR)


def test_errors_over_time_end_where_the_scores_do(results) -> None:
    own = own_interval(results.scores)
    rows = error_series(own)
    for subject in PRECESSION:
        (line,) = (row for row in own if row["subject"] == subject)
        series = [row for row in rows if row["subject"] == subject]
        assert {row["case"] for row in series} == {CASE}
        assert [row["time"] for row in series] == sorted({row["time"] for row in series})
        # Run again on the same increments: the same numbers, at the last instant.
        assert series[-1]["attitude_error"] == pytest.approx(line["attitude_error_end"], rel=1e-6)
        assert series[-1]["velocity_error"] == pytest.approx(line["velocity_error_end"], rel=1e-6)


def test_a_row_of_other_code_or_another_case_of_the_same_name_has_no_series(results) -> None:
    own = [dict(row) for row in own_interval(results.scores) if row["subject"] in PRECESSION]
    own[0]["attitude_error_max"] *= 10
    assert {row["subject"] for row in error_series(own)} == {own[1]["subject"]}
    own[1]["subject"] = "mine.py:mine"
    assert error_series(own) == []


def test_gyroscopic_systems_have_their_schuler_period_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    target = "sinsbench.subjects.gyroscopic.subjects:ghc"
    monkeypatch.setitem(BUILT_IN, "ghc", Subject("ghc", "gyro_systems", target, ""))
    (case,) = (case for case in cases_of("gyro_systems", "paper") if case.name == "TP_0.125")
    names = {"subject": "ghc", "dataset": "gyro_systems", "case": case.name, "interval": 10.0, "status": "ok"}
    made = sections(Results(scores=[{**names, "vertical_error_max_m": None}]))
    (section,) = (section for section in made if section.name == "growth_gyro_systems")
    (chart,) = section.charts
    (line,) = chart.specification["datasets"]["periods"]
    assert line["time"] == pytest.approx(2 * np.pi * np.sqrt(float(case.radius) / float(case.gravity)), rel=1e-15)
    assert line["label"] == "Schuler period"
    assert len(section.data["series_gyro_systems"]) == 64


def test_the_stability_map_is_that_of_the_literal_formulas() -> None:
    rows = stability_map()
    assert len({row["height"] for row in rows}) > 10
    for row in rows[::97]:
        constants = modal_constants(float(row["speed"]), 1000.0 * row["height"])
        # The literal (17) in binary64 loses digits to cancellation, six at most on this map.
        assert row["beta3"] == pytest.approx(constants.beta3, rel=1e-9)
        assert row["mu"] == pytest.approx(constants.mu, rel=1e-9)
        assert row["growth_time"] == pytest.approx(1 / row["beta3"] / 60, rel=1e-15)


def test_the_limits_of_the_map_are_where_the_specific_force_or_the_rate_of_the_frame_vanishes() -> None:
    for row in stability_limits():
        motion = EquatorMotion.at(row["speed"], 1000.0 * row["height"])
        # Units: g = 9.8 m/s^2, u = 7e-5 rad/s; the speed is rounded to 1e-12 of it.
        vanishing = motion.inertial_rate if row["limit"].startswith("omega") else motion.specific_force
        assert abs(vanishing) < 1e-13


def test_a_subject_that_declines_every_case_is_told_and_breaks_nothing() -> None:
    case = next(case for case in cases_of("dual_precession", "short") if case.name == CASE)
    rows = score(["panov2"], [replace(case, duration=case.interval)], factors=[Fraction(1)], repetitions=0)
    assert {row["status"] for row in rows} == {"not applicable"}
    names = [section.name for section in sections(Results(scores=rows))]
    assert names == ["failures", "machine"]
