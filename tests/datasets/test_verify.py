"""Verification: whole datasets pass, and every kind of damage is caught."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsdata.generate import Generated
from sinsdata.schema import DATASETS
from sinsdata.storage import content_hash, file_hash
from sinsdata.verify import Check, DatasetError, find_datasets, load_cases, read_manifest, verify


@pytest.fixture(params=list(DATASETS))
def folder(request: pytest.FixtureRequest, whole: dict[str, Path], tmp_path: Path) -> Path:
    """A copy of a small dataset, to be damaged."""
    return Path(shutil.copytree(whole[request.param], tmp_path / "copy"))


@pytest.fixture(scope="module")
def whole(make_dataset: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    out = tmp_path_factory.mktemp("whole")
    return {dataset: make_dataset(dataset, out).folder for dataset in DATASETS}


def _failures(folder: Path, rows: int = 3) -> list[Check]:
    return [check for check in verify(folder, rows) if not check.holds]


def _tables(folder: Path) -> list[str]:
    return list(read_manifest(folder)["tables"])


def _forge(folder: Path, table: str, change: Callable[[pa.Table], pa.Table]) -> None:
    """Change a table, and make the manifest say that this is how it was written."""
    path = folder / f"{table}.parquet"
    pq.write_table(change(pq.read_table(path)), path)
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    rows = pq.read_metadata(path).num_rows
    manifest["tables"][table] |= {"sha256": file_hash(path), "content_sha256": content_hash(path), "rows": rows}
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")


def _with_value(row: int, name: str, value: Callable[[Any], Any]) -> Callable[[pa.Table], pa.Table]:
    def change(data: pa.Table) -> pa.Table:
        values = data[name].to_pylist()
        values[row] = value(values[row])
        place = data.column_names.index(name)
        return data.set_column(place, data.schema.field(name), pa.array(values, data.schema.field(name).type))

    return change


def test_the_tiers_of_the_papers_verify(paper_dataset: Generated) -> None:
    checks = list(verify(paper_dataset.folder))
    assert [check for check in checks if not check.holds] == []
    cases, tables = len(paper_dataset.manifest["cases"]), len(paper_dataset.manifest["tables"])
    # Five checks of each table; names and parameters; rows and values of each case in each table but `cases`.
    assert len(checks) == 5 * tables - tables + 2 + 2 * cases * (tables - 1)


def test_every_row_of_a_small_dataset_verifies(folder: Path) -> None:
    assert _failures(folder, rows=10**6) == []
    assert _failures(folder, rows=0) == []


def test_a_flipped_bit_anywhere_in_a_table_is_caught(folder: Path) -> None:
    """Header, pages, footer: the first bytes, the last, and every so many between."""
    for table in _tables(folder):
        path = folder / f"{table}.parquet"
        good = path.read_bytes()
        places = {*range(8), *range(len(good) - 16, len(good)), *range(0, len(good), len(good) // 20)}
        for place in sorted(places):
            path.write_bytes(good[:place] + bytes([good[place] ^ 1 << place % 8]) + good[place + 1 :])
            caught = _failures(folder)
            assert caught, f"{table}, byte {place}"
            assert caught[0].where == f"{folder}: {table}"
            assert caught[0].what == "SHA-256 of the file"
        path.write_bytes(good)
    assert _failures(folder) == []


@pytest.mark.parametrize("keep", [0, 3, 4, 0.5, -1])
def test_a_truncated_file_is_caught(folder: Path, keep: float) -> None:
    path = folder / "truth.parquet"
    good = path.read_bytes()
    path.write_bytes(good[: int(keep * len(good)) if keep == 0.5 else int(keep)])
    assert {check.what for check in _failures(folder)} == {"SHA-256 of the file", "readable as Parquet"}


def test_a_missing_file_is_caught(folder: Path) -> None:
    for table in _tables(folder):
        (folder / f"{table}.parquet").rename(folder / "aside")
        (missing,) = _failures(folder)
        assert (missing.where, missing.detail) == (f"{folder}: {table}", f"{table}.parquet is missing")
        (folder / "aside").rename(folder / f"{table}.parquet")


def test_a_file_written_anew_has_the_same_content(folder: Path) -> None:
    path = folder / "truth.parquet"
    pq.write_table(pq.read_table(path), path, compression="none")
    assert [check.what for check in _failures(folder)] == ["SHA-256 of the file"]


VALUES: list[Callable[[Any], Any]] = [
    lambda x: x * (1 + 2.0**-52) + 5e-324,
    lambda x: -x if x else 1.0,
    lambda x: float("nan"),
    lambda x: float("inf"),
    lambda x: None,
]


@pytest.mark.parametrize("value", VALUES, ids=["last bit", "sign", "nan", "infinite", "null"])
@pytest.mark.parametrize("row", [0, -1])
def test_a_changed_value_with_forged_hashes_is_caught_by_recomputation(
    folder: Path, row: int, value: Callable[[Any], Any]
) -> None:
    dataset = read_manifest(folder)["dataset"]
    for table, columns in DATASETS[dataset].tables.items():
        name = next(column.name for column in columns[::-1] if column.kind != "index")
        if table == "cases":
            name = columns[1].name
        backup = {path: path.read_bytes() for path in folder.iterdir()}
        _forge(folder, table, _with_value(row, name, value))
        caught = _failures(folder)
        assert caught, (table, name)
        assert all(table in check.where and "hash" not in check.what for check in caught)
        for path, content in backup.items():
            path.write_bytes(content)


@pytest.mark.parametrize("column", ["time", "time_lo", "sample", "case"])
def test_a_changed_time_sample_or_name_is_caught(folder: Path, column: str) -> None:
    if column == "sample" and "sample" not in pq.read_schema(folder / "truth.parquet").names:
        column = "time"
    _forge(folder, "truth", _with_value(-1, column, lambda x: "cone" if column == "case" else x + 1))
    assert _failures(folder)


def test_a_changed_rest_is_caught(folder: Path) -> None:
    """1e-29 of the value: no binary64 alone would show it."""
    name = "d_height" if "equator" in read_manifest(folder)["dataset"] else "w_inertial_x"
    value = pq.read_table(folder / "truth.parquet")[name][0].as_py()
    _forge(folder, "truth", _with_value(0, f"{name}_lo", lambda x: x + 1e-29 * value))
    (caught,) = _failures(folder)
    assert "row 0" in caught.detail
    assert name in caught.detail


def test_a_changed_case_is_caught(folder: Path) -> None:
    """A parameter changed as number and as text: the truth no longer belongs to it."""
    parameter = "v_east" if "equator" in read_manifest(folder)["dataset"] else "spin_rate_dual"

    def change(data: pa.Table) -> pa.Table:
        return _with_value(0, parameter, lambda x: 251.0)(_with_value(0, f"{parameter}_exact", lambda x: "251")(data))

    _forge(folder, "cases", change)
    assert any(check.what.endswith("recomputed by mpmath") for check in _failures(folder))


def test_missing_rows_are_caught(folder: Path) -> None:
    _forge(folder, "truth", lambda data: data.slice(0, len(data) - 1))
    assert [check.what for check in _failures(folder)] == ["rows of the case"]
    _forge(folder, "truth", lambda data: data.slice(0, 0))
    assert {check.what for check in _failures(folder)} == {"rows of the case"}


def test_a_wrong_unit_is_caught(folder: Path) -> None:
    def change(data: pa.Table) -> pa.Table:
        field = data.schema.field("time")
        return data.cast(data.schema.set(data.column_names.index("time"), field.with_metadata({"unit": "h"})))

    _forge(folder, "truth", change)
    assert [check.what for check in _failures(folder)] == ["schema, units and metadata"]


def test_metadata_of_another_source_are_caught(folder: Path) -> None:
    _forge(folder, "truth", lambda data: data.replace_schema_metadata({**data.schema.metadata, b"version": b"0.9"}))
    assert [check.what for check in _failures(folder)] == ["schema, units and metadata"]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"version": "0.9.0"}, "version 0.9.0; this version of sinsbench reads 1.0.0"),
        ({"version": None}, "version None"),
        ({"format": 2}, "format 2; this version reads format 1"),
        ({"dataset": "gyroscopes"}, "unknown dataset 'gyroscopes'; admissible: equator_errors, dual_precession"),
        ({"dataset": ["equator_errors"]}, "unknown dataset"),
        ({"tables": {}}, "no entry for table 'cases'"),
        ({"tables": {"cases": "cases.parquet"}}, "not a manifest"),
        ({"tables": []}, "not a manifest"),
    ],
)
def test_a_manifest_that_this_version_cannot_use_is_refused(folder: Path, change: dict[str, Any], reason: str) -> None:
    manifest = read_manifest(folder) | change
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    for use in (read_manifest, load_cases, lambda place: list(verify(place))):
        with pytest.raises(DatasetError) as caught:
            use(folder)
        assert str(caught.value).startswith(f"{folder / 'manifest.json'}: ")
        assert reason in str(caught.value)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"{}", b"null", b'"manifest"', b"\xff", b"[" * 100_000, b"1" * 5000, b'{"format": 1}']
)
def test_a_broken_manifest_is_refused(folder: Path, content: bytes) -> None:
    (folder / "manifest.json").write_bytes(content)
    with pytest.raises(DatasetError, match="not a manifest") as caught:
        list(verify(folder))
    assert str(caught.value).isprintable()


def test_cases_that_are_none_are_refused(folder: Path) -> None:
    parameter = "v_east" if "equator" in read_manifest(folder)["dataset"] else "spin_rate"
    _forge(folder, "cases", _with_value(0, f"{parameter}_exact", lambda x: "import os"))
    with pytest.raises(DatasetError, match=f"case 1 .*{parameter} = 'import os': cannot read"):
        load_cases(folder)
    (folder / "cases.parquet").write_bytes(b"PAR1")
    with pytest.raises(DatasetError, match=r"cases\.parquet"):
        load_cases(folder)


def test_folders_that_are_no_datasets_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="no such folder"):
        find_datasets(tmp_path / "none")
    with pytest.raises(DatasetError, match=r"not a dataset: no manifest\.json here"):
        find_datasets(tmp_path)
    with pytest.raises(DatasetError, match="not a manifest"):
        list(verify(tmp_path))


def test_datasets_are_found_but_not_unfinished_ones(whole: dict[str, Path]) -> None:
    top = whole["equator_errors"].parents[1]
    hidden = top / "equator_errors" / ".partial-sweep.1.0"
    shutil.copytree(whole["equator_errors"], hidden)
    assert find_datasets(top) == sorted(whole.values())
    assert find_datasets(whole["equator_errors"]) == [whole["equator_errors"]]
    shutil.rmtree(hidden)
