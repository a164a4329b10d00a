"""Loading a dataset: from the package, the cache or a folder, to Arrow tables, pandas frames and numpy arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from sinsdata.publishing.archives import check_file
from sinsdata.publishing.fetch import UnavailableError, can_be_generated, fetch, generate_instead, place_of
from sinsdata.publishing.registry import SHIPPED, read_registry
from sinsdata.publishing.soundness import sound_manifest

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from numpy.typing import NDArray

#: The tier that ships inside the package.
SHORT = Path(__file__).parents[1] / "short"


class Dataset:
    """A dataset on disk. Each file is compared with its SHA-256 before it is read for the first time.

    Parameters
    ----------
    folder : path
        With a manifest.
    manifest : dict, optional
        Where it has been read and checked already.

    Attributes
    ----------
    folder : Path
    manifest : dict

    Raises
    ------
    sinsdata.format.manifest.DatasetError
        If the folder is not a dataset of this version.
    """

    def __init__(self, folder: Path | str, manifest: dict[str, Any] | None = None) -> None:
        if manifest is None:
            # Here: it imports the schema with all that truth is computed by, which what is cached does not need.
            from sinsdata.format.manifest import read_manifest

            manifest = read_manifest(Path(folder))
        self.folder = Path(folder)
        self.manifest: dict[str, Any] = manifest
        self._checked: set[str] = set()

    def __repr__(self) -> str:
        return f"<Dataset {self.manifest['dataset']}, tier {self.manifest['tier']}: {', '.join(self.tables)}>"

    def _error(self, message: str) -> ValueError:
        from sinsdata.format.manifest import DatasetError

        return DatasetError(f"{self.folder}: {message}")

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables."""
        return tuple(self.manifest["tables"])

    @cached_property
    def cases(self) -> tuple[str, ...]:
        """Names of the cases, in the order of the rows."""
        return tuple(name for part in self.batches("cases", columns=["case"]) for name in part["case"].to_pylist())

    def files(self, table: str) -> list[Path]:
        """Return the files of a table in the order of the rows, after comparing them with the manifest.

        Raises
        ------
        sinsdata.format.manifest.DatasetError
            If there is no such table.
        sinsdata.publishing.archives.ArchiveError
            If a file is missing or is not the one that the manifest lists.
        """
        if table not in self.tables:
            raise self._error(f"no table {table!r}; admissible: {', '.join(self.tables)}")
        for entry in self.manifest["tables"][table]["files"]:
            if entry["file"] not in self._checked:
                check_file(self.folder / entry["file"], entry)
                self._checked.add(entry["file"])
        return [self.folder / entry["file"] for entry in self.manifest["tables"][table]["files"]]

    def batches(self, table: str, columns: Sequence[str] | None = None) -> Iterator[pa.RecordBatch]:
        """Yield a table piece by piece; memory holds one piece.

        Parameters
        ----------
        table : str
        columns : sequence of str, optional
            All by default.
        """
        for path in self.files(table):
            with pq.ParquetFile(path) as file:
                yield from file.iter_batches(columns=None if columns is None else list(columns))

    def table(self, table: str, cases: Sequence[str] | None = None) -> pa.Table:
        """Return a table, or its rows of some cases.

        Parameters
        ----------
        table : str
            Such as ``truth``.
        cases : sequence of str, optional
            All by default.

        Returns
        -------
        pyarrow.Table
            Units, descriptions, frames and accuracy stand in the metadata of its fields.

        Raises
        ------
        sinsdata.format.manifest.DatasetError
            If there is no such table or case.
        sinsdata.publishing.archives.ArchiveError
            If a file is not the one that the manifest lists.
        """
        files = self.files(table)
        for name in cases or ():
            if name not in self.cases:
                known = ", ".join(self.cases[:20]) + (", ..." if len(self.cases) > 20 else "")
                raise self._error(f"no case {name!r}; admissible: {known}")
        return pa.concat_tables(_rows_of(path, cases) for path in files)

    def frame(self, table: str, cases: Sequence[str] | None = None) -> pd.DataFrame:
        """Return a table, or its rows of some cases, as a frame that keeps its units.

        Arrow metadata does not survive pandas, `DataFrame.attrs` does.

        Parameters
        ----------
        table, cases
            As for `table`.

        Returns
        -------
        pandas.DataFrame
            With ``attrs["units"]``, ``attrs["descriptions"]`` and ``attrs["frames"]`` by column.
        """
        data = self.table(table, cases)
        frame: pd.DataFrame = data.to_pandas()
        for attribute, key in (("units", b"unit"), ("descriptions", b"description"), ("frames", b"frame")):
            frame.attrs[attribute] = {
                field.name: (field.metadata or {}).get(key, b"").decode() for field in data.schema
            }
        return frame

    def arrays(self, table: str, case: str) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
        """Return the numbers of one case.

        Parameters
        ----------
        table, case : str

        Returns
        -------
        dict of str to ndarray, shape (rows,)
            By column; columns of text are left out.
        """
        data = self.table(table, [case]).combine_chunks()
        return {
            name: column.to_numpy()
            for name, column in zip(data.column_names, data.columns, strict=True)
            if not pa.types.is_string(column.type)
        }


