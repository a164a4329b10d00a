"""Errors of computed values against truth that is known to twice the working precision.

Truth comes in pairs of binary64 ``(x, x_lo)`` that stand for ``x + x_lo``. Every error is computed minus true.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["attitude_error_vectors", "difference", "rotated"]

Array = NDArray[np.float64]


def difference(computed: ArrayLike, truth: ArrayLike, truth_lo: ArrayLike) -> Array:
    """Return computed minus ``truth + truth_lo``, in the unit of the arguments.

    Parameters
    ----------
    computed, truth, truth_lo : array_like
        Arrays of one shape.

    Returns
    -------
    ndarray
        Correct to a rounding or two, however close the values: the first subtraction is exact where it cancels.
    """
    result: Array = (np.asarray(computed, np.float64) - np.asarray(truth, np.float64)) - np.asarray(
        truth_lo, np.float64
    )
    return result


def attitude_error_vectors(computed: ArrayLike, truth: ArrayLike, truth_lo: ArrayLike) -> Array:
    """Return the rotation from the true to the computed attitude as vectors in inertial axes.

    To first order the vector is alpha = 2 vect(Lambda o conj(Lambda*)), eq. (5.2) of Lebedev, Panov 1989, with the
    order of the factors corrected; large errors are measured by their true angle.

    Parameters
    ----------
    computed : array_like, shape (n, 4)
        Quaternions, scalar first, body to inertial. Their sign and norm do not matter.
    truth, truth_lo : array_like, shape (n, 4)
        True unit quaternions.

    Returns
    -------
    ndarray, shape (n, 3)
        Rotation vectors, rad, of length at most pi; NaN where a computed quaternion is zero.

    Raises
    ------
    ValueError
        If the shapes differ or are not (n, 4).
    """
    quaternion, star, star_lo = (np.asarray(x, np.float64) for x in (computed, truth, truth_lo))
    if not (quaternion.shape == star.shape == star_lo.shape) or quaternion.ndim != 2 or quaternion.shape[1] != 4:
        raise ValueError(
            f"attitudes of shapes {quaternion.shape}, {star.shape}, {star_lo.shape}: three (n, 4) are needed"
        )
    side = np.where(np.sum(quaternion * star, axis=1, keepdims=True) < 0, -1.0, 1.0)
    delta = difference(side * quaternion, star, star_lo)
    # Lambda o conj(Lambda*) = 1 + delta o conj(Lambda*): its vector part comes from delta alone, free of cancellation.
    scalar, vector = star[:, :1], star[:, 1:]
    error = delta[:, 1:] * scalar - delta[:, :1] * vector - np.cross(delta[:, 1:], vector)
    cosine = 1 + np.sum(delta * star, axis=1, keepdims=True)
    sine = np.linalg.norm(error, axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(sine > 0, 2 * np.arctan2(sine, cosine) / sine, 2 / np.where(cosine > 0, cosine, np.nan))
    vectors: Array = np.where(np.any(quaternion != 0, axis=1, keepdims=True), factor * error, np.nan)
    return vectors


def rotated(attitude: NDArray[Any], vectors: NDArray[Any]) -> Array:
    """Return body vectors in inertial axes, vect(Lambda o v o conj(Lambda)), for unit quaternions.

    Parameters
    ----------
    attitude : ndarray, shape (..., 4)
    vectors : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3)
    """
    axis = attitude[..., 1:]
    twice = 2 * np.cross(axis, vectors)
    result: Array = vectors + attitude[..., :1] * twice + np.cross(axis, twice)
    return result
