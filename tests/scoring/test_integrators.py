"""Scores of the built-in integrators: orders, the recomputed table of the paper, asymptotics, floors."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from sinsbench.scoring.integrators import LADDER, ladder, score_integrator
from sinsbench.subjects.integrators import panov4
from sinsbench.subjects.loading import LoadedSubject, resolve
from sinsbench.subjects.registry import Subject
from sinsdata.cases import DualPrecessionCase
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

CASES = {case.name: case for case in paper_cases("dual_precession")}
ORDERS = (2, 4, 6)

# Order, motion: drift (deg/h), body and inertial velocity error (m/s) of variants 1-3, recomputed in fifty digits.
RECOMPUTED = {
    (4, "coning"): (
        0.158948191,
        (0.00859585578, 0.0862650871, 0.0865030509),
        (0.00865572226, 0.0876263151, 0.0876263151),
    ),
    (4, "general"): (
        0.0823376212,
        (0.00459128303, 0.0461229222, 0.0464191271),
        (0.0046324265, 0.0470245901, 0.0470245901),
    ),
    (6, "coning"): (
        0.00034770704,
        (1.39981253e-5, 0.000140920221, 0.000141630359),
        (1.41744221e-5, 0.000144900389, 0.000144900389),
    ),
    (6, "general"): (
        0.000837185536,
        (4.59377589e-5, 0.000461685481, 0.000462424217),
        (4.6217609e-5, 0.000468132212, 0.000468132212),
    ),
}


@pytest.fixture(scope="module")
def ladders():
    """Both motions of variant 2 on the whole ladder, the other variants on the papers' interval."""
    return {
        name: ladder(case, LADDER if name.startswith("variant2") else (Fraction(1),)) for name, case in CASES.items()
    }


@pytest.fixture(scope="module")
def rows(ladders):
    names = [f"panov{order}{suffix}" for order in ORDERS for suffix in ("", "_compensated")]
    return {
        (name, case): score_integrator(resolve(name), CASES[case], rungs, repetitions=0)
        for case, rungs in ladders.items()
        for name in names
    }


@pytest.mark.parametrize("suffix", ["", "_compensated"])
@pytest.mark.parametrize("case", ["variant2_coning", "variant2_general"])
@pytest.mark.parametrize("order", ORDERS)
def test_observed_orders(rows, order, case, suffix):
    found = rows[f"panov{order}{suffix}", case]
    assert [row["status"] for row in found] == ["ok"] * 6
    for prefix in ("", "velocity_"):
        assert found[0][f"{prefix}observed_order"] == pytest.approx(order, abs=0.03)
        assert found[0][f"{prefix}order_residual"] < 0.05
        assert found[0][f"{prefix}order_points"] >= 4
        assert found[1][f"{prefix}local_order"] == pytest.approx(order, abs=0.03)
        assert found[0][f"{prefix}local_order"] is None


@pytest.mark.parametrize("variant", [1, 2, 3])
@pytest.mark.parametrize(("order", "motion"), RECOMPUTED)
def test_recomputed_table(rows, order, motion, variant):
    case = f"variant{variant}_{motion}"
    row = next(row for row in rows[f"panov{order}", case] if row["interval"] == 0.01)
    drift, body, inertial = RECOMPUTED[order, motion]
    # Nine digits are tabulated; at order 6 rounding in binary64 reaches the fifth.
    tolerance = {4: 1e-8, 6: 1e-5}[order]
    assert row["drift_deg_per_h"] == pytest.approx(drift, rel=tolerance)
    assert row["velocity_body_error_end"] == pytest.approx(body[variant - 1], rel=tolerance)
    assert row["velocity_error_end"] == pytest.approx(inertial[variant - 1], rel=tolerance)


@pytest.mark.parametrize("case", ["variant2_coning", "variant2_general"])
@pytest.mark.parametrize(("order", "nearness"), [(2, 2.5e-2), (4, 2e-2), (6, 1e-2)])
def test_asymptotics_are_approached_quadratically(rows, order, case, nearness):
    """The neglected terms are two powers of h higher: each halving brings the prediction four times nearer."""
    for field, predicted in (
        ("drift_deg_per_h", "predicted_drift_deg_per_h"),
        ("velocity_error_end", "predicted_velocity_error_end"),
    ):
        found = np.array([row[field] / row[predicted] - 1 for row in rows[f"panov{order}_compensated", case][:4]])
        assert abs(found[0]) < nearness
        if order < 6:  # at order 6 rounding is seen first
            assert found[:3] / found[1:] == pytest.approx([4] * 3, rel=0.2)


