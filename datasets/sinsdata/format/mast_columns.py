"""What the tables of `mast_antenna` hold.

Values are binary64 with a stated accuracy: beside noise of 1e-8 rad/s and more a second binary64 would say nothing.
"""

from __future__ import annotations

from sinsdata.format.columns import Column, DatasetSchema

#: Numbers of the satellites.
SATELLITES = "1234"
#: Instants of a step.
NODES = {"start": "at the start of the step", "middle": "in its middle", "end": "at its end"}
#: Accuracy of attitudes, of angular rates, rad/s, and of specific forces, m/s^2; of what is normally distributed,
#: relative.
ATTITUDE_ACCURACY, _RATE, _FORCE, _NORMAL = 3e-15, 5e-15, 1e-13, 1e-14
_J1, _J2, _Q, _G, _S = (
    "J1: vehicle", "J2: antenna", "Q: mast, z along it", "G: Earth-fixed, y along the axis", "S: east, north, up",
)  # fmt: skip

_CASE = Column("case", "", "name of the case", kind="key")
_TIME = Column("time", "s", "time since the start")
_STRATUM = Column("stratum", "", "stratum of a tier that has strata; null otherwise", kind="key")
_SAMPLE = Column("sample", "", "number of the step; it ends at the time of the row", kind="index")


def _vector(name: str, unit: str, said: str, frame: str, within: float, relative: bool = False) -> tuple[Column, ...]:
    return tuple(Column(f"{name}_{c}", unit, f"{said}, {c}", frame, "value", False, within, relative) for c in "xyz")


def _quaternion(name: str, said: str, frame: str) -> tuple[Column, ...]:
    return tuple(Column(f"{name}_{c}", "1", f"{said}, {c}", frame, "value", False, ATTITUDE_ACCURACY) for c in "wxyz")


#: Columns of the readings: name, unit, description, axes, accuracy.
_READINGS = (
    ("angular_rate1", "rad/s", "absolute angular rate of the vehicle", _J1, _RATE),
    ("specific_force1", "m/s^2", "specific force of the vehicle", _J1, _FORCE),
    ("angular_rate2", "rad/s", "absolute angular rate of the antenna, limit from inside the step", _J2, _RATE),
    ("specific_force2", "m/s^2", "specific force of the antenna", _J2, _FORCE),
)
_SENSORS = (
    *(
        column
        for node, when in NODES.items()
        for name, unit, said, frame, within in _READINGS
        for column in _vector(f"{node}_{name}", unit, f"{said}, without noise, {when}", frame, within)
    ),
    *(
        column
        for name, unit, said, frame, _ in _READINGS
        for column in _vector(
            f"noise_{name}",
            unit,
            f"what readings of {name} differ by in all the step, noise and fault",
            frame,
            _NORMAL,
            True,
        )
    ),
)
_SATELLITES = tuple(
    column
    for n in SATELLITES
    for column in (
        *_vector(f"satellite{n}", "m", f"position of satellite {n}", _G, 3e-8),
        *_vector(f"satellite{n}_velocity", "m/s", f"Earth-relative velocity of satellite {n}", _G, 5e-12),
        Column(f"range_rate{n}", "m/s", f"range rate of satellite {n}, without noise", "", "value", False, 1e-11),
        Column(f"range{n}", "m", f"range of satellite {n}, without noise", "", "value", False, 5e-8),
    )
)
_MEASUREMENTS = tuple(
    column
    for n in SATELLITES
    for column in (
        Column(f"range_rate{n}", "m/s", f"measured range rate of satellite {n}", "", "value", False, 1e-11),
        Column(f"range{n}", "m", f"measured range of satellite {n}", "", "value", False, 5e-8),
    )
)
_TRUTH = (
    *_quaternion("mu", "attitude of the vehicle", "I to J1, scalar first"),
    *_quaternion("lambda", "attitude of the mast on the vehicle", "J1 to Q, scalar first"),
    *_quaternion("eta", "attitude of the antenna on the mast", "Q to J2, scalar first"),
    *_quaternion("nu", "attitude of the antenna on the vehicle", "J1 to J2, scalar first"),
    Column("longitude", "rad", "longitude", "", "value", False, 5e-16),
    Column("latitude", "rad", "spherical latitude", "", "value", False, 5e-16),
    Column("height", "m", "height above the sphere", "", "value", False, 1e-12),
    *(
        Column(f"v_{name}", "m/s", f"velocity {name} over the Earth", _S, "value", False, 1e-13)
        for name in ("east", "north", "up")
    ),
    *(
        Column(f"mast_absolute_rate_{c}", "rad/s", f"absolute angular rate of the mast, {c}", _Q, "value", False, _RATE)
        for c in "xy"
    ),
)


