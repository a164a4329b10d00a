"""Scores of integrators: each case is sampled at a ladder of intervals, each subject runs on every rung.

Truth is compared at checkpoints common to all rungs, so that errors of different intervals are taken at the
same instants.
"""

from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.asymptotics import predicted_error
from sinsbench.scoring.convergence import FEWEST_POINTS, Convergence, convergence
from sinsbench.scoring.cost import operations, state_bytes, time_fields
from sinsbench.scoring.crossing import crossing
from sinsbench.scoring.ladders import LADDER, Rung, coarser_rungs, ladder
from sinsbench.scoring.rows import merged
from sinsbench.scoring.running import RunError
from sinsbench.scoring.runs import RungRun, norms, run_rung
from sinsbench.scoring.secular import frequencies_of, secular_parts
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import DUAL_PRECESSION, Subject
from sinsbench.subjects.rotation_vector_methods import METHODS
from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.sampling import SampledMotion

__all__ = ["LADDER", "NAVIGATION_DRIFT", "Rung", "ladder", "score_integrator"]

Array = NDArray[np.float64]

NAVIGATION_DRIFT = 1e-3
"""Drift, deg/h, that `rate_needed_hz` asks for: a tenth of what gyros of inertial navigation have."""

_DEG_PER_H = np.degrees(1.0) * 3600
_AVERAGED_AWAY = 0.01  # accumulation relative to that of the bias that accumulates most
_CONVERGING = 0.5  # order: between no convergence and the first
_WRONG = 1e-3  # rad: no method that is right stays there
_MICRO_G = 9.80665e-6  # m/s^2 in a millionth of standard gravity
_VELOCITY_GROWTH = 2  # powers of time by which oscillations of the velocity error grow, see `secular_parts`
#: Prefix of the fields of an order -> the field that it is fitted to.
_LADDERS = {"": "attitude_error_max", "secular_": "secular_drift_deg_per_h", "velocity_": "velocity_error_max"}


def _capped(prefix: str, error: Array | None, floor: Array) -> dict[str, float]:
    """Return largest and last error, neither below what the rounding of the inputs alone causes."""
    if error is None:
        return {}
    sizes, floors = norms(error), norms(floor)
    return {f"{prefix}_max": max(sizes.max(), floors.max()), f"{prefix}_end": max(sizes[-1], floors[-1])}


def _secular(
    rate: str, rest: str, unit: float, run: RungRun, error: Array | None, floor: Array, case: DualPrecessionCase
) -> dict[str, float]:
    """Return secular rate and largest periodic remainder, neither below those of the inputs' rounding."""
    if error is None:
        return {}
    growth = _VELOCITY_GROWTH if rate == "secular_velocity_rate" else 0
    frequencies = frequencies_of(case.motion)
    parts = [secular_parts(run.time, x, frequencies, growth) for x in (error, floor)]
    if parts[0] is None or parts[1] is None:
        return {}
    rates = [float(np.linalg.norm(part.rate)) * unit for part in parts if part is not None]
    found = {rate: max(rates), rest: max(norms(part.periodic).max() for part in parts if part is not None)}
    return found | ({} if growth else {"secular_input_floor": rates[1]})


def _equivalent_bias(error: Array | None, response: Array) -> float | None:
    """Return the norm of the constant bias, in body axes, whose effect is nearest to the errors in least squares.

    Directions in which the body's own rotation averages a bias away are left out: the errors would ask for
    absurd biases there.
    """
    if error is None:
        return None
    bias = np.linalg.lstsq(response.reshape(-1, 3), error.ravel(), rcond=_AVERAGED_AWAY)[0]
    return float(np.linalg.norm(bias))


def _rounding_bound(motion: SampledMotion, prefix: str) -> float:
    """Return the most that rounding can do: one unit roundoff a sample, all of one sign."""
    size = norms(motion.velocity_inertial).max() if prefix == "velocity_" else 1.0
    unit = _DEG_PER_H / motion.time[-1] if prefix == "secular_" else 1.0
    return float(size * unit * motion.samples * np.finfo(np.float64).eps / 2)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


