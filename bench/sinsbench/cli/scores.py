"""Scores as tables for people: units in the headings, the case's own interval unless the ladder is asked for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

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
#: Heading -> field, for subjects of `equator_errors`.
FORMULA_COLUMNS = {
    "subject": "subject",
    "case": "case",
    "dv_N, m/s": "error_dv_north_max",
    "dv_H, m/s": "error_dv_up_max",
    "dv_E, m/s": "error_dv_east_max",
    "dH, m": "error_d_height_max",
    "dphi, rad": "error_d_latitude_max",
    "dlambda, rad": "error_d_longitude_max",
    "scd": "scd",
    "mescd": "mescd",
    "ulp": "ulp_max",
    "ns a row": "ns_per_sample",
    "status": "status",
    "message": "message",
}
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
#: Observed order -> the one by theory, which stands behind it in brackets.
_THEORY = {"observed_order": "expected_order", "secular_observed_order": "secular_expected_order"}
_TITLES = {
    "dual_precession": "integrators on dual_precession (errors against certified truth)",
    "equator_errors": "solvers on equator_errors (largest errors against certified truth)",
}


def _pick(rows: Sequence[Mapping[str, Any]], columns: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return the rows with the headings people read; columns that say nothing throughout are left out."""
    nothing = (None, "", "ok")
    used = {heading: field for heading, field in columns.items() if any(row[field] not in nothing for row in rows)}
    return [{heading: _shown(field, row) for heading, field in used.items()} for row in rows]


def _shown(field: str, row: Mapping[str, Any]) -> Any:
    """Return an order with two decimals, and that of theory if there is one; everything else as it is."""
    value, theory = row[field], row[_THEORY[field]] if field in _THEORY else None
    if value is None or not field.endswith(("observed_order", "local_order")):
        return value
    return f"{value:.2f}" if theory is None else f"{value:.2f} ({theory})"


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
    for dataset, columns in (("dual_precession", integrators), ("equator_errors", FORMULA_COLUMNS)):
        own: Sequence[Mapping[str, Any]] = [row for row in rows if row["dataset"] == dataset]
        own = own if whole_ladder else native(own, known)
        if own:
            tables.append(_titled(_TITLES[dataset], _pick(own, columns)))
    return tables


def _titled(title: str, table: list[dict[str, Any]]) -> tuple[str, list[dict[str, Any]]]:
    """Return title and table; an interval that all rows share stands in the title."""
    intervals = {row.get("interval, s") for row in table}
    if len(intervals) > 1 or None in intervals:
        return title, table
    shared = f"{title}, sampled every {intervals.pop():g} s"
    return shared, [{name: value for name, value in row.items() if name != "interval, s"} for row in table]


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
