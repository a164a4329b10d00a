"""The error equations along the equator, written out in ball arithmetic, and their exponential.

Loginov, Tkachenko, Chelnokov 2013, eqs. (8)-(10). Beside the six errors stand 1, cos th, sin th, cos 2 th and
sin 2 th of the inertial longitude th: with them the equations under a misalignment are homogeneous and have
constant coefficients. Nothing here is taken from the closed forms that are compared with it.
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple, TypeAlias

from flint import arb, arb_mat

from sinsref.arithmetic import BallArithmetic

#: Far beyond binary64, and beyond the balls of the modules that are tested.
BITS = 320
U, A, GRAVITY = "7.29e-5", "6378245", "9.78049"
V_MAX = f"{A}*(sqrt({U}*{U} + {GRAVITY}/{A}) - {U})"  # a_H = 0 eastward, at H = 0
RESONANCE = f"{A}*(sqrt({GRAVITY}/{A}) - {U})"  # omega_N is the Schuler rate, at H = 0

#: A float is the binary64 it is, a text the number it says.
Given: TypeAlias = float | str
Matrix: TypeAlias = tuple[tuple[Given, Given, Given], ...]
NO_MISALIGNMENT: Matrix = ((0.0,) * 3,) * 3


class Constants(NamedTuple):
    """v, R, g, omega_N = u + v/R, 2 u + v/R, a_H and a_24."""

    v: arb
    R: arb
    g: arb
    turn: arb
    coriolis: arb
    force: arb
    a24: arb


@cache
def constants(v_east: Given, height: Given) -> Constants:
    with BallArithmetic(BITS) as ar:
        u, a, v = ar.number(U), ar.number(A), ar.number(v_east)
        R = a + ar.number(height)
        g = ar.number(GRAVITY) * a * a / (R * R)
        force, a24 = g - 2 * u * v - v * v / R, 2 * g / R - v * v / (R * R)
        return Constants(v, R, g, u + v / R, 2 * u + v / R, force, a24)


@cache
def generator(v_east: Given, height: Given, misalignment: Matrix = NO_MISALIGNMENT) -> arb_mat:
    """The 11 x 11 matrix of the homogeneous equations."""
    v, R, g, turn, coriolis, force, a24 = constants(v_east, height)
    with BallArithmetic(BITS) as ar:
        (_, l12, l13), (_, l22, l23), (_, l32, l33) = ([ar.number(x) for x in row] for row in misalignment)
        entries = {
            (0, 4): -g, (1, 2): 2 * turn, (1, 3): a24, (2, 1): -coriolis, (2, 5): -force,
            (3, 1): 1, (4, 0): 1 / R, (5, 2): 1 / R, (5, 3): -v / (R * R),
            # cos^2 = (1 + cos 2 th)/2, sin^2 = (1 - cos 2 th)/2, cos sin = (sin 2 th)/2
            (0, 7): force * l12, (0, 8): force * l13,
            (1, 6): force * (l22 + l33) / 2, (1, 9): force * (l22 - l33) / 2, (1, 10): force * (l32 + l23) / 2,
            (2, 6): force * (l32 - l23) / 2, (2, 9): force * (l32 + l23) / 2, (2, 10): force * (l33 - l22) / 2,
            (7, 8): -turn, (8, 7): turn, (9, 10): -2 * turn, (10, 9): 2 * turn,
        }  # fmt: skip
        return arb_mat(11, 11, [entries.get((i, j), 0) for i in range(11) for j in range(11)])


@cache
def exponential(v_east: Given, height: Given, time: Given, misalignment: Matrix = NO_MISALIGNMENT) -> arb_mat:
    """The transition matrix of the eleven equations; P(t) is its leading 6 x 6 block."""
    with BallArithmetic(BITS) as ar:
        matrix: arb_mat = (generator(v_east, height, misalignment) * ar.number(time)).exp()
        return matrix


@cache
def state(
    v_east: Given,
    height: Given,
    time: Given,
    initial: tuple[Given, ...],
    misalignment: Matrix = NO_MISALIGNMENT,
    longitude: Given = 0,
) -> list[arb]:
    """The six errors after `time` seconds; `longitude` is th at the start."""
    with BallArithmetic(BITS) as ar:
        th = ar.number(longitude)
        ring = [1, th.cos(), th.sin(), (2 * th).cos(), (2 * th).sin()]
        start = arb_mat(11, 1, [*(ar.number(x) for x in initial), *ring])
        return (exponential(v_east, height, time, misalignment) * start).entries()[:6]


def leading_block(matrix: arb_mat) -> list[list[arb]]:
    """Rows of the 6 x 6 block of the errors themselves."""
    return [[matrix[i, j] for j in range(6)] for i in range(6)]


def differences(found: Sequence[float | arb], exact: Sequence[arb]) -> list[float]:
    """Subtracted before they are rounded to binary64."""
    with BallArithmetic(BITS):
        return [float(arb(x) - y) for x, y in zip(found, exact, strict=True)]
