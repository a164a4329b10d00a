"""What a program that estimates the antenna on a mast is given and gives back, as tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.elsewhere.files import Columns
from sinsbench.elsewhere.vectors import AXES, QUATERNION, complete, stacked, vector_columns
from sinsbench.scoring.mast import first_steps
from sinsbench.subjects.mast.contract import ERRORS, MastInputs, MastStart

__all__ = ["COVARIANCE", "ESTIMATES", "NODES", "MastContract"]

NODES = ("start", "middle", "end")
"""Instants of a step, before the names of what is read then."""
_READINGS = {
    "angular_rate1": "rate1",
    "specific_force1": "specific_force1",
    "angular_rate2": "rate2",
    "specific_force2": "specific_force2",
}
_VELOCITY = ("v_east", "v_north", "v_up")
_MAST_RATE = tuple(f"mast_absolute_rate_{axis}" for axis in "xy")

ESTIMATES: Mapping[str, tuple[str, ...]] = {
    **{name: tuple(f"{name}_{axis}" for axis in QUATERNION) for name in ("mu", "lambda", "eta")},
    **{name: (name,) for name in ("longitude", "latitude", "height")},
    "velocity": _VELOCITY,
    "mast_rate": _MAST_RATE,
}
"""What a result must hold, with its columns: names of the dataset's table ``truth``."""
_ERROR_NAMES = (
    *(f"mu_{axis}" for axis in AXES),
    *("longitude", "latitude", *_VELOCITY, "height"),
    *(f"{name}_{axis}" for name in ("nu", "lambda") for axis in AXES),
    *_MAST_RATE,
)
_UPPER = np.triu_indices(ERRORS)
COVARIANCE = tuple(f"covariance_{i + 1}_{j + 1}" for i, j in zip(*_UPPER, strict=True))
"""Columns of the upper triangle of a covariance, row by row."""
_NIS = ("nis", "nis_freedom")


def _start_columns(start: MastStart, inputs: MastInputs) -> dict[str, float]:
    """Return what does not change from row to row: initial estimate, its deviations, those of the noise, constants."""
    given = {name: np.atleast_1d(getattr(start, "lambda_" if name == "lambda" else name)) for name in ESTIMATES}
    noise, constants = inputs.noise, inputs.constants
    return {
        **{
            _initial(name): float(value)
            for part, names in ESTIMATES.items()
            for name, value in zip(names, given[part], strict=True)
        },
        **{f"sd0_{name}": float(value) for name, value in zip(_ERROR_NAMES, start.deviations, strict=True)},
        # One name for both triads: a case has one figure for its gyros and one for its accelerometers.
        "gyro_sd": noise.rate1,
        "accelerometer_sd": noise.specific_force1,
        "antenna_rate_sd": noise.antenna_rate,
        "range_rate_sd": noise.range_rate,
        "range_sd": noise.range,
        "mast_length": constants.mast_length,
        "radius": constants.earth_radius,
        "rotation_rate": constants.earth_rate,
        "gravity": constants.gravitation,
    }


def _initial(name: str) -> str:
    """Return the name of a component at the start: ``mu_w`` is ``mu0_w`` there, ``height`` is ``height0``."""
    stem, _, axis = name.rpartition("_")
    return f"{stem}0_{axis}" if axis in QUATERNION else f"{name}0"


@dataclass(frozen=True)
class MastContract:
    """Tables of an estimator: a row a step, with all that is read in it, and the start in every row."""

    numbered = False

    @property
    def outputs(self) -> tuple[str, ...]:
        """Columns of estimates, of the normalised innovations squared and of a covariance."""
        return (*(name for names in ESTIMATES.values() for name in names), *_NIS, *COVARIANCE)

    def table(self, arguments: tuple[Any, ...], keywords: Mapping[str, Any]) -> Columns:
        """Return one row for each step; it ends at the time of the row, as in the dataset's table ``sensors``."""
        inputs: MastInputs = arguments[0]
        steps = len(inputs.time) - 1
        columns: Columns = {
            "sample": np.arange(1, steps + 1),
            "time": inputs.time[1:],
            "interval": np.full(steps, inputs.step),
        }
        for k, node in enumerate(NODES):
            for stem, name in _READINGS.items():
                columns |= vector_columns(f"{node}_{stem}", getattr(inputs, name)[:, k])
            for n in range(inputs.range.shape[2]):
                satellite = f"{node}_satellite{n + 1}"
                half_grid = slice(k, k + 2 * steps, 2)
                columns |= vector_columns(satellite, inputs.satellite_position[half_grid, n])
                columns |= vector_columns(f"{satellite}_velocity", inputs.satellite_velocity[half_grid, n])
                columns[f"{node}_range_rate{n + 1}"] = inputs.range_rate[:, k, n]
                columns[f"{node}_range{n + 1}"] = inputs.range[:, k, n]
        constants = _start_columns(arguments[1], inputs)
        return columns | {name: np.full(steps, value) for name, value in constants.items()}

    def rows(self, arguments: tuple[Any, ...]) -> int:
        """Return the number of steps."""
        return len(arguments[0].time) - 1

    def epochs(self, arguments: tuple[Any, ...]) -> NDArray[Any]:
        """Return the ends of the steps, and the start."""
        times: NDArray[Any] = arguments[0].time
        return times

    def result(self, path: Path, columns: Columns, rows: NDArray[Any] | None = None) -> dict[str, NDArray[Any]]:
        """Return the arrays that a callable returns; NaN among them are left to the score, which knows the second."""
        complete(path, columns, ("time", *(name for names in ESTIMATES.values() for name in names)))
        made = {"time": columns["time"], **{name: stacked(columns, names) for name, names in ESTIMATES.items()}}
        if any(name in columns for name in _NIS):
            complete(path, columns, _NIS)
            made |= {name: columns[name] for name in _NIS}
        if any(name in columns for name in COVARIANCE):
            complete(path, columns, COVARIANCE)
            covariance = np.empty((len(made["time"]), ERRORS, ERRORS))
            i, j = _UPPER
            covariance[:, i, j] = covariance[:, j, i] = stacked(columns, COVARIANCE)
            made["covariance"] = covariance
        return made

    def shortest(self, arguments: tuple[Any, ...], rows: int) -> tuple[tuple[Any, ...], float]:
        """Return the arguments of the steps up to the second row, so that the shortest result has two."""
        inputs: MastInputs = arguments[0]
        steps = len(inputs.time) - 1
        count = max(1, steps // max(rows - 1, 1))
        return (first_steps(inputs, count), *arguments[1:]), 1 - count / steps
