"""Call a Python function of any environment in a process of its own, under limits."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sinsbench.subjects.outcome import Outcome, OutcomeError
from sinsbench.subjects.processes import Limits, fail, private_folder, run_process

__all__ = ["OUTPUTS", "Limits", "describe_elsewhere", "rows_of", "run_elsewhere"]

OUTPUTS = (
    *("attitude", "velocity_inertial", "velocity_body", "vertical", "trihedron", "speed"),
    *("time", "mu", "longitude", "latitude", "velocity", "height", "eta", "lambda", "mast_rate"),
    *("covariance", "nis", "nis_freedom"),
)
"""What may be taken from a mapping that a function returns."""

_WORKER = Path(__file__).with_name("worker.py")
_BUDGET = 0.3  # s, after which no further repetition starts


def _attributes(value: Any) -> tuple[str, ...]:
    """Return the names of what an object holds: fields of a dataclass and its properties, fields of a named tuple."""
    if is_dataclass(value):
        properties = (name for name, member in vars(type(value)).items() if isinstance(member, property))
        return (*(field.name for field in fields(value)), *properties)
    return tuple(getattr(value, "_fields", ()))


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield arrays, numbers and texts of an argument: ``name``, ``name.field``, ``name.field.field``, ``name:key``."""
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _leaves(f"{name}:{key}", part)
    elif names := _attributes(value):
        for attribute in names:
            yield from _leaves(f"{name}.{attribute}", getattr(value, attribute))
    else:
        yield name, value


def rows_of(arguments: Sequence[Any]) -> int:
    """Return the length of the longest array among arguments and their fields."""
    return max((len(leaf) for one in arguments for _, leaf in _leaves("", one) if np.ndim(leaf)), default=0)


def _request(
    python: Path,
    target: str,
    folder: Path,
    limits: Limits,
    distribution: str,
    request: Mapping[str, Any],
    rows: int,
) -> dict[str, Any]:
    """Have a worker answer a request, and return the reply."""
    place, _, attribute = target.rpartition(":")
    absolute = f"{Path(place).resolve()}:{attribute}" if place.endswith(".py") else target
    whole = {"target": absolute, "folder": str(Path.cwd()), "distribution": distribution, **request}
    (folder / "request.json").write_text(json.dumps(whole), encoding="utf-8")
    finished = run_process([str(python), str(_WORKER), str(folder)], folder, limits, rows)
    answer = folder / "reply.json"
    if finished.status or not answer.exists():
        if not finished.status:
            raise OutcomeError("crashed", "left the process without an answer")
        fail(finished, limits, rows)
    reply: dict[str, Any] = json.loads(answer.read_text(encoding="utf-8"))
    if reply["status"] != "ok":
        raise OutcomeError(reply["status"], reply["message"])
    return reply


def run_elsewhere(
    python: Path,
    target: str,
    arguments: Sequence[Any],
    keywords: Mapping[str, Any] | None = None,
    limits: Limits | None = None,
    repetitions: int = 3,
    distribution: str = "",
) -> Outcome:
    """Call a function in a process of its own, with any Python that has NumPy.

    Parameters
    ----------
    python : Path
        The interpreter, that of a virtual environment for instance.
    target : str
        ``path/to/file.py:name``, or ``package.module:name`` as that interpreter finds it.
    arguments : sequence
        Arrays and numbers, or dataclasses and named tuples of these, of texts, of mappings of arrays and of one
        another, in whose place the function gets objects with the same attributes, properties among them.
    keywords : mapping of str, optional
        Arguments passed by name.
    limits : Limits, optional
    repetitions : int, default 3
        Timed calls at most, after a first one that does not count.
    distribution : str, default ""
        Name of an installed distribution whose version is to be told, and NumPy's beside it.

    Returns
    -------
    Outcome
        The result is an array, or a mapping from `OUTPUTS` to arrays.

    Raises
    ------
    OutcomeError
        If there is no result: ``not installed`` (an import failed for a missing module), ``error`` (it raised),
        ``not applicable``, ``wrong shape`` (no array of real numbers), ``timeout``, ``crashed``, ``out of memory``.
    """
    limits = limits or Limits()
    named = dict(keywords or {})
    rows = rows_of(arguments)
    with private_folder() as folder:
        given = {f"argument{i}": value for i, value in enumerate(arguments)} | named
        leaves = dict(leaf for name, value in given.items() for leaf in _leaves(name, value))
        texts = {name: value for name, value in leaves.items() if "." in name and isinstance(value, str | None)}
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in leaves.items() if name not in texts}
        if any(array.dtype.kind not in "fiub" for array in arrays.values()):
            raise OutcomeError("error", "only numbers can be sent to another process")
        np.savez(folder / "request.npz", **arrays)
        request = {
            "describe": False,
            "arguments": len(arguments),
            "texts": texts,
            "keywords": list(named),
            "outputs": OUTPUTS,
            "repetitions": repetitions,
            "budget": _BUDGET,
        }
        reply = _request(python, target, folder, limits, distribution, request, rows)
        with np.load(folder / "reply.npz", allow_pickle=False) as stored:
            made = {name.removeprefix("result_"): stored[name] for name in stored.files}
    return Outcome(made.get("", made), tuple(reply["seconds"]), reply["version"])


def describe_elsewhere(
    python: Path, target: str, limits: Limits | None = None, distribution: str = ""
) -> dict[str, Any]:
    """Load a function in a process of its own, and return what it tells about itself.

    Parameters
    ----------
    python, target, limits, distribution
        As `run_elsewhere` takes them.

    Returns
    -------
    dict
        ``summary``, ``samples_per_step``, ``takes``, ``state_bytes`` and ``version``.

    Raises
    ------
    OutcomeError
        See `run_elsewhere`.
    """
    with private_folder() as folder:
        request = {"describe": True}
        return _request(python, target, folder, limits or Limits(), distribution, request, 0)
