"""Scores of gyroscopic systems: each case is sampled at a ladder of intervals, each subject runs on every rung."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.convergence import Convergence, convergence
from sinsbench.scoring.errors import attitude_error_vectors
from sinsbench.scoring.gyroscopic_errors import (
    ARCSECOND,
    angle_errors,
    angles_between,
    inputs_of,
    rows_at,
    start_of,
    vertical_error,
)
from sinsbench.scoring.gyroscopic_responses import PERTURBATIONS, oscillation, response
from sinsbench.scoring.rows import Field
from sinsbench.scoring.running import RunError, run
from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Start
from sinsbench.subjects.gyroscopic.read_out import ANGLES
from sinsbench.subjects.loading import LoadedSubject
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.gyroscopic import GyroMotion, sampled

__all__ = ["FIELDS", "HOURS", "LADDER", "RESPONSE_FIELDS", "ladder", "score_gyroscopic", "score_responses"]

Array = NDArray[np.float64]

DATASET = "gyro_systems"
LADDER = (Fraction(8), Fraction(4), Fraction(2), Fraction(1))
"""Sampling intervals of a ladder, in units of the case's own."""
HOURS = {"1h": 3600.0, "2h": 7200.0, "4h": 14400.0}
"""Times at which errors are told, s."""

_COLUMNS = {"vertical": 3, "attitude": 4, "trihedron": 4, "speed": 0}
_UNIT = 1e-6  # how far a norm may be from 1: an error of the vertical by as much would be seen, a slip in units is not

_TIMES = (*((name, f"after {name[0]} h") for name in HOURS), ("max", "largest absolute value"))

FIELDS = (
    Field("subject", "", "name of the subject"),
    Field("dataset", "", "name of the dataset"),
    Field("case", "", "name of the case"),
    Field("interval", "s", "distance of the points, or sampling interval of the increments"),
    Field("samples_per_step", "", "such intervals in one step"),
    Field("takes", "", "points or increments"),
    Field("status", "", "what became of the subject, as in `sinsbench.scoring.rows.STATUSES`"),
    Field("message", "", "what went wrong, or which condition fails and when, in one line"),
    Field("ns_per_step", "ns", "least time over the repetitions, a step"),
    *(
        Field(f"vertical_error_{name}_m", "m", f"R times the angle to the true vertical, {text}")
        for name, text in _TIMES
    ),
    Field("vertical_error_max_arcsec", "arcsec", "largest angle to the true vertical"),
    Field("vertical_error_along_max_m", "m", "largest part of it along the absolute velocity"),
    Field("vertical_error_left_max_m", "m", "largest part of it to the left of the absolute velocity"),
    *(
        Field(f"{angle}_error_{name}_arcsec", "arcsec", f"error of the {angle.replace('_', ' ')}, {text}")
        for angle in ANGLES
        for name, text in _TIMES
    ),
    Field("speed_error_max", "m/s", "largest error of the absolute speed"),
    Field("attitude_error_max", "rad", "largest angle between computed and true attitude of the vehicle"),
    Field("observed_order", "", "slope of the differences between the verticals of neighbouring rungs"),
    Field("order_residual", "log2", "root mean square deviation from that slope, in powers of two"),
    Field("order_points", "", "differences that the order rests on"),
    Field("error_period", "s", "period of the error's part along the velocity, where the motion lasts 8000 s or more"),
)

RESPONSE_FIELDS = (
    *FIELDS[:4],
    Field("status", "", "as in the scores"),
    Field("message", "", "as in the scores"),
    Field("error", "", "what is wrong: a name of `sinsbench.scoring.gyroscopic_responses.PERTURBATIONS`"),
    Field("size", "", "by how much, in `unit`"),
    Field("unit", "", "unit of the size"),
    *(Field(f"response_{name}_m", "m", f"R times the angle between the verticals, {text}") for name, text in _TIMES),
)


