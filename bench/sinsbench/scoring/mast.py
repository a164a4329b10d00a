"""Scores of estimators of an antenna on a mast: errors over windows, settling times, consistency, cost."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.mast_deviations import deviations
from sinsbench.scoring.mast_errors import (
    BLOCKS,
    QUANTITIES,
    Estimates,
    FailedEstimateError,
    checked_estimates,
    gauge_free_errors,
    inputs_of,
    nees,
    start_of,
)
from sinsbench.scoring.rows import Field, plain_row
from sinsbench.scoring.running import RunError, run
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.mast.contract import BreakdownError, MastInputs
from sinsdata.cases import MastCase
from sinsdata.truth.mast import MastMotion

__all__ = [
    "DATASET",
    "FIELDS",
    "LIMITS",
    "NEES_TIMES",
    "WINDOWS",
    "error_history",
    "first_steps",
    "identity",
    "score_mast",
]

Array = NDArray[np.float64]

DATASET = "mast_antenna"
"""Name of the dataset."""
WINDOWS: Mapping[str, tuple[float, float]] = {"50_200": (50, 200), "200_500": (200, 500), "500_1000": (500, 1000)}
"""Windows over which errors are told where the motion lasts to their end, s; ``late`` is the second half of any run."""
LIMITS: Mapping[str, float] = {
    "mu": 1e-4,
    "nu": 2e-5,
    "antenna": 1e-4,
    "mast": 5e-5,
    "position": 1.0,
    "velocity": 0.01,
}
"""Errors below which an estimate counts as settled, in the units of `QUANTITIES`."""
NEES_TIMES = (10, 50, 100, 200, 500, 1000)
"""Times at which the normalised estimation error squared is told, s."""

_ASYMMETRY = 1e-6  # of the deviations' product: a filter that never symmetrises passes, a transposed block does not
_WARM_UP = 2.0  # s of a motion that a first call gets: enough for whatever compiles on the way
_SIZES = {"rms": "root mean square", "max": "largest"}
_SPANS = {name: f"over {low:g} to {high:g} s" for name, (low, high) in WINDOWS.items()} | {
    "late": "over the second half of the motion"
}

FIELDS = (
    Field("subject", "", "name of the subject"),
    Field("dataset", "", "name of the dataset"),
    Field("case", "", "name of the case"),
    Field("interval", "s", "length of a step"),
    Field("duration", "s", "of the motion"),
    Field("satellites", "", "number of satellites used"),
    Field("status", "", "what became of the subject, as in `sinsbench.scoring.rows.STATUSES`"),
    Field("message", "", "what went wrong, in one line"),
    Field("failed_at", "s", "time at which an estimate first failed"),
    Field("us_per_step", "us", "least time over the repetitions, a step"),
    *(
        Field(f"{name}_{size}_{window}", unit, f"{meaning}, {_SIZES[size]} {span}")
        for name, (unit, meaning) in QUANTITIES.items()
        for window, span in _SPANS.items()
        for size in _SIZES
    ),
    *(
        Field(f"{name}_settled", "s", f"time from which on the error of {name} stays below {limit:g} {unit}")
        for name, limit in LIMITS.items()
        for unit in (QUANTITIES[name][0],)
    ),
    *(
        Field(
            f"nees_{name}_{when}s",
            "",
            f"normalised estimation error squared at {when} s, {len(places)} degrees of freedom",
        )
        for name, places in BLOCKS.items()
        for when in NEES_TIMES
    ),
    Field("nis_ratio", "", "normalised innovations squared over their degrees of freedom, all steps; 1 is expected"),
    Field("nis_deviations", "", "that sum less its expectation, in standard deviations of chi-square"),
)


def _windows(time: Array) -> dict[str, NDArray[np.bool_]]:
    told = {name: span for name, span in WINDOWS.items() if time[-1] >= span[1] - 1e-6}
    told["late"] = (float(time[0] + time[-1]) / 2, float(time[-1]))
    # Times are multiples of a step in binary64: far less than a step off.
    return {name: (time >= low - 1e-6) & (time <= high + 1e-6) for name, (low, high) in told.items()}


def settled(time: Array, error: Array, limit: float) -> float | None:
    """Return the time from which on an error stays below a limit, s; None if it is not below it at the end."""
    above = np.flatnonzero(~(error < limit))
    if not above.size:
        return float(time[0])
    return None if above[-1] == len(error) - 1 else float(time[above[-1] + 1])


def _measured(estimates: Estimates, truth: MastMotion) -> dict[str, Any]:
    time = truth.time[estimates.rows]
    errors = gauge_free_errors(estimates, truth)
    told: dict[str, Any] = {}
    for window, inside in _windows(time).items():
        for name, values in errors.items():
            told[f"{name}_rms_{window}"] = np.sqrt(np.mean(values[inside] ** 2))
            told[f"{name}_max_{window}"] = values[inside].max()
    told |= {f"{name}_settled": settled(time, errors[name], limit) for name, limit in LIMITS.items()}
    return told


def _check_symmetric(covariance: Array, time: Array) -> None:
    places = BLOCKS["joint"]  # the twist of the mast may be known exactly: rounding would be all of its covariance
    block = covariance[:, places][:, :, places]
    size = np.sqrt(np.maximum(np.diagonal(block, axis1=1, axis2=2), 0.0))
    allowed = _ASYMMETRY * size[:, :, None] * size[:, None, :]
    wrong = (np.abs(block - block.transpose(0, 2, 1)) > allowed).any(axis=(1, 2))
    if wrong.any():
        raise FailedEstimateError("error", "covariance is not symmetric", float(time[int(np.argmax(wrong))]))


def _consistency(estimates: Estimates, truth: MastMotion) -> dict[str, float]:
    time, told = truth.time[estimates.rows], {}
    if estimates.covariance is not None:
        _check_symmetric(estimates.covariance, time)
        for name, values in nees(estimates, truth).items():
            for when in NEES_TIMES:
                for k in np.flatnonzero(np.abs(time - when) < 1e-6):
                    told[f"nees_{name}_{when}s"] = float(values[k])
    if estimates.nis is not None and estimates.nis_freedom is not None and estimates.nis_freedom[-1] > 0:
        total, freedom = float(estimates.nis[-1]), float(estimates.nis_freedom[-1])
        told |= {"nis_ratio": total / freedom, "nis_deviations": (total - freedom) / (2 * freedom) ** 0.5}
    return told


def first_steps(inputs: MastInputs, count: int) -> MastInputs:
    """Return copies of the inputs of the first steps, of all if there are no more than `count`."""
    count = min(len(inputs.time) - 1, count)
    stepwise = ("rate1", "specific_force1", "rate2", "specific_force2", "range_rate", "range")
    halved = ("satellite_position", "satellite_velocity")
    return replace(
        inputs,
        time=inputs.time[: count + 1].copy(),
        **{name: getattr(inputs, name)[:count].copy() for name in stepwise},
        **{name: getattr(inputs, name)[: 2 * count + 1].copy() for name in halved},
    )


def _estimates(loaded: LoadedSubject, truth: MastMotion, repetitions: int, warm: bool) -> tuple[Estimates, float]:
    """Run a subject on a motion; return its estimates, and the least time of a call, s."""
    inputs = inputs_of(truth)
    if repetitions and not warm and not loaded.elsewhere:
        # A motion is long: what compiles is made to do so on a short piece, whatever becomes of that.
        with suppress(RunError):
            short = first_steps(inputs, max(1, round(_WARM_UP / inputs.step)))
            run(loaded.function, (short, start_of(truth.start)), repetitions=0)
    timed = run(loaded.function, (inputs, start_of(truth.start)), min(repetitions, 1), warm=True)
    return checked_estimates(timed.result, truth), timed.least


def score_mast(
    loaded: LoadedSubject, case: MastCase, truth: MastMotion, repetitions: int = 1, warm: bool = False
) -> list[dict[str, Any]]:
    """Score an estimator on a case: one row.

    Parameters
    ----------
    loaded : LoadedSubject
        A callable ``f(inputs, start)`` of `sinsbench.subjects.mast.contract.MastInputs` and `MastStart`, which returns
        what that module says.
    case : MastCase
    truth : MastMotion
        The case, sampled.
    repetitions : int, default 1
        0 for no times; a long motion is run once.
    warm : bool
        Whether the subject has run before, so that nothing is left to compile.

    Returns
    -------
    list of dict
        A row with the fields `FIELDS`. A subject that fails, or whose estimates cease to be finite, has a row with
        status and message, which says at which second; one whose covariance is not positive has its errors there too.
    """
    told: dict[str, Any] = {"satellites": case.satellite_count}
    try:
        estimates, seconds = _estimates(loaded, truth, repetitions, warm)
        told |= {"us_per_step": seconds / truth.steps * 1e6, **_measured(estimates, truth)}
        told |= {"status": "ok", **_consistency(estimates, truth)}
    except RunError as error:
        told |= {"status": error.status, "message": str(error), "failed_at": _failed_at(error)}
    return [plain_row(FIELDS, identity(loaded, case, truth) | told)]


def _failed_at(error: RunError) -> float | None:
    if isinstance(error, FailedEstimateError):
        return error.time
    return error.__cause__.time if isinstance(error.__cause__, BreakdownError) else None


def error_history(loaded: LoadedSubject, truth: MastMotion) -> dict[str, Array]:
    """Return the errors of an estimator over time, for a plot.

    Parameters
    ----------
    loaded : LoadedSubject
    truth : MastMotion

    Returns
    -------
    dict of str to ndarray, shape (m,)
        ``time``, s, the names of `QUANTITIES` and, if it returns a covariance, ``nees_`` and the names of `BLOCKS`,
        ``deviation_`` and the names of `QUANTITIES`: the root mean squares that the covariance predicts.

    Raises
    ------
    RunError
        If the subject yields no usable result.
    """
    estimates, _ = _estimates(loaded, truth, 0, warm=True)
    told = {"time": truth.time[estimates.rows], **gauge_free_errors(estimates, truth)}
    if estimates.covariance is not None:
        told |= {f"nees_{name}": values for name, values in nees(estimates, truth).items()}
        told |= {f"deviation_{name}": values for name, values in deviations(estimates, truth).items()}
    return told


def identity(loaded: LoadedSubject, case: MastCase, truth: MastMotion) -> dict[str, Any]:
    """Return the fields that say which subject ran on what."""
    return {
        "subject": loaded.subject.name,
        "dataset": DATASET,
        "case": case.name,
        "interval": truth.interval,
        "duration": float(case.duration),
    }
