"""Compiled kernels: the motion of fitted polynomials by power series about the middle of the step."""

from typing import NamedTuple

from sinsbench.subjects.fitted_kernels import (
    TOLERANCE,
    FitTables,
    Gain,
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
from sinsbench.subjects.kernels import Array, Quaternion, compiled, conjugate, quaternion_product, velocity_gains


class SeriesTables(NamedTuple):
    """What `power_series` reads, 1/k from k = 1 on in row k, and room for what it writes."""

    fit: FitTables
    reciprocals: Array
    rate: Array
    force: Array
    sizes: Array
    bounds: Array
    series: Array


@compiled
def terms_needed(tables: SeriesTables) -> int:
    """Count the terms of the power series that matter; 0 if there are more than there is room for.

    The recursion of the series, run on the lengths of the coefficients, bounds every term from above. The series ends
    where N consecutive bounds are below the tolerance and every later one is at most half the largest of N before it.
    """
    samples = len(tables.rate) - 1
    sizes, bounds = tables.sizes, tables.bounds
    rate_total, force_total = 0.0, 0.0
    for j in range(samples):
        sizes[j, 0], sizes[j, 1] = length(vector_at(tables.rate, j)), length(vector_at(tables.force, j))
        rate_total, force_total = rate_total + sizes[j, 0], force_total + sizes[j, 1]
    bounds[0, 0], bounds[0, 1] = 1.0, 0.0
    needed = 2  # so that there are even terms and odd ones
    for k in range(1, len(bounds)):
        real, dual = 0.0, 0.0
        # From the far end: what the term before contributes comes last, and does not keep the others waiting.
        for j in range(min(k, samples) - 1, -1, -1):
            real = real + bounds[k - 1 - j, 0] * sizes[j, 0]
            dual = dual + (bounds[k - 1 - j, 1] * sizes[j, 0] + bounds[k - 1 - j, 0] * sizes[j, 1])
        bounds[k, 0], bounds[k, 1] = real * tables.reciprocals[k], dual * tables.reciprocals[k]
        if bounds[k, 0] > TOLERANCE or bounds[k, 1] > TOLERANCE * force_total:
            needed = k
        elif k - needed >= samples and rate_total * tables.reciprocals[k] <= 0.5:
            return needed
    return 0


@compiled
def parity_sum(series: Array, highest: int, first: int) -> Quaternion:
    """Sum of every second term down to the first or second; small terms first, which saves roundings."""
    total = quaternion_at(series, highest, first)
    for k in range(highest - 2, 0, -2):
        total = plus(total, quaternion_at(series, k, first))
    return total


@compiled
def series_gain(tables: SeriesTables, terms: int) -> Gain:
    """Gain of a step by the power series of Theta' = Theta o (w + s a) about the middle of the step.

    (k+1) Theta_(k+1) = sum over j of Theta_(k-j) o (w_j + s a_j), Theta_0 = 1. One series serves both ends of the
    step: with the sums E of its even and O of its odd terms it is 1 + E - O at the start and 1 + E + O at the end.
    """
    series, samples = tables.series, len(tables.rate) - 1
    place(series, 0, 0, (1.0, 0.0, 0.0, 0.0))
    place(series, 0, 4, (0.0, 0.0, 0.0, 0.0))
    for k in range(1, terms + 1):
        q, m = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
        for j in range(min(k, samples) - 1, -1, -1):
            w, a = vector_at(tables.rate, j), vector_at(tables.force, j)
            u, v = quaternion_at(series, k - 1 - j, 0), quaternion_at(series, k - 1 - j, 4)
            q = plus(q, by_vector(u, w))
            m = plus(m, plus(by_vector(v, w), by_vector(u, a)))
        place(series, k, 0, times(tables.reciprocals[k], q))
        place(series, k, 4, times(tables.reciprocals[k], m))
    highest_even, highest_odd = terms - terms % 2, terms - 1 + terms % 2
    even, odd = parity_sum(series, highest_even, 0), parity_sum(series, highest_odd, 0)
    even_dual, odd_dual = parity_sum(series, highest_even, 4), parity_sum(series, highest_odd, 4)
    back, back_dual = conjugate(plus(even, times(-1.0, odd))), conjugate(plus(even_dual, times(-1.0, odd_dual)))
    end, end_dual = plus(even, odd), plus(even_dual, odd_dual)
    # conj(1 + start) o (1 + end) - 1. In the sum of its linear terms half of each cancels, so that is written out.
    less_one = plus((2.0 * even[0], 2.0 * odd[1], 2.0 * odd[2], 2.0 * odd[3]), quaternion_product(back, end))
    moment = plus(quaternion_product(back, end_dual), quaternion_product(back_dual, end))
    moment = plus((2.0 * even_dual[0], 2.0 * odd_dual[1], 2.0 * odd_dual[2], 2.0 * odd_dual[3]), moment)
    rotation = plus((1.0, 0.0, 0.0, 0.0), less_one)
    return less_one, velocity_gains(rotation, moment)[0]


@compiled
def power_series(angle: Array, velocity: Array, tables: SeriesTables, gains: Array) -> int:
    """Find what each step does by power series.

    Parameters
    ----------
    angle, velocity : ndarray, shape (steps, N, 3)
        Increments, rad and m/s.
    tables : SeriesTables
        Coefficients and room to work.
    gains : ndarray, shape (steps, 7)
        Is given lambda - 1 and the velocity gained, m/s, in the body axes of the start of the step.

    Returns
    -------
    int
        Number of steps done: all of them, or those before the first that needs more terms than there is room for.
    """
    for step in range(len(gains)):
        fit_step(angle, step, tables.fit, tables.rate)
        fit_step(velocity, step, tables.fit, tables.force)
        terms = terms_needed(tables)
        if terms == 0:
            return step
        keep(gains, step, series_gain(tables, terms))
    return len(gains)
