"""Datasets on disk: reproducible bytes, hashes of the content, metadata that survives, cases that come back."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsdata.cases import CASE_CLASSES, Case
from sinsdata.generate import Generated, generate
from sinsdata.schema import DATASETS, arrow_schema
from sinsdata.storage import ContentHash, content_hash, file_hash, replacing
from sinsdata.tiers import paper_cases
from sinsdata.verify import load_cases

TABLES = [(dataset, table) for dataset, about in DATASETS.items() for table in about.tables]


@pytest.fixture(scope="module")
def small(make_dataset: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Generated]:
    out = tmp_path_factory.mktemp("small")
    return {dataset: make_dataset(dataset, out) for dataset in DATASETS}


@pytest.mark.parametrize("dataset", DATASETS)
def test_the_same_bytes_twice(make_dataset: Any, small: dict[str, Generated], tmp_path: Path, dataset: str) -> None:
    again = make_dataset(dataset, tmp_path)
    assert again.manifest == small[dataset].manifest
    files = sorted(path.name for path in small[dataset].folder.iterdir())
    assert files == sorted(["manifest.json", *(f"{table}.parquet" for table in DATASETS[dataset].tables)])
    for name in files:
        assert (again.folder / name).read_bytes() == (small[dataset].folder / name).read_bytes()


@pytest.mark.parametrize("dataset", DATASETS)
def test_the_manifest_says_what_is_there(small: dict[str, Generated], dataset: str) -> None:
    folder, manifest = small[dataset].folder, small[dataset].manifest
    assert json.loads((folder / "manifest.json").read_text(encoding="utf-8")) == manifest
    assert (manifest["dataset"], manifest["tier"], manifest["cases"]) == (dataset, "sweep", [
        case.name for case in load_cases(folder)[1]
    ])  # fmt: skip
    for table, entry in manifest["tables"].items():
        path = folder / entry["file"]
        assert entry["rows"] == pq.read_metadata(path).num_rows
        assert (entry["sha256"], entry["content_sha256"]) == (file_hash(path), content_hash(path))
        assert path.name == f"{table}.parquet"


@pytest.mark.parametrize(("dataset", "table"), TABLES)
@pytest.mark.parametrize(
    "options",
    [
        {"row_group_size": 3},
        {"compression": "none"},
        {"compression": "gzip", "use_dictionary": False},
        {"version": "1.0", "data_page_version": "2.0", "write_statistics": False},
        {"use_dictionary": False, "use_byte_stream_split": ["time"], "data_page_size": 64},
        {"store_schema": True, "write_page_index": True, "write_batch_size": 7},
    ],
    ids=lambda options: "+".join(options),
)
def test_the_content_hash_depends_on_the_content_alone(
    small: dict[str, Generated], tmp_path: Path, dataset: str, table: str, options: dict[str, Any]
) -> None:
    path, copy = small[dataset].folder / f"{table}.parquet", tmp_path / "copy.parquet"
    data = pq.read_table(path)
    if "use_byte_stream_split" in options and "time" not in data.column_names:
        options = {**options, "use_byte_stream_split": False}
    pq.write_table(data, copy, **options)
    assert content_hash(copy) == content_hash(path)
    assert file_hash(copy) != file_hash(path)


@pytest.mark.parametrize(("dataset", "table"), TABLES)
def test_the_content_hash_survives_pandas(
    small: dict[str, Generated], tmp_path: Path, dataset: str, table: str
) -> None:
    """Written by pandas, with the schema given; pandas adds metadata of its own."""
    path, copy = small[dataset].folder / f"{table}.parquet", tmp_path / "copy.parquet"
    frame = pd.read_parquet(path)
    assert len(frame) == pq.read_metadata(path).num_rows
    frame.to_parquet(copy, schema=arrow_schema(dataset, table), index=False, compression="brotli")
    assert b"pandas" in pq.read_schema(copy).metadata
    assert content_hash(copy) == content_hash(path)


def _hash(data: pa.Table) -> str:
    digest = ContentHash(data.schema)
    digest.update(data)
    return digest.hexdigest()


def test_the_content_hash_does_not_depend_on_batches_and_sees_every_change() -> None:
    texts, numbers, counts = ["a", None, "", "ab", "b"], [0.0, None, -0.0, float("nan"), 1.0], [1, 2, None, 4, 5]
    data = pa.table({"s": texts, "x": numbers, "n": counts})
    whole = _hash(data)
    digest = ContentHash(data.schema)
    for batch in data.to_batches(max_chunksize=2):
        digest.update(batch)
    assert digest.hexdigest() == whole
    unit = data.schema.field("x").with_metadata({"unit": "m"})
    changed = [
        pa.table({"s": ["a", None, "", "a", "bb"], "x": numbers, "n": counts}),
        pa.table({"s": ["a", "", None, "ab", "b"], "x": numbers, "n": counts}),
        pa.table({"s": texts, "x": [0.0, None, 0.0, float("nan"), 1.0], "n": counts}),
        pa.table({"s": texts, "x": [None, 0.0, -0.0, float("nan"), 1.0], "n": counts}),
        pa.table({"s": texts, "x": numbers, "n": [1, 2, 0, 4, 5]}),
        data.slice(0, 4),
        data.select(["x", "s", "n"]),
        data.rename_columns(["s", "y", "n"]),
        data.cast(pa.schema([("s", pa.string()), ("x", pa.float64()), ("n", pa.int32())])),
        data.cast(data.schema.set(1, unit)),
    ]
    assert len({whole, *map(_hash, changed)}) == 1 + len(changed)


@pytest.mark.parametrize(("dataset", "table"), TABLES)
def test_metadata_survives(small: dict[str, Generated], dataset: str, table: str) -> None:
    schema = pq.read_schema(small[dataset].folder / f"{table}.parquet")
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
            # Only keys and sample numbers have no unit; a ratio has the unit 1.
            assert bool(column.unit) == (column.kind not in ("key", "index"))


@pytest.mark.parametrize("dataset", DATASETS)
def test_cases_come_back(make_dataset: Any, small: dict[str, Generated], dataset: str) -> None:
    name, cases = load_cases(small[dataset].folder)
    assert name == dataset
    assert [case.name for case in cases] == small[dataset].manifest["cases"]
    # One case has attitude or misalignment, the other has none; equality compares the exact texts.
    optional = [getattr(case, "misalignment", None) or getattr(case, "initial_attitude", None) for case in cases]
    assert [value is None for value in optional] == [True, False]


@pytest.mark.parametrize("dataset", DATASETS)
def test_paper_cases_and_awkward_numbers_come_back_equal(mapping: Any, tmp_path: Path, dataset: str) -> None:
    """Numbers whose decimal expansions are long, and expressions."""
    numbers = {"height": 5e-30, "v_east": 0.1 + 0.2} if dataset == "equator_errors" else {"spin_rate_dual": 1.1e-29}
    awkward = CASE_CLASSES[dataset].from_mapping(mapping(dataset, name="awkward", **numbers))
    cases: list[Case] = [*_short(paper_cases(dataset)), awkward]
    made = generate(dataset, "sweep", cases, tmp_path)
    assert load_cases(made.folder) == (dataset, tuple(cases))


def _short(cases: tuple[Case, ...]) -> list[Case]:
    from dataclasses import replace

    return [replace(case, duration=case.interval) for case in cases]


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
