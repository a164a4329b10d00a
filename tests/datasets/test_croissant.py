"""The Croissant description, judged by the reference implementation, and the records that it finds by it."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

import mlcroissant
import pyarrow.parquet as pq
import pytest

from sinsdata.format.croissant import CONFORMS_TO, croissant, croissant_text
from sinsdata.format.storage import file_hash
from sinsdata.generation.generate import Generated

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]

# Of rdflib, which mlcroissant reads JSON-LD with.
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:rdflib", "ignore::DeprecationWarning:mlcroissant")


@pytest.fixture(scope="module", params=["dual_precession", "equator_errors"])
def generated(
    request: pytest.FixtureRequest, make_dataset: MakeDataset, tmp_path_factory: pytest.TempPathFactory
) -> Generated:
    return make_dataset(request.param, tmp_path_factory.mktemp("data"))


def records(folder: Path, table: str) -> list[dict[str, Any]]:
    """Return all records of a table as mlcroissant reads them, names without that of the table."""
    found = mlcroissant.Dataset(str(folder / "croissant.json")).records(table)
    return [{name.rpartition("/")[2]: plain(value) for name, value in record.items()} for record in found]


def plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if hasattr(value, "item") else value


def test_it_conforms_and_lacks_nothing_but_a_date(generated: Generated) -> None:
    dataset = mlcroissant.Dataset(str(generated.folder / "croissant.json"))
    assert dataset.metadata.ctx.conforms_to.value == CONFORMS_TO == "http://mlcommons.org/croissant/1.1"
    assert not dataset.metadata.ctx.issues.errors
    (warning,) = dataset.metadata.ctx.issues.warnings
    # A dataset is the same on every day that it is generated; the day it is published is not its own.
    assert "datePublished" in warning


def test_records_read_through_it_are_the_rows(generated: Generated) -> None:
    rows = pq.read_table(generated.folder / "truth.parquet").to_pylist()
    assert records(generated.folder, "truth") == rows


def test_every_table_can_be_read_through_it(generated: Generated) -> None:
    dataset = mlcroissant.Dataset(str(generated.folder / "croissant.json"))
    for table in generated.manifest["tables"]:
        schema = pq.read_schema(generated.folder / f"{table}.parquet")
        (record,) = islice(dataset.records(table), 1)
        assert list(record) == [f"{table}/{name}" for name in schema.names]


def test_units_and_descriptions_are_those_of_the_columns(generated: Generated) -> None:
    dataset = mlcroissant.Dataset(str(generated.folder / "croissant.json"))
    for record_set in dataset.metadata.record_sets:
        schema = pq.read_schema(generated.folder / f"{record_set.name}.parquet")
        for field in record_set.fields:
            metadata = schema.field(field.name).metadata
            unit = metadata.get(b"unit")
            assert [note.value for note in field.annotations] == ([unit.decode()] if unit else [])
            assert all(note.equivalentProperty == ["sc:unitText"] for note in field.annotations)
            assert field.description.startswith(metadata[b"description"].decode())
            assert unit is None or f"unit: {unit.decode()}" in field.description


def test_files_are_those_of_the_manifest(generated: Generated) -> None:
    nodes = json.loads((generated.folder / "croissant.json").read_text(encoding="utf-8"))["distribution"]
    entries = [file for table in generated.manifest["tables"].values() for file in table["files"]]
    assert [(node["contentUrl"], node["sha256"], node["contentSize"]) for node in nodes] == [
        (entry["file"], entry["sha256"], f"{entry['bytes']} B") for entry in entries
    ]


def test_the_text_depends_on_the_manifest_alone(generated: Generated) -> None:
    text = (generated.folder / "croissant.json").read_text(encoding="utf-8")
    assert text == croissant_text(generated.manifest) == croissant_text(dict(generated.manifest))


def test_citation_and_doi_are_those_of_the_manifest(generated: Generated) -> None:
    given = croissant(generated.manifest)
    assert generated.manifest["source"] in given["citeAs"]
    assert given.get("citation", "https://doi.org/") == f"https://doi.org/{generated.manifest['doi']}"


def test_a_table_of_several_files_is_read_as_one(generated: Generated, tmp_path: Path) -> None:
    table = pq.read_table(generated.folder / "truth.parquet")
    manifest = {**generated.manifest, "tables": {"truth": {"rows": len(table)}}}
    files = []
    for number, first in enumerate(range(0, len(table), 5)):
        path = tmp_path / f"truth-{number:05d}-of-{-(-len(table) // 5):05d}.parquet"
        pq.write_table(table.slice(first, 5), path)
        files.append({"file": path.name, "bytes": path.stat().st_size, "sha256": file_hash(path)})
    manifest["tables"]["truth"]["files"] = files
    (tmp_path / "croissant.json").write_text(croissant_text(manifest), encoding="utf-8")
    key = "time" if "sample" not in table.column_names else "sample"
    found = sorted(records(tmp_path, "truth"), key=lambda row: (row["case"], row[key]))
    assert len(files) > 2
    assert found == sorted(table.to_pylist(), key=lambda row: (row["case"], row[key]))
