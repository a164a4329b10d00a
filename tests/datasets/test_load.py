"""Loading: from the cache and from folders, checked before it is read, with units, at once."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import sinsdata
from sinsdata.format.manifest import DatasetError
from sinsdata.generation.generate import Generated
from sinsdata.publishing import loading
from sinsdata.publishing.archives import ArchiveError
from sinsdata.publishing.fetch import FetchError, UnavailableError
from sinsdata.publishing.loading import Dataset, load
from sinsdata.publishing.publish import publish

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]

NAME, TIER = "dual_precession", "sweep"


@pytest.fixture(scope="module")
def bundle(make_dataset: MakeDataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("published")
    make_dataset(NAME, folder / "data")
    return publish(folder / "data", folder / "bundle").folder


@pytest.fixture
def dataset(bundle: Path) -> Dataset:
    return Dataset(bundle / NAME / TIER)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SINSBENCH_DATA", str(tmp_path / "cache"))
    monkeypatch.delenv("SINSBENCH_MIRRORS", raising=False)
    return tmp_path / "cache"


def test_a_dataset_says_what_it_holds(dataset: Dataset) -> None:
    assert dataset.cases == ("cone", "other")
    assert {"cases", "increments", "truth"} <= set(dataset.tables)
    assert "dual_precession, tier sweep" in repr(dataset)


def test_a_table_is_the_file_with_its_units(dataset: Dataset) -> None:
    table = dataset.table("truth")
    assert table.equals(pq.read_table(dataset.folder / "truth.parquet"))
    assert table.schema.field("w_body_x").metadata[b"unit"] == b"m/s"
    assert pa.Table.from_batches(dataset.batches("truth")).equals(table)


def test_rows_of_a_case_as_table_frame_and_arrays(dataset: Dataset) -> None:
    whole = dataset.frame("truth")
    rows = whole[whole["case"] == "other"]
    frame = dataset.frame("truth", ["other"])
    assert frame.equals(rows.reset_index(drop=True))
    assert frame.attrs["units"]["w_body_x"] == "m/s"
    assert sinsdata.Dataset(dataset.folder).frame("truth", ["other"]).equals(frame)
    arrays = dataset.arrays("truth", "other")
    assert set(arrays) == set(frame.columns) - {"case"}
    for name, values in arrays.items():
        np.testing.assert_array_equal(values, frame[name].to_numpy())
    assert len(dataset.table("truth", [])) == 0


def test_what_is_not_there_is_named_with_what_is(dataset: Dataset) -> None:
    with pytest.raises(DatasetError, match=r"'sensors'; admissible: .*truth"):
        dataset.table("sensors")
    with pytest.raises(DatasetError, match="'third'; admissible: cone, other"):
        dataset.table("truth", ["third"])


def test_a_damaged_file_is_not_read(bundle: Path, tmp_path: Path) -> None:
    shutil.copytree(bundle / NAME / TIER, tmp_path / "copy")
    path = tmp_path / "copy" / "increments.parquet"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    damaged = Dataset(tmp_path / "copy")
    assert len(damaged.table("truth")) > 0
    with pytest.raises(ArchiveError, match="increments"):
        damaged.table("increments")
    path.unlink()
    with pytest.raises(ArchiveError, match="increments"):
        list(damaged.batches("increments"))


def test_load_fills_the_cache_once(bundle: Path, cache: Path) -> None:
    registry = bundle / "registry.json"
    first = load(NAME, TIER, source=bundle, registry=registry)
    assert first.folder == cache / "1.1.0" / NAME / TIER
    # The function of the package is the same, and stays one after its module has been imported.
    assert sinsdata.load(NAME, TIER, registry=registry).folder == first.folder
    assert sinsdata.load(NAME, TIER, registry=registry).table("truth").equals(first.table("truth"))


def test_what_cannot_be_had_is_offered_to_be_generated(bundle: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UnavailableError, match=r"sinsdata\.load\('dual_precession', 'paper', generate=True\)"):
        load(NAME, registry=bundle / "registry.json")
    with pytest.raises(UnavailableError, match="no mirror is known") as caught:  # whose cases are not known here
        load(NAME, TIER, registry=bundle / "registry.json")
    assert "generate" not in str(caught.value)
    with pytest.raises(FetchError, match=r"unknown tier 'gold'.*admissible: paper, standard, short, sweep"):
        load(NAME, "gold", registry=bundle / "registry.json")

    class MadeInstead:
        folder = bundle / NAME / TIER

    monkeypatch.setattr(loading, "generate_instead", lambda *_, **__: MadeInstead)
    assert load(NAME, TIER, registry=bundle / "registry.json", generate=True).folder == MadeInstead.folder


def test_the_tier_short_comes_out_of_the_package(
    bundle: Path, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(bundle / NAME / TIER, tmp_path / "short" / NAME)
    monkeypatch.setattr(loading, "SHORT", tmp_path / "short")
    assert load(NAME, "short").cases == ("cone", "other")
    assert not cache.exists()


def test_importing_the_package_imports_nothing_heavy() -> None:
    script = "import sys, sinsdata; print(sorted({'numpy', 'pyarrow', 'pandas', 'mpmath', 'pooch'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout == "[]\n"


def test_loading_from_the_cache_imports_nothing_that_takes_long(bundle: Path) -> None:
    # Half a second is promised for the process as a whole; each of these takes a good part of it.
    load(NAME, TIER, source=bundle, registry=bundle / "registry.json")
    slow = {"pandas", "scipy", "numba", "pooch", "requests", "pyarrow.dataset", "mpmath"}
    script = f"""
import sys, sinsdata
sinsdata.load(*sys.argv[1:3], registry=sys.argv[3]).table("truth")
print(sorted({slow} & set(sys.modules)))
"""
    command = [sys.executable, "-c", script, NAME, TIER, str(bundle / "registry.json")]
    assert subprocess.run(command, capture_output=True, text=True).stdout == "[]\n"


def test_row_groups_without_the_case_are_not_read(dataset: Dataset, tmp_path: Path) -> None:
    rows = dataset.table("truth")
    pq.write_table(rows, tmp_path / "truth.parquet", row_group_size=7)
    for cases in (["cone"], ["other"], ["other", "cone"]):
        wanted = [row for row in rows.to_pylist() if row["case"] in cases]
        assert loading._rows_of(tmp_path / "truth.parquet", cases).to_pylist() == wanted
    assert len(loading._rows_of(tmp_path / "truth.parquet", ["before"])) == 0
