"""A bucket of a local S3-compatible server: files one by one, the manifest last, and resumption from receipts."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pyarrow.fs as pafs
import pytest

from rehearsals import DATASET, PATIENCE, SHARD_ROWS, SHARDS, TIER, eventually, make, snapshot, sound
from sinsdata.format.manifest import DatasetError
from sinsdata.generation.destination import RemoteFolder, shown


def _answers(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), timeout=1).close()
    except OSError:
        return False
    return True


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """The authority of a server of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    process = subprocess.Popen(
        [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        eventually(lambda: _answers(port))
        yield f"127.0.0.1:{port}"
    finally:
        process.kill()
        process.wait(PATIENCE)


@pytest.fixture
def bucket(server: str, request: pytest.FixtureRequest) -> str:
    """The URI of a folder in a bucket of the test's own, its query left open."""
    name = "".join(letter for letter in request.node.name.replace("_", "-") if letter.isalnum() or letter == "-")[:60]
    options = f"scheme=http&region=us-east-1&endpoint_override={quote(server, safe='')}"
    pafs.FileSystem.from_uri(f"s3://id:word@{name}?{options}&allow_bucket_creation=true")[0].create_dir(name)
    return f"s3://id:word@{name}/data?{options}"


def _files(uri: str) -> set[str]:
    system, base = pafs.FileSystem.from_uri(uri)
    entries = system.get_file_info(pafs.FileSelector(base, recursive=True, allow_not_found=True))
    return {info.path.removeprefix(f"{base}/{DATASET}/{TIER}/") for info in entries if info.type == pafs.FileType.File}


def _fetched(uri: str, folder: Path) -> Path:
    system, base = pafs.FileSystem.from_uri(uri)
    folder.mkdir()
    pafs.copy_files(f"{base}/{DATASET}/{TIER}", str(folder), system, pafs.LocalFileSystem())
    return folder


@pytest.mark.parametrize("workers", [1, 2])
def test_an_interrupted_run_goes_on(bucket: str, undisturbed: Any, tmp_path: Path, workers: int) -> None:
    def interrupt(done: int, total: int, what: str) -> None:
        if done > 3 * SHARD_ROWS:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(bucket, progress=interrupt, workers=workers)
    left = _files(bucket)
    assert "manifest.json" not in left
    finished = sum(name.endswith(".receipt") for name in left)
    made = make(bucket, workers=workers)
    assert made.reused == finished > 0
    assert made.manifest == undisturbed.manifest
    assert _files(bucket) == set(snapshot(undisturbed.folder))
    folder = _fetched(bucket, tmp_path / "copy")
    assert snapshot(folder) == snapshot(undisturbed.folder)
    assert sound(folder)
    assert make(bucket).reused == SHARDS


def test_another_dataset_in_the_place_is_left_alone(bucket: str, tmp_path: Path) -> None:
    made = make(bucket, 1)
    assert "word" not in str(made.folder)
    with pytest.raises(DatasetError, match="another dataset is there; remove it, or choose another place") as refused:
        make(bucket, 2)
    assert "word" not in str(refused.value)
    assert make(bucket, 1).reused == made.shards
    # A manifest that this version cannot read belongs to another dataset too.
    system, base = pafs.FileSystem.from_uri(bucket)
    with system.open_output_stream(f"{base}/{DATASET}/{TIER}/manifest.json") as stream:
        stream.write(b'{"format": 1}')
    with pytest.raises(DatasetError, match="another dataset is there: not a manifest"):
        make(bucket, 1)


def test_damage_is_seen_and_mended(bucket: str, undisturbed: Any) -> None:
    make(bucket)
    system, base = pafs.FileSystem.from_uri(bucket)
    place = f"{base}/{DATASET}/{TIER}/truth-00001-of-00004.parquet"
    with system.open_input_stream(place) as stream:
        content = bytearray(stream.read())
    content[5000] ^= 1
    with system.open_output_stream(place) as stream:
        stream.write(bytes(content))
    made = make(bucket)
    assert (made.reused, made.manifest) == (0, undisturbed.manifest)
    assert make(bucket).reused == SHARDS


def test_independent_jobs(bucket: str, undisturbed: Any) -> None:
    assert make(bucket, part=(2, 2)).missing == 5
    made = make(bucket, part=(1, 2))
    assert (made.manifest, made.reused) == (undisturbed.manifest, 4)


def test_tables_of_an_earlier_attempt_are_removed(tmp_path: Path) -> None:
    """Files without a manifest are no dataset; here on a file system that needs no server."""
    folder = tmp_path / DATASET / TIER
    folder.mkdir(parents=True)
    (folder / "truth-00007-of-00009.parquet").write_bytes(b"PAR1")
    (folder / "notes.txt").write_text("precious", encoding="utf-8")
    place = RemoteFolder(folder.as_uri(), "0" * 64)
    place.begin()
    place.put_receipt("a.receipt", "text")
    assert (place.receipts(), place.receipt("a.receipt"), place.receipt("b.receipt")) == ({"a.receipt"}, "text", None)
    place.finish({"manifest.json": "{}", "digits.csv": ""}, [])
    assert sorted(path.name for path in folder.iterdir()) == ["digits.csv", "manifest.json", "notes.txt"]


def test_receipts_of_another_specification_stay(tmp_path: Path) -> None:
    own, other = (RemoteFolder((tmp_path / DATASET / TIER).as_uri(), digit * 64) for digit in "01")
    for place in (own, other):
        place.begin()
        place.put_receipt("a.receipt", "text")
    own.tidy()
    assert (own.receipts(), other.receipts()) == (set(), {"a.receipt"})


def test_a_uri_of_no_known_kind(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="nosuch://place/data/dual_precession/sweep: "):
        make("nosuch://place/data", 1)
    assert make(tmp_path.as_uri(), 1).folder == f"{tmp_path.as_uri()}/{DATASET}/{TIER}"
    assert sound(tmp_path / DATASET / TIER)
    assert shown("s3://id:word@bucket/a/?region=x", "d", "t") == "s3://bucket/a/d/t"
