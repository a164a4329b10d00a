"""Sweeps: which cases a grid has, how they are made, and how a file that is wrong is refused."""

from __future__ import annotations

import itertools
import pickle
import tracemalloc
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.cases import DualPrecessionCase, EquatorCase
from sinsdata.tiers import cases_from_toml
from sinsdata.tiers.grid import CaseFileError, GridCases, LinearAxis, LogarithmicAxis
from sinsref.arithmetic import MpArithmetic
from sinsref.exact import ExactNumber

SHARED: dict[str, Any] = {
    "spin_rate": "2*pi", "precession_ratio": "-1", "nutation": "pi/18", "spin_rate_dual": 0.5, "nutation_dual": 10,
    "initial_velocity": [10, 0, 0], "interval": "0.01", "duration": "1",
}  # fmt: skip
FILE = """
[case]
name = "cone"
spin_rate = "2*pi"
nutation_dual = 10
initial_velocity = [10, 0, 0]
interval = "0.01"
duration = "1"
[grid]
precession_ratio = [-1, "1/2"]
nutation = {from = "0.001", to = "1", count = 1000}
spin_rate_dual = {from = 0.01, to = 100, count = 5, spacing = "logarithmic"}
initial_attitude = [[1, 0, 0, 0], [0, 1, 0, 0]]
"""

#: Admissible floats of either sign.
MAGNITUDES = st.floats(1e-12, 1e12).flatmap(lambda x: st.sampled_from([x, -x]))


def _grid(axes: dict[str, Any], **shared: Any) -> GridCases:
    fixed = {key: value for key, value in SHARED.items() if key not in axes}
    return GridCases("dual_precession", {**fixed, **shared}, axes)


def _read(tmp_path: Path, text: str, dataset: str = "dual_precession") -> Any:
    path = tmp_path / "sweep.toml"
    path.write_text(text, encoding="utf-8")
    return cases_from_toml(dataset, path)


def _refusal(tmp_path: Path, text: str) -> str:
    with pytest.raises(CaseFileError) as caught:
        _read(tmp_path, text)
    message = str(caught.value)
    assert message.isprintable()
    assert message.startswith(f"{tmp_path / 'sweep.toml'}: ")
    return message.removeprefix(f"{tmp_path / 'sweep.toml'}: ")


def test_a_file_with_a_grid_is_the_product_of_its_axes(tmp_path: Path) -> None:
    cases = _read(tmp_path, FILE)
    assert isinstance(cases, GridCases)
    assert len(cases) == 2 * 1000 * 5 * 2
    first, last = cases[0], cases[-1]
    assert isinstance(first, DualPrecessionCase)
    assert isinstance(last, DualPrecessionCase)
    assert (first.name, last.name) == ("cone_000000", "cone_019999")
    assert (first.precession_ratio.text, first.nutation.text) == ("-1", "0.001")
    assert (last.precession_ratio.text, last.nutation.text) == ("1/2", "1")
    assert last.spin_rate_dual.fraction == 100
    assert [x.text for x in last.initial_attitude or ()] == ["0", "1", "0", "0"]


def test_the_last_axis_runs_fastest() -> None:
    cases = _grid({"precession_ratio": ["1/2", "1/3", "1/4"], "nutation_dual": [7, 8]})
    assert [case.name for case in cases] == [f"00000{i}" for i in range(6)]
    found = [(c.precession_ratio.text, c.nutation_dual.text) for c in cases if isinstance(c, DualPrecessionCase)]
    assert found == list(itertools.product(["1/2", "1/3", "1/4"], ["7", "8"]))


def test_a_grid_is_a_sequence() -> None:
    cases = _grid({"precession_ratio": [1, 2, 3], "nutation_dual": [7, 8]})
    assert list(cases) == [cases[i] for i in range(6)] == [*cases[:4], *cases[4:]]
    assert cases[-1] == cases[5]
    assert cases[::-2] == [cases[5], cases[3], cases[1]]
    assert cases[2] in cases
    for index in (6, -7):
        with pytest.raises(IndexError):
            cases[index]


def test_equidistant_values_are_exact() -> None:
    values = [axis.fraction for axis in LinearAxis(ExactNumber("0.1"), ExactNumber("0.7"), 10)]
    assert values == [Fraction(1, 10) + Fraction(6, 10) * Fraction(i, 9) for i in range(10)]


