"""Difficulty: known conditions, strata that are indeed hard, and the loss of binary64 measured otherwise."""

from __future__ import annotations

from functools import cache
from statistics import median

import numpy as np
import pytest

from sinsbench.subjects.equator_formulas import transition_matrix
from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.tiers import standard_cases, stratum_of
from sinsdata.tiers.difficulty import difficulty as computed_difficulty
from sinsdata.truth.formulas import equator_state
from sinsref.arithmetic import MpArithmetic

#: Each case once, however many tests ask for it.
difficulty = cache(computed_difficulty)


def _cases(dataset: str, stratum: str) -> list[Case]:
    return [c for c in standard_cases(dataset) if (s := stratum_of(dataset, c.name)) and s.name == stratum]


def _lost(dataset: str, stratum: str) -> list[float]:
    lost = (difficulty(case).digits_lost for case in _cases(dataset, stratum))
    return [digits for digits in lost if digits is not None]


def _turning(**changes: object) -> DualPrecessionCase:
    """Return a rotation about a fixed axis at (1 + eps) nu, without force: q = (cos, 0, 0, sin) of half the angle."""
    given = {
        "name": "turning", "spin_rate": "3", "precession_ratio": "1/4", "nutation": "0", "spin_rate_dual": "0",
        "nutation_dual": "0", "initial_velocity": ["0", "0", "0"], "interval": "1/10", "duration": "16",
    }  # fmt: skip
    return DualPrecessionCase.from_mapping({**given, **changes})


def test_the_condition_of_a_rotation_about_a_fixed_axis_is_half_its_angle() -> None:
    # |dq| = (1 + eps) nu t / 2 per relative change of nu or of the interval; of eps, a fifth of that.
    assert difficulty(_turning()).condition == 30
    assert difficulty(_turning(duration="4")).condition == 7.5
    # With eps = -11/10 the angle is nu t / 20 only, but eps moves it by 11/10 nu t / 2 = 26.4.
    assert difficulty(_turning(precession_ratio="-11/10")).condition == 26


def test_the_condition_of_an_oscillation_is_its_phase() -> None:
    # The rate is sqrt(g / R) at height and speed 0: the interval alone has a relative change. It changes dphi by
    # w t sin(w t) and dv_N by w t cos(w t), in units of their largest values at the three epochs.
    given = {"name": "north", "v_east": "0", "height": "0", "duration": "7200", "interval": "60"}
    case = EquatorCase.from_mapping({**given, "initial_errors": ["0", "0", "0", "0", "1e-6", "0"]})
    phases = (9.78049 / 6378245) ** 0.5 * np.array([60, 3600, 7200])
    latitude = np.max(np.abs(phases * np.sin(phases))) / np.max(np.abs(np.cos(phases)))
    velocity = np.max(np.abs(phases * np.cos(phases))) / np.max(np.abs(np.sin(phases)))
    assert difficulty(case).condition == float(f"{max(latitude, velocity):.1e}")


@pytest.mark.parametrize(
    "hard", ["stability_limit", "vanishing_frame_rate", "schuler_resonance", "double_rate_resonance"]
)
def test_next_to_its_poles_the_literal_form_loses_digits(hard: str) -> None:
    ordinary = [median(_lost("equator_errors", stratum)) for stratum in ("ship", "missile")]
    assert median(_lost("equator_errors", hard)) > max(ordinary) + 2


def test_the_loss_grows_toward_the_pole() -> None:
    """A decade nearer costs about a digit, where the frame rate vanishes."""
    lost = [difficulty(case).digits_lost or 0 for case in _cases("equator_errors", "vanishing_frame_rate")[1:13]]
    slope = np.polyfit(range(12), lost, 1)[0]
    assert 0.7 < slope < 1.3


