"""Archives from outside: nothing but the plain files that the manifest lists, and nothing written elsewhere."""

from __future__ import annotations

import hashlib
import json
import stat
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sinsdata.format.names import UnsafeNameError, safe_name, safe_names
from sinsdata.publishing.archives import ArchiveError, check_file, listed_files, pack, unpack

PREFIX = "dual_precession/paper"
DATA = b"a table"


def entry(name: str, content: bytes = DATA) -> dict[str, Any]:
    return {"file": name, "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}


def manifest(*names: str) -> bytes:
    return json.dumps({"tables": {"truth": {"files": [entry(name) for name in names]}}, "files": []}).encode()


def write(archive: Path, members: Sequence[tuple[str | zipfile.ZipInfo, bytes]]) -> Path:
    with zipfile.ZipFile(archive, "w") as zipped:
        for name, content in members:
            # zipfile cleans names that it is given as text; these are to stay as they are.
            info = zipfile.ZipInfo() if isinstance(name, str) else name
            if isinstance(name, str):
                info.filename = name
            zipped.writestr(info, content)
    return archive


def everything_below(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.fixture
def target(tmp_path: Path) -> Path:
    folder = tmp_path / "deep" / "down" / "target"
    folder.mkdir(parents=True)
    return folder


def test_a_sound_archive_is_unpacked(tmp_path: Path, target: Path) -> None:
    members = [(f"{PREFIX}/manifest.json", manifest("truth.parquet")), (f"{PREFIX}/truth.parquet", DATA)]
    unpack(write(tmp_path / "x.zip", members), PREFIX, 10**4, target)
    assert (target / "truth.parquet").read_bytes() == DATA
    assert everything_below(target) == ["manifest.json", "truth.parquet"]


@pytest.mark.parametrize(
    "name",
    [
        "/etc/truth.parquet",
        "../truth.parquet",
        f"{PREFIX}/../truth.parquet",
        f"{PREFIX}/../../../../truth.parquet",
        f"{PREFIX}/sub/truth.parquet",
        f"{PREFIX}//truth.parquet",
        f"/{PREFIX}/truth.parquet",
        "C:/truth.parquet",
        f"{PREFIX}/C:truth.parquet",
        f"{PREFIX}\\truth.parquet",
        f"{PREFIX}/..\\..\\truth.parquet",
        f"{PREFIX}/..",
        f"{PREFIX}/.",
        f"{PREFIX}/.truth.parquet",
        f"{PREFIX}/",
        f"{PREFIX}/sub/",
        f"{PREFIX}/con.parquet",
        f"{PREFIX}/NUL",
        f"{PREFIX}/truth.parquet\0.txt",
        f"{PREFIX}/{'x' * 300}",
        "truth.parquet",
        f"{PREFIX}/\u0442ruth.parquet",
    ],
)
def test_a_name_that_leads_elsewhere_is_refused(tmp_path: Path, target: Path, name: str) -> None:
    # The manifest lists it too, or what a reader that stops at a null byte makes of it.
    members = [(f"{PREFIX}/manifest.json", manifest(name.rpartition("/")[2].partition("\0")[0])), (name, DATA)]
    archive = write(tmp_path / "x.zip", members)
    before = everything_below(tmp_path)
    with pytest.raises(ArchiveError, match=r"x\.zip"):
        unpack(archive, PREFIX, 10**4, target)
    assert everything_below(tmp_path) == before


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFDIR, stat.S_IFCHR, stat.S_IFBLK, stat.S_IFIFO, stat.S_IFSOCK])
def test_what_is_not_a_plain_file_is_refused(tmp_path: Path, target: Path, kind: int) -> None:
    info = zipfile.ZipInfo(f"{PREFIX}/truth.parquet")
    info.create_system, info.external_attr = 3, (kind | 0o777) << 16
    archive = write(
        tmp_path / "x.zip", [(f"{PREFIX}/manifest.json", manifest("truth.parquet")), (info, b"/etc/passwd")]
    )
    with pytest.raises(ArchiveError, match="not a plain file"):
        unpack(archive, PREFIX, 10**4, target)
    assert everything_below(target) == []


