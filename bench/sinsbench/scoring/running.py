"""Run a stranger's code: time it, and turn whatever goes wrong into a status and one line."""

import contextlib
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.equator_model import NotApplicableError
from sinsbench.subjects.loading import described, printable
from sinsbench.subjects.outcome import Outcome, OutcomeError

__all__ = ["IntegratorOutput", "RunError", "Timed", "checked_integrator_output", "checked_states", "run"]

Array = NDArray[np.float64]

_COLUMNS = {"attitude": 4, "velocity_inertial": 3, "velocity_body": 3}
_MESSAGE_LENGTH = 300


class RunError(Exception):
    """A subject did not yield a usable result.

    Parameters
    ----------
    status : str
        One of `sinsbench.scoring.rows.STATUSES`.
    message : str
        Made one line, of limited length, that UTF-8 can encode.
    """

    def __init__(self, status: str, message: str) -> None:
        line = printable(" ".join(message.split()))
        super().__init__(line if len(line) <= _MESSAGE_LENGTH else line[: _MESSAGE_LENGTH - 3] + "...")
        self.status = status


@dataclass(frozen=True)
class Timed:
    """What a subject returned, and how long it took.

    Attributes
    ----------
    result : object
    seconds : tuple of float
        Times of the calls that count, s; empty if there were none.
    version : str
        Version of what runs elsewhere, where it tells one.
    elsewhere : bool
        Whether it ran in another process, so that its operations cannot be counted here.
    """

    result: Any
    seconds: tuple[float, ...]
    version: str = ""
    elsewhere: bool = False

    @property
    def least(self) -> float:
        """Least of the times, s; NaN if there are none."""
        return min(self.seconds, default=float("nan"))

    @property
    def median(self) -> float:
        """Median of the times, s; NaN if there are none."""
        return float(np.median(self.seconds)) if self.seconds else float("nan")


def run(
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    repetitions: int = 3,
    warm: bool = False,
    budget: float = 0.3,
    keywords: Mapping[str, Any] | None = None,
) -> Timed:
    """Call a subject, and again for its time; one that runs elsewhere is called once, and brings its times.

    Parameters
    ----------
    function : callable
    arguments : tuple
        Arrays among them are copied for each call: a subject may write into its arguments.
    repetitions : int, default 3
        Timed calls at most; 0 for none.
    warm : bool
        Whether the first call may be timed too; otherwise it may compile, and does not count.
    budget : float, default 0.3
        Time after which no further repetition starts, s.
    keywords : mapping, optional
        Arguments passed by name; arrays among them are copied too.

    Returns
    -------
    Timed
        What the first call returned, and the times.

    Raises
    ------
    RunError
        If a call raises anything but KeyboardInterrupt.
    """
    named = keywords or {}
    result, first = _call(function, arguments, named)
    if isinstance(result, Outcome):
        return Timed(result.result, result.seconds if repetitions else (), result.version, elsewhere=True)
    times = [first] if warm and repetitions else []
    while len(times) < repetitions and sum(times) < budget:
        times.append(_call(function, arguments, named)[1])
    return Timed(result, tuple(times))


def _own(value: Any) -> Any:
    return value.copy() if isinstance(value, np.ndarray) else value


def _call(function: Callable[..., Any], arguments: tuple[Any, ...], keywords: Mapping[str, Any]) -> tuple[Any, float]:
    own = tuple(map(_own, arguments))
    named = {name: _own(value) for name, value in keywords.items()}
    try:
        # A subject's warnings and prints are its own affair: standard output belongs to the results.
        with warnings.catch_warnings(), contextlib.redirect_stdout(sys.stderr):
            warnings.simplefilter("ignore")
            start = time.perf_counter()
            result = function(*own, **named)
            return result, time.perf_counter() - start
    except NotApplicableError as error:
        raise RunError("not applicable", described(error)) from error
    except OutcomeError as error:
        raise RunError(error.status, str(error)) from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a stranger's code may raise anything
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f" ({Path(last.filename).name}, line {last.lineno})" if last.filename != __file__ else ""
        raise RunError("error", f"{type(error).__name__}: {described(error)}{place}") from error


@dataclass(frozen=True)
class IntegratorOutput:
    """Checked result of an integrator.

    Attributes
    ----------
    samples_per_step : int
    attitude : ndarray, shape (m+1, 4), or None
    velocity_inertial, velocity_body : ndarray, shape (m+1, 3), or None
    """

    samples_per_step: int
    attitude: Array | None
    velocity_inertial: Array | None
    velocity_body: Array | None