@np.errstate(over="ignore", invalid="ignore")  # large errors are finite, but what is derived from them may not be
def _measured(run: RungRun, rung: Rung, case: DualPrecessionCase) -> dict[str, Any]:
    inputs, at = rung.inputs, run.reached
    attitude, velocity = inputs.attitude[at], inputs.velocity[at]
    fields: dict[str, Any] = {
        "status": "ok",
        "message": run.hint or None,
        "samples_per_step": run.output.samples_per_step,
        "version": run.timed.version,
        **time_fields(run.timed, run.samples),
        **_capped("attitude_error", run.attitude, attitude),
        **_capped("velocity_error", run.velocity, velocity),
        **_capped("velocity_body_error", run.velocity_body, inputs.velocity_body[at]),
        **_secular("secular_drift_deg_per_h", "attitude_periodic_max", _DEG_PER_H, run, run.attitude, attitude, case),
        **_secular("secular_velocity_rate", "velocity_periodic_max", 1.0, run, run.velocity, velocity, case),
        "input_floor": norms(attitude).max(),
        "velocity_input_floor": norms(velocity).max(),
        "gyro_bias_deg_per_h": _scaled(_equivalent_bias(run.attitude, inputs.bias_response[at]), _DEG_PER_H),
        "accelerometer_bias_ug": _scaled(_equivalent_bias(run.velocity, inputs.bias_response[at]), 1 / _MICRO_G),
    }
    if run.output.attitude is not None:
        fields["drift_deg_per_h"] = fields["attitude_error_end"] / run.time[-1] * _DEG_PER_H
        sizes: Array = np.linalg.norm(run.output.attitude, axis=1)
        fields["quaternion_norm_error_max"] = np.abs(sizes - 1).max()
    return fields


def _predicted(subject: Subject, case: DualPrecessionCase, interval: float, end: float) -> dict[str, Any]:
    """Return the asymptotic errors of the nested algorithms at the end."""
    method = METHODS.get(subject.name.removesuffix("_compensated"))
    fed_as_published = subject.dataset == DUAL_PRECESSION and subject.takes == "increments"
    if method is None or not fed_as_published or subject.paper != "lebedev1989":
        return {}
    error = predicted_error(case.motion, method.order, interval, [end])
    return {
        "predicted_drift_deg_per_h": norms(error.attitude)[0] / end * _DEG_PER_H,
        # In the precession frame the secular part lies along the axis of precession.
        "predicted_secular_drift_deg_per_h": abs(error.attitude[0, 2]) / end * _DEG_PER_H,
        "predicted_velocity_error_end": norms(error.velocity_inertial)[0],
    }


def _expected(subject: Subject) -> dict[str, Any]:
    """Return the orders that theory gives a built-in method."""
    drift = subject.order_drift or subject.order
    return {
        "expected_order": subject.order,
        "secular_expected_order": drift,
        "narrow_cone_order": subject.order_coning,
        "velocity_expected_order": subject.order_velocity or subject.order,
    }


def _cost(loaded: LoadedSubject, runs: dict[int, RungRun], rungs: Sequence[Rung]) -> dict[str, Any]:
    """Return what a sample costs on every rung alike; a user's subject is counted at the case's own interval."""
    if not runs:
        return {}
    number = next((i for i in runs if rungs[i].factor == 1), next(iter(runs)))
    run = runs[number]
    if loaded.elsewhere or run.timed.elsewhere:
        flops, note = None, "not run here"
    else:
        flops, note = operations(loaded, rungs[number].motion, run.output.samples_per_step)
    return {"flops_per_sample": flops, "flops_note": note or None, "state_bytes": state_bytes(loaded)}


def _a_second(fields: dict[str, Any], interval: float) -> dict[str, Any]:
    """Return costs a second of motion."""
    return {f"{name}_per_second": _scaled(fields.get(f"{name}_per_sample"), 1 / interval) for name in ("flops", "ns")}


def _fit(prefix: str, rungs: Sequence[Rung], measured: Sequence[dict[str, Any]], left_out: int = 0) -> Convergence:
    return convergence(
        [rung.motion.interval for rung in rungs],
        [fields.get(_LADDERS[prefix], np.nan) for fields in measured],
        [fields.get(f"{prefix}input_floor", 0.0) for fields in measured],
        [_rounding_bound(rung.motion, prefix) for rung in rungs],
        left_out,
    )


def _ladder_fields(prefix: str, fit: Convergence, rung: int) -> dict[str, Any]:
    return {
        f"{prefix}observed_order": fit.order,
        f"{prefix}order_residual": fit.residual,
        f"{prefix}order_points": fit.points,
        f"{prefix}order_note": fit.note or None,
        f"{prefix}local_order": fit.local_orders[rung],
        f"{prefix}floor": fit.floors[rung],
        f"{prefix}at_floor": bool(fit.at_floor[rung]),
    }


