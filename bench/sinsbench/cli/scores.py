"""Scores as tables for people: units in the headings, the case's own interval unless the ladder is asked for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sinsbench.subjects.registry import GYRO_SYSTEMS, MAST_ANTENNA
from sinsdata.cases import Case

#: Heading -> field, for subjects of `dual_precession`.
INTEGRATOR_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "drift, deg/h": "drift_deg_per_h",
    "secular drift": "secular_drift_deg_per_h",
    "velocity end, m/s": "velocity_error_end",
    "order": "observed_order",
    "secular order": "secular_observed_order",
    "narrow cone": "narrow_cone_order",
    "rate needed, Hz": "rate_needed_hz",
    "ns a sample": "ns_per_sample",
    "relative cost": "relative_cost",
    "flops a sample": "flops_per_sample",
    "version": "version",
    "status": "status",
    "message": "message",
}
#: Heading -> field, for the errors of subjects of `equator_errors`.
EQUATOR_ERRORS = {
    "dv_N, m/s": "error_dv_north_max",
    "dv_H, m/s": "error_dv_up_max",
    "dv_E, m/s": "error_dv_east_max",
    "dH, m": "error_d_height_max",
    "dphi, rad": "error_d_latitude_max",
    "dlambda, rad": "error_d_longitude_max",
}
#: The same for everything that is told of them.
FORMULA_COLUMNS = {
    "subject": "subject",
    "case": "case",
    **EQUATOR_ERRORS,
    "scd": "scd",
    "mescd": "mescd",
    "ulp": "ulp_max",
    "ns a row": "ns_per_sample",
    "status": "status",
    "message": "message",
}
#: Heading -> field, for subjects of `gyro_systems`: errors of the vertical in m, of the angles in arcsec.
GYROSCOPIC_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "1 h, m": "vertical_error_1h_m",
    "2 h, m": "vertical_error_2h_m",
    "4 h, m": "vertical_error_4h_m",
    "max, m": "vertical_error_max_m",
    "heading, arcsec": "heading_error_max_arcsec",
    "pitch, arcsec": "pitch_error_max_arcsec",
    "roll, arcsec": "roll_error_max_arcsec",
    "order": "observed_order",
    "ns a step": "ns_per_step",
}
#: The same for the whole ladder of sampling intervals.
GYROSCOPIC_LADDER_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "max, m": "vertical_error_max_m",
    "along, m": "vertical_error_along_max_m",
    "left, m": "vertical_error_left_max_m",
    "system, rad": "system_error_max",
    "attitude, rad": "attitude_error_max",
    "speed, m/s": "speed_error_max",
    "order": "observed_order",
    "residual": "order_residual",
}
#: Heading -> field, for the responses of subjects of `gyro_systems`.
RESPONSE_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "error": "error",
    "size": "size",
    "1 h, m": "response_1h_m",
    "2 h, m": "response_2h_m",
    "4 h, m": "response_4h_m",
    "max, m": "response_max_m",
}
#: The same for their periods.
PERIOD_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "error": "error",
    "along the velocity, s": "period_along",
    "to the left of it, s": "period_left",
}
#: Heading -> field, for the growth of errors with the speed.
GROWTH_COLUMNS = {
    "subject": "subject",
    "family": "family",
    "cases": "cases",
    "q from": "speed_ratio_min",
    "to": "speed_ratio_max",
    "error from, rad": "error_min",
    "to, rad": "error_max",
    "order in q": "order",
    "of the law": "law_order",
    "note": "note",
}
#: Heading -> field, for estimators on `mast_antenna`: the second half of a motion, root mean squares.
MAST_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "mu, rad": "mu_rms_late",
    "nu, rad": "nu_rms_late",
    "antenna, rad": "antenna_rms_late",
    "mast, rad": "mast_rms_late",
    "position, m": "position_rms_late",
    "NIS": "nis_ratio",
    "us a step": "us_per_step",
}
#: The same over the seeds of a scenario, where the band of the NEES is that of their number.
MAST_SUMMARY_COLUMNS = {
    "subject": "subject",
    "family": "family",
    "runs": "cases",
    "failed": "failed",
    "mu, rad": "mu_rms_late",
    "antenna, rad": "antenna_rms_late",
    "mast, rad": "mast_rms_late",
    "NEES at 10 s": "nees_joint_10s",
    "50 s": "nees_joint_50s",
    "100 s": "nees_joint_100s",
    "1000 s": "nees_joint_1000s",
    "its band": "band",
}
#: Heading -> field, for what no score was taken of.
_TOLD = {"subject": "subject", "case": "case", "interval, s": "interval", "status": "status", "message": "message"}
#: The same for the whole ladder of sampling intervals.
LADDER_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "interval, s": "interval",
    "attitude max, rad": "attitude_error_max",
    "local order": "local_order",
    "fitted order": "observed_order",
    "residual": "order_residual",
    "secular local order": "secular_local_order",
    "input floor, rad": "input_floor",
    "at floor": "at_floor",
    "velocity max, m/s": "velocity_error_max",
    "velocity local order": "velocity_local_order",
    "status": "status",
    "message": "message",
}
#: The same for work against precision.
WORK_COLUMNS = {
    "subject": "subject",
    "interval, s": "interval",
    "attitude max, rad": "attitude_error_max",
    "drift, deg/h": "drift_deg_per_h",
    "at floor": "at_floor",
    "flops a second": "flops_per_second",
    "ns a second": "ns_per_second",
    "relative cost": "relative_cost",
    "state, B": "state_bytes",
    "not counted because": "flops_note",
}
#: Observed order or period -> the one by theory, which stands behind it in brackets.
_THEORY = {
    "observed_order": "expected_order",
    "secular_observed_order": "secular_expected_order",
    "order": "expected_order",
    "law_order": "law_expected_order",
    "period_along": "expected_period_along",
    "period_left": "expected_period_left",
}
_DIGITS = 3  # of the numbers on `gyro_systems` and `mast_antenna`
_TITLES = {
    "dual_precession": "integrators on dual_precession (errors against certified truth)",
    "equator_errors": "solvers on equator_errors (largest errors against certified truth)",
    GYRO_SYSTEMS: "gyroscopic systems on gyro_systems (errors of the vertical; largest ones of the angles)",
    MAST_ANTENNA: "estimators on mast_antenna (root mean squares of the second half of the motion)",
}


def _pick(
    rows: Sequence[Mapping[str, Any]], columns: Mapping[str, str], digits: int | None = None
) -> list[dict[str, Any]]:
    """Return the rows with the headings people read; columns that say nothing throughout are left out.

    With `digits`, numbers are given to so many significant ones.
    """
    nothing = (None, "", "ok")
    used = {heading: field for heading, field in columns.items() if any(row[field] not in nothing for row in rows)}
    return [{heading: _shown(field, row, digits) for heading, field in used.items()} for row in rows]


def _shown(field: str, row: Mapping[str, Any], digits: int | None) -> Any:
    """Return an order or period with two decimals, and that of theory if there is one; everything else as it is."""
    value, theory = row[field], row.get(_THEORY.get(field, ""))
    if value is None or not (field in _THEORY or field.endswith("local_order")):
        return _rounded(value, digits) if digits and isinstance(value, float) and field != "interval" else value
    known = "" if theory is None else f" ({theory:.2f})" if isinstance(theory, float) else f" ({theory})"
    return f"{value:.2f}{known}"


def _rounded(value: float, digits: int) -> str:
    """Return a number with so many significant digits, without a power of ten from 1e-4 up to a million."""
    shown = f"{value:.{digits}g}"
    return f"{float(shown):.0f}" if 10**digits <= abs(value) < 1e6 else shown


def native(rows: Sequence[Mapping[str, Any]], cases: Iterable[Case]) -> list[Mapping[str, Any]]:
    """Return the rows at the cases' own sampling intervals, and those without an interval."""
    intervals = {case.name: float(case.interval) for case in cases}
    return [row for row in rows if row["interval"] in (None, intervals[row["case"]])]


