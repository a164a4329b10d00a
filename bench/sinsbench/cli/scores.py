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
    "attitude max, rad": "attitude_error_max",
    "drift, deg/h": "drift_deg_per_h",
    "asymptotic drift": "predicted_drift_deg_per_h",
    "velocity end, m/s": "velocity_error_end",
    "asymptotic velocity": "predicted_velocity_error_end",
    "order": "observed_order",
    "at floor": "at_floor",
    "ns a sample": "ns_per_sample",
    "flops a sample": "flops_per_sample",
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
    "input floor, rad": "input_floor",
    "at floor": "at_floor",
    "velocity max, m/s": "velocity_error_max",
    "velocity local order": "velocity_local_order",
    "velocity input floor, m/s": "velocity_input_floor",
    "status": "status",
    "message": "message",
}
_TITLES = {
    "dual_precession": "integrators on dual_precession (errors against certified truth)",
    "equator_errors": "solvers on equator_errors (largest errors against certified truth)",
}


def _pick(rows: Sequence[Mapping[str, Any]], columns: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return the rows with the headings people read; columns that are empty throughout are left out."""
    used = {heading: field for heading, field in columns.items() if any(row[field] not in (None, "") for row in rows)}
    return [{heading: _shown(field, row[field]) for heading, field in used.items()} for row in rows]


def _shown(field: str, value: Any) -> Any:
    """Return an order with two decimals, everything else as it is."""
    return (
        f"{value:.2f}"
        if field in ("observed_order", "local_order", "velocity_local_order") and value is not None
        else value
    )


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
        if own:
            tables.append((_TITLES[dataset], _pick(own if whole_ladder else native(own, known), columns)))
    return tables
