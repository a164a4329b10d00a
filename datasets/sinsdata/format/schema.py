"""What the tables of the datasets hold."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING

from sinsdata.format.columns import Column, DatasetSchema
from sinsdata.format.mast_columns import MAST_ANTENNA
from sinsdata.truth.formulas import TRANSITION_ELEMENTS
from sinsref.earth import (
    ECCENTRICITY_SQUARED,
    EQUATORIAL_GRAVITY,
    GRAVITY_FLATTENING,
    ROTATION_RATE,
    SEMI_MAJOR_AXIS,
)

if TYPE_CHECKING:
    import pyarrow as pa

#: Layout of folder and manifest; a reader refuses any other.
FORMAT = 2

_CASE = Column("case", "", "name of the case", kind="key")
_TIME = Column("time", "s", "time since the start")
_DIFFICULTY = (
    Column("stratum", "", "stratum of a tier that has strata; null otherwise", kind="key"),
    Column(
        "condition",
        "1",
        "relative change of the result per relative change of the parameters; null: not computed",
        kind="measure",
    ),
    Column(
        "digits_lost",
        "1",
        "decimal digits that the literal formula loses in binary64; null: it is not defined, or not computed",
        kind="measure",
    ),
)
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

_MOTION = Column("motion", "", "parallel, meridian, great_circle or climbing_turn", kind="key")
_TRAVEL_CASES = _parameters(
    ("latitude", "rad", "latitude at the start"),
    ("longitude", "rad", "longitude at the start"),
    ("height", "m", "height at the start"),
    ("speed", "m/s", "horizontal speed over the Earth; negative on a parallel for west, on a meridian for south"),
    ("heading", "rad", "heading at the start, clockwise from north; null: the motion has none"),
    ("climb_rate", "m/s", "upward velocity; null: the motion has none"),
    ("turn_rate", "rad/s", "rate of the heading; null: the motion has none"),
    *_SAMPLING,
    *((f"{c.name}_initial", c.unit, f"initial {c.description}") for c in _STATE),
)
_TRAVEL = (
    Column("v_north", "m/s", "velocity north over the Earth", "north-up-east"),
    Column("v_up", "m/s", "velocity up", "north-up-east"),
    Column("v_east", "m/s", "velocity east over the Earth", "north-up-east"),
    Column("height", "m", "height: a + height is the semi-major axis of the similar ellipsoid through the place"),
    Column("latitude", "rad", "geodetic latitude"),
    Column("longitude", "rad", "longitude"),
    Column("force_north", "m/s^2", "specific force north", "north-up-east"),
    Column("force_up", "m/s^2", "specific force up", "north-up-east"),
    Column("force_east", "m/s^2", "specific force east", "north-up-east"),
)


def _state(said: str) -> tuple[Column, ...]:
    return tuple(replace(column, description=said.format(column.description)) for column in _STATE)


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


def _vector(name: str, unit: str, description: str, frame: str = "body") -> tuple[Column, ...]:
    return tuple(Column(f"{name}_{c}", unit, f"{description}, {c}", frame) for c in "xyz")


_INCREMENTS = (
    *_vector("angle", "rad", "integral of the angular rate over the sample"),
    *_vector("velocity", "m/s", "integral of the specific force over the sample"),
)
#: The other input conventions of the same motion: table -> value columns.
_CONVENTIONS = {
    "rates": (
        *_vector("angular_rate", "rad/s", "angular rate at the instant"),
        *_vector("specific_force", "m/s^2", "specific force at the instant"),
    ),
    "mean_rates": (
        *_vector("angular_rate", "rad/s", "mean of the angular rate over the sample"),
        *_vector("specific_force", "m/s^2", "mean of the specific force over the sample"),
    ),
    "accumulated": (
        *_vector("angle", "rad", "integral of the angular rate since the start"),
        *_vector("velocity", "m/s", "integral of the specific force since the start"),
    ),
    "resolved": (
        *_vector(
            "velocity_start",
            "m/s",
            "integral of the specific force over the sample, resolved in the body axes of its start",
            "body at the start of the sample",
        ),
        *_vector(
            "velocity_end",
            "m/s",
            "integral of the specific force over the sample, resolved in the body axes of its end",
            "body at the end of the sample",
        ),
    ),
    "nonuniform": (Column("interval", "s", "length of the sample"), *_INCREMENTS),
    "dropped": _INCREMENTS,
    "quantised": tuple(
        replace(column, whole=True)
        for column in (
            *_vector("angle", "rad", "increment of the accumulated angle, rounded to whole quanta of 2^-20 rad"),
            *_vector("velocity", "m/s", "increment of the accumulated velocity, rounded to whole quanta of 2^-12 m/s"),
        )
    ),
}
_ATTITUDE = (
    *(Column(f"q_{c}", "1", f"attitude quaternion, {c}", "body to inertial, scalar first") for c in "wxyz"),
    *(Column(f"w_inertial_{c}", "m/s", f"apparent velocity, {c}", "inertial") for c in "xyz"),
    *(Column(f"w_body_{c}", "m/s", f"apparent velocity, {c}", "body") for c in "xyz"),
)

_GYRO_PROFILES = (
    ("latitude", "rad", "geocentric latitude, a function of the time t; its start unless the motion is a track"),
    ("longitude", "rad", "longitude on the rotating Earth, a function of t; its start unless the motion is a track"),
    ("speed", "m/s", "a function of t: east over the Earth on a parallel, absolute on a great circle; null: a track"),
    ("altitude", "m", "above the sphere, a function of t"),
    ("heading", "rad", "clockwise from north, a function of t"),
    ("pitch", "rad", "nose up, a function of t"),
    ("roll", "rad", "right side down, a function of t"),
)
_GYRO_CASES = (
    Column("motion", "", "track, parallel or great_circle", kind="key"),
    *(Column(name, unit, description, kind="key") for name, unit, description in _GYRO_PROFILES),
    *_parameters(
        (
            "course",
            "rad",
            "direction of the great circle at the start, clockwise from north; null: the motion has none",
        ),
        ("radius", "m", "radius of the sphere R"),
        ("gravity", "m/s^2", "attraction on the sphere g"),
        ("rotation_rate", "rad/s", "rate of the Earth u"),
        *_SAMPLING,
    ),
)
_VEHICLE, _INERTIAL = "vehicle: right, forward, up", "inertial X: X2 north, X1 and X3 in the equator"
_GYRO_SENSORS = (
    *_vector("angular_rate", "rad/s", "angular rate at the instant", _VEHICLE),
    *_vector("specific_force", "m/s^2", "specific force at the instant", _VEHICLE),
    *_vector("angle", "rad", "integral of the angular rate over the sample that ends here; 0 at time 0", _VEHICLE),
    *_vector("velocity", "m/s", "integral of the specific force over the sample that ends here; 0 at time 0", _VEHICLE),
)
_GYRO_TRUTH = (
    Column("latitude", "rad", "geocentric latitude"),
    Column("longitude_absolute", "rad", "longitude in the inertial axes X; goes on through whole turns"),
    Column("longitude", "rad", "longitude on the rotating Earth"),
    Column("radius", "m", "distance from the centre"),
    Column("radius_rate", "m/s", "its rate"),
    Column("speed", "m/s", "horizontal part of the absolute velocity, its magnitude"),
    *_vector("velocity", "m/s", "absolute velocity", _INERTIAL),
    *_vector("vertical", "1", "unit vertical", _INERTIAL),
    Column("heading", "rad", "heading, clockwise from north"),
    Column("pitch", "rad", "pitch, nose up"),
    Column("roll", "rad", "roll, right side down"),
    *(Column(f"q_{c}", "1", f"attitude quaternion, {c}", "vehicle to inertial X, scalar first") for c in "wxyz"),
    *(
        Column(f"trihedron_{c}", "1", f"quaternion of the Darboux trihedron of the absolute motion, {c}",
               "Darboux trihedron to inertial X, scalar first")
        for c in "wxyz"
    ),
)  # fmt: skip
_GYRO_REFERENCE = tuple(
    column
    for rule, said in (("paper", "from the paper's tilt -v/V"), ("rest", "from its own equilibrium at time 0"))
    for name, what in (
        ("gyro", "axis of the gyropendulum of constant H = m l sqrt(g R)"),
        ("mirror", "axis of the second gyropendulum of the bi-gyro"),
        ("bisector", "vertical of the bi-gyro"),
    )
    for column in _vector(f"{rule}_{name}", "1", f"{what}, {said}", _INERTIAL)
)

_LOGINOV_2013 = "Loginov M. Yu., Tkachenko M. G., Chelnokov Yu. N., Izv. Saratov Univ. Math. Mech. Inform. 13 (2013)"
_LOGINOV_2013_DOI = "10.18500/1816-9791-2013-13-1-1-69-84"

DATASETS: Mapping[str, DatasetSchema] = {
    schema.name: schema
    for schema in (
        DatasetSchema(
            "equator_errors",
            "Errors of a strapdown INS along the equator: exact solutions of the linear error equations",
            "1.1.0",
            _LOGINOV_2013,
            _LOGINOV_2013_DOI,
            {
                "rotation_rate, rad/s": ROTATION_RATE.text,
                "semi_major_axis, m": SEMI_MAJOR_AXIS.text,
                "equatorial_gravity, m/s^2": EQUATORIAL_GRAVITY.text,
                "earth": "sphere, gravity inverse to the square of the distance",
                "errors": "computed minus true",
            },
            {
                "cases": (_CASE, *_DIFFICULTY, *_EQUATOR_CASES),
                "truth": (_CASE, _TIME, *_STATE),
                "modes": (_CASE, *_MODES),
                "transition": (_CASE, _TIME, *_TRANSITION),
            },
        ),
        DatasetSchema(
            "dual_precession",
            "Regular precession and its dual analogue: increments, attitude and apparent velocity, exact",
            "1.1.0",
            "Lebedev D. V., Panov A. P., Synthesis of high-accuracy algorithms for the apparent velocity, 1989",
            "",
            {
                "quaternions": "scalar first, Hamilton product, body to inertial",
                "increments": "integrals of angular rate and specific force in body axes over the sample",
            },
            {
                "cases": (_CASE, *_DIFFICULTY, *_PRECESSION_CASES),
                "increments": (_CASE, _SAMPLE, _TIME, *_INCREMENTS),
                "truth": (_CASE, _SAMPLE, _TIME, *_ATTITUDE),
                **{name: (_CASE, _SAMPLE, _TIME, *columns) for name, columns in _CONVENTIONS.items()},
                "nonuniform_truth": (_CASE, _SAMPLE, _TIME, *_ATTITUDE),
            },
        ),
        DatasetSchema(
            "error_equations",
            "Errors of a strapdown INS along any motion: the linear error equations and the nonlinear ideal ones",
            "1.0.0",
            _LOGINOV_2013,
            _LOGINOV_2013_DOI,
            {
                "rotation_rate, rad/s": ROTATION_RATE.text,
                "semi_major_axis, m": SEMI_MAJOR_AXIS.text,
                "eccentricity_squared": ECCENTRICITY_SQUARED.text,
                "equatorial_gravity, m/s^2": EQUATORIAL_GRAVITY.text,
                "gravity_flattening": GRAVITY_FLATTENING.text,
                "errors": "computed minus true",
                "nonlinear": "exact sensors; the computer resolves the force at the position it has computed",
            },
            {
                "cases": (_CASE, *_DIFFICULTY, _MOTION, *_TRAVEL_CASES),
                "motion": (_CASE, _TIME, *_TRAVEL),
                "truth": (_CASE, _TIME, *_state("{}, by the linear error equations")),
                "nonlinear": (_CASE, _TIME, *_state("{}, of a computer that integrates the nonlinear equations")),
                "linearisation": (_CASE, _TIME, *_state("{}: nonlinear less linear")),
            },
        ),
        DatasetSchema(
            "gyro_systems",
            "Motion over a sphere in inertial space: sensors, attitude, and the gyropendulum and bi-gyro along it",
            "1.0.0",
            "Chelnokov Yu. N., Mechanics of Solids (Izv. AN SSSR, MTT) 1991, no. 4",
            "",
            {
                "quaternions": "scalar first, Hamilton product, to the inertial axes X",
                "attraction": "uniform over the sphere, inverse to the square of the distance from its centre",
                "gyropendulum": "constant H = m l sqrt(g R), no moments: kappa = 1/sqrt(g R)",
            },
            {
                "cases": (_CASE, _DIFFICULTY[0], *_GYRO_CASES),
                "sensors": (_CASE, _TIME, *_GYRO_SENSORS),
                "truth": (_CASE, _TIME, *_GYRO_TRUTH),
                "reference": (_CASE, _TIME, *_GYRO_REFERENCE),
            },
        ),
        MAST_ANTENNA,
    )
}


#: Entries of the metadata of a file that say who wrote it when, not what it holds.
_PROVENANCE = (b"generator", b"specification", b"certification")


def without_provenance(schema: pa.Schema) -> pa.Schema:
    """Return a schema without the traces of the run that wrote it: any run and version writes the same data."""
    return schema.with_metadata({k: v for k, v in (schema.metadata or {}).items() if k not in _PROVENANCE})


@cache
def _generator() -> str:
    return version("sinsbench")


@cache
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
        "digits": about.digits,
        "parameters": json.dumps(about.parameters),
        "license": "CC0-1.0",
        "generator": f"sinsbench {_generator()}",
    }
    fields = [field for column in about.tables[table] for field in column.fields()]
    return pa.schema(fields, metadata={key: value for key, value in metadata.items() if value})