def test_rounding_floor(rows):
    for case in ("variant2_coning", "variant2_general"):
        plain, compensated = (rows[f"panov6{suffix}", case][-1] for suffix in ("", "_compensated"))
        assert plain["velocity_at_floor"]
        # Carried rounding errors lower the velocity floor by an order of magnitude at least.
        assert compensated["velocity_floor"] < plain["velocity_floor"] / 10
        for row in (*rows["panov6", case], *rows["panov6_compensated", case]):
            for prefix in ("", "velocity_"):
                assert row[f"{prefix}floor"] >= row[f"{prefix}input_floor"] > 0
            assert row["attitude_error_max"] >= row["input_floor"]
            assert row["velocity_error_max"] >= row["velocity_input_floor"]
    assert not any(row["at_floor"] or row["velocity_at_floor"] for row in rows["panov2", "variant2_coning"])


def test_equivalent_biases(rows):
    # The axis of the cone is at rest, the body's z axis 10 degrees from it: the bias is the drift over the cosine.
    row = rows["panov4", "variant2_coning"][1]
    assert row["gyro_bias_deg_per_h"] == pytest.approx(row["drift_deg_per_h"] / np.cos(np.pi / 18), rel=5e-3)


def test_operations(rows):
    flops = [rows[f"panov{order}", "variant2_coning"][0]["flops_per_sample"] for order in ORDERS]
    assert 0 < flops[0] < flops[1] < flops[2]


def user(function, samples_per_step=None):
    return LoadedSubject(Subject("mine", None, "mine", "", samples_per_step=samples_per_step), function)


@pytest.fixture(scope="module")
def short():
    case = replace(CASES["variant2_general"], duration=ExactNumber("0.64"))
    return case, ladder(case, (Fraction(1), Fraction(1, 2)))


def test_a_planted_bias_is_found(short):
    """Constant biases added to the increments come out as such; those of the method are a hundred times smaller."""
    case, rungs = short
    gyro, accelerometer = np.array([0, 0, 3e-3]), np.array([0, 0, 0.2])

    def biased(angle, velocity, interval, attitude0, velocity0):
        return panov4(angle, velocity + accelerometer * interval, interval, attitude0, velocity0)

    def drifting(angle, velocity, interval, attitude0, velocity0):
        return panov4(angle + gyro * interval, velocity, interval, attitude0, velocity0)

    row = score_integrator(user(biased), case, rungs, 0)[1]
    assert row["accelerometer_bias_ug"] == pytest.approx(0.2 / 9.80665e-6, rel=1e-2)
    row = score_integrator(user(drifting), case, rungs, 0)[1]
    assert row["gyro_bias_deg_per_h"] == pytest.approx(np.degrees(3e-3) * 3600, rel=1e-2)


def test_attitude_alone(short):
    case, rungs = short
    found = score_integrator(user(lambda *inputs: panov4(*inputs)["attitude"]), case, rungs)
    full = score_integrator(user(panov4), case, rungs)
    for row, other in zip(found, full, strict=True):
        assert row["attitude_error_max"] == other["attitude_error_max"]
        assert (row["velocity_error_max"], row["velocity_floor"], row["velocity_body_error_max"]) == (None, None, None)
        assert row["ns_per_sample"] > 0


def test_the_sign_of_the_quaternion_does_not_matter(short):
    case, rungs = short

    def flipped(*inputs):
        result = panov4(*inputs)
        result["attitude"][1::2] *= -1
        return result

    found, full = (score_integrator(user(f), case, rungs, 0) for f in (flipped, panov4))
    assert [row["attitude_error_max"] for row in found] == [row["attitude_error_max"] for row in full]


def test_the_conjugate_quaternion_does(short):
    case, rungs = short

    def conjugated(*inputs):
        return panov4(*inputs)["attitude"] * [1, -1, -1, -1]

    row = score_integrator(user(conjugated), case, rungs, 0)[0]
    assert (row["status"], row["observed_order"]) == ("ok", None)
    assert row["attitude_error_max"] > 1


def test_truth_scores_the_floor(short):
    """A subject that returns the rounded truth gets the input floor, no better."""
    case, rungs = short
    motions = {rung.motion.samples: rung.motion for rung in rungs}

    def oracle(angle, *_):
        motion = motions[len(angle)]
        return {"attitude": motion.attitude, "velocity_inertial": motion.velocity_inertial}

    for row in score_integrator(user(oracle), case, rungs, 0):
        assert row["status"] == "ok"
        assert row["attitude_error_max"] == pytest.approx(row["input_floor"], rel=2)
        assert row["attitude_error_max"] >= row["input_floor"]
        assert row["observed_order"] is None


def test_three_samples_a_step(short):
    """A step that does not divide the run: the samples are cut to whole steps, errors taken where all rungs meet."""
    case, rungs = short
    seen = []

    def three(angle, velocity, interval, attitude0, velocity0):
        seen.append(len(angle))
        return panov_of_three(angle, velocity, interval, attitude0, velocity0)

    for row in score_integrator(user(three, samples_per_step=3), case, rungs, 0):
        assert (row["status"], row["samples_per_step"]) == ("ok", 3)
        assert row["attitude_error_end"] > 0
    assert seen[:2] == [63, 126]  # and a few samples again, to count operations


