"""A solver of one's own for the error equations on the equator: the matrix exponential, row by row."""

import numpy as np
from scipy.linalg import expm

EARTH_RATE, RADIUS, GRAVITY = 7.29e-5, 6378245.0, 9.78049  # rad/s, m, m/s^2


def exponential(time, v_east, height, initial_errors):
    """Return dv_N, dv_H, dv_E (m/s), dH (m), dphi, dlambda (rad) at each time: (n, 6)."""
    r = RADIUS + height
    g = GRAVITY * (RADIUS / r) ** 2
    turn = v_east / r
    force = g - v_east * (2 * EARTH_RATE + turn)
    matrix = np.zeros((6, 6))
    matrix[0, 4] = -g
    matrix[1, 2], matrix[1, 3] = 2 * (EARTH_RATE + turn), 2 * g / r - turn**2
    matrix[2, 1], matrix[2, 5] = -(2 * EARTH_RATE + turn), -force
    matrix[3, 1] = 1
    matrix[4, 0] = matrix[5, 2] = 1 / r
    matrix[5, 3] = -turn / r
    return np.array([expm(matrix * t) @ initial_errors for t in time])
