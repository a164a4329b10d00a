"""Scores of integrators: each case is sampled at a ladder of intervals, each subject runs on every rung.

Truth is compared at checkpoints common to all rungs, so that errors of different intervals are taken at the
same instants.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, reduce
from math import lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.asymptotics import predicted_error
from sinsbench.scoring.convergence import Convergence, convergence
from sinsbench.scoring.errors import attitude_error_vectors, difference
from sinsbench.scoring.inputs import InputErrors, input_errors
from sinsbench.scoring.rows import merged
from sinsbench.scoring.running import IntegratorOutput, RunError, checked_integrator_output, run
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import DUAL_PRECESSION, Subject
from sinsbench.subjects.rotation_vector_methods import METHODS, RotationVectorMethod
from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.sampling import SampledMotion, sample
from sinsref.exact import ExactNumber

__all__ = ["LADDER", "Rung", "ladder", "score_integrator"]

Array = NDArray[np.float64]

LADDER = tuple(Fraction(2) / 2**k for k in range(6))
"""Sampling intervals of a ladder, in units of the case's own."""

_MOST_SAMPLES = 400_000  # on a rung: its arrays grow with the samples, and so does what computes them
_USUAL_SAMPLES_PER_STEP = 4
_DEG_PER_H = np.degrees(1.0) * 3600
_AVERAGED_AWAY = 0.01  # accumulation relative to that of the bias that accumulates most
_MICRO_G = 9.80665e-6  # m/s^2 in a millionth of standard gravity


@dataclass(frozen=True)
class Rung:
    """A case sampled at one interval, and what the rounding of these samples does."""

    motion: SampledMotion
    inputs: InputErrors


def ladder(
    case: DualPrecessionCase, factors: Sequence[Fraction] = LADDER, convention: str = "increments"
) -> tuple[Rung, ...]:
    """Sample a case at a ladder of intervals, coarsest first.

    Parameters
    ----------
    case : DualPrecessionCase
    factors : sequence of Fraction
        Intervals in units of the case's. Left out are those that do not divide the duration into whole samples and
        those that divide it into more than 400,000, which would fill the memory; never the case's own interval, 1.
    convention : str, default "increments"
        What the samples hold: a name of `sinsdata.truth.conventions.CONVENTIONS`.

    Returns
    -------
    tuple of Rung
        Checkpoints are as far apart as a step of four samples at the coarsest interval, where that divides
        the duration.

    Raises
    ------
    ValueError
        If no interval is left, or there is no such convention.
    """
    used = sorted((x for x in map(Fraction, factors) if (case.samples / x).denominator == 1), reverse=True)
    if not used:
        raise ValueError(f"none of the intervals asked for divides {case.duration.text} s into whole samples")
    used = [x for x in used if x == 1 or case.samples / x <= _MOST_SAMPLES]
    if not used:
        raise ValueError(
            f"the intervals asked for divide {case.duration.text} s into more than {_MOST_SAMPLES} samples"
        )
    common = used[0]
    for factor in used:  # the least common multiple of fractions; it divides the duration as each of them does
        numerators = common.numerator * factor.denominator, factor.numerator * common.denominator
        common = Fraction(lcm(*numerators), common.denominator * factor.denominator)
    step = common * _USUAL_SAMPLES_PER_STEP
    spacing = step if (case.samples / step).denominator == 1 else common
    distance = ExactNumber(f"({case.interval.text})*{spacing.numerator}/{spacing.denominator}")
    motions = (sample(case, factor, distance, convention) for factor in used)
    return tuple(Rung(motion, input_errors(motion)) for motion in motions)


@dataclass(frozen=True)
class _Run:
    """Errors of one run at the checkpoints it reaches; None for what the subject does not compute."""

    output: IntegratorOutput
    time: Array
    reached: NDArray[np.intp]  # checkpoints, by number
    attitude: Array | None
    velocity: Array | None
    velocity_body: Array | None
    ns_per_sample: float
    version: str

    def at(self, checkpoints: NDArray[np.intp]) -> "_Run":
        """Return the errors at some of the checkpoints."""
        kept = np.isin(self.reached, checkpoints)
        attitude, velocity, velocity_body = (
            None if x is None else x[kept] for x in (self.attitude, self.velocity, self.velocity_body)
        )
        return replace(
            self,
            time=self.time[kept],
            reached=self.reached[kept],
            attitude=attitude,
            velocity=velocity,
            velocity_body=velocity_body,
        )