def _row(fields: Sequence[Field], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row with every field, of plain values; NaN and infinity become None.

    Raises
    ------
    KeyError
        For a name that is not a field.
    """
    names = [field.name for field in fields]
    if unknown := set(values) - set(names):
        raise KeyError(f"no such fields: {', '.join(sorted(unknown))}")
    plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in values.items()}
    return {
        name: None if isinstance(plain.get(name), float) and not np.isfinite(plain[name]) else plain.get(name)
        for name in names
    }


def ladder(case: GyroCase, factors: Sequence[Fraction] = LADDER) -> tuple[GyroMotion, ...]:
    """Sample a case at a ladder of intervals, coarsest first.

    Parameters
    ----------
    case : GyroCase
    factors : sequence of Fraction
        Intervals in units of the case's; those that do not make whole steps of four are left out.

    Raises
    ------
    ValueError
        If no interval is left.
    """
    steps = {factor: Fraction(case.samples) / factor for factor in map(Fraction, factors)}
    used = sorted(
        (factor for factor, count in steps.items() if count.denominator == 1 and count % 4 == 0), reverse=True
    )
    if not used:
        raise ValueError(f"none of the intervals asked for divides {case.duration.text} s into whole steps of four")
    finest = sampled(case, used[-1])
    strides = [factor / used[-1] for factor in used]
    # Proofs of digits cost far more than the subjects do: what the finest rung holds is not proved again.
    return tuple(
        _thinned(finest, int(stride)) if stride.denominator == 1 else sampled(case, factor)
        for stride, factor in zip(strides, used, strict=True)
    )


def _thinned(motion: GyroMotion, stride: int) -> GyroMotion:
    """Return every `stride`-th epoch of a motion; increments are added up, which rounds them once more."""
    if stride == 1:
        return motion
    arrays: dict[str, Any] = {}
    for field in fields(motion):
        values = getattr(motion, field.name)
        if "increment" in field.name:
            arrays[field.name] = values.reshape(-1, stride, 3).sum(axis=1)
        elif isinstance(values, np.ndarray):
            arrays[field.name] = np.ascontiguousarray(values[::stride])
    return replace(motion, interval=motion.interval * stride, **arrays)


def _checked(result: Any, intervals: int) -> dict[str, Array]:
    """Return what a subject computed as arrays.

    Raises
    ------
    RunError
        If there is no vertical, a shape is wrong, a value is not finite, or a vertical is no unit vector.
    """
    given = result if isinstance(result, Mapping) else {"vertical": result}
    arrays: dict[str, Array] = {}
    for name, columns in _COLUMNS.items():
        if given.get(name) is None:
            continue
        try:
            array = np.asarray(given[name]).astype(np.float64, casting="same_kind")
        except Exception as error:  # a stranger's object may raise anything when it is asked for its numbers
            raise RunError("wrong shape", f"{name} is not an array of real numbers") from error
        count = len(array) - 1 if array.ndim else 0
        if array.shape[1:] != ((columns,) if columns else ()) or count < 1 or intervals % count:
            rows = f"(m+1, {columns})" if columns else "(m+1,)"
            raise RunError(
                "wrong shape", f"{name} has shape {array.shape}; {rows} is needed, where m divides {intervals}"
            )
        finite = np.isfinite(array.reshape(len(array), -1)).all(axis=1)
        if not finite.all():
            raise RunError("not finite", f"{name} holds NaN or infinity, first in row {int(np.argmin(finite))}")
        arrays[name] = array
    if "vertical" not in arrays:
        raise RunError("wrong shape", "the result holds no vertical")
    if len({len(array) for array in arrays.values()}) > 1:
        raise RunError("wrong shape", "the numbers of rows differ")
    if np.abs(np.linalg.norm(arrays["vertical"], axis=1) - 1).max() > _UNIT:
        raise RunError("error", "vertical holds vectors that are no unit vectors")
    return arrays


def _told(prefix: str, unit: str, time: Array, values: Array, scale: float) -> dict[str, float]:
    """Return values at the hours that the motion lasts to, and the largest one."""
    told = {}
    for name, when in HOURS.items():
        index = int(np.searchsorted(time, when))
        if index < len(time) and np.isclose(time[index], when, rtol=0, atol=1e-6):  # no error moves in a microsecond
            told[f"{prefix}_{name}_{unit}"] = float(values[index]) * scale
    return told | {f"{prefix}_max_{unit}": float(np.abs(values).max()) * scale}


def _measured(arrays: Mapping[str, Array], truth: GyroMotion, radius: float) -> dict[str, Any]:
    count = len(arrays["vertical"])
    time = rows_at(truth.time, count)
    error = vertical_error(arrays["vertical"], truth)
    told: dict[str, Any] = {
        **_told("vertical_error", "m", time, error.angle, radius),
        "vertical_error_max_arcsec": error.angle.max() / ARCSECOND,
        "vertical_error_along_max_m": np.abs(error.along).max() * radius,
        "vertical_error_left_max_m": np.abs(error.left).max() * radius,
    }
    if "speed" in arrays:
        told["speed_error_max"] = np.abs(arrays["speed"] - rows_at(truth.speed, count)).max()
    if "attitude" in arrays:
        true = (rows_at(truth.attitude, count), rows_at(truth.attitude_lo, count))
        told["attitude_error_max"] = np.linalg.norm(attitude_error_vectors(arrays["attitude"], *true), axis=1).max()
    if {"attitude", "trihedron"} <= set(arrays):
        try:
            for name, values in angle_errors(arrays, truth).items():
                told |= _told(f"{name}_error", "arcsec", time, values, 1 / ARCSECOND)
        except BrokenConditionError as broken:
            told["message"] = f"no angles: {broken}"
    if time[-1] - time[0] >= 8000 and np.isfinite(error.along).all():
        told["error_period"] = oscillation(time, error.along).period
    return told


def _order(verticals: Mapping[int, Array], intervals: Sequence[float]) -> Convergence:
    """Fit the order to the differences between neighbouring rungs, which hold no error that all rungs share."""
    differences, bounds = [], []
    for k in range(len(intervals) - 1):
        if k in verticals and k + 1 in verticals:
            common = int(np.gcd(len(verticals[k]) - 1, len(verticals[k + 1]) - 1)) + 1
            pair = (rows_at(verticals[i], common) for i in (k, k + 1))
            differences.append(float(angles_between(*pair).max()))
        else:
            differences.append(float("nan"))
        # The most that rounding can do: a unit roundoff for each of the three numbers of a vertical and step.
        bounds.append(3 * np.finfo(np.float64).eps * max(len(v) for v in verticals.values()) if verticals else 0.0)
    return convergence(intervals[:-1], differences, [0.0] * len(bounds), bounds)


def _start(case: GyroCase, truth: GyroMotion) -> Start:
    return start_of(truth, float(case.radius), float(case.gravity))


def score_gyroscopic(
    loaded: LoadedSubject, case: GyroCase, rungs: Sequence[GyroMotion], repetitions: int = 3, warm: bool = False
) -> list[dict[str, Any]]:
    """Score a subject on a case: one row a rung.

    Parameters
    ----------
    loaded : LoadedSubject
        A callable ``f(inputs, start)`` of `sinsbench.subjects.gyroscopic.contract.Inputs` and `Start`, which returns a
        mapping with ``vertical`` and any of ``attitude``, ``trihedron`` and ``speed``.
    case : GyroCase
    rungs : sequence of GyroMotion
        What `ladder` returned for the case.
    repetitions : int, default 3
        Timed calls at most; 0 for no times.
    warm : bool
        Whether the subject has run before, so that its first call compiles nothing and may be timed.

    Returns
    -------
    list of dict
        Rows with the fields `FIELDS`. A subject that fails on a rung, or declines it because a condition of its
        equations breaks, has a row there with status and message, which says what and when.
    """
    increments = loaded.subject.takes == "increments"
    measured: list[dict[str, Any]] = []
    verticals: dict[int, Array] = {}
    for k, truth in enumerate(rungs):
        intervals = len(truth.time) - 1
        try:
            timed = run(
                loaded.function,
                (inputs_of(truth, increments=increments), _start(case, truth)),
                repetitions,
                warm or bool(verticals),
            )
            arrays = _checked(timed.result, intervals)
            told = {"status": "ok", **_measured(arrays, truth, float(case.radius))}
        except RunError as error:
            measured.append({"status": error.status, "message": str(error)})
            continue
        steps = len(arrays["vertical"]) - 1
        verticals[k] = arrays["vertical"]
        told |= {"ns_per_step": timed.least / steps * 1e9, "samples_per_step": intervals // steps}
        measured.append(told)
    fit = _order(verticals, [truth.interval for truth in rungs])
    order = {"observed_order": fit.order, "order_residual": fit.residual, "order_points": fit.points}
    return [
        _row(FIELDS, _names(loaded, case, truth) | told | (order if k in verticals else {}))
        for k, (truth, told) in enumerate(zip(rungs, measured, strict=True))
    ]


def _names(loaded: LoadedSubject, case: GyroCase, truth: GyroMotion) -> dict[str, Any]:
    return {
        "subject": loaded.subject.name,
        "dataset": DATASET,
        "case": case.name,
        "interval": truth.interval,
        "samples_per_step": loaded.subject.samples_per_step,
        "takes": loaded.subject.takes or "points",
    }


def score_responses(loaded: LoadedSubject, case: GyroCase, truth: GyroMotion) -> list[dict[str, Any]]:
    """Tell how a subject answers to errors of the instruments and of the start: one row an error.

    Parameters
    ----------
    loaded : LoadedSubject
        As for `score_gyroscopic`.
    case : GyroCase
    truth : GyroMotion
        The case at one interval.

    Returns
    -------
    list of dict
        Rows with the fields `RESPONSE_FIELDS`: distances between the verticals with the error and without.
    """
    inputs, start = inputs_of(truth, increments=loaded.subject.takes == "increments"), _start(case, truth)
    names = {name: value for name, value in _names(loaded, case, truth).items() if name in {f.name for f in FIELDS[:4]}}
    rows = []
    for perturbation in PERTURBATIONS.values():
        told: dict[str, Any] = {
            **names,
            "error": perturbation.name,
            "size": perturbation.size,
            "unit": perturbation.unit,
        }
        try:
            angles = run(response, (loaded.function, inputs, start, perturbation), repetitions=0).result
        except RunError as error:
            told |= {"status": error.status, "message": str(error)}
        else:
            time = rows_at(truth.time, len(angles))
            told |= {"status": "ok", **_told("response", "m", time, angles, float(case.radius))}
        rows.append(_row(RESPONSE_FIELDS, told))
    return rows
