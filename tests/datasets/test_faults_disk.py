"""Full disks and folders that cannot be written: what was complete stays, a message says why, a rerun goes on."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from rehearsals import beside, ended, make, start
from sinsbench.cli import run

# The child fills what room there is; an existing dataset is to survive. Errors reach it as on any full disk. Then
# there is room, and the same call goes on.
FULL_DISK = """
import errno, resource, signal, subprocess, sys
from pathlib import Path
from rehearsals import beside, finished_shards, half_written, make, snapshot, sound, target_of

out, limit, workers = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
make(out, 1)
before = snapshot(target_of(out))
if limit:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
try:
    make(out, 40, workers=workers)
except OSError as error:
    name = errno.errorcode[error.errno]
else:
    sys.exit("there was room enough")
assert snapshot(target_of(out)) == before
assert sound(target_of(out))
assert half_written(out) == []
finished = finished_shards(out)
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
else:
    subprocess.run(["mount", "-o", "remount,size=64m", out], check=True)
made = make(out, 40)
assert made.reused == finished
# Of two workers the one that finds no room may be the first to come to an end.
assert finished > 0 or workers > 1
assert beside(out) == ["sweep"]
print(name, *(entry["content_sha256"] for entry in made.manifest["tables"].values()))
"""


def _content(made: Any) -> list[str]:
    return [entry["content_sha256"] for entry in made.manifest["tables"].values()]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_file_size_limit(start_python: Any, undisturbed: Any, tmp_path: Path, workers: int) -> None:
    """Files of increments fit, those of the truth do not."""
    assert ended(start_python(FULL_DISK, tmp_path, 80_000, workers)).split() == ["EFBIG", *_content(undisturbed)]


@pytest.mark.parametrize(("room", "workers"), [("400k", 1), ("800k", 2)])
def test_a_full_disk(start_python: Any, undisturbed: Any, tmp_path: Path, room: str, workers: int) -> None:
    """A file system of its own, seen by the child alone; where that may not be made, a limit on the file size."""
    inside = ("unshare", "--mount", "sh", "-c", f'mount -t tmpfs -o size={room} none "{tmp_path}" && exec "$@"', "sh")
    possible = shutil.which("unshare") and subprocess.run([*inside, "true"], capture_output=True, check=False)
    if possible and possible.returncode == 0:
        output, expected = ended(start_python(FULL_DISK, tmp_path, 0, workers, before=inside)), "ENOSPC"
    else:
        output, expected = ended(start_python(FULL_DISK, tmp_path, 90_000, workers)), "EFBIG"
    assert output.split() == [expected, *_content(undisturbed)]


def test_the_command_line_says_that_there_is_no_room(tmp_path: Path) -> None:
    script = """
import resource, signal, sys
from sinsbench.cli import run

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
sys.exit(run(["generate", "dual_precession", "--tier", "short", "--out", sys.argv[1]]))
"""
    process = start(script, tmp_path)
    output, errors = process.communicate(timeout=60)
    assert (process.returncode, output) == (2, "")
    assert errors.strip().endswith("File too large")
    assert len(errors.strip().splitlines()) == 1


@pytest.mark.parametrize("workers", [1, 2])
def test_a_folder_that_cannot_be_written(capfd: pytest.CaptureFixture[str], tmp_path: Path, workers: int) -> None:
    """A path that leads through a file: the permissions of a folder mean nothing to root."""
    file = tmp_path / "file"
    file.write_text("precious", encoding="utf-8")
    with pytest.raises(NotADirectoryError):
        make(file, 1, workers=workers)
    assert run(["generate", "dual_precession", "--tier", "short", "--out", str(file), "--workers", str(workers)]) == 2
    output, errors = capfd.readouterr()
    assert output == ""
    assert errors.strip().startswith(f"sinsbench: {file}")
    assert errors.strip().endswith("Not a directory")
    assert file.read_text(encoding="utf-8") == "precious"


def test_a_file_in_the_place_of_the_dataset_is_left_alone(tmp_path: Path) -> None:
    target = tmp_path / "dual_precession" / "sweep"
    target.parent.mkdir()
    target.write_text("precious", encoding="utf-8")
    with pytest.raises(NotADirectoryError):
        make(tmp_path, 1)
    assert target.read_text(encoding="utf-8") == "precious"
    assert [name for name in beside(tmp_path) if not name.startswith(".partial-")] == ["sweep"]
