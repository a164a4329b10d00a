"""Strapdown integrators that fit polynomials to increments: power series, functional iteration, Magnus expansion.

Each method of `sinsbench.subjects.fitted_methods` is an integrator of this module under its own name and obeys the
contract of a subject,

    f(angle, velocity, interval, attitude0, velocity0) -> mapping of arrays.

Attitude and inertial velocity are sums with carried rounding errors. Compilation happens at the first call, and
importing this module does not import numba.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from sinsbench.subjects.fitted_methods import (
    FITTED_METHODS,
    Fit,
    FittedMethod,
    chebyshev_fit,
    chebyshev_integrals,
    iterate_degree,
    magnus_weights,
    power_fit,
)
from sinsbench.subjects.integrators import Array, Integrator, MotionState, checked_array, checked_inputs
from sinsbench.subjects.rotation_vector_methods import PANOV_6, binary64_coefficients

if TYPE_CHECKING:
    from sinsbench.subjects.fitted_kernels import FitTables
    from sinsbench.subjects.kernels import CompensatedState

__all__ = ["FITTED_INTEGRATORS", "MOST_TERMS", "FittedStreamingIntegrator", "fitted_integrator"]

MOST_TERMS = 400
"""Longest power series. Smooth motion takes 10 to 30 terms. A polynomial of high degree through noise swings far
beyond it and takes hundreds, and for ten samples noise of 0.003 rad in each is more than this length can follow."""


def _vector(numbers: Sequence[Fraction]) -> Array:
    return np.array([float(x) for x in numbers])


def _matrix(rows: Sequence[Sequence[Fraction]]) -> Array:
    return np.array([_vector(row) for row in rows]) if rows else np.empty((0, 0))


def _room(*shapes: tuple[int, ...]) -> tuple[Array, ...]:
    return tuple(np.zeros(shape) for shape in shapes)


@cache
def _exact_fit(samples: int, chebyshev: bool) -> Fit:
    return chebyshev_fit(samples) if chebyshev else power_fit(samples)


@cache
def _reciprocals(most: int, multiple: int = 1) -> tuple[float, ...]:
    """Return 1 / (multiple k) at place k, up to the one asked for; nothing is divided by k = 0."""
    return (0.0, *(float(Fraction(1, multiple * k)) for k in range(1, most + 1)))


@cache
def _integrals(samples: int) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in chebyshev_integrals(samples))


def _fit_tables(samples: int, chebyshev: bool = False) -> "FitTables":
    from sinsbench.subjects.fitted_kernels import FitTables

    fit = _exact_fit(samples, chebyshev)
    room = np.empty((samples + 1) // 2)
    return FitTables(_matrix(fit.even), _matrix(fit.odd), _vector(fit.mean), samples / 2, room)


def _series_tables(samples: int) -> Any:
    from sinsbench.subjects.fitted_series_kernels import SeriesTables

    reciprocals = np.array(_reciprocals(MOST_TERMS))
    shapes = ((samples + 1, 3), (samples + 1, 3), (samples, 2), (MOST_TERMS + 1, 2), (MOST_TERMS + 1, 8))
    return SeriesTables(_fit_tables(samples), reciprocals, *_room(*shapes))


def _iteration_tables(samples: int) -> Any:
    from sinsbench.subjects.fitted_iteration_kernels import IterationTables

    degree = iterate_degree(samples)
    inverses, integrals = np.array(_reciprocals(degree, 4)), np.array(_integrals(samples))
    vectors, longest = (samples + 1, 3), degree + 2 * samples - 1
    shapes = (vectors, vectors, (samples,), (longest, 4), (degree + 2, 4), (degree + 1, 4))
    return IterationTables(_fit_tables(samples, chebyshev=True), inverses, integrals, *_room(*shapes))


def _magnus_tables(samples: int, sixth: bool) -> Any:
    from sinsbench.subjects.fitted_magnus_kernels import MagnusTables

    # Of the coefficients of a rotation-vector method only the series of the elementary functions are looked at.
    constants = _vector(magnus_weights(samples)), sixth, binary64_coefficients(PANOV_6)
    return MagnusTables(_fit_tables(samples), *constants, *_room((samples + 1, 3), (samples + 1, 3)))


def _flow(method: FittedMethod) -> tuple[Callable[[Array, Array, Any, Array], int], Any]:
    """Return the kernel of a method and the tables that it works with; they serve one thread at a time."""
    if method.flow == "power series":
        from sinsbench.subjects.fitted_series_kernels import power_series

        return power_series, _series_tables(method.samples_per_step)
    if method.flow == "functional iteration":
        from sinsbench.subjects.fitted_iteration_kernels import functional_iteration

        return functional_iteration, _iteration_tables(method.samples_per_step)
    from sinsbench.subjects.fitted_magnus_kernels import magnus_expansion

    return magnus_expansion, _magnus_tables(method.samples_per_step, method.flow == "Magnus 6")


def _initial_state(attitude: Array, velocity: Array) -> "CompensatedState":
    q, w = attitude.tolist(), velocity.tolist()
    return (q[0], q[1], q[2], q[3]), (0.0, 0.0, 0.0, 0.0), (w[0], w[1], w[2]), (0.0, 0.0, 0.0)


class FittedStreamingIntegrator:
    """A method of polynomial fit that is fed one step at a time; its states are bit for bit those of the batch.

    Parameters
    ----------
    method : FittedMethod
        The method.
    attitude0 : array_like, shape (4,)
        Initial attitude, scalar-first quaternion from body to inertial axes.
    velocity0 : array_like, shape (3,)
        Initial apparent velocity in inertial axes, m/s.

    Raises
    ------
    ValueError
        If a shape is wrong or a value is not finite.
    """

    def __init__(self, method: FittedMethod, attitude0: ArrayLike, velocity0: ArrayLike) -> None:
        from sinsbench.subjects import fitted_kernels, kernels

        q, w = checked_array("attitude0", attitude0, (4,)), checked_array("velocity0", velocity0, (3,))
        self._method = method
        self._flow, self._tables = _flow(method)
        self._accumulate = fitted_kernels.accumulate
        self._carried = _initial_state(q, w)
        body = kernels.body_velocity(self._carried[0], self._carried[2])
        self._state = MotionState(q.copy(), w.copy(), np.array(body))

    @property
    def state(self) -> MotionState:
        """The state after the increments fed so far."""
        return self._state

    def update(self, angle: ArrayLike, velocity: ArrayLike) -> MotionState:
        """Advance by one step.

        Parameters
        ----------
        angle, velocity : array_like, shape (N, 3)
            Increments of the N samples of the step, rad and m/s.

        Returns
        -------
        MotionState
            The state at the end of the step.

        Raises
        ------
        ValueError
            If a shape is wrong, a value is not finite, or the step turns too far; the state is then unchanged.
        """
        samples = self._method.samples_per_step
        p, b = checked_array("angle", angle, (samples, 3)), checked_array("velocity", velocity, (samples, 3))
        gains = np.empty((1, 7))
        if not self._flow(p[np.newaxis], b[np.newaxis], self._tables, gains):
            raise ValueError(_too_far(self._method, p))
        attitude, inertial, body = (np.empty((1, columns)) for columns in (4, 3, 3))
        self._carried = self._accumulate(self._carried, gains, attitude, inertial, body)
        self._state = MotionState(attitude[0], inertial[0], body[0])
        return self._state


def _too_far(method: FittedMethod, angle: Array) -> str:
    turn = float(np.linalg.norm(angle, axis=1).sum())
    return f"{method.name} does not converge: its {len(angle)} samples turn by {turn:.3g} rad in all"


_CONTRACT = """Integrate attitude and apparent velocity: {summary}.

    Order {order} ({source}). Attitude and inertial velocity are sums with carried rounding errors (Kahan).

    Parameters
    ----------
    angle : array_like, shape (n, 3)
        Integrals of the body angular rate over each sample, rad. n is a multiple of {samples}.
    velocity : array_like, shape (n, 3)
        Integrals of the specific force, in body axes, over each sample, m/s.
    interval : float
        Sampling interval, s. Checked and otherwise unused: the increments are integrals already.
    attitude0 : array_like, shape (4,)
        Initial attitude, scalar-first quaternion from body to inertial axes.
    velocity0 : array_like, shape (3,)
        Initial apparent velocity in inertial axes, m/s.

    Returns
    -------
    dict of str to ndarray
        ``attitude`` (m+1, 4), ``velocity_inertial`` (m+1, 3) and ``velocity_body`` (m+1, 3), m/s, where
        m = n/{samples}; row 0 is the initial state.

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, the interval is not positive, n is not a multiple of {samples},
        or a step turns so far that the method does not converge.
    """


def fitted_integrator(method: FittedMethod) -> Integrator:
    """Make the integrator of a method of polynomial fit for attitude and apparent velocity.

    Parameters
    ----------
    method : FittedMethod
        The method.

    Returns
    -------
    callable
        ``f(angle, velocity, interval, attitude0, velocity0)``, the contract of
        `sinsbench.subjects.integrators.panov6`. It may be called from several threads.
    """
    samples = method.samples_per_step

    def integrate(
        angle: ArrayLike, velocity: ArrayLike, interval: float, attitude0: ArrayLike, velocity0: ArrayLike
    ) -> dict[str, Array]:
        p, b, q, w = checked_inputs(samples, angle, velocity, interval, attitude0, velocity0)
        from sinsbench.subjects import fitted_kernels, kernels

        flow, tables = _flow(method)
        p, b = p.reshape(-1, samples, 3), b.reshape(-1, samples, 3)
        gains = np.empty((len(p), 7))
        done = flow(p, b, tables, gains)
        if done < len(p):
            raise ValueError(f"step {done}: {_too_far(method, p[done])}")
        attitude, inertial, body = (np.empty((len(p) + 1, columns)) for columns in (4, 3, 3))
        state = _initial_state(q, w)
        attitude[0], inertial[0], body[0] = q, w, kernels.body_velocity(state[0], state[2])
        fitted_kernels.accumulate(state, gains, attitude[1:], inertial[1:], body[1:])
        return {"attitude": attitude, "velocity_inertial": inertial, "velocity_body": body}

    integrate.__name__ = integrate.__qualname__ = method.name
    integrate.__doc__ = _CONTRACT.format(
        summary=method.summary, order=method.order, source=method.source, samples=samples
    )
    return integrate


FITTED_INTEGRATORS: dict[str, Integrator] = {name: fitted_integrator(method) for name, method in FITTED_METHODS.items()}
"""The built-in integrators of this kind by name."""


def __getattr__(name: str) -> Integrator:
    if name in FITTED_INTEGRATORS:
        return FITTED_INTEGRATORS[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
