"""The numbers are the same in pandas, polars, DuckDB, C++ and CSV, and the cards' examples print what they say."""

from __future__ import annotations

import csv
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsbench.cli.publishing import export as export_command
from sinsdata.cases import Case
from sinsdata.generation.generate import Generated, generate
from sinsdata.publishing.csv_export import export_csv
from sinsdata.publishing.publish import document, publish
from sinsdata.tiers import cases_of

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("dual_precession", "equator_errors")
_COMPILERS = ("c++", "g++", "clang++")


@pytest.fixture(scope="module", params=NAMES)
def dataset(
    request: pytest.FixtureRequest, make_dataset: MakeDataset, tmp_path_factory: pytest.TempPathFactory
) -> Generated:
    return make_dataset(request.param, tmp_path_factory.mktemp("data"))


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tier of the paper, of the cases that the cards' examples show."""
    folder = tmp_path_factory.mktemp("published")
    for name in NAMES:
        cases: list[Case] = list(cases_of(name, "paper"))
        shown = cases[:1] if name == "dual_precession" else cases
        generate(name, "paper", shown, folder / "data")
    # Under this version the whole tier is published; here nothing is.
    nothing = folder / "nothing.json"
    nothing.write_text('{"format": 1, "mirrors": [], "entries": []}', encoding="utf-8")
    return publish(folder / "data", folder / "bundle", registry=nothing).folder


def columns(table: pa.Table) -> dict[str, np.ndarray]:
    return {field.name: table[field.name].to_numpy() for field in table.schema if field.type == pa.float64()}


def assert_same(found: np.ndarray, expected: np.ndarray) -> None:
    """Compare bit by bit, nulls as NaN."""
    assert found.dtype == expected.dtype == np.float64
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    np.testing.assert_array_equal(np.nan_to_num(found).view(np.int64), np.nan_to_num(expected).view(np.int64))


def files(dataset: Generated) -> Iterator[tuple[str, Path, dict[str, np.ndarray]]]:
    for table in dataset.manifest["tables"]:
        path = dataset.folder / f"{table}.parquet"
        yield table, path, columns(pq.read_table(path))


def test_pandas_reads_the_same_numbers(dataset: Generated) -> None:
    for _, path, expected in files(dataset):
        frame = pd.read_parquet(path)
        for name, values in expected.items():
            assert_same(frame[name].to_numpy(), values)


def test_polars_reads_the_same_numbers(dataset: Generated) -> None:
    for _, path, expected in files(dataset):
        frame = pl.read_parquet(path)
        for name, values in expected.items():
            assert_same(frame[name].cast(pl.Float64).fill_null(float("nan")).to_numpy(), values)


def test_duckdb_reads_the_same_numbers(dataset: Generated) -> None:
    with duckdb.connect() as connection:
        for _, path, expected in files(dataset):
            found = connection.execute("SELECT * FROM read_parquet(?)", [str(path)]).fetchnumpy()
            for name, values in expected.items():
                assert_same(np.ma.filled(np.ma.asarray(found[name]), np.nan), values)


def test_csv_reads_back_exactly(dataset: Generated, tmp_path: Path) -> None:
    rows = export_csv(dataset.folder, tmp_path)
    folder = tmp_path / dataset.manifest["dataset"] / dataset.manifest["tier"]
    assert sorted(path.name for path in folder.iterdir()) == sorted([*rows, "columns.csv"])
    with (folder / "columns.csv").open(encoding="utf-8", newline="") as lines:
        about = {(row["table"], row["column"]): row["unit"] for row in csv.DictReader(lines)}
    for table, path, expected in files(dataset):
        text = (folder / f"{table}.csv").read_bytes().decode("utf-8")
        assert text.count("\n") == rows[f"{table}.csv"] + 1
        with (folder / f"{table}.csv").open(encoding="utf-8", newline="") as lines:
            found = list(csv.DictReader(lines))
        assert list(found[0]) == pq.read_schema(path).names
        for name, values in expected.items():
            assert_same(np.array([float(row[name] or "nan") for row in found]), values)
            unit = pq.read_schema(path).field(name).metadata.get(b"unit", b"").decode()
            assert about[table, name] == unit


