"""The errors along the equator by a matrix exponential and by integrators."""

import pytest

from equator_errors import FIGHTER, MOTIONS, SHIP, end_state, state_error
from sinsbench.subjects import equator_numerical

every_motion = pytest.mark.parametrize("name", MOTIONS)


# Numerical subjects: bounds are a few times the errors measured; DOP853 is limited by rounding, the others
# by the smallest tolerance SciPy accepts, the exponential by its squarings.
NUMERICAL = {
    equator_numerical.expm: 6e-13,
    equator_numerical.rk45: 3e-13,
    equator_numerical.dop853: 3e-13,
    equator_numerical.lsoda: 3e-12,
    equator_numerical.radau: 1e-13,
}


@pytest.mark.parametrize("subject", NUMERICAL, ids=lambda subject: subject.__name__)
def test_numerical_subjects(subject):
    for motion, misaligned in ((FIGHTER, False), (FIGHTER, True), (SHIP, False)):
        if subject is equator_numerical.radau and (motion is SHIP or misaligned):
            continue  # 10,000 implicit steps a run
        state = end_state(subject, motion, misaligned=misaligned)
        assert state_error(state, motion, 7200.0, misaligned=misaligned) < NUMERICAL[subject]


@every_motion
def test_exponential_at_every_speed(name):
    for misaligned in (False, True):
        state = end_state(equator_numerical.expm, MOTIONS[name], misaligned=misaligned)
        assert state_error(state, MOTIONS[name], 7200.0, misaligned=misaligned) < 6e-13


@pytest.mark.parametrize("subject", [equator_numerical.rk45, equator_numerical.dop853])
def test_integrators_beyond_the_stability_limit(subject):
    motion = (8000.0, 0.0)
    assert state_error(end_state(subject, motion, misaligned=True), motion, 7200.0, misaligned=True) < 3e-13