def _rows_of(path: Path, cases: Sequence[str] | None) -> pa.Table:
    """Return the rows of some cases out of a file, reading only the row groups that may hold them."""
    # Not pyarrow.parquet.read_table: it imports pandas, which takes longer than everything else here together.
    with pq.ParquetFile(path) as file:
        if cases is None:
            return file.read()
        names = [file.metadata.row_group(group).column(0).statistics for group in range(file.num_row_groups)]
        groups = [
            group
            for group, known in enumerate(names)
            if known is None or any(known.min <= case <= known.max for case in cases)
        ]
        table = file.read_row_groups(groups)
        return table.filter(pc.is_in(table["case"], pa.array(cases, pa.string())))


def load(
    dataset: str,
    tier: str = "paper",
    *,
    source: Path | str | None = None,
    mirrors: Sequence[str] = (),
    registry: Path | str = SHIPPED,
    generate: bool = False,
) -> Dataset:
    """Return a published dataset: out of the package (tier ``short``) or the cache, which is filled if need be.

    Parameters
    ----------
    dataset : str
        Such as ``dual_precession``.
    tier : str, default "paper"
    source, mirrors, registry
        Where to get what is not in the cache, as for `sinsdata.publishing.fetch.fetch`.
    generate : bool, default False
        Generate it where it cannot be had.

    Returns
    -------
    Dataset

    Raises
    ------
    sinsdata.publishing.fetch.UnavailableError
        If it is not there and cannot be had.
    sinsdata.publishing.fetch.FetchError, sinsdata.publishing.archives.ArchiveError
        If what is there is not what was published, if there is no such folder, or no such dataset or tier.
    """
    registry = Path(registry)
    if tier == "short" and (SHORT / dataset).is_dir():
        return Dataset(SHORT / dataset)
    entry = read_registry(registry).find(dataset, tier)
    folder = place_of(dataset, tier, entry, None)
    # The files are hashed when they are read; only what was generated here is read at once, for its content.
    if (manifest := sound_manifest(folder, entry, hashed=False)) is not None:
        return Dataset(folder, manifest)
    try:
        given = None if source is None else Path(source)
        return Dataset(fetch(dataset, tier, source=given, mirrors=mirrors, registry=registry).folder)
    except UnavailableError as error:
        if not generate:
            if not can_be_generated(dataset, tier):
                raise
            raise UnavailableError(
                f"{error}; it can be generated: sinsdata.load({dataset!r}, {tier!r}, generate=True)"
            ) from None
    return Dataset(generate_instead(dataset, tier, registry=registry).folder)
