"""Gyroscopic systems driven by sensors: figures, exactness, equivalence, methods."""

from dataclasses import replace

import numpy as np
import pytest

from gyroscopic_figures import ANGLE_RESPONSES, METHODICAL, READ_OUT
from gyroscopic_motions import DEG, SCHULER_SPEED, G, R, conjugate, motion, product, turned
from gyroscopic_runs import STEP, angles, case, result, start_of
from sinsbench.subjects.gyroscopic import start_rules, subjects
from sinsbench.subjects.gyroscopic.catalogue import CATALOGUE, SUBJECTS
from sinsbench.subjects.gyroscopic.contract import Inputs
from sinsbench.subjects.gyroscopic.drivers import integrated, points_of_increments, subject
from sinsbench.subjects.gyroscopic.read_out import ANGLES, read_out
from sinsbench.subjects.gyroscopic.systems import SYSTEMS, constants, third_axis

#: Of the classical method at that step on the motions T1-T4, measured, and proportional to its fourth power.
METHOD_ERROR = 1e-6  # m
EXACT = ("bgx", "gf", "ghc", "full", "trad")


def components(m, vertical):
    return np.einsum("nij,nj->ni", m.axes[::2], vertical - m.vertical[::2])


@pytest.mark.parametrize("row", METHODICAL, ids=lambda row: "-".join(map(str, row[:3])))
def test_methodical_errors_are_those_computed_apart(row):
    name, system, time, along, left, metres, speed = row
    m, computed, k = case(name)[0], result(name, system), round(time / STEP)
    # The figures have ten digits, the vertical of a gyropendulum is off by 0.04 rad and 240 km.
    assert components(m, computed["vertical"])[k, :2] == pytest.approx([along, left], abs=1e-11)
    assert R * angles(computed["vertical"], m.vertical[::2])[k] == pytest.approx(metres, abs=2e-6)
    if speed is not None:
        assert computed["speed"][k] - m.speed[2 * k] == pytest.approx(speed, abs=1e-6)


def angles_of(computed):
    """Angles (2.9)-(2.11), arcseconds, a column each."""
    shown = read_out(computed["trihedron"], computed["attitude"], computed["time"])
    return np.column_stack([shown[name] for name in ANGLES]) / DEG * 3600


def wrapped(difference):
    return (difference + 648000) % 1296000 - 648000


@pytest.mark.parametrize("row", READ_OUT, ids=lambda row: "-".join(map(str, row[:2])))
def test_errors_of_position_and_attitude_are_those_computed_apart(row):
    """The whole chain: sensors, attitude, force in X, system, read-out."""
    system, time, *figures = row
    m, k = case("T3")[0], round(time / STEP)
    true = np.array([getattr(m, name)[2 * k] for name in ANGLES]) / DEG * 3600
    # Nine digits; 1e-6 m are 3e-8 arcseconds, which heading and longitude see through 1/cos(latitude).
    assert wrapped(angles_of(result("T3", system))[k] - true) == pytest.approx(figures, rel=5.1e-9, abs=1e-7)


@pytest.mark.parametrize("row", ANGLE_RESPONSES, ids=lambda row: "-".join(row[:3]))
def test_responses_of_position_and_attitude_are_those_computed_apart(row):
    name, error, system, *figures = row
    _, inputs, start = case(name, 14400.0)
    rate, force = error != "accelerometer_bias", error != "gyro_bias"
    biased = replace(
        inputs, rate=inputs.rate + rate * 0.01 * DEG / 3600, specific_force=inputs.specific_force + force * 50e-6 * G
    )
    difference = angles_of(subject(SYSTEMS[system])(biased, start)) - angles_of(result(name, system, duration=14400.0))
    # A unit of the fifth decimal: 3e-4 m.
    assert wrapped(difference[-1]) == pytest.approx(figures, abs=1.1e-5)


@pytest.mark.parametrize("name", ["T1", "T2", "T3", "T4"])
@pytest.mark.parametrize("system", EXACT)
def test_exact_systems_follow_the_truth(name, system):
    m, computed = case(name)[0], result(name, system)
    assert R * angles(computed["vertical"], m.vertical[::2]).max() < METHOD_ERROR
    # A metre a second of velocity is worth sqrt(R/g) = 806 m of vertical.
    assert np.abs(computed["speed"] - m.speed[::2]).max() < METHOD_ERROR / 10


