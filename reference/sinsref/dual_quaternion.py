"""Rotation vectors and dual rotation vectors, quaternions and dual quaternions (biquaternions).

A dual rotation vector is a pair (phi, phi0), a dual quaternion a pair (lambda, mu): rotation, and beside it
the part that carries apparent velocity. Lebedev, Panov 1989, section 1.
"""

from __future__ import annotations

from collections.abc import Callable

from sinsref.arithmetic import Arithmetic, Number
from sinsref.elementary import cosine_and_sinc
from sinsref.quaternion import Quaternion, Vector, conjugate, dot, product
from sinsref.series import DualArithmetic, DualNumber


def from_rotation_vector(ar: Arithmetic, phi: Vector) -> list[Number]:
    """Return the quaternion of a rotation vector (1.12).

    Parameters
    ----------
    ar : Arithmetic
    phi : sequence of 3 Number
        Rotation vector, rad.
    """
    cosine, sinc = cosine_and_sinc(ar, dot(phi, phi) / 4)
    return [cosine, *(sinc * component / 2 for component in phi)]


def from_dual_rotation_vector(ar: Arithmetic, phi: Vector, phi_dual: Vector) -> tuple[list[Number], list[Number]]:
    """Return the dual quaternion (lambda, mu) of a dual rotation vector: (1.12) by the transfer principle.

    The printed (1.12) has the sign of the last term of mu reversed; the transfer principle has no sign to
    misprint.

    Parameters
    ----------
    ar : Arithmetic
    phi : sequence of 3 Number
        Rotation vector, rad.
    phi_dual : sequence of 3 Number
        Its dual part, m/s.
    """
    return transfer(ar, lambda dual, vector: from_rotation_vector(dual, vector), phi, phi_dual)


def transfer(
    ar: Arithmetic,
    formula: Callable[[DualArithmetic, list[Number]], list[Number]],
    principal: Vector,
    dual: Vector,
) -> tuple[list[Number], list[Number]]:
    """Apply a formula for real arguments to dual ones: the transfer principle of Kotelnikov and Study.

    Parameters
    ----------
    ar : Arithmetic
    formula : callable
        ``formula(arithmetic, arguments)`` returns a list of numbers.
    principal, dual : sequence of Number
        Principal and dual parts of the arguments.

    Returns
    -------
    principal, dual : list of Number
        Principal and dual parts of the values.
    """
    values = formula(DualArithmetic(ar), [DualNumber(x, y) for x, y in zip(principal, dual, strict=True)])
    return [value.principal for value in values], [value.dual for value in values]


def to_rotation_vector(ar: Arithmetic, unit: Quaternion) -> list[Number]:
    """Return the rotation vector, of length at most pi, of a unit quaternion.

    Parameters
    ----------
    ar : Arithmetic
    unit : sequence of 4 Number
        Unit quaternion; the sign does not matter.

    Notes
    -----
    The angle is twice the arctangent of |vector| / scalar. It is found without an inverse function of the
    arithmetic: the half angle is halved again until it is small, then the arcsine series is summed.
    """
    scalar, *vector = unit if ar.sign(unit[0]) >= 0 else [-x for x in unit]
    scale = ar.number(2) + scalar * 0
    # q -> sqrt(q) = (1 + q)/|1 + q| halves the angle; sin of the half angle falls below 1/16 after at most
    # six times.
    while ar.magnitude(dot(vector, vector)) > 1 / 256:
        norm = ar.sqrt((scalar + 1) * 2)
        scalar, vector = (scalar + 1) / norm, [x / norm for x in vector]
        scale = scale * 2
    square = dot(vector, vector)
    # arcsin(s)/s = sum of (2k)!/(4^k k!^2 (2k+1)) s^2k
    term = ar.number(1) + square * 0
    total = term
    size, k = 1.0, 0
    while size > ar.resolution * 1e-6:
        k += 1
        term = term * square * (2 * k - 1) / (2 * k)
        total = total + term / (2 * k + 1)
        size /= 256
    total = ar.widen(total, term / 128)
    return [scale * total * x for x in vector]


def to_dual_rotation_vector(ar: Arithmetic, unit: Quaternion, dual: Quaternion) -> tuple[list[Number], list[Number]]:
    """Return the dual rotation vector of a unit dual quaternion, by the transfer principle."""
    return transfer(ar, lambda duals, quaternion: to_rotation_vector(duals, quaternion), unit, dual)


def apparent_velocity(unit: Quaternion, dual: Quaternion) -> tuple[list[Number], list[Number]]:
    """Return the apparent velocity in inertial and in body axes (1.3).

    Parameters
    ----------
    unit, dual : sequence of 4 Number
        The dual quaternion Lambda + s M.

    Returns
    -------
    inertial, body : list of 3 Number
        ``2 vect(M o conj(Lambda))`` and ``2 vect(conj(Lambda) o M)``, m/s.
    """
    inertial = product(dual, conjugate(unit))
    body = product(conjugate(unit), dual)
    return [x * 2 for x in inertial[1:]], [x * 2 for x in body[1:]]


def dual_part(unit: Quaternion, velocity_inertial: Vector) -> list[Number]:
    """Return M = W_I o Lambda / 2, the inverse of (1.3)."""
    return [x / 2 for x in product([velocity_inertial[0] * 0, *velocity_inertial], unit)]
