"""Case files in TOML."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.cases import DualPrecessionCase, EquatorCase
from sinsdata.generation.generate import generate
from sinsdata.tiers import CaseFileError, cases_from_toml
from sinsdata.verification.verify import verify

TRANSPORT = """
[[case]]
name = "transport"
v_east = 250.0          # m/s
height = 5000.0         # m
duration = 7200.0       # s
interval = 60.0         # s
initial_errors = [0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7]   # dv_N dv_H dv_E (m/s), dH (m), dphi, dlambda (rad)
misalignment = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]   # optional
inertial_longitude = 0.0                           # optional: rad
"""

CONE = """
[[case]]
name = "cone"
spin_rate = "2*pi"
precession_ratio = "-1/3"
nutation = "pi/18"
spin_rate_dual = "0.1"
nutation_dual = 0.1
initial_attitude = ["cos(pi/36)", "sin(pi/36)", 0, 0]
initial_velocity = ["100/3", 0, 1.0]
interval = "0.01"
duration = "1/2"
"""


def _file(tmp_path: Path, content: str | bytes) -> Path:
    path = tmp_path / "my.toml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def _refusal(dataset: str, path: Path) -> str:
    with pytest.raises(CaseFileError) as caught:
        cases_from_toml(dataset, path)
    message = str(caught.value)
    assert message.isprintable()
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


def test_a_transport_aircraft_from_file_to_verified_dataset(tmp_path: Path) -> None:
    (case,) = cases_from_toml("equator_errors", _file(tmp_path, TRANSPORT))
    assert isinstance(case, EquatorCase)
    assert (case.name, case.samples, case.misalignment) == ("transport", 120, None)
    assert case.v_east.fraction == 250
    assert [x.fraction for x in case.initial_errors[3:]] == [1, Fraction(1.57e-7), Fraction(1.57e-7)]
    made = generate("equator_errors", "sweep", [case], tmp_path)
    assert made.manifest["tables"]["truth"]["rows"] == 121
    assert all(check.holds for check in verify(made.folder))


def test_strings_are_exact_and_numbers_binary64(tmp_path: Path) -> None:
    (case,) = cases_from_toml("dual_precession", _file(tmp_path, CONE))
    assert isinstance(case, DualPrecessionCase)
    assert case.samples == 50
    assert case.initial_attitude is not None
    assert case.spin_rate_dual.fraction == Fraction(1, 10)
    assert case.nutation_dual.fraction == Fraction(0.1) != Fraction(1, 10)
    assert case.precession_ratio.fraction == Fraction(-1, 3)
    assert case.initial_velocity[0].fraction == Fraction(100, 3)
    assert case.nutation.fraction is None
    assert float(case.initial_attitude[1]) == 0.08715574274765818  # 0.087155742747658173558... correctly rounded
    made = generate("dual_precession", "sweep", [case], tmp_path)
    assert all(check.holds for check in verify(made.folder))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "no case; a case file holds [[case]] tables"),
        ("# nothing\n", "no case; a case file holds [[case]] tables"),
        ("case = []", "no case; a case file holds [[case]] tables"),
        ("case = 5", "no case; a case file holds [[case]] tables"),
        ('[case]\nname = "a"', "no case; a case file holds [[case]] tables"),
        ("case = [5]", "case 1: must be a table"),
        ('title = "x"\n' + TRANSPORT, "unknown key 'title'; a case file holds [[case]] tables"),
        (TRANSPORT + "\n[[cases]]\n", "unknown key 'cases'"),
        (TRANSPORT * 2, "case 2 (transport): the name occurs twice"),
        (TRANSPORT.replace("250.0", ""), "not TOML: Invalid value (at line 4, column"),
        (TRANSPORT.replace("]]   #", "]   #"), "(at line"),
        (TRANSPORT.replace("height", "v_east"), "(at line 5, column"),
        (TRANSPORT.replace("250.0", "250,0"), "(at line 4, column 13)"),
        (TRANSPORT.replace("250.0", "nan"), "case 1 (transport): v_east = nan: nan is not a finite number"),
        (TRANSPORT.replace("250.0", "-inf"), "case 1 (transport): v_east = -inf: -inf is not a finite number"),
        (TRANSPORT.replace("250.0", "2024-01-01"), "v_east = datetime.date(2024, 1, 1): must be a number"),
        (TRANSPORT.replace("250.0", "1e999"), "v_east = inf: inf is not a finite number"),
        (TRANSPORT.replace("250.0", "9" * 5000), "not TOML: Exceeds the limit"),
        (TRANSPORT.replace("250.0", "0x" + "f" * 5000), "v_east = (an integer of 20000 bits): must be 0, or"),
        (TRANSPORT.replace("250.0", "[" * 5000 + "]" * 5000), "not TOML: maximum recursion depth"),
        (b"\xff\xfe[\x00[\x00", "not TOML: 'utf-8' codec can't decode byte 0xff in position 0"),
        (TRANSPORT.encode().replace(b"transport", b"caf\xe9"), "not TOML: 'utf-8' codec can't decode byte 0xe9"),
        (b"\x00\x01\x02", "not TOML: Invalid statement (at line 1, column 1)"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(tmp_path: Path, content: str | bytes, reason: str) -> None:
    assert reason in _refusal("equator_errors", _file(tmp_path, content))


def test_a_case_of_another_dataset_is_refused(tmp_path: Path) -> None:
    assert "case 1 (cone): spin_rate = '2*pi': unknown key" in _refusal("equator_errors", _file(tmp_path, CONE))


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    assert _refusal("equator_errors", tmp_path / "none.toml") == "No such file or directory"
    assert _refusal("equator_errors", tmp_path) == "Is a directory"
    # A loop of links: nobody can read it, not even root, whom permissions do not hold back.
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    assert _refusal("equator_errors", tmp_path / "loop.toml") == "Too many levels of symbolic links"


def test_an_unknown_dataset_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseFileError, match="unknown dataset 'equator'; admissible: equator_errors, dual_prec"):
        cases_from_toml("equator", _file(tmp_path, TRANSPORT))


@settings(derandomize=True, deadline=None, max_examples=150)
@given(position=st.integers(0, len(TRANSPORT) - 1), replacement=st.binary(max_size=3))
def test_a_damaged_file_is_refused_or_read(
    tmp_path_factory: pytest.TempPathFactory, position: int, replacement: bytes
) -> None:
    content = TRANSPORT.encode()
    path = _file(tmp_path_factory.mktemp("damaged"), content[:position] + replacement + content[position + 1 :])
    refusal = ""
    try:
        cases_from_toml("equator_errors", path)
    except CaseFileError as error:
        refusal = str(error)
    assert refusal.isprintable()
    assert not refusal or refusal.startswith(f"{path}: ")
