"""File names that come from outside: in archives, manifests and registries."""

from __future__ import annotations

import re
from collections.abc import Iterable

_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,127}")
#: Windows takes these for devices, whatever the suffix.
_DEVICES = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)


class UnsafeNameError(ValueError):
    """A name from outside is not that of a plain file in a folder of its own; the message says which and why."""


def safe_name(text: object) -> str:
    """Return a name that is a plain file name on every system: in whatever folder it is used, it stays in it.

    Parameters
    ----------
    text : object
        Where it comes from JSON, it may be no text at all.

    Returns
    -------
    str
        The same text: 1 to 128 ASCII letters, digits, or ``_ . + -``, of which the first is a letter or digit.

    Raises
    ------
    UnsafeNameError
        For anything else: absolute paths, ``..``, drive letters, separators, hidden files, names of devices.
    """
    shown = repr(text)[:80]
    if not isinstance(text, str) or not _PLAIN.fullmatch(text):
        raise UnsafeNameError(
            f"{shown} is not a plain file name: 1 to 128 letters, digits or _ . + -, the first a letter or digit"
        )
    if _DEVICES.fullmatch(text) or text.endswith("."):
        raise UnsafeNameError(f"{shown} is not a file name on every system")
    return text


def safe_names(names: Iterable[object]) -> list[str]:
    """Return names of files that can stand together in one folder on every system.

    Parameters
    ----------
    names : iterable of object

    Returns
    -------
    list of str
        In the order given.

    Raises
    ------
    UnsafeNameError
        If a name is not safe, occurs twice, or differs from another by case alone.
    """
    seen: dict[str, str] = {}
    for text in names:
        name = safe_name(text)
        other = seen.setdefault(name.lower(), name) if name.lower() in seen else None
        if other is not None:
            same = "occurs twice" if other == name else f"differs from {other!r} by case alone"
            raise UnsafeNameError(f"{name!r} {same}")
        seen[name.lower()] = name
    return list(seen.values())