@pytest.mark.parametrize("name", ["T1", "T2", "T3", "T4"])
def test_programmed_gyropendulum_keeps_its_law(name):
    """sin alpha = -v/sqrt(g R) for any motion where H = m l sqrt(g R - v^2)."""
    m = case(name)[0]
    sine = -m.speed[::2, None] / SCHULER_SPEED
    law = -sine * m.axes[::2, 1] + np.sqrt(1 - sine**2) * m.vertical[::2]
    assert R * angles(result(name, "gpx")["vertical"], law).max() < METHOD_ERROR


@pytest.mark.parametrize("name", ["T1", "T2"])
def test_pair_tuned_to_a_constant_speed_is_exact_at_that_speed(name):
    m = case(name)[0]
    assert R * angles(result(name, "bgv")["vertical"], m.vertical[::2]).max() < METHOD_ERROR


@pytest.mark.parametrize("system", [*EXACT, "gpx"])
def test_dop853_follows_the_truth(system):
    """Two hours in float64, sampled each 5 s: the tolerance of 3e-14 on some hundred steps leaves 4e-7 m."""
    m, inputs, start = case("T3", step=10.0)
    computed = subject(SYSTEMS[system], "dop853")(inputs, start)
    expected = m.vertical[::2] if system != "gpx" else result("T3", "gpx")["vertical"][::20]
    assert R * angles(computed["vertical"], expected).max() < 1e-6


@pytest.mark.parametrize("method", ["rk4", "commutator_free"])
@pytest.mark.parametrize("system", EXACT)
def test_fixed_step_methods_have_order_four(system, method):
    errors = []
    for step in (16.0, 8.0):
        m = case("T3", 3600.0, step)[0]
        errors.append(angles(result("T3", system, method, 3600.0, step)["vertical"], m.vertical[::2]).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.2)  # terms of the fifth order at 8 s


def test_lie_group_method_keeps_the_norm():
    states = result("T3", "ghc", "commutator_free", 3600.0, 16.0)["states"]
    # One rounding a component, product and step.
    assert np.abs(np.linalg.norm(states[:, :4], axis=1) - 1).max() < 4 * len(states) * np.finfo(float).eps


def test_increments_of_a_cubic_give_its_points_and_lose_nothing():
    cubic = np.polynomial.Polynomial([0.3, -0.2, 0.05, 0.01])
    interval, ends = 0.25, np.arange(9) * 0.25
    increments = np.diff(cubic.integ()(ends))[:, None]
    points = points_of_increments(increments, interval)
    assert points[..., 0] == pytest.approx(cubic(ends[[[0, 2, 4], [4, 6, 8]]]), abs=1e-14)
    simpson = points[..., 0] @ [1, 4, 1] / 6 * 4 * interval
    assert simpson == pytest.approx(increments.reshape(2, 4).sum(1), abs=1e-15)


@pytest.mark.parametrize("system", EXACT)
def test_increments_serve_as_points_do(system):
    """Increments by Gauss quadrature, exact to rounding at this interval; the order is four."""
    errors = []
    for interval in (4.0, 2.0):
        time = np.linspace(0, 3600, round(3600 / interval) + 1)
        nodes, weights = np.polynomial.legendre.leggauss(8)
        inner = motion("T3", (time[:-1, None] + interval * (nodes + 1) / 2).ravel())
        rate, force = (
            np.einsum("nki,k->ni", x.reshape(len(time) - 1, 8, 3), weights) * interval / 2
            for x in (inner.rate, inner.specific_force)
        )
        m = motion("T3", time)
        computed = integrated(SYSTEMS[system], "rk4", Inputs(time, rate, force, {}, "increments"), start_of(m))
        assert computed["time"] == pytest.approx(time[::4])
        errors.append(angles(computed["vertical"], m.vertical[::4]).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.3)
    assert R * errors[1] < 10  # metres, with steps of 8 s


