"""Compiled kernels: one step of strapdown attitude and apparent velocity, and the loops over steps.

Vectors are tuples of 3 floats, quaternions tuples of 4 (scalar first, Hamilton product, body to inertial),
and the increments of a step a tuple of vectors (``angle`` in rad, ``velocity`` in m/s), those of remembered samples
first: a step allocates nothing. Coefficients arrive at run time as `Coefficients`. A tuple may hold more vectors than
the method looks at: with tuples of one length, all methods run in the same machine code.

`sinsbench.instrumentation` rebuilds this very file with every floating-point operation rounded or counted.
Integer arithmetic therefore stands only inside subscripts and the arguments of ``range`` and ``rows``, which
that rewriting leaves alone.

The algorithm is that of Lebedev, Panov 1989, eqs. (1.12), (2.2), (2.5), (2.6), with the sign of the last term
of (1.12) corrected. Nothing compiles before the first call.
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numba.extending import overload
from numpy.typing import NDArray

from sinsbench.subjects.rotation_vector_methods import Coefficients

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Increments = tuple[Vector, ...]
State = tuple[Quaternion, Vector, Vector]
"""Attitude, apparent velocity in inertial axes, apparent velocity in body axes."""
CompensatedState = tuple[Quaternion, Quaternion, Vector, Vector]
"""Attitude, its carried rounding error, apparent velocity in inertial axes, its carried rounding error."""

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Compile on the first call; keep the machine code on disk wherever there is a place for it.

    Without fast-math: compensated summation needs every rounding where the source has it. Calls are inlined: each
    would otherwise hand over all coefficients, one by one, which takes as long as the arithmetic.
    """
    result: Any
    try:
        result = njit(cache=True, error_model="numpy", forceinline=True)(function)
    except RuntimeError:  # numba found no writable folder for its cache; compiling in memory is as correct
        result = njit(error_model="numpy", forceinline=True)(function)
    return cast("Function", result)


def rows(array: Array, first: int, like: Increments) -> Increments:
    """Rows `first`, `first` + 1, ... of an (n, 3) array, as many as `like` has entries; after the last row, that again.

    Rows that do not exist are asked for at the end only, where `like` is longer than what the method looks at.
    """
    numbers = [min(first + i, len(array) - 1) for i in range(len(like))]
    return tuple((array[i, 0], array[i, 1], array[i, 2]) for i in numbers)


@overload(rows, strict=False)
def _compiled_rows(array: Any, first: Any, like: Any) -> Any:
    # Compiled code has no tuples of a length known at run time only: write one out for the type at hand.
    numbers = "".join(f"    i{k} = min(first + {k}, len(array) - 1)\n" for k in range(len(like)))
    vectors = "".join(f"(array[i{k}, 0], array[i{k}, 1], array[i{k}, 2])," for k in range(len(like)))
    namespace: dict[str, Any] = {}
    exec(f"def rows(array, first, like):\n{numbers}    return ({vectors})", namespace)
    return namespace["rows"]


