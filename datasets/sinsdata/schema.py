"""What the tables of the datasets hold: columns, units, frames, accuracy."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

from sinsdata.truth import TRANSITION_ELEMENTS
from sinsref.earth import EQUATORIAL_GRAVITY, ROTATION_RATE, SEMI_MAJOR_AXIS

if TYPE_CHECKING:
    import pyarrow as pa

#: Layout of folder and manifest; a reader refuses any other.
FORMAT = 1

_ACCURACY = "correctly rounded: the binary64 nearest to the exact value (ties to even)"
_ACCURACY_LO = (
    "the binary64 nearest to exact value minus {name}; together within 1e-30 relative, proved by ball arithmetic"
)
_ACCURACY_EXACT = "exact"
_ACCURACY_NEAREST = "the binary64 nearest to the exact value, which stands in {name}_exact"


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
    kind : {"pair", "key", "index", "parameter"}
        A pair becomes two fields, x and x_lo; a parameter becomes its nearest binary64 and the exact text
        ``x_exact``.
    """

    name: str
    unit: str
    description: str
    frame: str = ""
    kind: str = "pair"

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
        if self.kind == "parameter":
            return [
                field(self.name, pa.float64(), _ACCURACY_NEAREST.format(name=self.name), self.description),
                field(f"{self.name}_exact", pa.string(), _ACCURACY_EXACT, f"exact value: {self.description}"),
            ]
        return [
            field(self.name, pa.float64(), _ACCURACY, self.description),
            field(
                f"{self.name}_lo",
                pa.float64(),
                _ACCURACY_LO.format(name=self.name),
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
    """

    name: str
    title: str
    version: str
    source: str
    doi: str
    parameters: Mapping[str, str]
    tables: Mapping[str, tuple[Column, ...]]


_CASE = Column("case", "", "name of the case", kind="key")
_TIME = Column("time", "s", "time since the start")
_STATE = (
    Column("dv_north", "m/s", "error of the velocity north", "north-up-east"),
    Column("dv_up", "m/s", "error of the velocity up", "north-up-east"),
    Column("dv_east", "m/s", "error of the velocity east", "north-up-east"),
    Column("d_height", "m", "error of the height"),
    Column("d_latitude", "rad", "error of the latitude"),
    Column("d_longitude", "rad", "error of the longitude"),
)


def _parameters(*rows: tuple[str, str, str]) -> tuple[Column, ...]:
    return tuple(Column(name, unit, description, kind="parameter") for name, unit, description in rows)


_SAMPLING = (("duration", "s", "duration"), ("interval", "s", "interval of the epochs or samples"))

_EQUATOR_CASES = _parameters(
    ("v_east", "m/s", "speed east over the Earth"),
    ("height", "m", "height"),
    *_SAMPLING,
    *((f"{c.name}_initial", c.unit, f"initial {c.description}") for c in _STATE),
    *(
        (f"misalignment_{i}{j}", "1", f"element {i}{j} of the initial misalignment; null: none")
        for i in "123"
        for j in "123"
    ),
    ("inertial_longitude", "rad", "inertial longitude at the start"),
)

_PRECESSION_CASES = _parameters(
    ("spin_rate", "rad/s", "spin rate nu"),
    ("precession_ratio", "1", "precession rate over spin rate, eps"),
    ("nutation", "rad", "nutation angle theta"),
    ("spin_rate_dual", "m/s^2", "dual part of the spin rate"),
    ("nutation_dual", "m/s", "dual part of the nutation angle"),
    *((f"q_{c}_initial", "1", f"initial attitude, {c}; null: that of the precession frame") for c in "wxyz"),
    *((f"w_inertial_{c}_initial", "m/s", f"initial apparent velocity, {c}, inertial axes") for c in "xyz"),
    *_SAMPLING,
)

_MODES = (
    Column("rho1", "1/s^2", "positive root of the quadratic in beta squared"),
    Column("rho2", "1/s^2", "negative root of the quadratic in beta squared"),
    Column("beta3", "1/s", "rate of the exponentials"),
    Column("omega", "1/s", "Schuler rate"),
    Column("mu", "1/s", "rate of the oscillation of the coupled channel"),
    Column("nu", "rad/m", "longitude component of the oscillating eigenvector"),
    Column("alpha3_growing", "1/s", "velocity component east of the exponential eigenvectors"),
    Column("alpha3_swinging", "1/s", "velocity component east of the oscillating eigenvectors"),
    Column("alpha6", "rad/m", "longitude component of the growing eigenvector"),
)


def _ratio(numerator: str, denominator: str) -> str:
    if numerator == denominator:
        return "1"
    reduced = {
        ("m/s", "m"): "1/s",
        ("m", "m/s"): "s",
        ("m/s", "rad"): "m/(s rad)",
        ("rad", "m/s"): "rad s/m",
    }
    return reduced.get((numerator, denominator), f"{numerator}/{denominator}")


_TRANSITION = tuple(
    Column(
        f"p{i}{j}",
        _ratio(_STATE[i - 1].unit, _STATE[j - 1].unit),
        f"{_STATE[i - 1].name} per unit of initial {_STATE[j - 1].name}",
    )
    for i, j in TRANSITION_ELEMENTS
)

_SAMPLE = Column("sample", "", "number of the sample; increments end at it", kind="index")
_INCREMENTS = (
    *(Column(f"angle_{c}", "rad", f"integral of the angular rate over the sample, {c}", "body") for c in "xyz"),
    *(Column(f"velocity_{c}", "m/s", f"integral of the specific force over the sample, {c}", "body") for c in "xyz"),
)
_ATTITUDE = (
    *(Column(f"q_{c}", "1", f"attitude quaternion, {c}", "body to inertial, scalar first") for c in "wxyz"),
    *(Column(f"w_inertial_{c}", "m/s", f"apparent velocity, {c}", "inertial") for c in "xyz"),
    *(Column(f"w_body_{c}", "m/s", f"apparent velocity, {c}", "body") for c in "xyz"),
)

DATASETS: Mapping[str, DatasetSchema] = {
    schema.name: schema
    for schema in (
        DatasetSchema(
            "equator_errors",
            "Errors of a strapdown INS along the equator: exact solutions of the linear error equations",
            "1.0.0",
            "Loginov M. Yu., Tkachenko M. G., Chelnokov Yu. N., Izv. Saratov Univ. Math. Mech. Inform. 13 (2013)",
            "10.18500/1816-9791-2013-13-1-1-69-84",
            {
                "rotation_rate, rad/s": ROTATION_RATE.text,
                "semi_major_axis, m": SEMI_MAJOR_AXIS.text,
                "equatorial_gravity, m/s^2": EQUATORIAL_GRAVITY.text,
                "earth": "sphere, gravity inverse to the square of the distance",
                "errors": "computed minus true",
            },
            {
                "cases": (_CASE, *_EQUATOR_CASES),
                "truth": (_CASE, _TIME, *_STATE),
                "modes": (_CASE, *_MODES),
                "transition": (_CASE, _TIME, *_TRANSITION),
            },
        ),
        DatasetSchema(
            "dual_precession",
            "Regular precession and its dual analogue: increments, attitude and apparent velocity, exact",
            "1.0.0",
            "Lebedev D. V., Panov A. P., Synthesis of high-accuracy algorithms for the apparent velocity, 1989",
            "",
            {
                "quaternions": "scalar first, Hamilton product, body to inertial",
                "increments": "integrals of angular rate and specific force in body axes over the sample",
            },
            {
                "cases": (_CASE, *_PRECESSION_CASES),
                "increments": (_CASE, _SAMPLE, _TIME, *_INCREMENTS),
                "truth": (_CASE, _SAMPLE, _TIME, *_ATTITUDE),
            },
        ),
    )
}


def without_generator(schema: pa.Schema) -> pa.Schema:
    """Return a schema without the name of the program that wrote it: any version writes the same data."""
    return schema.with_metadata({k: v for k, v in (schema.metadata or {}).items() if k != b"generator"})


def arrow_schema(dataset: str, table: str) -> pa.Schema:
    """Return the Arrow schema of a table, metadata included."""
    import pyarrow as pa

    about = DATASETS[dataset]
    metadata = {
        "dataset": about.name,
        "table": table,
        "version": about.version,
        "title": about.title,
        "source": about.source,
        "doi": about.doi,
        "digits": "32",
        "parameters": json.dumps(about.parameters),
        "license": "CC0-1.0",
        "generator": f"sinsbench {version('sinsbench')}",
    }
    fields = [field for column in about.tables[table] for field in column.fields()]
    return pa.schema(fields, metadata={key: value for key, value in metadata.items() if value})
