"""The methodical errors behind the statements of Chelnokov 1991 that do not hold, proved, as tables."""

from itertools import pairwise
from math import log2
from typing import Any

from sinsbench.claims import gyroscopic_runs as runs
from sinsbench.claims.gyroscopic_states import case
from sinsref.arithmetic import BallArithmetic, Number

MOTIONS = ("T1", "T2", "T3", "T4")
STARTS = ("paper", "rest")
FAMILIES = ("TE", "TP")
ERRORS = {"law": "axis_from_law", "bisector": "bisector", "bisector from rest": "bisector_from_rest"}


def methodical_errors() -> tuple[str, tuple[dict[str, Any], ...]]:
    """Return what gyropendulum and bi-gyro of H = m l V err after one and two hours: a sentence, and rows.

    Returns
    -------
    sentence : str
    rows : tuple of dict
        A row a motion, start and hour: the first axis, and the bisector, less the vertical, along the velocity and to
        the left, rad; the angles, m on the sphere; the error of the speed, m/s. 0 is a ball around zero, below 1e-15.
    """
    rows = []
    for motion in MOTIONS:
        radius = float(case(motion).radius)
        for start in STARTS:
            for hour, at in enumerate(runs.pendulums(motion, start, runs.HOUR, 2), start=1):
                row: dict[str, Any] = {"motion": motion, "start": start, "time_s": hour * runs.HOUR}
                for name, vector in (("axis", at.axis), ("bisector", at.bisector)):
                    with BallArithmetic(runs.BITS):
                        angle = runs.horizontal(vector)
                    row |= {f"{name}_along_rad": _value(vector[0]), f"{name}_left_rad": _value(vector[1])}
                    row[f"{name}_from_vertical_m"] = radius * float(angle.middle) if angle.lower else 0.0
                rows.append(row | {"speed_error_m_per_s": _value(at.speed_error)})
    axes, bisectors = ([row[f"{name}_from_vertical_m"] for row in rows] for name in ("axis", "bisector"))
    sentence = (
        f"With H = m l V the axis of a gyropendulum is {min(axes) / 1000:.0f} to {max(axes) / 1000:.0f} km from the "
        f"vertical, the bisector of a bi-gyro up to {max(bisectors):.0f} m, and not at all on a great circle at "
        "constant speed from rest."
    )
    return sentence, tuple(rows)


def _value(ball: Number) -> float:
    """Return the middle of a ball, 0 where the ball contains it."""
    return 0.0 if ball.contains(0) else float(ball)


def orders_in_speed() -> tuple[str, tuple[dict[str, Any], ...]]:
    """Return how these errors vanish with the speed: a sentence, and rows.

    Returns
    -------
    sentence : str
    rows : tuple of dict
        A row a family and scale: the largest speed, m/s, the largest errors within two hours, rad, and the orders by
        this scale and twice as large a one, None where there is none.
    """
    rows: list[dict[str, Any]] = []
    for family in FAMILIES:
        own = [_row(family, scale) for scale in runs.FAMILY_SCALES]
        orders: list[dict[str, Any]] = [{f"{name}_order": None for name in ERRORS.values()}]
        for faster, slower in pairwise(own):
            ratios = {name: faster[f"{name}_rad"] / slower[f"{name}_rad"] for name in ERRORS.values()}
            orders.append({f"{name}_order": log2(ratio) for name, ratio in ratios.items()})
        rows += [row | order for row, order in zip(own, orders, strict=True)]
    last = {row["family"]: row for row in rows}
    sentence = (
        f"The axis leaves the paper's law by order {last['TE']['axis_from_law_order']:.2f} in v/V, the bisector the "
        f"vertical by order {last['TE']['bisector_order']:.2f} on a manoeuvre, "
        f"{last['TP']['bisector_order']:.2f} on a parallel, and {last['TP']['bisector_from_rest_order']:.2f} on a "
        "parallel from rest."
    )
    return sentence, tuple(rows)


def _row(family: str, scale: str) -> dict[str, Any]:
    motion = f"{family}_{scale}"
    with BallArithmetic(runs.BITS):
        speeds = [float(at.speed) for at in runs.pendulums(motion, "paper", runs.SAMPLE, runs.SAMPLES)]
        errors = {f"{name}_rad": float(runs.largest_error(motion, error)) for error, name in ERRORS.items()}
    return {"family": family, "scale": float(scale), "largest_speed_m_per_s": max(speeds), **errors}