def test_equidistant_values_between_irrational_ends_are_exact_expressions() -> None:
    axis, ar = LinearAxis(ExactNumber("-pi/2"), ExactNumber("2"), 7), MpArithmetic(50)
    for i, value in enumerate(axis):
        assert abs(ar.number(value) - (-ar.pi / 2 + (2 + ar.pi / 2) * i / 6)) < 1e-48
        assert ExactNumber(value.text) == value


@settings(derandomize=True, deadline=None, max_examples=60)
@given(start=MAGNITUDES, end=MAGNITUDES, count=st.integers(2, 40))
def test_equidistant_values_between_floats_are_exact(start: float, end: float, count: int) -> None:
    axis = LinearAxis(ExactNumber(start), ExactNumber(end), count)
    for i, value in enumerate(axis):
        exact = Fraction(start) + (Fraction(end) - Fraction(start)) * Fraction(i, count - 1)
        assert value.fraction == ExactNumber(value.text).fraction == exact


@pytest.mark.parametrize(("start", "end"), [("0.01", "100"), ("-3", "-1e-9"), ("pi", "pi/1000"), ("1e-30", "1e30")])
def test_logarithmic_values_are_seventeen_digits_in_constant_proportion(start: str, end: str) -> None:
    axis, ar = LogarithmicAxis(ExactNumber(start), ExactNumber(end), 11), MpArithmetic(60)
    a, b = ar.number(ExactNumber(start)), ar.number(ExactNumber(end))
    assert (axis[0].text, axis[10].text) == (start, end)
    for i in range(1, 10):
        exact = a * (b / a) ** (ar.number(i) / 10)
        # Half a unit of the 17th digit.
        assert abs(ar.number(axis[i]) / exact - 1) <= 5e-17
        assert len(axis[i].text.lstrip("-").partition("E")[0].replace(".", "").strip("0")) <= 17


def test_a_case_is_a_function_of_specification_and_number_alone() -> None:
    axes = {"nutation": {"from": "0", "to": "pi", "count": 1000}, "precession_ratio": [-1, 1]}
    one, other = _grid(axes), _grid(axes)
    assert [other[i] for i in (1999, 0, 777)] == [list(one)[i] for i in (1999, 0, 777)]


def test_a_grid_of_millions_is_small() -> None:
    axes = {
        "nutation": {"from": "0.001", "to": "pi", "count": 10_000},
        "spin_rate_dual": {"from": 0.01, "to": 100, "count": 1000, "spacing": "logarithmic"},
    }
    cases = _grid(axes)
    assert len(cases) == 10**7
    assert cases[9_999_999].name == "9999999"
    assert len(pickle.dumps(cases)) < 2000
    copy = pickle.loads(pickle.dumps(cases))
    assert [copy[i] for i in (0, 1_234_567)] == [cases[i] for i in (0, 1_234_567)]


def test_walking_through_a_grid_keeps_nothing() -> None:
    cases = _grid(
        {"nutation": {"from": 0.001, "to": 3, "count": 10}, "nutation_dual": {"from": 0, "to": 9, "count": 300}}
    )
    for case in itertools.islice(cases, 1200):  # fills the caches
        assert case.samples == 100
    tracemalloc.start()
    for case in cases:
        assert case.samples == 100
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # Three thousand cases kept would be some 1.5 MB; what stays is in the caches, of at most a few thousand numbers.
    assert kept < 500_000


def test_a_grid_without_shared_keys(tmp_path: Path) -> None:
    text = (
        "[grid]\nv_east = [10, 600]\nheight = ['0']\nduration = [60]\ninterval = [60]\ninitial_errors = [[0,0,0,1,0,0]]"
    )
    cases = _read(tmp_path, text, "equator_errors")
    assert [case.name for case in cases] == ["000000", "000001"]
    assert all(isinstance(case, EquatorCase) for case in cases)