@pytest.mark.parametrize("name", ["T0", "T3"])
def test_exact_systems_answer_alike_to_corrupted_sensors(name):
    """GHC, GF, FULL and TRAD are one flow in four sets of variables."""
    _, inputs, start = case(name)
    corrupted = replace(inputs, rate=inputs.rate + 0.01 * DEG / 3600, specific_force=inputs.specific_force + 50e-6 * G)
    verticals = {s: subject(SYSTEMS[s])(corrupted, start)["vertical"] for s in ("ghc", "gf", "full", "trad")}
    worst = max(R * angles(verticals[s], verticals["trad"]).max() for s in ("ghc", "gf", "full"))
    assert worst < METHOD_ERROR
    assert R * angles(verticals["trad"], result(name, "trad")["vertical"]).max() > 1000  # the errors are felt


def test_radius_that_varies():
    """Only h' = a1 - r' h/r with r(t) is exact; figures from arithmetic of 45 digits."""
    m, inputs, start = case("T3", climb=5000.0)
    expected = {
        "ghc": (1014.141790, 504.021681),
        "ghc_radius": (566.175945, 445.387441),
        "ghc_altitude": (0.0, 0.0),
        "bgx": (948.527690, 332.656546),
    }
    for system, figures in expected.items():
        error = R * angles(subject(SYSTEMS[system])(inputs, start)["vertical"], m.vertical[::2])
        assert error[[7200, 14400]] == pytest.approx(figures, abs=2 * METHOD_ERROR)


def test_mistuned_pair():
    _, inputs, start = case("T3")
    vertical = subject(SYSTEMS["bg_paper"], factor=0.99)(inputs, start)["vertical"]
    error = R * angles(vertical, case("T3")[0].vertical[::2])
    assert error[[7200, 14400]] == pytest.approx([14048.685585, 6517.548685], abs=2 * METHOD_ERROR)


@pytest.mark.parametrize(("spin", "figures"), [(1e-6, (210.250690, 435.724368)), (1e-5, (2119.709897, 4414.492127))])
def test_full_equations_need_a_momentum_without_vertical_part(spin, figures):
    def spoilt(start, fixed):
        state = start_rules.momentum_of_motion(start, fixed)
        state[4:] += product(np.array([0.0, *(spin * start.vertical)]), state[:4]) / 2
        return state

    m, inputs, start = case("T3")
    computed = subject(replace(SYSTEMS["full"], start=spoilt))(inputs, start)
    error = R * angles(computed["vertical"], m.vertical[::2])
    # The figures have six decimals; their own start was perturbed to about that.
    assert error[[7200, 14400]] == pytest.approx(figures, abs=2e-5)


def test_full_equations_tend_to_the_gyropendulum():
    """With n = 1/J and L.y3 = m l V they differ from (2.6) by the first order in J/(m l R)."""
    m, inputs, start = case("T3", 600.0, 0.1)
    axis = result("T3", "gp_paper", duration=600.0, step=0.1)["vertical"]
    differences = []
    for ratio in (0.02, 0.01):
        fixed = constants(start)._replace(inverse_inertia=1 / (ratio * R))

        def nutation_free(start, fixed):
            z = start_rules.pendulum(start_rules.paper_inclination)(start, fixed)
            third = third_axis(z[None])[0]
            turning = -fixed.tuning * m.force_inertial[0]
            turning += (fixed.inverse_inertia / fixed.tuning - turning @ third) * third
            return np.array([*z, *product(np.array([0.0, *turning]), z) / 2])

        system = replace(SYSTEMS["full"], start=nutation_free)
        differences.append(angles(integrated(system, "rk4", inputs, start, fixed)["vertical"], axis).max())
    assert np.log2(differences[0] / differences[1]) == pytest.approx(1, abs=0.1)


def test_general_forms_reduce_to_the_gyropendulum():
    """Without moments, with w*_3 = -kappa a_3 or any other spin, the axis is that of (2.6)."""
    axis = result("T3", "gp_paper")["vertical"]
    _, inputs, start = case("T3")
    for system in ("gp_moments", "gyroscope_general"):
        assert R * angles(result("T3", system)["vertical"], axis).max() < METHOD_ERROR
        spinning = replace(inputs, aids={"spin": np.full(len(inputs.time), 1e-3)})
        assert R * angles(subject(SYSTEMS[system])(spinning, start)["vertical"], axis).max() < METHOD_ERROR


