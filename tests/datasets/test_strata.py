"""The tiers of strata: what is declared holds for every case, and every machine makes the same cases."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.tiers import CaseFileError, cases_of, paper_cases, short_cases, standard_cases, stratum_of
from sinsdata.tiers.strata import STRATA, Draw, Stratum
from sinsdata.tiers.strata.declaration import sampling
from sinsdata.truth.certified import RowFormula, blocks
from sinsdata.truth.formulas import (
    WORKING_BITS,
    equator_bits,
    equator_state,
    increment_formula,
    precession_formula,
    transition_formula,
)
from sinsref.arithmetic import MpArithmetic
from sinsref.equator import EquatorModel
from sinsref.equator_modes import modes
from sinsref.exact import ExactNumber
from sinsref.rounding import RoundingTally

#: SHA-256 of every case of the published tiers: they never change, on no machine.
PUBLISHED = {
    "equator_errors": "47b2c06e0d505dbd01111b74c33f349f5ecbec249aed261bb1ac9dae0a63604f",
    "dual_precession": "012f2712f0eb92f149acce0d41775e928731abe63423d4358d354a1a4081b195",
}
HASH = """
import hashlib
from sinsdata.tiers import standard_cases
for dataset in ("equator_errors", "dual_precession"):
    print(hashlib.sha256(repr(standard_cases(dataset)).encode()).hexdigest())
