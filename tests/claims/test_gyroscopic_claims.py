"""The claims of Chelnokov 1991: verdicts on record, numbers computed apart, and that a changed print is noticed."""

import json
import re
from collections import Counter
from dataclasses import replace
from math import asin, atan, log2, sqrt
from pathlib import Path
from typing import Any

import pytest

from gyroscopic_figures import METHODICAL, RESPONSES
from gyroscopic_motions import SCHULER_SPEED
from sinsbench.claims import Claim, evaluate, load_claims
from sinsbench.claims.evaluate import evaluate_claims
from sinsbench.claims.gyroscopic_recipes import order_in_speed
from sinsbench.claims.model import Call, recorded_verdicts
from sinsbench.claims.quantities import Enclosure
from sinsbench.claims.stories import methodical_story, orders_story

PAPER = "chelnokov1991"
ALL = {claim.id: claim for claim in load_claims(PAPER)}
PAGE = Path(__file__).parents[2] / "reference" / "papers" / "chelnokov1991.md"
QUOTED = {
    "deviation.inclination": 5,
    "bi_gyro.bisector": 2,
    "bi_gyro.bisector_T2": 3,
    "bi_gyro.speed": 3,
    "compass.altitude": 1,
    "frame.linear_spring": 0,
}
"""Figures on the page of the paper, with their decimals."""
EQUATIONS = [name for name, claim in ALL.items() if claim.recompute.name == "equation"]
STANDING = [name for name, claim in ALL.items() if claim.recompute.name == "equation_residual"]
STATES = [name for name, claim in ALL.items() if claim.recompute.name == "residual"]
#: Largest distances within two hours, every 120 s, for the speeds 1/4 and 1/8 of a family, computed apart in float64.
FAMILIES = {
    ("TE", "law"): (2.007855e-05, 2.511338e-06),
    ("TE", "bisector"): (2.132081e-05, 2.666195e-06),
    ("TP", "law"): (8.851820e-06, 1.122383e-06),
    ("TP", "bisector"): (4.564754e-06, 5.689712e-07),
    ("TP", "bisector from rest"): (1.296954e-07, 8.101626e-09),
}


def _verdict(claim: Claim) -> str:
    return evaluate_claims([claim])[0].verdict


def _plural(counts: Counter[str]) -> dict[str, int]:
    names = {"reproduced": "reproduced", "misprint": "misprints", "not reproduced": "not reproduced"}
    return {name: counts[verdict] for verdict, name in names.items()}


def _figures(motion: str, system: str) -> tuple[float, ...]:
    (row,) = (row[3:] for row in METHODICAL if row[:3] == (motion, system, 3600))
    return row


def _ratios(system: str) -> list[float]:
    """Return the largest responses of a system over those of the compass, which are the traditional system's."""
    largest = {row[:3]: row[-1] for row in RESPONSES if row[1].endswith(("bias", "biases"))}
    return [value / largest[(*key[:2], "ghc")] for key, value in largest.items() if key[2] == system]


def _independent() -> dict[str, float]:
    """Return what the numbers are by computations of others, in 45 digits or by DOP853."""
    along, left, *_ = _figures("T3", "gp_paper")
    slow = 300 / SCHULER_SPEED
    ratios = {"bi_gyro": "bg_equilibrium", "self_tuned": "bgx", "pendulum": "gp_equilibrium"}
    return {
        "deviation.inclination": asin(left / sqrt(1 - along * along)) / (470.795163199 / SCHULER_SPEED),
        "deviation.inclination_T1": atan(slow / (1 - slow * slow)) / slow,
        "deviation.plane": along,
        "bi_gyro.bisector": _figures("T3", "bg_paper")[2],
        "bi_gyro.bisector_T2": _figures("T2", "bg_equilibrium")[2],
        "bi_gyro.speed": -0.2220691,
        "compass.altitude": 566.175945,
        **{f"remark.{name}.ratio": (min(_ratios(s)) + max(_ratios(s))) / 2 for name, s in ratios.items()},
    }


