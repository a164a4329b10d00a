"""How errors of gyroscopic systems grow with the speed, and the periods with which they swing."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sinsbench.scoring.rows import Field, plain_row
from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS
from sinsdata.cases.gyroscopic import GyroCase

__all__ = ["GROWTH_FIELDS", "SEARCHED", "Oscillation", "Theory", "expected_periods", "growth", "growth_order",
           "oscillation", "theory_of"]  # fmt: skip

Array = NDArray[np.float64]

SEARCHED = 0.6, 1.4
"""Where the period of an error is looked for, in units of 2 pi sqrt(R/g): two hours on the Earth are long enough."""

_MEMBER = re.compile(r"(.+)_(\d+(?:\.\d+)?)")
_PROPORTIONAL = 0.01  # how far speeds of a family may be from proportional to the numbers in its names


class Theory(NamedTuple):
    """Order in q = v/sqrt(g R) of the error of a system.

    Attributes
    ----------
    general, parallel, great_circle : int or None
        Of the vertical, in general motion, and at constant speed on a parallel and on a great circle; None where there
        is no error of the system itself.
    law : int or None
        Of the deviation of a gyropendulum from alpha = -v/sqrt(g R); None for other systems.
    """

    general: int | None = None
    parallel: int | None = None
    great_circle: int | None = None
    law: int | None = None


_THEORY: Mapping[str, Theory] = {
    # The inclination itself is of order 1; the paper's law for it holds to a relative error of order 2.
    **dict.fromkeys(("gp_paper", "gp_equilibrium", "gpx"), Theory(1, 1, 1, law=3)),
    # The bisector of two axes that err by the same third order, on opposite sides but for the turn w3.
    "bg_paper": Theory(3, 3, 3),
    "bg_equilibrium": Theory(3, 4, None),
    "bgv": Theory(3, None, None),
    # The tangent differs from sin E cos E by the square of cos E = m l v/(2B), which turns the frame as v/R does.
    "gf_linear": Theory(3, None, None),
}

_INERTIAL = ("gf", "ghc", "ghc_radius", "ghc_altitude", "full", "trad")
"""Systems that are the two-component inertial one in other variables."""

GROWTH_FIELDS = (
    Field("subject", "", "name of the subject"),
    Field("family", "", "what the names of the cases have in common"),
    Field("cases", "", "cases that the order rests on: those in which the error of the system is seen"),
    Field("speed_ratio_min", "", "q = v/sqrt(g R) at the largest speed of the slowest case"),
    Field("speed_ratio_max", "", "of the fastest"),
    Field("error_min", "rad", "largest error of the vertical in the slowest case, as system_error_max of the scores"),
    Field("error_max", "rad", "in the fastest"),
    Field("order", "", "power of q with which that error grows, a least-squares slope"),
    Field("expected_order", "", "by theory (built-in systems)"),
    Field("law_order", "", "as order, of the deviation from the law of a gyropendulum (gyropendulums)"),
    Field("law_expected_order", "", "by theory"),
    Field("note", "", "why there is no order"),
)


def theory_of(subject: str) -> Theory | None:
    """Return the orders of a built-in subject by theory; None for any other."""
    row = SUBJECTS.get(subject)
    return None if row is None else _THEORY.get(row.system, Theory())


def expected_periods(subject: str, case: GyroCase) -> dict[str, float]:
    """Return the periods of small errors of a built-in system at constant speed on a great circle, as fields.

    Linearised about the unperturbed motion: across the path the Schuler period 2 pi sqrt(R/g), along it
    2 pi/sqrt(g/R - v^2/R^2) for the systems which are the two-component inertial one in other variables, and
    2 pi/sqrt(g/R + v^2/R^2) for the self-tuned bi-gyro; for the gyropendulum of constant momentum, about its
    equilibrium, 2 pi sqrt(R/g)/sqrt(1 - q^2 + q^4), q = v/sqrt(g R).

    Parameters
    ----------
    subject : str
    case : GyroCase

    Returns
    -------
    dict of str to float
        ``expected_period_along`` and ``expected_period_left``, s; empty for other systems and motions.
    """
    row, speed = SUBJECTS.get(subject), case.speed.constant if case.speed is not None else None
    level = case.altitude.constant is not None and float(case.altitude.constant) == 0
    if row is None or speed is None or case.motion != "great_circle" or not level:
        return {}
    radius, gravity = float(case.radius), float(case.gravity)
    rate, ratio = np.sqrt(gravity / radius), float(speed) ** 2 / (gravity * radius)
    if row.system in _INERTIAL:
        rates = rate * np.sqrt(1 - ratio), rate
    elif row.system == "bgx":
        rates = rate * np.sqrt(1 + ratio), rate
    elif row.system in ("gp_paper", "gp_equilibrium"):
        rates = (rate * np.sqrt(1 - ratio + ratio**2),) * 2
    else:
        return {}
    along, left = (float(2 * np.pi / x) for x in rates)
    return {"expected_period_along": along, "expected_period_left": left}


def growth_order(scales: Sequence[float], errors: Sequence[float]) -> float:
    """Return the power of the scale with which errors grow: the least-squares slope of their logarithms.

    Parameters
    ----------
    scales, errors : sequence of float
        Positive numbers, such as q = v/V and the largest error at that speed; two at least.

    Raises
    ------
    ValueError
        If there are fewer than two, or one is not positive.
    """
    x, y = np.asarray(scales, np.float64), np.asarray(errors, np.float64)
    if x.size < 2 or x.shape != y.shape or not ((x > 0).all() and (y > 0).all()):
        raise ValueError("two or more positive scales, and as many positive errors, are needed for an order of growth")
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def growth(rows: Sequence[Mapping[str, Any]], cases: Sequence[GyroCase]) -> list[dict[str, Any]]:
    """Fit the orders in q = v/sqrt(g R) with which errors grow over families of cases.

    A family are cases whose names end in ``_`` and a number to which their largest speeds are proportional: TE_1,
    TE_0.5, ...

    Parameters
    ----------
    rows : sequence of mapping
        Scores (`sinsbench.scoring.gyroscopic.FIELDS`) on the cases; those at their own intervals count.
    cases : sequence of GyroCase

    Returns
    -------
    list of dict
        Rows with the fields `GROWTH_FIELDS`, one for each subject and family of two cases at least.
    """
    by_name = {case.name: case for case in cases}
    scored = {(row["subject"], row["case"], row["interval"]): row for row in rows if row["status"] == "ok"}
    found = []
    for subject in dict.fromkeys(row["subject"] for row in rows):
        for family, members in _families(by_name).items():
            own = {name: scored.get((subject, name, float(by_name[name].interval))) for name in members}
            present = {name: row for name, row in own.items() if row is not None}
            if len(present) > 1 and _proportional(present, members):
                found.append(_grown(subject, family, list(present.values()), by_name[next(iter(present))]))
    return found


def _families(names: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    families: dict[str, dict[str, float]] = {}
    for name in names:
        if (matched := _MEMBER.fullmatch(name)) and float(matched[2]) > 0:
            families.setdefault(matched[1], {})[name] = float(matched[2])
    return families


def _proportional(rows: Mapping[str, Mapping[str, Any]], scales: Mapping[str, float]) -> bool:
    units = [row["speed_ratio_max"] / scales[name] for name, row in rows.items()]
    return len({scales[name] for name in rows}) > 1 and max(units) <= (1 + _PROPORTIONAL) * min(units)


def _grown(subject: str, family: str, rows: Sequence[Mapping[str, Any]], case: GyroCase) -> dict[str, Any]:
    shown = sorted((row for row in rows if row["system_error_max"]), key=lambda row: float(row["speed_ratio_max"]))
    told: dict[str, Any] = {"subject": subject, "family": family, "cases": len(shown)}
    theory = theory_of(subject)
    if theory is not None:
        steady = case.speed is not None and case.speed.constant is not None
        told["expected_order"] = getattr(theory, case.motion) if steady else theory.general
        told["law_expected_order"] = theory.law
    if len(shown) < 2:
        told["note"] = "that of the integration hides any error of the system"
        return plain_row(GROWTH_FIELDS, told)
    ratios, errors = ([float(row[name]) for row in shown] for name in ("speed_ratio_max", "system_error_max"))
    told |= {"speed_ratio_min": ratios[0], "speed_ratio_max": ratios[-1]}
    told |= {"error_min": errors[0], "error_max": errors[-1]}
    told["order"] = growth_order(ratios, errors)
    by_law = [(row["speed_ratio_max"], row["law_error_max"]) for row in shown if row["law_error_max"]]
    if theory is not None and theory.law is not None and len(by_law) > 1:
        told["law_order"] = growth_order(*zip(*by_law, strict=True))
    return plain_row(GROWTH_FIELDS, told)


@dataclass(frozen=True)
class Oscillation:
    """An oscillation about a straight line, fitted to an error.

    Attributes
    ----------
    period : float
        s.
    amplitude : float
        In the unit of the error.
    residual : float
        Root mean square of what is left, relative to the amplitude.
    """

    period: float
    amplitude: float
    residual: float


def oscillation(time: Array, error: Array, expected: float) -> Oscillation:
    """Measure the period of an error: that with which b + c t + A cos wt + B sin wt fits best.

    Parameters
    ----------
    time, error : ndarray, shape (n,)
        s, any unit.
    expected : float
        Period in whose surroundings (`SEARCHED`) it is looked for, s.

    Returns
    -------
    Oscillation

    Raises
    ------
    ValueError
        If the times span less than the longest period, which leaves a period undetermined.
    """
    from scipy.optimize import minimize_scalar

    shortest, longest = (expected * x for x in SEARCHED)
    span = float(time[-1] - time[0])
    if span < longest:
        raise ValueError(f"an error over {span:.9g} s cannot tell a period of up to {longest:.9g} s")
    scale = float(np.abs(error).max()) or 1.0
    x, y = (time - time[0]) / span, error / scale

    def fit(period: float) -> tuple[Array, Array]:
        angle = 2 * np.pi * span / period * x
        basis = np.column_stack([np.ones_like(x), x, np.cos(angle), np.sin(angle)])
        weights = np.linalg.lstsq(basis, y, rcond=None)[0]
        return weights, y - basis @ weights

    def misfit(period: float) -> float:
        return float(np.mean(fit(period)[1] ** 2))

    # The frequency resolution of the record is 1/span: several trial frequencies within each leave no valley unseen.
    trials = 1 / np.linspace(1 / longest, 1 / shortest, 2 + 8 * int(np.ceil(span * (1 / shortest - 1 / longest))))
    best = int(np.argmin([misfit(period) for period in trials]))
    bounds = trials[min(best + 1, len(trials) - 1)], trials[max(best - 1, 0)]
    # A misfit is flat at its minimum: a parabola through it is found to the square root of the rounding of its value.
    period = float(minimize_scalar(misfit, bounds=bounds, method="bounded", options={"xatol": 1e-7 * longest}).x)
    weights, left = fit(period)
    amplitude = float(np.hypot(weights[2], weights[3]))
    return Oscillation(period, amplitude * scale, float(np.sqrt(np.mean(left**2)) / amplitude))