def _run(loaded: LoadedSubject, motion: SampledMotion, repetitions: int, warm: bool) -> _Run:
    step = loaded.subject.samples_per_step or 1
    rows = len(motion.ends) - 1
    samples = rows - rows % step
    if not samples:
        given = "1 sample is" if rows == 1 else f"{rows} samples are"
        raise RunError("not applicable", f"{given} less than a step of {step}")
    with_start = len(motion.first) - rows
    arguments = (
        motion.first[: samples + with_start],
        motion.second[: samples + with_start],
        motion.end_times[: samples + 1] if motion.convention.times else motion.interval,
        motion.attitude[0],
        motion.velocity_inertial[0],
    )
    timed = run(loaded.function, arguments, repetitions, warm)
    output = checked_integrator_output(timed.result, samples)
    r = output.samples_per_step
    # Input rows that end at the checkpoints; a sample that was dropped ends none.
    places = np.searchsorted(motion.ends, motion.checkpoints)
    met = (motion.ends[places] == motion.checkpoints) & (places % r == 0) & (places <= samples)
    reached = np.flatnonzero(met)
    if reached.size < 2:
        raise RunError("not applicable", f"steps of {r} samples meet no checkpoint after the start")
    steps = places[reached] // r

    def errors(name: str, measure: Callable[[Array, Array, Array], Array] = difference) -> Array | None:
        computed: Array | None = getattr(output, name)
        if computed is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            error = measure(computed[steps], getattr(motion, name)[reached], getattr(motion, f"{name}_lo")[reached])
            finite = np.isfinite(_norms(error))
        if not finite.all():
            first = int(steps[np.argmin(finite)])
            raise RunError("not finite", f"the error of {name} exceeds the range of float64, first in row {first}")
        return error

    return _Run(
        output,
        motion.time[reached],
        reached,
        errors("attitude", attitude_error_vectors),
        errors("velocity_inertial"),
        errors("velocity_body"),
        timed.least / samples * 1e9,
        timed.version,
    )


def _norms(vectors: Array) -> Array:
    norms: Array = np.linalg.norm(vectors, axis=1)
    return norms


def _capped(prefix: str, error: Array | None, floor: Array) -> dict[str, float]:
    """Return largest and last error, neither below what the rounding of the inputs alone causes."""
    if error is None:
        return {}
    norms, floors = _norms(error), _norms(floor)
    return {f"{prefix}_max": max(norms.max(), floors.max()), f"{prefix}_end": max(norms[-1], floors[-1])}


def _equivalent_bias(error: Array | None, response: Array) -> float | None:
    """Return the norm of the constant bias, in body axes, whose effect is nearest to the errors in least squares.

    Directions in which the body's own rotation averages a bias away are left out: the errors would ask for
    absurd biases there.
    """
    if error is None:
        return None
    bias = np.linalg.lstsq(response.reshape(-1, 3), error.ravel(), rcond=_AVERAGED_AWAY)[0]
    return float(np.linalg.norm(bias))


def _rounding_bound(motion: SampledMotion, velocity: bool) -> float:
    """Return the most that rounding can do: one unit roundoff a sample, all of one sign."""
    size = _norms(motion.velocity_inertial).max() if velocity else 1.0
    return float(size * motion.samples * np.finfo(np.float64).eps / 2)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


@np.errstate(over="ignore", invalid="ignore")  # large errors are finite, but what is derived from them may not be
def _measured(errors: _Run, rung: Rung) -> dict[str, Any]:
    inputs, at = rung.inputs, errors.reached
    fields: dict[str, Any] = {
        "status": "ok",
        "samples_per_step": errors.output.samples_per_step,
        "ns_per_sample": errors.ns_per_sample,
        "version": errors.version,
        **_capped("attitude_error", errors.attitude, inputs.attitude[at]),
        **_capped("velocity_error", errors.velocity, inputs.velocity[at]),
        **_capped("velocity_body_error", errors.velocity_body, inputs.velocity_body[at]),
        "input_floor": _norms(inputs.attitude[at]).max(),
        "velocity_input_floor": _norms(inputs.velocity[at]).max(),
        "gyro_bias_deg_per_h": _scaled(_equivalent_bias(errors.attitude, inputs.bias_response[at]), _DEG_PER_H),
        "accelerometer_bias_ug": _scaled(_equivalent_bias(errors.velocity, inputs.bias_response[at]), 1 / _MICRO_G),
    }
    if errors.output.attitude is not None:
        fields["drift_deg_per_h"] = fields["attitude_error_end"] / errors.time[-1] * _DEG_PER_H
        norms: Array = np.linalg.norm(errors.output.attitude, axis=1)
        fields["quaternion_norm_error_max"] = np.abs(norms - 1).max()
    return fields


