"""Strapdown integrators: attitude and apparent velocity from increments, by rotation-vector methods.

Every integrator obeys the contract of a subject,

    f(angle, velocity, interval, attitude0, velocity0) -> mapping of arrays,

and is made by one factory from a method of `sinsbench.subjects.rotation_vector_methods`. Compilation happens
at the first call, and importing this module does not import numba.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sinsbench.subjects.rotation_vector_methods import (
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


def checked_array(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    """Return `value` as a contiguous float64 array after checking its shape and that it is finite.

    Parameters
    ----------
    name : str
        Name for the messages.
    value : array_like
        The argument.
    shape : tuple
        Required shape; None admits any length.

    Returns
    -------
    ndarray
        The checked array.

    Raises
    ------
    ValueError
        If the shape is another one, or a value is NaN or infinite.
    """
    array = np.ascontiguousarray(value, dtype=np.float64)
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        wanted = " x ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} has shape {' x '.join(map(str, array.shape)) or 'scalar'}, expected {wanted}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} has values that are not finite")
    return array


def checked_inputs(
    samples_per_step: int,
    angle: ArrayLike,
    velocity: ArrayLike,
    interval: float,
    attitude0: ArrayLike,
    velocity0: ArrayLike,
) -> tuple[Array, Array, Array, Array]:
    """Check the five arguments of an integrator and return the four arrays among them.

    Parameters
    ----------
    samples_per_step : int
        Number of samples one step consumes.
    angle, velocity, interval, attitude0, velocity0
        As for `panov6`.

    Returns
    -------
    tuple of ndarray
        angle (n, 3), velocity (n, 3), attitude0 (4,), velocity0 (3,).

    Raises
    ------
    ValueError
        If a shape is wrong, a value is not finite, the interval is not positive, or n is not a multiple of
        `samples_per_step`.
    """
    if not (np.isfinite(interval) and interval > 0):
        raise ValueError(f"interval is {interval}, expected a positive number of seconds")
    angle = checked_array("angle", angle, (None, 3))
    velocity = checked_array("velocity", velocity, (angle.shape[0], 3))
    if angle.shape[0] % samples_per_step:
        raise ValueError(f"angle has {angle.shape[0]} samples, expected a multiple of {samples_per_step}")
    attitude0, velocity0 = (
        checked_array("attitude0", attitude0, (4,)),
        checked_array("velocity0", velocity0, (3,)),
    )
    return angle, velocity, attitude0, velocity0


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


def _document(function: Any, method: RotationVectorMethod, suffix: str, what: str, returns: str) -> None:
    samples, name = method.samples_per_step, method.name + suffix
    more = _COMPENSATED if suffix == "_compensated" else ""
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
        like = ((0.0, 0.0, 0.0),) * samples
        run(state, p, b, like, coefficients, attitude[1:], inertial[1:], body[1:])
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
        like = ((0.0, 0.0, 0.0),) * samples
        _kernels().integrate_attitude(tuple(q.tolist()), p, like, coefficients, attitude[1:])
        return {"attitude": attitude}

    _document(integrate, method, "_attitude", "attitude alone", _ATTITUDE)
    return integrate


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
    ) -> None:
        q, w = checked_array("attitude0", attitude0, (4,)), checked_array("velocity0", velocity0, (3,))
        kernels = _kernels()
        self._samples = method.samples_per_step
        self._coefficients = binary64_coefficients(method)
        self._compensated = compensated
        self._step = kernels.compensated_step if compensated else kernels.step
        self._body_velocity = kernels.body_velocity
        self._state = _initial_state(q, w, compensated)

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
        increments = tuple(map(tuple, p.tolist())), tuple(map(tuple, b.tolist()))
        self._state = self._step(self._state, *increments, self._coefficients)
        return self.state


panov2 = integrator(PANOV_2)
panov4 = integrator(PANOV_4)
panov6 = integrator(PANOV_6)
panov2_compensated = integrator(PANOV_2, compensated=True)
panov4_compensated = integrator(PANOV_4, compensated=True)
panov6_compensated = integrator(PANOV_6, compensated=True)

INTEGRATORS: dict[str, Integrator] = {
    function.__name__: function
    for function in (panov2, panov4, panov6, panov2_compensated, panov4_compensated, panov6_compensated)
}
"""The built-in integrators by name."""
