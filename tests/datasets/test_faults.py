"""Faults rehearsed: kills, interrupts, full disks, two writers at once, readers meanwhile, long tables."""

from __future__ import annotations

import shutil
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

from sinsdata.cases import DualPrecessionCase
from sinsdata.generate import generate
from sinsdata.storage import file_hash
from sinsdata.verify import DatasetError, find_datasets, read_manifest, verify

#: What every child begins with: one case, of a duration that is given, and a generation of it.
PRELUDE = """
import os, signal, sys
from pathlib import Path
import sinsdata.certified, sinsdata.generate
from sinsdata.cases import DualPrecessionCase
from sinsdata.generate import generate
from sinsdata.verify import DatasetError, find_datasets, verify

def make(out, duration, progress=lambda done, total, table: None):
    case = DualPrecessionCase.from_mapping(dict(
        name="cone", spin_rate=1, precession_ratio=-1, nutation="pi/18", spin_rate_dual=0.5, nutation_dual=10,
        initial_velocity=[10, 0, 0], interval="0.01", duration=duration))
    return generate("dual_precession", "sweep", [case], out, progress)
"""

#: The child kills itself, as `kill -9` does, at an instant named by its argument.
SELF_KILL = (
    PRELUDE
    + """
out, instant = Path(sys.argv[1]), sys.argv[2]
die = lambda *arguments, **named: os.kill(os.getpid(), signal.SIGKILL)
sinsdata.certified.BLOCK = 50
def progress(done, total, table):
    if f"{table} {done}" == instant:
        die()
if instant == "manifest":
    sinsdata.generate.write_json = die
if instant in ("first rename", "between the renames"):
    rename = Path.rename
    def dying(path, target):
        if instant == "first rename" or path == Path(target):
            die()
        result = rename(path, target)
        if ".old-" in str(target):
            die()
        return result
    Path.rename = dying
make(out, 2, progress)
"""
)
INSTANTS = ["increments 0", "increments 100", "truth 250", "truth 401", "manifest", "first rename"]


def _finish(process: subprocess.Popen[str]) -> str:
    output, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    return output


def _snapshot(folder: Path) -> dict[str, str]:
    return {path.name: file_hash(path) for path in sorted(folder.iterdir())}


def _case(mapping: Any, **changes: Any) -> DualPrecessionCase:
    return DualPrecessionCase.from_mapping(mapping("dual_precession", **changes))


def _holds(folder: Path) -> bool:
    return all(check.holds for check in verify(folder))


@pytest.mark.parametrize("instant", INSTANTS)
def test_a_kill_leaves_nothing_that_verifies(start_python: Any, mapping: Any, tmp_path: Path, instant: str) -> None:
    process = start_python(SELF_KILL, tmp_path, instant)
    process.communicate(timeout=120)
    assert process.returncode == -signal.SIGKILL
    assert not (tmp_path / "dual_precession" / "sweep").exists()
    with pytest.raises(DatasetError, match="not a dataset"):
        find_datasets(tmp_path)
    made = generate("dual_precession", "sweep", [_case(mapping)], tmp_path)  # a later run is not in its way
    assert find_datasets(tmp_path) == [made.folder]
    assert _holds(made.folder)


def test_a_kill_leaves_an_existing_dataset_whole(start_python: Any, mapping: Any, tmp_path: Path) -> None:
    folder = generate("dual_precession", "sweep", [_case(mapping)], tmp_path).folder
    before = _snapshot(folder)
    processes = [start_python(SELF_KILL, tmp_path, instant) for instant in ("truth 250", "first rename")]
    for process in processes:
        process.communicate(timeout=120)
        assert process.returncode == -signal.SIGKILL
    assert find_datasets(tmp_path) == [folder]
    assert _snapshot(folder) == before
    assert _holds(folder)


def test_a_kill_between_the_two_renames_leaves_both_whole(start_python: Any, mapping: Any, tmp_path: Path) -> None:
    """The one instant at which a kill takes the place of the old dataset from it; nothing of it is lost."""
    folder = generate("dual_precession", "sweep", [_case(mapping)], tmp_path).folder
    before = _snapshot(folder)
    process = start_python(SELF_KILL, tmp_path, "between the renames")
    process.communicate(timeout=120)
    assert process.returncode == -signal.SIGKILL
    with pytest.raises(DatasetError, match="not a dataset"):
        find_datasets(tmp_path)
    (old,) = folder.parent.glob(".old-*")
    assert _snapshot(old) == before
    assert _holds(old)
    assert _holds(generate("dual_precession", "sweep", [_case(mapping)], tmp_path).folder)


def test_a_kill_from_outside_at_any_moment(start_python: Any, tmp_path: Path) -> None:
    """One child makes the dataset over and over; it is killed at moments that nobody chose."""
    script = PRELUDE + "print('ready', flush=True)\nwhile True:\n    make(Path(sys.argv[1]), 1)"
    for delay in (0.02, 0.09, 0.2):
        process = start_python(script, tmp_path)
        assert process.stdout.readline() == "ready\n"
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(delay)
        process.kill()
        process.communicate()
        try:
            (found,) = find_datasets(tmp_path)
        except DatasetError:
            continue
        assert _holds(found)


def test_an_exception_in_the_middle_leaves_nothing(mapping: Any, tmp_path: Path) -> None:
    def fail(done: int, total: int, table: str) -> None:
        if table == "truth" and done:
            raise RuntimeError("rehearsed")

    with pytest.raises(RuntimeError, match="rehearsed"):
        generate("dual_precession", "sweep", [_case(mapping)], tmp_path, fail)
    assert list((tmp_path / "dual_precession").iterdir()) == []


