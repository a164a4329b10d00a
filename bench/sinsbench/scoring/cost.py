"""What a subject costs: time against a fixed workload, floating-point operations, bytes of state."""

import contextlib
import sys
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

from sinsbench.scoring.running import Timed
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import DUAL_PRECESSION
from sinsdata.cases import DualPrecessionCase
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import SampledMotion, sample
from sinsref.exact import ExactNumber

__all__ = ["inputs_of", "operations", "state_bytes", "time_fields"]

#: Case and duration (s) on whose samples built-in subjects are counted: their counts belong to no case.
_COUNTED_ON, _COUNTED_FOR = "variant2_general", "1.28"


def time_fields(timed: Timed, samples: int) -> dict[str, Any]:
    """Return the fields of a row that tell of time.

    Parameters
    ----------
    timed : Timed
    samples : int
        Samples (or epochs) of one call.
    """
    if not timed.seconds:
        return {}
    from sinsbench.scoring.calibration import calibration_unit  # imports numba

    unit, least = calibration_unit(), timed.least / samples * 1e9
    return {
        "ns_per_sample": least,
        "ns_per_sample_median": timed.median / samples * 1e9,
        "calibration_ns": unit,
        "relative_cost": least / unit,
    }


def inputs_of(motion: SampledMotion, samples: int) -> tuple[Any, ...]:
    """Return what an integrator is called with for the first samples of a motion.

    Parameters
    ----------
    motion : SampledMotion
    samples : int
        At most the number of the motion's input rows, a row for the start not counted.
    """
    with_start = len(motion.first) - len(motion.ends) + 1
    return (
        motion.first[: samples + with_start],
        motion.second[: samples + with_start],
        motion.end_times[: samples + 1] if motion.convention.times else motion.interval,
        motion.attitude[0],
        motion.velocity_inertial[0],
    )


def state_bytes(loaded: LoadedSubject) -> int | None:
    """Return the bytes that a subject carries between steps, as it is registered or as its attribute says."""
    declared = loaded.subject.state_bytes or getattr(loaded.function, "state_bytes", None)
    return declared if type(declared) is int and declared > 0 else None


def operations(loaded: LoadedSubject, motion: SampledMotion, step: int) -> tuple[float | None, str]:
    """Count the floating-point operations a sample of an integrator that runs in this process.

    Parameters
    ----------
    loaded : LoadedSubject
    motion : SampledMotion
        Samples that a user's own subject is run on; built-in ones are counted once, on the same samples always.
    step : int
        Samples that a step consumes.

    Returns
    -------
    operations : float or None
    note : str
        Why they could not be counted, in one line.
    """
    if loaded.subject.dataset is not None:
        return _built_in_operations(loaded.function, motion.convention.name, step)
    return _counted(loaded.function, motion, step)


@lru_cache(maxsize=256)
def _built_in_operations(function: Callable[..., Any], convention: str, step: int) -> tuple[float | None, str]:
    case = next(case for case in paper_cases(DUAL_PRECESSION) if case.name == _COUNTED_ON)
    if not isinstance(case, DualPrecessionCase):
        raise TypeError(f"{case.name} is no motion")
    short = replace(case, duration=ExactNumber(_COUNTED_FOR))
    return _counted(function, sample(short, convention=convention), step)


def _counted(function: Callable[..., Any], motion: SampledMotion, step: int) -> tuple[float | None, str]:
    from sinsbench.instrumentation.counting import COUNTED_STEPS, operations_per_sample

    def arguments(samples: int) -> tuple[Any, ...]:
        return tuple(x.copy() if hasattr(x, "copy") else x for x in inputs_of(motion, samples))

    most = COUNTED_STEPS[-1]
    if most * step > len(motion.ends) - 1:
        return None, f"counting takes {most} steps of {step} samples; there are {len(motion.ends) - 1}"
    with warnings.catch_warnings(), contextlib.redirect_stdout(sys.stderr):
        warnings.simplefilter("ignore")
        return operations_per_sample(function, arguments, step)
