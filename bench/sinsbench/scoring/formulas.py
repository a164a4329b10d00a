"""Scores of subjects of the equator error equations: errors by component, correct digits, ulps."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.cost import time_fields
from sinsbench.scoring.errors import difference
from sinsbench.scoring.rows import merged
from sinsbench.scoring.running import RunError, checked_states, run
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import EQUATOR_ERRORS
from sinsbench.subjects.worker import not_taken
from sinsdata.cases import EquatorCase
from sinsdata.truth.sampling import EquatorTruth, equator_truth
from sinsref.arithmetic import MpArithmetic
from sinsref.equator import EquatorModel
from sinsref.exact import ExactNumber

__all__ = ["COMPONENTS", "EquatorReference", "equator_reference", "score_formula"]

Array = NDArray[np.float64]

COMPONENTS = ("dv_north", "dv_up", "dv_east", "d_height", "d_latitude", "d_longitude")


@dataclass(frozen=True)
class EquatorReference:
    """Truth of a case, the input floor, and natural scales.

    Attributes
    ----------
    truth : EquatorTruth
    input_errors : ndarray, shape (n, 6)
        Errors that the rounding of the inputs to binary64 alone causes: the exact solution for the rounded
        inputs less that for the exact ones. The times count as exact, as they are whenever the interval is a
        binary64 with some bits to spare.
    scales : ndarray, shape (6,)
        sqrt(g R), m/s, for velocities; R, m, for the height; 1 for angles.
    arguments : tuple
        What a subject is called with: ``time, v_east, height, initial_errors``.
    keywords : mapping
        ``misalignment`` and ``inertial_longitude``, where the case has a misalignment; else empty.
    """

    truth: EquatorTruth
    input_errors: Array
    scales: Array
    arguments: tuple[Any, ...]
    keywords: Mapping[str, Any]


def _rounded(number: ExactNumber) -> ExactNumber:
    return ExactNumber(float(number))


def equator_reference(case: EquatorCase) -> EquatorReference:
    """Compute the truth of a case, and again for the inputs that a subject gets.

    Parameters
    ----------
    case : EquatorCase

    Returns
    -------
    EquatorReference
    """
    truth = equator_truth(case)
    misalignment = case.misalignment
    rounded = replace(
        case,
        v_east=_rounded(case.v_east),
        height=_rounded(case.height),
        initial_errors=tuple(map(_rounded, case.initial_errors)),
        misalignment=None if misalignment is None else tuple(tuple(map(_rounded, line)) for line in misalignment),
        inertial_longitude=_rounded(case.inertial_longitude),
    )
    given = equator_truth(rounded)
    ar = MpArithmetic(30)
    model = EquatorModel.at(ar, case.v_east, case.height)
    speed, radius = float(ar.sqrt(model.gravity * model.radius)), float(model.radius)
    return EquatorReference(
        truth,
        (given.state - truth.state) + (given.state_lo - truth.state_lo),
        np.array([speed, speed, speed, radius, 1.0, 1.0]),
        (
            truth.time,
            float(case.v_east),
            float(case.height),
            np.array([float(x) for x in case.initial_errors]),
        ),
        {}
        if misalignment is None
        else {
            "misalignment": np.array([[float(x) for x in line] for line in misalignment]),
            "inertial_longitude": float(case.inertial_longitude),
        },
    )


def _digits(ratio: Array) -> float:
    return float(-np.log10(ratio.max(initial=0.0)))


def score_formula(
    loaded: LoadedSubject, case: EquatorCase, reference: EquatorReference, repetitions: int = 3, warm: bool = False
) -> list[dict[str, Any]]:
    """Score an equator subject on a case: one row.

    Parameters
    ----------
    loaded : LoadedSubject
    case : EquatorCase
    reference : EquatorReference
        What `equator_reference` returned for the case.
    repetitions : int, default 3
        Timed calls at most; 0 for no time.
    warm : bool
        Whether the subject has run before, so that its first call may be timed.

    Returns
    -------
    list of dict
        One row with the fields of `sinsbench.scoring.rows`. No error counts as less than what the rounding of the
        inputs causes. A subject that takes no misalignment is not applicable to a case with one. Digits are those of
        the Test Set for IVP Solvers (Mazzia, Magherini 2008) at the last epoch: ``scd = -log10 max |e/x|`` and
        ``mescd = -log10 max |e| / (s + |x|)``, where s takes the place of the ratio of absolute to relative
        tolerance. A component that is exactly zero, and computed as zero, is left out of ``scd``.
    """
    truth = reference.truth
    head: dict[str, Any] = {
        "subject": loaded.subject.name,
        "dataset": EQUATOR_ERRORS,
        "case": case.name,
        "interval": float(case.interval),
    }
    try:
        missing = not_taken(loaded.function, reference.keywords)
        if missing is not None:
            raise RunError("not applicable", f"takes no {missing}")
        timed = run(loaded.function, reference.arguments, repetitions, warm, keywords=reference.keywords)
        fields = _measured(checked_states(timed.result, len(truth.time)), reference)
    except RunError as failure:
        return [merged(head, {"status": failure.status, "message": str(failure)})]
    return [merged(head, fields, time_fields(timed, len(truth.time)), {"version": timed.version})]


@np.errstate(over="ignore", divide="ignore", invalid="ignore")
def _measured(states: Array, reference: EquatorReference) -> dict[str, Any]:
    truth = reference.truth
    floor = np.abs(reference.input_errors)
    error = np.maximum(np.abs(difference(states, truth.state, truth.state_lo)), floor)
    finite = np.isfinite(np.linalg.norm(error, axis=1))
    if not finite.all():
        raise RunError("not finite", f"the error exceeds the range of float64, first in row {int(np.argmin(finite))}")
    size = np.abs(truth.state)
    # What a perfect subject leaves: the rounding of its inputs and that of its result.
    unavoidable = np.maximum(floor, np.abs(truth.state_lo))
    speed, speed_floor, least = (np.linalg.norm(x[:, :3], axis=1) for x in (error, floor, unavoidable))
    end, end_size = error[-1], size[-1]
    counted = (end > 0) | (end_size > 0)
    nonzero = size > 0
    return {
        "status": "ok",
        "velocity_error_max": speed.max(),
        "velocity_error_end": speed[-1],
        "velocity_input_floor": speed_floor.max(),
        "at_floor": bool(speed.max() <= least.max()),
        "scd": _digits(end[counted] / end_size[counted]),
        "mescd": _digits(end / (reference.scales + end_size)),
        "ulp_max": np.max(error[nonzero] / np.spacing(size[nonzero]), initial=0.0),
        **{f"error_{name}_max": error[:, i].max() for i, name in enumerate(COMPONENTS)},
    }
