"""The mast's equations: against matrices, against a motion, under the change of gauge that nothing can observe."""

import numpy as np
import pytest

from mast_equations import CONSTANTS, NAMES, SENSORS, STATE, TIME, disagreements, expected
from mast_motion import STEP, motion, points, product, simulated
from mast_python import python_modules
from sinsbench.subjects.mast.terms import CORRECTED, VARIANTS

PYTHON = python_modules()
MODEL = PYTHON["model"]
EARTH = MODEL.Constants()


@pytest.mark.parametrize("name", NAMES)
def test_equations_derivatives_and_noise(name):
    assert disagreements(name, expected(name)) == []


def test_the_variants_use_every_coefficient():
    differing = {
        field
        for name in NAMES
        for field in CORRECTED._fields
        if getattr(VARIANTS[name].terms, field) != getattr(CORRECTED, field)
    }
    assert differing | {"mast_x"} == set(CORRECTED._fields)  # mast_x is right in every form


@pytest.fixture(scope="module")
def quiet():
    """A motion without noise of the sensors; the antenna still turns on the mast at random."""
    return simulated(2.0, quiet=True)


def state_of(truth, k):
    names = ("mu", "longitude", "latitude", "velocity", "height", "eta", "lambda", "mast_rate")
    return np.concatenate([np.atleast_1d(truth[name][k]) for name in names])


def sensors_of(inputs, k):
    arrays = (inputs.rate1, inputs.specific_force1, inputs.rate2, inputs.specific_force2)
    return MODEL.Sensors(*(tuple(a[k, 0]) for a in arrays))


def test_values_at_the_start(quiet):
    """To the digits that two independent programs agree on."""
    y, sensors = state_of(quiet.truth, 0), sensors_of(quiet.inputs, 0)
    assert np.allclose(sensors.force1, (-0.010157918812, 0.036962429660, 9.791491502946), rtol=0, atol=1e-12)
    assert np.allclose(sensors.force2, (0.228397847689, 0.314175612945, 7.925138769713), rtol=0, atol=1e-12)
    shown = MODEL.antenna_rate(y, sensors, CORRECTED, EARTH)
    assert np.allclose(shown, (0.541722884248, 0.279718908502, -0.004432708935), rtol=0, atol=1e-12)
    position, speed = (tuple(a[0, 0]) for a in (quiet.inputs.satellite_position, quiet.inputs.satellite_velocity))
    assert abs(MODEL.satellite_range_rate(y, position, speed, EARTH) - 87.77324125363) < 1e-9
    assert abs(MODEL.satellite_range(y, position, CORRECTED, EARTH) - 20327374.2785) < 1e-4
    assert abs(MODEL.mast_constraint(y, sensors, CORRECTED, EARTH)) < 1e-13


def test_a_motion_obeys_the_equations():
    """Differences of order 8 of an independent motion; steps of 5 ms leave 1e-9 of what turns at 7 rad/s."""
    t, mu, lam, lat, height, v, w, _, f1, f2, *_ = motion(2.0)
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / (STEP / 2)
    still = np.array([0.9, 0.1, -0.3, 0.2]) / np.linalg.norm([0.9, 0.1, -0.3, 0.2])
    columns = (
        mu,
        np.full((len(t), 1), np.pi / 6),
        lat[:, None],
        v,
        height[:, None],
        np.tile(still, (len(t), 1)),
        lam,
        w[:, :2],
    )
    states = np.hstack(columns)
    from_mast = np.linalg.inv(np.array([MODEL.back(tuple(still), tuple(x)) for x in np.eye(3)]).T)
    rate1 = np.stack([1e-1 * np.cos(3 * t), 1e-3 * np.cos(4 * t), 1.5e-2 * np.cos(7 * t)], axis=-1)
    for k in (10, 77, 300):
        sensors = MODEL.Sensors(tuple(rate1[k]), tuple(f1[k]), (0.0, 0.0, 0.0), tuple(from_mast @ f2[k]))
        out = np.zeros(20)
        MODEL.state_rates(states[k], t[k], sensors, 0.0, CORRECTED, EARTH, out)
        slope = weights @ states[k - 4 : k + 5]
        scale = np.maximum(1.0, np.abs(states[k]))  # differences of numbers lose that much
        assert np.abs((slope - out) / scale).max() < 1e-9
        assert abs(MODEL.mast_constraint(states[k], sensors, CORRECTED, EARTH)) < 1e-12


def turned(state, angle):
    """The same motion, the mast's axes turned about the mast."""
    half = np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
    c, s = np.cos(angle), np.sin(angle)
    result = state.copy()
    result[14:18] = product(state[14:18], half)
    result[10:14] = product(half * [1, -1, -1, -1], state[10:14])
    result[18:] = [c * state[18] + s * state[19], c * state[19] - s * state[18]]
    return result


@pytest.mark.parametrize("angle", [0.3, -2.0])
def test_the_twist_of_the_mast_is_a_gauge(angle):
    """It changes nothing that is measured, and rates only by turning them along: rounding of numbers below 100."""

    def rates(y):
        out = np.zeros(20)
        MODEL.state_rates(y, TIME, SENSORS, 1.0, CORRECTED, CONSTANTS, out)
        return out

    other = turned(STATE, angle)
    for function in (MODEL.antenna_rate, MODEL.mast_constraint):
        values = [np.array(function(y, SENSORS, CORRECTED, CONSTANTS)) for y in (STATE, other)]
        assert np.abs(values[0] - values[1]).max() < 1e-14
    assert np.abs(turned(rates(STATE), angle) - rates(other)).max() < 1e-13


def test_points_of_a_step():
    assert points(np.arange(5)).tolist() == [[0, 1, 2], [2, 3, 4]]
