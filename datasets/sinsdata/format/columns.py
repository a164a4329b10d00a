"""Columns and datasets as data: names, units, frames, accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pyarrow as pa

_ACCURACY = "correctly rounded: the binary64 nearest to the exact value (ties to even)"
_ACCURACY_LO = (
    "the binary64 nearest to exact value minus {name}; together within 1e-30 relative, proved by ball arithmetic"
)
_ACCURACY_EXACT = "exact"
_ACCURACY_NEAREST = "the binary64 nearest to the exact value, which stands in {name}_exact"
_ACCURACY_MEASURE = "two significant digits"
_ACCURACY_VALUE = "within {within:g}{unit} of the exact value, or {share:g} of the largest of its unit in the row"
_ACCURACY_RELATIVE = "within {within:g} of its own size"
#: Error that a value may have relative to the largest of its unit in the row, where that is more: a few roundings.
SHARE = 2e-15
_ACCURACY_WHOLE = "exact: a whole number of quanta, of which ball arithmetic proves how many"
_ACCURACY_WHOLE_LO = "exact; 0 where binary64 holds the number of quanta"


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : str
    unit : str
        SI; empty where there is none.
    description : str
    frame : str
        Axes in which a component is resolved.
    kind : {"pair", "key", "index", "parameter", "measure", "value"}
        A pair becomes two fields, x and x_lo; a parameter becomes its nearest binary64 and the exact text
        ``x_exact``; a measure is one field, meant for sorting; a value is one field of stated accuracy.
    whole : bool
        Whether a pair is a whole number of quanta, and so exact.
    within : float
        Accuracy of a value.
    relative : bool
        Whether that is relative to the exact value.
    """

    name: str
    unit: str
    description: str
    frame: str = ""
    kind: str = "pair"
    whole: bool = False
    within: float = 0.0
    relative: bool = False

    def fields(self) -> list[pa.Field]:
        """Return the Arrow fields, with unit, description, frame and accuracy as metadata."""
        import pyarrow as pa

        def field(name: str, kind: pa.DataType, accuracy: str, description: str) -> pa.Field:
            metadata = {
                "unit": self.unit,
                "description": description,
                "frame": self.frame,
                "accuracy": accuracy,
            }
            return pa.field(name, kind, metadata={k: v for k, v in metadata.items() if v})

        if self.kind in ("key", "index"):
            kind = pa.string() if self.kind == "key" else pa.int64()
            return [field(self.name, kind, _ACCURACY_EXACT, self.description)]
        if self.kind == "measure":
            return [field(self.name, pa.float64(), _ACCURACY_MEASURE, self.description)]
        if self.kind == "value":
            unit = f" {self.unit}" if self.unit not in ("", "1") else ""
            said = _ACCURACY_RELATIVE if self.relative else _ACCURACY_VALUE
            accuracy = said.format(within=self.within, unit=unit, share=SHARE)
            return [field(self.name, pa.float64(), accuracy, self.description)]
        if self.kind == "parameter":
            return [
                field(self.name, pa.float64(), _ACCURACY_NEAREST.format(name=self.name), self.description),
                field(f"{self.name}_exact", pa.string(), _ACCURACY_EXACT, f"exact value: {self.description}"),
            ]
        return [
            field(self.name, pa.float64(), _ACCURACY_WHOLE if self.whole else _ACCURACY, self.description),
            field(
                f"{self.name}_lo",
                pa.float64(),
                _ACCURACY_WHOLE_LO if self.whole else _ACCURACY_LO.format(name=self.name),
                f"rest: {self.description}",
            ),
        ]


@dataclass(frozen=True)
class DatasetSchema:
    """A dataset: its tables and where it comes from.

    Attributes
    ----------
    name, title, version : str
        The version of the data: PATCH same data reserialised, MINOR added, MAJOR changed.
    source : str
        The paper.
    doi : str
        Of the paper; empty where it has none.
    parameters : mapping of str to str
        Constants and conventions that hold for all cases.
    tables : mapping of str to tuple of Column
    digits : str
        Significant digits of its values.
    method : str
        How these are certified.
    """

    name: str
    title: str
    version: str
    source: str
    doi: str
    parameters: Mapping[str, str]
    tables: Mapping[str, tuple[Column, ...]]
    digits: str = "32"
    method: str = "ball arithmetic; x nearest binary64, x + x_lo within 1e-30 relative, both proved"
