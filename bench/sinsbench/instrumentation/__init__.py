"""A function's own source, rebuilt: every operation rounded to fewer bits, or counted."""

from sinsbench.instrumentation.counting import UncountableError, count_operations, operations_per_sample
from sinsbench.instrumentation.reduced_precision import rebuilt_kernels, reduced_precision_integrator, round_mantissa

__all__ = [
    "UncountableError",
    "count_operations",
    "operations_per_sample",
    "rebuilt_kernels",
    "reduced_precision_integrator",
    "round_mantissa",
]
