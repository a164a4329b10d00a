"""Error functions against mpmath in fifty digits."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsbench.scoring.errors import attitude_error_vectors, difference

MP = mpmath.MPContext()
MP.dps = 50
EPS = np.finfo(np.float64).eps

unit_interval = st.floats(-1, 1, allow_subnormal=False)


def product(a, b):
    a0, a1, a2, a3 = a
    b0, b1, b2, b3 = b
    return [
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 + a2 * b0 + a3 * b1 - a1 * b3,
        a0 * b3 + a3 * b0 + a1 * b2 - a2 * b1,
    ]


def pair(values):
    high = np.array([float(x) for x in values])
    return high, np.array([float(x - MP.mpf(h)) for x, h in zip(values, high.tolist(), strict=True)])


def unit(vector):
    norm = MP.sqrt(sum(MP.mpf(x) ** 2 for x in vector))
    return [MP.mpf(x) / norm for x in vector]


def exact_rotation_vector(computed, truth):
    error = product([MP.mpf(x) for x in computed.tolist()], [truth[0], *(-x for x in truth[1:])])
    if error[0] < 0:
        error = [-x for x in error]
    sine = MP.sqrt(sum(x * x for x in error[1:]))
    angle = 2 * MP.atan2(sine, error[0])
    return np.array([float(angle * x / sine) if sine else 0.0 for x in error[1:]])


@given(
    st.tuples(*[unit_interval] * 4).filter(lambda q: sum(x * x for x in q) > 0.01),
    st.tuples(*[unit_interval] * 3).filter(lambda v: sum(x * x for x in v) > 0.01),
    st.floats(-20, 0.49),
    st.sampled_from([1.0, -1.0]),
)
@settings(max_examples=200, deadline=None)
def test_attitude_error_is_right_from_a_millionth_of_an_ulp_to_half_a_turn(given, axis, magnitude, sign):
    truth = unit(given)
    angle = MP.mpf(10) ** magnitude
    rotation = [MP.cos(angle / 2), *(MP.sin(angle / 2) * x for x in unit(axis))]
    computed = sign * pair(product(rotation, truth))[0]
    high, low = pair(truth)
    found = attitude_error_vectors(computed[None], high[None], low[None])[0]
    expected = exact_rotation_vector(computed, truth)
    # Some ten roundings, relative to the error and to the rounding (EPS) of the quaternion itself.
    assert np.linalg.norm(found - expected) <= 20 * EPS * (np.linalg.norm(expected) + EPS)


def test_the_vector_lies_in_inertial_axes():
    turn = np.array([np.cos(0.5), 0, 0, np.sin(0.5)])
    truth = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])  # body y is inertial z
    computed = np.array([float(x) for x in product(turn, truth)])
    found = attitude_error_vectors(computed[None], truth[None], np.zeros((1, 4)))[0]
    assert found == pytest.approx([0, 0, 1], abs=1e-15)


def test_norm_and_sign_of_the_computed_quaternion_do_not_matter():
    truth = np.array([[0.5, 0.5, 0.5, 0.5]])
    for factor in (-1.0, 3.0, -0.25):
        assert attitude_error_vectors(factor * truth, truth, np.zeros((1, 4))) == pytest.approx(np.zeros((1, 3)))


def test_a_zero_quaternion_is_no_attitude():
    truth = np.array([[0.5, 0.5, 0.5, 0.5]])
    assert np.isnan(attitude_error_vectors(np.zeros((1, 4)), truth, np.zeros((1, 4)))).all()


def test_shapes_are_checked():
    with pytest.raises(ValueError, match="three"):
        attitude_error_vectors(np.zeros((4, 5)), np.zeros((5, 4)), np.zeros((5, 4)))


@given(st.floats(-1e6, 1e6), st.integers(-3, 3), st.floats(-0.5, 0.5))
def test_difference_sees_below_the_ulp(high, steps, part):
    ulp = float(np.spacing(abs(high)))
    computed, low = high + steps * ulp, part * ulp
    exact = MP.mpf(computed) - MP.mpf(high) - MP.mpf(low)
    assert float(difference(computed, high, low)) == pytest.approx(float(exact), rel=4 * EPS)