@pytest.mark.filterwarnings("ignore:Duplicate name:UserWarning")  # zipfile's, about the attack that is written here
@pytest.mark.parametrize(("second", "what"), [("truth.parquet", "occurs twice"), ("Truth.parquet", "by case alone")])
def test_names_that_collide_are_refused(tmp_path: Path, target: Path, second: str, what: str) -> None:
    members = [
        (f"{PREFIX}/manifest.json", manifest("truth.parquet")),
        (f"{PREFIX}/truth.parquet", DATA),
        (f"{PREFIX}/{second}", b"another"),
    ]
    with pytest.raises(ArchiveError, match=what):
        unpack(write(tmp_path / "x.zip", members), PREFIX, 10**4, target)
    assert everything_below(target) == []


def test_more_bytes_than_stated_are_refused_before_any_is_written(tmp_path: Path, target: Path) -> None:
    info = zipfile.ZipInfo(f"{PREFIX}/truth.parquet")
    info.compress_type = zipfile.ZIP_DEFLATED
    bomb = bytes(50_000_000)
    archive = write(tmp_path / "x.zip", [(f"{PREFIX}/manifest.json", manifest("truth.parquet")), (info, bomb)])
    assert archive.stat().st_size < 10**5
    with pytest.raises(ArchiveError, match="would unpack to"):
        unpack(archive, PREFIX, 10**6, target)
    assert everything_below(target) == []


def test_a_member_that_understates_its_length_is_refused(tmp_path: Path, target: Path) -> None:
    info = zipfile.ZipInfo(f"{PREFIX}/truth.parquet")
    info.compress_type = zipfile.ZIP_DEFLATED
    content = bytes(10**6)
    archive = write(tmp_path / "x.zip", [(f"{PREFIX}/manifest.json", manifest("truth.parquet")), (info, content)])
    packed = archive.read_bytes().replace((10**6).to_bytes(4, "little"), len(DATA).to_bytes(4, "little"))
    archive.write_bytes(packed)
    with pytest.raises(ArchiveError, match="CRC"):
        unpack(archive, PREFIX, 10**4, target)
    assert sum(path.stat().st_size for path in target.iterdir()) < 10**4


@pytest.mark.parametrize(
    ("members", "what"),
    [
        ([("truth.parquet", DATA)], "no manifest.json"),
        ([("manifest.json", b"{")], "manifest.json"),
        ([("manifest.json", b"[]")], "not a manifest"),
        ([("manifest.json", b'{"tables": {"truth": {"files": [{}]}}, "files": []}')], "not a manifest"),
        ([("manifest.json", b"[" * 10**5)], "manifest.json"),
        ([("manifest.json", manifest("truth.parquet"))], "missing"),
        ([("manifest.json", manifest()), ("evil.py", DATA)], "not listed"),
        ([("manifest.json", manifest("truth.parquet")), ("truth.parquet", b"a tabLe")], "SHA-256"),
        ([("manifest.json", manifest("truth.parquet")), ("truth.parquet", b"short")], "length"),
        ([("manifest.json", manifest("../truth.parquet")), ("truth.parquet", DATA)], "plain file name"),
        ([("manifest.json", manifest("manifest.json"))], "occurs twice"),
    ],
)
def test_an_archive_that_is_not_its_manifest_is_refused(
    tmp_path: Path, target: Path, members: list[tuple[str, bytes]], what: str
) -> None:
    archive = write(tmp_path / "x.zip", [(f"{PREFIX}/{name}", content) for name, content in members])
    with pytest.raises(ArchiveError, match=what):
        unpack(archive, PREFIX, 10**6, target)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda content: b"",
        lambda content: b"PK",
        lambda content: content[: len(content) // 2],
        lambda content: content[:-30],
        lambda content: b"\0" * len(content),
        lambda content: content[:40] + b"\xff" * 40 + content[80:],
    ],
)
def test_a_file_that_is_no_sound_archive_is_refused(
    tmp_path: Path, target: Path, spoil: Callable[[bytes], bytes]
) -> None:
    members = [(f"{PREFIX}/manifest.json", manifest("truth.parquet")), (f"{PREFIX}/truth.parquet", DATA)]
    archive = write(tmp_path / "x.zip", members)
    archive.write_bytes(spoil(archive.read_bytes()))
    with pytest.raises(ArchiveError):
        unpack(archive, PREFIX, 10**4, target)


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.integers(min_value=0), st.integers(min_value=1, max_value=255))
def test_whatever_byte_is_changed_nothing_but_an_archive_error_comes_out(
    tmp_path_factory: pytest.TempPathFactory, place: int, change: int
) -> None:
    folder = tmp_path_factory.mktemp("changed")
    members = [(f"{PREFIX}/manifest.json", manifest("truth.parquet")), (f"{PREFIX}/truth.parquet", DATA)]
    archive = write(folder / "x.zip", members)
    content = bytearray(archive.read_bytes())
    content[place % len(content)] ^= change
    archive.write_bytes(content)
    (folder / "target").mkdir()
    try:
        unpack(archive, PREFIX, 10**4, folder / "target")
    except ArchiveError:
        pass
    else:  # a byte that says nothing about the content, such as one of a time
        assert (folder / "target" / "truth.parquet").read_bytes() == DATA
    assert set(everything_below(folder)) <= {"x.zip", "target", "target/manifest.json", "target/truth.parquet"}


