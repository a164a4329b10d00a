"""Compiled kernels that all methods of polynomial fit share: the fit to the increments, and the sum of the steps.

A step is done in two stages. The first finds from its increments alone how the body turns and what velocity it gains:
`fit_step` and then one of three flows, in `sinsbench.subjects.fitted_series_kernels`, `fitted_iteration_kernels` and
`fitted_magnus_kernels`. The second, `accumulate`, adds the steps up. Between them stands lambda - 1 instead of lambda:
a compensated sum adds the small difference without loss.

Polynomials are those of `sinsbench.subjects.fitted_methods`: w(tau) = (H/4) omega and a(tau) = (H/4) times the
specific force, tau from -1 to 1, their coefficients in the rows of an array and the sum of the increments in its last
row. Sizes are read off the arrays, so that one compilation serves any number of samples, and whatever a step writes
is handed in: nothing is allocated. Vectors and quaternions are tuples, as in `sinsbench.subjects.kernels`.
"""

import math
from typing import NamedTuple

from sinsbench.subjects.kernels import (
    Array,
    CompensatedState,
    Quaternion,
    Vector,
    add_compensated,
    body_velocity,
    compiled,
    dot,
    quaternion_product,
    rotate,
    store,
)

TOLERANCE = 1e-18
"""What may be left out of a step: a hundredth of the rounding of a unit quaternion."""

Gain = tuple[Quaternion, Vector]
"""What a step does: lambda - 1, and the velocity gained, m/s, in the body axes of its start."""


class FitTables(NamedTuple):
    """`sinsbench.subjects.fitted_methods.Fit` in binary64, N/2, and room for the differences of (N+1)/2 increments."""

    even: Array
    odd: Array
    mean: Array
    half: float
    differences: Array


@compiled
def plus(a: Quaternion, b: Quaternion) -> Quaternion:
    """Sum of two quaternions."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@compiled
def times(factor: float, a: Quaternion) -> Quaternion:
    """Product of a number and a quaternion."""
    return factor * a[0], factor * a[1], factor * a[2], factor * a[3]


@compiled
def by_vector(q: Quaternion, v: Vector) -> Quaternion:
    """Hamilton product of a quaternion and a vector."""
    return (
        -(q[1] * v[0] + q[2] * v[1] + q[3] * v[2]),
        q[0] * v[0] + q[2] * v[2] - q[3] * v[1],
        q[0] * v[1] + q[3] * v[0] - q[1] * v[2],
        q[0] * v[2] + q[1] * v[1] - q[2] * v[0],
    )


@compiled
def vector_at(array: Array, row: int) -> Vector:
    """Row of an array of three columns."""
    return array[row, 0], array[row, 1], array[row, 2]


@compiled
def quaternion_at(array: Array, row: int, first: int) -> Quaternion:
    """Four entries of a row of an array."""
    return array[row, first], array[row, first + 1], array[row, first + 2], array[row, first + 3]


@compiled
def place(array: Array, row: int, first: int, q: Quaternion) -> None:
    """Write a quaternion into four entries of a row of an array."""
    array[row, first], array[row, first + 1], array[row, first + 2], array[row, first + 3] = q[0], q[1], q[2], q[3]


@compiled
def weighted_sum(weights: Array, row: int, values: Array) -> float:
    """Scalar product of a row of a matrix with the first entries of a vector."""
    total: float = weights[row, 0] * values[0]
    for i in range(1, weights.shape[1]):
        total = total + weights[row, i] * values[i]
    return total


@compiled
def fit_step(samples: Array, step: int, tables: FitTables, out: Array) -> None:
    """Fit polynomials to the increments of one step of `samples`, shape (steps, N, 3), see `FitTables`."""
    last, inner = samples.shape[1] - 1, len(tables.even)
    for axis in range(3):
        # All even coefficients but the first come from differences from the innermost pair. For constant increments
        # these vanish, and with them what rounding would make of the coefficients: a constant rate stays one.
        reference = samples[step, inner, axis] + samples[step, last - inner, axis]
        total = tables.half * reference
        for i in range(inner):
            difference = (samples[step, i, axis] + samples[step, last - i, axis]) - reference
            tables.differences[i] = difference
            total = total + difference
        constant = 0.25 * total
        for j in range(inner):
            coefficient = weighted_sum(tables.even, j, tables.differences)
            out[2 * j + 2, axis] = coefficient
            constant = constant - tables.mean[j] * coefficient
        out[0, axis] = constant
        out[last + 1, axis] = total
        for i in range(len(tables.odd)):
            tables.differences[i] = samples[step, last - i, axis] - samples[step, i, axis]
        for j in range(len(tables.odd)):
            out[2 * j + 1, axis] = weighted_sum(tables.odd, j, tables.differences)


@compiled
def length(v: Vector) -> float:
    """Length of a vector."""
    return math.sqrt(dot(v, v))


@compiled
def keep(gains: Array, step: int, gain: Gain) -> None:
    """Write what a step does into a row of an array of 7 columns."""
    place(gains, step, 0, gain[0])
    for c in range(3):
        gains[step, 4 + c] = gain[1][c]


@compiled
def accumulate(
    state: CompensatedState, gains: Array, attitude: Array, inertial: Array, body: Array
) -> CompensatedState:
    """Add up what the steps do, with carried rounding errors, and return the last state.

    The states after the steps go to the rows of `attitude` (4 columns), `inertial` and `body` (3 columns, m/s).
    """
    q, carry, velocity, velocity_carry = state
    for k in range(len(gains)):
        gain = rotate(q, (gains[k, 4], gains[k, 5], gains[k, 6]))
        term = quaternion_product(q, quaternion_at(gains, k, 0))
        q0, e0 = add_compensated(q[0], carry[0], term[0])
        q1, e1 = add_compensated(q[1], carry[1], term[1])
        q2, e2 = add_compensated(q[2], carry[2], term[2])
        q3, e3 = add_compensated(q[3], carry[3], term[3])
        v0, d0 = add_compensated(velocity[0], velocity_carry[0], gain[0])
        v1, d1 = add_compensated(velocity[1], velocity_carry[1], gain[1])
        v2, d2 = add_compensated(velocity[2], velocity_carry[2], gain[2])
        q, carry, velocity, velocity_carry = (q0, q1, q2, q3), (e0, e1, e2, e3), (v0, v1, v2), (d0, d1, d2)
        store(attitude, k, q)
        store(inertial, k, velocity)
        store(body, k, body_velocity(q, velocity))
    return q, carry, velocity, velocity_carry
