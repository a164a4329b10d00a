"""Manifests from outside, and folders that hold something else: refused in one line, nothing lost."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from sinsbench.cli import run
from sinsdata.cases import CASE_CLASSES
from sinsdata.format.manifest import NAME, DatasetError, is_sealed, read_manifest, sealed
from sinsdata.format.storage import OccupiedError, replacing
from sinsdata.generation.generate import Generated, generate
from sinsdata.publishing.csv_export import export_csv
from sinsdata.publishing.fetch import fetch
from sinsdata.publishing.publish import PublishError, publish
from sinsdata.publishing.registry import RegistryError
from sinsdata.verification.verify import verify

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]
DATASET = "dual_precession"


@pytest.fixture(scope="module")
def made(make_dataset: MakeDataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = make_dataset(DATASET, tmp_path_factory.mktemp("made")).folder
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    place = tmp_path / "gen" / DATASET / "sweep"
    shutil.copytree(made, place)
    return place


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def seal_again(folder: Path, **changes: Any) -> None:
    """Write a manifest with other entries that carries a sound seal."""
    manifest = json.loads((folder / NAME).read_text(encoding="utf-8")) | changes
    del manifest["sha256"]
    (folder / NAME).write_text(sealed(manifest, manifest.pop("files")), encoding="utf-8", newline="\n")


@pytest.mark.parametrize("tier", ["../../precious", "/precious", "..", "a/b", "", None, 1, "con", "x" * 129, ["sweep"]])
def test_a_tier_cannot_lead_out_of_its_folder(folder: Path, tmp_path: Path, tier: object) -> None:
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "thesis.tex").touch()
    seal_again(folder, tier=tier)
    before = files(tmp_path)
    uses: list[Callable[[], object]] = [
        lambda: export_csv(folder, tmp_path / "out" / "csv"),
        lambda: publish(folder, tmp_path / "out" / "bundle"),
    ]
    for use in uses:
        with pytest.raises(DatasetError, match=r"tier: .* not a"):
            use()
    assert files(tmp_path) == before


FILE = {"file": "digits.csv", "bytes": 1, "sha256": "0" * 64}
ODD: list[tuple[tuple[str, ...], object]] = [
    (("specification",), "0" * 63),
    (("specification",), ["0" * 64]),
    (("cases",), -1),
    (("cases",), True),
    (("cases",), 2.0),
    (("generator",), "sinsbench"),
    (("generator",), {}),
    (("certification",), {"method": "none"}),
    (("certification", "values"), None),
    (("title",), 1),
    (("tables",), [["cases", {}]]),
    (("tables", "truth"), []),
    (("tables", "truth", "rows"), "7"),
    (("tables", "truth", "content_sha256"), None),
    (("tables", "truth", "files"), {}),
    (("tables", "truth", "files"), []),
    (("tables", "truth", "files"), ["truth.parquet"]),
    (("tables", "truth", "files"), [FILE]),
    (("files",), None),
    (("files",), [{**FILE, "bytes": "1"}]),
    (("files",), [{**FILE, "sha256": "0" * 63 + "\n"}]),
    (("files",), [{**FILE, "file": ["digits.csv"]}]),
    (("files",), [FILE, FILE]),
]


@pytest.mark.parametrize(("keys", "value"), ODD)
def test_an_entry_of_another_form_is_refused_wherever_it_is_used(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], keys: tuple[str, ...], value: object
) -> None:
    *path, last = keys
    manifest = json.loads((folder / NAME).read_text(encoding="utf-8"))
    entry = manifest
    for key in path:
        entry = entry[key]
    entry[last] = value
    (folder / NAME).write_text(json.dumps(manifest), encoding="utf-8")
    with pytest.raises(DatasetError, match="not a manifest: ") as caught:
        read_manifest(folder)
    assert str(caught.value).isprintable()
    for command in ("export", "publish"):
        assert run([command, str(folder), "--out", str(tmp_path / "out")]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert run(["verify", str(folder)]) == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("key", ["tier", "specification", "cases", "generator", "certification", "tables", "files"])
def test_a_manifest_that_lacks_an_entry_is_refused(folder: Path, key: str) -> None:
    manifest = json.loads((folder / NAME).read_text(encoding="utf-8"))
    del manifest[key]
    (folder / NAME).write_text(json.dumps(manifest), encoding="utf-8")
    with pytest.raises(DatasetError, match=f"not a manifest: {key} is missing"):
        read_manifest(folder)


def test_a_dataset_with_such_a_manifest_is_made_again(make_dataset: MakeDataset, made: Path, folder: Path) -> None:
    for change in ({"specification": None}, {"certification": {}}, {"tier": ".."}, {"cases": float("1e300")}):
        seal_again(folder, **change)
        make_dataset(DATASET, folder.parents[1])
        assert files(folder) == files(made)


@pytest.mark.parametrize("odd", ["1e999", "NaN", r'"\ud800"'])
def test_a_manifest_with_what_json_cannot_write_is_not_sealed(folder: Path, odd: str) -> None:
    text = (folder / NAME).read_text(encoding="utf-8")
    assert is_sealed(text)
    (folder / NAME).write_text(text.replace('"doi":', f'"odd": {odd},\n "doi":'), encoding="utf-8")
    failed = [check.what for check in verify(folder) if not check.holds]
    assert failed == ["own hash"]


# Targets that hold something else.


@pytest.mark.parametrize(
    "stray", ["thesis.tex", "chapter/thesis.tex", ".git/config", "mine.parquet", "truth-2.parquet"]
)
def test_a_file_of_the_user_in_a_dataset_is_not_lost(make_dataset: MakeDataset, folder: Path, stray: str) -> None:
    (folder / stray).parent.mkdir(exist_ok=True)
    (folder / stray).write_text("mine")
    (folder / "digits.csv").write_text("damaged")
    before = files(folder.parents[1])
    with pytest.raises(OccupiedError, match=stray):
        make_dataset(DATASET, folder.parents[1])
    assert files(folder.parents[1]) == before


@pytest.mark.parametrize(
    "there", [{"thesis.tex": ""}, {NAME: "{}"}, {NAME: "[1"}, {"cases.parquet": "mine"}, {"digits.csv": "mine"}]
)
def test_a_folder_of_the_user_in_the_place_of_a_dataset_is_not_lost(
    make_dataset: MakeDataset, tmp_path: Path, there: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / DATASET / "paper"
    place.mkdir(parents=True)
    for name, text in there.items():
        (place / name).write_text(text)
    before = files(tmp_path)
    assert run(["generate", DATASET, "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert next(iter(there)) in line
    assert files(tmp_path) == before


def test_a_dataset_of_another_format_with_leftovers_is_replaced(
    make_dataset: MakeDataset, made: Path, folder: Path
) -> None:
    (folder / NAME).write_text(
        json.dumps({"format": 1, "dataset": DATASET, "tables": {"truth": {"file": "old.bin"}}, "version": "0.1"})
    )
    (folder / "old.bin").touch()
    (folder / ".writing-0-truth.parquet").touch()
    make_dataset(DATASET, folder.parents[1])
    assert files(folder) == files(made)


def test_a_file_that_comes_while_a_dataset_is_made_is_not_lost(
    folder: Path, tmp_path: Path, mapping: Callable[..., dict[str, Any]]
) -> None:
    def write(done: int, total: int, what: str) -> None:
        if what == "rows":
            (folder / "thesis.tex").write_text("mine")

    cases = [CASE_CLASSES[DATASET].from_mapping(mapping(DATASET))]
    with pytest.raises(OccupiedError, match=r"sweep: .*thesis\.tex"):
        generate(DATASET, "sweep", cases, tmp_path / "gen", write)
    assert (folder / "thesis.tex").read_text() == "mine"
    assert (folder / NAME).is_file()
    assert not list(folder.parent.glob(".old-*"))


def test_what_was_fetched_is_not_put_in_the_place_of_something_else(folder: Path, tmp_path: Path) -> None:
    bundle = publish(folder, tmp_path / "bundle").folder
    place = tmp_path / "out" / DATASET / "sweep"
    place.mkdir(parents=True)
    (place / "thesis.tex").touch()
    with pytest.raises(OccupiedError, match=r"thesis\.tex"):
        fetch(DATASET, "sweep", out=tmp_path / "out", source=bundle, registry=bundle / "registry.json")
    assert files(tmp_path / "out") == {f"{DATASET}/sweep/thesis.tex": b""}


def test_a_dataset_is_not_exported_over_itself(folder: Path) -> None:
    before = files(folder)
    with pytest.raises(OccupiedError, match="is the dataset itself"):
        export_csv(folder, folder.parents[1])
    assert files(folder) == before


def test_an_export_takes_the_place_of_an_export_only(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "csv"
    place = out / DATASET / "sweep"
    export_csv(folder, out)
    before = files(out)
    (place / "truth.csv").write_text("damaged")
    export_csv(folder, out)
    assert files(out) == before
    for stray, text in {"results.csv": "mine", "columns.csv": "a,b\n"}.items():
        kept = files(place).get(stray)
        (place / stray).write_text(text)
        with pytest.raises(OccupiedError):
            export_csv(folder, out)
        assert (place / stray).read_text() == text
        if kept is None:
            (place / stray).unlink()


@pytest.mark.parametrize("registry", ["{}", "mine", '{"format": 1, "mirrors": [], "entries": []}'])
def test_a_folder_with_any_registry_is_no_bundle(folder: Path, tmp_path: Path, registry: str) -> None:
    project = tmp_path / "project"
    (project / "src").mkdir(parents=True)
    (project / "registry.json").write_text(registry)
    (project / "src" / "main.c").write_text("mine")
    before = files(project)
    with pytest.raises((OccupiedError, RegistryError)):
        publish(folder, project)
    assert files(project) == before


def test_a_file_in_a_dataset_of_a_bundle_is_not_lost(folder: Path, tmp_path: Path) -> None:
    bundle = publish(folder, tmp_path / "bundle").folder
    for stray in (bundle / DATASET / "notes.md", bundle / DATASET / "sweep" / "notes.md"):
        stray.touch()
        with pytest.raises(OccupiedError, match=r"notes\.md"):
            publish(folder, bundle)
        stray.unlink()
    publish(folder, bundle)


def test_only_the_kind_that_is_asked_for_is_looked_at(tmp_path: Path) -> None:
    (tmp_path / "target").mkdir()
    (tmp_path / "target" / "a").touch()
    with replacing(tmp_path / "target") as folder:
        (folder / "b").touch()
    assert [path.name for path in (tmp_path / "target").iterdir()] == ["b"]


# What a bundle is made of.


@pytest.mark.parametrize("tier", ["paper", "standard", "short", "sweep"])
def test_a_tier_of_the_package_is_published_with_all_its_tables(
    tmp_path: Path, mapping: Callable[..., dict[str, Any]], tier: str, capsys: pytest.CaptureFixture[str]
) -> None:
    cases = [CASE_CLASSES[DATASET].from_mapping(mapping(DATASET))]
    # The strata that the cases of some tiers are sorted into play no part.
    made = generate(DATASET, "sweep", cases, tmp_path, tables=["truth"])
    if tier == "sweep":
        publish(made.folder, tmp_path / "bundle")
        return
    seal_again(made.folder, tier=tier)
    assert run(["publish", str(made.folder), "--out", str(tmp_path / "bundle")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"tier {tier} lacks " in line
    assert "increments" in line
    assert not (tmp_path / "bundle").exists()


def test_a_tier_whose_archive_has_no_admissible_name_is_refused_before_anything_is_written(
    folder: Path, tmp_path: Path
) -> None:
    seal_again(folder, tier="x" * 128)
    with pytest.raises(PublishError, match="not a plain file name"):
        publish(folder, tmp_path / "out" / "bundle")
    assert not (tmp_path / "out").exists()
