"""Run programs in processes of their own and under limits.

Whatever a program does, this process goes on: a hang ends at a deadline, with all processes it started; a crash, a
flood of output and hunger for memory end in a status and one line. Memory and size of files are limited where the
system can do that (POSIX, memory not on macOS); deadlines hold everywhere.
"""

from __future__ import annotations

import contextlib
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from sinsbench.subjects.launch import CANNOT_RUN
from sinsbench.subjects.outcome import Outcome, OutcomeError

__all__ = ["Finished", "Limits", "LimitsError", "Patience", "fail", "private_folder", "run_process"]

_LAUNCH = Path(__file__).with_name("launch.py")
_LIMITS_MEMORY = os.name == "posix" and platform.system() != "Darwin"  # macOS takes no such limit
_TAIL = 4096  # bytes of standard error that are looked at
# Words with which programs say that they got no memory; the exit status tells nothing.
_NO_MEMORY = (
    *("out of memory", "cannot allocate memory", "bad_alloc", "memoryerror"),
    *("memory allocation of", "allocation failed", "cannot map zero-fill pages", "failed to map segment"),
)


class LimitsError(ValueError):
    """A limit makes no sense, or this system has none of that kind."""


@dataclass(frozen=True)
class Limits:
    """What a process may use up.

    Attributes
    ----------
    timeout : float or None
        Time after which it is stopped, s; None for 60 s and a millisecond for each row of its input.
    memory : int or None
        Bytes of memory of each of its processes; None for half of what the machine has.
    output : int or None
        Bytes of each file it writes, standard output and standard error among them; None for 64 MB and 2 kB for each
        row of its input.

    Raises
    ------
    LimitsError
        If a limit is not positive, or memory is to be limited on a system that cannot do it.
    """

    timeout: float | None = None
    memory: int | None = None
    output: int | None = None

    def __post_init__(self) -> None:
        for name, value in (("timeout", self.timeout), ("memory", self.memory), ("output", self.output)):
            if value is not None and not 0 < value < float("inf"):
                raise LimitsError(f"{name} = {value}: a positive number is needed")
        if self.memory is not None and not _LIMITS_MEMORY:
            raise LimitsError("this system offers no limit of memory to a process; leave it out")

    def seconds(self, rows: int = 0) -> float:
        """Return the time that an input of some rows may take, s."""
        return 60 + rows / 1000 if self.timeout is None else min(self.timeout, threading.TIMEOUT_MAX)

    def output_bytes(self, rows: int = 0) -> int:
        """Return the size that each file may have, bytes."""
        return 64_000_000 + 2000 * rows if self.output is None else self.output

    def memory_bytes(self) -> int:
        """Return the memory that each process may have, bytes (POSIX only)."""
        if self.memory is not None:
            return min(self.memory, sys.maxsize)
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2


@dataclass(frozen=True)
class Finished:
    """A process that came to its end.

    Attributes
    ----------
    status : int
        Exit status; the negative number of the signal that ended it.
    seconds : float
        Wall time from start to end, s.
    complaint : str
        Last line of standard error that is not blank; of Node, which ends with its version, the last with an error.
    told : str
        The end of standard error.
    """

    status: int
    seconds: float
    complaint: str
    told: str


@dataclass
class Patience:
    """Waits once for what takes too long: the rungs of a ladder grow, and each would use up the whole time."""

    _late_at: int = 0  # rows of the last input, if that took too long
    _message: str = ""

    def wait(self, rows: int, attempt: Callable[[], Outcome]) -> Outcome:
        """Make an attempt, unless the last one had fewer rows and was stopped already.

        Parameters
        ----------
        rows : int
            Rows of the input.
        attempt : callable

        Raises
        ------
        OutcomeError
            What the attempt raises, or ``timeout``.
        """
        if 0 < self._late_at < rows:
            raise OutcomeError("timeout", f"not run: with {self._late_at} rows it was {self._message}")
        self._late_at = 0
        try:
            return attempt()
        except OutcomeError as error:
            if error.status == "timeout":
                self._late_at, self._message = rows, str(error)
            raise


