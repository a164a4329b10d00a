"""The command's tables, thresholds and work-precision tables, as a user meets them."""

import json
from dataclasses import replace

import pytest

from sinsbench.cli import run
from sinsbench.cli.scores import score_tables, work_precision_tables
from sinsbench.scoring.score import score
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

ARGUMENTS = ["score", "panov2", "panov4", "--case", "variant1_coning"]


@pytest.fixture(scope="module")
def scored(tmp_path_factory):
    """One run with thresholds that hold for one subject and not for the other."""
    path = tmp_path_factory.mktemp("scores") / "scores.json"
    return path, [*ARGUMENTS, "--json", str(path)]


def test_thresholds_decide_the_exit_status(scored, capsys, monkeypatch):
    path, arguments = scored
    monkeypatch.setenv("COLUMNS", "140")
    required = ["--require", "drift_deg_per_h<1", "--require", "status==ok", "--work-precision"]
    assert run([*arguments, *required]) == 1
    printed = capsys.readouterr().out
    missed = [line for line in printed.splitlines() if line.startswith("does not hold")]
    assert len(missed) == 1
    assert "panov2 on variant1_coning at 0.01 s: drift_deg_per_h is 205.0" in missed[0]
    assert missed[0].endswith("required < 1.0")
    assert max(map(len, printed.splitlines())) <= 141
    assert "work and precision on variant1_coning" in printed
    assert "cheapest on variant1_coning" in printed
    rows = json.loads(path.read_text(encoding="utf-8"))
    for row in rows:
        assert row["flops_per_second"] == pytest.approx(row["flops_per_sample"] / row["interval"])
        assert row["relative_cost"] == pytest.approx(row["ns_per_sample"] / row["calibration_ns"])
        assert row["ns_per_sample_median"] >= row["ns_per_sample"] > 0


def test_thresholds_that_hold_change_nothing(capsys):
    assert run([*ARGUMENTS[:1], *ARGUMENTS[2:], "--require", "drift_deg_per_h<0.2"]) == 0
    assert "does not hold" not in capsys.readouterr().out


@pytest.mark.parametrize("condition", ["drift<1", "drift_deg_per_h<low", "drift_deg_per_h"])
def test_a_condition_that_means_nothing_is_one_line(condition, capsys):
    assert run([*ARGUMENTS, "--require", condition]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert len(told.err.splitlines()) == 1
    assert condition in told.err


@pytest.fixture(scope="module")
def made():
    cases = [case for case in paper_cases("dual_precession") if case.name.startswith("variant2")]
    cases = [replace(case, duration=ExactNumber("0.64")) for case in cases]
    return cases, score(["panov2", "panov6_compensated"], cases)


def test_tables_show_each_row_once(made):
    cases, rows = made
    [(title, table)] = score_tables(rows, cases)
    assert title.endswith("sampled every 0.01 s")
    assert [(line["subject"], line["case"]) for line in table] == [
        (subject, case.name) for case in cases for subject in ("panov2", "panov6_compensated")
    ]
    [(title, table)] = score_tables(rows, cases, whole_ladder=True)
    assert len(table) == len(rows)
    assert "interval, s" in table[0]


def test_work_precision_tables_come_in_pairs_a_case(made):
    cases, rows = made
    tables = work_precision_tables(rows)
    assert [title.split(" (")[0] for title, _ in tables] == [
        f"{what} on {case.name}" for case in cases for what in ("work and precision", "cheapest")
    ]
    for _, table in tables[1::2]:
        assert table
        # The tighter the error, the more it costs.
        costs = [
            float(line["flops a second"].removeprefix("<= ")) for line in table if line["error at most"].endswith("rad")
        ]
        assert costs == sorted(costs)


def test_rows_that_failed_stand_in_the_table_but_not_in_work_and_precision():
    rows = score(["panov2"], [replace(next(iter(paper_cases("dual_precession"))), duration=ExactNumber("0.02"))])
    assert {row["status"] for row in rows} == {"not applicable", "ok"}
    cases = [next(iter(paper_cases("dual_precession")))]
    [(_, table)] = score_tables(rows, cases)
    assert table[0]["status"] == "not applicable"
    assert "less than a step" in table[0]["message"]


def test_the_order_by_theory_stands_behind_the_observed_one(made):
    cases, _ = made
    rows = score(["savage3"], cases[:1], repetitions=0)
    [(_, table)] = score_tables(
        [one | {"observed_order": 3.021, "secular_observed_order": 3.58} for one in rows], cases
    )
    assert (table[0]["order"], table[0]["secular order"], table[0]["narrow cone"]) == ("3.02 (3)", "3.58 (4)", 6)
