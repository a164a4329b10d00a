"""A strapdown integrator of one's own for samples of different lengths: two-sample coning, attitude only."""

import numpy as np


def product(a, b):
    """Return the Hamilton product of two quaternions, scalar first."""
    scalar = a[0] * b[0] - a[1:] @ b[1:]
    return np.array([scalar, *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def two_unequal_samples(angle, velocity, time, attitude0, velocity0):
    """Integrate increments (n, 3) between the times (n+1), two a step, to attitudes (n/2 + 1, 4)."""
    first, second = angle[::2], angle[1::2]
    a, b = np.diff(time)[::2, None], np.diff(time)[1::2, None]
    # The angular rate through both increments is linear in time; for samples of one length the factor is 2/3.
    vector = first + second + (a + b) ** 2 / (6 * a * b) * np.cross(first, second)
    size = np.linalg.norm(vector, axis=1, keepdims=True)
    steps = np.hstack([np.cos(size / 2), np.sinc(size / (2 * np.pi)) / 2 * vector])
    attitude = [attitude0]
    for step in steps:
        attitude.append(product(attitude[-1], step))
    return np.array(attitude)


two_unequal_samples.takes = "nonuniform"
two_unequal_samples.samples_per_step = 2
