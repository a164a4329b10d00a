"""The mast's antenna on the page: the board, errors beside their bounds, consistency beside its band."""

import json
import re
from dataclasses import replace
from functools import cache

import altair as alt
import numpy as np
import pytest
from scipy.stats import chi2

from mast_estimates import SIZES, shifted
from sinsbench.report import mast, series
from sinsbench.report import page as pages
from sinsbench.report.boards import boards, own_interval
from sinsbench.report.figures import write_figures
from sinsbench.report.findings import checks
from sinsbench.report.results import ReportError, Results, read_results
from sinsbench.report.sections import sections
from sinsbench.scoring.mast import score_mast
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import BUILT_IN, MAST_ANTENNA, Subject
from sinsdata.cases import MastCase
from sinsdata.tiers import cases_of
from sinsdata.truth.mast import MastMotion, sampled

#: Estimators that know their errors, and that believe in a quarter of them.
HONEST, SURE = "honest", "sure"
SEEDS = ("seed_1000", "seed_1001")


@cache
def truth_of(name: str) -> MastMotion:
    return sampled(case_of(name))


def case_of(name: str) -> MastCase:
    (case,) = (case for case in cases_of("mast_antenna", "standard") if case.name == name)
    assert isinstance(case, MastCase)
    return case


def estimator(name: str) -> LoadedSubject:
    """Return an estimator whose errors are normal, with the standard deviations `SIZES` and nothing in common."""

    def estimate(inputs, start):
        truth = next(one for one in map(truth_of, SEEDS) if np.array_equal(one.start.mu, start.mu))
        rows = np.arange(0, len(truth.time), 200)
        random = np.random.default_rng([truth.case_name.encode()[-1], name == SURE])
        believed = SIZES / (4 if name == SURE else 1)
        errors = SIZES * random.normal(size=(len(rows), 17))
        return shifted(truth, rows, errors) | {"covariance": np.tile(np.diag(believed**2), (len(rows), 1, 1))}

    return LoadedSubject(Subject(name, MAST_ANTENNA, None, ""), estimate)


@pytest.fixture(scope="module")
def scores():
    rows = [
        row
        for name in SEEDS
        for subject in (SURE, HONEST)
        for row in score_mast(estimator(subject), case_of(name), truth_of(name), 0, warm=True)
    ]
    failed = {"status": "not finite", "message": "mu holds NaN, first at t = 3 s", "failed_at": 3.0}
    empty = {name: value if isinstance(value, str) else None for name, value in rows[0].items()}
    kept = {"interval": 0.01, "duration": 100.0, "satellites": 4}
    return rows + [{**empty, **kept, **failed, "subject": "printed", "case": name} for name in SEEDS]


@pytest.fixture(scope="module")
def made(scores):
    with pytest.MonkeyPatch.context() as patch:
        for name in (HONEST, SURE):
            patch.setitem(BUILT_IN, name, Subject(name, MAST_ANTENNA, None, ""))
        patch.setattr(series, "resolve", estimator)
        patch.setattr(series.mast, "sampled", lambda case: truth_of(case.name.removeprefix("my_")))
        yield {section.name: section for section in sections(Results(scores=scores))}


def test_the_board_ranks_by_the_antenna_and_tells_consistency(scores) -> None:
    (board,) = boards(own_interval(scores))
    own = {name: [row for row in scores if row["subject"] == name] for name in (HONEST, SURE)}
    for line in board.rows[:2]:
        rows = own[line["subject"]]
        assert line["antenna to level, rad"] == max(row["antenna_rms_late"] for row in rows)
        assert line["mean NEES at 100 s"] == np.mean([row["nees_joint_100s"] for row in rows])
    assert [line["rank"] for line in board.rows] == [1, 2, None]
    assert board.rows[2]["subject"] == "printed"
    assert board.rows[2]["failures"] == "not finite"
    assert "worst of the 2 cases" in board.caption


def test_a_time_counts_that_all_have_a_value_at(scores) -> None:
    shorter = [{**row, "nees_joint_100s": None} if row["subject"] == SURE else row for row in scores]
    (board,) = boards(shorter)
    assert "mean NEES at 50 s" in board.columns
    silent = [{**row, **{name: None for name in row if name.startswith("nees")}} for row in scores]
    assert not [name for name in boards(silent)[0].columns if "NEES" in name]


