"""Tables as pandas frames that keep their units."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sinsdata.publishing.loading import Dataset

if TYPE_CHECKING:
    import pandas as pd


def read_frame(folder: Path | str, table: str, cases: Sequence[str] | None = None) -> pd.DataFrame:
    """Read a table of the dataset in a folder: `sinsdata.publishing.loading.Dataset.frame`."""
    return Dataset(folder).frame(table, cases)
