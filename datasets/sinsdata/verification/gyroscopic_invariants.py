"""Relations between the tables of `gyro_systems`.

Source: Chelnokov 1991, eq. (1.14)-(1.16), (2.6), (2.8).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from sinsdata.cases import GyroCase
from sinsdata.verification.double_double import DoubleDouble, nearest
from sinsdata.verification.residuals import CACHED_CASES, DIGITS, Invariant, Residual, Residuals, differences
from sinsdata.verification.stored_rows import Window
from sinsref.arithmetic import MpArithmetic
from sinsref.gyroscopic import Kinematics
from sinsref.quaternion import cross, dot, rotate

_RULES = ("paper", "rest")
_AXES = ("gyro", "mirror")


def _unit_lengths(window: Window, vectors: Sequence[Sequence[DoubleDouble]]) -> Residuals:
    for vector in vectors:
        yield Residual(window.epochs, dot(vector, vector) - 1)


def _unit_vectors(window: Window) -> Residuals:
    attitude, trihedron = (window.vector("truth", stem, "wxyz") for stem in ("q", "trihedron"))
    yield from _unit_lengths(window, [attitude, trihedron, window.vector("truth", "vertical")])


def _unit_axes(window: Window) -> Residuals:
    axes = [window.vector("reference", f"{rule}_{name}") for rule in _RULES for name in (*_AXES, "bisector")]
    yield from _unit_lengths(window, axes)


def _trihedron(window: Window) -> Residuals:
    """Compare third axis of the Darboux trihedron and vertical, speed along the first axis and velocity."""
    one, zero = _constant(window, 1.0), _constant(window, 0.0)
    trihedron, vertical = window.vector("truth", "trihedron", "wxyz"), window.vector("truth", "vertical")
    yield from differences(window.epochs, rotate(trihedron, [zero, zero, one]), vertical)
    along = [window.column("truth", "speed"), zero, window.column("truth", "radius_rate")]
    yield from differences(window.epochs, rotate(trihedron, along), window.vector("truth", "velocity"))


def _longitudes(window: Window) -> Residuals:
    """Compare the difference of the longitudes with the Earth's rotation."""
    (rate,) = window.constants(_rotation_rate, window.epochs)
    turned = window.column("truth", "time") * rate
    relative, absolute = (window.column("truth", name) for name in ("longitude", "longitude_absolute"))
    yield Residual(window.epochs, absolute - relative - turned)


@lru_cache(CACHED_CASES)
def _rotation_rate(case: GyroCase) -> DoubleDouble:
    return nearest([MpArithmetic(DIGITS).number(case.rotation_rate)])


def _starts(window: Window) -> Residuals:
    """Compare angles and radius at time 0 with those of the case."""
    rows = window.starts
    places = window.epochs[rows]
    names = ("latitude", "longitude", "radius", "heading", "pitch", "roll")
    stored = [window.column("truth", name)[rows] for name in names]
    yield from differences(places, stored, window.constants(_start, places))
    for stem in ("angle", "velocity"):
        for increment in window.vector("sensors", stem):
            yield Residual(places, increment[rows])


@lru_cache(CACHED_CASES)
def _start(case: GyroCase) -> DoubleDouble:
    ar = MpArithmetic(DIGITS)
    kinematics, zero = Kinematics(ar, case.model), ar.number(0)
    latitude, longitude, heading, pitch, roll = (
        kinematics.jet(name, zero)[0] for name in ("latitude", "longitude", "heading", "pitch", "roll")
    )
    return nearest([latitude, longitude, kinematics.radius + kinematics.jet("altitude", zero)[0], heading, pitch, roll])


def _isometry(window: Window) -> Residuals:
    """Compare the angle of two solutions of one gyropendulum, which (2.6) keeps, with that an epoch before."""
    for name in _AXES:
        first, second = (window.vector("reference", f"{rule}_{name}") for rule in _RULES)
        cosine = dot(first, second)
        yield Residual(window.samples, cosine[window.after] - cosine[window.before])


def _bisectors(window: Window) -> Residuals:
    """Check that the vertical of a bi-gyro is as far from one axis as from the other, and in their plane."""
    for rule in _RULES:
        first, second, middle = (window.vector("reference", f"{rule}_{name}") for name in (*_AXES, "bisector"))
        yield Residual(window.epochs, dot(first, middle) - dot(second, middle))
        yield Residual(window.epochs, dot(cross(first, second), middle))


def _constant(window: Window, value: float) -> DoubleDouble:
    count = len(window.epochs.epoch)
    return DoubleDouble(np.full(count, value), np.zeros(count))


INVARIANTS = (
    Invariant(("truth",), "unit quaternions and vertical", _unit_vectors),
    Invariant(("truth",), "vertical and velocity in the Darboux trihedron", _trihedron),
    Invariant(("truth",), "longitudes and the Earth's rotation", _longitudes),
    Invariant(("sensors", "truth"), "start of the motion", _starts),
    Invariant(("reference",), "unit axes", _unit_axes),
    Invariant(("reference",), "solutions of one gyropendulum keep their angle", _isometry),
    Invariant(("reference",), "verticals half way between the axes", _bisectors),
)
"""Relations between tables with a row per epoch."""