def test_long_durations_are_worse_conditioned_than_short_ones() -> None:
    for dataset, ordinary in (("equator_errors", "ship"), ("dual_precession", "slow_spin")):
        long = [difficulty(case).condition for case in _cases(dataset, "long_duration")]
        assert median(long) > 3 * median(difficulty(case).condition for case in _cases(dataset, ordinary))


def test_cancellation_and_coarse_sampling_are_badly_conditioned() -> None:
    conditions = {
        stratum: median(difficulty(case).condition for case in _cases(dataset, stratum))
        for dataset, stratum in (
            ("equator_errors", "cancellation"), ("equator_errors", "heights"),
            ("dual_precession", "coarse_sampling"), ("dual_precession", "fine_sampling"),
        )
    }  # fmt: skip
    assert conditions["cancellation"] > 100 * conditions["heights"]
    assert conditions["coarse_sampling"] > 100 * conditions["fine_sampling"]


@pytest.mark.parametrize(
    "stratum", ["stability_limit", "vanishing_frame_rate", "schuler_resonance", "equal_roots", "beyond_limit"]
)
def test_where_the_literal_form_is_not_defined_no_loss_is_stated(stratum: str) -> None:
    assert difficulty(_cases("equator_errors", stratum)[0]).digits_lost is None


def test_where_only_binary64_breaks_down_all_digits_are_lost() -> None:
    # 30 digits off the resonance the form is defined; in binary64 its divisor is 0 or left to chance.
    assert all(
        (difficulty(case).digits_lost or 0) >= 15 for case in _cases("equator_errors", "double_rate_resonance")[:2]
    )


def _measured_loss(case: EquatorCase) -> float:
    """Return the digits that the form (22) in numpy loses, against the certified solution."""
    ar = MpArithmetic(80)
    epochs = [1, (case.samples + 1) // 2, case.samples]
    times = [float(case.interval) * epoch for epoch in epochs]
    exact = np.array(
        [[float(x) for x in equator_state(case)(ar, ar.number(case.interval) * epoch)] for epoch in epochs]
    )
    initial = np.array([float(x) for x in case.initial_errors])
    computed = transition_matrix(times, float(case.v_east), float(case.height)) @ initial
    error = np.max(np.abs(computed - exact) / np.max(np.abs(exact), axis=0))
    return float(np.log10(max(error, 2.0**-53) * 2.0**53))


def test_the_loss_agrees_with_that_of_numpy() -> None:
    cases = [
        case
        for stratum in ("ship", "aircraft", "missile", "vanishing_frame_rate", "stability_limit")
        for case in _cases("equator_errors", stratum)
        # Beyond 12 digits the rounded speed itself falls on a side of the pole that is left to chance.
        if (lost := difficulty(case).digits_lost) is not None and lost < 12
    ]
    assert len(cases) > 50
    differences = [
        _measured_loss(case) - (difficulty(case).digits_lost or 0) for case in cases if isinstance(case, EquatorCase)
    ]
    # The two orders of operations round differently: single cases differ by a digit or two, the whole does not.
    assert abs(median(differences)) < 0.5
    assert max(abs(x) for x in differences) < 2.5


def test_both_numbers_have_two_significant_digits_and_repeat() -> None:
    for dataset in ("equator_errors", "dual_precession"):
        for case in standard_cases(dataset)[::40]:
            first = computed_difficulty(case)
            assert first == computed_difficulty(case)
            assert all(x is None or x == float(f"{x:.1e}") for x in (first.condition, first.digits_lost))


def test_the_formulas_of_precession_lose_what_the_phase_loses() -> None:
    exact = difficulty(_turning(interval="1e5", duration="16e5"))
    rounded = difficulty(_turning(spin_rate="3.1", interval="100000.1", duration="1600001.6"))
    assert (exact.condition, exact.digits_lost) == (3e6, 0)  # every phase is a binary64
    # The rounding of a phase of 3e6 is 6.5 digits above that of 1.
    assert rounded.digits_lost is not None
    assert 4.5 < rounded.digits_lost < 7.5
