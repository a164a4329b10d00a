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
    law_of_gyropendulum,
    rows_at,
    start_of,
    vertical_error,
)
from sinsbench.scoring.gyroscopic_growth import oscillation
from sinsbench.scoring.rows import Field, plain_row
from sinsbench.scoring.running import RunError, run
from sinsbench.subjects.gyroscopic.contract import BrokenConditionError, Start
from sinsbench.subjects.gyroscopic.read_out import ANGLES
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import GYRO_SYSTEMS
from sinsdata.cases import CaseError
from sinsdata.cases.gyroscopic import GyroCase
from sinsdata.truth.gyroscopic import GyroMotion, sampled

__all__ = ["FIELDS", "HOURS", "LADDER", "TIMES", "at_hours", "checked", "error_history", "identity", "ladder",
           "period_of", "score_gyroscopic", "start"]  # fmt: skip

Array = NDArray[np.float64]

LADDER = (Fraction(8), Fraction(4), Fraction(2), Fraction(1))
"""Sampling intervals of a ladder, in units of the case's own."""
HOURS = {"1h": 3600.0, "2h": 7200.0, "4h": 14400.0}
"""Times at which errors are told, s."""

_COLUMNS = {"vertical": 3, "attitude": 4, "trihedron": 4, "speed": 0}
_UNIT = 1e-6  # how far a norm may be from 1: an error of the vertical by as much would be seen, a slip in units is not

TIMES = (*((name, f"after {name[0]} h") for name in HOURS), ("max", "largest absolute value"))
"""Ends of the names of fields that tell a value at these times, and what they say."""

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
        for name, text in TIMES
    ),
    Field("vertical_error_max_arcsec", "arcsec", "largest angle to the true vertical"),
    Field("vertical_error_along_max_m", "m", "largest part of it along the absolute velocity"),
    Field("vertical_error_left_max_m", "m", "largest part of it to the left of the absolute velocity"),
    *(
        Field(f"{angle}_error_{name}_arcsec", "arcsec", f"error of the {angle.replace('_', ' ')}, {text}")
        for angle in ANGLES
        for name, text in TIMES
    ),
    Field("speed_error_max", "m/s", "largest error of the absolute speed"),
    Field("attitude_error_max", "rad", "largest angle between computed and true attitude of the vehicle"),
    Field("observed_order", "", "slope of the differences between the verticals of neighbouring rungs"),
    Field("order_residual", "log2", "root mean square deviation from that slope, in powers of two"),
    Field("order_points", "", "differences that the order rests on"),
    Field("error_period", "s", "period of the part along the velocity, where the motion lasts 1.4 Schuler periods"),
    Field("error_period_residual", "", "what is left of that part beside the oscillation, relative to its amplitude"),
    Field("schuler_period", "s", "2 pi sqrt(R/g)"),
    Field("speed_ratio_max", "", "largest q = v/sqrt(g R) of the motion"),
    Field(
        "system_error_max",
        "rad",
        "largest angle to the true vertical once that is extrapolated to the interval 0 from this one and the next "
        "coarser: the error of the system; none where that of the integration hides it",
    ),
    Field(
        "law_error_max",
        "rad",
        "as system_error_max, to the axis of a gyropendulum by its law alpha = -v/sqrt(g R)",
    ),
)


def ladder(case: GyroCase, factors: Sequence[Fraction] = LADDER) -> tuple[GyroMotion, ...]:
    """Sample a case at a ladder of intervals, coarsest first.

    Parameters
    ----------
    case : GyroCase
    factors : sequence of Fraction
        Intervals in units of the case's; those that do not make whole steps of four are left out.

    Raises
    ------
    CaseError
        If no interval is left.
    """
    steps = {factor: Fraction(case.samples) / factor for factor in map(Fraction, factors)}
    used = sorted(
        (factor for factor, count in steps.items() if count.denominator == 1 and count % 4 == 0), reverse=True
    )
    if not used:
        why = f"none of the intervals of the ladder divides {case.duration.text} s into whole steps of four"
        raise CaseError("interval", case.interval, f"{why} (case {case.name})")
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


def checked(result: Any, intervals: int) -> dict[str, Array]:
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


def at_hours(prefix: str, unit: str, time: Array, values: Array, scale: float) -> dict[str, float]:
    """Return values at the hours that the motion lasts to, and the largest one."""
    told = {}
    for name, when in HOURS.items():
        index = int(np.searchsorted(time, when))
        if index < len(time) and np.isclose(time[index], when, rtol=0, atol=1e-6):  # no error moves in a microsecond
            told[f"{prefix}_{name}_{unit}"] = float(values[index]) * scale
    return told | {f"{prefix}_max_{unit}": float(np.abs(values).max()) * scale}


def period_of(case: GyroCase) -> float:
    """Return the Schuler period 2 pi sqrt(R/g) of a case, s."""
    return float(2 * np.pi * np.sqrt(float(case.radius) / float(case.gravity)))


