"""Relations between the tables of `dual_precession`.

Source: Lebedev, Panov 1989, sections 1, 2 and 4.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from math import expm1, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.conventions import QUANTA
from sinsdata.truth.irregular import PARTS, shifts
from sinsdata.verification.double_double import DoubleDouble, nearest
from sinsdata.verification.residuals import (
    CACHED_CASES,
    DIGITS,
    TOLERANCE,
    Invariant,
    Residual,
    Residuals,
    differences,
    interval_of,
)
from sinsdata.verification.stored_rows import Places, Window, arrivals
from sinsref.arithmetic import Arithmetic, MpArithmetic, Number
from sinsref.dual_quaternion import dual_part, transfer
from sinsref.precession import body_rate
from sinsref.quaternion import conjugate, dot, product, rotate
from sinsref.series import Series


def _quaternion(window: Window, table: str = "truth") -> list[DoubleDouble]:
    return window.vector(table, "q", "wxyz")


def _unit_norm(window: Window, table: str = "truth") -> Residuals:
    q = _quaternion(window, table)
    yield Residual(window.epochs, dot(q, q) - 1)


def _body_axes(window: Window, table: str = "truth") -> Residuals:
    """Check the dual constraint in stored quantities: W_body = conj(q) o W_inertial o q, (1.3)."""
    turned = rotate(conjugate(_quaternion(window, table)), window.vector(table, "w_inertial"))
    yield from differences(window.epochs, turned, window.vector(table, "w_body"))


@lru_cache(CACHED_CASES)
def _initial_values(case: DualPrecessionCase) -> DoubleDouble:
    ar = MpArithmetic(DIGITS)
    if case.initial_attitude is None:
        sine, cosine = ar.sin_cos(ar.number(case.nutation) / 2)
        attitude = [cosine, sine, ar.number(0), ar.number(0)]
    else:
        given = [ar.number(x) for x in case.initial_attitude]
        attitude = [x / ar.sqrt(dot(given, given)) for x in given]
    # Parameters are 0 or at least 1e-30: what is smaller is what mpmath leaves of an exact zero, as of cos(pi/2).
    unit = [x if abs(x) > 1e-60 else ar.number(0) for x in attitude]
    return nearest([*unit, *map(ar.number, case.initial_velocity)])


def _starts_as_given(window: Window, table: str = "truth") -> Residuals:
    rows = window.starts
    stored = [x[rows] for x in (*_quaternion(window, table), *window.vector(table, "w_inertial"))]
    places = window.epochs[rows]
    yield from differences(places, stored, window.constants(_initial_values, places))


def _of_parameters(
    case: DualPrecessionCase, formula: Callable[[Arithmetic, list[Number], Number], list[Number]]
) -> DoubleDouble:
    """Return functions of the parameters and of the interval, then their dual parts."""
    ar = MpArithmetic(DIGITS)
    interval = ar.number(case.interval)
    principal, dual = transfer(
        ar,
        lambda duals, p: formula(duals, p, duals.constant(interval)),
        case.motion.principal(ar),
        case.motion.dual(ar),
    )
    return nearest([*principal, *dual])


@lru_cache(CACHED_CASES)
def _step_constants(case: DualPrecessionCase) -> DoubleDouble:
    def formula(ar: Arithmetic, parameters: list[Number], interval: Number) -> list[Number]:
        nu, eps, _ = parameters
        sin_spin, cos_spin = ar.sin_cos(nu * interval / 2)
        sin_precession, _ = ar.sin_cos(eps * nu * interval / 2)
        turn = eps * nu * interval
        return [sin_precession, eps * sin_spin * 2, turn * cos_spin, turn * sin_spin, nu * interval]

    return _of_parameters(case, formula)


def _dual(principal: DoubleDouble, dual: DoubleDouble) -> Series:
    return Series(lambda k: principal * 0, (principal, dual))


def _dual_constants(window: Window, of_case: Callable[[Any], DoubleDouble], places: Places) -> list[Series]:
    values = window.constants(of_case, places)
    half = len(values) // 2
    return [_dual(x, y) for x, y in zip(values[:half], values[half:], strict=True)]


def _dual_vector(window: Window, table: str, stems: tuple[str, str]) -> list[Series]:
    first, second = (window.vector(table, stem) for stem in stems)
    return [_dual(x, y) for x, y in zip(first, second, strict=True)]


def _rotation_of_samples(window: Window) -> list[Series]:
    """Return the dual quaternion from the start of each sample to its end, of the stored attitudes and velocities."""
    q = _quaternion(window)
    ends = [_dual(x, y) for x, y in zip(q, dual_part(q, window.vector("truth", "w_inertial")), strict=True)]
    before, after = ([_dual(x[0][rows], x[1][rows]) for x in ends] for rows in (window.before, window.after))
    return product(conjugate(before), after)


def _step(window: Window) -> Residuals:
    r"""Increments and the step of the attitude.

    By `sinsref.precession.body_rotation` and `body_increment` the increment
    :math:`\alpha` and the step :math:`\lambda` of the attitude, of which the latter turns by
    :math:`\varepsilon\nu h` about the precession axis and then by :math:`\nu h` about the spin axis, satisfy

    .. math::
        \sin\frac{\varepsilon\nu h}{2}\,\alpha_{x,y} &= 2\varepsilon\sin\frac{\nu h}{2}\,\lambda_{x,y}\\
        \sin\frac{\varepsilon\nu h}{2}\,(\alpha_z - \nu h) &=
        \varepsilon\nu h\,\Bigl(\lambda_z\cos\frac{\nu h}{2} - \lambda_w\sin\frac{\nu h}{2}\Bigr),

    in dual numbers also with the velocity increments.
    """
    places = window.samples
    sine, chord, turn_cosine, turn_sine, spin = _dual_constants(window, _step_constants, places)
    step = _rotation_of_samples(window)
    x, y, z = _dual_vector(window, "increments", ("angle", "velocity"))
    for residual in (
        sine * x - chord * step[1],
        sine * y - chord * step[2],
        sine * (z - spin) - (turn_cosine * step[3] - turn_sine * step[0]),
    ):
        yield from (Residual(places, residual[part]) for part in (0, 1))


@lru_cache(CACHED_CASES)
def _commutator_bounds(case: DualPrecessionCase) -> DoubleDouble:
    """Return the bounds of `_small_rotations`, rad and m/s, from the largest rates of the motion."""
    rate, force = _largest_rates(case)
    h = float(case.interval)
    angle = rate * h
    vector = 2 * (expm1(angle / 2) - angle / 2) if angle < 50 else np.inf
    bounds = np.array([vector, rate * force * h * h / 2]) * (1 + 1e-9)
    return DoubleDouble(bounds, np.zeros(2))


def _largest_rates(case: DualPrecessionCase) -> tuple[float, float]:
    """Return the largest magnitudes of angular rate, rad/s, and specific force, m/s^2."""
    ar = MpArithmetic(DIGITS)
    # As sums over dual parts of the amplitudes along and across the spin axis: the phase at 0 has a dual part 0.
    motion = case.motion

    def amplitudes(duals: Arithmetic, p: list[Number]) -> list[Number]:
        zero = duals.number(0)
        return body_rate(duals, p, zero)

    (_, across, along), (_, across_dual, along_dual) = transfer(ar, amplitudes, motion.principal(ar), motion.dual(ar))
    drift = abs(float(across * ar.number(motion.spin_rate_dual) * ar.number(case.duration)))
    rate = sqrt(float(across) ** 2 + float(along) ** 2)
    return rate, sqrt((abs(float(across_dual)) + drift) ** 2 + float(along_dual) ** 2)


def _small_rotations(window: Window) -> Residuals:
    """For any motion: a rotation differs from the integral of its rate by products of two increments.

    Twice the vector part of the attitude's step and the angle increment differ by at most
    2 (exp(s/2) - 1 - s/2) with s = h max|omega|, the terms beyond the first of the solution's series in iterated
    integrals. The change of velocity, in the axes of the start, and the velocity increment differ by what the axes turn
    meanwhile, at most h^2 max|omega| max|a| / 2.
    """
    places = window.samples
    step = _rotation_of_samples(window)
    angle_bound, velocity_bound = window.constants(_commutator_bounds, places)
    w = window.vector("truth", "w_inertial")
    change = [x[window.after] - x[window.before] for x in w]
    turned = rotate(conjugate([x[window.before] for x in _quaternion(window)]), change)
    for bound, left, stem in (
        (angle_bound, [x[0] * 2 for x in step[1:]], "angle"),
        (velocity_bound, turned, "velocity"),
    ):
        for x, y in zip(left, window.vector("increments", stem), strict=True):
            yield Residual(places, x - y, bound.high + (x - y).majorant * TOLERANCE)


def _running_sum(window: Window) -> Residuals:
    for stem in ("angle", "velocity"):
        sums = window.vector("accumulated", stem)
        changes = [x[window.after] - x[window.before] for x in sums]
        yield from differences(window.samples, changes, window.vector("increments", stem))
        for x in sums:
            yield Residual(window.epochs[window.starts], x[window.starts])


_RATES = (("angular_rate", "angle"), ("specific_force", "velocity"))


def _means(window: Window) -> Residuals:
    (interval,) = window.constants(interval_of, window.samples)
    for rate, integral in _RATES:
        products = [x * interval for x in window.vector("mean_rates", rate)]
        yield from differences(window.samples, products, window.vector("increments", integral))


@lru_cache(CACHED_CASES)
def _spin(case: DualPrecessionCase) -> DoubleDouble:
    return _of_parameters(case, lambda ar, parameters, interval: [parameters[0], interval])


def _rates(window: Window) -> Residuals:
    """Compare nu times the integrals with the changes of the rates, turned by a quarter: (4.1), (4.3)."""
    places = window.samples
    spin, interval = _dual_constants(window, _spin, places)
    x, y, z = _dual_vector(window, "increments", ("angle", "velocity"))
    rates = _dual_vector(window, "rates", ("angular_rate", "specific_force"))
    before, after = ([_dual(r[0][rows], r[1][rows]) for r in rates] for rows in (window.before, window.after))
    for residual in (
        spin * x - (before[1] - after[1]),
        spin * y - (after[0] - before[0]),
        z - before[2] * interval,
        after[2] - before[2],
    ):
        yield from (Residual(places, residual[part]) for part in (0, 1))


def _resolved(window: Window) -> Residuals:
    """Compare with the change of velocity over a sample, resolved at its start and at its end, (2.6)."""
    q, w = _quaternion(window), window.vector("truth", "w_inertial")
    change = [x[window.after] - x[window.before] for x in w]
    for end, rows in (("start", window.before), ("end", window.after)):
        turned = rotate([x[rows] for x in q], window.vector("resolved", f"velocity_{end}"))
        yield from differences(window.samples, turned, change)


def _nonuniform(window: Window) -> Residuals:
    """Lengths of the samples off the grid, and the constant rates about the spin axis."""
    places = window.samples
    parts = np.concatenate(
        [PARTS + np.diff(shifts(part.case.samples, np.arange(part.start, part.end + 1))) for part in window.parts]
    )
    interval, *_ = window.constants(interval_of, places)
    share = DoubleDouble(parts / PARTS, np.zeros(len(parts)))  # exact: PARTS is a power of two
    stored = window.column("nonuniform", "interval")
    yield Residual(places, stored - interval * share)
    for stem, rate in zip(("angle_z", "velocity_z"), window.constants(_rates_along, places), strict=True):
        yield Residual(places, window.column("nonuniform", stem) - stored * rate)


@lru_cache(CACHED_CASES)
def _rates_along(case: DualPrecessionCase) -> DoubleDouble:
    """Return the constant parts of angular rate and specific force, along the spin axis."""
    return _of_parameters(case, lambda ar, p, interval: body_rate(ar, p, interval)[2:])


def _dropped(window: Window) -> Residuals:
    """Check that what arrives is what was sent."""
    kept = np.concatenate(
        [
            np.isin(np.arange(part.start + 1, part.end + 1), arrivals(part.case.samples, part.start, part.end))
            for part in window.parts
        ]
    )
    for stem in ("angle", "velocity"):
        sent = [x[kept] for x in window.vector("increments", stem)]
        yield from differences(window.samples[kept], window.vector("dropped", stem), sent)


def _quantised(window: Window) -> Residuals:
    """Compare with changes of the accumulated integrals, each rounded to whole quanta."""
    for stem, quantum in zip(("angle", "velocity"), (QUANTA[0], QUANTA[3]), strict=True):
        for total, stored in zip(window.vector("accumulated", stem), window.vector("quantised", stem), strict=True):
            counts, certain = _counts(total, quantum)
            # A tie that the pair cannot decide, or a count beyond 2^52, says nothing.
            known = certain[window.after] & certain[window.before]
            steps = (counts[window.after] - counts[window.before])[known]
            expected = DoubleDouble(steps * quantum, np.zeros(len(steps)))
            yield Residual(window.samples[known], stored[known] - expected, np.full(len(steps), quantum / 4))


def _counts(value: DoubleDouble, quantum: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return whole quanta nearest to values, and which of them are certain."""
    scaled = value.high / quantum
    counts = np.rint(scaled)
    beyond = scaled - counts
    half_way = np.abs(beyond) == 0.5
    counts += np.where(half_way & (value.low * beyond > 0), np.sign(beyond), 0.0)
    certain = ~(half_way & (value.low == 0)) & (np.abs(scaled) < 2.0**51)
    return counts, certain


INVARIANTS = (
    *(
        Invariant((table,), name, partial(residuals, table=table))
        for table in ("truth", "nonuniform_truth")
        for name, residuals in (
            ("unit norm of the attitude", _unit_norm),
            ("apparent velocity in body axes is that in inertial axes, turned", _body_axes),
            ("initial values of the case", _starts_as_given),
        )
    ),
    Invariant(("increments", "truth"), "increments and change of attitude and velocity", _step),
    Invariant(("increments", "truth"), "increments and rotation differ by commutators at most", _small_rotations),
    Invariant(("accumulated", "increments"), "sums of the increments", _running_sum),
    Invariant(("mean_rates", "increments"), "means times interval are increments", _means),
    Invariant(("rates", "increments"), "rates at the ends of a sample and increments", _rates),
    Invariant(("resolved", "truth"), "resolved increments are changes of velocity", _resolved),
    Invariant(("nonuniform",), "lengths of the samples and rotation about the spin axis", _nonuniform),
    Invariant(("dropped", "increments"), "what arrives is what was sent", _dropped),
    Invariant(("quantised", "accumulated"), "whole quanta of the accumulated integrals", _quantised),
)
"""Relations between tables with a row per epoch or sample."""