def test_packing_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    for name, content in (("b", b"2"), ("a", b"1")):
        (tmp_path / name).write_bytes(content)
    pack(tmp_path, PREFIX, ["b", "a"], tmp_path / "first.zip")
    (tmp_path / "a").touch()
    (tmp_path / "a").chmod(0o600)
    pack(tmp_path, PREFIX, ["a", "b"], tmp_path / "second.zip")
    assert (tmp_path / "first.zip").read_bytes() == (tmp_path / "second.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "first.zip") as zipped:
        assert [(i.filename, i.compress_type, i.date_time) for i in zipped.infolist()] == [
            (f"{PREFIX}/{name}", zipfile.ZIP_STORED, (1980, 1, 1, 0, 0, 0)) for name in "ab"
        ]


@settings(derandomize=True, deadline=None)
@given(st.text(max_size=12))
def test_a_safe_name_stays_in_its_folder(text: str) -> None:
    try:
        name = safe_name(text)
    except UnsafeNameError:
        return
    assert Path("/folder", name).resolve().parent == Path("/folder")
    assert not {*name} & {*'/\\:*?"<>|\0'}


@pytest.mark.parametrize("good", ["truth.parquet", "truth-00001-of-00012.parquet", "digits.csv", "a", "x+y_z-1.0"])
def test_names_of_ours_are_safe(good: str) -> None:
    assert safe_name(good) == good
    assert safe_names([good, "other"]) == [good, "other"]


@pytest.mark.parametrize("bad", [None, 1, ["a"], "", ".", "..", "a.", "-x", "a b", "aux.txt", "COM1", "\u00e4", "a\n"])
def test_names_that_are_not_plain_are_refused(bad: object) -> None:
    with pytest.raises(UnsafeNameError):
        safe_name(bad)


def test_tables_and_other_files_are_listed_in_order() -> None:
    tables = {"truth": {"files": [entry("b"), entry("a")]}}
    assert list(listed_files({"tables": tables, "files": [entry("c")]})) == ["b", "a", "c"]


def test_a_length_that_is_not_the_stated_one_is_refused_whatever_the_hash(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(DATA)
    check_file(tmp_path / "a", entry("a"))
    with pytest.raises(ArchiveError, match="its length or SHA-256"):
        check_file(tmp_path / "a", {**entry("a"), "bytes": len(DATA) + 1})


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ArchiveError, match="absent"):
        check_file(tmp_path / "absent", entry("absent"))
