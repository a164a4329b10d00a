"""A run of an integrator on one rung of a ladder, and its errors at the checkpoints."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.cost import inputs_of
from sinsbench.scoring.errors import attitude_error_vectors, difference
from sinsbench.scoring.misreadings import misreading
from sinsbench.scoring.running import IntegratorOutput, RunError, Timed, checked_integrator_output, run
from sinsbench.subjects.loading import LoadedSubject
from sinsdata.truth.sampling import SampledMotion

__all__ = ["RungRun", "norms", "run_rung"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RungRun:
    """Errors of one run at the checkpoints it reaches.

    Attributes
    ----------
    output : IntegratorOutput
    timed : Timed
    samples : int
        Samples it was given.
    time : ndarray, shape (m,)
        Times of the checkpoints that it reaches, s.
    reached : ndarray of int, shape (m,)
        Their numbers.
    attitude : ndarray, shape (m, 3), or None
        Attitude error in inertial axes, rad; None where the subject computes no attitude.
    velocity, velocity_body : ndarray, shape (m, 3), or None
        Errors of the apparent velocity in inertial and in body axes, m/s.
    hint : str
        Convention in which its attitudes would be right, if they are wrong; see `sinsbench.scoring.misreadings`.
    """

    output: IntegratorOutput
    timed: Timed
    samples: int
    time: Array
    reached: NDArray[np.intp]
    attitude: Array | None
    velocity: Array | None
    velocity_body: Array | None
    hint: str = ""

    def at(self, checkpoints: NDArray[np.intp]) -> "RungRun":
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


def run_rung(loaded: LoadedSubject, motion: SampledMotion, repetitions: int, warm: bool) -> RungRun:
    """Run an integrator on a rung, and measure its errors.

    Parameters
    ----------
    loaded : LoadedSubject
    motion : SampledMotion
    repetitions : int
        Timed calls at most.
    warm : bool
        Whether the first call may be timed too.

    Raises
    ------
    RunError
        If the subject fails, or what it returns cannot be used or compared.
    """
    step = loaded.subject.samples_per_step or 1
    rows = len(motion.ends) - 1
    samples = rows - rows % step
    if not samples:
        given = "1 sample is" if rows == 1 else f"{rows} samples are"
        raise RunError("not applicable", f"{given} less than a step of {step}")
    timed = run(loaded.function, inputs_of(motion, samples), repetitions, warm)
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
            finite = np.isfinite(norms(error))
        if not finite.all():
            first = int(steps[np.argmin(finite)])
            raise RunError("not finite", f"the error of {name} exceeds the range of float64, first in row {first}")
        return error

    truth = motion.attitude[reached], motion.attitude_lo[reached]
    hint = "" if output.attitude is None else misreading(output.attitude[steps], *truth)
    return RungRun(
        output,
        timed,
        samples,
        motion.time[reached],
        reached,
        errors("attitude", attitude_error_vectors),
        errors("velocity_inertial"),
        errors("velocity_body"),
        hint,
    )


def norms(vectors: Array) -> Array:
    """Return the Euclidean norms of the rows of an array."""
    result: Array = np.linalg.norm(vectors, axis=1)
    return result
