"""Secular and periodic parts: planted ones are recovered, and those of the nested algorithms are the theory's."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.scoring.integrators import ladder, score_integrator
from sinsbench.scoring.secular import frequencies_of, secular_parts
from sinsbench.subjects.integrators import panov6
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import Subject
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

CASES = {case.name: case for case in paper_cases("dual_precession")}
NU = 2 * np.pi
vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


def test_frequencies_of_a_precession():
    assert frequencies_of(CASES["variant2_general"].motion) == pytest.approx([NU / 2, NU, 1.5 * NU])
    assert frequencies_of(CASES["variant2_coning"].motion) == pytest.approx([NU, 2 * NU])


@given(vectors, vectors, vectors, vectors, st.floats(2.5, 40))
@settings(derandomize=True, deadline=None, max_examples=60)
def test_planted_parts_are_recovered_whatever_the_duration(constant, rate, cosine, sine, duration):
    """Two frequencies, no whole number of periods: the fit is exact but for rounding and the conditioning."""
    t = np.arange(0, duration, 0.07)[:, None]
    wave = cosine * np.cos(NU * t) + sine * np.sin(NU / 2 * t)
    parts = secular_parts(t[:, 0], constant + rate * t + wave, [NU / 2, NU])
    assert parts.rate == pytest.approx(rate, abs=1e-11)
    assert parts.periodic == pytest.approx(wave, abs=1e-11)


@given(vectors, vectors, vectors, st.floats(8.0, 60))
@settings(derandomize=True, deadline=None, max_examples=40)
def test_oscillations_that_grow_do_not_leak(rate, linear, quadratic, duration):
    """Amplitudes of t and t^2, as the transport of an attitude error makes them, and a secular part of degree 2."""
    t = np.arange(0, duration, 0.07)[:, None]
    wave = (linear * t + quadratic * t**2) * np.cos(NU * t)
    secular = rate * t + 0.01 * t**2
    parts = secular_parts(t[:, 0], secular + wave, [NU], growth=2)
    end = float(t[-1, 0])
    assert parts.rate == pytest.approx(rate + 0.01 * end, abs=1e-10 * end**2)
    assert parts.periodic == pytest.approx(wave, abs=1e-10 * end**2)


def test_a_period_that_the_run_does_not_complete_counts_as_secular():
    t = np.linspace(0, 0.5, 40)
    slow = np.sin(NU * t)[:, None] * [1.0, 0, 0]
    parts = secular_parts(t, slow, [NU])
    line = np.polyfit(t, slow[:, 0], 1)
    assert parts.rate[0] == pytest.approx(line[0])


def test_frequencies_too_near_to_be_told_apart_count_once():
    t = np.linspace(0, 20, 300)
    error = np.sin(NU * t)[:, None] * np.ones(3) + 0.3 * t[:, None]
    parts = secular_parts(t, error, [NU, NU * (1 + 1e-9)])
    assert parts.rate == pytest.approx([0.3] * 3, rel=1e-9)


@pytest.mark.parametrize(("instants", "found"), [(2, False), (3, False), (4, True), (5, True), (9, True)])
def test_few_instants(instants, found):
    """A straight line has two unknowns and takes four instants; with few, frequencies are given up, not the fit."""
    t = np.linspace(0, 10, instants)
    parts = secular_parts(t, np.outer(t, [1.0, 2.0, 0.0]), [NU / 2, NU])
    assert (parts is not None) == found
    if found:
        assert parts.rate == pytest.approx([1.0, 2.0, 0.0], abs=1e-12)


def test_secular_drift_is_the_theory_s_between_whole_periods():
    """After 8.64 periods of precession the error at the end holds a piece of a period; the secular part does not.

    The asymptotic drift neglects two powers of h: halving h brings the secular drift four times nearer to it, while
    the drift at the end stays away by the piece of a period.
    """
    case = replace(CASES["variant2_general"], duration=ExactNumber("17.28"))
    rungs = ladder(case, (Fraction(1), Fraction(1, 2)))
    for name in ("panov2", "panov4", "panov6"):
        coarse, fine = score_integrator(resolve(name), case, rungs, 0)
        distances = [
            [row[field] / row["predicted_secular_drift_deg_per_h"] - 1 for row in (coarse, fine)]
            for field in ("secular_drift_deg_per_h", "drift_deg_per_h")
        ]
        secular, plain = np.array(distances)
        assert abs(secular[1]) < 2e-3
        assert secular[0] / secular[1] == pytest.approx(4, rel=0.05)
        assert plain.min() > 0.03
        assert plain[1] == pytest.approx(plain[0], rel=0.15)
        assert 0 < fine["attitude_periodic_max"] < fine["attitude_error_max"]


def test_secular_velocity_error_of_a_planted_accelerometer_bias():
    """A bias along an axis that is nearly at rest: what it gains, times the cosine of the nutation angle."""
    case = replace(CASES["variant2_coning"], duration=ExactNumber("13.2"))
    bias = np.array([0, 0, 2e-3])

    def biased(angle, velocity, interval, attitude0, velocity0):
        return panov6(angle, velocity + bias * interval, interval, attitude0, velocity0)

    subject = LoadedSubject(Subject("mine", None, "mine", ""), biased)
    [row] = score_integrator(subject, case, ladder(case, (Fraction(1),)), 0)
    # The algorithm's own secular velocity error is 1.4e-6 m/s^2 on this motion.
    assert row["secular_velocity_rate"] == pytest.approx(2e-3 * np.cos(np.pi / 18), abs=3e-6)
    assert row["velocity_periodic_max"] < 1e-3


def test_truth_has_no_less_than_the_inputs_leave():
    case = replace(CASES["variant2_general"], duration=ExactNumber("5.12"))
    rungs = ladder(case, (Fraction(1),))

    def oracle(*_):
        return {"attitude": rungs[0].motion.attitude, "velocity_inertial": rungs[0].motion.velocity_inertial}

    [row] = score_integrator(LoadedSubject(Subject("mine", None, "mine", ""), oracle), case, rungs, 0)
    time = float(rungs[0].motion.time[-1])
    parts = secular_parts(rungs[0].motion.time, rungs[0].inputs.attitude, frequencies_of(case.motion))
    floor = np.linalg.norm(parts.rate) * np.degrees(1) * 3600
    assert row["secular_drift_deg_per_h"] >= floor > 0
    assert row["secular_drift_deg_per_h"] * time < 1e-9
