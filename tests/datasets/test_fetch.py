"""Fetching: from good mirrors, past bad ones, from folders, out of the cache; what fails leaves nothing behind."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from mirrors import Mirror, dead_mirror, serving
from sinsbench.cli.publishing import fetch as fetch_command
from sinsdata.cases import EquatorCase
from sinsdata.generation.generate import Generated, generate
from sinsdata.publishing import fetch as fetching
from sinsdata.publishing.archives import unpack
from sinsdata.publishing.fetch import FetchError, UnavailableError, fetch, generate_instead
from sinsdata.publishing.publish import publish
from sinsdata.publishing.registry import Entry, RegistryError, read_registry
from sinsdata.publishing.soundness import is_sound

#: As in conftest.py.
MakeDataset: TypeAlias = Callable[[str, Path], Generated]

NAME, TIER = "dual_precession", "sweep"


@pytest.fixture(scope="module")
def bundle(make_dataset: MakeDataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("published")
    make_dataset(NAME, folder / "data")
    return publish(folder / "data", folder / "bundle").folder


@pytest.fixture(scope="module")
def entry(bundle: Path) -> Entry:
    return read_registry(bundle / "registry.json").entries[0]


@pytest.fixture
def mirror(bundle: Path) -> Iterator[Mirror]:
    with serving(bundle) as started:
        yield started


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SINSBENCH_DATA", str(tmp_path / "cache"))
    monkeypatch.delenv("SINSBENCH_MIRRORS", raising=False)
    return tmp_path / "cache"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def files_in(cache: Path) -> list[str]:
    return [path.name for path in cache.rglob("*") if path.is_file()]


def test_a_good_mirror_fills_the_cache_with_the_published_bytes(bundle: Path, mirror: Mirror, cache: Path) -> None:
    got = fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    assert got.origin == f"{mirror.base()}/{NAME}-{TIER}-1.1.0.zip"
    assert got.folder == cache / "1.1.0" / NAME / TIER
    assert contents(got.folder) == contents(bundle / NAME / TIER)
    assert sorted(path.name for path in got.folder.parent.iterdir()) == [TIER]


def test_what_is_in_the_cache_is_not_asked_for_again(bundle: Path, mirror: Mirror) -> None:
    first = fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    asked = len(mirror.requests)
    again = fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    assert (again.folder, again.origin) == (first.folder, "cache")
    assert len(mirror.requests) == asked == 1


@pytest.mark.parametrize("damage", ["flip", "cut", "remove"])
def test_what_was_damaged_in_the_cache_is_fetched_again(bundle: Path, mirror: Mirror, damage: str) -> None:
    got = fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    path = got.folder / "truth.parquet"
    content = bytearray(path.read_bytes())
    content[100] ^= 4
    if damage == "remove":
        path.unlink()
    else:
        path.write_bytes(content if damage == "flip" else content[:-1])
    got = fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    assert got.origin != "cache"
    assert contents(got.folder) == contents(bundle / NAME / TIER)


@pytest.mark.parametrize(
    ("manner", "reason"),
    [
        ("missing", "HTTP 404"),
        ("truncated", "the connection was cut"),
        ("damaged", "its SHA-256 is not that of the registry"),
        ("endless", "sends more than"),
        ("silent", "silent for 0.5 s"),
        ("dead", "no connection"),
    ],
)
def test_a_bad_mirror_is_named_with_its_reason_and_the_next_is_asked(
    bundle: Path, mirror: Mirror, cache: Path, manner: str, reason: str
) -> None:
    bad = dead_mirror() if manner == "dead" else mirror.base(manner)
    start = time.monotonic()
    with pytest.raises(UnavailableError, match=reason) as caught:
        fetch(NAME, TIER, mirrors=[bad], registry=bundle / "registry.json", timeout=0.5)
    assert time.monotonic() - start < 15  # seconds; without the timeout the silent mirror takes a minute
    assert bad in str(caught.value)
    assert not cache.exists()
    got = fetch(NAME, TIER, mirrors=[bad, mirror.base()], registry=bundle / "registry.json", timeout=0.5)
    assert got.origin.startswith(mirror.base())
    assert contents(got.folder) == contents(bundle / NAME / TIER)


def test_mirrors_of_the_environment_and_the_registry_are_asked_in_turn(
    bundle: Path, mirror: Mirror, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = json.loads((bundle / "registry.json").read_text(encoding="utf-8"))
    given["mirrors"] = [mirror.base("good")]
    (tmp_path / "registry.json").write_text(json.dumps(given), encoding="utf-8")
    monkeypatch.setenv("SINSBENCH_MIRRORS", f"{mirror.base('damaged')} {mirror.base('truncated')}")
    fetch(NAME, TIER, mirrors=[mirror.base("missing")], registry=tmp_path / "registry.json")
    assert [path.split("/")[1] for path in mirror.requests] == ["missing", "damaged", "truncated", "good"]


@pytest.mark.parametrize("what", ["bundle", "archives"])
def test_offline_it_comes_from_a_bundle_or_a_folder_of_archives(bundle: Path, tmp_path: Path, what: str) -> None:
    source = tmp_path / "source"
    if what == "bundle":
        shutil.copytree(bundle, source, ignore=shutil.ignore_patterns("*.zip"))
    else:
        source.mkdir()
        shutil.copy(next(bundle.glob("*.zip")), source)
    got = fetch(NAME, TIER, source=source, registry=bundle / "registry.json")
    assert got.origin.startswith(str(source))
    assert contents(got.folder) == contents(bundle / NAME / TIER)


def test_what_the_package_does_not_know_its_bundle_vouches_for(bundle: Path, tmp_path: Path) -> None:
    got = fetch(NAME, TIER, source=bundle, out=tmp_path / "out")
    assert got.folder == tmp_path / "out" / NAME / TIER
    assert contents(got.folder) == contents(bundle / NAME / TIER)


@pytest.mark.parametrize("damage", ["archive", "manifest", "table"])
def test_a_damaged_folder_is_refused(bundle: Path, tmp_path: Path, cache: Path, damage: str) -> None:
    source = tmp_path / "source"
    shutil.copytree(bundle, source)
    archive = next(source.glob("*.zip"))
    damaged = {"archive": archive, "manifest": source / NAME / TIER / "manifest.json"}.get(
        damage, source / NAME / TIER / "truth.parquet"
    )
    content = bytearray(damaged.read_bytes())
    content[len(content) // 2] ^= 1
    damaged.write_bytes(content)
    if damage != "archive":
        archive.unlink()
    # Archive and manifest are compared with the registry before anything in them is believed.
    judge = "manifest" if damage == "table" else "registry"
    with pytest.raises(ValueError, match=rf"{re.escape(damaged.name)}: its .* is not that of the {judge}"):
        fetch(NAME, TIER, source=source, registry=bundle / "registry.json")
    assert files_in(cache) == []


def test_an_archive_with_other_content_than_the_registry_states_is_refused(
    bundle: Path, tmp_path: Path, cache: Path
) -> None:
    given = json.loads((bundle / "registry.json").read_text(encoding="utf-8"))
    given["entries"][0]["content_sha256"]["truth"] = "0" * 64
    (tmp_path / "registry.json").write_text(json.dumps(given), encoding="utf-8")
    with pytest.raises(FetchError, match="its content hashes are not those of the registry"):
        fetch(NAME, TIER, source=bundle, registry=tmp_path / "registry.json")
    assert files_in(cache) == []


def test_without_a_place_to_get_it_from_it_says_so(bundle: Path, tmp_path: Path) -> None:
    with pytest.raises(UnavailableError, match="no mirror is known"):
        fetch(NAME, TIER, registry=bundle / "registry.json")
    with pytest.raises(UnavailableError, match="neither"):
        fetch(NAME, TIER, source=tmp_path, registry=bundle / "registry.json")
    own = tmp_path / "registry.json"
    own.write_text('{"format": 1, "mirrors": [], "entries": []}', encoding="utf-8")
    with pytest.raises(UnavailableError, match=re.escape(f"{own} has no such data")):
        fetch(NAME, registry=own)
    (empty := tmp_path / "empty").mkdir()
    with pytest.raises(UnavailableError, match=re.escape(f"{empty / 'registry.json'} is not there")):
        fetch(NAME, source=empty, registry=own)
    with pytest.raises(FetchError, match="nowhere: no such folder"):
        fetch(NAME, source=tmp_path / "nowhere")
    with pytest.raises(FetchError, match="unknown tier 'gold' of dual_precession; admissible: paper, standard, short"):
        fetch(NAME, "gold")
    with pytest.raises(FetchError, match="unknown dataset 'gyro'"):
        fetch("gyro")


SCRIPT = """
import sys
from pathlib import Path
from sinsdata.publishing.fetch import fetch
print(fetch(sys.argv[1], sys.argv[2], mirrors=[sys.argv[3]], registry=Path(sys.argv[4])).origin)
"""


def start(bundle: Path, base: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-W", "error", "-c", SCRIPT, NAME, TIER, base, str(bundle / "registry.json")]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_killed_in_the_middle_it_leaves_nothing_under_the_final_name(
    bundle: Path, mirror: Mirror, cache: Path, entry: Entry
) -> None:
    running = start(bundle, mirror.base("slow"))
    assert mirror.half_sent.wait(30)
    running.send_signal(signal.SIGKILL)
    running.communicate()
    assert not (cache / "1.1.0" / NAME / TIER).exists()
    (left,) = (cache / "1.1.0" / NAME).iterdir()
    os.utime(left, (0, 0))  # days later
    got = fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    assert is_sound(got.folder, entry)
    assert not left.exists()


def test_two_processes_at_once_both_end_well(bundle: Path, mirror: Mirror, cache: Path, entry: Entry) -> None:
    both = [start(bundle, mirror.base("slow")) for _ in range(2)]
    while len(mirror.requests) < 2:  # both are in the middle of it
        assert all(process.poll() is None for process in both)
    mirror.release.set()
    for process in both:
        _, complaint = process.communicate(timeout=60)
        assert (process.returncode, complaint) == (0, "")
    assert is_sound(cache / "1.1.0" / NAME / TIER, entry)
    assert [path.name for path in (cache / "1.1.0" / NAME).iterdir()] == [TIER]


def test_the_slower_of_two_does_not_touch_what_the_faster_has_put_there(
    bundle: Path, cache: Path, entry: Entry, monkeypatch: pytest.MonkeyPatch
) -> None:
    registry = bundle / "registry.json"
    target = cache / "1.1.0" / NAME / TIER
    inode: list[int] = []

    def unpack_late(*arguments: Any) -> None:
        unpack(*arguments)
        if not inode:
            inode.append(0)
            fetch(NAME, TIER, source=bundle, registry=registry)
            inode[0] = target.stat().st_ino

    monkeypatch.setattr(fetching, "unpack", unpack_late)
    fetch(NAME, TIER, source=bundle, registry=registry)
    assert target.stat().st_ino == inode[0]


@pytest.fixture(scope="module")
def tiny() -> tuple[EquatorCase, ...]:
    errors = ["0.01", "0.01", "0.01", 1, "1.57e-7", "1.57e-7"]
    given = {"name": "tiny", "v_east": 600, "height": 10000, "duration": 60, "interval": 10, "initial_errors": errors}
    return (EquatorCase.from_mapping(given),)


@pytest.fixture
def tiny_bundle(tiny: tuple[EquatorCase, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    # The tier of the paper with one short case: what is generated instead is then there in a moment.
    monkeypatch.setattr("sinsdata.tiers.cases_of", lambda dataset, tier: tiny)
    generate("equator_errors", "paper", tiny, tmp_path / "data")
    # Under this version other content is published; here nothing is.
    nothing = tmp_path / "nothing.json"
    nothing.write_text('{"format": 1, "mirrors": [], "entries": []}', encoding="utf-8")
    return publish(tmp_path / "data", tmp_path / "bundle", registry=nothing).folder


def test_what_cannot_be_had_is_generated_with_the_same_content(tiny_bundle: Path) -> None:
    got = generate_instead("equator_errors", "paper", registry=tiny_bundle / "registry.json")
    assert got.origin == "generated"
    assert got.entry is not None
    assert is_sound(got.folder, got.entry)
    assert fetch("equator_errors", registry=tiny_bundle / "registry.json").origin == "cache"


def test_generated_content_that_differs_from_the_published_is_refused(tiny_bundle: Path, tmp_path: Path) -> None:
    given = json.loads((tiny_bundle / "registry.json").read_text(encoding="utf-8"))
    given["entries"][0]["content_sha256"]["truth"] = "0" * 64
    (tmp_path / "registry.json").write_text(json.dumps(given), encoding="utf-8")
    with pytest.raises(FetchError, match="the content of truth is not that of the registry"):
        generate_instead("equator_errors", "paper", registry=tmp_path / "registry.json")


def test_the_command_offers_to_generate_and_does_it_when_told_to(
    tiny_bundle: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    registry, out = tiny_bundle / "registry.json", tmp_path / "out"
    command = f"sinsbench fetch equator_errors --tier paper --out {out} --registry {registry} --generate"
    with pytest.raises(UnavailableError, match=re.escape(command)):
        fetch_command("equator_errors", out=out, registry=registry)
    assert not out.exists()
    fetch_command("equator_errors", out=out, registry=registry, generate=True, json=tmp_path / "got.json")
    assert "by their SHA-256 the published ones" in capsys.readouterr().out
    got = json.loads((tmp_path / "got.json").read_text(encoding="utf-8"))
    assert got == {"folder": str(out / "equator_errors" / "paper"), "origin": "generated", "registered": True}
    # A person is asked.
    for stream in (sys.stdin, sys.stderr):
        monkeypatch.setattr(stream, "isatty", lambda: True)
    for answer in (False, True):
        monkeypatch.setattr("typer.confirm", lambda *_, answer=answer, **__: answer)
        if answer:
            fetch_command("equator_errors", registry=registry)
        else:
            with pytest.raises(UnavailableError):
                fetch_command("equator_errors", registry=registry)


@pytest.mark.parametrize(
    ("key", "value"),
    [("archive", "../x.zip"), ("dataset", "/etc"), ("sha256", "0"), ("bytes", -1), ("bytes", "1"), ("tier", "a/b")],
)
def test_a_registry_with_an_unsound_entry_is_refused(bundle: Path, tmp_path: Path, key: str, value: object) -> None:
    given = json.loads((bundle / "registry.json").read_text(encoding="utf-8"))
    given["entries"][0][key] = value
    (tmp_path / "registry.json").write_text(json.dumps(given), encoding="utf-8")
    with pytest.raises(RegistryError, match=r"registry\.json"):
        read_registry(tmp_path / "registry.json")


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 2}', '{"format": 1, "mirrors": [1], "entries": []}'])
def test_a_file_that_is_no_registry_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "registry.json").write_text(text, encoding="utf-8")
    with pytest.raises(RegistryError, match=r"registry\.json"):
        read_registry(tmp_path / "registry.json")


def test_the_registry_of_the_package_can_be_read() -> None:
    for entry in read_registry().entries:
        assert entry.archive == f"{entry.dataset}-{entry.tier}-{entry.version}.zip"


def test_without_pooch_it_says_how_to_install_it(bundle: Path, mirror: Mirror, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pooch", None)
    with pytest.raises(FetchError, match="pip install pooch"):
        fetch(NAME, TIER, mirrors=[mirror.base()], registry=bundle / "registry.json")
    # The rest works without.
    assert fetch(NAME, TIER, source=bundle, registry=bundle / "registry.json").origin.startswith(str(bundle))
