"""Thresholds: what is understood, what is refused, what holds."""

import pytest

from sinsbench.scoring.requirements import RequirementError, parse_requirement, violations
from sinsbench.scoring.rows import row


def made(**fields):
    return row(**{"subject": "mine", "case": "cone", "interval": 0.01, "status": "ok", **fields})


@pytest.mark.parametrize(
    ("text", "fields", "holds"),
    [
        ("drift_deg_per_h<1e-3", {"drift_deg_per_h": 9e-4}, True),
        ("drift_deg_per_h<1e-3", {"drift_deg_per_h": 1e-3}, False),
        (" drift_deg_per_h <= 1e-3 ", {"drift_deg_per_h": 1e-3}, True),
        ("observed_order>3.9", {"observed_order": 4.0}, True),
        ("observed_order>=4", {"observed_order": 3.99}, False),
        ("samples_per_step==4", {"samples_per_step": 4}, True),
        ("status==ok", {}, True),
        ("status==ok", {"status": "timeout"}, False),
        ("status==not applicable", {"status": "not applicable"}, True),
        ("at_floor==no", {"at_floor": False}, True),
        ("at_floor==false", {"at_floor": True}, False),
        ("at_floor<1", {"at_floor": False}, False),
        ("message<1", {"message": "text"}, False),
        ("drift_deg_per_h<1e-3", {}, False),
        ("drift_deg_per_h<1e-3", {"drift_deg_per_h": float("nan")}, False),
    ],
)
def test_conditions(text, fields, holds):
    assert parse_requirement(text).holds(made(**fields)) == holds


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("drift<1e-3", "did you mean"),
        ("drift_deg_per_hour<1", "drift_deg_per_h"),
        ("qqqqqqqq<1", "no field 'qqqqqqqq'"),
        ("drift_deg_per_h<small", "'small' is no number"),
        ("drift_deg_per_h<nan", "finite"),
        ("drift_deg_per_h<", "write FIELD<NUMBER"),
        ("drift_deg_per_h", "write FIELD<NUMBER"),
        ("drift_deg_per_h=1", "write FIELD<NUMBER"),
        ("", "write FIELD<NUMBER"),
    ],
)
def test_what_is_refused(text, says):
    with pytest.raises(RequirementError, match=says) as caught:
        parse_requirement(text)
    assert "\n" not in str(caught.value)


def test_lines_of_what_does_not_hold():
    wanted = [parse_requirement("drift_deg_per_h<1e-3"), parse_requirement("observed_order>=3.9")]
    rows = [
        made(drift_deg_per_h=0.158948191, observed_order=4.0),
        made(subject="other", status="timeout", message="stopped"),
        made(subject="good", drift_deg_per_h=1e-5, observed_order=6.0),
    ]
    assert violations(wanted, rows) == [
        "does not hold: mine on cone at 0.01 s: drift_deg_per_h is 0.158948, required < 0.001",
        "does not hold: other on cone at 0.01 s: drift_deg_per_h has no value (timeout), required < 0.001",
        "does not hold: other on cone at 0.01 s: observed_order has no value (timeout), required >= 3.9",
    ]
    assert violations([], rows) == []
