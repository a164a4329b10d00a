"""What a program of a dataset is given and gives back, as tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sinsbench.elsewhere.files import Columns, check_finite
from sinsbench.elsewhere.mast import MastContract
from sinsbench.elsewhere.vectors import AXES, QUATERNION, assembled, complete, vector_columns
from sinsbench.scoring.formulas import COMPONENTS
from sinsbench.scoring.gyroscopic_errors import known_kind
from sinsbench.subjects.gyroscopic.contract import Inputs
from sinsbench.subjects.loading import SubjectError
from sinsbench.subjects.registry import DUAL_PRECESSION, GYRO_SYSTEMS, MAST_ANTENNA
from sinsdata.truth.conventions import TABLES, Convention, known_convention

__all__ = ["Arguments", "Contract", "GyroscopicContract", "IntegratorContract", "SolverContract", "contract_of"]

#: Positional arguments of a subject.
Arguments = tuple[Any, ...]

_VECTORS = {
    "attitude": tuple(f"q_{axis}" for axis in QUATERNION),
    "velocity_inertial": tuple(f"w_inertial_{axis}" for axis in AXES),
    "velocity_body": tuple(f"w_body_{axis}" for axis in AXES),
}
_GYROSCOPIC = {
    "vertical": tuple(f"vertical_{axis}" for axis in AXES),
    "attitude": _VECTORS["attitude"],
    "trihedron": tuple(f"trihedron_{axis}" for axis in QUATERNION),
    "speed": ("speed",),
}


class Contract(Protocol):
    """Tables in place of arguments and results.

    An implementation knows one dataset.
    """

    @property
    def outputs(self) -> tuple[str, ...]:
        """Columns of numbers that a result may have."""

    def table(self, arguments: Arguments, keywords: Mapping[str, Any]) -> Columns:
        """Return what a subject is called with as one table."""

    @property
    def numbered(self) -> bool:
        """Whether a column ``sample`` counts the epochs of a result."""

    def rows(self, arguments: Arguments) -> int:
        """Return how many rows of input a subject is called with."""

    def epochs(self, arguments: Arguments) -> NDArray[Any]:
        """Return the times at which a row of a result may stand, s."""

    def result(self, path: Path, columns: Columns, rows: NDArray[Any] | None = None) -> Any:
        """Return what a callable would have returned; raise `OutcomeError` for a table that is no result.

        `rows` are the numbers that the rows have in the file, if it holds more.
        """

    def shortest(self, arguments: Arguments, rows: int) -> tuple[Arguments, float]:
        """Return the arguments of the shortest run, and the part of a whole run that it leaves out.

        `rows` is the number of rows of the result of the whole run. Without a shorter run the part is 0.
        """


@dataclass(frozen=True)
class IntegratorContract:
    """Tables of an integrator.

    Parameters
    ----------
    convention : Convention
        What it takes.
    """

    convention: Convention

    @property
    def outputs(self) -> tuple[str, ...]:
        """Columns of attitude and velocities."""
        return tuple(name for names in _VECTORS.values() for name in names)

    def table(self, arguments: Arguments, keywords: Mapping[str, Any]) -> Columns:
        """Return one row for each row of input; the initial state stands in every row."""
        first, second, third, attitude0, velocity0 = arguments
        rows = len(first)
        if self.convention.times:
            sample, time, interval = np.arange(1, rows + 1), third[1:], np.diff(third)
        else:
            sample = np.arange(rows) + 1 - self._with_start
            time, interval = sample * third, np.full(rows, third)
        initial = np.tile(np.concatenate([attitude0, velocity0]), (rows, 1))
        return {
            "sample": sample,
            "time": time,
            "interval": interval,
            **vector_columns(self.convention.first[1], first),
            **vector_columns(self.convention.second[1], second),
            **vector_columns("attitude0", initial[:, :4], QUATERNION),
            **vector_columns("velocity0", initial[:, 4:]),
        }

    @property
    def numbered(self) -> bool:
        """Whether every epoch counts: samples that never arrived have numbers too."""
        return not self.convention.times

    def rows(self, arguments: Arguments) -> int:
        """Return the number of samples, or of instants."""
        return len(arguments[0])

    @property
    def _with_start(self) -> int:
        """Number of input rows that end no sample."""
        return 1 - TABLES[self.convention.first[0]].first_sample

    def epochs(self, arguments: Arguments) -> NDArray[Any]:
        """Return the ends of the samples, and the start."""
        first, _, third, *_ = arguments
        times: NDArray[Any] = third if self.convention.times else np.arange(len(first) - self._with_start + 1) * third
        return times

    def result(self, path: Path, columns: Columns, rows: NDArray[Any] | None = None) -> dict[str, NDArray[Any]]:
        """Return the vectors of which the table has a component."""
        return assembled(path, columns, rows, _VECTORS)

    def shortest(self, arguments: Arguments, rows: int) -> tuple[Arguments, float]:
        """Return the arguments of one step."""
        first, second, third, *initial = arguments
        steps = max(rows - 1, 1)
        samples = (len(first) - self._with_start) // steps
        kept = samples + self._with_start
        times = third[: samples + 1] if self.convention.times else third
        return (first[:kept], second[:kept], times, *initial), 1 - 1 / steps


@dataclass(frozen=True)
class SolverContract:
    """Tables of a solver of the error equations on the equator."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Columns of the six errors."""
        return COMPONENTS

    def table(self, arguments: Arguments, keywords: Mapping[str, Any]) -> Columns:
        """Return one row for each time; everything else stands in every row."""
        time, *rest = arguments
        constants = dict(zip(("v_east", "height"), rest[:2], strict=True))
        constants |= {f"{name}0": value for name, value in zip(COMPONENTS, rest[2], strict=True)}
        if "misalignment" in keywords:
            matrix = keywords["misalignment"]
            constants |= {f"misalignment_{i + 1}{j + 1}": matrix[i, j] for i in range(3) for j in range(3)}
            constants["inertial_longitude"] = keywords["inertial_longitude"]
        return {"time": time, **{name: np.full(len(time), float(value)) for name, value in constants.items()}}

    numbered = False

    def rows(self, arguments: Arguments) -> int:
        """Return the number of times."""
        return len(arguments[0])

    def epochs(self, arguments: Arguments) -> NDArray[Any]:
        """Return the times."""
        times: NDArray[Any] = arguments[0]
        return times

    def result(self, path: Path, columns: Columns, rows: NDArray[Any] | None = None) -> NDArray[Any]:
        """Return the errors, all six of them."""
        complete(path, columns, COMPONENTS)
        check_finite(path, columns, COMPONENTS, rows)
        return np.column_stack([columns[name] for name in COMPONENTS])

    def shortest(self, arguments: Arguments, rows: int) -> tuple[Arguments, float]:
        """Return the arguments of one row."""
        return (arguments[0][:1], *arguments[1:]), 1 - 1 / max(rows, 1)


