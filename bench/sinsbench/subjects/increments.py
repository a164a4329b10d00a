"""Increments as an integrator is given them: checked, and continued to before the first."""

from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["checked_array", "checked_inputs", "extrapolated_start", "finite_over_time"]

Array = NDArray[np.float64]


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


def finite_over_time(name: str, values: ArrayLike, shape: tuple[int, ...], time: Array) -> Array:
    """Return `values` as a contiguous float64 array after checking its shape and that each row is finite.

    Parameters
    ----------
    name : str
        Name for the messages.
    values : array_like
        The argument, a row an instant.
    shape : tuple of int
        Required shape.
    time : ndarray
        Instants of the rows, s.

    Raises
    ------
    ValueError
        If the shape is another one, or a value is NaN or infinite: it says at which time first.
    """
    array = np.ascontiguousarray(values, np.float64)
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
    finite = np.isfinite(array.reshape(len(array), -1)).all(axis=1)
    if not finite.all():
        raise ValueError(f"{name} is not finite, first at t = {time[int(np.argmin(finite))]:.9g} s")
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
        As for `sinsbench.subjects.integrators.panov6`.

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


_STARTING_SAMPLES = 3


def extrapolated_start(increments: Array, count: int) -> Array:
    """Continue increments to the samples before the first, by the parabola through the first three.

    A method that remembers samples needs some before its first step, and the contract of an integrator has none.
    Zeros would leave an attitude error that never goes away, of third order in the interval; what the parabola
    leaves is of fifth order.

    Parameters
    ----------
    increments : ndarray, shape (n, 3)
        Increments from the first on. With less than three of them the polynomial has as many terms as there are.
    count : int
        Number of samples wanted.

    Returns
    -------
    ndarray, shape (count, 3)
        Increments of the samples before the first, oldest first.
    """
    rows = increments[:_STARTING_SAMPLES]
    for _ in range(count):
        terms = min(len(rows), _STARTING_SAMPLES)
        weights = [(-1) ** k * comb(terms, k + 1) for k in range(terms)]
        rows = np.vstack([np.einsum("k,ki->i", weights, rows[:terms]), rows])
    return rows[:count]