def checked_integrator_output(result: Any, samples: int) -> IntegratorOutput:
    """Check what an integrator returned for n samples.

    Parameters
    ----------
    result : object
        The quaternions, or a mapping with any of ``attitude``, ``velocity_inertial``, ``velocity_body``.
    samples : int
        Number n of samples it was given.

    Raises
    ------
    RunError
        If a shape is wrong, n is not a multiple of the number of steps, a value is not finite, a quaternion is zero,
        or the square of its norm leaves the range of normal binary64.
    """
    given = result if isinstance(result, Mapping) else {"attitude": result}
    arrays = {name: _array(name, given[name]) for name in _COLUMNS if given.get(name) is not None}
    if not arrays:
        held = f"it holds {', '.join(map(str, given)) or 'nothing'}" if given is result else "it is None"
        raise RunError("wrong shape", f"the result holds none of {', '.join(_COLUMNS)}; {held}")
    for name, array in arrays.items():
        m = len(array) - 1 if array.ndim else 0
        if array.ndim != 2 or array.shape[1] != _COLUMNS[name] or m < 1 or samples % m:
            hint = _transposed(array, _COLUMNS[name])
            if not hint and array.ndim == 2 and m >= 0 and samples % (m + 1) == 0:
                hint = "; is the initial row missing? Or the last one?"
            raise RunError(
                "wrong shape",
                f"{name} has shape {array.shape}; (m+1, {_COLUMNS[name]}) is needed, the initial row and one a step, "
                f"for {samples} samples in m equal steps{hint}",
            )
    rows = {name: len(array) for name, array in arrays.items()}
    if len(set(rows.values())) > 1:
        raise RunError("wrong shape", f"the numbers of rows differ: {', '.join(f'{n} {m}' for n, m in rows.items())}")
    for name, array in arrays.items():
        _check_finite(name, array)
    attitude = arrays.get("attitude")
    if attitude is not None:
        _check_norms(attitude)
    return IntegratorOutput(
        samples // (next(iter(rows.values())) - 1),
        attitude,
        arrays.get("velocity_inertial"),
        arrays.get("velocity_body"),
    )


def checked_states(result: Any, epochs: int) -> Array:
    """Check what an equator subject returned for n epochs, and return it as an (n, 6) array.

    Raises
    ------
    RunError
        If the shape is wrong or a value is not finite.
    """
    states = _array("the result", result)
    if states.shape != (epochs, 6):
        hint = _transposed(states, 6)
        raise RunError("wrong shape", f"the result has shape {states.shape}; ({epochs}, 6) is needed{hint}")
    _check_finite("the result", states)
    return states


def _array(name: str, value: Any) -> Array:
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu":
            raise TypeError(f"its elements are {array.dtype}" if array.ndim else f"it is {type(value).__name__}")
        with np.errstate(over="ignore"):  # a wider type may overflow to infinity, which is found later
            return array.astype(np.float64)
    except Exception as error:  # a stranger's object may raise anything when it is asked for its numbers
        raise RunError("wrong shape", f"{name} is not an array of real numbers: {described(error)}") from error


def _transposed(array: Array, columns: int) -> str:
    return "; transposed?" if array.ndim == 2 and array.shape[0] == columns != array.shape[1] else ""


def _check_norms(attitude: Array) -> None:
    nonzero = np.any(attitude != 0, axis=1)
    if not nonzero.all():
        raise RunError("error", f"attitude is zero, no rotation, in row {int(np.argmin(nonzero))}")
    # A square that overflows, or loses digits to underflow, tells no rotation either.
    with np.errstate(over="ignore", under="ignore"):
        squares = np.sum(attitude**2, axis=1)
    usable = np.isfinite(squares) & (squares >= np.finfo(np.float64).tiny)
    if not usable.all():
        first = int(np.argmin(usable))
        raise RunError("not finite", f"the norm of attitude leaves the range of float64, first in row {first}")


def _check_finite(name: str, array: Array) -> None:
    finite = np.isfinite(array).all(axis=1)
    if not finite.all():
        raise RunError("not finite", f"{name} holds NaN or infinity, first in row {int(np.argmin(finite))}")
