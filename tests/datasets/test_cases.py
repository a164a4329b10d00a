"""Cases: what is admissible, what a number means, and what a user is told who made a mistake."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.cases import CASE_CLASSES, CaseError, DualPrecessionCase, EquatorCase
from sinsdata.tiers import CaseFileError, checked_cases
from sinsref.earth import SEMI_MAJOR_AXIS
from sinsref.exact import ExactNumber

EQUATOR, PRECESSION = "equator_errors", "dual_precession"
NAN, INFINITY = float("nan"), float("inf")

# dataset, changed keys, field in the message, value in the message, what would do
BAD = [
    (EQUATOR, {"v_east": NAN}, "v_east", "nan", "finite"),
    (EQUATOR, {"height": INFINITY}, "height", "inf", "finite"),
    (EQUATOR, {"initial_errors": [0, 0, -INFINITY, 0, 0, 0]}, "initial_errors[2]", "-inf", "finite"),
    (PRECESSION, {"nutation": NAN}, "nutation", "nan", "finite"),
    (EQUATOR, {"height": -6378245.0}, "height", "-6378245", "above the Earth's centre"),
    (EQUATOR, {"height": -1e7}, "height", "-10000000", "above the Earth's centre"),
    (EQUATOR, {"interval": 0.0}, "interval", "0", "greater than 0 s"),
    (EQUATOR, {"interval": -60.0}, "interval", "-60", "greater than 0 s"),
    (PRECESSION, {"duration": 0}, "duration", "0", "greater than 0 s"),
    (PRECESSION, {"duration": "-pi"}, "duration", "-pi", "greater than 0 s"),
    (EQUATOR, {"duration": 90.0}, "duration", "90", "whole number of intervals, at most 1e9; near it: 120 s"),
    (PRECESSION, {"duration": 0.01}, "duration", "0.01", "near it: 0.1 s"),
    (PRECESSION, {"duration": 1e12}, "duration", "1000000000000", "near it: 100000000 s"),
    (EQUATOR, {"initial_errors": [0, 0, 0]}, "initial_errors", "[0, 0, 0]", "6 elements, not 3"),
    (EQUATOR, {"initial_errors": 1.0}, "initial_errors", "1.0", "list of 6 numbers"),
    (EQUATOR, {"initial_errors": "000000"}, "initial_errors", "'000000'", "list of 6 numbers"),
    (EQUATOR, {"misalignment": [[0, 0, 0], [0, 0, 0]]}, "misalignment", "[[0, 0, 0]", "3 lists of 3 numbers"),
    (EQUATOR, {"misalignment": [[0, 0, 0], [0, 0], [0, 0, 0]]}, "misalignment[1]", "[0, 0]", "3 elements, not 2"),
    (EQUATOR, {"misalignment": [1, 2, 3]}, "misalignment[0]", "1", "list of 3 numbers"),
    (PRECESSION, {"initial_velocity": [1, 2, 3, 4]}, "initial_velocity", "[1, 2, 3, 4]", "3 elements, not 4"),
    (PRECESSION, {"initial_attitude": [1, 0, 0]}, "initial_attitude", "[1, 0, 0]", "4 elements, not 3"),
    (PRECESSION, {"initial_attitude": [1, 1, 0, 0]}, "initial_attitude", "['1', '1'", "norm 1 within 1e-6, not 1.414"),
    (PRECESSION, {"initial_attitude": [0, 0, 0, 0]}, "initial_attitude", "['0', '0'", "norm 1 within 1e-6, not 0"),
    (PRECESSION, {"spin_rate": 0}, "spin_rate", "0", "must not be 0"),
    (EQUATOR, {"v_east": True}, "v_east", "True", "must be a number"),
    (EQUATOR, {"initial_errors": [0, 0, 0, False, 0, 0]}, "initial_errors[3]", "False", "must be a number"),
    (EQUATOR, {"v_east": [1.0]}, "v_east", "[1.0]", "must be a number"),
    (EQUATOR, {"v_east": {"value": 1}}, "v_east", "{'value': 1}", "must be a number"),
    (EQUATOR, {"name": ""}, "name", "''", "1 to 64 letters"),
    (EQUATOR, {"name": 5}, "name", "5", "1 to 64 letters"),
    (EQUATOR, {"name": "../../etc"}, "name", "'../../etc'", "1 to 64 letters"),
    (EQUATOR, {"name": "two\nlines"}, "name", r"'two\nlines'", "1 to 64 letters"),
    (EQUATOR, {"name": "n" * 65}, "name", "'nnnnn", "1 to 64 letters"),
    (EQUATOR, {"v_esat": 1.0}, "v_esat", "1.0", "did you mean 'v_east'?"),
    (EQUATOR, {"hieght": 1.0}, "hieght", "1.0", "did you mean 'height'?"),
    (PRECESSION, {"zzz": 1.0}, "zzz", "1.0", "admissible keys: name, spin_rate,"),
    (PRECESSION, {"two\nlines": 1.0}, r"'two\nlines'", "1.0", "unknown key"),
    (EQUATOR, {"height": None}, "height", "(missing)", "is required"),
    (PRECESSION, {"name": None}, "name", "(missing)", "is required"),
    (EQUATOR, {"v_east": 1e308}, "v_east", "1e+308", "1e-30 to 1e+30"),
    (EQUATOR, {"height": 5e-324}, "height", "5e-324", "1e-30 to 1e+30"),
    (EQUATOR, {"initial_errors": [1e300, 0, 0, 0, 0, 0]}, "initial_errors[0]", "1e+300", "1e-30 to 1e+30"),
    (PRECESSION, {"spin_rate": 10**400}, "spin_rate", "1329 bits", "1e-30 to 1e+30"),
    (PRECESSION, {"spin_rate": 1 << 20000}, "spin_rate", "20001 bits", "1e-30 to 1e+30"),
    (PRECESSION, {"interval": 1e-320, "duration": 1e300}, "interval", "1e-320", "1e-30 to 1e+30"),
    (PRECESSION, {"initial_attitude": [1e200, 0, 0, 0]}, "initial_attitude[0]", "1e+200", "1e-30 to 1e+30"),
    (PRECESSION, {"nutation": "1e-400"}, "nutation", "1e-400", "1e-30 to 1e+30"),
    (EQUATOR, {"duration": 6e8}, "duration", "600000000", "leave the range of binary64; at this speed at most"),
    (EQUATOR, {"height": -6378244.999}, "duration", "600", "leave the range of binary64"),
]

OUTSIDE_THE_GRAMMAR = [
    "", " ", "nan", "inf", "x", "Pi", "2**3", "2^3", "1//2", "7 % 2", "1 if 1 else 2", "1,2", "[1]", "'1'", "1j",
    "True", "None", "0x10", "0b1", "0o7", "1__0", "1e", "1 2", "pi pi", "2pi", "(1", "1)", "--", "٣", "１", "tan(1)",
    "sin()", "sin(1, 2)", "sin(x=1)", "sin", "pi()", "math.pi", "__import__('os')", "open('x').read()", "(lambda: 1)()",
    "1\x00", "1e400", "1e999999999", "1e-999999999", "1e9_9_9_9_9_9_9_9_9", "1/0", "1/(pi-pi)", "1/sin(pi)", "sqrt(-1)",
    "1/(sin(1)-sin(1))", "1+sqrt(sin(1)-sin(1))", "sin(1)-sin(1)", "(" * 150 + "1" + ")" * 150, "1+" * 150 + "1",
]  # fmt: skip


@pytest.mark.parametrize(("dataset", "changes", "field", "value", "admissible"), BAD)
def test_a_bad_value_is_named_in_one_line(
    mapping: Any, dataset: str, changes: dict[str, Any], field: str, value: str, admissible: str
) -> None:
    entry = mapping(dataset, **changes)
    with pytest.raises(CaseFileError) as caught:
        checked_cases(dataset, [entry], "my.toml")
    message = str(caught.value)
    place, _, rest = message.partition(f"{field} = ")
    assert message.isprintable()
    # A case is named by its number, and by its name where that is a name.
    assert place.startswith(f"my.toml: case 1 ({entry['name']}): " if "name" not in changes else "my.toml: case 1")
    assert value in rest.removesuffix(admissible)
    assert admissible in rest


@pytest.mark.parametrize("text", OUTSIDE_THE_GRAMMAR)
@pytest.mark.filterwarnings("default::SyntaxWarning")  # Python's own, on the text that it is about to refuse
def test_an_expression_outside_the_grammar_is_refused(mapping: Any, text: str) -> None:
    with pytest.raises(CaseError, match=r"^nutation = ") as caught:
        DualPrecessionCase.from_mapping(mapping(PRECESSION, nutation=text))
    message = str(caught.value)
    assert message.isprintable()
    assert re.search(
        r"admissible: decimal numbers|has no finite real value|1 to \d+ characters|1e-30 to 1e\+30", message
    )


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("1/3", Fraction(1, 3)),
        ("0.1", Fraction(1, 10)),
        ("1.5E-7", Fraction(15, 10**8)),
        ("-(2 - 1/4)*.5", Fraction(-7, 8)),
        (" +7. ", Fraction(7)),
        ("sqrt(1/4)", Fraction(1, 2)),
        ("cos(pi/3)", Fraction(1, 2)),
        (0.1, Fraction(0.1)),
        (1e-30, Fraction(1e-30)),
        (1e30, Fraction(1e30)),
        (-3, Fraction(-3)),
        (-0.0, Fraction(0)),
    ],
)
def test_a_string_means_what_it_says_and_a_number_its_binary64(mapping: Any, text: Any, meaning: Fraction) -> None:
    case = DualPrecessionCase.from_mapping(mapping(PRECESSION, spin_rate_dual=text))
    assert case.spin_rate_dual.fraction == meaning
    assert ExactNumber(case.spin_rate_dual.text).fraction == meaning  # the text alone carries it


def test_pi_is_no_float(mapping: Any) -> None:
    case = DualPrecessionCase.from_mapping(mapping(PRECESSION, nutation="pi/18"))
    assert case.nutation.fraction is None
    assert float(case.nutation) == math.pi / 18
    assert case.nutation != DualPrecessionCase.from_mapping(mapping(PRECESSION, nutation=math.pi / 18)).nutation


@pytest.mark.parametrize(
    "changes",
    [
        {"height": f"-{SEMI_MAJOR_AXIS.text} + 1000000"},
        {"v_east": "-7.29e-5*6383245"},  # the rate of the frame vanishes
        {"v_east": -9000},
        {"v_east": 20000},
        {"initial_errors": [0] * 6},
        {"misalignment": [[1e-3] * 3] * 3, "inertial_longitude": "pi/4"},
        {"interval": 600},
    ],
)
def test_hard_cases_on_the_equator_are_admissible(mapping: Any, changes: dict[str, Any]) -> None:
    case = EquatorCase.from_mapping(mapping(EQUATOR, **changes))
    assert case.samples == round(600 / float(case.interval))


def test_a_misalignment_of_zeros_is_none(mapping: Any) -> None:
    zeros = EquatorCase.from_mapping(mapping(EQUATOR, misalignment=[[0, 0.0, "0"]] * 3))
    assert zeros == EquatorCase.from_mapping(mapping(EQUATOR))


def test_a_case_cannot_be_changed_and_hashes_by_value(mapping: Any) -> None:
    cases = [DualPrecessionCase.from_mapping(mapping(PRECESSION)) for _ in range(2)]
    assert len(set(cases)) == 1
    with pytest.raises(AttributeError):
        cases[0].duration = ExactNumber(1)  # type: ignore[misc]


_scalars = (
    st.none() | st.booleans() | st.integers() | st.integers(-(2**3000), 2**3000) | st.floats() | st.text(max_size=30)
    | st.dates() | st.times() | st.datetimes()
    | st.text(alphabet="0123456789.eE+-*/()pisqrtncoxj_ ", max_size=14)
    | st.sampled_from(OUTSIDE_THE_GRAMMAR)
)  # fmt: skip
_values = st.recursive(
    _scalars,
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=9,
)


@pytest.mark.parametrize("dataset", [EQUATOR, PRECESSION])
@pytest.mark.filterwarnings("ignore::SyntaxWarning")  # Python's own, on random texts
@settings(derandomize=True, deadline=None, max_examples=150)
@given(data=st.data())
def test_no_mapping_raises_anything_else(mapping: Any, dataset: str, data: st.DataObject) -> None:
    """Any values under the known keys, and any unknown keys."""
    keys = sorted(CASE_CLASSES[dataset].__dataclass_fields__)
    changed = data.draw(st.dictionaries(st.sampled_from(keys) | st.text(max_size=8), _values, min_size=1, max_size=4))
    refusal = ""
    try:
        (case,) = checked_cases(dataset, [{**mapping(dataset), **changed}], "my.toml")
        assert case.samples >= 1
    except CaseFileError as error:
        refusal = str(error)
    assert refusal.isprintable()
    assert not refusal or refusal.startswith("my.toml: case 1")
