"""Datasets on disk: reproducible bytes, manifests that say what is there, metadata that survives, cases that return."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsdata.cases import CASE_CLASSES
from sinsdata.format.content_hash import ContentHash
from sinsdata.format.manifest import table_files
from sinsdata.format.schema import DATASETS, arrow_schema
from sinsdata.format.storage import file_hash, replacing
from sinsdata.generation.generate import Generated, generate
from sinsdata.tiers import paper_cases
from sinsdata.verification.stored_cases import load_cases

SMALL = ("equator_errors", "dual_precession")
TABLES = [(dataset, table) for dataset in SMALL for table in DATASETS[dataset].tables]


@pytest.fixture(scope="module")
def small(make_dataset: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Generated]:
    out = tmp_path_factory.mktemp("small")
    return {dataset: make_dataset(dataset, out) for dataset in SMALL}


def _content(path: Path) -> str:
    with pq.ParquetFile(path) as file:
        digest = ContentHash(file.schema_arrow)
        for batch in file.iter_batches():
            digest.update(batch)
    return digest.hexdigest()


@pytest.mark.parametrize("dataset", SMALL)
def test_the_same_bytes_twice(make_dataset: Any, small: dict[str, Generated], tmp_path: Path, dataset: str) -> None:
    again = make_dataset(dataset, tmp_path)
    assert again.manifest == small[dataset].manifest
    files = sorted(path.name for path in small[dataset].folder.iterdir())
    texts = ["manifest.json", "croissant.json", "digits.csv"]
    assert files == sorted([*texts, *(f"{table}.parquet" for table in DATASETS[dataset].tables)])
    for name in files:
        assert (again.folder / name).read_bytes() == (small[dataset].folder / name).read_bytes()


@pytest.mark.parametrize("dataset", SMALL)
def test_the_manifest_says_what_is_there(small: dict[str, Generated], dataset: str) -> None:
    folder, manifest = small[dataset].folder, small[dataset].manifest
    assert json.loads((folder / "manifest.json").read_text(encoding="utf-8")) == manifest
    assert (manifest["dataset"], manifest["tier"], manifest["cases"]) == (dataset, "sweep", 2)
    for table, entry in manifest["tables"].items():
        (path,) = table_files(folder, manifest, table)
        (file,) = entry["files"]
        assert entry["rows"] == file["rows"] == pq.read_metadata(path).num_rows
        assert entry["content_sha256"] == _content(path)
        assert (file["bytes"], file["sha256"]) == (path.stat().st_size, file_hash(path))
    for file in manifest["files"]:
        path = folder / file["file"]
        assert (file["bytes"], file["sha256"]) == (path.stat().st_size, file_hash(path))


@pytest.mark.parametrize(("dataset", "table"), TABLES)
def test_the_content_hash_survives_other_writers(
    small: dict[str, Generated], tmp_path: Path, dataset: str, table: str
) -> None:
    """Other row groups and encodings, and pandas, which adds metadata of its own."""
    path, copy = small[dataset].folder / f"{table}.parquet", tmp_path / "copy.parquet"
    pq.write_table(pq.read_table(path), copy, row_group_size=3, compression="gzip", data_page_size=64)
    assert _content(copy) == _content(path)
    assert file_hash(copy) != file_hash(path)
    pd.read_parquet(path).to_parquet(copy, schema=arrow_schema(dataset, table), index=False, compression="brotli")
    assert b"pandas" in pq.read_schema(copy).metadata
    assert _content(copy) == _content(path)


@pytest.mark.parametrize(("dataset", "table"), TABLES)
def test_metadata_survives(small: dict[str, Generated], dataset: str, table: str) -> None:
    schema: pa.Schema = pq.read_schema(small[dataset].folder / f"{table}.parquet")
    assert schema.equals(arrow_schema(dataset, table), check_metadata=True)
    about = DATASETS[dataset]
    assert schema.metadata[b"dataset"].decode() == dataset
    assert schema.metadata[b"version"].decode() == about.version
    assert schema.metadata[b"source"].decode() == about.source
    assert (b"doi" in schema.metadata) == bool(about.doi)
    for column in about.tables[table]:
        for field in column.fields():
            stored = schema.field(field.name).metadata
            assert stored[b"description"]
            assert stored[b"accuracy"]
            assert stored.get(b"unit", b"").decode() == column.unit
            assert stored.get(b"frame", b"").decode() == column.frame


@pytest.mark.parametrize("dataset", SMALL)
def test_paper_cases_and_awkward_numbers_come_back_equal(mapping: Any, tmp_path: Path, dataset: str) -> None:
    """Numbers whose decimal expansions are long, and expressions; equality compares the exact texts."""
    numbers = {"height": 5e-30, "v_east": 0.1 + 0.2} if dataset == "equator_errors" else {"spin_rate_dual": 1.1e-29}
    awkward = CASE_CLASSES[dataset].from_mapping(mapping(dataset, name="awkward", **numbers))
    cases = [*(replace(case, duration=case.interval) for case in paper_cases(dataset)), awkward]
    made = generate(dataset, "sweep", cases, tmp_path, tables=["cases"])
    name, found = load_cases(made.folder)
    assert (name, list(found)) == (dataset, cases)


def test_the_last_of_several_writers_stays(tmp_path: Path) -> None:
    target = tmp_path / "target"
    with replacing(target) as first:
        (first / "a").write_text("first")
        with replacing(target) as second:
            (second / "a").write_text("second")
        assert (target / "a").read_text() == "second"
    assert (target / "a").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["target"]


def test_a_place_that_another_writer_clears_meanwhile_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The target exists when it is tried, and is gone when the failure is looked at."""
    target, rename = tmp_path / "target", Path.rename

    def contested(path: Path, place: Path) -> Path:
        try:
            return rename(path, place)
        except OSError:
            shutil.rmtree(target)
            raise

    target.mkdir()
    (target / "a").write_text("of another writer")
    with replacing(target) as folder:
        (folder / "a").write_text("new")
        monkeypatch.setattr(Path, "rename", contested)
    assert (target / "a").read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["target"]


def test_a_file_in_the_place_of_the_folder_is_left_alone(tmp_path: Path) -> None:
    target = tmp_path / "target"
    target.write_text("precious")
    with pytest.raises(NotADirectoryError), replacing(target) as folder:
        (folder / "a").write_text("new")
    assert target.read_text() == "precious"
    assert [path.name for path in tmp_path.iterdir()] == ["target"]
