"""Find the callable that a user means: a built-in subject, ``package.module:name`` or ``path/to/file.py:name``."""

import contextlib
import difflib
import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from sinsbench.subjects.registry import BUILT_IN, Subject

__all__ = ["FORMS", "LoadedSubject", "SubjectError", "described", "printable", "resolve"]

FORMS = "a built-in name, package.module:name or path/to/file.py:name"
_LISTED = 8  # names shown of what a module holds


class SubjectError(ValueError):
    """A subject cannot be had; the message says in one line what is wrong and where.

    Parameters
    ----------
    message : str
    """

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


@dataclass(frozen=True)
class LoadedSubject:
    """A subject together with its code.

    Attributes
    ----------
    subject : Subject
        What it is.
    function : callable
        The code, called as the contract of the dataset says.
    elsewhere : bool
        Whether the code runs in another process, or has run before: there is nothing to count or to trace here.
    of_case : callable, optional
        For results that were computed beforehand: ``of_case(case, interval)`` is the subject that looks up those of a
        case, which are for its own sampling interval alone.
    """

    subject: Subject
    function: Callable[..., Any]
    elsewhere: bool = False
    of_case: "Callable[[str, float], LoadedSubject] | None" = None


def printable(text: str) -> str:
    """Return a text that UTF-8 can encode, with a question mark for each lone surrogate."""
    return text.encode("utf-8", "replace").decode("utf-8")


def described(error: BaseException) -> str:
    """Return the message of a stranger's exception in one line, which may be empty.

    Raises
    ------
    KeyboardInterrupt
        If it arrives meanwhile. Whatever else the exception's ``__str__`` raises is told in place of the message.
    """
    try:
        return printable(" ".join(str(error).split()))
    except KeyboardInterrupt:
        raise
    except BaseException as another:  # a stranger's __str__ may raise anything
        return f"its message cannot be had, __str__ raises {type(another).__name__}"


def resolve(text: str) -> LoadedSubject:
    """Load the subject that a text names.

    Parameters
    ----------
    text : str
        A built-in name, ``package.module:name`` or ``path/to/file.py:name``. A file may import modules of its own
        folder, a module may lie in the working directory; `sys.path` is left as it was.

    Returns
    -------
    LoadedSubject
        A callable may say how many samples its step consumes in an attribute ``samples_per_step``, and which input
        convention it takes in an attribute ``takes``.

    Raises
    ------
    SubjectError
        If the name is unknown, the file or module is missing or fails to import, or holds no such callable, or what
        the callable takes is no name.
    """
    if text in BUILT_IN:
        subject = BUILT_IN[text]
        module, _, attribute = subject.target.partition(":")
        return LoadedSubject(subject, _callable(importlib.import_module(module), attribute, module))
    place, colon, attribute = text.rpartition(":")
    if not colon or not place or not attribute:
        raise SubjectError(_unknown(text))
    is_file = place.endswith(".py") or "/" in place or "\\" in place
    module_object = _load_file(Path(place)) if is_file else _load_module(place)
    function = _callable(module_object, attribute, place)
    samples = getattr(function, "samples_per_step", None)
    summary = (getattr(function, "__doc__", None) or "").strip().split("\n")[0]
    samples = samples if type(samples) is int and samples > 0 else None
    takes = getattr(function, "takes", None)
    if not isinstance(takes, str | None):
        raise SubjectError(
            f"{text} takes {type(takes).__name__}: the attribute must be the name of an input convention"
        )
    return LoadedSubject(Subject(text, None, text, summary, samples_per_step=samples, takes=takes), function)


def _unknown(text: str) -> str:
    if text.endswith(".py"):
        return f"{text!r} names a file but no callable in it: write {text}:NAME"
    near = difflib.get_close_matches(text, BUILT_IN, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"a subject is {FORMS}"
    return f"there is no subject {text!r}; {hint}"


def _callable(module: ModuleType, attribute: str, place: str) -> Callable[..., Any]:
    value: Any = module
    for part in attribute.split("."):
        if not hasattr(value, part):
            raise SubjectError(f"{place} holds no {attribute!r}; {_callables_of(module)}")
        value = getattr(value, part)
    if not callable(value):
        raise SubjectError(
            f"{attribute!r} in {place} is {type(value).__name__}, not a callable; {_callables_of(module)}"
        )
    function: Callable[..., Any] = value
    return function


def _callables_of(module: ModuleType) -> str:
    """List what the module itself defines; what it imports is hardly what the user means."""
    names = [
        name
        for name, value in vars(module).items()
        if callable(value) and not name.startswith("_") and getattr(value, "__module__", None) == module.__name__
    ]
    if not names:
        return "it holds no callable of its own"
    return f"it holds {', '.join(names[:_LISTED])}" + (", ..." if len(names) > _LISTED else "")


@contextlib.contextmanager
def _importing_from(folder: Path) -> Iterator[None]:
    """Let imports find modules of a folder, for the time of a ``with`` block."""
    before = list(sys.path)
    sys.path.insert(0, str(folder))
    try:
        # What an imported file prints must not mix with the results on standard output.
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        sys.path[:] = before


def _load_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise SubjectError(f"there is no file {path}")
    resolved = path.resolve()
    # A private name: a user's file called numpy.py or test.py must not replace a real module.
    name = f"_sinsbench_subject_{abs(hash(resolved)):x}_{path.stem}"
    specification = importlib.util.spec_from_file_location(name, resolved)
    if specification is None or specification.loader is None:
        raise SubjectError(f"{path} is not a Python file: its name does not end in .py")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # dataclasses and pickle look the module up by its name
    try:
        with _importing_from(resolved.parent):
            specification.loader.exec_module(module)
    except BaseException as error:  # a stranger's file may raise anything
        sys.modules.pop(name, None)
        if isinstance(error, KeyboardInterrupt):
            raise
        raise SubjectError(_failure(error, resolved, str(path))) from error
    return module


def _load_module(name: str) -> ModuleType:
    try:
        with _importing_from(Path.cwd()):
            return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name and f"{name}.".startswith(f"{error.name}."):
            raise SubjectError(
                f"there is no module {error.name!r} (a file is given as path/to/file.py:name)"
            ) from error
        raise SubjectError(_failure(error, None, name)) from error
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a stranger's module may raise anything
        raise SubjectError(_failure(error, None, name)) from error


def _failure(error: BaseException, path: Path | None, place: str) -> str:
    """Say which line of the user's own code failed, and why, in one line."""
    what = f"{type(error).__name__}: {described(error)}"
    if isinstance(error, SyntaxError) and error.lineno is not None:
        # The file with the slip may be another one, which the user's file imports.
        name = place if error.filename in (None, str(path)) else error.filename
        return f"{name}, line {error.lineno}: {type(error).__name__}: {error.msg}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if path is not None and Path(frame.filename) == path]
    if own:
        return f"{place}, line {own[-1].lineno}: {what}"
    foreign = [frame for frame in frames if not frame.filename.startswith("<frozen") and frame.filename != __file__]
    foreign = [frame for frame in foreign if Path(frame.filename).parent.name != "importlib"]
    return f"{place} cannot be imported: {what}" + (
        f" ({foreign[-1].filename}, line {foreign[-1].lineno})" if foreign else ""
    )
