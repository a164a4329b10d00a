"""Several runs and a reader at the same place: runs of one specification share their work, of others the last stays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rehearsals import SHARDS, beside, ended, half_written, make, place_of, snapshot, sound, target_of
from sinsdata.format.manifest import DatasetError, all_files, read_manifest
from sinsdata.format.storage import file_hash

RUN = """
import sys
from pathlib import Path
from rehearsals import make

sys.stdin.readline()
made = make(Path(sys.argv[1]), int(sys.argv[2]), workers=int(sys.argv[3]))
print(made.reused, made.manifest["sha256"])
"""


@pytest.mark.parametrize("workers", [(1, 1), (1, 2)])
def test_two_runs_of_one_specification(
    start_python: Any, undisturbed: Any, tmp_path: Path, workers: tuple[int, int]
) -> None:
    runs = [start_python(RUN, tmp_path, 40, number, stdin=-1) for number in workers]
    for run in runs:
        run.stdin.write("\n")
        run.stdin.flush()
    for run in runs:
        assert ended(run).split()[1] == undisturbed.manifest["sha256"]
    assert beside(tmp_path) == ["sweep"]
    assert half_written(tmp_path) == []
    assert sound(target_of(tmp_path))


@pytest.mark.parametrize("rows", [1, 1025, 4001, 8001])
def test_another_run_finishes_while_this_one_writes(undisturbed: Any, tmp_path: Path, rows: int) -> None:
    """The other takes along what both have finished; this one finds the dataset finished."""
    seen = []

    def overtake(done: int, total: int, what: str) -> None:
        if what == "rows" and done >= rows and not seen:
            seen.append(make(tmp_path))

    made = make(tmp_path, progress=overtake)
    assert seen[0].manifest == made.manifest == undisturbed.manifest
    assert made.reused == SHARDS
    assert beside(tmp_path) == ["sweep"]
    assert sorted(snapshot(made.folder)) == sorted(snapshot(undisturbed.folder))


def test_a_file_that_another_run_is_writing_is_not_taken_along(undisturbed: Any, tmp_path: Path) -> None:
    """It has the name of a finished file already, of the same content, and is half written when the dataset moves."""
    other = place_of(tmp_path)

    def finish_meanwhile() -> None:
        with other.write("truth-00000-of-00004.parquet") as path:
            path.write_bytes(b"PAR1")
            assert make(tmp_path).manifest == undisturbed.manifest

    other.begin()
    with pytest.raises(FileNotFoundError):
        finish_meanwhile()
    assert other.taken()
    other.leave()
    assert snapshot(target_of(tmp_path)) == snapshot(undisturbed.folder)
    assert beside(tmp_path) == ["sweep"]


def test_runs_of_different_specifications_and_a_reader(start_python: Any, tmp_path: Path) -> None:
    """While two processes replace the same dataset again and again, a reader meets a whole one or none.

    The reader holds on to one folder, by the number of its inode: what it read belongs together if the folder is
    still in its place afterwards.
    """
    script = "import sys\nfrom pathlib import Path\nfrom rehearsals import make\n"
    script += "for _ in range(3):\n    for duration in sys.argv[2:]:\n        make(Path(sys.argv[1]), float(duration))"
    writers = [start_python(script, tmp_path, *durations) for durations in (("0.5", "1"), ("1", "2"))]
    folder = target_of(tmp_path)
    whole = 0
    while any(writer.poll() is None for writer in writers):
        try:
            before = folder.stat().st_ino
            manifest = read_manifest(folder)
            hashes = [file_hash(folder / entry["file"]) for entry in all_files(manifest)]
            after = folder.stat().st_ino
        except (FileNotFoundError, DatasetError):
            continue
        if before == after:
            assert hashes == [entry["sha256"] for entry in all_files(manifest)]
            whole += 1
    for writer in writers:
        ended(writer)
    assert whole > 0
    assert sound(folder)
    assert beside(tmp_path) == ["sweep"]


def test_the_last_of_different_runs_stays(tmp_path: Path) -> None:
    """The shorter one begins later and is finished earlier."""
    short = []

    def overtake(done: int, total: int, what: str) -> None:
        if what == "rows" and done > 2000 and not short:
            short.append(make(tmp_path, 1))
            assert sound(short[0].folder)

    made = make(tmp_path, progress=overtake)
    assert read_manifest(target_of(tmp_path)) == made.manifest != short[0].manifest
    assert sound(made.folder)
    assert beside(tmp_path) == ["sweep"]
