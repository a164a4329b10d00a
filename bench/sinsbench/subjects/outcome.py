"""What comes back from a subject that runs elsewhere: in another process, another environment, another language."""

from dataclasses import dataclass
from typing import Any

__all__ = ["Outcome", "OutcomeError"]


class OutcomeError(Exception):
    """A subject that runs elsewhere yielded no result.

    Parameters
    ----------
    status : str
        One of `sinsbench.scoring.rows.STATUSES`, such as ``timeout`` or ``crashed``.
    message : str
        What happened.
    """

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status = status


@dataclass(frozen=True)
class Outcome:
    """A result that brings its own times: those of the process it was made in, without the way there and back.

    Attributes
    ----------
    result : object
        What a callable of the same contract would have returned.
    seconds : tuple of float
        Times of the calls that count, s; empty where none was taken.
    version : str
        Version of what made the result, where it tells one: ``ahrs 0.4.0``.
    """

    result: Any
    seconds: tuple[float, ...] = ()
    version: str = ""
