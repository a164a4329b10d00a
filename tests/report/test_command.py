"""The command: page and figures on disk, complaints in one line, nothing half-written."""

import re
import shlex
from pathlib import Path

import pytest

from sinsbench.cli import run
from sinsbench.report import write

DOCUMENTATION = Path(__file__).resolve().parents[2] / "docs" / "report.md"


def test_every_command_of_its_documentation_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```console\n(.*?)```", DOCUMENTATION.read_text(encoding="utf-8"), flags=re.DOTALL)
    for command in block.splitlines():
        program, *arguments = shlex.split(command)
        assert program == "sinsbench"
        assert run(arguments) == 0, command
    assert [path.name for path in Path("page").iterdir()] == ["report.html"]
    assert {path.name for path in Path("drawn").iterdir()} >= {"claims.svg", "claims.png", "stability_growth.svg"}
    said = capsys.readouterr().out
    assert f"The page is {Path('page', 'report.html')}.\n" in said
    assert f"{len(list(Path('drawn').iterdir()))} figures are in drawn.\n" in said


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ([], "Missing argument 'RESULT...'"),
        (["nowhere.json"], "nowhere.json: there is no such file"),
        (["text.json"], "text.json: not JSON"),
        (["claims.json", "--out", "text.json"], "text.json: a folder is needed, and this is a file"),
        (["claims.json", "--figures", "text.json"], "text.json: a folder is needed, and this is a file"),
    ],
)
def test_mistakes_are_told_in_one_line(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    complaint: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.json").write_text("no JSON", encoding="utf-8")
    Path("claims.json").write_bytes((folder / "claims.json").read_bytes())
    assert run(["report", *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert complaint in told.err
    assert told.err.count("\n") == 1
    assert sorted(path.name for path in Path.cwd().iterdir()) == ["claims.json", "text.json"]


def test_an_interruption_leaves_the_old_page(results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / write.PAGE).write_text("old", encoding="utf-8")

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(write, "page", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write.write_report(type(results)(claims=results.claims), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [write.PAGE]
    assert (tmp_path / write.PAGE).read_text(encoding="utf-8") == "old"