def test_errors_stand_beside_three_deviations(made) -> None:
    section = made["growth_mast_antenna"]
    rows = section.data["series_mast_antenna"]
    assert section.cases == SEEDS
    assert set(section.series) == {HONEST, SURE}
    assert {"printed"} == {name for name in ("printed", HONEST, SURE) if f" {name}." in section.text}
    for row in rows:
        # Three axes of 0.1 m/s, of which the other estimator believes a quarter; four digits are drawn.
        believed = 3 * 0.1 * 3**0.5 / (4 if row["subject"] == SURE else 1)
        assert row["bound_velocity"] == pytest.approx(believed, rel=1e-3)
    for name, least, most in ((HONEST, 0.0, 0.02), (SURE, 0.3, 1.0)):
        own = [row for row in rows if row["subject"] == name]
        assert (own[0]["time"], own[-1]["time"]) == (1, 100)
        beyond = np.mean([row["velocity"] > row["bound_velocity"] for row in own])
        assert least <= beyond <= most, name
    fields = {chart.name: str(chart.specification) for chart in section.charts}
    quantities = ("antenna", "mu", "nu", "mast", "position", "velocity")
    assert list(fields) == [f"growth_{name}" for name in (*quantities, "nees")]
    for name, text in fields.items():
        if name != "growth_nees":
            assert f"bound_{name.removeprefix('growth_')}" in text


def test_the_strip_is_the_band_of_so_many_runs(made) -> None:
    for name, chart, runs in (("growth_mast_antenna", "growth_nees", 1), ("mast_seeds", "seeds_joint", 2)):
        (drawn,) = (one for one in made[name].charts if one.name == chart)
        band = drawn.specification["datasets"]["bands"][0]
        assert band["low"] == pytest.approx(chi2.ppf(0.025, 16 * runs) / runs, rel=1e-12)
        assert band["high"] == pytest.approx(chi2.ppf(0.975, 16 * runs) / runs, rel=1e-12)
        assert f"strip: 95 % band of {'one run' if runs == 1 else 'the mean of 2 runs'}" == band["label"]
    assert made["mast_seeds"].charts[0].title == "NEES of all 16 errors (seed: mean of 2 runs)"


def test_means_over_the_seeds_are_those_of_the_scores(made, scores) -> None:
    rows = made["mast_seeds"].data["mast_seeds"]
    assert {(row["case"], row["time"], row["subject"]) for row in rows if row["told"]} == {
        ("seed", when, name) for when in (10, 50, 100) for name in (HONEST, SURE)
    }
    assert len(rows) > 100
    for row in (row for row in rows if row["told"]):
        own = [one[f"nees_mast_{row['time']:g}s"] for one in scores if one["subject"] == row["subject"]]
        assert row["nees_mast"] == pytest.approx(np.mean(own), rel=1e-3)  # four digits are drawn
    assert not any(row["fewer"] for row in rows)


def test_fewer_runs_than_the_band_is_of_are_hollow(scores) -> None:
    rows = [{**row, "status": "error"} if (row["subject"], row["case"]) == (SURE, SEEDS[1]) else row for row in scores]
    (section,) = (one for one in mast.sections(rows, []) if one.name == "mast_seeds")
    assert {row["subject"] for row in section.data["mast_seeds"] if row["fewer"]} == {SURE}
    # Nothing was run again: what is drawn is what the scores tell.
    assert {row["time"] for row in section.data["mast_seeds"] if row["told"]} == {10, 50, 100}
    assert len(section.data["mast_seeds"]) == 6