@contextlib.contextmanager
def private_folder() -> Iterator[Path]:
    """Make a folder that nobody else reads, for the time of a ``with`` block."""
    folder = Path(tempfile.mkdtemp(prefix="sinsbench-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _stop(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and all of its group."""
    with contextlib.suppress(OSError):
        if os.name == "posix":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


def _waited(process: subprocess.Popen[bytes], seconds: float) -> bool:
    """Wait for a process; return whether it had to be stopped."""
    late = threading.Event()

    def stop() -> None:
        late.set()
        _stop(process)

    # A wait with a deadline looks every 50 ms, too coarse for what is timed here.
    timer = threading.Timer(seconds, stop)
    timer.daemon = True
    timer.start()
    try:
        if hasattr(os, "waitid"):  # leaves it a zombie, whose number nobody else gets before its group is killed
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        else:
            process.wait()
    finally:
        timer.cancel()
        _stop(process)  # also what it started and left behind, and itself at an interrupt
        process.wait()
    return late.is_set()


def _end_of(path: Path) -> str:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _TAIL))
        return file.read().decode("utf-8", "replace")


def run_process(
    command: Sequence[str],
    folder: Path,
    limits: Limits,
    rows: int = 0,
    stdin: Path | None = None,
    stdout: Path | None = None,
) -> Finished:
    """Run a command to its end, in the working directory.

    Parameters
    ----------
    command : sequence of str
        Program and arguments; no shell reads them.
    folder : Path
        Where standard error goes, to a file of its own.
    limits : Limits
    rows : int
        Rows of the input, for the default timeout.
    stdin, stdout : Path, optional
        Files; by default there is nothing to read, and what is written goes where standard error goes.

    Returns
    -------
    Finished
        Also when the program reports a failure.

    Raises
    ------
    OutcomeError
        ``timeout``, ``not installed`` if there is no such program, or ``error`` if it cannot be run.
    """
    found = shutil.which(command[0])
    if found is None:
        here = Path(command[0])
        if here.is_file() and os.access(here, os.X_OK):
            raise OutcomeError("not installed", f"{command[0]} is not on the search path; write ./{command[0]}")
        if here.exists():
            raise OutcomeError("error", f"{command[0]} is not executable")
        raise OutcomeError("not installed", f"there is no program {command[0]}")
    words = [found, *command[1:]]
    if os.name == "posix":
        most = map(str, (limits.memory_bytes(), limits.output_bytes(rows)))
        words = [sys.executable, "-I", "-S", str(_LAUNCH), *most, *words]
    complaints = folder / "stderr"
    with contextlib.ExitStack() as files:
        error = files.enter_context(complaints.open("wb"))
        given: Any = subprocess.DEVNULL if stdin is None else files.enter_context(stdin.open("rb"))
        out: Any = error if stdout is None else files.enter_context(stdout.open("wb"))
        start = time.perf_counter()
        process = subprocess.Popen(words, stdin=given, stdout=out, stderr=error, start_new_session=True)
        allowed = limits.seconds(rows)
        stopped = _waited(process, allowed)
        seconds = time.perf_counter() - start
    if stopped:
        raise OutcomeError("timeout", f"stopped after {allowed:g} s")
    told = _end_of(complaints)
    return Finished(process.returncode, seconds, _complaint(told), told)


def _complaint(told: str) -> str:
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    if lines and lines[-1].startswith("Node.js v"):
        lines = [line for line in lines if re.match(r"\w*Error\b", line)] or lines
    return lines[-1] if lines else ""


def fail(finished: Finished, limits: Limits, rows: int = 0) -> NoReturn:
    """Raise what a process that reported a failure, or brought no result, stands for.

    Parameters
    ----------
    finished, limits, rows
        What `run_process` returned, and was given.

    Raises
    ------
    OutcomeError
        ``out of memory``, ``crashed`` with the name of the signal, or ``error`` with the exit status.
    """
    complaint = f": {finished.complaint}" if finished.complaint else ""
    hungry = any(words in finished.told.lower() for words in _NO_MEMORY)
    if finished.status < 0:
        name = _signal_name(-finished.status)
        if name == "SIGXFSZ":
            raise OutcomeError("error", f"wrote more than {limits.output_bytes(rows) / 1e6:g} MB{complaint}")
        # Only the system's own end of memory kills without being asked.
        status = "out of memory" if hungry or name == "SIGKILL" else "crashed"
        raise OutcomeError(status, f"killed by {name}{complaint}")
    if hungry and finished.status:
        raise OutcomeError("out of memory", f"exit status {finished.status}{complaint}")
    if finished.status == CANNOT_RUN:
        raise OutcomeError("error", finished.complaint or f"exit status {finished.status}")
    raise OutcomeError("error", f"exit status {finished.status}{complaint}")


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