"""


def _model(case: EquatorCase) -> tuple[MpArithmetic, EquatorModel]:
    ar = MpArithmetic(60)
    return ar, EquatorModel.at(ar, case.v_east, case.height)


def _index(case: Case) -> int:
    return int(case.name.rpartition("_")[2])


def _beside(quantity: Callable[[EquatorModel], Any], centres: int, furthest: float) -> Callable[[EquatorCase], bool]:
    """Return the rule: a quantity vanishes to 28 digits for the first cases, and comes near to it for the others.

    `furthest` bounds the quantity, made dimensionless by the Schuler rate, for the other cases.
    """

    def rule(case: EquatorCase) -> bool:
        ar, model = _model(case)
        size = ar.magnitude(quantity(model))
        exact = _index(case) < centres
        return size < 1e-28 if exact else 1e-28 < size < furthest

    return rule


def _within(value: ExactNumber, low: float, high: float) -> bool:
    return low <= abs(float(value)) <= high


def _phase(case: DualPrecessionCase) -> float:
    return abs(float(case.spin_rate) * float(case.interval))


def _is_tilted(case: EquatorCase) -> bool:
    """Every second misalignment is a small rotation: antisymmetric."""
    l = [[x.fraction or Fraction(0) for x in row] for row in case.misalignment or ()]
    antisymmetric = bool(l) and all(l[i][j] == -l[j][i] for i in range(3) for j in range(3))
    sizes = [abs(x) for row in l for x in row if x]
    return antisymmetric == (_index(case) % 2 == 0) and Fraction("1e-7") <= min(sizes) <= max(sizes) <= Fraction("1e-3")


def _decays_at_first(case: EquatorCase) -> bool:
    """After ten minutes the height error is what exp(-beta3 t) leaves, 0.35, within a tenth."""
    ar, model = _model(case)
    height = equator_state(case)(ar, ar.number(600))[3] / ar.number(case.initial_errors[3])
    return bool(abs(height / ar.exp(-modes(ar, model).beta3 * 600) - 1) < 0.1)


def _ratio_offset(case: DualPrecessionCase) -> float:
    """Distance of eps from the number of -1, 0, 1 that the case is about."""
    centre = (-1, 0, 1)[_index(case) % 3]
    return abs(float(ExactNumber(f"{case.precession_ratio.text} - ({centre})")))


def _is_unit(case: DualPrecessionCase) -> bool:
    return sum((x.fraction or Fraction(0)) ** 2 for x in case.initial_attitude or ()) == 1


EQUATOR_RULES: dict[str, Callable[[EquatorCase], bool]] = {
    "ship": lambda c: _within(c.v_east, 0, 20) and c.height.fraction == 0 and 3600 <= float(c.duration) <= 14400,
    "aircraft": lambda c: _within(c.v_east, 60, 600) and _within(c.height, 100, 15000) and float(c.duration) <= 18000,
    "missile": lambda c: (
        -7500 <= float(c.v_east) <= 6500 and _within(c.v_east, 1000, 7500) and _within(c.height, 1e4, 4e5)
    ),
    "single_error": lambda c: sum(bool(float(x)) for x in c.initial_errors) == 1,
    "stability_limit": _beside(lambda m: m.specific_force / m.gravity, 2, 10 / 3000),
    "beyond_limit": lambda c: _model(c)[1].q < 0,
    "vanishing_frame_rate": _beside(lambda m: m.frame_rate / m.schuler_rate, 1, 10 / 7000),
    "vanishing_coriolis_rate": _beside(lambda m: m.coriolis_rate / m.schuler_rate, 1, 1 / 7000),
    "equal_roots": _beside(lambda m: (m.p * m.p + m.q * 4) / m.schuler_rate**4, 2, 1e-2),
    "schuler_resonance": _beside(lambda m: (m.frame_rate / m.schuler_rate) ** 2 - 1, 2, 1e-3),
    "double_rate_resonance": _beside(
        lambda m: ((m.frame_rate * 2) ** 4 - (m.frame_rate * 2) ** 2 * m.p - m.q) / m.schuler_rate**4, 2, 1e-2
    ),
    "misalignment": lambda c: _is_tilted(c) and _within(c.v_east, 0, 600),
    "long_duration": lambda c: 12 * 3600 <= float(c.duration) <= 24 * 3600,
    "cancellation": _decays_at_first,
    "extreme_errors": lambda c: all(_within(x, 1e-20, 1e20) for x in c.initial_errors),
    "heights": lambda c: -11000 <= float(c.height) < 0 or 1e5 <= float(c.height) <= 4e7,
    "epochs": lambda c: 1e-4 <= float(c.interval) <= 0.1 or 1000 <= float(c.interval) <= 10000,
}
PRECESSION_RULES: dict[str, Callable[[DualPrecessionCase], bool]] = {
    "coning": lambda c: c.precession_ratio.fraction == -1 and _within(c.nutation, 1e-4, 0.2),
    "general": lambda c: _within(c.spin_rate, 0.5, 20) and _within(c.precession_ratio, 0.1, 3),
    "special_ratio": lambda c: _ratio_offset(c) == 0 if _index(c) < 3 else 1e-14 <= _ratio_offset(c) <= 1,
    "small_nutation": lambda c: _within(c.nutation, 1e-16, 1),
    "near_pi_nutation": lambda c: 1e-12 <= float(ExactNumber(f"pi - ({c.nutation.text})")) <= 1,
    "flat_nutation": lambda c: c.nutation.text in ("0", "pi"),
    "slow_spin": lambda c: _within(c.spin_rate, 1e-8, 1e-4),
    "fast_spin": lambda c: _within(c.spin_rate, 100, 1e4) and 0.0095 <= _phase(c) <= 1.05,
    "large_dual": lambda c: _within(c.spin_rate_dual, 1e3, 1e6) and _within(c.nutation_dual, 1e3, 1e6),
    "zero_dual": lambda c: c.spin_rate_dual.fraction == 0 == c.nutation_dual.fraction,
    "one_dual": lambda c: (c.spin_rate_dual.fraction == 0) != (c.nutation_dual.fraction == 0),
    # The interval is rounded to two digits, by up to 5 % of itself.
    "fine_sampling": lambda c: 0.95e-6 <= _phase(c) <= 1.05e-3,
    "coarse_sampling": lambda c: 0.475 <= _phase(c) <= 10.5,
    "long_duration": lambda c: c.duration.fraction == 86400 and _within(c.spin_rate, 1e-4, 0.01),
    "initial_attitude": _is_unit,
    "large_velocity": lambda c: all(_within(x, 1e4, 1e7) for x in c.initial_velocity),
}
RULES: dict[str, dict[str, Callable[[Any], bool]]] = {
    "equator_errors": EQUATOR_RULES,
    "dual_precession": PRECESSION_RULES,
}


@pytest.fixture(params=list(STRATA))
def dataset(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_each_stratum_has_the_declared_number_of_cases_and_names_are_unique(dataset: str) -> None:
    cases = standard_cases(dataset)
    names = [case.name for case in cases]
    assert len(cases) == len(set(names)) == sum(stratum.count for stratum in STRATA[dataset]) == 200
    found = [stratum_of(dataset, name) for name in names]
    for stratum in STRATA[dataset]:
        assert found.count(stratum) == stratum.count


def test_every_stratum_has_a_rule_in_one_sentence(dataset: str) -> None:
    assert set(RULES[dataset]) == {stratum.name for stratum in STRATA[dataset]}
    assert all(s.rule.endswith(".") and ". " not in s.rule for s in STRATA[dataset])


@pytest.mark.parametrize(("of", "stratum"), [(of, s) for of, strata in STRATA.items() for s in strata])
def test_the_rule_of_a_stratum_holds_for_each_case(of: str, stratum: Stratum) -> None:
    cases = [case for case in standard_cases(of) if stratum_of(of, case.name) == stratum]
    broken = [case.name for case in cases if not RULES[of][stratum.name](case)]
    assert not broken


@pytest.mark.parametrize("environment", [{"PYTHONHASHSEED": "1", "LC_ALL": "C"}, {"PYTHONHASHSEED": "77", "TZ": "X-9"}])
def test_other_processes_make_the_same_cases(environment: dict[str, str]) -> None:
    made = subprocess.run(
        [sys.executable, "-c", HASH], env={**os.environ, **environment}, capture_output=True, text=True, check=True
    )
    assert made.stdout.split() == list(PUBLISHED.values())


def test_the_cases_are_the_published_ones(dataset: str) -> None:
    assert hashlib.sha256(repr(standard_cases(dataset)).encode()).hexdigest() == PUBLISHED[dataset]


def test_a_case_depends_on_stratum_and_index_alone(dataset: str) -> None:
    for stratum in reversed(STRATA[dataset]):
        last = stratum.mapping(dataset, stratum.count - 1)
        case = next(case for case in standard_cases(dataset) if case.name == last["name"])
        assert case == type(case).from_mapping(last)


def test_the_short_tier_takes_small_cases_of_several_strata(dataset: str) -> None:
    short = short_cases(dataset)
    assert 4 <= len(short) <= 5
    assert set(short) <= set(standard_cases(dataset))
    assert len({stratum_of(dataset, case.name) for case in short}) == len(short)
    # Some 500 bytes a row in all tables: below 150 kB.
    assert sum(case.samples + 1 for case in short) <= 340


def test_the_size_of_the_standard_tier(dataset: str) -> None:
    low, high = {"equator_errors": (30_000, 60_000), "dual_precession": (100_000, 150_000)}[dataset]
    assert low <= sum(case.samples + 1 for case in standard_cases(dataset)) <= high


def _formulas(case: Case) -> list[tuple[RowFormula, int]]:
    if isinstance(case, EquatorCase):
        return [(f(case), equator_bits(case)) for f in (equator_state, transition_formula)]
    assert isinstance(case, DualPrecessionCase)
    return [(f(case), WORKING_BITS) for f in (increment_formula, precession_formula)]


def test_the_first_and_the_last_case_of_each_stratum_can_be_certified(dataset: str) -> None:
    cases = {case.name: case for case in standard_cases(dataset)}
    for stratum in STRATA[dataset]:
        for index in (0, stratum.count - 1):
            case, tally = cases[stratum.case_name(index)], RoundingTally()
            for formula, bits in _formulas(case):
                (block,) = blocks(formula, case.interval, case.samples - 1, 2, bits, tally)
                assert block.high.shape == block.low.shape
                assert abs(block.low).max() <= 2.0**-53 * abs(block.high).max()


def test_tiers_are_found_by_name(dataset: str) -> None:
    assert cases_of(dataset, "paper") == paper_cases(dataset)
    assert cases_of(dataset, "short") == short_cases(dataset)
    with pytest.raises(CaseFileError, match=f"{dataset} has no tier 'long'; admissible: paper, standard, short"):
        cases_of(dataset, "long")


@pytest.mark.parametrize("name", ["coning_018", "coning_7", "coning_0007", "coning", "cone_001", "coning_٠٠٧", ""])
def test_other_names_belong_to_no_stratum(name: str) -> None:
    assert stratum_of("dual_precession", name) is None


def test_draws_are_uniform() -> None:
    draws = [Draw("d", "s", index) for index in range(4000)]
    numbers = [float(draw.fraction("x")) for draw in draws]
    # The mean of 4000 numbers is within five standard deviations, 5 sqrt(1/12/4000), of 1/2.
    assert abs(sum(numbers) / 4000 - 0.5) < 0.023
    decades = [float(draw.log_uniform("x", "1e-6", "1e6")) < 1 for draw in draws]
    assert abs(sum(decades) / 4000 - 0.5) < 0.04  # five of sqrt(1/4/4000)
    assert {draw.choice("x", "abc") for draw in draws} == set("abc")
    assert {draw.integer("x", -1, 1) for draw in draws} == {-1, 0, 1}


def test_draws_of_other_fields_cases_strata_and_datasets_differ() -> None:
    draws = [Draw("d", "s", 0), Draw("d", "s", 1), Draw("d", "t", 0), Draw("e", "s", 0)]
    assert len({draw.fraction(field) for draw in draws for field in "xy"}) == 8


def test_a_draw_is_the_hash_that_is_stated() -> None:
    digest = hashlib.sha256(b"dual_precession/coning/7/nutation/2013").hexdigest()
    assert Draw("dual_precession", "coning", 7).fraction("nutation") == Fraction(int(digest[:16], 16), 2**64)


def test_drawn_numbers_are_short_decimals_within_their_bounds() -> None:
    for index in range(300):
        draw = Draw("d", "s", index)
        for text, low, high in (
            (draw.uniform("u", "-20", "20"), -20, 20),
            (draw.log_uniform("l", "1e-8", "1e-5"), 1e-8, 1e-5),
            (draw.log_uniform("m", "1e4", "4e12"), 1e4, 4e12),
        ):
            assert low <= float(text) <= high
            assert len(text.lstrip("-").partition("e")[0].replace(".", "").strip("0")) <= 4


def test_the_duration_is_exactly_a_number_of_intervals() -> None:
    assert sampling("0.0001234", 7) == {"interval": "0.0001234", "duration": "0.0008638"}
    assert sampling("60", 1440)["duration"] == "86400"
