"""The registry: which archives hold the published data, with their hashes, and where they can be had."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sinsdata.format.names import UnsafeNameError, safe_name

#: Layout of the file; a reader refuses any other.
REGISTRY_FORMAT = 1
#: The registry of the data that belong to this version of the package.
SHIPPED = Path(__file__).with_name("registry.json")

_SHA256 = re.compile(r"[0-9a-f]{64}")


class RegistryError(ValueError):
    """A registry cannot be used; the message says which and why."""


@dataclass(frozen=True)
class Entry:
    """One published archive.

    Attributes
    ----------
    dataset, tier, version : str
        What it holds.
    archive : str
        Its file name.
    bytes : int
        Its length.
    sha256 : str
        Of the archive.
    unpacked_bytes : int
        Of all its files together.
    manifest_sha256 : str
        Of its manifest, which has the hashes of all other files.
    content_sha256 : mapping of str to str
        Table to content hash, which does not depend on how the table was written.
    """

    dataset: str
    tier: str
    version: str
    archive: str
    bytes: int
    sha256: str
    unpacked_bytes: int
    manifest_sha256: str
    content_sha256: Mapping[str, str]

    def __post_init__(self) -> None:
        for text in (self.dataset, self.tier, self.version, self.archive, *self.content_sha256):
            safe_name(text)
        for length in (self.bytes, self.unpacked_bytes):
            if not isinstance(length, int) or length < 0:
                raise ValueError(f"{length!r} is not a number of bytes")
        for digest in (self.sha256, self.manifest_sha256, *self.content_sha256.values()):
            if not isinstance(digest, str) or not _SHA256.fullmatch(digest):
                raise ValueError(f"{digest!r} is not a SHA-256")


@dataclass(frozen=True)
class Registry:
    """Published archives, and where to ask for them.

    Attributes
    ----------
    entries : tuple of Entry
    mirrors : tuple of str
        Base URLs; the name of the archive is put behind.
    """

    entries: tuple[Entry, ...] = ()
    mirrors: tuple[str, ...] = ()

    def find(self, dataset: str, tier: str) -> Entry | None:
        """Return the entry of a dataset and tier, the last one where there are several versions; None without one."""
        return next((entry for entry in reversed(self.entries) if (entry.dataset, entry.tier) == (dataset, tier)), None)


def read_registry(path: Path = SHIPPED) -> Registry:
    """Read a registry.

    Parameters
    ----------
    path : Path, optional
        That of the package by default; that of a bundle stands in its folder.

    Raises
    ------
    RegistryError
        If the file cannot be read, is of another format, or an entry is not sound.
    """
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
        if given["format"] != REGISTRY_FORMAT:
            raise RegistryError(f"{path}: format {given['format']!r}; this version reads format {REGISTRY_FORMAT}")
        mirrors = tuple(given["mirrors"])
        if not all(isinstance(url, str) for url in mirrors):
            raise RegistryError(f"{path}: a mirror is not a URL")
        return Registry(tuple(Entry(**entry) for entry in given["entries"]), mirrors)
    except OSError as error:
        raise RegistryError(f"{path}: {error.strerror or error}") from None
    except UnsafeNameError as error:
        raise RegistryError(f"{path}: {error}") from None
    except RegistryError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise RegistryError(f"{path}: not a registry: {type(error).__name__}: {error}") from None


def registry_json(registry: Registry) -> dict[str, Any]:
    """Return the content of a registry's file."""
    return {
        "format": REGISTRY_FORMAT,
        "mirrors": list(registry.mirrors),
        "entries": [{**vars(entry), "content_sha256": dict(entry.content_sha256)} for entry in registry.entries],
    }
