"""The page of methods: all of them, and the numbers that the code beside it measures."""

from pathlib import Path

import pytest

from sinsbench.methods_page import MethodRow, method_rows, page
from sinsbench.subjects.registry import BUILT_IN, DUAL_PRECESSION, subjects_of

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "methods.md").read_text(encoding="utf-8")
TABLE = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line.startswith("|")]
PRINTED = {line[0].strip("`"): line for line in TABLE[2:]}
# One of each kind: optimised for coning, asymmetric, and a fit.
RECOMPUTED = ("miller3_coning", "park5", "panov6", "taylor4")


def test_every_integrator_has_its_row_in_the_order_of_the_list():
    assert list(PRINTED) == [subject.name for subject in subjects_of(DUAL_PRECESSION)]


def test_theory_and_sources_are_those_of_the_list():
    empty = dict.fromkeys(
        ("observed_order", "secular_observed_order", "secular_drift_deg_per_h", "flops_per_sample", "state_bytes")
    )
    for name, line in PRINTED.items():
        cells = list(MethodRow(name, dict.fromkeys(("coning", "general", "narrow"), empty)).cells())
        theory = [0, 1, 2, 5, 8, -1]
        assert [line[i] for i in theory] == [cells[i] for i in theory]


@pytest.fixture(scope="module")
def recomputed():
    return {row.name: list(row.cells()) for row in method_rows(RECOMPUTED)}


@pytest.mark.parametrize("name", RECOMPUTED)
def test_the_numbers_can_be_made_again(recomputed, name):
    for printed, made in zip(PRINTED[name], recomputed[name], strict=True):
        if printed.replace(".", "").replace("e-", "").replace("e+", "").isdigit():
            # Orders are printed with two decimals, drifts with four digits: half a unit, and half of another machine's.
            assert float(made) == pytest.approx(float(printed), rel=1e-3, abs=0.01 if float(printed) >= 1 else 0)
        else:
            assert made == printed


@pytest.mark.parametrize("name", [name for name in PRINTED if BUILT_IN[name].order_coning], ids=lambda name: name)
def test_orders_optimised_for_coning_are_seen_on_a_narrow_cone_and_nowhere_else(name):
    drift_general, narrow = float(PRINTED[name][7]), float(PRINTED[name][9])
    # The fit reaches to 10 samples a turn, where the next power of the interval still matters: 0.3 at most.
    assert narrow == pytest.approx(BUILT_IN[name].order_coning, abs=0.3)
    assert drift_general == pytest.approx(4, abs=0.3)


def test_the_page_is_what_the_module_prints():
    introduction = PAGE[: PAGE.index("\n|")]
    assert page([]).startswith(introduction)
