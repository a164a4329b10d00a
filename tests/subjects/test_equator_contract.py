"""What every equator subject accepts, returns and refuses, and the forcing they share."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from equator_errors import EPS, FIGHTER, INITIAL
from sinsbench.subjects import equator_formulas, equator_numerical, equator_robust
from sinsbench.subjects.equator_model import EquatorMotion, NotApplicableError, forcing

SUBJECTS = [
    equator_formulas.corrected,
    equator_formulas.general_solution,
    equator_formulas.amplitude_phase,
    equator_formulas.printed,
    equator_formulas.amplitude_phase_printed,
    equator_robust.robust,
    equator_numerical.expm,
    equator_numerical.rk45,
    equator_numerical.dop853,
    equator_numerical.lsoda,
]  # without radau: 10,000 implicit steps a run


@pytest.mark.parametrize("subject", SUBJECTS, ids=lambda subject: subject.__name__)
def test_any_ascending_instants(subject):
    time = np.array([0.0, 0.0, 100.0, 250.0])
    errors = subject(time, *FIGHTER, INITIAL)
    assert errors.shape == (4, 6)
    assert errors.dtype == np.float64
    np.testing.assert_array_equal(errors[0], errors[1])
    late = subject(time[2:], *FIGHTER, INITIAL)
    # The interpolated instants of an integrator do not depend on what else is asked for.
    np.testing.assert_allclose(late, errors[2:], rtol=1e-12)
    assert subject([], *FIGHTER, INITIAL).shape == (0, 6)
    assert subject([0.0], *FIGHTER, INITIAL).shape == (1, 6)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"time": [2.0, 1.0]}, "ascending"),
        ({"time": [-1.0]}, "negative"),
        ({"time": [np.nan]}, "finite"),
        ({"time": 1.0}, "shape"),
        ({"v_east": np.inf}, "v_east"),
        ({"height": -6378245.0}, "height"),
        ({"height": np.nan}, "height"),
        ({"initial_errors": [0.0]}, "initial_errors"),
        ({"initial_errors": [np.nan] * 6}, "initial_errors"),
        ({"misalignment": np.zeros((3, 2))}, "misalignment"),
        ({"inertial_longitude": np.nan}, "inertial_longitude"),
    ],
)
def test_bad_arguments(changes, sentence):
    arguments = {"time": [1.0], "v_east": 600.0, "height": 0.0, "initial_errors": INITIAL} | changes
    with pytest.raises(ValueError, match=sentence):
        equator_robust.robust(**arguments)


@pytest.mark.parametrize("subject", [equator_formulas.corrected, equator_robust.robust, equator_numerical.expm])
def test_overflow_is_reported(subject):
    with pytest.raises(NotApplicableError, match="range of float64"):
        subject([5e5], *FIGHTER, INITIAL)


@settings(max_examples=30)
@given(
    misalignment=st.lists(st.floats(-1e-2, 1e-2), min_size=9, max_size=9),
    angle=st.floats(-10, 10),
    v_east=st.floats(-9000, 9000),
)
def test_forcing_is_the_printed_one(misalignment, angle, v_east):
    (_, l12, l13), (_, l22, l23), (_, l32, l33) = matrix = np.reshape(misalignment, (3, 3))
    motion, c, s = EquatorMotion.at(v_east, 0.0), np.cos(angle), np.sin(angle)
    north = l12 * c + l13 * s
    up = l22 * c**2 + (l32 + l23) * c * s + l33 * s**2
    east = l32 * c**2 + (l33 - l22) * c * s - l23 * s**2
    expected = motion.specific_force * np.array([north, up, east, 0, 0, 0])
    # A few roundings of terms no larger than 3 max|Lambda| a_H; half an ulp of 20 rad in the double angle.
    bound = 16 * EPS * abs(motion.specific_force) * np.abs(matrix).max() * 3
    np.testing.assert_allclose(forcing(motion, matrix, angle), expected, atol=bound)
