"""Result files: what they hold decides, not their names; the later file counts; complaints in one line."""

import json
from pathlib import Path

import pytest

from sinsbench.report.results import ReportError, positive, read_results, real


def write(path: Path, document: object) -> Path:
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_a_folder_holds_results_of_every_kind(results, scores) -> None:
    assert results.scores == scores
    kinds = (results.claims, results.mutants, results.stories, results.datasets, results.checks, results.runs)
    assert [len(rows) for rows in kinds] == [4, 3, 1, 1, 2, 2]
    assert results.environment["machine"] == "riscv64"


def test_a_later_file_replaces_the_same_subject_on_the_same_case(tmp_path: Path) -> None:
    def row(subject: str, case: str, error: float) -> dict[str, object]:
        names = {"subject": subject, "dataset": "d", "case": case, "interval": 0.1, "status": "ok"}
        return {**names, "attitude_error_max": error}

    first = write(tmp_path / "1.json", [row("a", "x", 1.0), row("a", "x", 2.0), row("b", "x", 3.0)])
    second = write(tmp_path / "2.json", [row("a", "x", 4.0), row("a", "y", 5.0)])
    found = [(x["subject"], x["case"], x["attitude_error_max"]) for x in read_results([first, second]).scores]
    assert sorted(found) == [("a", "x", 4.0), ("a", "y", 5.0), ("b", "x", 3.0)]


def test_answers_of_gyroscopic_systems_are_told_from_scores(tmp_path: Path) -> None:
    row = {"subject": "a", "dataset": "gyro_systems", "case": "x", "interval": 1, "status": "ok", "error": "gyro"}
    found = read_results([write(tmp_path / "1.json", [{**row, "response_max_m": 1.0}])])
    assert (len(found.responses), len(found.scores)) == (1, 0)


@pytest.mark.parametrize(
    ("document", "complaint"),
    [
        ({"of": "something else"}, "it is a result: what score, claims"),
        ([{"subject": "a"}, {"case": "b"}], "it is a result"),
        ("text", "it is a result"),
        ([1, 2], "it is a result"),
    ],
)
def test_what_is_no_result_is_refused_in_one_line(tmp_path: Path, document: object, complaint: str) -> None:
    path = write(tmp_path / "x.json", document)
    with pytest.raises(ReportError) as raised:
        read_results([path])
    assert complaint in str(raised.value)
    assert str(raised.value).startswith(str(path))
    assert "\n" not in str(raised.value)


def test_missing_and_broken_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(ReportError, match=r"nowhere\.json: there is no such file"):
        read_results([tmp_path / "nowhere.json"])
    (tmp_path / "broken.json").write_text("{", encoding="utf-8")
    with pytest.raises(ReportError, match=r"broken\.json: not JSON: Expecting"):
        read_results([tmp_path])
    (tmp_path / "broken.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ReportError, match=r"broken\.json: not JSON"):
        read_results([tmp_path])


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "x.json", {"of": "something else"})
    with pytest.raises(ReportError, match="no file in it is a result"):
        read_results([tmp_path])


def test_numbers_that_have_no_place_on_an_axis() -> None:
    row = {"a": 1, "b": 0.0, "c": True, "d": "1", "e": float("nan"), "f": None, "g": -2.5}
    assert [real(row, name) for name in "abcdefgh"] == [1.0, 0.0, None, None, None, None, -2.5, None]
    assert [positive(row, name) for name in "abg"] == [1.0, None, None]
