"""Cases of `mast_antenna`: what a file may say, and what is refused, with field, value, condition and time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from sinsdata.cases import CaseError, MastCase
from sinsdata.format.case_columns import mapping, parameters
from sinsdata.tiers import CaseFileError, cases_from_toml, cases_of, strata_of, stratum_name, tiers_of
from sinsdata.tiers.mast import MAST_STRATA, mast_paper_cases, mast_standard_cases

_BASE = {"name": "mine", "duration": "100", "interval": "0.01"}


def case(**given: Any) -> MastCase:
    return MastCase.from_mapping({**_BASE, **given})


_REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "below the horizon": (
        {"satellites": [["pi/6", "pi/4"], ["0", "-pi/3"], ["0", "0"], ["0", "0"]], "satellites_used": 2},
        r"satellites = .*: satellite 2 is below the horizon; t = 0 s",
    ),
    "sets later": (
        {"duration": "20000", "interval": "1", "antenna_rate_sd": "0.001", "velocity_north": "0", "satellites_used": 1,
         "angular_rate": [0, 0, 0], "mast_rate": [0, 0]},
        r"satellites = .*: satellite 1 is below the horizon; t = \d{4,5} s",
    ),
    "at a pole": ({"latitude": "pi/2"}, r"latitude = pi/2: comes within 0\.001 rad of a pole; t = 0 s"),
    "towards a pole": (
        {"latitude": "1.5697", "satellites_used": 1, "satellites": [["0", "pi/2"]] * 4},
        r"velocity_north = .*: the vehicle comes within 0\.001 rad of a pole; t = 6\.\d+ s",
    ),
    "no mast": ({"mast_length": 0}, r"mast_length = 0: must be greater than 0 m"),
    "a mast downwards": ({"mast_length": "-5"}, r"mast_length = -5: must be greater than 0 m"),
    "no sum": ({"velocity_up": "exp(t)"}, r"velocity_up = .*outside the grammar"),
    "no function of a list": ({"angular_rate": ["1", "t*sin(t)", "0"]}, r"angular_rate\[1\] = .*admissible"),
    "too few": ({"mast_rate": ["1"]}, r"mast_rate = .*: must be a list of 2 functions of time"),
    "a text in place of a list": ({"angular_rate": "1"}, r"angular_rate = '1': must be a list of 3 functions of time"),
    "no list": ({"satellites": 4}, r"satellites = 4: must be a list of 4 pairs"),
    "no pair": ({"satellites": [["0"]] * 4}, r"satellites\[0\] = .*: must have 2 elements, not 1"),
    "no satellite": ({"satellites_used": 0}, r"satellites_used = 0: must be a whole number, 1 to 4"),
    "five satellites": ({"satellites_used": 5}, r"satellites_used = 5: must be a whole number, 1 to 4"),
    "half a seed": ({"seed": 0.5}, r"seed = 0\.5: must be a whole number, 0 to 2\^64 - 1"),
    "a long seed": ({"error_seed": 2**64}, r"error_seed = 18446744073709551616: must be a whole number"),
    "negative noise": ({"gyro_sd": "-1e-8"}, r"gyro_sd = -1e-8: must not be negative"),
    "an antenna that tumbles": ({"antenna_rate_sd": 6}, r"antenna_rate_sd = 6: must be at most 5 rad/s for the int"),
    "too fast for the interval": (
        {"angular_rate": ["cos(500*t)", "0", "0"]}, r"interval = 0\.01: must be at most 0\.00448 s where the motion",
    ),
    "too deep": ({"height": -20000}, r"height = -20000: the height must stay between -10000 and 1e\+06 m; t = 0 s"),
    "through the ground": (
        {"velocity_up": "-200"}, r"velocity_up = -200: the height must stay between .* m; t = 50\.0\d+ s",
    ),
    "an unknown fault": ({"fault": "gyro"}, r"fault = 'gyro': must be one of rate1, specific_force1"),
    "itself": ({"run": "mine"}, r"run = 'mine': must be the name of another case"),
    "a slip": ({"mast_lenght": 5}, r"mast_lenght = 5: unknown key; did you mean 'mast_length'\?"),
    "no duration": ({"duration": 0}, r"duration = 0: must be greater than 0 s"),
    "half a step": ({"duration": "1.005"}, r"duration = 1\.005: must be a whole number of intervals"),
}  # fmt: skip


@pytest.mark.parametrize("what", _REFUSED)
def test_what_is_refused(what: str) -> None:
    given, message = _REFUSED[what]
    with pytest.raises(CaseError, match=message):
        case(**given)


def test_satellites_that_are_not_used_may_be_anywhere() -> None:
    pairs = [["0", "pi/3"], ["0", "-pi/2"], ["0", "0"], ["0", "0"]]
    assert case(satellites=pairs, satellites_used=1).satellite_count == 1


def test_the_paper_is_the_default() -> None:
    made = case()
    assert made.velocity_north.text == "100 + sin(0.02*t)"
    assert [rate.text for rate in made.mast_rate] == ["0.43*cos(2.45*t)", "0.3*cos(2.7*t)"]
    assert (float(made.gyro_sd), float(made.accelerometer_sd), float(made.mast_length)) == (5e-8, 1e-4, 5)
    assert made.satellite_count == 4


def test_quick_motions_are_cut_finer() -> None:
    """Twice the highest frequency, twice the parts: a part turns no more than 0.0175 rad."""
    assert [case(angular_rate=[f"0.1*cos({w}*t)", "0", "0"]).parts for w in (3, 7, 14, 140)] == [1, 2, 4, 40]


def test_a_case_goes_to_the_table_and_back() -> None:
    made = case(satellites_used=2, fault="range", fault_time="1/3", seed=2**63 + 1, angular_rate=["t", "0", "1"])
    columns = parameters(made)
    row: dict[str, Any] = {"case": made.name}
    for name, value in columns.items():
        row[f"{name}_exact" if hasattr(value, "text") else name] = getattr(value, "text", value)
    assert MastCase.from_mapping({k: v for k, v in mapping("mast_antenna", row).items() if v is not None}) == made


_FILE = """
[[case]]
name = "four"
duration = 10
interval = "0.01"
mast_rate = ["0.2*sin(t)", 0]
[[case]]
name = "one"
run = "{run}"
duration = 10
interval = "0.01"
mast_rate = ["0.2*sin(t)", {rate}]
satellites_used = 1
range_sd = 1
"""


@pytest.mark.parametrize(
    ("run", "rate", "message"),
    [
        ("four", "0.1", r"case 2 \(one\): run = 'four': that case has another mast_rate; only satellites_used"),
        ("none", "0", r"case 2 \(one\): run = 'none': no such case beside it"),
    ],
)
def test_cases_that_share_a_run_have_its_motion(run: str, rate: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text(_FILE.format(run="four", rate="0"))
    four, one = cases_from_toml("mast_antenna", path)
    assert isinstance(one, MastCase)
    assert one.run == four.name
    path.write_text(_FILE.format(run=run, rate=rate))
    with pytest.raises(CaseFileError, match=message):
        cases_from_toml("mast_antenna", path)


def test_the_paper_tier() -> None:
    """One and four satellites at three grades, and one set of sensors."""
    found = mast_paper_cases()
    assert [made.name for made in found] == ["N4_G1", "N4_G2", "N4_G3", "N1_G1", "N1_G2", "N1_G3"]
    assert [made.run for made in found] == [None, *["N4_G1"] * 5]
    grades = [(float(made.range_rate_sd), float(made.range_sd)) for made in found]
    assert grades == [(0.1, 5), (0.01, 1), (0.001, 0.1)] * 2
    assert all(made.samples == 100_000 for made in found)


def test_the_standard_tier() -> None:
    pairs = mast_standard_cases()
    assert list(dict.fromkeys(stratum for _, stratum in pairs)) == list(MAST_STRATA)
    assert sum(count for _, count, _ in strata_of("mast_antenna")) == len(pairs)
    assert all(stratum_name("mast_antenna", made.name) == stratum for made, stratum in pairs)
    assert {made.name for made in cases_of("mast_antenna", "short")} <= {made.name for made, _ in pairs}
    assert tiers_of("mast_antenna") == ("paper", "standard", "short")
    seeds = [made for made, stratum in pairs if stratum == "seed"]
    assert [int(float(made.seed)) for made in seeds] == list(range(1000, 1008))