def test_a_range_of_one_value() -> None:
    assert len(_grid({"nutation": {"from": 0.5, "to": 0.5, "count": 1}})) == 1


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("precession_ratio = [", "spin_rate = [", "spin_rate stands in [case] and in [grid]; one of them must go"),
        ("precession_ratio =", "precession_rate =", "[grid] 'precession_rate': unknown key; did you mean 'prec"),
        ("nutation_dual = 10", "title = 10", "[case] 'title': unknown key; admissible: spin_rate, "),
        ("nutation_dual = 10", "", "[case] nutation_dual = '(missing)': is required"),
        ('name = "cone"', "name = 5", "[case] name = 5: must be a string"),
        ('name = "cone"', "name = 'a b'", "[case] name = 'a b_000000': must be 1 to 64 letters"),
        ("nutation_dual = 10", "nutation_dual = nan", "[case] nutation_dual = nan: nan is not a finite number"),
        ('[-1, "1/2"]', "[]", "[grid] precession_ratio = []: an axis needs at least one value"),
        ('[-1, "1/2"]', "-1", "[grid] precession_ratio = -1: must be a list of values or a range {from"),
        (
            '[-1, "1/2"]',
            '[-1, "1/0"]',
            "[grid] precession_ratio, value 2: precession_ratio = '1/0': '1/0' has no finite",
        ),
        ("[0, 1, 0, 0]]", "[0, 1, 1, 0]]", "[grid] initial_attitude, value 2: initial_attitude = ['0', '1', '1', '0']"),
        ("[0, 1, 0, 0]]", "[0, 1, 0]]", "[grid] initial_attitude, value 2: initial_attitude = [0, 1, 0]: must have 4"),
        ("count = 1000", "count = 1", "[grid] nutation.count = 1: must be at least 2 where the ends differ"),
        ("count = 1000", "count = 0", "[grid] nutation.count = 0: must be an integer from 1 to 10000000"),
        ("count = 1000", "count = 5.0", "[grid] nutation.count = 5.0: must be an integer"),
        ("count = 1000", "count = true", "[grid] nutation.count = True: must be an integer"),
        ("count = 1000", "steps = 9", "[grid] nutation.steps = 9: unknown key of a range; admissible: from, to, "),
        (", count = 1000", "", "[grid] nutation.count = '(missing)': is required in a range"),
        ('to = "1"', 'to = "one"', "[grid] nutation.to = 'one': 'one' in 'one' is outside the grammar"),
        ('to = "1"', "to = 1e300", "[grid] nutation.to = 1e+300: must be 0, or 1e-30 to 1e+30"),
        ("count = 1000", "count = 2000000", "[grid]: 40000000 cases (precession_ratio 2 x nutation 2000000 x "),
        ("from = 0.01", "from = -0.01", "[grid] spin_rate_dual.from = -0.01: must have the sign of `to`"),
        ("from = 0.01", "from = 0", "[grid] spin_rate_dual.from = 0: must have the sign of `to`"),
        ('"logarithmic"', '"log"', "[grid] spin_rate_dual.spacing = 'log': must be one of: linear, logarithmic"),
        ('interval = "0.01"', 'interval = "0.3"', "[case] duration = 1: must be a whole number of intervals"),
        ("[case]", "[[case]]", "cases beside a grid; a case file holds [[case]] tables, or one [case] and a [grid]"),
        ("[grid]", "[sweep]", "unknown key 'sweep'; a case file holds [[case]] tables, or one [case] and a [grid]"),
        ("[grid]", "[[grid]]", "cases beside a grid; a case file holds"),
    ],
)
def test_a_grid_that_cannot_be_used_is_refused(tmp_path: Path, old: str, new: str, reason: str) -> None:
    assert old in FILE
    assert reason in _refusal(tmp_path, FILE.replace(old, new, 1))


def test_a_grid_without_axes_is_refused(tmp_path: Path) -> None:
    assert "[grid]: no axis; admissible: spin_rate, " in _refusal(tmp_path, FILE.partition("precession_ratio")[0])


def test_an_expression_too_long_between_the_ends_is_refused() -> None:
    long = "+".join(["pi"] * 60)
    with pytest.raises(CaseFileError, match=r"\[grid\] nutation, value 2: an expression has 1 to 200 characters"):
        _grid({"nutation": {"from": long, "to": f"1+{long}", "count": 3}})


def test_a_combination_that_is_not_admissible_is_refused_when_it_is_asked_for() -> None:
    cases = _grid({"interval": ["0.5", "0.25"], "duration": ["1", "0.5"]}, name="pair")
    assert len(list(cases)) == 4
    cases = _grid({"interval": ["0.5", "0.75"], "duration": ["3", "2"]})
    with pytest.raises(CaseFileError, match=r"^grid: \[grid\] case 000003: duration = 2: must be a whole number"):
        list(cases)
    assert cases[2].samples == 4
