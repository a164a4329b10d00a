"""Verification: whatever is changed in a dataset, with or without its hashes made anew, is found and named."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sinsdata.cases import CASE_CLASSES
from sinsdata.format.content_hash import ContentHash
from sinsdata.format.manifest import NAME, DatasetError, read_manifest, sealed
from sinsdata.format.schema import arrow_schema
from sinsdata.format.storage import file_hash
from sinsdata.generation.generate import Generated, generate
from sinsdata.verification.recompute import Wanted
from sinsdata.verification.stored_cases import find_datasets, load_cases
from sinsdata.verification.verify import Check, verify

pytestmark = pytest.mark.usefixtures("digits_once")
_DATASETS = ("equator_errors", "dual_precession")


@pytest.fixture(scope="module")
def whole(make_dataset: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    out = tmp_path_factory.mktemp("whole")
    return {dataset: make_dataset(dataset, out).folder for dataset in _DATASETS}


@pytest.fixture(params=_DATASETS)
def folder(request: pytest.FixtureRequest, whole: dict[str, Path], tmp_path: Path) -> Path:
    """A copy of a small dataset, to be damaged."""
    return Path(shutil.copytree(whole[request.param], tmp_path / "copy"))


def _failures(folder: Path, recompute: Wanted = 2) -> list[Check]:
    return [check for check in verify(folder, recompute) if not check.holds]


def _failures_or_refusal(folder: Path) -> list[str]:
    """Return where something does not hold, or why a dataset is refused."""
    try:
        return [check.where for check in _failures(folder, 0)]
    except DatasetError as error:
        return [str(error)]


def _seal(folder: Path, **changes: Any) -> None:
    """Write the manifest as if the files had always been what they are."""
    manifest: dict[str, Any] = json.loads((folder / NAME).read_text(encoding="utf-8")) | changes
    del manifest["sha256"]
    for entry in [entry for table in manifest["tables"].values() for entry in table["files"]] + manifest["files"]:
        path = folder / entry["file"]
        entry |= {"bytes": path.stat().st_size, "sha256": file_hash(path)}
    (folder / NAME).write_text(sealed(manifest, manifest.pop("files")), encoding="utf-8")


def _forge(folder: Path, table: str, change: Callable[[pa.Table], pa.Table]) -> None:
    """Change a table, and make manifest and hashes say that this is how it was made."""
    path = folder / f"{table}.parquet"
    data = change(pq.read_table(path, partitioning=None))
    pq.write_table(data, path)
    manifest = read_manifest(folder)
    digest = ContentHash(arrow_schema(manifest["dataset"], table))
    digest.update(data)
    manifest["tables"][table] |= {"rows": len(data), "content_sha256": digest.hexdigest()}
    manifest["tables"][table]["files"][0]["rows"] = len(data)
    _seal(folder, tables=manifest["tables"])


def _with_value(row: int, name: str, value: Callable[[Any], Any]) -> Callable[[pa.Table], pa.Table]:
    def change(data: pa.Table) -> pa.Table:
        values = data[name].to_pylist()
        values[row] = value(values[row])
        place = data.column_names.index(name)
        return data.set_column(place, data.schema.field(name), pa.array(values, data.schema.field(name).type))

    return change


def _beside(row: int, name: str, relative: float) -> Callable[[pa.Table], pa.Table]:
    """Return a change of a value by a part of it that no binary64 alone would show."""
    return lambda data: _with_value(row, f"{name}_lo", lambda x: x + relative * data[name][row].as_py())(data)


def _value_column(folder: Path) -> str:
    return "d_height" if "equator" in read_manifest(folder)["dataset"] else "w_inertial_x"


def test_the_tiers_of_the_papers_verify(paper_dataset: Generated) -> None:
    checks = list(verify(paper_dataset.folder, 1))
    assert [check for check in checks if not check.holds] == []
    assert {check.where for check in checks} >= {
        f"{paper_dataset.folder}: {name}"
        for table, entry in paper_dataset.manifest["tables"].items()
        for name in (table, *(file["file"] for file in entry["files"]))
    }


@pytest.mark.parametrize("recompute", [0, 1, "all", "few"])
def test_a_small_dataset_verifies_with_any_number_of_rows(folder: Path, recompute: Wanted) -> None:
    assert _failures(folder, recompute) == []


def test_a_dataset_with_some_tables_verifies(mapping: Any, tmp_path: Path) -> None:
    case = CASE_CLASSES["dual_precession"].from_mapping(mapping("dual_precession"))
    made = generate("dual_precession", "sweep", [case], tmp_path, tables=["truth"])
    assert _failures(made.folder) == []


@settings(
    derandomize=True,
    deadline=None,
    max_examples=8,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_in_any_file_is_found(folder: Path, place: float, bit: int) -> None:
    for path in sorted(folder.iterdir()):
        good = path.read_bytes()
        byte = int(place * len(good))
        path.write_bytes(good[:byte] + bytes([good[byte] ^ 1 << bit]) + good[byte + 1 :])
        caught = _failures_or_refusal(folder)
        path.write_bytes(good)
        assert caught, f"{path.name}, byte {byte}"
        assert path.name in caught[0]
    assert _failures(folder, 0) == []


@pytest.mark.parametrize("keep", [0, 3, 4, -1])
def test_a_truncated_file_is_found(folder: Path, keep: int) -> None:
    for path in sorted(folder.glob("*.*")):
        good = path.read_bytes()
        path.write_bytes(good[:keep])
        if path.name == NAME:
            (found,) = _failures_or_refusal(folder)
            assert NAME in found
        else:
            caught = _failures(folder, 0)
            assert [(c.where, c.what) for c in caught] == [(f"{folder}: {path.name}", "size and SHA-256 of the file")]
            assert f"{path.name} has " in caught[0].detail
        path.write_bytes(good)


def test_a_file_that_is_missing_renamed_or_too_much_is_named(folder: Path) -> None:
    for path in sorted(folder.glob("[!m]*.*")):
        path.rename(folder / "aside.parquet")
        missing, more = _failures(folder, 0)
        assert (missing.where, missing.detail) == (f"{folder}: {path.name}", f"{path.name} is missing")
        assert more.detail == "not in the manifest: aside.parquet"
        (folder / "aside.parquet").rename(path)
    (folder / ".hidden").touch()
    assert _failures(folder, 0) == []


def test_a_file_of_another_dataset_is_found(folder: Path, whole: dict[str, Path]) -> None:
    (other,) = [place for dataset, place in whole.items() if dataset != read_manifest(folder)["dataset"]]
    shutil.copy(other / "truth.parquet", folder / "truth.parquet")
    _seal(folder)
    assert [check.what for check in _failures(folder, 0)][:2] == ["schema, units and metadata", "number of rows"]


def test_a_file_written_anew_has_other_bytes_and_the_same_content(folder: Path) -> None:
    path = folder / "truth.parquet"
    pq.write_table(pq.read_table(path, partitioning=None), path, compression="none")
    assert [check.what for check in _failures(folder)] == ["size and SHA-256 of the file"]
    _seal(folder)
    assert _failures(folder) == []


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" * 10, b"\0" * 1000])
def test_what_is_no_parquet_is_found(folder: Path, content: bytes) -> None:
    (folder / "truth.parquet").write_bytes(content)
    _seal(folder)
    caught = _failures(folder)
    assert [(c.where, c.what) for c in caught] == [(f"{folder}: truth", "readable as Parquet")]


# Content, with hashes made anew.

_VALUES: dict[str, Callable[[Any], Any]] = {
    "last bit": lambda x: x * (1 + 2.0**-52) + 5e-324,
    "sign": lambda x: -x if x else 1.0,
    "nan": lambda x: float("nan"),
    "infinite": lambda x: float("inf"),
    "null": lambda x: None,
}


def _value_of(folder: Path, table: str) -> str:
    """Return the name of a column of values: of the first given as text in `cases`, else of the last."""
    names = pq.read_schema(folder / f"{table}.parquet").names
    found = [name for name in names if name + ("_exact" if table == "cases" else "_lo") in names]
    return found[0 if table == "cases" else -1]


@pytest.mark.parametrize("row", [0, -1])
def test_a_changed_value_is_found_in_the_table_that_holds_it(folder: Path, row: int) -> None:
    backup = {path: path.read_bytes() for path in folder.iterdir()}
    for table in read_manifest(folder)["tables"]:
        _forge(folder, table, _with_value(row, _value_of(folder, table), _VALUES["last bit"]))
        caught = _failures(folder)
        assert caught, table
        assert all(table in check.where and "hash" not in check.what for check in caught), caught
        for path, content in backup.items():
            path.write_bytes(content)


@pytest.mark.parametrize("tables", ["cases", "others"])
@pytest.mark.parametrize("value", list(_VALUES)[1:])
def test_values_changed_in_many_tables_are_found_in_each(folder: Path, value: str, tables: str) -> None:
    changed = [table for table in read_manifest(folder)["tables"] if (table == "cases") == (tables == "cases")]
    for n, table in enumerate(changed):
        _forge(folder, table, _with_value(-(n % 2), _value_of(folder, table), _VALUES[value]))
    caught = [check.where for check in _failures(folder) if "hash" not in check.what]
    assert [table for table in changed if not any(table in where for where in caught)] == []


@pytest.mark.parametrize("recompute", [0, 1])
def test_a_defect_of_1e_25_is_found_without_recomputing_its_row(folder: Path, recompute: int) -> None:
    _forge(folder, "truth", _beside(3, _value_column(folder), 1e-25))
    caught = _failures(folder, recompute)
    assert caught
    assert all("truth" in check.where for check in caught)
    assert any("epoch 3: " in check.detail for check in caught)


def test_a_defect_of_1e_29_is_found_by_recomputation(folder: Path) -> None:
    name = _value_column(folder)
    _forge(folder, "truth", _beside(-1, name, 1e-29))
    assert any(f"{name}" in c.detail and "by mpmath" in c.what for c in _failures(folder))


@pytest.fixture(scope="module")
def integrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset whose rows cost all rows before them: two cases of seven epochs."""
    given = {
        "motion": "parallel", "latitude": "pi/4", "longitude": 0, "height": 0, "speed": 10, "duration": 18,
        "interval": 3, "initial_errors": [0.01, 0.01, 0.01, 1, 1.57e-7, 1.57e-7],
    }  # fmt: skip
    cases = [CASE_CLASSES["error_equations"].from_mapping({"name": name, **given}) for name in ("a", "b")]
    return generate("error_equations", "sweep", cases, tmp_path_factory.mktemp("integrated")).folder