def test_the_export_command_writes_all_datasets_below_a_folder(
    dataset: Generated, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    export_command(dataset.folder.parents[1], tmp_path / "csv")
    assert "truth.csv" in capsys.readouterr().out
    assert (tmp_path / "csv" / dataset.manifest["dataset"] / "sweep" / "truth.csv").is_file()


@pytest.fixture(scope="module")
def cpp_reader(tmp_path_factory: pytest.TempPathFactory) -> Path | None:
    """The compiled example, None without a compiler."""
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        return None
    folder, library = tmp_path_factory.mktemp("cpp"), Path(pa.get_library_dirs()[0])
    suffix, pattern = (".dylib", ".*.dylib") if sys.platform == "darwin" else (".so", ".so.*")
    for name in ("arrow", "parquet"):
        # The wheel has its libraries under names with a version, which a linker does not look for.
        (found,) = library.glob(f"lib{name}{pattern}")
        (folder / f"lib{name}{suffix}").symlink_to(found)
    options = ["-std=c++20", f"-isystem{pa.get_include()}", "-Wall", "-Wextra", "-Werror"]
    libraries = [f"-L{folder}", "-lparquet", "-larrow", f"-Wl,-rpath,{library}"]
    source = str(ROOT / "examples" / "read_truth.cpp")
    built = subprocess.run(
        [compiler, *options, source, *libraries, "-o", str(folder / "read_truth")], capture_output=True, text=True
    )
    assert built.returncode == 0, built.stderr
    return folder / "read_truth"


def test_cpp_reads_the_same_numbers(dataset: Generated, cpp_reader: Path | None, tmp_path: Path) -> None:
    if cpp_reader is None:
        print(f"no C++ compiler ({', '.join(_COMPILERS)}): examples/read_truth.cpp is not tried")
        return
    for _, path, expected in files(dataset):
        output = subprocess.run([cpp_reader, path], capture_output=True, text=True, check=True).stdout
        found = {name: (unit, float.fromhex(total)) for name, unit, total in csv_lines(output)}
        assert set(found) == set(expected)
        for name, values in expected.items():
            present = values[~np.isnan(values)]
            # The same additions in the same order.
            total = np.add.accumulate(present)[-1] if len(present) else 0.0
            unit = pq.read_schema(path).field(name).metadata.get(b"unit", b"").decode()
            assert found[name] == (unit, total)
    refused = subprocess.run([cpp_reader, tmp_path / "absent"], capture_output=True, text=True)
    assert (refused.returncode, refused.stdout) == (1, "")


def csv_lines(text: str) -> list[tuple[str, str, str]]:
    return [(name, unit, total) for name, unit, total in (line.split(",") for line in text.splitlines())]


def load_section(name: str) -> str:
    text = document(f"{name}.md").read_text(encoding="utf-8")
    return text.split("## Load it\n")[1].split("\n## ")[0]


def blocks(name: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", load_section(name), re.DOTALL)


# Packages of ours, and all else but pandas, numpy and what these import, cannot be imported behind this.
_NEWCOMER = """
import sys

class OnlyPandas:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"sinsbench", "sinsdata", "sinsref", "flint", "mpmath", "gmpy2", "scipy", "numba"}:
            raise ModuleNotFoundError(f"a newcomer has no {name}", name=name)

sys.meta_path.insert(0, OnlyPandas())
"""


@pytest.mark.parametrize("name", NAMES)
def test_the_first_example_of_a_card_prints_what_stands_beside_it(bundle: Path, name: str) -> None:
    script = _NEWCOMER + blocks(name, "python")[0]
    ran = subprocess.run([sys.executable, "-W", "error", "-c", script], cwd=bundle, capture_output=True, text=True)
    assert ran.stderr == ""
    assert [ran.stdout] == blocks(name, "text")


def test_the_newcomer_has_none_of_our_packages(bundle: Path) -> None:
    for package in ("sinsdata", "sinsref", "sinsbench"):
        command = [sys.executable, "-c", _NEWCOMER + f"import {package}"]
        ran = subprocess.run(command, cwd=bundle, capture_output=True, text=True)
        assert "a newcomer has no" in ran.stderr


def test_the_example_file_is_that_of_the_card() -> None:
    assert (ROOT / "examples" / "angle_error.py").read_text(encoding="utf-8") == blocks("dual_precession", "python")[0]


def test_the_drift_of_the_example_is_the_one_of_theory() -> None:
    """1/2 sin^2(theta) nu (1 - sin(nu h)/(nu h)): what an integrator without coning correction drifts on a cone."""
    nu, theta, h = 2 * math.pi, math.pi / 18, 0.01
    drift = 0.5 * math.sin(theta) ** 2 * nu * (1 - math.sin(nu * h) / (nu * h))
    assert f"drift: {math.degrees(drift) * 3600:.4f} deg/h\n" in blocks("dual_precession", "text")[0]


@pytest.mark.parametrize("name", NAMES)
def test_the_other_examples_of_a_card_run(bundle: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(bundle)
    for block in blocks(name, "python")[1:]:
        if "sinsdata" not in block:  # which loads what ships with the package
            exec(compile(block, "card", "exec"), {})
    (query,) = blocks(name, "sql")
    with duckdb.connect() as connection:
        assert len(connection.execute(query).fetchall()) == len(pq.read_table(f"{name}/paper/cases.parquet"))
