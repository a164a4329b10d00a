"""What counts as the published dataset: the published manifest, or rows that hash to the published content."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sinsbench.cli.publishing import fetch as fetch_command
from sinsdata.cases import EquatorCase
from sinsdata.format.manifest import sealed
from sinsdata.format.storage import file_hash
from sinsdata.generation.generate import Generated, generate
from sinsdata.publishing.archives import ArchiveError
from sinsdata.publishing.fetch import FetchError, generate_instead
from sinsdata.publishing.registry import Entry
from sinsdata.publishing.soundness import is_published, is_sound, sound_manifest, stated_contents, stored_contents

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]


@pytest.fixture
def made(make_dataset: MakeDataset, tmp_path: Path) -> Path:
    return Path(make_dataset("dual_precession", tmp_path / "data").folder)


def manifest_of(folder: Path) -> dict[str, Any]:
    manifest: dict[str, Any] = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    return manifest


def entry_of(folder: Path) -> Entry:
    about = manifest_of(folder)
    named = about["dataset"], about["tier"], about["version"]
    return Entry(*named, "x.zip", 1, "0" * 64, 1, file_hash(folder / "manifest.json"), stated_contents(about))


def rewrite(folder: Path, change: Callable[[pa.Table], pa.Table]) -> None:
    """Store other rows of truth, with a manifest that lists the new file and states the old content."""
    about, path = manifest_of(folder), folder / "truth.parquet"
    pq.write_table(change(pq.read_table(path)), path, compression="none")
    about["tables"]["truth"]["files"][0] |= {"bytes": path.stat().st_size, "sha256": file_hash(path)}
    del about["sha256"]
    (folder / "manifest.json").write_text(sealed(about, about.pop("files")), encoding="utf-8")


def falsified(table: pa.Table) -> pa.Table:
    """Return a table whose first velocity is another."""
    column = table.schema.get_field_index("w_body_x")
    values = table["w_body_x"].to_pylist()
    return table.set_column(column, table.schema.field(column), pa.array([values[0] + 1, *values[1:]]))


def test_the_content_is_computed_from_the_rows(made: Path) -> None:
    assert stored_contents(made, manifest_of(made)) == stated_contents(manifest_of(made))


@pytest.mark.parametrize("hashed", [True, False])
def test_the_word_of_an_unpublished_manifest_is_not_taken(made: Path, hashed: bool) -> None:
    entry = entry_of(made)
    assert sound_manifest(made, entry, hashed) == manifest_of(made)
    rewrite(made, falsified)
    assert not is_published(made, entry)
    assert stated_contents(manifest_of(made)) == dict(entry.content_sha256)
    assert sound_manifest(made, entry, hashed) is None
    # The rows as they were, in another file: the content is the published one, the manifest is not.
    rewrite(made, lambda table: table.set_column(*_first_velocity(table)))
    assert not is_published(made, entry)
    assert is_sound(made, entry)


def _first_velocity(table: pa.Table) -> tuple[int, pa.Field, pa.Array]:
    column = table.schema.get_field_index("w_body_x")
    values = table["w_body_x"].to_pylist()
    return column, table.schema.field(column), pa.array([values[0] - 1, *values[1:]])


def test_files_of_a_table_with_different_columns_have_no_content(made: Path) -> None:
    about = manifest_of(made)
    other = about["tables"]["increments"]["files"][0]
    about["tables"]["truth"]["files"].append(other)
    with pytest.raises(ArchiveError, match=r"increments\.parquet: other columns than the first file of truth"):
        stored_contents(made, about)


def test_what_an_earlier_run_left_is_read_before_it_counts_as_generated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    errors = ["0.01", "0.01", "0.01", 1, "1.57e-7", "1.57e-7"]
    given = {"name": "tiny", "v_east": 600, "height": 10000, "duration": 60, "interval": 10, "initial_errors": errors}
    tiny = (EquatorCase.from_mapping(given),)
    monkeypatch.setattr("sinsdata.tiers.cases_of", lambda dataset, tier: tiny)
    folder = Path(generate("equator_errors", "paper", tiny, tmp_path).folder)
    registry = tmp_path / "registry.json"
    entry = {**vars(entry_of(folder)), "content_sha256": dict(entry_of(folder).content_sha256)}
    registry.write_text(json.dumps({"format": 1, "mirrors": [], "entries": [entry]}), encoding="utf-8")
    fetch_command("equator_errors", out=tmp_path, registry=registry)
    assert "manifest and files are by their SHA-256 the published ones" in " ".join(capsys.readouterr().out.split())

    def shifted(table: pa.Table) -> pa.Table:
        last = table.num_columns - 1
        return table.set_column(last, table.schema.field(last), pa.array([7.0] * table.num_rows))

    rewrite(folder, shifted)
    with pytest.raises(FetchError, match="the content of truth is not that of the registry"):
        generate_instead("equator_errors", out=tmp_path, registry=registry)