@dataclass(frozen=True)
class GyroscopicContract:
    """Tables of a gyroscopic system: those of the dataset, and the start in every row.

    Parameters
    ----------
    kind : {"points", "increments"}
    """

    kind: str

    @property
    def outputs(self) -> tuple[str, ...]:
        """Columns of vertical, attitude, trihedron and speed."""
        return tuple(name for names in _GYROSCOPIC.values() for name in names)

    def table(self, arguments: Arguments, keywords: Mapping[str, Any]) -> Columns:
        """Return one row for each time, the start among them, which ends no sample and has increments of 0."""
        inputs, start = arguments
        count = len(inputs.time)
        rate, force = (np.vstack([np.zeros((count - len(x), 3)), x]) for x in (inputs.rate, inputs.specific_force))
        names = ("angular_rate", "specific_force") if self.kind == "points" else ("angle", "velocity")
        initial = np.tile(np.concatenate([start.attitude, start.vertical, start.velocity]), (count, 1))
        constants = {
            "turn_rate0": start.turn_rate or 0.0,
            "sphere_radius": start.radius,
            "sphere_gravity": start.gravity,
        }
        return {
            "sample": np.arange(count),
            "time": inputs.time,
            **vector_columns(names[0], rate),
            **vector_columns(names[1], force),
            **inputs.aids,
            **vector_columns("attitude0", initial[:, :4], QUATERNION),
            **vector_columns("vertical0", initial[:, 4:7]),
            **vector_columns("velocity0", initial[:, 7:]),
            **{name: np.full(count, value) for name, value in constants.items()},
        }

    numbered = True

    def rows(self, arguments: Arguments) -> int:
        """Return the number of times."""
        return len(arguments[0].time)

    def epochs(self, arguments: Arguments) -> NDArray[Any]:
        """Return the times."""
        times: NDArray[Any] = arguments[0].time
        return times

    def result(self, path: Path, columns: Columns, rows: NDArray[Any] | None = None) -> dict[str, NDArray[Any]]:
        """Return the vectors of which the table has a component."""
        return assembled(path, columns, rows, _GYROSCOPIC)

    def shortest(self, arguments: Arguments, rows: int) -> tuple[Arguments, float]:
        """Return the arguments of one step."""
        inputs: Inputs = arguments[0]
        steps = max(rows - 1, 1)
        end = (len(inputs.time) - 1) // steps + 1
        kept = end - (self.kind == "increments")
        step = replace(
            inputs,
            time=inputs.time[:end],
            rate=inputs.rate[:kept],
            specific_force=inputs.specific_force[:kept],
            aids={name: values[:end] for name, values in inputs.aids.items()},
        )
        return (step, *arguments[1:]), 1 - 1 / steps


def contract_of(dataset: str, takes: str | None) -> Contract:
    """Return the contract of a dataset, for integrators or gyroscopic systems that take a convention.

    Parameters
    ----------
    dataset : str
    takes : str or None
        By default increments or, on `gyro_systems`, points.

    Raises
    ------
    SubjectError
        If there is no such convention.
    """
    try:
        if dataset == GYRO_SYSTEMS:
            return GyroscopicContract(known_kind(takes or "points"))
        if dataset == MAST_ANTENNA:
            return MastContract()
        if dataset != DUAL_PRECESSION:
            return SolverContract()
        return IntegratorContract(known_convention(takes or "increments"))
    except ValueError as error:
        raise SubjectError(str(error)) from None
