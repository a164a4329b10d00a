"""Quaternions over any arithmetic: scalar first, Hamilton product, body to reference.

A quaternion is a list of four numbers, a vector a list of three.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from sinsref.arithmetic import Arithmetic, Number

Quaternion: TypeAlias = Sequence[Number]
Vector: TypeAlias = Sequence[Number]


def product(a: Quaternion, b: Quaternion) -> list[Number]:
    """Return the Hamilton product."""
    a0, a1, a2, a3 = a
    b0, b1, b2, b3 = b
    return [
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 + a2 * b0 + a3 * b1 - a1 * b3,
        a0 * b3 + a3 * b0 + a1 * b2 - a2 * b1,
    ]


def conjugate(a: Quaternion) -> list[Number]:
    """Return the quaternion with its vector part reversed."""
    return [a[0], -a[1], -a[2], -a[3]]


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """Return the scalar product of two vectors or quaternions."""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> list[Number]:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotate(a: Quaternion, v: Vector) -> list[Number]:
    """Return the vector part of ``a o v o conj(a)``: a vector of the body resolved in the reference frame."""
    return product(product(a, [v[0] * 0, *v]), conjugate(a))[1:]


def normalised(arithmetic: Arithmetic, a: Quaternion) -> list[Number]:
    """Return the unit quaternion of the same direction."""
    norm = arithmetic.sqrt(dot(a, a))
    return [x / norm for x in a]
