"""Whether a folder holds a dataset, whole, with the content that the registry states."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from sinsdata.format.storage import file_hash
from sinsdata.publishing.archives import ArchiveError, check_files, listed_files
from sinsdata.publishing.registry import Entry


def stated_contents(manifest: Mapping[str, Any]) -> dict[str, str]:
    """Return the content hashes that a manifest states, by table."""
    return {table: about["content_sha256"] for table, about in manifest["tables"].items()}


def stored_contents(folder: Path, manifest: Mapping[str, Any]) -> dict[str, str]:
    """Return the content hashes of the tables as they are stored, computed from every row.

    Parameters
    ----------
    folder : Path
    manifest : mapping
        Its manifest: which files a table consists of.

    Raises
    ------
    ArchiveError
        If the files of a table differ in their columns.
    """
    # Here: what is cached as it was published is not read for this.
    import pyarrow.parquet as pq

    from sinsdata.format.content_hash import ContentHash

    found = {}
    for table, about in manifest["tables"].items():
        schema = pq.read_schema(folder / about["files"][0]["file"])
        digest = ContentHash(schema)
        for entry in about["files"]:
            with pq.ParquetFile(folder / entry["file"]) as file:
                if not file.schema_arrow.equals(schema, check_metadata=True):
                    raise ArchiveError(f"{folder / entry['file']}: other columns than the first file of {table}")
                for rows in file.iter_batches():
                    digest.update(rows)
        found[table] = digest.hexdigest()
    return found


def is_published(folder: Path, entry: Entry) -> bool:
    """Return whether the manifest in a folder is, by its SHA-256, the one that was published.

    Its word on content and files is then the publisher's.
    """
    path = folder / "manifest.json"
    return file_hash(path) == entry.manifest_sha256 and stated_contents(
        json.loads(path.read_text(encoding="utf-8"))
    ) == dict(entry.content_sha256)


def _is_the_same(folder: Path, manifest: Mapping[str, Any], entry: Entry) -> bool:
    """Return whether a dataset with a manifest of its own, such as a generated one, has the published content."""
    named = (manifest["dataset"], manifest["tier"], manifest["version"])
    return named == (entry.dataset, entry.tier, entry.version) and stored_contents(folder, manifest) == dict(
        entry.content_sha256
    )


def sound_manifest(folder: Path, entry: Entry | None, hashed: bool = True) -> dict[str, Any] | None:
    """Return the manifest of a dataset that is whole and has the content that the registry states; None otherwise.

    The word of a manifest is taken only if it is the published one; of any other the content is computed.

    Parameters
    ----------
    folder : Path
    entry : Entry or None
        Of the registry, where it has one.
    hashed : bool, default True
        Hash the files; otherwise their lengths must do.
    """
    # NotImplementedError: of pyarrow, for files that it cannot decode.
    unsound = (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, NotImplementedError)
    with suppress(*unsound):
        manifest: dict[str, Any] = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
        if hashed:
            check_files(folder, manifest)
        whole = all((folder / name).stat().st_size == about["bytes"] for name, about in listed_files(manifest).items())
        if whole and (entry is None or is_published(folder, entry) or _is_the_same(folder, manifest, entry)):
            return manifest
    return None


def is_sound(folder: Path, entry: Entry | None) -> bool:
    """Return whether a folder holds a dataset, whole, with the content that the registry states."""
    return sound_manifest(folder, entry) is not None
