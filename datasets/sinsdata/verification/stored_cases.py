"""Datasets in folders, and the cases that they were made from."""

from __future__ import annotations

import re
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from sinsdata.cases import Case
from sinsdata.format.case_columns import mapping
from sinsdata.format.manifest import NAME, DatasetError, read_manifest, table_files
from sinsdata.tiers import CaseFileError, checked_cases


def find_datasets(folder: Path) -> list[Path]:
    """Return the dataset folders at or below a folder.

    Raises
    ------
    sinsdata.format.manifest.DatasetError
        If there is none.
    """
    if not folder.is_dir():
        # A path has only one of the slashes; a single letter is a drive.
        if not folder.exists() and (uri := re.match(r"[A-Za-z][A-Za-z0-9+.-]+:/(?!/)", str(folder))):
            raise DatasetError(
                f"{uri[0]}/{str(folder)[uri.end() :]}: datasets are read from local folders; copy it to one first"
            )
        raise DatasetError(f"{folder}: {'a file, not a folder' if folder.exists() else 'no such folder'}")
    found = sorted({path.parent for depth in ("", "*/", "*/*/") for path in folder.glob(depth + NAME)})
    found = [path for path in found if not any(part.startswith(".") for part in path.relative_to(folder).parts)]
    if not found:
        raise DatasetError(f"{folder}: not a dataset: no {NAME} here or in DATASET/TIER below")
    return found


def load_cases(folder: Path) -> tuple[str, tuple[Case, ...]]:
    """Return name and cases of the dataset in a folder.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    sinsdata.format.manifest.DatasetError
        If the folder is not a dataset that this version reads.
    """
    manifest = read_manifest(folder)
    dataset, paths = manifest["dataset"], table_files(folder, manifest, "cases")
    try:
        rows = [row for path in paths for row in pq.read_table(path, partitioning=None).to_pylist()]
        return dataset, checked_cases(dataset, [mapping(dataset, row) for row in rows], str(paths[0]))
    except (OSError, pa.ArrowException, KeyError, CaseFileError) as error:
        raise DatasetError(f"{paths[0]}: {str(error) or type(error).__name__}") from None
