"""Frames keep units and refuse what is not there."""

from pathlib import Path

import pytest

from sinsdata.cases import EquatorCase
from sinsdata.format.manifest import DatasetError
from sinsdata.generation.generate import generate
from sinsdata.publishing.loading import Dataset

CASE = {
    "v_east": 600, "height": 10000, "duration": 600, "interval": 60,
    "initial_errors": ["0.01", "0.01", "0.01", 1, "1.57e-7", "1.57e-7"],
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    cases = [EquatorCase.from_mapping({"name": name, **CASE}) for name in ("first", "second")]
    return generate("equator_errors", "sweep", cases, tmp_path_factory.mktemp("data")).folder


def test_a_frame_keeps_units_descriptions_and_frames(folder: Path) -> None:
    frame = Dataset(folder).frame("truth")
    assert len(frame) == 22
    assert frame.attrs["units"]["dv_up"] == frame.attrs["units"]["dv_up_lo"] == "m/s"
    assert frame.attrs["descriptions"]["d_height"] == "error of the height"
    assert frame.attrs["frames"]["dv_north"] == "north-up-east"
    assert set(frame.attrs["units"]) == set(frame.columns)


def test_a_frame_of_one_case(folder: Path) -> None:
    frame = Dataset(str(folder)).frame("truth", ["second"])
    assert set(frame["case"]) == {"second"}
    assert len(frame) == 11


@pytest.mark.parametrize(
    ("table", "cases", "hint"), [("sensors", None, "transition"), ("truth", ["third"], "first, second")]
)
def test_what_is_not_there_is_named_with_what_is(folder: Path, table: str, cases: list[str] | None, hint: str) -> None:
    with pytest.raises(DatasetError, match=hint):
        Dataset(folder).frame(table, cases)