def score_tables(
    rows: Sequence[Mapping[str, Any]], cases: Iterable[Case], *, whole_ladder: bool = False
) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return titled tables, one a dataset, of rows that were scored on `cases`."""
    known = tuple(cases)
    tables = []
    integrators = LADDER_COLUMNS if whole_ladder else INTEGRATOR_COLUMNS
    systems = GYROSCOPIC_LADDER_COLUMNS if whole_ladder else GYROSCOPIC_COLUMNS
    for dataset, columns in (
        ("dual_precession", integrators),
        ("equator_errors", FORMULA_COLUMNS),
        (GYRO_SYSTEMS, systems),
        (MAST_ANTENNA, MAST_COLUMNS),
    ):
        own: Sequence[Mapping[str, Any]] = [row for row in rows if row["dataset"] == dataset]
        own = own if whole_ladder else native(own, known)
        if own and dataset == GYRO_SYSTEMS:
            tables += _with_words(_TITLES[dataset], own, columns)
            tables += growth_tables(rows, known)
        elif own and dataset == MAST_ANTENNA:
            tables += _with_words(_TITLES[dataset], own, columns)
            tables += mast_summary_tables(own)
        elif own:
            tables.append(_titled(_TITLES[dataset], _pick(own, columns)))
    return tables


def _with_words(
    title: str, rows: Sequence[Mapping[str, Any]], columns: Mapping[str, str]
) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return the rows with numbers in a titled table, and what others say instead in a second."""
    scored = [row for row in rows if row["status"] == "ok"]
    told = [row for row in rows if row["message"]]
    parts = ((title, scored, columns), ("no score, or not the whole of it", told, _TOLD))
    tables = [_titled(heading, _pick(some, names, _DIGITS)) for heading, some, names in parts if some]
    # Narrow enough for a window of 100 columns.
    return [_shared(heading, table, "case", "{}, {}") for heading, table in tables]