@compiled
def add(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def scale(factor: float, a: Vector) -> Vector:
    """Product of a number and a vector."""
    return factor * a[0], factor * a[1], factor * a[2]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def cross_dual(a: Vector, a_dual: Vector, b: Vector, b_dual: Vector) -> Vector:
    """Dual part of the vector product of two dual vectors."""
    return add(cross(a_dual, b), cross(a, b_dual))


@compiled
def vector_part(q: Quaternion) -> Vector:
    """Vector part of a quaternion."""
    return q[1], q[2], q[3]


@compiled
def conjugate(q: Quaternion) -> Quaternion:
    """Conjugate quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@compiled
def quaternion_product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    )


@compiled
def rotate(q: Quaternion, v: Vector) -> Vector:
    """Vector part of q o v o conj(q); a quaternion that is not a unit one scales by its squared norm."""
    u = vector_part(q)
    along = add(scale(q[0] * q[0] - dot(u, u), v), scale(2.0 * dot(u, v), u))
    return add(along, scale(2.0 * q[0], cross(u, v)))


@compiled
def increment_sum(increments: Increments, coefficients: Coefficients) -> Vector:
    """Sum of the increments of the step itself: those of remembered samples belong to earlier steps."""
    total = increments[coefficients.window - coefficients.samples]
    for i in range(coefficients.window - coefficients.samples + 1, coefficients.window):
        total = add(total, increments[i])
    return total


@compiled
def rotation_vector(angle: Increments, coefficients: Coefficients) -> Vector:
    """Rotation vector of one step, rad: Lebedev, Panov 1989, eq. (2.2)."""
    p, c = angle, coefficients
    phi = increment_sum(p, c)
    for e in range(c.pairs):
        i, j = c.pair_index[e]
        phi = add(phi, scale(c.pair[e], cross(p[i], p[j])))
    for e in range(c.triples):
        i, j, k = c.triple_index[e]
        phi = add(phi, scale(c.triple[e], cross(p[i], cross(p[j], p[k]))))
    for e in range(c.quartics):
        i, j, k, m = c.quartic_index[e]
        phi = add(phi, scale(c.quartic[e] * dot(p[i], p[j]), cross(p[k], p[m])))
    return phi


@compiled
def rotation_vector_dual(angle: Increments, velocity: Increments, coefficients: Coefficients) -> Vector:
    """Dual part of the rotation vector of one step, m/s: Lebedev, Panov 1989, eq. (2.5).

    It is the Kotelnikov-Study transfer of `rotation_vector`: each product is replaced by its derivative in
    the direction of the velocity increments, with the same coefficients.
    """
    p, b, c = angle, velocity, coefficients
    phi_dual = increment_sum(b, c)
    for e in range(c.pairs):
        i, j = c.pair_index[e]
        phi_dual = add(phi_dual, scale(c.pair[e], cross_dual(p[i], b[i], p[j], b[j])))
    for e in range(c.triples):
        i, j, k = c.triple_index[e]
        inner, inner_dual = cross(p[j], p[k]), cross_dual(p[j], b[j], p[k], b[k])
        phi_dual = add(phi_dual, scale(c.triple[e], cross_dual(p[i], b[i], inner, inner_dual)))
    for e in range(c.quartics):
        i, j, k, m = c.quartic_index[e]
        product_dual = dot(b[i], p[j]) + dot(p[i], b[j])
        by_vector = scale(dot(p[i], p[j]), cross_dual(p[k], b[k], p[m], b[m]))
        term = add(scale(product_dual, cross(p[k], p[m])), by_vector)
        phi_dual = add(phi_dual, scale(c.quartic[e], term))
    return phi_dual


@compiled
def polynomial(x: float, coefficients: tuple[float, ...]) -> float:
    """Polynomial by Horner's rule, constant term first."""
    value = coefficients[len(coefficients) - 1]
    for k in range(len(coefficients) - 2, -1, -1):
        value = value * x + coefficients[k]
    return value


@compiled
def half_angle(square: float, coefficients: Coefficients) -> tuple[float, float]:
    """Return cos(n/2) and sin(n/2)/n of Lebedev, Panov 1989, eq. (1.12), where n^2 = `square`."""
    if square <= coefficients.series_limit:
        return polynomial(square, coefficients.cosine), polynomial(square, coefficients.sine)
    n = math.sqrt(square)
    half = 0.5 * n
    return math.cos(half), math.sin(half) / n


@compiled
def half_angle_cosine_less_one(square: float, coefficients: Coefficients) -> float:
    """Return cos(n/2) - 1 to full relative accuracy, where n^2 = `square`."""
    if square <= coefficients.series_limit:
        return square * polynomial(square, coefficients.cosine[1:])
    sine = math.sin(0.25 * math.sqrt(square))
    return -2.0 * (sine * sine)


@compiled
def rotation_quaternion(phi: Vector, coefficients: Coefficients) -> Quaternion:
    """Quaternion lambda of a rotation vector: Lebedev, Panov 1989, eq. (1.12)."""
    cosine, sine = half_angle(dot(phi, phi), coefficients)
    x, y, z = scale(sine, phi)
    return cosine, x, y, z


@compiled
def rotation_biquaternion(phi: Vector, phi_dual: Vector, coefficients: Coefficients) -> tuple[Quaternion, Quaternion]:
    """Biquaternion lambda + s mu of a dual rotation vector: Lebedev, Panov 1989, eq. (1.12), sign corrected.

    The slope n^-2 (cos(n/2)/2 - sin(n/2)/n) cancels for small angles, hence its own series. With a series
    limit of 0 the closed forms of the paper serve every rotation but that by zero, where they are 0/0.
    """
    square, along = dot(phi, phi), dot(phi, phi_dual)
    cosine, sine = half_angle(square, coefficients)
    if square <= coefficients.series_limit:
        slope = polynomial(square, coefficients.dual)
    else:
        slope = (0.5 * cosine - sine) / square
    x, y, z = scale(sine, phi)
    u, v, w = add(scale(sine, phi_dual), scale(slope * along, phi))
    return (cosine, x, y, z), (-0.5 * sine * along, u, v, w)


@compiled
def velocity_gains(rotation: Quaternion, moment: Quaternion) -> tuple[Vector, Vector]:
    """Velocity gained in one step, 2 vect(mu o conj(lambda)) and 2 vect(conj(lambda) o mu), m/s.

    The first is resolved in the body axes of the start of the step, the second in those of its end; they
    differ in the sign of a vector product. Lebedev, Panov 1989, eq. (1.3).
    """
    u, v = vector_part(rotation), vector_part(moment)
    common = add(scale(2.0 * rotation[0], v), scale(-2.0 * moment[0], u))
    twist = scale(2.0, cross(u, v))
    return add(common, twist), add(common, scale(-1.0, twist))


@compiled
def resolved_gain(angle: Increments, velocity: Increments, phi_dual: Vector, coefficients: Coefficients) -> Vector:
    """Velocity gained in one step, in the body axes of its start, m/s, by a classical velocity update.

    Savage 1998, part II: velocity increment and sculling correction, which together are the dual part of the
    rotation vector, plus the rotation correction 1/2 P x B; with its next term, 1/6 P x (P x B), if that is asked for.
    """
    c = coefficients
    total = increment_sum(angle, c)
    correction = cross(total, increment_sum(velocity, c))
    gain = add(phi_dual, scale(c.resolving[0], correction))
    if c.resolving[1] != 0.0:
        gain = add(gain, scale(c.resolving[1], cross(total, correction)))
    return gain


@compiled
def step(state: State, angle: Increments, velocity: Increments, coefficients: Coefficients) -> State:
    """One step of attitude and apparent velocity: Lebedev, Panov 1989, eq. (2.6), or a classical velocity update."""
    attitude, inertial, body = state
    phi, phi_dual = rotation_vector(angle, coefficients), rotation_vector_dual(angle, velocity, coefficients)
    if coefficients.resolving[0] != 0.0:
        rotation = rotation_quaternion(phi, coefficients)
        gain = resolved_gain(angle, velocity, phi_dual, coefficients)
        return (
            quaternion_product(attitude, rotation),
            add(inertial, rotate(attitude, gain)),
            rotate(conjugate(rotation), add(body, gain)),
        )
    rotation, moment = rotation_biquaternion(phi, phi_dual, coefficients)
    gain_start, gain_end = velocity_gains(rotation, moment)
    return (
        quaternion_product(attitude, rotation),
        add(inertial, rotate(attitude, gain_start)),
        add(rotate(conjugate(rotation), body), gain_end),
    )


@compiled
def attitude_step(attitude: Quaternion, angle: Increments, coefficients: Coefficients) -> Quaternion:
    """One step of attitude alone: the operations of `step` less the dual part."""
    phi = rotation_vector(angle, coefficients)
    return quaternion_product(attitude, rotation_quaternion(phi, coefficients))


@compiled
def add_compensated(total: float, carry: float, term: float) -> tuple[float, float]:
    """Kahan summation: the new total, and the rounding error that the next addition takes back."""
    corrected = term - carry
    updated = total + corrected
    return updated, (updated - total) - corrected


@compiled
def compensated_step(
    state: CompensatedState, angle: Increments, velocity: Increments, coefficients: Coefficients
) -> CompensatedState:
    """`step` with compensated accumulation of attitude and inertial velocity.

    The attitude gains the small Lambda o (lambda - 1) instead of being multiplied by lambda: only then is
    there a sum whose rounding error can be carried to the next step.
    """
    attitude, carry, inertial, inertial_carry = state
    phi, phi_dual = rotation_vector(angle, coefficients), rotation_vector_dual(angle, velocity, coefficients)
    rotation, moment = rotation_biquaternion(phi, phi_dual, coefficients)
    x, y, z = vector_part(rotation)
    q = quaternion_product(attitude, (half_angle_cosine_less_one(dot(phi, phi), coefficients), x, y, z))
    q0, e0 = add_compensated(attitude[0], carry[0], q[0])
    q1, e1 = add_compensated(attitude[1], carry[1], q[1])
    q2, e2 = add_compensated(attitude[2], carry[2], q[2])
    q3, e3 = add_compensated(attitude[3], carry[3], q[3])
    gain = velocity_gains(rotation, moment)[0]
    if coefficients.resolving[0] != 0.0:
        gain = resolved_gain(angle, velocity, phi_dual, coefficients)
    gain = rotate(attitude, gain)
    w0, d0 = add_compensated(inertial[0], inertial_carry[0], gain[0])
    w1, d1 = add_compensated(inertial[1], inertial_carry[1], gain[1])
    w2, d2 = add_compensated(inertial[2], inertial_carry[2], gain[2])
    return (q0, q1, q2, q3), (e0, e1, e2, e3), (w0, w1, w2), (d0, d1, d2)


@compiled
def body_velocity(attitude: Quaternion, inertial: Vector) -> Vector:
    """Apparent velocity in body axes, conj(Lambda) o W_I o Lambda, m/s: Lebedev, Panov 1989, eq. (1.3)."""
    return rotate(conjugate(attitude), inertial)


@compiled
def store(output: Array, index: int, values: tuple[float, ...]) -> None:
    """Write a tuple into row `index` of an array."""
    for i in range(len(values)):
        output[index, i] = values[i]


@compiled
def integrate(
    state: State,
    angle: Array,
    velocity: Array,
    like: Increments,
    coefficients: Coefficients,
    attitude: Array,
    inertial: Array,
    body: Array,
) -> None:
    """Run `step` over all rows of `angle` and `velocity`; each step is handed as many as `like` has entries.

    The states after the steps go to the rows of `attitude`, `inertial` and `body`.
    """
    for k in range(attitude.shape[0]):
        p, b = rows(angle, k * coefficients.samples, like), rows(velocity, k * coefficients.samples, like)
        state = step(state, p, b, coefficients)
        store(attitude, k, state[0])
        store(inertial, k, state[1])
        store(body, k, state[2])


@compiled
def integrate_attitude(
    state: Quaternion, angle: Array, like: Increments, coefficients: Coefficients, attitude: Array
) -> None:
    """Run `attitude_step` as `integrate` runs `step`."""
    for k in range(attitude.shape[0]):
        p = rows(angle, k * coefficients.samples, like)
        state = attitude_step(state, p, coefficients)
        store(attitude, k, state)


@compiled
def integrate_compensated(
    state: CompensatedState,
    angle: Array,
    velocity: Array,
    like: Increments,
    coefficients: Coefficients,
    attitude: Array,
    inertial: Array,
    body: Array,
) -> None:
    """Run `compensated_step` as `integrate` runs `step`; `body_velocity` gives the body axes."""
    for k in range(attitude.shape[0]):
        p, b = rows(angle, k * coefficients.samples, like), rows(velocity, k * coefficients.samples, like)
        state = compensated_step(state, p, b, coefficients)
        store(attitude, k, state[0])
        store(inertial, k, state[2])
        store(body, k, body_velocity(state[0], state[2]))