def test_only_what_was_scored_is_drawn_and_no_more_than_fits(scores, made, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(series, "_MOST_STEPS", 10_000)
    asked: list[str] = []
    rows = series.error_series(scores, lambda done, total, what: asked.append(f"{done + 1}/{total} {what}"))
    first = [row for row in scores if row["case"] == SEEDS[0] and row["status"] == "ok"]
    best = min(first, key=lambda row: row["antenna_rms_late"])
    assert {(row["case"], row["subject"]) for row in rows} == {(SEEDS[0], best["subject"])}
    assert asked == [f"1/1 errors over time: {best['subject']} on {SEEDS[0]}"]
    others = [{**row, "antenna_max_late": 10 * row["antenna_max_late"]} for row in scores if row["status"] == "ok"]
    assert series.error_series(others) == []


def test_other_runs_of_a_scenario_are_run_again_where_all_of_them_fit(
    scores, made, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(series, "CASES", 1)
    # Two estimators on 10,000 steps each: of 30,000 the second run would have one of them only.
    for steps, drawn in ((40_000, set(SEEDS)), (30_000, {SEEDS[0]})):
        monkeypatch.setattr(series, "_MOST_STEPS", steps)
        rows = series.error_series(scores)
        assert {row["case"] for row in rows} == drawn


def test_cases_of_a_file_are_drawn_where_the_file_is_named(scores, made, tmp_path) -> None:
    rows = [{**row, "case": f"my_{row['case']}"} for row in scores]
    (tmp_path / "scores.json").write_text(json.dumps(rows), encoding="utf-8")
    lines = [f'{{ name = "my_{name}", duration = 100, interval = "0.01", seed = {name[-4:]}}}' for name in SEEDS]
    (tmp_path / "mine.toml").write_text(f"case = [{', '.join(lines)}]", encoding="utf-8")
    results = read_results([tmp_path / "mine.toml", tmp_path / "scores.json"])
    assert list(results.cases["mast_antenna"]) == [f"my_{name}" for name in SEEDS]
    assert series.error_series(rows) == []
    assert {row["case"] for row in series.error_series(rows, cases=results.cases)} == {f"my_{name}" for name in SEEDS}
    (tmp_path / "other.toml").write_text('[[case]]\nname = "x"\nspin_rate = 1.0\n', encoding="utf-8")
    for files in (["scores.json", "other.toml"], ["other.toml"]):
        with pytest.raises(ReportError, match=r"other\.toml: ") as raised:
            read_results([tmp_path / name for name in files])
        assert "\n" not in str(raised.value)


def test_charts_are_valid_and_name_their_units(made) -> None:
    for name in ("growth_mast_antenna", "mast_seeds"):
        for chart in made[name].charts:
            alt.LayerChart.validate(dict(chart.specification))
            titles = set(re.findall(r'"title": "([^"]*)"', json.dumps(chart.specification)))
            assert {"time, s"} < titles
            squared = chart.name == "growth_nees" or chart.name.startswith("seeds")
            wanted = "normalised estimation error squared" if squared else r"error of .*, (rad|m/s|m)"
            assert any(re.fullmatch(wanted, title) for title in titles), titles


def test_figures_are_the_same_twice(made, tmp_path) -> None:
    chosen = [
        replace(made[name], charts=made[name].charts[:1], cases=made[name].cases[:1])
        for name in ("growth_mast_antenna", "mast_seeds")
    ]
    first, second = (write_figures(chosen, tmp_path / name) for name in ("first", "second"))
    names = ("growth_antenna_seed_1000", "seeds_joint_seed")
    assert [path.name for path in first] == [f"{name}{kind}" for name in names for kind in (".svg", ".png")]
    for path, again in zip(first, second, strict=True):
        assert path.read_bytes() == again.read_bytes()
    for path in first[::2]:
        text = path.read_text(encoding="utf-8")
        assert all(name in text for name in (HONEST, SURE))
    assert "95 % band of the mean of 2 runs" in first[2].read_text(encoding="utf-8")


def test_the_page_holds_it_all(made, scores, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "libraries", str)  # what draws is not looked at here
    html = pages.page(Results(scores=scores), tuple(made.values())).html
    charts = json.loads(re.findall(r'id="charts">(.*?)</script>', html)[0])["charts"]
    assert {"growth_antenna", "growth_nees", "seeds_joint", "seeds_mast"} <= set(charts)
    for text in ("NaN, first at t = 3 s", "mean NEES at 100 s", "3 methods on 2 cases, 6 runs; 2 failed"):
        assert text in html


def test_one_of_a_thing_is_one(scores) -> None:
    (check,) = checks(Results(scores=scores[:1]))
    assert check.found == "1 method on 1 case, 1 run; 0 failed"
    assert (check.section, check.holds) == (mast.NAME, True)
