"""Tables as pandas frames that keep their units: Arrow metadata does not survive pandas, `DataFrame.attrs` does."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pyarrow.parquet as pq

from sinsdata.schema import DATASETS
from sinsdata.verify import DatasetError, read_manifest

if TYPE_CHECKING:
    import pandas as pd


def read_frame(folder: Path | str, table: str, cases: Sequence[str] | None = None) -> pd.DataFrame:
    """Read a table of a dataset.

    Parameters
    ----------
    folder : path
        The dataset, a folder with a manifest.
    table : str
        Such as ``truth``.
    cases : sequence of str, optional
        Names of the cases wanted; all by default.

    Returns
    -------
    pandas.DataFrame
        With ``attrs["units"]``, ``attrs["descriptions"]`` and ``attrs["frames"]`` by column.

    Raises
    ------
    sinsdata.verify.DatasetError
        If the folder is not a dataset of this version, or has no such table or case.
    """
    manifest = read_manifest(Path(folder))
    if table not in manifest["tables"]:
        raise DatasetError(
            f"{folder}: no table {table!r}; admissible: {', '.join(DATASETS[manifest['dataset']].tables)}"
        )
    for name in cases or ():
        if name not in manifest["cases"]:
            raise DatasetError(f"{folder}: no case {name!r}; admissible: {', '.join(manifest['cases'])}")
    filters = None if cases is None else [("case", "in", list(cases))]
    data = pq.read_table(Path(folder) / manifest["tables"][table]["file"], filters=filters)
    frame: pd.DataFrame = data.to_pandas()
    for attribute, key in (("units", b"unit"), ("descriptions", b"description"), ("frames", b"frame")):
        frame.attrs[attribute] = {field.name: (field.metadata or {}).get(key, b"").decode() for field in data.schema}
    return frame
