"""Bundles: whole, the same bytes on every run, only of what verifies, never other content under the same version."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import pytest
import yaml

from sinsbench.cli.publishing import publish as publish_command
from sinsdata.format.manifest import DatasetError, read_manifest
from sinsdata.format.schema import DATASETS
from sinsdata.format.storage import OccupiedError, file_hash
from sinsdata.generation.generate import Generated
from sinsdata.publishing.archives import ArchiveError
from sinsdata.publishing.publish import NotSoundError, PublishError, card_with_header, document, publish
from sinsdata.publishing.registry import Entry, Registry, read_registry, registry_json
from sinsdata.verification.verify import Check

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]

NAMES = ("dual_precession", "equator_errors")


@pytest.fixture(scope="module")
def data(make_dataset: MakeDataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data")
    for name in NAMES:
        make_dataset(name, folder)
    return folder


@pytest.fixture(scope="module")
def bundle(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return publish(data, tmp_path_factory.mktemp("published") / "bundle").folder


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_bundle_has_every_file_of_its_datasets_and_what_goes_with_them(data: Path, bundle: Path) -> None:
    files = contents(bundle)
    assert {name: content for name, content in files.items() if "/sweep/" in name} == contents(data)
    others = {name for name in files if "/sweep/" not in name}
    beside = {f"{name}/{file}" for name in NAMES for file in ("README.md", "CITATION.cff", "LICENSE", "SHA256SUMS")}
    archives = {f"{name}-sweep-{DATASETS[name].version}.zip" for name in NAMES}
    assert others == beside | archives | {"registry.json", "SHA256SUMS"}
    assert files["dual_precession/LICENSE"].startswith(b"Creative Commons")


def test_publishing_again_gives_the_same_bytes_in_place_of_the_bundle(data: Path, bundle: Path, tmp_path: Path) -> None:
    again = tmp_path / "again"
    publish(data, again)
    assert contents(again) == contents(bundle)
    (again / "SHA256SUMS").write_text("damaged")
    publish(data, again)
    assert contents(again) == contents(bundle)


def test_checksums_cover_every_file_as_sha256sum_reads_them(bundle: Path) -> None:
    for folder in (bundle, *(bundle / name for name in NAMES)):
        lines = (folder / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
        listed = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
        there = set(contents(folder)) - {"SHA256SUMS"}
        assert set(listed) == {name for name in there if folder != bundle or "/" not in name}
        assert all(file_hash(folder / name) == digest for name, digest in listed.items())
        if program := shutil.which("sha256sum"):
            assert subprocess.run([program, "-c", "SHA256SUMS"], cwd=folder, capture_output=True).returncode == 0


def test_the_registry_says_what_is_there(bundle: Path) -> None:
    for entry in read_registry(bundle / "registry.json").entries:
        archive, folder = bundle / entry.archive, bundle / entry.dataset / entry.tier
        manifest = read_manifest(folder)
        assert (entry.bytes, entry.sha256) == (archive.stat().st_size, file_hash(archive))
        assert entry.manifest_sha256 == file_hash(folder / "manifest.json")
        assert entry.unpacked_bytes == sum(map(len, contents(folder).values()))
        assert entry.version == manifest["version"]
        assert entry.content_sha256 == {name: table["content_sha256"] for name, table in manifest["tables"].items()}


@pytest.mark.parametrize("name", NAMES)
def test_the_header_of_a_card_names_the_files_that_are_there(bundle: Path, name: str) -> None:
    text = (bundle / name / "README.md").read_text(encoding="utf-8")
    _, header, body = text.split("---\n", 2)
    given = yaml.safe_load(header)
    assert given["license"] == "cc0-1.0"
    assert given["size_categories"] == ["n<1K"]
    assert sum(config.get("default", False) for config in given["configs"]) == 1
    tables = read_manifest(bundle / name / "sweep")["tables"]
    assert {config["config_name"] for config in given["configs"]} == set(tables)
    for config in given["configs"]:
        (file,) = config["data_files"]
        assert file["split"] == "sweep"
        assert (bundle / name / file["path"]).is_file()
    assert body == document(f"{name}.md").read_text(encoding="utf-8").split("---\n", 2)[2]


def test_the_header_of_a_card_with_shards_and_several_tiers() -> None:
    def manifest(tier: str, files: int, rows: int) -> dict[str, Any]:
        entries = [
            {"file": f"truth-{n:05d}-of-{files:05d}.parquet" if files > 1 else "truth.parquet"} for n in range(files)
        ]
        return {"dataset": "x", "tier": tier, "tables": {"truth": {"rows": rows, "files": entries}}}

    old = "configs:\n  - config_name: old\n    default: true\nsize_categories:\n  - n<1K\n"
    card = f"---\nlicense: cc0-1.0\n{old}---\ntext\n"
    made = card_with_header(card, [manifest("standard", 3, 10**6), manifest("paper", 1, 5)])
    given = yaml.safe_load(made.split("---\n")[1])
    files = [
        {"split": "paper", "path": "paper/truth.parquet"},
        {"split": "standard", "path": "standard/truth-*.parquet"},
    ]
    assert given == {
        "license": "cc0-1.0",
        "size_categories": ["1M<n<10M"],
        "configs": [{"config_name": "truth", "default": True, "data_files": files}],
    }
    assert made.endswith("---\ntext\n")


def test_what_does_not_verify_is_not_published(data: Path, tmp_path: Path) -> None:
    spoilt, out = tmp_path / "spoilt", tmp_path / "bundle"
    shutil.copytree(data, spoilt)
    path = spoilt / "dual_precession" / "sweep" / "truth.parquet"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(NotSoundError, match="truth"):
        publish(spoilt, out)
    assert sorted(found.name for found in tmp_path.iterdir()) == ["spoilt"]


def test_what_changes_after_it_was_verified_is_not_packed(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changing, out = tmp_path / "changing", tmp_path / "bundle"
    shutil.copytree(data, changing)

    def verified_too_early(folder: Path) -> list[Check]:
        (folder / "truth.parquet").write_bytes(b"PAR1")
        return []

    monkeypatch.setattr("sinsdata.publishing.publish.verify", verified_too_early)
    with pytest.raises(ArchiveError, match=r"truth\.parquet"):
        publish(changing, out)
    assert not out.exists()


def test_a_folder_that_is_no_bundle_is_left_alone(data: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(OccupiedError, match="is no bundle"):
        publish(data, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    with pytest.raises(NotADirectoryError, match="is no folder"):
        publish(data, tmp_path / "thesis.tex")


def test_a_failure_on_the_way_leaves_the_earlier_bundle(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "bundle"
    publish(data, out)
    before = contents(out)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("sinsdata.publishing.publish._write_sums", full)
    with pytest.raises(OSError, match="No space"):
        publish(data, out)
    assert contents(out) == before
    assert [path.name for path in tmp_path.iterdir()] == ["bundle"]


def test_other_content_needs_another_version(data: Path, bundle: Path, tmp_path: Path) -> None:
    known = read_registry(bundle / "registry.json")
    publish(data, tmp_path / "same", registry=bundle / "registry.json")
    first = known.entries[0]
    other = Entry(**{**vars(first), "content_sha256": {**first.content_sha256, "truth": "0" * 64}})
    changed = tmp_path / "registry.json"
    changed.write_text(json.dumps(registry_json(Registry((other,)))), encoding="utf-8")
    with pytest.raises(PublishError, match="other data, other version"):
        publish(data, tmp_path / "bundle", registry=changed)


def test_the_same_tier_twice_and_a_folder_without_data_are_refused(data: Path, tmp_path: Path) -> None:
    for copy in ("a", "b"):
        shutil.copytree(data / "dual_precession" / "sweep", tmp_path / "twice" / copy)
    with pytest.raises(PublishError, match="more than once"):
        publish(tmp_path / "twice", tmp_path / "bundle")
    (tmp_path / "empty").mkdir()
    with pytest.raises(DatasetError, match="not a dataset"):
        publish(tmp_path / "empty", tmp_path / "bundle")


def test_a_document_that_is_not_there_is_named() -> None:
    with pytest.raises(PublishError, match=r"gyro\.md"):
        document("gyro.md")


def test_the_command_prints_what_does_not_hold_and_ends_with_1(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import typer

    publish_command(data, tmp_path / "bundle", tmp_path / "rows.json")
    assert [row["dataset"] for row in json.loads((tmp_path / "rows.json").read_text())] == list(NAMES)
    assert "dual_precession-sweep" in capsys.readouterr().out
    spoilt = tmp_path / "spoilt"
    shutil.copytree(data, spoilt)
    (spoilt / "dual_precession" / "sweep" / "truth.parquet").unlink()
    with pytest.raises(typer.Exit) as caught:
        publish_command(spoilt, tmp_path / "other")
    assert caught.value.exit_code == 1
    assert "does not hold" in capsys.readouterr().out
    assert not (tmp_path / "other").exists()