def response_tables(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return titled tables of responses and of their periods."""
    rows = [{**row, "size": f"{row['size']:g} {row['unit']}" if row["unit"] else None} for row in rows]
    tables = _with_words("responses to errors: the vertical against that without the error", rows, RESPONSE_COLUMNS)
    swinging = [row for row in rows if row["period_along"] or row["period_left"]]
    schuler = ", ".join(dict.fromkeys(f"{row['schuler_period']:.2f} s" for row in rows))
    title = f"periods of these responses, by theory in brackets; Schuler period {schuler}"
    return [*tables, *([(title, _pick(swinging, PERIOD_COLUMNS))] if swinging else [])]


def growth_tables(rows: Sequence[Mapping[str, Any]], cases: Sequence[Case]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return a titled table of orders in the speed, where rows of `gyro_systems` hold a family of cases."""
    from sinsbench.scoring.gyroscopic_growth import growth
    from sinsdata.cases import GyroCase

    own = [row for row in rows if row["dataset"] == GYRO_SYSTEMS]
    found = growth(own, [case for case in cases if isinstance(case, GyroCase)])
    title = "growth of the systems' own errors of the vertical with q = v/sqrt(g R), order by theory in brackets"
    return [(title, _pick(found, GROWTH_COLUMNS, _DIGITS))] if found else []


def mast_summary_tables(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return a titled table of medians and of the consistency, where rows of `mast_antenna` hold several seeds."""
    from sinsbench.scoring.mast_summary import summary

    found = [
        {
            **row,
            "failed": row["failed"] or None,
            "band": f"{row['nees_joint_low']:.1f} to {row['nees_joint_high']:.1f}" if row["nees_joint_low"] else None,
        }
        for row in summary(rows)
    ]
    title = "over the seeds: medians, mean NEES of 16 degrees of freedom, its band of 95 per cent"
    return [_shared(title, _pick(found, MAST_SUMMARY_COLUMNS, _DIGITS), "family", "{}, {}")] if found else []


def _titled(title: str, table: list[dict[str, Any]]) -> tuple[str, list[dict[str, Any]]]:
    """Return title and table; an interval that all rows share stands in the title."""
    return _shared(title, table, "interval, s", "{}, sampled every {:g} s")


def _shared(title: str, table: list[dict[str, Any]], column: str, form: str) -> tuple[str, list[dict[str, Any]]]:
    """Return title and table; a value of a column that all rows share stands in the title."""
    values = {row.get(column) for row in table}
    if len(values) > 1 or None in values:
        return title, table
    rest = [{name: value for name, value in row.items() if name != column} for row in table]
    return form.format(title, values.pop()), rest


def work_precision_tables(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return two titled tables for each case of integrators: what every rung costs, and who is cheapest at an error.

    Costs are those of a second of motion.
    """
    from sinsbench.scoring.work_precision import cheapest

    measured = [row for row in rows if row["dataset"] == "dual_precession" and row["status"] == "ok"]
    tables = []
    for case in dict.fromkeys(row["case"] for row in measured):
        own = [row for row in measured if row["case"] == case]
        tables.append((f"work and precision on {case}", _pick(own, WORK_COLUMNS)))
        best = [
            {
                "error at most": f"{one.level.value:g} {one.level.unit}",
                "fewest operations": one.by_flops.subject,
                "flops a second": one.by_flops.shown,
                "least time": one.by_time.subject,
                "ns a second": one.by_time.shown,
                "reached by": one.reached_by,
            }
            for one in cheapest(own)
        ]
        tables.append((f"cheapest on {case} (interpolated along the ladders; costs a second of motion)", best))
    return tables
