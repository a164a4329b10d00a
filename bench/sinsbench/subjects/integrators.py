"""Strapdown integrators: attitude and apparent velocity from increments, by rotation-vector methods.

Every integrator obeys the contract of a subject,

    f(angle, velocity, interval, attitude0, velocity0) -> mapping of arrays,

and is made by one factory from a method of `sinsbench.subjects.rotation_vector_methods` or
`sinsbench.subjects.published_methods`; all built-in ones are attributes of this module. Compilation happens at the
first call, and importing this module does not import numba.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sinsbench.subjects.increments import checked_array, checked_inputs, extrapolated_start
from sinsbench.subjects.published_methods import PUBLISHED_METHODS
from sinsbench.subjects.rotation_vector_methods import (
    METHODS,
    PANOV_2,
    PANOV_4,
    PANOV_6,
    RotationVectorMethod,
    binary64_coefficients,
)

if TYPE_CHECKING:
    from types import ModuleType

__all__ = [
    "INTEGRATORS",
    "Integrator",
    "MotionState",
    "StreamingIntegrator",
    "attitude_only",
    "checked_array",
    "checked_inputs",
    "extrapolated_start",
    "integrator",
    "panov2",
    "panov2_compensated",
    "panov4",
    "panov4_compensated",
    "panov6",
    "panov6_compensated",
]

Array = NDArray[np.float64]
Integrator = Callable[[ArrayLike, ArrayLike, float, ArrayLike, ArrayLike], dict[str, Array]]


def _kernels() -> "ModuleType":
    from sinsbench.subjects import kernels

    return kernels


_COMMON_WINDOW = max(method.window for method in (*PUBLISHED_METHODS.values(), *METHODS.values()))


def _like(method: RotationVectorMethod) -> tuple[tuple[float, ...], ...]:
    """Return increments of the length that kernels are compiled for: one length for all built-in methods."""
    return ((0.0, 0.0, 0.0),) * max(method.window, _COMMON_WINDOW)


def _with_earlier(method: RotationVectorMethod, increments: Array) -> Array:
    if not method.history:
        return increments
    return np.vstack([extrapolated_start(increments, method.history), increments])


_CONTRACT = """

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
        {returns}

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, the interval is not positive, or n is not a multiple
        of {samples}.
    """
_ALL = """``attitude`` (m+1, 4), ``velocity_inertial`` (m+1, 3) and ``velocity_body`` (m+1, 3), m/s, where
        m = n/{samples}; row 0 is the initial state."""
_ATTITUDE = "``attitude`` (m+1, 4), where m = n/{samples}; row 0 is the initial attitude."
_COMPENSATED = """

    Attitude and inertial velocity are sums with carried rounding errors (Kahan). That lowers the rounding
    floor of the velocity by orders of magnitude and keeps the quaternion norm; the floor of the attitude is
    set by the rounding of the increments and stays."""
_REMEMBERS = """

    It remembers the last sample or samples of the step before. Those before the first step are extrapolated, see
    `extrapolated_start`."""
_CLASSICAL = """

    The velocity, of order {order}, has a power series in place of the exact rotation correction."""


def _document(function: Any, method: RotationVectorMethod, suffix: str, what: str, returns: str) -> None:
    samples, name = method.samples_per_step, method.name + suffix
    more = "".join(
        text
        for text, applies in (
            (_COMPENSATED, suffix == "_compensated"),
            (_REMEMBERS, method.history),
            (_CLASSICAL.format(order=method.order_velocity), method.velocity_rule != "transfer"),
        )
        if applies
    )
    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"Integrate {what}, order {method.order} ({method.source}).{more}" + _CONTRACT.format(
        samples=samples, returns=returns.format(samples=samples)
    )


def integrator(method: RotationVectorMethod, *, compensated: bool = False) -> Integrator:
    """Make the integrator of a method for attitude and apparent velocity.

    Parameters
    ----------
    method : RotationVectorMethod
        The method.
    compensated : bool
        Accumulate attitude and inertial velocity with carried rounding errors.

    Returns
    -------
    callable
        ``f(angle, velocity, interval, attitude0, velocity0)``, see `panov6`.
    """
    coefficients = binary64_coefficients(method)
    samples = method.samples_per_step

    def integrate(
        angle: ArrayLike, velocity: ArrayLike, interval: float, attitude0: ArrayLike, velocity0: ArrayLike
    ) -> dict[str, Array]:
        p, b, q, w = checked_inputs(samples, angle, velocity, interval, attitude0, velocity0)
        kernels = _kernels()
        run = kernels.integrate_compensated if compensated else kernels.integrate
        steps = p.shape[0] // samples
        attitude, inertial, body = (np.empty((steps + 1, columns)) for columns in (4, 3, 3))
        state = _initial_state(q, w, compensated)
        attitude[0], inertial[0], body[0] = q, w, kernels.body_velocity(tuple(q.tolist()), tuple(w.tolist()))
        p, b = _with_earlier(method, p), _with_earlier(method, b)
        run(state, p, b, _like(method), coefficients, attitude[1:], inertial[1:], body[1:])
        return {"attitude": attitude, "velocity_inertial": inertial, "velocity_body": body}

    suffix = "_compensated" if compensated else ""
    _document(integrate, method, suffix, "attitude and apparent velocity", _ALL)
    return integrate


def attitude_only(method: RotationVectorMethod) -> Integrator:
    """Make the integrator of a method for attitude alone, the fastest path.

    Parameters
    ----------
    method : RotationVectorMethod
        The method.

    Returns
    -------
    callable
        ``f(angle, velocity, interval, attitude0, velocity0)`` that returns ``attitude`` only, bit for bit
        that of the full integrator. The velocities are checked and otherwise ignored.
    """
    coefficients = binary64_coefficients(method)
    samples = method.samples_per_step

    def integrate(
        angle: ArrayLike, velocity: ArrayLike, interval: float, attitude0: ArrayLike, velocity0: ArrayLike
    ) -> dict[str, Array]:
        p, _, q, _ = checked_inputs(samples, angle, velocity, interval, attitude0, velocity0)
        attitude = np.empty((p.shape[0] // samples + 1, 4))
        attitude[0] = q
        p = _with_earlier(method, p)
        _kernels().integrate_attitude(tuple(q.tolist()), p, _like(method), coefficients, attitude[1:])
        return {"attitude": attitude}

    _document(integrate, method, "_attitude", "attitude alone", _ATTITUDE)
    return integrate


def _tuples(vectors: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, vectors.tolist()))


def _initial_state(attitude: Array, velocity: Array, compensated: bool) -> tuple[tuple[float, ...], ...]:
    q, w = tuple(attitude.tolist()), tuple(velocity.tolist())
    if compensated:
        return q, (0.0,) * 4, w, (0.0,) * 3
    return q, w, _kernels().body_velocity(q, w)


class MotionState(NamedTuple):
    """State of a `StreamingIntegrator`.

    Attributes
    ----------
    attitude : ndarray, shape (4,)
        Scalar-first quaternion from body to inertial axes.
    velocity_inertial, velocity_body : ndarray, shape (3,)
        Apparent velocity in inertial and in body axes, m/s.
    """

    attitude: Array
    velocity_inertial: Array
    velocity_body: Array


class StreamingIntegrator:
    """An integrator that is fed one step at a time; its states are bit for bit those of the batch integrator.

    Parameters
    ----------
    method : RotationVectorMethod
        The method.
    attitude0 : array_like, shape (4,)
        Initial attitude, scalar-first quaternion from body to inertial axes.
    velocity0 : array_like, shape (3,)
        Initial apparent velocity in inertial axes, m/s.
    compensated : bool
        Accumulate attitude and inertial velocity with carried rounding errors.
    earlier : pair of array_like, shape (method.history, 3), optional
        Angle and velocity increments of the samples before the first, oldest first, for a method that remembers
        samples. Zeros by default, which leaves a constant attitude error of third order in the sampling interval;
        the batch integrator, which sees the samples that follow, has `extrapolated_start` of them.

    Raises
    ------
    ValueError
        If a shape is wrong or a value is not finite.
    """

    def __init__(
        self,
        method: RotationVectorMethod,
        attitude0: ArrayLike,
        velocity0: ArrayLike,
        compensated: bool = False,
        earlier: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> None:
        q, w = checked_array("attitude0", attitude0, (4,)), checked_array("velocity0", velocity0, (3,))
        kernels = _kernels()
        self._samples = method.samples_per_step
        self._coefficients = binary64_coefficients(method)
        self._compensated = compensated
        self._step = kernels.compensated_step if compensated else kernels.step
        self._body_velocity = kernels.body_velocity
        self._state = _initial_state(q, w, compensated)
        before = (np.zeros((method.history, 3)),) * 2 if earlier is None else earlier
        angle, velocity = (checked_array("earlier", array, (method.history, 3)) for array in before)
        self._earlier = _tuples(angle), _tuples(velocity)
        self._surplus = _like(method)[method.window :]

    @property
    def state(self) -> MotionState:
        """The state after the increments fed so far."""
        if self._compensated:
            attitude, _, inertial, _ = self._state
            body = self._body_velocity(attitude, inertial)
        else:
            attitude, inertial, body = self._state
        return MotionState(np.array(attitude), np.array(inertial), np.array(body))

    def update(self, angle: ArrayLike, velocity: ArrayLike) -> MotionState:
        """Advance by one step.

        Parameters
        ----------
        angle, velocity : array_like, shape (r, 3)
            Increments of the r samples of the step, rad and m/s.

        Returns
        -------
        MotionState
            The state at the end of the step.

        Raises
        ------
        ValueError
            If a shape is wrong or a value is not finite; the state is then unchanged.
        """
        p = checked_array("angle", angle, (self._samples, 3))
        b = checked_array("velocity", velocity, (self._samples, 3))
        angles, velocities = self._earlier[0] + _tuples(p), self._earlier[1] + _tuples(b)
        increments = angles + self._surplus, velocities + self._surplus
        self._state = self._step(self._state, *increments, self._coefficients)
        self._earlier = angles[self._samples :], velocities[self._samples :]
        return self.state


panov2 = integrator(PANOV_2)
panov4 = integrator(PANOV_4)
panov6 = integrator(PANOV_6)
panov2_compensated = integrator(PANOV_2, compensated=True)
panov4_compensated = integrator(PANOV_4, compensated=True)
panov6_compensated = integrator(PANOV_6, compensated=True)

INTEGRATORS: dict[str, Integrator] = {
    **{name: integrator(method) for name, method in PUBLISHED_METHODS.items()},
    **{
        function.__name__: function
        for function in (panov2, panov4, panov6, panov2_compensated, panov4_compensated, panov6_compensated)
    },
}
"""The built-in integrators by name."""


def __getattr__(name: str) -> Integrator:
    if name in INTEGRATORS:
        return INTEGRATORS[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
