"""The whole of scoring: rows for everything, whatever the subjects do."""

import json
import warnings
from dataclasses import replace
from fractions import Fraction

import pytest

from sinsbench.scoring.rows import FIELDS, STATUSES, row
from sinsbench.scoring.score import SCORE_FIELDS, score
from sinsbench.subjects.loading import SubjectError
from sinsbench.subjects.registry import subjects_of
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

REQUIRED = (
    "subject", "dataset", "case", "interval", "samples_per_step", "attitude_error_max", "attitude_error_end",
    "drift_deg_per_h", "velocity_error_max", "velocity_error_end", "observed_order", "order_residual", "at_floor",
    "ns_per_sample", "flops_per_sample", "status", "message",
)  # fmt: skip

SUBJECTS = """
import warnings
import numpy as np
from sinsbench.subjects.integrators import panov4

def good(*inputs): return panov4(*inputs)
def raises(*inputs): raise RuntimeError("out of fuel")
def nan(*inputs): return {**panov4(*inputs), "velocity_body": np.full((len(inputs[0]) // 4 + 1, 3), np.nan)}
def transposed(*inputs): return panov4(*inputs)["attitude"].T
def off_by_one(*inputs): return panov4(*inputs)["attitude"][1:]
def quits(*inputs): raise SystemExit("bye")
def nothing(*inputs): pass
def noisy(*inputs):
    warnings.warn("beware")
    print("hello")
    return panov4(*inputs)
def coarse_only(angle, *inputs):
    if len(angle) > 64: raise MemoryError("too long")
    return panov4(angle, *inputs)
"""
STATUS = {
    "good": "ok",
    "raises": "error",
    "nan": "not finite",
    "transposed": "wrong shape",
    "off_by_one": "wrong shape",
    "quits": "error",
    "nothing": "wrong shape",
    "noisy": "ok",
}
FACTORS = (Fraction(1), Fraction(1, 2), Fraction(1, 4))


@pytest.fixture(scope="module")
def short():
    case = next(case for case in paper_cases("dual_precession") if case.name == "variant2_general")
    return replace(case, duration=ExactNumber("0.64"))


@pytest.fixture
def planted(tmp_path):
    path = tmp_path / "planted.py"
    path.write_text(SUBJECTS, encoding="utf-8")
    return path


def test_fields():
    assert SCORE_FIELDS[: len(REQUIRED)] == REQUIRED
    assert len(set(SCORE_FIELDS)) == len(SCORE_FIELDS)
    assert all(field.meaning for field in FIELDS)


def test_rows_are_plain():
    made = row(subject="x", floor=float("nan"), scd=float("inf"))
    assert tuple(made) == SCORE_FIELDS
    assert (made["floor"], made["scd"], made["case"]) == (None, None, None)
    with pytest.raises(KeyError, match="flor"):
        row(flor=1.0)


def test_planted_subjects(short, planted, capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = score([f"{planted}:{name}" for name in STATUS], [short], factors=FACTORS)
    assert capsys.readouterr().out == ""
    assert len(found) == len(STATUS) * len(FACTORS)
    for one in found:
        name = one["subject"].rpartition(":")[2]
        assert one["status"] == STATUS[name]
        assert one["status"] in STATUSES
        assert (one["message"] is None) == (one["status"] == "ok")
        assert (one["attitude_error_max"] is None) == (one["status"] != "ok")
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    messages = {one["subject"].rpartition(":")[2]: one["message"] for one in found}
    assert messages["raises"] == "RuntimeError: out of fuel (planted.py, line 7)"
    assert "initial row" in messages["off_by_one"]


def test_rungs_fail_one_by_one(short, planted):
    found = score([f"{planted}:coarse_only"], [short], factors=(*FACTORS, Fraction(2), Fraction(4)))
    assert [one["status"] for one in found] == ["ok"] * 3 + ["error"] * 2
    assert found[0]["order_points"] == 3
    assert found[0]["observed_order"] == pytest.approx(4, abs=0.1)


def test_progress_counts_to_the_end(short):
    calls = []
    score(["panov2", "panov4"], [short, short], lambda *call: calls.append(call), factors=(Fraction(1),))
    assert [done for done, _, _ in calls] == list(range(7))
    assert {total for _, total, _ in calls} == {6}
    assert calls[-1] == (6, 6, "done")


def test_both_datasets():
    case = replace(next(iter(paper_cases("equator_errors"))), duration=ExactNumber(600))
    names = ["equator_printed", "equator_robust", "ode45_1e-3"]
    found = score(names, [case])
    assert [one["subject"] for one in found] == names
    assert [one["status"] for one in found] == ["ok"] * 3
    assert all(one["ns_per_sample"] > 0 for one in found)
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_all_built_in_subjects_by_default(short):
    found = score(None, [short], factors=(Fraction(1),), repetitions=0)
    assert {one["subject"] for one in found} == {subject.name for subject in subjects_of("dual_precession")}
    assert {one["status"] for one in found} == {"ok"}
    assert {one["ns_per_sample"] for one in found} == {None}


def test_wrong_usage(short):
    with pytest.raises(SubjectError, match="equator_robust is a subject of equator_errors"):
        score(["equator_robust"], [short])
    with pytest.raises(SubjectError, match="did you mean"):
        score(["panov44"], [short])
    with pytest.raises(ValueError, match="unknown dataset 'dual'"):
        score(["panov4"], "dual")
    with pytest.raises(ValueError, match="one dataset"):
        score(["panov4"], [])
    with pytest.raises(ValueError, match="one dataset"):
        score(["panov4"], [short, paper_cases("equator_errors")[0]])