@pytest.mark.slow
def test_every_claim() -> None:
    """One test, as all that is run for these claims is run but once in a process."""
    results = {result.id: result for result in evaluate(PAPER)}
    verdicts = {name: result.verdict for name, result in results.items()}
    assert {name: verdict for name, verdict in verdicts.items() if verdict != "reproduced"} == recorded_verdicts(PAPER)
    counts = Counter(verdicts.values())
    assert counts == {"reproduced": 17, "misprint": 17, "not reproduced": 18}
    page = PAGE.read_text(encoding="utf-8")
    assert f"judges {counts.total()}, on the motions" in page
    assert ", ".join(f"{number} {verdict}" for verdict, number in _plural(counts).items()) in page.replace("\n", " ")
    for name, digits in QUOTED.items():
        computed = results[name].computed
        assert isinstance(computed, float)
        assert f" {computed:.{digits}f} " in page.replace("\n", " "), name
    for name, number in _independent().items():
        # Seven digits of the read-out of the speed are given; ratios are rounded to five decimals.
        tolerance = 2e-5 if "ratio" in name else 3e-7
        assert results[name].computed == pytest.approx(number, rel=tolerance), name
    # Within the hour the error is not smaller than at its end.
    spring = results["frame.linear_spring"].computed
    assert isinstance(spring, float)
    assert spring > _figures("T3", "gf_linear")[2]
    assert "recomputed: 1.07447 to 1.23985" in results["remark.pendulum.ratio"].note
    assert "(errors gyro_bias): 0.99925 to 0.99978" in results["remark.bi_gyro.ratio"].note
    assert "order in speed (family TE, error bisector): 2.999" in results["bi_gyro.bisector"].note
    for name in ("compass", "frame", "full"):
        assert results[f"remark.{name}.ratio"].computed == 1
        assert "recomputed: below" in results[f"remark.{name}.difference"].note
        same = replace(ALL[f"remark.{name}.ratio"], printed="= 1")
        assert _verdict(same) == "reproduced"
    for name, claim in ALL.items():
        row = results[name].to_row()
        assert row["rounds_to_printed"] is (row["verdict"] == "reproduced")
        assert row["relative_difference"] is None
        json.dumps(row, allow_nan=False)
        if claim.printed == "= 0":
            assert _verdict(replace(claim, printed="= 1")) == "not reproduced"
            assert verdicts[name] == "not reproduced" or _verdict(replace(claim, printed="> 0.1")) == "not reproduced"
        if claim.printed in ("< 1", "> 0"):
            other = {"< 1": "> 0.9", "> 0": "< 1e-6"}[claim.printed]
            assert _verdict(replace(claim, printed=other)) == "reproduced"


@pytest.mark.parametrize(("family", "error"), FAMILIES)
def test_orders_in_speed(family: str, error: str) -> None:
    value = order_in_speed(family=family, error=error).value
    assert isinstance(value, Enclosure)
    faster, slower = FAMILIES[family, error]
    # Seven digits are given, and float64 leaves some 1e-13 rad.
    assert float(value.middle) == pytest.approx(log2(faster / slower), abs=2e-6 + 1e-13 / slower)
    assert value.upper - value.lower < 1e-7


METHODS = {"gp": ("axis", None), "bg": ("bisector", "speed_error_m_per_s")}
RULES = {"paper": "paper", "equilibrium": "rest"}


@pytest.mark.parametrize("figures", [row for row in METHODICAL if row[1] != "gf_linear"], ids=lambda row: row[:3])
def test_the_methodical_errors_are_those_computed_apart(figures: tuple[Any, ...]) -> None:
    motion, system, time, *numbers, speed = figures
    kind, _, rule = system.partition("_")
    (row,) = (
        row
        for row in methodical_story().rows
        if (row["motion"], row["start"], row["time_s"]) == (motion, RULES[rule], time)
    )
    vector, speed_column = METHODS[kind]
    found = [row[f"{vector}_{column}"] for column in ("along_rad", "left_rad", "from_vertical_m")]
    # Ten digits of the components are given, microns of the distance, and seven digits of the speed.
    assert found == [pytest.approx(number, rel=6e-10) for number in numbers[:2]] + [pytest.approx(numbers[2], abs=6e-7)]
    if speed_column is not None:
        assert row[speed_column] == pytest.approx(speed, rel=6e-7)


