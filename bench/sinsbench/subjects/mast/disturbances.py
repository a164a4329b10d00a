"""How noise enters the mast's equations: F_1, H_1 and Theta, as compiled functions.

The noise of the process is W = (W_d1, W_a1, W_a2, w_J), that of the measurements (w_J, W_d1, W_d2, W_V, W_R), each
sensor showing its true value plus W. The printed paper leaves F_1 open; it follows from (3.14) by putting Z - W for
the true values.
"""

import numpy as np
from numpy.typing import NDArray

from sinsbench.subjects.gyroscopic.equations import quaternion
from sinsbench.subjects.kernels import scale
from sinsbench.subjects.mast.jacobians import add_product_columns, put_column
from sinsbench.subjects.mast.model import (
    ETA,
    LAMBDA,
    LATITUDE,
    LONGITUDE,
    MU,
    RATE,
    STATES,
    VELOCITY,
    Constants,
    axis,
    back,
    inner,
    leverage,
    resolved,
    to_local,
)
from sinsbench.subjects.mast.terms import Terms

__all__ = ["NOISES", "noise_gain", "shared_noise"]

Array = NDArray[np.float64]

NOISES = 12
"""Length of W."""


@inner
def noise_gain(state: Array, t: float, driven: float, terms: Terms, constants: Constants, out: Array) -> None:
    """F_1 of (3.14).

    Parameters
    ----------
    state : ndarray, shape (20,)
    t : float
        Time, s.
    driven : float
        As for `sinsbench.subjects.mast.model.state_rates`. With 1 the last three columns belong to W_d2 instead of w_J:
        the rate that drives eta holds the noise of the gyroscopes.
    terms : Terms
    constants : Constants
    out : ndarray, shape (20, 12)
        Receives it.
    """
    for i in range(STATES):
        for j in range(NOISES):
            out[i, j] = 0.0
    mu, eta, lam = quaternion(state, MU), quaternion(state, ETA), quaternion(state, LAMBDA)
    angle, latitude = state[LONGITUDE] + constants.earth_rate * t, state[LATITUDE]
    absolute, per_length = 1.0 - terms.relative, leverage(terms, constants)
    x, y = terms.mast_x * per_length, terms.mast_y * per_length
    for k in range(3):
        unit = axis(k)
        add_product_columns(out, MU, k, mu, scale(-1.0, unit))
        put_column(out, VELOCITY, 3 + k, scale(-1.0, to_local(angle, latitude, back(mu, unit))))
        turned = resolved(lam, unit)
        add_product_columns(out, LAMBDA, k, lam, (absolute * turned[0], absolute * turned[1], 0.0))
        carried = (terms.relative * turned[0], terms.relative * turned[1], turned[2])
        add_product_columns(out, ETA, k, eta, scale(driven, resolved(eta, carried)))
        add_product_columns(out, ETA, 9 + k, eta, scale(1.0 - 2.0 * driven, unit))
        turn = (1.0 - terms.earth_turn) * turned[2]
        out[RATE, k] = -terms.turn_x * state[RATE + 1] * turn
        out[RATE + 1, k] = -terms.turn_y * state[RATE] * turn
        away = back(eta, unit)
        out[RATE, 3 + k] = x * turned[1]
        out[RATE + 1, 3 + k] = y * turned[0]
        out[RATE, 6 + k] = -x * away[1]
        out[RATE + 1, 6 + k] = -y * away[0]


@inner
def shared_noise(
    state: Array, gain: Array, rate1: float, antenna: float, rate2: float, terms: Terms, theta: Array, inverse: Array
) -> None:
    """Theta = F_1 E[W V^T] H_1^T of (3.18), and the inverse of S = H_1 D_H H_1^T, for the three rates of (3.15).

    H_1 is (1, -D(eta) M D(lambda), 1) with M = diag(0, 0, 1), or the unit matrix where the state holds relative rates.

    Parameters
    ----------
    state : ndarray, shape (20,)
    gain : ndarray, shape (20, 12)
        F_1, not driven.
    rate1, antenna, rate2 : float
        Intensities of W_d1, w_J and W_d2, rad^2/s.
    terms : Terms
    theta : ndarray, shape (20, 3)
        Receives Theta.
    inverse : ndarray, shape (3, 3)
        Receives S^-1.
    """
    eta, lam = quaternion(state, ETA), quaternion(state, LAMBDA)
    for k in range(3):
        unit = axis(k)
        # Row k of D(eta) M D(lambda).
        row = back(eta, unit)
        row = back(lam, (terms.relative * row[0], terms.relative * row[1], row[2]))
        for i in range(STATES):
            shared = gain[i, 0] * row[0] + gain[i, 1] * row[1] + gain[i, 2] * row[2]
            theta[i, k] = antenna * gain[i, 9 + k] - rate1 * shared
    # D(eta) M M^T D(eta)^T has the eigenvalue 1 along the mast and `relative` across it.
    across = 1.0 / (antenna + rate2 + rate1 * terms.relative)
    along = 1.0 / (antenna + rate2 + rate1)
    mast = resolved(eta, (0.0, 0.0, 1.0))
    for i in range(3):
        for j in range(3):
            inverse[i, j] = across * (1.0 if i == j else 0.0) + (along - across) * mast[i] * mast[j]