def panov_of_three(angle, velocity, interval, attitude0, velocity0):
    """Order 2 with three samples a step, from the one with four: sums of three samples, split evenly into four."""
    from sinsbench.subjects.integrators import panov2

    thirds = (x.reshape(-1, 3, 3).sum(axis=1) for x in (angle, velocity))
    quarters = (np.repeat(x / 4, 4, axis=0) for x in thirds)
    return panov2(*quarters, interval, attitude0, velocity0)


@pytest.mark.parametrize(
    ("samples", "factors", "expected"),
    [
        (64, LADDER, (list(LADDER), 8)),
        (10, LADDER, (list(LADDER), 2)),
        (9, LADDER, (list(LADDER[1:]), 1)),
        (24, (1, Fraction(2, 3), Fraction(3, 2)), ([Fraction(3, 2), 1, Fraction(2, 3)], 24)),
    ],
)
def test_ladders_of_any_length(samples, factors, expected):
    case = replace(CASES["variant1_general"], duration=ExactNumber(f"{samples}/100"))
    rungs = ladder(case, tuple(map(Fraction, factors)))
    used, spacing = expected
    assert [rung.motion.samples for rung in rungs] == [samples / factor for factor in used]
    for rung in rungs:
        assert rung.motion.time[1] == pytest.approx(spacing / 100)
        assert rung.motion.time[-1] == pytest.approx(samples / 100)
    for row in score_integrator(resolve("panov4"), case, rungs, 0):
        assert row["status"] == "ok"


def test_an_interval_that_does_not_divide():
    with pytest.raises(ValueError, match="divides"):
        ladder(replace(CASES["variant1_general"], duration=ExactNumber("0.07")), (Fraction(2),))


def test_a_motion_about_a_fixed_axis():
    parameters = dict.fromkeys(("precession_ratio", "nutation", "spin_rate_dual", "nutation_dual"), "0")
    velocity = ("1", "2", "3")
    case = DualPrecessionCase("spin", "1", initial_velocity=velocity, interval="0.01", duration="0.64", **parameters)
    for row in score_integrator(resolve("panov4"), case, ladder(case, (Fraction(1),)), 0):
        assert row["status"] == "ok"
        assert row["predicted_drift_deg_per_h"] == 0
        # Every order is exact here: what is left is rounding, at most a unit roundoff a sample.
        assert row["attitude_error_max"] < 64 * 1.2e-16


@pytest.mark.parametrize("name", ["attitude", "velocity_inertial", "velocity_body"])
@pytest.mark.parametrize("factor", [1e308, 1e-320])
def test_errors_beyond_the_range_of_float64(short, name, factor):
    case, rungs = short

    def scaled(*inputs):
        result = panov4(*inputs)
        result[name] = np.full_like(result[name], factor)
        return result

    for row in score_integrator(user(scaled), case, rungs, 0):
        if name != "attitude" and factor < 1:  # a tiny velocity is wrong, but its error is a number
            field = {"velocity_inertial": "velocity_error_max", "velocity_body": "velocity_body_error_max"}[name]
            assert (row["status"], row[field] > 0.1) == ("ok", True)
        else:
            assert (row["status"], row["attitude_error_max"]) == ("not finite", None)
            assert row["message"]


def test_the_largest_errors_that_are_numbers(short):
    """Just below overflow of the norm, on one rung only: the slope is absurd, and still no warning leaks."""
    case, rungs = short

    def steep(angle, *inputs):
        result = panov4(angle, *inputs)
        if len(angle) == rungs[0].motion.samples:
            result["velocity_inertial"][:] = 7e153
        return result

    for row in score_integrator(user(steep), case, rungs, 0):
        assert row["status"] == "ok"
        assert row["velocity_error_max"] > 0


@pytest.mark.parametrize(("samples", "message"), [(1, "1 sample is less than a step of 4"), (3, "3 samples are less")])
def test_fewer_samples_than_a_step(samples, message):
    case = replace(CASES["variant1_general"], duration=ExactNumber(f"{samples}/100"))
    [row] = score_integrator(resolve("panov4"), case, ladder(case, (Fraction(1),)), 0)
    assert row["status"] == "not applicable"
    assert row["message"].startswith(message)


def test_long_rungs_are_left_out(monkeypatch):
    case = replace(CASES["variant1_general"], duration=ExactNumber("0.64"))
    for most, expected in ((256, [32, 64, 128, 256]), (255, [32, 64, 128]), (20, [64])):
        monkeypatch.setattr("sinsbench.scoring.ladders._MOST_SAMPLES", most)
        assert [rung.motion.samples for rung in ladder(case)] == expected
    with pytest.raises(ValueError, match="more than 20 samples"):
        ladder(case, LADDER[2:])