def test_the_orders_of_the_story_are_those_of_the_claims() -> None:
    rows = {(row["family"], row["scale"]): row for row in orders_story().rows}
    assert len(rows) == 8
    for (family, error), (faster, slower) in FAMILIES.items():
        column = {"law": "axis_from_law_rad", "bisector": "bisector_rad"}.get(error, "bisector_from_rest_rad")
        # Seven digits are given, and float64 leaves some 1e-13 rad.
        assert rows[family, 0.25][column] == pytest.approx(faster, rel=6e-7, abs=1e-13)
        assert rows[family, 0.125][column] == pytest.approx(slower, rel=6e-7, abs=1e-13)
    assert rows["TE", 1.0]["largest_speed_m_per_s"] == pytest.approx(884.506, abs=6e-4)
    assert rows["TP", 1.0]["bisector_from_rest_rad"] == pytest.approx(3.356479e-5, rel=6e-7)
    assert {row["bisector_order"] is None for (_, scale), row in rows.items() if scale == 1} == {True}
    assert orders_story().sentence.endswith("3.00 on a parallel, and 4.00 on a parallel from rest.")


def _misread(text: str) -> Call:
    return Call("symbols misread", {"right": text, "wrong": f"{text}?"})


@pytest.mark.parametrize("name", EQUATIONS)
def test_equations(name: str) -> None:
    """The printed form fails and its slip explains it; the right form passes; another form explains nothing."""
    claim = ALL[name]
    (result,) = evaluate_claims([claim])
    assert result.verdict == "misprint"
    assert "right form: residual below" in result.note
    assert re.search(r"printed form: residual \d", result.note)
    assert _verdict(replace(claim, printed=str(result.computed))) == "reproduced"
    assert _verdict(replace(claim, printed=claim.printed + " + 1")) == "not reproduced"
    assert _verdict(replace(claim, slips=())) == "not reproduced"
    assert _verdict(replace(claim, slips=claim.slips[:-1])) == "not reproduced"
    # A form that nobody has tested is no misprint, even if a slip would lead to it.
    other = replace(claim, printed=f"{result.computed}?", slips=(_misread(str(result.computed)),))
    assert _verdict(other) == "not reproduced"


@pytest.mark.parametrize(
    ("name", "slip"),
    [
        ("equation.2.11.roll", Call("symbols lost", {"right": " + ", "wrong": " x "})),
        ("equation.2.11.roll", Call("symbols misread", {"right": "^2", "wrong": ""})),  # occurs twice
        ("equation.1.4", Call("symbols lost", {"right": "e", "wrong": "e"})),
        ("equation.1.4", Call("sign dropped", {})),
        ("equation.2.14", Call("symbols lost", {"right": "Y2", "wrong": "Y1"})),
        ("equation.2.14", Call("symbols misread", {"right": "Y3", "wrong": "Y1"})),
        ("bi_gyro.bisector_T2", Call("symbols misread", {"right": "1", "wrong": "0"})),
    ],
)
def test_a_wrong_slip_explains_nothing(name: str, slip: Call) -> None:
    assert _verdict(replace(ALL[name], slips=(slip,))) == "not reproduced"


@pytest.mark.parametrize("name", [*STANDING, *STATES])
def test_the_margin_of_an_equality_decides(name: str) -> None:
    """No margin, no equality that balls could prove; a margin of 1 proves what is wrong by less."""
    claim = ALL[name]
    assert _verdict(claim) == recorded_verdicts(PAPER).get(name, "reproduced")
    assert _verdict(replace(claim, within=claim.within * 0)) == "not reproduced"
    assert _verdict(replace(claim, within=claim.within * 0 + 1)) == "reproduced"
    assert _verdict(replace(claim, printed="> 0.5")) == "not reproduced"
