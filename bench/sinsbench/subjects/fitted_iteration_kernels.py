"""Compiled kernels: the motion of fitted polynomials by functional (Picard) iteration in Chebyshev polynomials.

Attitude is iterated as in QuatFIter (Wu, Yan 2019), every iterate cut off at one degree; velocity is then the integral
of the specific force resolved by the polynomial attitude, as in iNavFIter (Wu 2020), without a cut-off of its own.
"""

import math
from typing import NamedTuple

from sinsbench.subjects.fitted_kernels import (
    TOLERANCE,
    FitTables,
    by_vector,
    fit_step,
    keep,
    length,
    place,
    plus,
    quaternion_at,
    times,
    vector_at,
)
from sinsbench.subjects.kernels import Array, Quaternion, Vector, add, compiled, cross, scale

MOST_ITERATIONS = 60
"""What has not converged by then does not converge in binary64 at all."""


class IterationTables(NamedTuple):
    """What `functional_iteration` reads, and room for what it writes.

    With T the degree at which iterates are cut off, `inverses` has 1/(4 k) in rows k = 1 ... T, and `integrals` the
    integrals over the step of products of Chebyshev polynomials, a quarter of those of T_0 T_0, half of those of other
    products with T_0. `current` has zeros beyond row T.
    """

    fit: FitTables
    inverses: Array
    integrals: Array
    rate: Array
    force: Array
    tails: Array
    current: Array
    product: Array
    change: Array


@compiled
def chebyshev_product(iterate: Array, vectors: Array, terms: int, k: int) -> Quaternion:
    """Twice the coefficient of T_k in the product of two Chebyshev series, the second cut off after `terms` vectors.

    Where coefficients of T_0 are twice those of the function, T_m T_j = (T_(m+j) + T_|m-j|)/2 gives all coefficients
    one form: c_k = (1/2) sum over all j of x_|k-j| o y_|j|.
    """
    total = by_vector(quaternion_at(iterate, k, 0), vector_at(vectors, 0))
    for j in range(1, terms):
        both = plus(quaternion_at(iterate, abs(k - j), 0), quaternion_at(iterate, k + j, 0))
        total = plus(total, by_vector(both, vector_at(vectors, j)))
    return total


@compiled
def integrate_product(tables: IterationTables) -> tuple[Quaternion, float]:
    """Integrate twice the product of the last iteration from the start of the step, cut off at degree T.

    Returns the integral at the end of the step and a bound on it anywhere.
    """
    product, current, degree = tables.product, tables.current, len(tables.inverses) - 1
    odd, even, squares = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), 0.0
    for k in range(1, degree + 1):
        q = plus(quaternion_at(product, k - 1, 0), times(-1.0, quaternion_at(product, k + 1, 0)))
        q = times(tables.inverses[k], q)
        place(current, k, 0, q)
        squares = squares + (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        if k % 2:
            odd = plus(odd, q)
        else:
            even = plus(even, q)
    place(current, 0, 0, times(2.0, plus(odd, times(-1.0, even))))
    # Schwarz's inequality bounds the sum of the lengths, and the constant term at most doubles it.
    return times(2.0, odd), 2.0 * math.sqrt(degree * squares)


@compiled
def iterate_attitude(tables: IterationTables) -> tuple[Quaternion, bool]:
    """Functional iteration q <- 1 + integral of q o w; returns q - 1 at the end, and whether it converged.

    The equation is linear, so each iteration adds the integral of (what the last one added) o w. That is iterated
    here, since small numbers are added with small errors. Coefficients of w that no longer matter are left out. The
    Chebyshev coefficients of q - 1 go to `tables.change`.
    """
    rate, current, product, change = tables.rate, tables.current, tables.product, tables.change
    samples = len(rate) - 1
    tail = 0.0
    for j in range(samples - 1, -1, -1):
        tail = tail + length(vector_at(rate, j))
        tables.tails[j] = tail
    for k in range(len(product)):
        w = vector_at(rate, k) if k < samples else (0.0, 0.0, 0.0)
        place(product, k, 0, (0.0, 2.0 * w[0], 2.0 * w[1], 2.0 * w[2]))
    _, bound = integrate_product(tables)
    # To the first order the rotation is the sum of the increments, free of what rounding does to the fit.
    total = (0.0, 0.5 * rate[samples, 0], 0.5 * rate[samples, 1], 0.5 * rate[samples, 2])
    for k in range(len(change)):
        place(change, k, 0, quaternion_at(current, k, 0))
    for _ in range(MOST_ITERATIONS):
        terms = samples
        while terms > 0 and tables.tails[terms - 1] * bound <= TOLERANCE:
            terms = terms - 1
        if terms == 0:
            return total, True
        for k in range(len(product)):
            place(product, k, 0, chebyshev_product(current, rate, terms, k))
        end, bound = integrate_product(tables)
        total = plus(total, end)
        for k in range(len(change)):
            place(change, k, 0, plus(quaternion_at(change, k, 0), quaternion_at(current, k, 0)))
    return total, False


@compiled
def velocity_gained(tables: IterationTables) -> Vector:
    """Integral of q o a o conj(q) over the step, exact for the polynomials q and a.

    With q = 1 + x the integrand is a + vect((x o a) o conj(2 + x)).
    """
    force, current, change = tables.force, tables.current, tables.change
    for k in range(len(change)):
        place(current, k, 0, quaternion_at(change, k, 0))
    change[0, 0] = change[0, 0] + 4.0
    gain = vector_at(force, len(force) - 1)
    for m in range(len(tables.integrals)):
        x, y = chebyshev_product(current, force, len(force) - 1, m), (0.0, 0.0, 0.0, 0.0)
        for n in range(m % 2, len(change), 2):
            y = plus(y, times(tables.integrals[m, n], quaternion_at(change, n, 0)))
        u, v = (x[1], x[2], x[3]), (y[1], y[2], y[3])
        gain = add(gain, add(add(scale(y[0], u), scale(-x[0], v)), cross(v, u)))
    return gain


@compiled
def functional_iteration(angle: Array, velocity: Array, tables: IterationTables, gains: Array) -> int:
    """Find what each step does by functional iteration, as `power_series` does; returns when one does not converge."""
    for step in range(len(gains)):
        fit_step(angle, step, tables.fit, tables.rate)
        fit_step(velocity, step, tables.fit, tables.force)
        for c in range(3):  # the convention of `chebyshev_product`
            tables.rate[0, c], tables.force[0, c] = 2.0 * tables.rate[0, c], 2.0 * tables.force[0, c]
        less_one, converged = iterate_attitude(tables)
        if not converged:
            return step
        keep(gains, step, (less_one, velocity_gained(tables)))
    return len(gains)
