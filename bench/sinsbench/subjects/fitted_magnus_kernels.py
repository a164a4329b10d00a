"""Compiled kernels: the motion of fitted polynomials by the Magnus expansion of order 4 or 6."""

from typing import NamedTuple

from sinsbench.subjects.fitted_kernels import FitTables, fit_step, keep, vector_at
from sinsbench.subjects.kernels import (
    Array,
    Vector,
    add,
    compiled,
    cross,
    cross_dual,
    dot,
    half_angle_cosine_less_one,
    rotation_biquaternion,
    scale,
    velocity_gains,
)
from sinsbench.subjects.rotation_vector_methods import Coefficients


class MagnusTables(NamedTuple):
    """What `magnus_expansion` reads, and room for what it writes.

    `weights` are those of `sinsbench.subjects.fitted_methods.magnus_weights`, `sixth` tells order 6 from order 4.
    """

    fit: FitTables
    weights: Array
    sixth: bool
    elementary: Coefficients
    rate: Array
    force: Array


@compiled
def magnus_generators(polynomial: Array, weights: Array) -> tuple[Vector, Vector, Vector]:
    """Return the generators alpha_1, alpha_2, alpha_3 of a fitted polynomial (Blanes, Casas, Oteo, Ros 2009)."""
    second, third = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for j in range(1, len(weights)):
        term = scale(weights[j], vector_at(polynomial, j))
        if j % 2:
            second = add(second, term)
        else:
            third = add(third, term)
    first = add(vector_at(polynomial, len(weights)), scale(-1.0 / 12.0, third))
    return first, second, third


@compiled
def magnus_exponent(tables: MagnusTables) -> tuple[Vector, Vector]:
    """Rotation vector of a step and its dual part by the Magnus expansion of order 4 or 6.

    Blanes, Casas, Oteo, Ros 2009, with the signs of Lambda' = Lambda o w, where the rotation stands on the right, and
    with vector products for commutators.
    """
    last = len(tables.weights)
    one, two, three = magnus_generators(tables.rate, tables.weights)
    one_dual, two_dual, three_dual = magnus_generators(tables.force, tables.weights)
    left, left_dual, right, right_dual = scale(20.0, one), scale(20.0, one_dual), two, two_dual
    if tables.sixth:
        pair, pair_dual = cross(one, two), cross_dual(one, one_dual, two, two_dual)
        inner = add(scale(2.0, three), scale(-1.0, pair))
        inner_dual = add(scale(2.0, three_dual), scale(-1.0, pair_dual))
        left, left_dual = add(left, add(three, pair)), add(left_dual, add(three_dual, pair_dual))
        right = add(right, scale(1.0 / 60.0, cross(one, inner)))
        right_dual = add(right_dual, scale(1.0 / 60.0, cross_dual(one, one_dual, inner, inner_dual)))
    phi = add(vector_at(tables.rate, last), scale(1.0 / 240.0, cross(left, right)))
    phi_dual = scale(1.0 / 240.0, cross_dual(left, left_dual, right, right_dual))
    return phi, add(vector_at(tables.force, last), phi_dual)


@compiled
def magnus_expansion(angle: Array, velocity: Array, tables: MagnusTables, gains: Array) -> int:
    """Find what each step does by the Magnus expansion, as `power_series` does; all steps are done always."""
    for step in range(len(gains)):
        fit_step(angle, step, tables.fit, tables.rate)
        fit_step(velocity, step, tables.fit, tables.force)
        phi, phi_dual = magnus_exponent(tables)
        rotation, moment = rotation_biquaternion(phi, phi_dual, tables.elementary)
        less_one = half_angle_cosine_less_one(dot(phi, phi), tables.elementary)
        keep(gains, step, ((less_one, rotation[1], rotation[2], rotation[3]), velocity_gains(rotation, moment)[0]))
    return len(gains)