def _nested_method(subject: Subject) -> tuple[RotationVectorMethod | None, bool]:
    base = subject.name.removesuffix("_compensated")
    fed_as_published = subject.dataset == DUAL_PRECESSION and subject.takes == "increments"
    method = METHODS.get(base) if fed_as_published else None
    return method, base != subject.name


@cache
def _operations(method: RotationVectorMethod, compensated: bool) -> float:
    from sinsbench.instrumentation import operation_counts  # compiles nothing, but reads the kernels' source

    return sum(operation_counts(method, compensated=compensated).values())


def _known(subject: Subject, case: DualPrecessionCase, interval: float, end: float) -> dict[str, Any]:
    """Return what is known of the nested algorithms without running them: operations, asymptotic errors at the end."""
    method, compensated = _nested_method(subject)
    if method is None:
        return {}
    error = predicted_error(case.motion, method.order, interval, [end])
    return {
        "flops_per_sample": _operations(method, compensated),
        "predicted_drift_deg_per_h": _norms(error.attitude)[0] / end * _DEG_PER_H,
        "predicted_velocity_error_end": _norms(error.velocity_inertial)[0],
    }


def _ladder_fields(prefix: str, fit: Convergence, rung: int) -> dict[str, Any]:
    return {
        f"{prefix}observed_order": fit.order,
        f"{prefix}order_residual": fit.residual,
        f"{prefix}order_points": fit.points,
        f"{prefix}local_order": fit.local_orders[rung],
        f"{prefix}floor": fit.floors[rung],
        f"{prefix}at_floor": bool(fit.at_floor[rung]),
    }


def score_integrator(
    loaded: LoadedSubject, case: DualPrecessionCase, rungs: Sequence[Rung], repetitions: int = 3, warm: bool = False
) -> list[dict[str, Any]]:
    """Score an integrator on a case: one row a rung.

    Parameters
    ----------
    loaded : LoadedSubject
    case : DualPrecessionCase
    rungs : sequence of Rung
        What `ladder` returned for the case, in the convention that the subject takes.
    repetitions : int, default 3
        Timed calls at most; 0 for no times.
    warm : bool
        Whether the subject has run before, so that its first call compiles nothing and may be timed.

    Returns
    -------
    list of dict
        Rows with the fields of `sinsbench.scoring.rows`. A subject that fails on a rung has a row with status
        and message there; the order is fitted to the other rungs.
    """
    runs: dict[int, _Run] = {}
    failures: dict[int, RunError] = {}
    for i, rung in enumerate(rungs):
        try:
            runs[i] = _run(loaded, rung.motion, repetitions, warm or bool(runs))
        except RunError as error:
            failures[i] = error
    common = reduce(np.intersect1d, (one.reached for one in runs.values())) if runs else np.zeros(0, np.intp)
    if common.size > 1:  # else the rungs have no instant in common, and each is measured where it can be
        runs = {i: one.at(common) for i, one in runs.items()}
    measured: list[dict[str, Any]] = [
        _measured(runs[i], rung) | _known(loaded.subject, case, rung.motion.interval, float(runs[i].time[-1]))
        if i in runs
        else {"status": failures[i].status, "message": str(failures[i])}
        for i, rung in enumerate(rungs)
    ]
    intervals = [rung.motion.interval for rung in rungs]
    fits = {}
    for prefix, name in (("", "attitude_error_max"), ("velocity_", "velocity_error_max")):
        fits[prefix] = convergence(
            intervals,
            [fields.get(name, np.nan) for fields in measured],
            [fields.get(f"{prefix}input_floor", 0.0) for fields in measured],
            [_rounding_bound(rung.motion, velocity=prefix != "") for rung in rungs],
        )
    return [
        merged(
            {
                "subject": loaded.subject.name,
                "dataset": DUAL_PRECESSION,
                "case": case.name,
                "interval": intervals[i],
                "takes": rungs[i].motion.convention.name,
            },
            {"samples_per_step": loaded.subject.samples_per_step},
            measured[i],
            *(
                _ladder_fields(prefix, fit, i)
                for prefix, fit in fits.items()
                if f"{prefix or 'attitude_'}error_max" in measured[i]
            ),
        )
        for i in range(len(rungs))
    ]
