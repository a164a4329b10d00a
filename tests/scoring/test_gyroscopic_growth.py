"""Growth of the errors of gyroscopic systems with the speed, and the periods with which they swing."""

from functools import cache

import numpy as np
import pytest

from gyroscopic_motions import G, R
from sinsbench.scoring.gyroscopic import ladder, score_gyroscopic
from sinsbench.scoring.gyroscopic_growth import (
    GROWTH_FIELDS,
    expected_periods,
    growth,
    growth_order,
    oscillation,
    theory_of,
)
from sinsbench.scoring.gyroscopic_responses import score_responses
from sinsbench.subjects.loading import resolve
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.gyroscopic import sampled

SCHULER = 2 * np.pi * np.sqrt(R / G)
SCALES = ("1", "0.5", "0.25")


@cache
def family():
    """A parallel at constant absolute speeds of 600 m/s and less."""
    return tuple(
        GyroCase(
            name=f"slow_{scale}", motion="parallel", latitude="pi/4", longitude="0", speed=f"600*{scale}",
            rotation_rate="0", duration="3600", interval="10",
        )
        for scale in SCALES
    )  # fmt: skip


@cache
def scored():
    rows = []
    for case in family():
        rungs = ladder(case, (2, 1))
        for name in ("gp_paper", "bg_paper", "bg_equilibrium", "ghc"):
            rows += score_gyroscopic(resolve(name), case, rungs, repetitions=0)
    return rows


def test_orders_in_speed_are_those_of_theory():
    """Third order of the gyropendulum's law and of the bi-gyro, fourth of the bi-gyro at equilibrium on a parallel."""
    found = {row["subject"]: row for row in growth(scored(), family())}
    assert all(list(row) == [field.name for field in GROWTH_FIELDS] for row in found.values())
    assert {row["family"] for row in found.values()} == {"slow"}
    for name, order in (("gp_paper", 1), ("bg_paper", 3), ("bg_equilibrium", 4)):
        assert found[name]["expected_order"] == order
        # Terms of the next order are q = 0.08 of these.
        assert found[name]["order"] == pytest.approx(order, abs=0.1)
    assert found["gp_paper"]["law_order"] == pytest.approx(found["gp_paper"]["law_expected_order"], abs=0.1)
    assert found["gp_paper"]["speed_ratio_max"] == pytest.approx(600 / np.sqrt(G * R))


def test_a_system_without_an_error_of_its_own_has_no_order():
    (row,) = (row for row in growth(scored(), family()) if row["subject"] == "ghc")
    assert (row["cases"], row["order"], row["expected_order"]) == (0, None, None)
    assert "integration" in row["note"]
    assert theory_of("mine.py:f") is None


def test_errors_of_the_system_are_those_without_integration():
    """Figures computed apart over two hours, with a far smaller step; the largest errors come in the first hour."""
    found = {(row["subject"], row["case"]): row for row in scored() if row["interval"] == 10}
    # At 10 s the integration errs by 2.6e-7 rad, more than the bi-gyro at equilibrium does at 150 m/s.
    assert found["bg_equilibrium", "slow_0.5"]["system_error_max"] == pytest.approx(2.079622e-06, rel=0.01)
    assert found["bg_paper", "slow_0.25"]["system_error_max"] == pytest.approx(4.564754e-06, rel=0.01)
    assert found["bg_equilibrium", "slow_0.25"]["system_error_max"] is None
    assert found["ghc", "slow_1"]["system_error_max"] is None


def test_a_family_has_speeds_in_proportion_to_its_names():
    rows = [dict(row, case=row["case"].replace("slow_0.5", "slow_0.4")) for row in scored()]
    cases = [GyroCase.from_mapping({"name": name, "motion": "parallel", "latitude": "1", "longitude": "0", "speed": "9",
                                    "duration": "40", "interval": "10"})
             for name in ("slow_1", "slow_0.4", "slow_0.25", "other")]  # fmt: skip
    assert growth(rows, cases) == []
    assert growth(rows, cases[2:]) == []


@pytest.mark.parametrize(
    ("scales", "errors"), [((1.0,), (1.0,)), ((1.0, 2.0), (1.0, 0.0)), ((1.0, 2.0), (1.0, 2.0, 3.0))]
)
def test_growth_needs_positive_pairs(scales, errors):
    with pytest.raises(ValueError, match="two or more"):
        growth_order(scales, errors)


def test_oscillation_is_measured():
    time = np.linspace(0.0, 14400.0, 1441)
    found = oscillation(time, 3.0 + 1e-3 * time + 20.0 * np.sin(2 * np.pi * time / 5063.48 + 0.4), 5000.0)
    assert found.period == pytest.approx(5063.48, rel=1e-7)
    assert found.amplitude == pytest.approx(20.0, rel=1e-6)
    assert found.residual < 1e-6
    with pytest.raises(ValueError, match="cannot tell a period"):
        oscillation(time[:100], time[:100], 5000.0)


def circle(**changes):
    given = {"latitude": "pi/4", "longitude": "0", "course": "pi/3", "speed": "300", "duration": "7200"}
    return GyroCase.from_mapping({"name": "circle", "motion": "great_circle", "interval": "12", **given, **changes})


@cache
def circle_truth():
    return sampled(circle())


@pytest.mark.parametrize("name", ["ghc", "bgx", "gp_equilibrium"])
def test_periods_of_the_responses_are_those_of_theory(name):
    """Across the path the Schuler period; along it it depends on v, and on the system."""
    answers = {row["error"]: row for row in score_responses(resolve(name), circle(), circle_truth())}
    square = 300**2 / (G * R)
    along = {"ghc": 1 - square, "bgx": 1 + square, "gp_equilibrium": 1 - square + square**2}[name]
    expected = {
        "along": SCHULER / np.sqrt(along),
        "left": SCHULER if name != "gp_equilibrium" else SCHULER / along**0.5,
    }
    for error, axis in (("tilt", "along"), ("course", "left")):
        assert answers[error][f"expected_period_{axis}"] == pytest.approx(expected[axis], rel=1e-12)
        # The response is linear to its own size, 1e-4; squares of v^2/(g R) differ by 1e-6 of the period.
        assert answers[error][f"period_{axis}"] == pytest.approx(expected[axis], rel=1e-5)
    assert answers["gyro_bias"]["period_along"] is None


def test_no_theory_where_none_is_known():
    assert expected_periods("mine.py:f", circle()) == {}
    assert expected_periods("bg_paper", circle()) == {}
    assert expected_periods("ghc", circle(speed="300 + 10*sin(t)")) == {}
    assert expected_periods("ghc", circle(altitude="1000")) == {}
