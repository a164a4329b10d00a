"""Cases as rows of the table ``cases``, and back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from sinsdata.cases import CASE_CLASSES, Case
from sinsref.exact import ExactNumber
from sinsref.profiles import Profile

_STATE = ("dv_north", "dv_up", "dv_east", "d_height", "d_latitude", "d_longitude")
#: Columns that hold the elements of the lists in a case file; any other key has a column of its own name.
_LISTS: dict[str, tuple[Any, ...]] = {
    "initial_errors": tuple(f"{name}_initial" for name in _STATE),
    "misalignment": tuple(tuple(f"misalignment_{i}{j}" for j in "123") for i in "123"),
    "initial_attitude": tuple(f"q_{c}_initial" for c in "wxyz"),
    "initial_velocity": tuple(f"w_inertial_{c}_initial" for c in "xyz"),
    "angular_rate": tuple(f"angular_rate_{c}" for c in "xyz"),
    "mast_rate": tuple(f"mast_rate_{c}" for c in "xy"),
    **{f"{name}_rotation": tuple(f"{name}_rotation_{c}" for c in "xyz") for name in ("vehicle", "mast", "antenna")},
    "satellites": tuple((f"node_{n}", f"argument_{n}") for n in "1234"),
}


def parameters(case: Case) -> dict[str, ExactNumber | str | None]:
    """Return what a case was given, name aside, by the columns of the table ``cases``; None for what it has not."""
    return {
        column: value
        for field in fields(case)
        if field.name != "name"
        for column, value in _cells(_LISTS.get(field.name, field.name), getattr(case, field.name))
    }


def _cells(columns: Any, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(columns, str):
        yield columns, value.text if isinstance(value, Profile) else value
        return
    for number, column in enumerate(columns):
        yield from _cells(column, None if value is None else value[number])


def texts(case: Case) -> dict[str, str | None]:
    """Return the same as exact texts."""
    return {
        column: value.text if isinstance(value, ExactNumber) else value for column, value in parameters(case).items()
    }


def mapping(dataset: str, row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table ``cases`` as the keys of a case file."""

    def given(columns: Any) -> Any:
        if isinstance(columns, str):
            # Exact texts; what is no number has a column without.
            return row[f"{columns}_exact"] if f"{columns}_exact" in row else row[columns]
        values = [given(column) for column in columns]
        return None if None in values else values

    keys = [field.name for field in fields(CASE_CLASSES[dataset]) if field.name != "name"]
    return {"name": row["case"], **{key: given(_LISTS.get(key, key)) for key in keys}}