def _keys(*rows: tuple[str, str, str]) -> tuple[Column, ...]:
    return tuple(Column(name, unit, description, kind="key") for name, unit, description in rows)


def _parameters(*rows: tuple[str, str, str]) -> tuple[Column, ...]:
    return tuple(Column(name, unit, description, kind="parameter") for name, unit, description in rows)


_ROTATIONS = {
    "vehicle_rotation": "from S to J1",
    "mast_rotation": "from J1 to Q",
    "antenna_rotation": "from Q to J2",
}
_CASES = (
    *_keys(
        ("run", "", "case whose sensors, satellites and truth this one shares; null: its own"),
        ("velocity_east", "m/s", "over the Earth, a function of the time t"),
        ("velocity_north", "m/s", "over the Earth, a function of t"),
        ("velocity_up", "m/s", "a function of t"),
        *((f"angular_rate_{c}", "rad/s", f"absolute rate of the vehicle in J1, {c}, a function of t") for c in "xyz"),
        *((f"mast_rate_{c}", "rad/s", f"rate of the mast on the vehicle in Q, {c}, a function of t") for c in "xy"),
        ("fault", "", "reading that has a bias, axis x or satellite 1; null: none"),
    ),
    *_parameters(
        ("duration", "s", "duration"),
        ("interval", "s", "step: interval of the readings"),
        ("longitude", "rad", "longitude at the start"),
        ("latitude", "rad", "spherical latitude at the start"),
        ("height", "m", "height at the start"),
        ("mast_length", "m", "length of the mast R"),
        *((f"{name}_{c}", "rad", f"rotation vector {said} at the start, {c}") for name, said in _ROTATIONS.items()
          for c in "xyz"),
        ("antenna_rate_sd", "rad/s", "standard deviation of the rate of the antenna on the mast, of a sample"),
        ("gyro_sd", "rad/s", "standard deviation of gyro noise, of a sample"),
        ("accelerometer_sd", "m/s^2", "standard deviation of accelerometer noise, of a sample"),
        ("range_rate_sd", "m/s", "standard deviation of range rates, of a measurement"),
        ("range_sd", "m", "standard deviation of ranges, of a measurement"),
        *((f"{name}_{n}", "rad", said.format(n)) for n in SATELLITES for name, said in (
            ("node", "longitude of the ascending node of satellite {} at the start"),
            ("argument", "argument of latitude of satellite {} at the start"),
        )),
        ("satellites_used", "1", "number of satellites used: the first ones"),
        ("seed", "1", "seed of the samples"),
        ("error_seed", "1", "seed of the errors of the initial estimate"),
        ("attitude_error_sd", "rad", "standard deviation of the initial errors of mu, nu, lambda, each component"),
        ("position_error_sd", "m", "standard deviation of the initial errors of the position, each component"),
        ("velocity_error_sd", "m/s", "standard deviation of the initial errors of the velocity, each component"),
        ("mast_rate_error_sd", "rad/s", "standard deviation of the initial errors of the mast's rate, each component"),
        ("fault_time", "s", "start of the fault"),
        ("fault_size", "", "size of the fault, in units of the reading"),
        ("radius", "m", "radius of the sphere RE"),
        ("gravity", "m/s^2", "attraction g"),
        ("rotation_rate", "rad/s", "rate of the Earth Om"),
    ),
)  # fmt: skip

MAST_ANTENNA = DatasetSchema(
    "mast_antenna",
    "Antenna on a mast on a moving vehicle: two triads of sensors, satellites, and the true attitudes and position",
    "1.0.0",
    "Sokolov S. V., Pogorelov V. A., Reshetnikova I. V., Nonlinear stochastic estimation of the navigation parameters"
    " of the antenna of a mobile radio engineering complex by inertial-satellite measurements, 2024",
    "",
    {
        "quaternions": "scalar first, Hamilton product; q takes components to the rotated frame: v' = conj(q) v q",
        "attraction": "uniform, the same at all heights; the change over the mast is neglected",
        "noise": "white, held over a step: SplitMix64 by counter, Box-Muller; reading = value + noise",
        "satellites": "circular orbits, a = 26560 km, inclination 55 degrees, GM = 3.986004418e14 m^3/s^2",
    },
    {
        "cases": (_CASE, _STRATUM, *_CASES),
        "sensors": (_CASE, _SAMPLE, _TIME, *_SENSORS),
        "satellites": (_CASE, _TIME, *_SATELLITES),
        "measurements": (_CASE, _TIME, *_MEASUREMENTS),
        "truth": (_CASE, _TIME, *_TRUTH),
    },
    "15",
    "binary64 of stated accuracy, each column confirmed by Taylor series in mpmath; times nearest binary64, proved",
)