def test_an_interrupt_between_the_two_renames_restores_the_old_dataset(
    mapping: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = generate("dual_precession", "sweep", [_case(mapping)], tmp_path).folder
    before = _snapshot(folder)
    rename = Path.rename

    def interrupted(path: Path, target: Path) -> Path:
        result = rename(path, target)
        if ".old-" in str(target):
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        generate("dual_precession", "sweep", [_case(mapping, duration=1)], tmp_path)
    assert _snapshot(folder) == before
    assert list(folder.parent.iterdir()) == [folder]


def test_control_c_leaves_nothing(start_python: Any, tmp_path: Path) -> None:
    script = PRELUDE + (
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "sinsdata.certified.BLOCK = 50\n"
        "make(Path(sys.argv[1]), 1000, lambda done, total, table: print(done, flush=True))"
    )
    process = start_python(script, tmp_path)
    for _ in range(4):  # some blocks are written
        process.stdout.readline()
    assert list((tmp_path / "dual_precession").glob(".partial-sweep.*/increments.parquet"))
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == -signal.SIGINT
    assert "KeyboardInterrupt" in errors
    assert list((tmp_path / "dual_precession").iterdir()) == []


# The child fills what room there is; an existing dataset is to survive. Errors reach it as on any full disk.
FULL_DISK = (
    PRELUDE
    + """
import errno, resource
out, limit = Path(sys.argv[1]), int(sys.argv[2])
kept = make(out, "0.05").folder
before = {path.name: path.read_bytes() for path in kept.iterdir()}
if limit:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    make(out, 20)
except OSError as error:
    print(errno.errorcode[error.errno])
else:
    sys.exit("there was room enough")
assert {path.name: path.read_bytes() for path in kept.iterdir()} == before
assert find_datasets(out) == [kept]
assert all(check.holds for check in verify(kept))
assert [path.name for path in kept.parent.iterdir()] == ["sweep"]
"""
)


@pytest.mark.parametrize("limit", [30_000, 100_000, 200_000])
def test_a_file_size_limit_leaves_the_old_dataset_whole(start_python: Any, tmp_path: Path, limit: int) -> None:
    assert _finish(start_python(FULL_DISK, tmp_path, limit)) == "EFBIG\n"


@pytest.mark.parametrize("room", ["160k", "300k", "420k"])
def test_a_full_disk_leaves_the_old_dataset_whole(start_python: Any, tmp_path: Path, room: str) -> None:
    """A file system of its own, seen by the child alone; where that may not be made, a limit on the file size."""
    inside = ("unshare", "--mount", "sh", "-c", f'mount -t tmpfs -o size={room} none "{tmp_path}" && exec "$@"', "sh")
    possible = shutil.which("unshare") and subprocess.run([*inside, "true"], capture_output=True, check=False)
    if possible and possible.returncode == 0:
        assert _finish(start_python(FULL_DISK, tmp_path, 0, before=inside)) == "ENOSPC\n"
    else:
        assert _finish(start_python(FULL_DISK, tmp_path, 60_000)) == "EFBIG\n"


def test_two_writers_and_a_reader(start_python: Any, tmp_path: Path) -> None:
    """While two processes replace the same dataset again and again, a reader meets a whole one or none.

    The reader holds on to one folder, by the number of its inode: what it read belongs together if the folder is
    still in its place afterwards.
    """
    script = PRELUDE + "for _ in range(12):\n    make(Path(sys.argv[1]), sys.argv[2])"
    writers = [start_python(script, tmp_path, duration) for duration in ("0.5", "1")]
    folder = tmp_path / "dual_precession" / "sweep"
    whole = 0
    while any(writer.poll() is None for writer in writers):
        try:
            before = folder.stat().st_ino
            manifest = read_manifest(folder)
            hashes = {name: file_hash(folder / entry["file"]) for name, entry in manifest["tables"].items()}
            after = folder.stat().st_ino
        except (FileNotFoundError, DatasetError):
            continue
        if before == after:
            assert hashes == {name: entry["sha256"] for name, entry in manifest["tables"].items()}
            whole += 1
    for writer in writers:
        _finish(writer)
    assert whole > 0
    assert _holds(folder)
    assert list(folder.parent.iterdir()) == [folder]


def test_memory_does_not_grow_with_the_number_of_rows(start_python: Any, tmp_path: Path) -> None:
    """50,000 and 400,000 rows: the peak is that of one block, here of 8192 rows.

    The 350,000 rows more are 53 MB of bare numbers (15 and 23 columns), and several times that while they are balls.
    Allowed are 24 MB: the footers of the row groups, and what allocators keep between blocks.
    """
    script = PRELUDE + (
        "import resource\n"
        "sinsdata.certified.BLOCK = 8192\n"
        "made = make(Path(sys.argv[1]), sys.argv[2])\n"
        "rows = sum(made.manifest['tables'][table]['rows'] for table in ('increments', 'truth'))\n"
        "print(rows, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == 'darwin' else 1024))"
    )
    durations = {50_001: 250, 400_001: 2000}
    processes = [start_python(script, tmp_path / str(rows), duration) for rows, duration in durations.items()]
    (few, small), (many, large) = (map(int, _finish(process).split()) for process in processes)
    assert [few, many] == list(durations)
    assert large - small < 24e6
