"""A strapdown integrator of one's own: the two-sample coning algorithm, attitude only."""

import numpy as np


def rotation(vector):
    """Return the quaternion, scalar first, of a rotation vector."""
    angle = np.linalg.norm(vector)
    return np.array([np.cos(angle / 2), *(np.sinc(angle / (2 * np.pi)) / 2 * vector)])


def product(a, b):
    """Return the Hamilton product."""
    scalar = a[0] * b[0] - a[1:] @ b[1:]
    return np.array([scalar, *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def two_sample(angle, velocity, interval, attitude0, velocity0):
    """Integrate increments (n, 3), two a step, to attitudes (n/2 + 1, 4)."""
    attitude = [attitude0]
    for first, second in angle.reshape(-1, 2, 3):
        step = first + second + 2 / 3 * np.cross(first, second)
        attitude.append(product(attitude[-1], rotation(step)))
    return np.array(attitude)
