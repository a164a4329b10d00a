"""A Python callable as a subject in a process of its own: whatever it does, the run goes on."""

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sinsbench.subjects.isolation import describe_elsewhere, rows_of, run_elsewhere
from sinsbench.subjects.loading import LoadedSubject, SubjectError
from sinsbench.subjects.outcome import Outcome, OutcomeError
from sinsbench.subjects.processes import Limits, Patience
from sinsbench.subjects.registry import Subject

__all__ = ["Isolated", "isolated_subject"]

_USERS_SLIPS = ("error", "not installed")  # told before anything runs, as when the callable is loaded in this process


@dataclass
class Isolated:
    """A callable of the same contract that calls another one in a fresh process each time.

    Parameters
    ----------
    target : str
        ``path/to/file.py:name`` or ``package.module:name``.
    limits : Limits
    broken : OutcomeError, optional
        What became of the attempt to load it.
    """

    target: str
    limits: Limits
    broken: OutcomeError | None = None
    _patience: Patience = field(default_factory=Patience, init=False)

    def __call__(self, *arguments: Any, **keywords: Any) -> Outcome:
        """Call the callable.

        Raises
        ------
        OutcomeError
            See `sinsbench.subjects.isolation.run_elsewhere`.
        """
        if self.broken is not None:
            raise OutcomeError(self.broken.status, str(self.broken))
        python = Path(sys.executable)
        return self._patience.wait(
            rows_of(arguments), lambda: run_elsewhere(python, self.target, arguments, keywords, self.limits)
        )


def isolated_subject(text: str, limits: Limits | None = None) -> LoadedSubject:
    """Make a subject of a callable that is never loaded in this process.

    Parameters
    ----------
    text : str
        ``path/to/file.py:name`` or ``package.module:name``.
    limits : Limits, optional

    Raises
    ------
    SubjectError
        If the file or module is missing or raises when it is imported, or holds no such callable. One that hangs or
        crashes meanwhile is a subject, and says so when it is called.
    """
    place, colon, attribute = text.rpartition(":")
    if not colon or not place or not attribute:
        raise SubjectError(f"{text!r} is no callable: write path/to/file.py:name or package.module:name")
    if place.endswith(".py") and not Path(place).is_file():
        raise SubjectError(f"there is no file {place}")
    limits = limits or Limits()
    try:
        told = describe_elsewhere(Path(sys.executable), text, limits)
    except OutcomeError as error:
        if error.status in _USERS_SLIPS and not str(error).startswith("exit status"):
            raise SubjectError(f"{text}: {error}") from None
        return LoadedSubject(Subject(text, None, text, ""), Isolated(text, limits, error), elsewhere=True)
    samples, takes, size = told["samples_per_step"], told["takes"], told["state_bytes"]
    subject = Subject(
        text,
        None,
        text,
        told["summary"],
        samples_per_step=samples if type(samples) is int and samples > 0 else None,
        takes=takes if takes is None else str(takes),
        state_bytes=size if type(size) is int and size >= 0 else None,
    )
    return LoadedSubject(subject, Isolated(text, limits), elsewhere=True)