@pytest.mark.parametrize(("row", "recompute", "workers"), [(5, "all", 1), (12, "all", 2), (6, 2, 1)])
def test_a_coherent_change_far_into_an_integration_is_found(
    integrated: Path, tmp_path: Path, row: int, recompute: Wanted, workers: int
) -> None:
    """8 m/s more in linear and nonlinear errors alike, which leaves their difference as it was."""
    folder = Path(shutil.copytree(integrated, tmp_path / "copy"))
    for table in ("truth", "nonlinear"):
        _forge(folder, table, _with_value(row, "dv_up", lambda x: x + 8))
    caught = {
        check.where.rpartition(" ")[2]: check.detail
        for check in verify(folder, recompute, workers=workers)
        if not check.holds and "by mpmath" in check.what
    }
    assert set(caught) == {"truth", "nonlinear"}
    case, epoch = "ab"[row // 7], row % 7
    assert all(detail.endswith(f" at {case}, row {epoch}, dv_up") for detail in caught.values())


def test_workers_find_the_same_and_few_rows_say_that_they_are(folder: Path, integrated: Path) -> None:
    seen: list[tuple[int, int]] = []
    for place, among in ((folder, ""), (integrated, ", of the first 4 rows of each case")):
        alone = list(verify(place, progress=lambda done, total, what: seen.append((done, total))))
        assert seen[-1] == (sum(entry["rows"] for entry in read_manifest(place)["tables"].values()),) * 2
        assert alone == list(verify(place, workers=2))
        assert all(check.holds for check in alone)
        endings = {check.what.partition("by mpmath")[2] for check in alone if "by mpmath" in check.what}
        assert endings == {among}


def test_a_rest_that_is_too_large_is_found(folder: Path) -> None:
    """The sum is what it was, but x is not the nearest binary64."""
    name = _value_column(folder)

    def change(data: pa.Table) -> pa.Table:
        step = 2 * math.ulp(data[name][2].as_py())
        moved = _with_value(2, name, lambda x: x + step)(data)
        return _with_value(2, f"{name}_lo", lambda x: x - step)(moved)

    _forge(folder, "truth", change)
    assert "finite pairs, x_lo at most half a unit in the last place of x" in [c.what for c in _failures(folder)]


@pytest.mark.parametrize("column", ["time", "time_lo", "sample", "case"])
def test_a_changed_time_sample_or_name_is_found(folder: Path, column: str) -> None:
    if column not in pq.read_schema(folder / "truth.parquet").names:
        column = "time"
    _forge(folder, "truth", _with_value(5, column, lambda x: "cones" if column == "case" else x + 1))
    what = "times of the epochs" if "time" in column else "rows of the cases in order"
    assert what in [check.what for check in _failures(folder, 0)]


def test_rows_in_another_order_are_found(folder: Path) -> None:
    _forge(folder, "truth", lambda data: data.take([1, 0, *range(2, len(data))]))
    assert "times of the epochs" in [check.what for check in _failures(folder, 0)]


@pytest.mark.parametrize("rows", [0, 1, -1])
def test_missing_rows_are_found(folder: Path, rows: int) -> None:
    _forge(folder, "truth", lambda data: data.slice(0, rows if rows >= 0 else len(data) - 1))
    assert [check.what for check in _failures(folder)] == ["rows of the cases"]


def test_a_changed_case_is_found(folder: Path) -> None:
    """A parameter changed as number and as text: neither specification nor truth belong to it any more."""
    parameter = "v_east" if "equator" in read_manifest(folder)["dataset"] else "spin_rate_dual"
    number, text = _with_value(0, parameter, lambda x: 251.0), _with_value(0, f"{parameter}_exact", lambda x: "251")
    _forge(folder, "cases", lambda data: number(text(data)))
    found = {check.what.lstrip("0123456789 ") for check in _failures(folder)}
    assert found >= {"specification", "digits computed again", "values computed again by mpmath"}


def test_a_wrong_unit_and_another_source_are_found(folder: Path) -> None:
    def unit(data: pa.Table) -> pa.Table:
        field = data.schema.field("time")
        return data.cast(data.schema.set(data.column_names.index("time"), field.with_metadata({"unit": "h"})))

    _forge(folder, "truth", unit)
    assert [check.what for check in _failures(folder)] == ["schema, units and metadata"]
    _seal(folder, license="CC-BY-4.0", doi="10.1/1")
    assert _failures(folder)[0].detail == "doi, license: not those of this version"


def test_wrong_digits_are_found(folder: Path) -> None:
    path = folder / "digits.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    changed = lines[7][:-1] + ("1" if lines[7][-1] != "1" else "2")
    path.write_text("\n".join([*lines[:7], changed, *lines[8:]]) + "\n", encoding="utf-8", newline="\n")
    _seal(folder)
    assert [check.what for check in _failures(folder)] == ["digits computed again"]


# Manifests.


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"version": "0.9.0"}, "version '0.9.0' of the data; this version reads 1.1.0"),
        ({"version": None}, "version None"),
        ({"format": 1}, "format 1; this version reads format 2"),
        ({"dataset": "gyroscopes"}, "unknown dataset 'gyroscopes'; admissible: "),
        ({"dataset": ["equator_errors"]}, "unknown dataset"),
        ({"tables": {}}, "the table of the cases is missing"),
        ({"tables": {"cases": "cases.parquet"}}, "not a manifest"),
        ({"tables": []}, "not a manifest"),
        ({"files": [{"file": "../digits.csv"}]}, "not a plain file name"),
    ],
)
def test_a_manifest_that_this_version_cannot_use_is_refused(folder: Path, change: dict[str, Any], reason: str) -> None:
    manifest = read_manifest(folder) | change
    (folder / NAME).write_text(json.dumps(manifest), encoding="utf-8")
    for use in (read_manifest, load_cases, lambda place: list(verify(place))):
        with pytest.raises(DatasetError) as caught:
            use(folder)
        assert str(caught.value).startswith(f"{folder / NAME}: ")
        assert reason in str(caught.value)
        assert str(caught.value).isprintable()


def test_cases_that_are_none_are_refused(folder: Path) -> None:
    parameter = "v_east" if "equator" in read_manifest(folder)["dataset"] else "spin_rate"
    _forge(folder, "cases", _with_value(0, f"{parameter}_exact", lambda x: "import os"))
    with pytest.raises(DatasetError, match=f"case 1 .*{parameter} = 'import os': cannot read"):
        load_cases(folder)
    with pytest.raises(DatasetError, match=f"case 1 .*{parameter}"):
        list(verify(folder))
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
    hidden = top / "equator_errors" / ".partial-sweep-0"
    shutil.copytree(whole["equator_errors"], hidden)
    assert find_datasets(top) == sorted(whole.values())
    assert find_datasets(whole["equator_errors"]) == [whole["equator_errors"]]
    shutil.rmtree(hidden)