def _measured(arrays: Mapping[str, Array], truth: GyroMotion, case: GyroCase) -> dict[str, Any]:
    radius, schuler_speed = float(case.radius), float(np.sqrt(float(case.radius) * float(case.gravity)))
    count = len(arrays["vertical"])
    time = rows_at(truth.time, count)
    error = vertical_error(arrays["vertical"], truth)
    told: dict[str, Any] = {
        **at_hours("vertical_error", "m", time, error.angle, radius),
        "vertical_error_max_arcsec": error.angle.max() / ARCSECOND,
        "vertical_error_along_max_m": np.abs(error.along).max() * radius,
        "vertical_error_left_max_m": np.abs(error.left).max() * radius,
        "schuler_period": period_of(case),
        "speed_ratio_max": truth.speed.max() / schuler_speed,
    }
    if "speed" in arrays:
        told["speed_error_max"] = np.abs(arrays["speed"] - rows_at(truth.speed, count)).max()
    if "attitude" in arrays:
        true = (rows_at(truth.attitude, count), rows_at(truth.attitude_lo, count))
        told["attitude_error_max"] = np.linalg.norm(attitude_error_vectors(arrays["attitude"], *true), axis=1).max()
    if {"attitude", "trihedron"} <= set(arrays):
        try:
            for name, values in angle_errors(arrays, truth).items():
                told |= at_hours(f"{name}_error", "arcsec", time, values, 1 / ARCSECOND)
        except BrokenConditionError as broken:
            told["message"] = f"no angles: {broken}"
    if np.isfinite(error.along).all():
        try:
            swing = oscillation(time, error.along, period_of(case))
        except ValueError:  # a short motion
            return told
        told |= {"error_period": swing.period, "error_period_residual": swing.residual}
    return told


def _system_errors(coarse: Array, fine: Array, truth: GyroMotion, order: float, case: GyroCase) -> dict[str, float]:
    """Return the errors of the system without those of the integration, which fall with a power of the interval.

    Parameters
    ----------
    coarse, fine : ndarray
        Verticals at twice the interval of the truth, and at that.
    truth : GyroMotion
    order : float
        The power.
    case : GyroCase
    """
    common = int(np.gcd(len(coarse) - 1, len(fine) - 1)) + 1
    coarse, fine = rows_at(coarse, common), rows_at(fine, common)
    step = (fine - coarse) / (2**order - 1)
    limit = fine + step
    limit /= np.linalg.norm(limit, axis=1, keepdims=True)
    law = law_of_gyropendulum(truth, common, np.sqrt(float(case.radius) * float(case.gravity)))
    found = {
        "system_error_max": float(vertical_error(limit, truth).angle.max()),
        "law_error_max": float(angles_between(limit, law).max()),
    }
    integrated = np.linalg.norm(step, axis=1).max() + _rounding_bound(fine)
    return {name: value for name, value in found.items() if value > integrated}


def _rounding_bound(vertical: Array) -> float:
    """Return the most that rounding can do: a unit roundoff for each of the three numbers of a vertical and step."""
    return float(3 * np.finfo(np.float64).eps * len(vertical))


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
        bounds.append(max(map(_rounding_bound, verticals.values()), default=0.0))
    return convergence(intervals[:-1], differences, [0.0] * len(bounds), bounds)


def start(case: GyroCase, truth: GyroMotion) -> Start:
    """Return the start of a case over its sphere."""
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
                (inputs_of(truth, increments=increments), start(case, truth)),
                repetitions,
                warm or bool(verticals),
            )
            arrays = checked(timed.result, intervals)
            told = {"status": "ok", **_measured(arrays, truth, case)}
        except RunError as error:
            measured.append({"status": error.status, "message": str(error)})
            continue
        steps = len(arrays["vertical"]) - 1
        verticals[k] = arrays["vertical"]
        told |= {"ns_per_step": timed.least / steps * 1e9, "samples_per_step": intervals // steps}
        measured.append(told)
    fit = _order(verticals, [truth.interval for truth in rungs])
    order = {"observed_order": fit.order, "order_residual": fit.residual, "order_points": fit.points}
    power = loaded.subject.order or fit.order
    for k in range(1, len(rungs)):
        if power and k in verticals and k - 1 in verticals and rungs[k - 1].interval == 2 * rungs[k].interval:
            measured[k] |= _system_errors(verticals[k - 1], verticals[k], rungs[k], power, case)
    return [
        plain_row(FIELDS, identity(loaded, case, truth) | told | (order if k in verticals else {}))
        for k, (truth, told) in enumerate(zip(rungs, measured, strict=True))
    ]


def error_history(loaded: LoadedSubject, case: GyroCase, truth: GyroMotion) -> dict[str, Array]:
    """Return the error of a subject's vertical over time, for a plot.

    Parameters
    ----------
    loaded, case
        As for `score_gyroscopic`.
    truth : GyroMotion
        The case at one interval.

    Returns
    -------
    dict of str to ndarray, shape (m + 1,)
        ``time``, s; ``angle``, ``along`` the absolute velocity and ``left`` of it, R times the angle, m. They swing
        with `period_of` the case.

    Raises
    ------
    RunError
        If the subject yields no usable result.
    """
    inputs = inputs_of(truth, increments=loaded.subject.takes == "increments")
    result = run(loaded.function, (inputs, start(case, truth)), repetitions=0).result
    vertical = checked(result, len(truth.time) - 1)["vertical"]
    error, radius = vertical_error(vertical, truth), float(case.radius)
    metres = {"angle": radius * error.angle, "along": radius * error.along, "left": radius * error.left}
    return {"time": rows_at(truth.time, len(vertical)), **metres}


def identity(loaded: LoadedSubject, case: GyroCase, truth: GyroMotion) -> dict[str, Any]:
    """Return the fields that say which subject ran on what."""
    return {
        "subject": loaded.subject.name,
        "dataset": GYRO_SYSTEMS,
        "case": case.name,
        "interval": truth.interval,
        "samples_per_step": loaded.subject.samples_per_step,
        "takes": loaded.subject.takes or "points",
    }
