"""A strapdown integrator of one's own: the two-sample coning algorithm, attitude only."""

import numpy as np


def two_sample(angle, velocity, interval, attitude0, velocity0):
    """Integrate increments (n, 3), two a step, to attitudes (n/2 + 1, 4)."""
    first, second = angle[::2], angle[1::2]
    vectors = first + second + 2 / 3 * np.cross(first, second)
    half = np.linalg.norm(vectors, axis=1, keepdims=True) / 2
    rotations = np.hstack([np.cos(half), np.sinc(half / np.pi) / 2 * vectors])
    w, x, y, z = attitude0.tolist()
    attitude = [(w, x, y, z)]
    for a, b, c, d in rotations.tolist():
        w, x, y, z = (
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        )
        attitude.append((w, x, y, z))
    return np.array(attitude)


two_sample.samples_per_step = 2
