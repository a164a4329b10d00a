"""A strapdown integrator of one's own that takes point values: Runge-Kutta of order 4, two samples a step."""

import numpy as np


def product(a, b):
    """Return the Hamilton products of quaternions (..., 4), scalar first."""
    scalar, vector = a[..., :1], a[..., 1:]
    real = scalar * b[..., :1] - np.sum(vector * b[..., 1:], axis=-1, keepdims=True)
    return np.concatenate([real, scalar * b[..., 1:] + b[..., :1] * vector + np.cross(vector, b[..., 1:])], axis=-1)


def turned(q, vector):
    """Return q o vector o conj(q)."""
    pure = np.insert(vector, 0, 0, axis=-1)
    return product(product(q, pure), q * [1, -1, -1, -1])[..., 1:]


def runge_kutta(rate, force, interval, attitude0, velocity0):
    """Integrate angular rate and specific force at instants (n+1, 3) to attitudes and velocities at every other one."""
    h = 2 * interval
    one = np.array([1.0, 0, 0, 0])
    (w0, w1, w2), (f0, f1, f2) = ((x[:-1:2], x[1::2], x[2::2]) for x in (rate, force))
    # 2 q' = q o w and v' = q o f o conj(q) are solved from q = 1, v = 0 in each step, for all steps at once.
    stages, slopes = [np.broadcast_to(one, (len(w0), 4))], []
    for w, part in ((w0, h / 2), (w1, h / 2), (w1, h), (w2, 0)):
        slopes.append(product(stages[-1], np.insert(w, 0, 0, axis=1)) / 2)
        stages.append(one + part * slopes[-1])
    weights = np.array([1, 2, 2, 1]) * h / 6
    steps = one + sum(weight * slope for weight, slope in zip(weights, slopes, strict=True))
    gains = sum(weight * turned(q, f) for weight, q, f in zip(weights, stages[:4], (f0, f1, f1, f2), strict=True))
    attitude = [attitude0]
    for step in steps:
        attitude.append(product(attitude[-1], step))
    attitude = np.array(attitude)
    velocity = velocity0 + np.cumsum(np.vstack([np.zeros(3), turned(attitude[:-1], gains)]), axis=0)
    return {"attitude": attitude, "velocity_inertial": velocity}


runge_kutta.takes = "rates"
runge_kutta.samples_per_step = 2