def test_programmed_momentum_is_made_by_a_moment_along_the_axis():
    """(2.5): M_3 = H' with H = m l sqrt(g R - v^2) keeps the exact law."""
    m, inputs, start = case("T4")
    speed_rate = 100 * (2 * np.pi / 1800) * np.cos(2 * np.pi * m.time / 1800)
    moment = -m.speed * speed_rate / np.sqrt(SCHULER_SPEED**2 - m.speed**2)
    system = replace(
        SYSTEMS["gp_moments"],
        start=lambda start, fixed: np.append(
            start_rules.pendulum(start_rules.exact_inclination)(start, fixed),
            np.sqrt(SCHULER_SPEED**2 - start.speed**2),
        ),
    )
    computed = subject(system)(replace(inputs, aids={"moment_z": moment}), start)
    assert R * angles(computed["vertical"], result("T4", "gpx")["vertical"]).max() < METHOD_ERROR


def test_frame_with_moments_follows_the_truth_when_turned_by_the_law():
    m, inputs, start = case("T3")
    computed = subject(SYSTEMS["gf_moments"])(replace(inputs, aids={"spin": m.speed / R}), start)
    assert R * angles(computed["vertical"], m.vertical[::2]).max() < METHOD_ERROR


@pytest.mark.parametrize("system", ["deviation", "gp_deviation"])
def test_deviation_from_the_trihedron_composes_to_the_gyropendulum(system):
    m, inputs, start = case("T3")
    turning = (
        np.cross(m.vertical, m.velocity) / R
        + (np.sum(m.axes[:, 1] * m.force_inertial, 1) / m.speed)[:, None] * m.vertical
    )
    reference = np.einsum("nij,nj->ni", m.axes, turning)
    aids = {f"reference_rate_{axis}": column for axis, column in zip("xyz", reference.T, strict=True)}
    if system == "deviation":
        # w*_eta of (2.6), with e of a gyropendulum run on the same points: every point is the end of a step of half.
        fine, fine_inputs, fine_start = case("T3", step=STEP / 2)
        states = subject(SYSTEMS["gp_paper"])(fine_inputs, fine_start)["states"]
        gyro = -turned(conjugate(states), fine.force_inertial[::2]) / SCHULER_SPEED
        aids |= {f"gyro_rate_{axis}": column for axis, column in zip("xyz", gyro.T, strict=True)}
    computed = subject(SYSTEMS[system])(replace(inputs, aids=aids), start)
    assert R * angles(computed["vertical"], result("T3", "gp_paper")["vertical"]).max() < METHOD_ERROR


def test_newton_grows_in_altitude_where_the_others_oscillate():
    _, inputs, start = case("T0")
    biased = replace(inputs, specific_force=inputs.specific_force + 50e-6 * G)
    computed = subject(SYSTEMS["newton"])(biased, start)
    # Figures of 45 digits; an error grows by exp(sqrt(2) t sqrt(g/R)), 3e5 in 2 h.
    assert computed["radius"][[7200, 14400]] - R == pytest.approx([47141.416922, 11892515.867514], rel=1e-6)


def test_every_entry_of_the_catalogue_is_a_system_and_every_subject_runs():
    assert set(CATALOGUE) == set(SYSTEMS)
    assert dir(subjects) == sorted(SUBJECTS)
    m, inputs, start = case("T1", 600.0)
    increments = replace(inputs, rate=m.rate[1:] * 0.25, specific_force=m.specific_force[1:] * 0.25, kind="increments")
    for name, row in SUBJECTS.items():
        computed = getattr(subjects, name)(increments if row.takes == "increments" else inputs, start)
        assert len(computed["vertical"]) == (len(inputs.time) - 1) // row.samples_per_step + 1
        assert {"vertical", "trihedron", "attitude"} <= set(computed)
        assert third_axis(computed["trihedron"]) == pytest.approx(computed["vertical"], abs=1e-14)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = subjects.nothing
