"""Results that were computed beforehand: the rows of each case, each once, in order and whole."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sinsbench.cli import run
from sinsbench.elsewhere.files import FORMATS, write_columns
from sinsbench.elsewhere.results import result_file
from sinsbench.scoring.score import score
from sinsbench.subjects.loading import SubjectError
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import equator_truth, sample
from sinsref.exact import ExactNumber

QUATERNION = ["q_w", "q_x", "q_y", "q_z"]
STATES = ["dv_north", "dv_up", "dv_east", "d_height", "d_latitude", "d_longitude"]
STEP = 4


@pytest.fixture(scope="module")
def cases():
    found = [case for case in paper_cases("dual_precession") if case.name in ("variant1_coning", "variant2_general")]
    return [replace(case, duration=ExactNumber("0.64")) for case in found]


@pytest.fixture(scope="module")
def frame(cases):
    """Truth at every fourth sample, to which the score is the floor of the inputs."""
    parts = []
    for case in cases:
        motion = sample(case)
        part = pd.DataFrame(motion.attitude[::STEP], columns=QUATERNION)
        parts.append(part.assign(case=case.name, sample=np.arange(0, 65, STEP), time=motion.time[::STEP]))
    return pd.concat(parts, ignore_index=True)


def stored(frame, path):
    """Store a frame in the format of the suffix."""
    columns = {name: frame[name].to_numpy() for name in frame.columns}
    if path.suffix == ".csv":
        frame.to_csv(path, index=False, float_format="%.17g", na_rep="nan")
    else:
        write_columns(columns, path)
    return path


def scored(frame, cases, tmp_path, name="mine.csv", **options):
    loaded = result_file(stored(frame, tmp_path / name), "dual_precession", [case.name for case in cases], **options)
    return score([loaded], cases, repetitions=0)


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("dropped", ["sample", "time", "neither"])
def test_truth_itself_scores_the_floor(frame, cases, tmp_path, suffix, dropped):
    rows = scored(frame.drop(columns=dropped, errors="ignore"), cases, tmp_path, f"mine.{suffix}")
    assert [row["case"] for row in rows] == [case.name for case in cases]  # and no other interval
    for row in rows:
        assert (row["status"], row["subject"], row["interval"], row["samples_per_step"]) == (
            "ok", f"mine.{suffix}", 0.01, STEP,
        )  # fmt: skip
        assert row["attitude_error_max"] < 1e-14
        assert row["observed_order"] is None
        assert row["ns_per_sample"] is None


def test_beside_a_subject_that_climbs_the_ladder(frame, cases, tmp_path):
    loaded = result_file(stored(frame, tmp_path / "mine.csv"), "dual_precession", [case.name for case in cases])
    rows = score(["panov4", loaded], cases[:1], repetitions=0)
    assert len([row for row in rows if row["subject"] == "mine.csv"]) == 1
    assert len([row for row in rows if row["subject"] == "panov4"]) > 1


def first_case(frame, change):
    """Return the rows of the first case changed, and the others as they are."""
    mine = frame["case"] == "variant1_coning"
    return pd.concat([change(frame[mine]), frame[~mine]], ignore_index=True)


@pytest.mark.parametrize(
    ("change", "status", "message"),
    [
        (lambda x: x.drop(x.index[3]), "wrong shape", "1 row missing of 17, the first of them sample 12"),
        (lambda x: x.iloc[2:], "wrong shape", "2 rows missing of 17, the first of them sample 0"),
        (lambda x: x.iloc[:-1], "wrong shape", "1 row missing of 17, the first of them sample 64"),
        (lambda x: x.iloc[:1], "wrong shape", "rows missing of 65, the first of them sample 1"),
        (lambda x: pd.concat([x, x.tail(1)]), "wrong shape", "sample 64 stands twice"),
        (lambda x: pd.concat([x, x.tail(1).assign(sample=68)]), "wrong shape", "sample 68 is none of this case's"),
        (lambda x: pd.concat([x.head(1).assign(sample=-4), x]), "wrong shape", "sample -4 is none of this case's"),
        (lambda x: x.assign(sample=x["sample"] + 0.5), "wrong shape", "sample 0.5 is none of this case's"),
        (lambda x: x.iloc[::-1], "wrong shape", "rows out of order, sample 60 after 64"),
        (lambda x: x.assign(sample=np.nan), "wrong shape", "rows out of order, sample nan after nan"),
        (lambda x: x.assign(q_y=np.nan), "not finite", "mine.csv, line 2, column q_y: nan"),
        (lambda x: x.iloc[:0], "not applicable", "mine.csv holds no case variant1_coning"),
    ],
)
def test_rows_that_are_not_those_of_the_case(frame, cases, tmp_path, change, status, message):
    bad, good = scored(first_case(frame, change), cases, tmp_path)
    assert bad["status"] == status
    assert message in bad["message"]
    assert good["status"] == "ok"


def test_rows_between_the_steps_are_surplus(frame, cases, tmp_path):
    extra = frame.head(1).assign(sample=5)
    ordered = pd.concat([frame.head(2), extra, frame.iloc[2:]], ignore_index=True)
    row, _ = scored(ordered, cases, tmp_path)
    assert "variant1_coning: 1 row surplus of 17, the first of them sample 5" in row["message"]


def test_times_may_be_rounded_but_not_wrong(frame, cases, tmp_path):
    rounded = frame.drop(columns="sample").assign(time=lambda x: x["time"] + 1e-6)
    assert {row["status"] for row in scored(rounded, cases, tmp_path)} == {"ok"}
    shifted = frame.drop(columns="sample").assign(time=lambda x: x["time"] + 1e-4)
    message = scored(shifted, cases, tmp_path)[0]["message"]
    assert "time 0.0001 is none of this case's" in message


def test_the_line_of_a_bad_number_is_that_of_the_file(frame, cases, tmp_path):
    frame = frame.copy()
    frame.loc[20, "q_w"] = np.inf
    _, row = scored(frame, cases, tmp_path)
    assert (row["status"], row["message"]) == ("not finite", "mine.csv, line 22, column q_w: inf")


def test_samples_off_the_grid_are_known_by_their_times(cases, tmp_path):
    motion = sample(cases[0], convention="nonuniform")
    frame = pd.DataFrame(motion.attitude, columns=QUATERNION).assign(case=cases[0].name, time=motion.time)
    (row,) = scored(frame, cases[:1], tmp_path, takes="nonuniform")
    assert (row["status"], row["samples_per_step"]) == ("ok", 1)
    (row,) = scored(frame.assign(time=np.arange(len(frame)) * 0.01), cases[:1], tmp_path, takes="nonuniform")
    assert "is none of this case's" in row["message"]


@pytest.mark.parametrize(
    ("convention", "dropped"), [("increments", "sample"), ("increments", "time"), ("nonuniform", "sample")]
)
def test_steps_that_do_not_divide_the_samples(cases, tmp_path, convention, dropped):
    motion = sample(cases[0], convention=convention)
    frame = pd.DataFrame(motion.attitude[::3], columns=QUATERNION)
    frame = frame.assign(case=cases[0].name, sample=np.arange(0, 65, 3), time=motion.time[::3])
    (row,) = scored(frame.drop(columns=dropped), cases[:1], tmp_path, takes=convention)
    assert (row["status"], row["samples_per_step"]) == ("ok", 3)


def test_solvers_of_the_error_equations(tmp_path):
    cases = [replace(case, duration=case.interval) for case in paper_cases("equator_errors")[:2]]
    truths = [equator_truth(case) for case in cases]
    frame = pd.concat(
        pd.DataFrame(truth.state, columns=STATES).assign(case=case.name, time=truth.time)
        for case, truth in zip(cases, truths, strict=True)
    )
    path = stored(frame, tmp_path / "mine.parquet")
    rows = score([result_file(path, "equator_errors", [case.name for case in cases])], cases)
    assert [(row["status"], row["ulp_max"] <= 1) for row in rows] == [("ok", True)] * 2
    path = stored(frame.iloc[1:], tmp_path / "mine.parquet")
    first, second = score([result_file(path, "equator_errors", [case.name for case in cases])], cases)
    assert "1 row missing of 2, the first of them time 0" in first["message"]
    assert second["status"] == "ok"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "there is no file mine.csv"),
        ("q_w;q_x;q_y;q_z;case;sample\n", "are the cells separated by commas?"),
        ("", "mine.csv is empty"),
        ("a,b\n1,2\n", "names no column of q_w"),
        ("q_w,q_x,q_y,q_z,sample\n1,0,0,0,0\n", "mine.csv has no column case"),
        (
            "case,q_w,q_x,q_y,q_z\nother,1,0,0,0\n",
            "holds none of the cases to score on (variant1_coning); it holds other",
        ),
        ("case,sample,q_w,q_x,q_y,q_z\nvariant1_coning,0,1,0,0,x\n", "line 2, column q_z: 'x' is no number"),
    ],
)
def test_files_that_are_no_results(tmp_path, text, message):
    path = tmp_path / "mine.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(SubjectError) as caught:
        result_file(path, "dual_precession", ["variant1_coning"])
    assert message in str(caught.value)


def test_columns_that_are_missing_are_a_row(frame, cases, tmp_path):
    row, _ = scored(frame.drop(columns="q_z"), cases, tmp_path)
    assert row["message"] == "mine.csv has no column q_z"
    row, _ = scored(frame.drop(columns=["sample", "time"]), cases, tmp_path)
    assert row["message"] == "mine.csv has no column sample or time"


def test_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["generate", "dual_precession", "--tier", "short", "--out", "data"]) == 0
    folder = Path("data/dual_precession/short")
    truth = pd.read_parquet(next(folder.glob("truth*")))
    names = truth["case"].unique()[:2]
    mine = truth[truth["case"] == names[0]]
    stored(mine[["case", "sample", *QUATERNION]], Path("mine.parquet"))
    arguments = ["--on", str(folder), "--case", names[0], "--case", names[1], "--json", "rows.json"]
    assert run(["score", "--result", "mine.parquet", "--name", "mine", *arguments]) == 0
    found = json.loads(Path("rows.json").read_text(encoding="utf-8"))
    assert [(row["subject"], row["case"], row["status"]) for row in found] == [
        ("mine", names[0], "ok"),
        ("mine", names[1], "not applicable"),
    ]
    capsys.readouterr()
    assert run(["score", "--result", "mine.parquet", "--on", str(folder), "--case", names[1]]) == 2
    assert "holds none of the cases to score on" in capsys.readouterr().err
