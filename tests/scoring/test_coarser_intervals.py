"""Orders that the ladder hides below its floor are seen at coarser intervals; nothing on the ladder itself changes."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from sinsbench.scoring.convergence import convergence
from sinsbench.scoring.integrators import LADDER, ladder, score_integrator
from sinsbench.scoring.ladders import coarser_rungs
from sinsbench.subjects.integrators import panov2
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import Subject
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

CASES = {case.name: case for case in paper_cases("dual_precession")}


@pytest.fixture(scope="module")
def case():
    """Ten seconds of coning."""
    return replace(CASES["variant1_coning"], duration=ExactNumber("10"))


@pytest.fixture(scope="module")
def rungs(case):
    return ladder(case, LADDER[:4])


def user(function, samples_per_step=None):
    return LoadedSubject(Subject("mine", None, "mine", "", samples_per_step=samples_per_step), function)


@pytest.mark.parametrize(("name", "order"), [("taylor6", 8), ("taylor8", 10)])
def test_high_orders_are_observed(case, rungs, name, order):
    found = score_integrator(resolve(name), case, rungs, 0)
    assert len(found) > len(rungs)
    assert [row["interval"] for row in found] == sorted((row["interval"] for row in found), reverse=True)
    for row in found:
        assert row["order_points"] >= 3
        # The slope of a power law is reached as h -> 0; these intervals are coarse.
        assert row["observed_order"] == pytest.approx(order, abs=0.25)
        assert row["secular_observed_order"] == pytest.approx(order, abs=0.25)
        assert row["order_note"] is None
        assert 1 < row["rate_needed_hz"] < 100
        assert row["rate_needed_note"] is None


def test_what_shows_its_order_is_not_run_at_other_intervals(case, rungs):
    found = score_integrator(resolve("panov2"), case, rungs, 0)
    assert [row["interval"] for row in found] == [rung.motion.interval for rung in rungs]
    assert found[0]["rate_needed_note"].startswith("extrapolated from 0.0025 s along order")
    # Second order: the drift falls by the square of the rate.
    last = found[-1]
    expected = np.sqrt(last["drift_deg_per_h"] / 1e-3) / last["interval"]
    assert last["rate_needed_hz"] == pytest.approx(expected, rel=0.02)


def test_the_ladder_s_own_rows_do_not_change(case, rungs, monkeypatch):
    """Coarser rungs have checkpoints of their own."""
    extended = score_integrator(resolve("taylor8"), case, rungs, 0)
    monkeypatch.setattr("sinsbench.scoring.integrators.coarser_rungs", lambda *_: ())
    alone = score_integrator(resolve("taylor8"), case, rungs, 0)
    assert len(alone) == len(rungs) < len(extended)
    for row, other in zip(extended[-len(rungs) :], alone, strict=True):
        for field in ("attitude_error_max", "drift_deg_per_h", "velocity_error_end", "secular_drift_deg_per_h"):
            assert row[field] == other[field]
    assert alone[0]["observed_order"] is None


def test_an_exact_subject_has_no_order_at_any_interval(case, rungs):
    motions = {}
    for rung in (*rungs, *coarser_rungs(case, rungs)):
        motions[rung.motion.samples] = rung.motion

    def oracle(angle, *_):
        motion = motions[len(angle)]
        every = motion.samples // (len(motion.attitude) - 1)
        return {"attitude": motion.attitude} if every else None

    for row in score_integrator(user(oracle), case, rungs, 0):
        assert row["observed_order"] is None
        assert "above the floor; an order takes 3" in row["order_note"]
        assert row["rate_needed_hz"] is None
        assert row["rate_needed_note"].startswith("at most 0.001 at every interval up to")


def test_a_subject_that_fails_at_coarser_intervals_has_no_rows_there(case, rungs):
    def only_fine(angle, *rest):
        if len(angle) < 450:
            raise MemoryError("too coarse")
        return resolve("taylor8").function(angle, *rest)

    found = score_integrator(user(only_fine, samples_per_step=8), case, rungs, 0)
    assert [row["status"] for row in found] == ["ok"] * len(rungs)
    assert found[0]["observed_order"] is None


def test_coarser_intervals_divide_the_duration(case):
    rungs = ladder(case, (Fraction(2), Fraction(1)))
    factors = [rung.factor for rung in coarser_rungs(case, rungs)]
    assert factors == [Fraction(5, 2), 4, 5, 8, 10]
    odd = replace(case, duration=ExactNumber("0.09"))
    assert [rung.factor for rung in coarser_rungs(odd, ladder(odd, (Fraction(1),)))] == [Fraction(3, 2), 3]


def test_intervals_left_out_do_not_bend_the_slope():
    intervals = [0.16 / 2**k for k in range(6)]
    errors = [(h**4) * (1 + (h / 0.08) ** 4) for h in intervals]
    bent, straight = (convergence(intervals, errors, [0.0] * 6, [0.0] * 6, left_out) for left_out in (0, 2))
    assert (bent.points, straight.points) == (6, 4)
    assert abs(bent.order - 4) > 0.5
    assert straight.order == pytest.approx(4, abs=0.05)
    assert len(straight.local_orders) == 6


def test_one_rung_has_no_order_and_says_so(case):
    [row] = score_integrator(user(panov2), case, ladder(case, (Fraction(1),)), 0)
    assert row["observed_order"] is None
    assert row["order_note"] == "errors at 1 of 1 intervals are above the floor; an order takes 3"
    assert row["rate_needed_note"] == "above 0.001 at every interval, and no order to extrapolate along"
