"""The robust closed form of the errors along the equator, at every speed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from equator_errors import (
    EPS,
    FIGHTER,
    GENERAL,
    INITIAL,
    LONGITUDE,
    MOTIONS,
    SHIP,
    as_floats,
    end_state,
    exact_matrix,
    matrix_error,
    scales,
    state_error,
)
from sinsbench.subjects import equator_robust
from sinsbench.subjects.equator_model import EquatorMotion, NotApplicableError, particular_solution

every_motion = pytest.mark.parametrize("name", MOTIONS)


@every_motion
def test_robust_matrix_is_accurate_at_every_speed(name):
    # 30 eps after 7200 s: the rounding of rho enters the exponent, beta3 t = 12.5, and cosh and cos of it.
    for time, tolerance in ((1.0, 2 * EPS), (3600.0, 30 * EPS), (7200.0, 30 * EPS)):
        matrix = equator_robust.transition_matrix([time], *MOTIONS[name])[0]
        assert matrix_error(matrix, MOTIONS[name], time) < tolerance


@pytest.mark.parametrize("motion", [FIGHTER, SHIP])
def test_robust_matrix_after_a_day(motion):
    # The exponent is 150 by then; 1e-15 and 9e-15 are the known errors.
    assert matrix_error(equator_robust.transition_matrix([86400.0], *motion)[0], motion, 86400.0) < 2e-14


def test_robust_keeps_every_element_at_early_instants():
    # Elements of P(1 s) are as small as t^3: no difference may cancel.  The worst measured is 1.6 eps.
    for motion in (FIGHTER, SHIP):
        matrix = equator_robust.transition_matrix([1.0], *motion)[0]
        exact = as_floats(exact_matrix(motion, 1.0))
        np.testing.assert_allclose(matrix, exact, rtol=4 * EPS, atol=0)


@every_motion
def test_robust_under_misalignment(name):
    # Near 2 omega_N = +-mu the answer comes from the exponential, which is good to 3e-13.
    tolerance = 3e-13 if name.startswith("2 omega_N") else 3e-14
    for time in (1.0, 7200.0):
        state = end_state(equator_robust.robust, MOTIONS[name], time, misaligned=True)
        assert state_error(state, MOTIONS[name], time, misaligned=True) < tolerance


@settings(deadline=None, max_examples=60)
@given(
    v_east=st.floats(-12000, 12000),
    height=st.floats(-5000, 1e6),
    first=st.floats(0, 4000),
    second=st.floats(0, 4000),
)
def test_robust_semigroup(v_east, height, first, second):
    matrices = equator_robust.transition_matrix(sorted([first, second]), v_east, height)
    whole = equator_robust.transition_matrix([first + second], v_east, height)[0]
    scale = scales(v_east, height)
    weight = scale / scale[:, None]
    left, right = matrices * weight
    # Factors of norm up to 4e4 may cancel: the tolerance, the error of either factor, scales with both.
    bound = 200 * EPS * np.linalg.norm(left) * np.linalg.norm(right)
    assert np.linalg.norm(left @ right - whole * weight) < bound


def test_small_rotation_about_north_is_an_offset_of_longitude():
    offset = 1e-5
    rotation = np.zeros((3, 3))
    rotation[2, 1], rotation[1, 2] = offset, -offset
    time = np.array([60.0, 3600.0, 7200.0])
    shifted = equator_robust.robust(time, *FIGHTER, np.array(INITIAL) - offset * np.eye(6)[5])
    expected = shifted + offset * np.eye(6)[5]
    actual = equator_robust.robust(time, *FIGHTER, INITIAL, rotation, LONGITUDE)
    # Cancellation with the offset itself: eps of its response.
    np.testing.assert_allclose(actual / scales(*FIGHTER), expected / scales(*FIGHTER), rtol=1e-12, atol=1e-20)


@pytest.mark.parametrize(("v_east", "height"), [(3644.262041013479, 0.0), (-3871.1515824743283, 46723971.494846754)])
def test_particular_solution_refuses_to_divide_by_zero(v_east, height):
    # Places, found by search, where 2 omega_N = mu or a_24 + 2 omega_N v/R = 0 holds exactly in float64.
    with pytest.raises(NotApplicableError, match="divides by zero"):
        particular_solution(EquatorMotion.at(v_east, height), GENERAL, 0.0)
    assert np.isfinite(equator_robust.robust([7200.0], v_east, height, INITIAL, GENERAL)).all()
