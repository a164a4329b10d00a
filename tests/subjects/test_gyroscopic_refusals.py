"""What gyroscopic systems refuse: conditions that break, bad inputs, places without angles."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyroscopic_motions import SCHULER_SPEED, R, conjugate, grid, motion, product
from gyroscopic_runs import angles, case, start_of
from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Inputs
from sinsbench.subjects.gyroscopic.drivers import subject
from sinsbench.subjects.gyroscopic.read_out import read_out
from sinsbench.subjects.gyroscopic.systems import SYSTEMS


def test_division_by_h_fails_where_the_vehicle_nearly_stops():
    """T5 passes 0.05 m/s; its trihedron turns by 4 rad/s. Systems that do not divide by h are not disturbed."""
    m = motion("T5", grid(3600.0, 1.0))
    held = Inputs(m.time, 0 * m.rate, m.force_inertial)
    start = replace(start_of(m), attitude=np.array([1.0, 0, 0, 0]))
    for system in ("full", "trad", "bgx"):
        error = R * angles(subject(SYSTEMS[system])(held, start)["vertical"], m.vertical[::2])[-1]
        assert error < 1e-7
    for system, condition in (("ghc", "h > 0"), ("gf", "0 < E < pi/2")):
        with pytest.raises(BrokenConditionError, match=condition) as caught:
            subject(SYSTEMS[system])(held, start)
        assert 1795 < caught.value.time < 1810
        assert caught.value.status == "not applicable"


def test_speed_above_that_of_the_two_rotors_is_refused():
    _, inputs, start = case("T1")
    fast = replace(start, velocity=start.velocity * 7)  # 2100 m/s, above 2B/(m l) = 2000 m/s
    with pytest.raises(BrokenConditionError, match=r"2B/\(m l\)"):
        subject(SYSTEMS["gf"])(inputs, fast)


@pytest.mark.parametrize("system", ["bgx", "bgv"])
def test_speed_above_the_schuler_speed_is_refused(system):
    _, inputs, start = case("T1")
    with pytest.raises(BrokenConditionError, match=r"sqrt\(g R\)"):
        subject(SYSTEMS[system])(inputs, replace(start, velocity=start.velocity * 27))


@pytest.mark.parametrize("method", ["rk4", "commutator_free", "dop853"])
def test_programmed_speed_that_reaches_the_schuler_speed_is_refused(method):
    m, inputs, start = case("T1", 120.0, 1.0)
    rising = replace(inputs, aids={"speed": 300 + (SCHULER_SPEED - 200) * m.time / 120})
    with pytest.raises(BrokenConditionError, match=r"sqrt\(g R\)") as caught:
        subject(SYSTEMS["gpx"], method)(rising, start)
    assert 118 < caught.value.time <= 119  # 120 s (V - 300)/(V - 200) = 118.44 s, or the end of that step


def test_a_limit_within_a_long_step_is_told_to_the_millisecond():
    """Beyond the limit the slopes are not finite: the steps shrink until it is found."""
    m, inputs, start = case("T3", 16.0, 4.0)
    steep = replace(inputs, aids={"speed": 300 + 1000 * m.time})
    with pytest.raises(BrokenConditionError, match=r"sqrt\(g R\)") as caught:
        subject(SYSTEMS["gpx"], "dop853")(steep, start)
    assert caught.value.time == pytest.approx((SCHULER_SPEED - 300) / 1000, abs=1e-3)


def test_systems_of_the_velocity_refuse_a_vehicle_at_rest_and_the_others_do_not():
    _, inputs, start = case("T1")
    for velocity in (np.zeros(3), 7 * start.vertical):
        resting = replace(start, velocity=velocity)
        for system in ("ghc", "gf", "bgx", "gp_paper"):
            with pytest.raises(BrokenConditionError, match="speed > 0"):
                subject(SYSTEMS[system])(inputs, resting)
        for system in ("full", "trad", "newton"):
            vertical = subject(SYSTEMS[system])(inputs, resting)["vertical"]
            assert vertical[0] == pytest.approx(start.vertical, abs=1e-15)
            assert np.isfinite(vertical).all()


def test_overflow_is_no_silent_nan():
    _, inputs, start = case("T1")
    force = inputs.specific_force.copy()
    force[4001] = 1e308
    with pytest.raises(BrokenConditionError, match="finite") as caught:
        subject(SYSTEMS["trad"])(replace(inputs, specific_force=force), start)
    assert caught.value.time == inputs.time[4002]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda i: replace(i, time=np.delete(i.time, 100), rate=np.delete(i.rate, 100, 0)), "multiple of 2"),
        (lambda i: replace(i, time=i.time + 0.1 * (i.time > 60)), "sampling gap: 0.35 s between t = 60 s"),
        (lambda i: replace(i, time=i.time[::-1]), "increasing"),
        (lambda i: replace(i, rate=np.where(i.time[:, None] == 30, np.nan, i.rate)), "rate is not finite, .*t = 30 s"),
        (lambda i: replace(i, specific_force=i.specific_force[:, :2]), "specific_force has shape"),
        (lambda i: replace(i, aids={}), "needs the aiding input 'speed'"),
        (lambda i: replace(i, kind="increments"), "rate has shape"),
    ],
)
def test_bad_inputs_are_named(change, message):
    _, inputs, start = case("T1", 600.0)
    with pytest.raises(ValueError, match=message):
        subject(SYSTEMS["gpx"])(change(inputs), start)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vertical": np.array([0.0, 2.0, 0.0])}, "vertical has the norm 2"),
        ({"attitude": np.ones(3)}, "attitude has shape 3"),
        ({"radius": 0.0}, "radius = 0"),
        ({"turn_rate": np.nan}, "turn_rate"),
        ({"turn_rate": None}, "needs turn_rate"),
    ],
)
def test_bad_starts_are_named(change, message):
    _, inputs, start = case("T1", 600.0)
    with pytest.raises(ValueError, match=message):
        subject(SYSTEMS["gp_equilibrium"])(inputs, replace(start, **change))


def test_unknown_methods_are_refused():
    _, inputs, start = case("T1", 600.0)
    with pytest.raises(ValueError, match="no method 'euler'"):
        subject(SYSTEMS["ghc"], "euler")(inputs, start)


# Read-out


@given(
    latitude=st.floats(-1.5, 1.5), longitude=st.floats(-3.1, 3.1), heading=st.floats(0.0, 6.28),
    pitch=st.floats(-1.5, 1.5), roll=st.floats(-3.1, 3.1), azimuth=st.floats(-3.1, 3.1),
)  # fmt: skip
@settings(derandomize=True, deadline=None)
def test_read_out_inverts_the_definition_of_the_angles(latitude, longitude, heading, pitch, roll, azimuth):
    def elementary(axis, angle):
        q = np.zeros(4)
        q[0], q[axis] = np.cos(angle / 2), np.sin(angle / 2)
        return q

    place = product(elementary(2, longitude), elementary(1, -latitude))
    s = place
    for axis, angle in ((3, -heading), (1, pitch), (2, roll)):
        s = product(s, elementary(axis, angle))
    e = product(place, elementary(3, azimuth))
    computed = read_out(-3 * e[None], 2 * s[None], [0.0])  # neither norm nor sign matters
    expected = (latitude, longitude, heading, pitch, roll)
    for value, true in zip(computed.values(), expected, strict=True):
        # Rounding, divided by the cosine of 1.5 rad, 0.07, of latitude and of pitch.
        assert abs((value[0] - true + np.pi) % (2 * np.pi) - np.pi) < 1e-13


@pytest.mark.parametrize(("axis", "condition"), [(1, "poles"), (0, "pitch")])
def test_read_out_refuses_what_has_no_angles(axis, condition):
    quarter = np.array([np.cos(np.pi / 4), np.sin(np.pi / 4), 0, 0])
    level = np.array([1.0, 0, 0, 0])
    e = np.array([level, conjugate(quarter) if axis == 1 else level])
    s = np.array([level, quarter if axis == 0 else level])
    with pytest.raises(BrokenConditionError, match=f"{condition}.*t = 7 s"):
        read_out(e, s, [0.0, 7.0])
