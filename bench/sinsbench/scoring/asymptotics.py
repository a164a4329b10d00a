r"""Accumulated error of the nested algorithms on dual regular precession, to leading order in the sampling interval.

One step of order :math:`\rho` with r = 4 samples errs by (exact minus computed)

.. math:: \delta_\rho h^{\rho+1} (B u + A z), \qquad u = (\sin\nu t_m, \cos\nu t_m, 0),

with :math:`A = \varepsilon\nu^{\rho+1}\sin^2\vartheta\, f_\rho` and
:math:`B = \varepsilon\nu^{\rho+1}\sin\vartheta\, g_\rho`. The steps add up to closed forms in the precession
frame. Dual parts of f and g follow from f and g by the transfer principle.

Source: Lebedev, Panov 1989, section 5, with (5.3)-(5.6) corrected; f and g of order 6, which the paper does
not give, are derived here from the leading local error (2.4).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sinsref.arithmetic import MpArithmetic
from sinsref.precession import DualPrecession, frame_offset
from sinsref.quaternion import conjugate, rotate

__all__ = ["ORDERS", "PredictedError", "predicted_error"]

Array = NDArray[np.float64]
_Polynomial = Mapping[tuple[int, int], int]

_SAMPLES_PER_STEP = 4

_DELTA = {2: Fraction(16, 3), 4: Fraction(16, 45), 6: Fraction(8, 945)}

# Polynomials as {(power of eps, power of cos theta): coefficient}.
_F: Mapping[int, _Polynomial] = {
    2: {(1, 0): -1},
    4: {(3, 0): -4, (2, 1): -24, (1, 0): -23},
    6: {(5, 0): -64, (4, 1): -576, (3, 2): -1630, (3, 0): 116, (2, 1): -1660, (1, 0): -745},
}
_G: Mapping[int, _Polynomial] = {
    2: {(0, 0): 1, (1, 1): 1},
    4: {(3, 1): 4, (2, 2): 24, (2, 0): -8, (1, 1): 19, (0, 0): 7},
    6: {
        (5, 1): 64, (4, 2): 576, (4, 0): -192, (3, 3): 1630, (3, 1): -768, (2, 2): 1808, (2, 0): -892,
        (1, 1): 463, (0, 0): 89,
    },
}  # fmt: skip

ORDERS = tuple(_DELTA)
"""Orders of the nested algorithms."""


@dataclass(frozen=True)
class PredictedError:
    """Leading term of the accumulated error, computed minus true, in the precession frame.

    Attributes
    ----------
    attitude : ndarray, shape (n, 3)
        alpha(t), rad: (5.3) corrected.
    attitude_dual : ndarray, shape (n, 3)
        alpha0(t), the dual part of alpha, m/s: (5.4) corrected.
    velocity_inertial, velocity_body : ndarray, shape (n, 3)
        Errors of the apparent velocity, m/s: that of the components in inertial and in body axes, both
        turned into the precession frame. Their norms are those in their own axes.
    """

    attitude: Array
    attitude_dual: Array
    velocity_inertial: Array
    velocity_body: Array


def _value(polynomial: _Polynomial, eps: float, cosine: float) -> float:
    return sum(k * eps**i * cosine**j for (i, j), k in polynomial.items())


def _slope(polynomial: _Polynomial, eps: float, cosine: float) -> float:
    """Return the derivative with respect to cos theta, which the transfer principle turns into the dual part."""
    return sum(k * eps**i * j * cosine ** (j - 1) for (i, j), k in polynomial.items() if j)


def predicted_error(motion: DualPrecession, order: int, interval: float, time: ArrayLike) -> PredictedError:
    """Predict the error of the nested algorithm of an order, started without error.

    Parameters
    ----------
    motion : DualPrecession
        The motion.
    order : {2, 4, 6}
        Order of the algorithm.
    interval : float
        Sampling interval h, a quarter of the step, s.
    time : array_like, shape (n,)
        Times, s.

    Returns
    -------
    PredictedError

    Raises
    ------
    ValueError
        If there is no algorithm of that order.
    """
    if order not in _DELTA:
        raise ValueError(f"order = {order}: the nested algorithms have the orders 2, 4 and 6")
    times = np.asarray(time, np.float64)
    ar = MpArithmetic(30)
    nu, eps, theta = (float(x) for x in motion.principal(ar))
    nu_dual, _, theta_dual = (float(x) for x in motion.dual(ar))
    if eps == 0 or nu == 0:  # rotation about a fixed axis: every method is exact, and w below would not vary
        zero = np.zeros((times.size, 3))
        return PredictedError(zero, zero, zero, zero)
    sin, cos = np.sin(theta), np.cos(theta)
    f, g = _value(_F[order], eps, cos), _value(_G[order], eps, cos)
    f_dual, g_dual = (-theta_dual * sin * _slope(table[order], eps, cos) for table in (_F, _G))

    scale = eps * nu**order
    A, B = scale * nu * sin**2 * f, scale * nu * sin * g
    growth = (order + 1) * nu_dual
    A_dual = scale * ((growth * sin**2 + nu * theta_dual * np.sin(2 * theta)) * f + nu * sin**2 * f_dual)
    B_dual = scale * ((growth * sin + nu * theta_dual * cos) * g + nu * sin * g_dual)

    horizontal = B * cos - A * sin
    horizontal_dual = B_dual * cos - B * theta_dual * sin - A_dual * sin - A * theta_dual * cos
    secular = B * sin + A * cos
    secular_dual = (A_dual + B * theta_dual) * cos + (B_dual - A * theta_dual) * sin
    w = eps * nu * times
    # Minus: the paper's differences are exact minus computed.
    K = -float(_DELTA[order]) * interval**order / _SAMPLES_PER_STEP
    k, q = (horizontal_dual - horizontal * nu_dual / nu) / (eps * nu), horizontal * nu_dual / nu
    alpha = K * np.column_stack(
        [horizontal / (eps * nu) * (np.cos(w) - 1), horizontal / (eps * nu) * np.sin(w), secular * times]
    )
    alpha_dual = K * np.column_stack(
        [
            k * (np.cos(w) - 1) - q * times * np.sin(w),
            k * np.sin(w) + q * times * np.cos(w),
            secular_dual * times,
        ]
    )
    travelled = np.column_stack(  # U_I of (4.7)
        [
            nu_dual * times * sin * np.sin(w) + theta_dual * np.cos(w),
            -nu_dual * times * sin * np.cos(w) + theta_dual * np.sin(w),
            nu_dual * times * (eps + cos),
        ]
    )
    offset = frame_offset(ar, motion)
    start = rotate(conjugate(offset), [ar.number(x) for x in motion.initial_velocity])
    # C_I of (1.11), corrected, in the precession frame.
    constant = np.array([float(x) for x in start]) - np.array([theta_dual, 0.0, 0.0])
    return PredictedError(
        attitude=alpha,
        attitude_dual=alpha_dual,
        velocity_inertial=alpha_dual - np.cross(travelled, alpha),
        velocity_body=alpha_dual + np.cross(constant, alpha),
    )
