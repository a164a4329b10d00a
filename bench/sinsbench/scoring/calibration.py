"""A fixed workload that is timed beside the subjects, so that their times compare between machines and moments."""

import time

from sinsbench.subjects.kernels import compiled

__all__ = ["PRODUCTS", "calibration_unit"]

PRODUCTS = 20_000
"""Quaternion products in one run of the workload."""

_RUNS = 5


@compiled
def _products(count: int) -> float:
    """Multiply a quaternion on by the same unit quaternion, each product waiting for the one before."""
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    a, b, c, d = 0.8, 0.36, -0.48, 0.0
    for _ in range(count):
        w, x, y, z = (
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        )
    return w


def calibration_unit() -> float:
    """Return the time of one quaternion product in a compiled loop, ns, at this moment on this machine.

    The unit is 16 multiplications and 12 additions that wait for one another, which is what the recursion of an
    integrator consists of. The least of five runs of `PRODUCTS` products counts, a tenth of a millisecond each.
    """
    _products(1)  # compiles, or loads what was compiled
    times = []
    for _ in range(_RUNS):
        start = time.perf_counter()
        _products(PRODUCTS)
        times.append(time.perf_counter() - start)
    return min(times) / PRODUCTS * 1e9