def _stuck(fit: Convergence, fields: dict[str, Any]) -> str | None:
    """Return what a large error that finer sampling does not lessen points to."""
    if fit.order is None or fit.order > _CONVERGING or fields.get("attitude_error_max", 0.0) < _WRONG:
        return None
    return "the error does not shrink with the interval: are units (rad), axes, signs and initial attitude right?"


def _rate_needed(fit: Convergence, rungs: Sequence[Rung], measured: Sequence[dict[str, Any]]) -> dict[str, Any]:
    drifts = [fields.get("drift_deg_per_h", np.nan) for fields in measured]
    if not np.isfinite(drifts).any():
        return {}
    least = float(fit.floors[-1] / rungs[-1].motion.time[-1] * _DEG_PER_H)
    found = crossing([rung.motion.interval for rung in rungs], drifts, NAVIGATION_DRIFT, fit.order, least)
    rate = None if found.interval is None else 1 / found.interval
    return {"rate_needed_hz": rate, "rate_needed_note": found.note or None}


def score_integrator(
    loaded: LoadedSubject, case: DualPrecessionCase, rungs: Sequence[Rung], repetitions: int = 3, warm: bool = False
) -> list[dict[str, Any]]:
    """Score an integrator on a case: one row a rung.

    Where rounding hides the order of a method on most of the ladder, or the drift is small on all of it, coarser
    intervals are tried, and have rows too if the subject runs on them.

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
        Rows with the fields of `sinsbench.scoring.rows`, coarsest interval first. A subject that fails on a rung has
        a row with status and message there; the order is fitted to the other rungs.
    """
    runs: dict[int, RungRun] = {}
    failures: dict[int, RunError] = {}
    for i, rung in enumerate(rungs):
        try:
            runs[i] = run_rung(loaded, rung.motion, repetitions, warm or bool(runs))
        except RunError as error:
            failures[i] = error
    cost = _cost(loaded, runs, rungs)
    common = reduce(np.intersect1d, (one.reached for one in runs.values())) if runs else np.zeros(0, np.intp)
    if common.size > 1:  # else the rungs have no instant in common, and each is measured where it can be
        runs = {i: one.at(common) for i, one in runs.items()}

    def fields_of(run: RungRun, rung: Rung) -> dict[str, Any]:
        interval = rung.motion.interval
        found = _measured(run, rung, case) | cost | _predicted(loaded.subject, case, interval, float(run.time[-1]))
        return found | _a_second(found, interval)

    measured: list[dict[str, Any]] = [
        fields_of(runs[i], rung) if i in runs else {"status": failures[i].status, "message": str(failures[i])}
        for i, rung in enumerate(rungs)
    ]
    used = list(rungs)
    fits = {prefix: _fit(prefix, used, measured) for prefix in _LADDERS}
    left_out = dict.fromkeys(fits, 0)
    for rung in coarser_rungs(case, rungs) if len(runs) >= FEWEST_POINTS else ():
        hidden = {prefix for prefix, fit in fits.items() if fit.order is None and _LADDERS[prefix] in measured[-1]}
        if not hidden and measured[0].get("drift_deg_per_h", np.inf) > NAVIGATION_DRIFT:
            break
        try:
            more = fields_of(run_rung(loaded, rung.motion, repetitions, warm=True), rung)
        except RunError:
            break
        used, measured = [rung, *used], [more, *measured]
        # Where the ladder itself shows an order, it rests on the ladder.
        left_out = {prefix: 0 if prefix in hidden else left_out[prefix] + 1 for prefix in fits}
        fits = {prefix: _fit(prefix, used, measured, left_out[prefix]) for prefix in _LADDERS}
    whole = _rate_needed(fits[""], used, measured)
    for fields in measured:
        if fields["status"] == "ok" and not fields["message"]:
            fields["message"] = _stuck(fits[""], fields)
    return [
        merged(
            {
                "subject": loaded.subject.name,
                "dataset": DUAL_PRECESSION,
                "case": case.name,
                "interval": rung.motion.interval,
                "takes": rung.motion.convention.name,
            },
            {"samples_per_step": loaded.subject.samples_per_step, **_expected(loaded.subject)},
            fields,
            *(_ladder_fields(prefix, fit, i) for prefix, fit in fits.items() if _LADDERS[prefix] in fields),
            whole if fields["status"] == "ok" else {},
        )
        for i, (rung, fields) in enumerate(zip(used, measured, strict=True))
    ]
