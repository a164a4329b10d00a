"""The experiment of Lebedev, Panov 1989, section 6, run again: the errors after 100 s, and what spoils them.

Six motions (three variants, coning and general precession) are sampled once, with certified increments and certified
final values. On them run the nested algorithms of orders 4 and 6, in binary64, in a shorter mantissa, and with every
rotation vector scaled by one factor.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from sinsbench.scoring.errors import attitude_error_vectors, difference
from sinsbench.subjects.integrators import Integrator, panov2_compensated, panov4_compensated, panov6_compensated
from sinsbench.subjects.rotation_vector_methods import (
    PANOV_4,
    PANOV_6,
    RotationVectorMethod,
    binary64_coefficients,
)
from sinsdata.cases import DualPrecessionCase
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import SampledMotion, sample

Array = NDArray[np.float64]

METHODS = {"4": PANOV_4, "6": PANOV_6}
MOTIONS = ("coning", "general")

#: The scale error of the rotation vectors at which its effect, linear in it, is measured.
_PROBE = 1e-6


@dataclass(frozen=True)
class FinalErrors:
    """Errors at the end of a run, computed minus true.

    Attributes
    ----------
    attitude : ndarray, shape (3,)
        Rotation from the true to the computed attitude, inertial axes, rad.
    inertial, body : ndarray, shape (3,)
        Errors of the apparent velocity by its components in inertial and in body axes, m/s.
    """

    attitude: Array
    inertial: Array
    body: Array

    def plus(self, factor: float, other: "FinalErrors") -> "FinalErrors":
        """Return these errors plus a multiple of others."""
        return FinalErrors(
            self.attitude + factor * other.attitude,
            self.inertial + factor * other.inertial,
            self.body + factor * other.body,
        )

    def velocity(self, axes: str) -> float:
        """Return the norm of the velocity error in ``"inertial"`` or ``"body"`` axes, m/s."""
        return float(np.linalg.norm({"inertial": self.inertial, "body": self.body}[axes]))


@cache
def case(variant: str, motion: str) -> DualPrecessionCase:
    """Return the case of a variant (``variant1`` ...) and a motion (``coning``, ``general``)."""
    cases = {c.name: c for c in paper_cases("dual_precession") if isinstance(c, DualPrecessionCase)}
    return cases[f"{variant}_{motion}"]


@cache
def sampled(variant: str, motion: str) -> SampledMotion:
    """Return its increments, with truth at the start and at the end alone."""
    given = case(variant, motion)
    return sample(given, checkpoint_interval=given.duration)


def final_errors(run: Integrator, motion: SampledMotion, angle: ArrayLike, velocity: ArrayLike) -> FinalErrors:
    """Run an integrator on increments and return its errors at the end of a motion."""
    result = run(angle, velocity, motion.interval, motion.attitude[0], motion.velocity_inertial[0])
    return FinalErrors(
        attitude_error_vectors(result["attitude"][-1:], motion.attitude[-1:], motion.attitude_lo[-1:])[0],
        difference(result["velocity_inertial"][-1], motion.velocity_inertial[-1], motion.velocity_inertial_lo[-1]),
        difference(result["velocity_body"][-1], motion.velocity_body[-1], motion.velocity_body_lo[-1]),
    )


@cache
def errors(order: str, variant: str, motion: str) -> FinalErrors:
    """Return the errors of the algorithm of an order, ``"4"`` or ``"6"``, in compensated binary64."""
    run = {"4": panov4_compensated, "6": panov6_compensated}[order]
    data = sampled(variant, motion)
    return final_errors(run, data, data.angle, data.velocity)


@cache
def _scale_effect(order: str, variant: str, motion: str) -> FinalErrors:
    """Return what one unit of scale error in every rotation vector adds to the errors, to first order."""
    data = sampled(variant, motion)
    phi, phi_dual = _rotation_vectors(data, METHODS[order])
    # The method of order 2 only adds the increments of a step: fed with rotation vectors it does (1.12) and (2.6).
    above, below = (
        final_errors(panov2_compensated, data, (1 + kappa) * phi, (1 + kappa) * phi_dual) for kappa in (_PROBE, -_PROBE)
    )
    half = 1 / (2 * _PROBE)
    zero = FinalErrors(np.zeros(3), np.zeros(3), np.zeros(3))
    return zero.plus(half, above).plus(-half, below)


def _rotation_vectors(data: SampledMotion, method: RotationVectorMethod) -> tuple[Array, Array]:
    """Return the rotation vectors of all steps and their dual parts as increments, (n, 3): one, then zeros, a step."""
    # Imported here: it loads the compiler, which the claims of the other paper do not need.
    from sinsbench.instrumentation import rebuilt_kernels

    kernels, coefficients, r = rebuilt_kernels(), binary64_coefficients(method), method.samples_per_step
    # The plain functions of the kernels take arrays for numbers: all steps at once.
    p, b = (tuple(tuple(array[i::r].T) for i in range(r)) for array in (data.angle, data.velocity))
    phi, phi_dual = np.zeros_like(data.angle), np.zeros_like(data.velocity)
    phi[::r] = np.transpose(kernels["rotation_vector"](p, coefficients))
    phi_dual[::r] = np.transpose(kernels["rotation_vector_dual"](p, b, coefficients))
    return phi, phi_dual


def scaled_errors(order: str, variant: str, motion: str) -> FinalErrors:
    """Return the errors if every rotation vector is scaled by 1 + `fitted_scale` of the motion."""
    return errors(order, variant, motion).plus(fitted_scale(motion), _scale_effect(order, variant, motion))


@dataclass(frozen=True)
class Cell:
    """A printed velocity error: order, motion, variant, axes, and the number, m/s."""

    order: str
    motion: str
    variant: str
    axes: str
    printed: float


@cache
def velocity_cells() -> tuple[Cell, ...]:
    """Return the printed velocity errors, shared ones once; without the cell that has its neighbour's number."""
    from sinsbench.claims.model import load_claims

    return tuple(
        Cell(a["order"], a["motion"], a["variants"][0], a["axes"], float(claim.printed))
        for claim in load_claims("lebedev1989")
        if "axes" in (a := claim.recompute.arguments) and not claim.slips
    )


def root_mean_square_log_ratio(cells: Mapping[Cell, float]) -> float:
    """Return the root mean square of ln(value/printed) over cells."""
    return float(np.sqrt(np.mean([np.log(value / cell.printed) ** 2 for cell, value in cells.items()])))


def cell_values(errors_of: Callable[[Cell], FinalErrors], cells: tuple[Cell, ...]) -> dict[Cell, float]:
    """Return the velocity error of each cell by a function that gives the errors of its run."""
    return {cell: errors_of(cell).velocity(cell.axes) for cell in cells}


@cache
def fitted_scale(motion: str) -> float:
    """Return the one scale error of a motion that best explains its printed velocity errors of both orders."""
    cells = tuple(cell for cell in velocity_cells() if cell.motion == motion)

    def misfit(parts_in_1e9: float) -> float:
        kappa = parts_in_1e9 * 1e-9

        def run(cell: Cell) -> FinalErrors:
            key = cell.order, cell.variant, cell.motion
            return errors(*key).plus(kappa, _scale_effect(*key))

        return root_mean_square_log_ratio(cell_values(run, cells))

    # A coarse scan first: the norms have a minimum for either sign of kappa.
    start = min(np.linspace(-20, 20, 81), key=misfit)
    best = minimize_scalar(misfit, bounds=(start - 0.5, start + 0.5), method="bounded", options={"xatol": 1e-4})
    return float(best.x) * 1e-9
