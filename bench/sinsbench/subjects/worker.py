"""Call a Python function in a process of its own: ``python worker.py FOLDER``.

A script that needs nothing but NumPy, so that any Python can run it, also one without this package. FOLDER holds
``request.json`` and, for a call, ``request.npz``; the answer is ``reply.json`` and, where there is a result,
``reply.npz``. What the function prints goes to standard error.
"""

import sys
from pathlib import Path

if __name__ == "__main__" and Path(sys.path[0]) == Path(__file__).parent:
    sys.path.pop(0)  # its neighbours are no modules that a function may import

import contextlib
import importlib
import importlib.util
import inspect
import json
import os
import re
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Mapping
from types import SimpleNamespace
from typing import Any

_Reply = dict[str, Any]


class _CallError(Exception):
    """The call ends here, with a status and a message."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status = status


def _load(target: str, folder: str) -> Callable[..., Any]:
    """Return what ``path/to/file.py:name`` or ``package.module:name`` names."""
    place, _, attribute = target.rpartition(":")
    path = Path(place)
    if place.endswith(".py"):
        sys.path.insert(0, str(path.resolve().parent))
        specification = importlib.util.spec_from_file_location(f"_sinsbench_subject_{path.stem}", path)
        if specification is None or specification.loader is None:
            raise _CallError("error", f"{place} is not a Python file")
        module = importlib.util.module_from_spec(specification)
        sys.modules[specification.name] = module  # dataclasses and pickle look the module up by its name
        specification.loader.exec_module(module)
    else:
        sys.path.insert(0, folder)
        module = importlib.import_module(place)
    value: Any = module
    for part in attribute.split("."):
        value = getattr(value, part)
    if not callable(value):
        raise _CallError("error", f"{attribute!r} in {place} is {type(value).__name__}, not a callable")
    function: Callable[..., Any] = value
    return function


def _failure(error: BaseException) -> tuple[str, str]:
    """Return status and one line for an exception of a stranger's code."""
    if isinstance(error, _CallError):
        return error.status, str(error)
    try:
        text = " ".join(str(error).split())
    except BaseException as another:  # a stranger's __str__ may raise anything
        text = f"its message cannot be had, __str__ raises {type(another).__name__}"
    if any(kind.__name__ == "NotApplicableError" for kind in type(error).__mro__):
        return "not applicable", text
    frames = [one for one in traceback.extract_tb(error.__traceback__) if one.filename != __file__]
    frames = [one for one in frames if not one.filename.startswith("<frozen")]
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    message = f"{type(error).__name__}{text and ': '}{text}{place}"
    return "out of memory" if isinstance(error, MemoryError) else "error", message


def _version(distribution: str) -> str:
    """Return name and version of an installed distribution, and of NumPy."""
    from importlib.metadata import PackageNotFoundError, version

    if not distribution:
        return ""
    try:
        own = f"{distribution} {version(distribution)}"
    except PackageNotFoundError:
        return ""
    return own if distribution == "numpy" else f"{own}, numpy {version('numpy')}"


def not_taken(function: Callable[..., Any], names: Iterable[str]) -> str | None:
    """Return the first of some names that a function does not take as a keyword."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # compiled code may hide its signature: the call will tell
        return None
    if any(one.kind is one.VAR_KEYWORD for one in parameters):
        return None
    taken = {one.name for one in parameters if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)}
    return next((name for name in names if name not in taken), None)


def _description(function: Callable[..., Any]) -> _Reply:
    """Return what a function tells about itself: its attributes as far as JSON holds them, and its summary."""
    told: _Reply = {"summary": (getattr(function, "__doc__", None) or "").strip().split("\n")[0]}
    for name in ("samples_per_step", "takes", "state_bytes"):
        value = getattr(function, name, None)
        told[name] = value if isinstance(value, str | int | None) else type(value).__name__
    return told


def _numbers(name: str, value: Any) -> Any:
    import numpy as np

    try:
        array = np.asarray(value)
    except MemoryError:
        raise
    except Exception as error:  # a stranger's object may raise anything when it is asked for its numbers
        raise _CallError("wrong shape", f"{name} is not an array of real numbers: {error}") from error
    if array.dtype.kind not in "fiu":
        raise _CallError("wrong shape", f"{name} is not an array of real numbers: its elements are {array.dtype}")
    return array


def _objects(leaves: Mapping[str, Any]) -> _Reply:
    """Return arguments by name: objects with attributes for ``name.field``, mappings with keys for ``name:key``."""
    made: _Reply = {}
    for path, value in leaves.items():
        place, name = made, ""
        for mark, part in re.findall(r"([.:]?)([^.:]+)", path):
            if mark == ".":
                place = place.setdefault(name, SimpleNamespace()).__dict__
            elif mark:
                place = place.setdefault(name, {})
            name = part
        place[name] = value
    return made


def _call(function: Callable[..., Any], folder: Path, request: Mapping[str, Any]) -> _Reply:
    """Call a function as a request says, and again for its time."""
    import numpy as np

    missing = not_taken(function, request["keywords"])
    if missing is not None:
        raise _CallError("not applicable", f"takes no {missing}")
    with np.load(folder / "request.npz", allow_pickle=False) as stored:
        given = {name: stored[name] if stored[name].ndim else stored[name].item() for name in stored.files}
    names = [f"argument{i}" for i in range(request["arguments"])]

    def once() -> tuple[Any, float]:
        # Copies: a function may write into its arguments.
        copies = {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in given.items()}
        own = _objects({**copies, **request["texts"]})
        positional, named = [own[name] for name in names], {name: own[name] for name in request["keywords"]}
        start = time.perf_counter()
        result = function(*positional, **named)
        return result, time.perf_counter() - start

    result, _ = once()  # may compile, and does not count
    if isinstance(result, Mapping):
        made = {name: _numbers(name, result[name]) for name in request["outputs"] if result.get(name) is not None}
    else:
        made = {"": _numbers("the result", result)}
    np.savez(folder / "reply.npz", **{f"result_{name}": value for name, value in made.items()})
    seconds: list[float] = []
    while len(seconds) < request["repetitions"] and sum(seconds) < request["budget"]:
        seconds.append(once()[1])
    return {"seconds": seconds}


def _answer(folder: Path) -> _Reply:
    request = json.loads((folder / "request.json").read_text(encoding="utf-8"))
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(sys.stderr):
            warnings.simplefilter("ignore")
            try:
                function = _load(request["target"], request["folder"])
            except ModuleNotFoundError as error:
                raise _CallError("not installed", _failure(error)[1]) from error
            reply = _description(function) if request["describe"] else _call(function, folder, request)
        return {"status": "ok", "message": "", "version": _version(request["distribution"]), **reply}
    except BaseException as error:  # a stranger's code may raise anything
        status, message = _failure(error)
        return {"status": status, "message": message}


def main(folder: Path) -> None:
    """Answer the request in a folder."""
    # As in the process that asks: the threads that a library starts for matrices take memory, and small ones no less.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    reply = _answer(folder)
    temporary = folder / "reply.part"
    temporary.write_text(json.dumps(reply), encoding="utf-8")
    temporary.replace(folder / "reply.json")  # an answer is whole, or there is none
    with contextlib.suppress(OSError, ValueError):  # full, or closed: what a function printed is not the answer
        sys.stderr.flush()
    os._exit(0)  # threads that a function left behind, and what libraries do at the end, are not waited for


if __name__ == "__main__":
    main(Path(sys.argv[1]))
