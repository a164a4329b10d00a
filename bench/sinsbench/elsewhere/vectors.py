"""Vectors as columns of a table, a column a component, and columns as vectors again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.elsewhere.files import Columns, check_finite, listed
from sinsbench.subjects.outcome import OutcomeError

__all__ = ["AXES", "QUATERNION", "assembled", "complete", "stacked", "vector_columns"]

AXES = ("x", "y", "z")
"""Names of the components of a vector."""
QUATERNION = ("w", *AXES)
"""Names of the components of a quaternion."""


def vector_columns(stem: str, values: NDArray[Any], axes: Sequence[str] = AXES) -> Columns:
    """Return the columns ``stem_x`` ... of an array whose last index is that of the component."""
    return {f"{stem}_{axis}": np.ascontiguousarray(values[..., i]) for i, axis in enumerate(axes)}


def complete(path: Path, columns: Mapping[str, Any], names: Sequence[str]) -> None:
    """Raise `OutcomeError` unless all of some columns are there."""
    missing = [name for name in names if name not in columns]
    if missing:
        raise OutcomeError("wrong shape", f"{path.name} has no column {listed(missing)}")


def stacked(columns: Columns, names: Sequence[str]) -> NDArray[Any]:
    """Return a column as it is, several as one array of shape (m, columns)."""
    return columns[names[0]] if len(names) == 1 else np.column_stack([columns[name] for name in names])


def assembled(
    path: Path, columns: Columns, rows: NDArray[Any] | None, wanted: Mapping[str, Sequence[str]]
) -> dict[str, NDArray[Any]]:
    """Return the vectors, or the numbers, of which a table has a component.

    Parameters
    ----------
    path : Path
        File that the table was read from.
    columns : dict
    rows : ndarray of int, optional
        Numbers that the rows have in the file, if it holds more.
    wanted : mapping of str to sequence of str
        Vector -> its columns.

    Raises
    ------
    OutcomeError
        If another component is missing, or a value is not finite.
    """
    made: dict[str, NDArray[Any]] = {}
    for result, names in wanted.items():
        if any(name in columns for name in names):
            complete(path, columns, names)
            check_finite(path, columns, names, rows)
            made[result] = stacked(columns, names)
    return made
