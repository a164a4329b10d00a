"""The fields of a row of scores: name, unit and meaning, as data."""

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

__all__ = ["FIELDS", "SCORE_FIELDS", "STATUSES", "Field", "plain_row", "row"]

STATUSES = (
    *("ok", "error", "wrong shape", "not finite", "not applicable"),
    *("timeout", "crashed", "out of memory", "not installed"),
)
"""What may become of a subject: it ran; it raised; its result has another form, or holds NaN; it declined the case.
Of one that runs elsewhere also: it was stopped; its process died; it asked for too much memory; it is not there."""


class Field(NamedTuple):
    """One field of a row."""

    name: str
    unit: str
    meaning: str


FIELDS = (
    Field("subject", "", "name of the subject"),
    Field("dataset", "", "name of the dataset"),
    Field("case", "", "name of the case"),
    Field("interval", "s", "sampling interval; for formulas the distance of the epochs"),
    Field("samples_per_step", "", "samples one step of the integrator consumes"),
    Field(
        "attitude_error_max",
        "rad",
        "largest angle between computed and true attitude, not below the input floor",
    ),
    Field("attitude_error_end", "rad", "that angle at the last epoch"),
    Field("drift_deg_per_h", "deg/h", "attitude_error_end over the time since the start"),
    Field(
        "velocity_error_max",
        "m/s",
        "largest norm of the velocity error: inertial axes, or north, up and east",
    ),
    Field("velocity_error_end", "m/s", "that norm at the last epoch"),
    Field("observed_order", "", "least-squares slope of attitude_error_max over the ladder, floor excluded"),
    Field("order_residual", "log2", "root mean square deviation from that slope, in powers of two"),
    Field(
        "at_floor",
        "",
        "whether rounding sets attitude_error_max (formulas: that of inputs and result sets velocity_error_max)",
    ),
    Field("ns_per_sample", "ns", "least time over the repetitions, a sample (formulas: an epoch)"),
    Field("flops_per_sample", "", "floating-point operations a sample, counted by running the subject's own source"),
    Field("status", "", f"one of: {', '.join(STATUSES)}"),
    Field("message", "", "what went wrong, in one line"),
    Field("version", "", "version of a subject that runs elsewhere"),
    Field("secular_drift_deg_per_h", "deg/h", "rate of the secular part of the attitude error, periodic parts apart"),
    Field("attitude_periodic_max", "rad", "largest attitude error once the secular part is taken off"),
    Field(
        "secular_velocity_rate",
        "m/s^2",
        "what the secular part of the velocity error, inertial axes, gains over the run, divided by its duration",
    ),
    Field("velocity_periodic_max", "m/s", "largest velocity error once the secular part is taken off"),
    Field(
        "rate_needed_hz",
        "Hz",
        "lowest sampling rate from which on drift_deg_per_h is at most 0.001, interpolated on the ladder",
    ),
    Field("rate_needed_note", "", "how rate_needed_hz was extrapolated, or why there is none"),
    Field("ns_per_sample_median", "ns", "median time over the repetitions, a sample"),
    Field("calibration_ns", "ns", "time of one quaternion product in a compiled loop, taken beside ns_per_sample"),
    Field("relative_cost", "", "ns_per_sample over calibration_ns: quaternion products that a sample costs"),
    Field("flops_note", "", "why flops_per_sample is not known"),
    Field("state_bytes", "B", "size of what is carried from one step to the next"),
    Field("flops_per_second", "1/s", "floating-point operations a second of motion"),
    Field("ns_per_second", "ns/s", "least time a second of motion"),
    Field("takes", "", "input convention that the integrator was fed"),
    Field("order_points", "", "rungs of the ladder that observed_order rests on"),
    Field("order_note", "", "why there is no observed_order"),
    Field("local_order", "", "slope of attitude_error_max to the next coarser interval"),
    Field(
        "floor",
        "rad",
        "floor of attitude_error_max: that of the inputs or, where seen and larger, of rounding",
    ),
    Field("input_floor", "rad", "attitude error that the rounding of the inputs alone causes, largest"),
    Field("velocity_body_error_max", "m/s", "largest norm of the error of the velocity in body axes"),
    Field("velocity_body_error_end", "m/s", "that norm at the last epoch"),
    Field(
        "secular_observed_order",
        "",
        "as observed_order, of secular_drift_deg_per_h: the order that coefficients optimised for coning raise",
    ),
    *(
        Field(f"secular_{name}", unit, f"as {name}, of secular_drift_deg_per_h")
        for name, unit in (
            ("order_residual", "log2"),
            ("order_points", ""),
            ("order_note", ""),
            ("local_order", ""),
            ("floor", "deg/h"),
            ("at_floor", ""),
            ("input_floor", "deg/h"),
        )
    ),
    Field("expected_order", "", "order of attitude_error_max in general motion, by theory (built-in integrators)"),
    Field("secular_expected_order", "", "as expected_order, of secular_drift_deg_per_h"),
    Field(
        "narrow_cone_order",
        "",
        "order of secular_drift_deg_per_h on pure coning to the square of the half-angle, by theory: that of "
        "coefficients optimised for coning, if they are",
    ),
    Field("velocity_expected_order", "", "as expected_order, of velocity_error_max"),
    Field("velocity_observed_order", "", "as observed_order, of velocity_error_max"),
    Field("velocity_order_residual", "log2", "as order_residual, of velocity_error_max"),
    Field("velocity_order_points", "", "as order_points, of velocity_error_max"),
    Field("velocity_order_note", "", "as order_note, of velocity_error_max"),
    Field("velocity_local_order", "", "as local_order, of velocity_error_max"),
    Field("velocity_floor", "m/s", "as floor, of velocity_error_max"),
    Field("velocity_input_floor", "m/s", "as input_floor, of velocity_error_max"),
    Field("velocity_at_floor", "", "as at_floor, of velocity_error_max"),
    Field(
        "gyro_bias_deg_per_h",
        "deg/h",
        "norm of the constant gyro bias, body axes, nearest to the attitude errors",
    ),
    Field(
        "accelerometer_bias_ug",
        "ug",
        "norm of the constant accelerometer bias nearest to the velocity errors",
    ),
    Field("predicted_drift_deg_per_h", "deg/h", "asymptotic drift_deg_per_h"),
    Field("predicted_secular_drift_deg_per_h", "deg/h", "asymptotic secular_drift_deg_per_h"),
    Field("predicted_velocity_error_end", "m/s", "asymptotic velocity_error_end"),
    Field("quaternion_norm_error_max", "", "largest deviation of the quaternion's norm from 1"),
    Field("error_dv_north_max", "m/s", "largest error of dv_N"),
    Field("error_dv_up_max", "m/s", "largest error of dv_H"),
    Field("error_dv_east_max", "m/s", "largest error of dv_E"),
    Field("error_d_height_max", "m", "largest error of dH"),
    Field("error_d_latitude_max", "rad", "largest error of dphi"),
    Field("error_d_longitude_max", "rad", "largest error of dlambda"),
    Field("scd", "digits", "significant correct digits at the last epoch: -log10 of the largest relative error"),
    Field(
        "mescd",
        "digits",
        "the same with mixed errors |e| / (s + |x|), s = sqrt(g R), R, 1 for velocity, height, angle",
    ),
    Field("ulp_max", "ulp", "largest error in units in the last place of the true value, where that is not zero"),
)

SCORE_FIELDS = tuple(field.name for field in FIELDS)
"""Names of the fields; every row has all of them, None where one does not apply."""


def row(**values: Any) -> dict[str, Any]:
    """Return a row with every field of `FIELDS`; see `plain_row`."""
    return plain_row(FIELDS, values)


def plain_row(fields: Iterable[Field], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row with every field, of plain values; NaN and infinity become None.

    Raises
    ------
    KeyError
        For a name that is not a field.
    """
    names = [field.name for field in fields]
    unknown = set(values).difference(names)
    if unknown:
        raise KeyError(f"no such fields: {', '.join(sorted(unknown))}")
    return {name: _plain(values.get(name)) for name in names}


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def merged(*parts: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row from several groups of fields."""
    return row(**{name: value for part in parts for name, value in part.items()})
