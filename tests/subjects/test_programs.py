"""Programs as subjects: what they are given, what they may give back, and all that can go wrong on the way."""

import json
import shutil
import stat
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from sinsbench.cli import run
from sinsbench.elsewhere.programs import numbered, program
from sinsbench.scoring.runs import inputs_of
from sinsbench.scoring.score import score
from sinsbench.subjects.loading import SubjectError
from sinsbench.subjects.processes import Limits, run_process
from sinsdata.tiers import paper_cases
from sinsdata.truth.sampling import sample
from sinsref.exact import ExactNumber

ROOT = Path(__file__).resolve().parents[2]
TWO_SAMPLE = f"{ROOT / 'examples' / 'two_sample.py'}:two_sample"
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
FACTORS = (Fraction(1), Fraction(1, 2))
OWN = (Fraction(1),)
HEADER = ",".join(QUATERNION)


@pytest.fixture(scope="module")
def short():
    case = next(case for case in paper_cases("dual_precession") if case.name == "variant2_general")
    return replace(case, duration=ExactNumber("0.64"))


@pytest.fixture(scope="module")
def inputs(short):
    """What an integrator of increments is called with."""
    return inputs_of(sample(short, Fraction(1), None, "increments"), 64)


@pytest.fixture
def write(tmp_path):
    """Write a Python program, and return the command that runs it without the site packages."""

    def write(source, name="prog.py"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(source, encoding="utf-8")
        return f'"{sys.executable}" -S "{path}"'

    return write


def scored(command, case, factors=OWN, **options):
    return score([program(command, "dual_precession", **options)], [case], factors=factors)


def failed(command, case, **options):
    (row,) = scored(command, case, **options)
    message = row["message"] or ""
    assert "\n" not in message
    return row["status"], message


def output(*lines, header=HEADER):
    """Return a program that writes these lines for what there are 64 samples."""
    text = "\n".join([header, *lines]) + "\n"
    return f"import sys\nsys.stdin.read()\nsys.stdout.write({text!r})"


GOOD = ("1,0,0,0",) * 33


def cells(line, cell):
    return (*GOOD[: line - 2], f"1,{cell},0,0", *GOOD[line - 1 :])


@pytest.mark.parametrize(
    ("source", "status", "message"),
    [
        (output(*GOOD), "ok", ""),
        (output(*cells(5, "nan")), "not finite", "output.csv, line 5, column q_x: nan"),
        (output(*cells(5, "-inf")), "not finite", "output.csv, line 5, column q_x: -inf"),
        (output(*cells(7, "abc")), "wrong shape", "output.csv, line 7, column q_x: 'abc' is no number"),
        (output(*cells(7, "")), "wrong shape", "output.csv, line 7, column q_x: '' is no number"),
        (output(*cells(7, "0,0")), "wrong shape", "output.csv, line 7 has 5 cells; the header has 4"),
        (output(*GOOD, "1,0"), "wrong shape", "output.csv, line 35 has 2 cells; the header has 4"),
        (output(*GOOD[1:]), "wrong shape", "is the initial row missing?"),
        (output(*GOOD[:30]), "wrong shape", "attitude has shape (30, 4)"),
        (output(), "wrong shape", "attitude has shape (0, 4)"),
        (output(*GOOD, header="a,b,c,d"), "wrong shape", "names no column of q_w, q_x"),
        (output(*GOOD, header="q_w,q_x,q_y,d"), "wrong shape", "output.csv has no column q_z"),
        (output(*GOOD, header="q_w,q_w,q_y,q_z"), "wrong shape", "names a column twice: q_w"),
        (output(*(f"{x},{k}" for k, x in enumerate(GOOD)), header=f"{HEADER},sample"), "ok", ""),
        (output(*(f"{x},{-k}" for k, x in enumerate(GOOD)), header=f"{HEADER},sample"), "wrong shape",
         "rows out of order, sample -1 after 0"),
        (output(*(f"{x},2e-3" for x in GOOD), header=f"{HEADER},seconds"), "ok", ""),
        (output(*(f"{x},-1" for x in GOOD), header=f"{HEADER},seconds"), "wrong shape", "one positive number"),
        ("", "wrong shape", "output.csv is empty: no standard output, and the command names no {output}"),
        ("print()", "wrong shape", "begins with a blank line"),
        ("import os; os.write(1, bytes(range(256)) * 999)", "wrong shape", "names no column of"),
        ("print('Hello, world'); print(1)", "wrong shape", "it says 'Hello,world'"),
        ("import sys; sys.exit('bad input')", "error", "exit status 1: bad input"),
        ("import sys; sys.exit(3)", "error", "exit status 3"),
        ("import sys; sys.exit('x\\nTypeError: no number\\n  at main.js:1\\n\\nNode.js v24.0.0')", "error",
         "exit status 1: TypeError: no number"),
        ("import sys; sys.exit('Node.js v24.0.0')", "error", "exit status 1: Node.js v24.0.0"),
        ("import sys; sys.exit('RangeError: Array buffer allocation failed')", "out of memory", "allocation failed"),
        ("import os; os.abort()", "crashed", "killed by SIGABRT"),
        ("x = [bytes(10**7) for _ in range(10**4)]", "out of memory", "exit status 1: MemoryError"),
        ("while True: print('x' * 10**5)", "error", "File too large"),
    ],
)  # fmt: skip
def test_what_a_program_writes(write, short, source, status, message):
    found = failed(write(source), short, limits=Limits(memory=200_000_000, output=1_000_000))
    assert found[0] == status
    assert message in found[1]


def test_a_flood_that_knows_no_limit_ends_at_the_limit(short, write):
    endless = shutil.which("yes")
    command = (
        "yes" if endless else write("import signal; signal.signal(signal.SIGXFSZ, signal.SIG_DFL)\nwhile 1: print('y')")
    )
    assert failed(command, short, limits=Limits(output=1_000_000)) == ("error", "wrote more than 1 MB")


def test_numbers_as_other_languages_write_them(write, short):
    rows = [*GOOD[:-4], "+1.0E+00, 0 ,-0.,.0", "1.0D+00,0.D0,0,-0.0d-00", "1e0,0x0p0,0,0", GOOD[0]]
    status, message = failed(write(output(*rows)), short)
    assert (status, message) == ("wrong shape", "output.csv, line 33, column q_x: '0x0p0' is no number")
    rows[-2] = "1e0,0,0,0"
    assert failed(write(output(*rows)), short)[0] == "ok"


def test_line_ends_marks_and_blank_lines_do_not_matter(write, short):
    source = output(*GOOD, "", header='\ufeff q_w , q_x,"q_y",q_z').replace("\\n", "\\r\\n")
    assert (
        failed(write(source.replace("import sys", "import sys; sys.stdout.reconfigure(encoding='utf-8')")), short)[0]
        == "ok"
    )


def test_an_output_that_is_removed_or_never_written(write, short):
    silent = write("import sys; print('nothing to say', file=sys.stderr)", "silent.py")
    message = "exit status 0, but it wrote no output.csv: nothing to say"
    assert failed(f"{silent} {{input}} {{output}}", short) == ("error", message)
    removes = write("import os, sys; open(sys.argv[1], 'w').close(); os.remove(sys.argv[1])", "removes.py")
    assert failed(f"{removes} {{output}}", short)[1] == "exit status 0, but it wrote no output.csv"


def test_programs_that_are_not_there_or_cannot_be_run(tmp_path, short, monkeypatch):
    assert failed("no-such-program {input} {output}", short) == ("not installed", "there is no program no-such-program")
    path = tmp_path / "prog"
    path.write_bytes(b"\0\1\2")
    assert failed(f'"{path}"', short) == ("error", f"{path} is not executable")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    assert failed(f'"{path}"', short) == ("error", f"cannot run {path}: Exec format error")
    monkeypatch.chdir(tmp_path)
    assert failed("prog", short) == ("not installed", "prog is not on the search path; write ./prog")


def test_no_shell_reads_the_command(write, short, tmp_path):
    show = write("import sys; sys.exit(' '.join(sys.argv[1:]))")
    message = failed(f"{show} '$HOME' ';' 'a  b' --in={{input}} {{output}} {{other}} > x", short)[1]
    assert message.startswith("exit status 1: $HOME ; a b --in=/")
    assert message.endswith("output.csv {other} > x")


def test_a_hang_is_waited_for_once_on_a_ladder(write, short):
    command = write("import time; time.sleep(1000)")
    first, *rest = scored(command, short, FACTORS, limits=Limits(timeout=0.5))
    assert (first["status"], first["message"]) == ("timeout", "stopped after 0.5 s")
    assert {row["status"] for row in rest} == {"timeout"}
    assert rest[0]["message"] == "not run: with 64 rows it was stopped after 0.5 s"


def test_a_program_that_is_given_whole_steps(write, short):
    # 64 samples are 21 steps of 3 and one sample, which this program would not accept.
    source = "import sys\nrows = len(sys.stdin.readlines()) - 1\nif rows % 3: sys.exit(f'{rows} rows')\n"
    source += f"print({HEADER!r})\nfor _ in range(rows // 3 + 1): print('1,0,0,0')"
    assert failed(write(source), short) == ("error", "exit status 1: 64 rows")
    (row,) = scored(write(source), short, samples_per_step=3)
    assert (row["status"], row["samples_per_step"]) == ("ok", 3)


def test_time_that_a_program_tells(write, short):
    rows = scored(write(output(*(f"{x},2e-3" for x in GOOD), header=f"{HEADER},seconds")), short)
    assert rows[0]["ns_per_sample"] == pytest.approx(2e-3 / 64 * 1e9)


def test_time_that_is_taken(write, inputs, monkeypatch):
    """The start, that of the shortest run, is taken off: what is left here is a millisecond a sample."""

    def clocked(command, folder, limits, rows, stdin, stdout):
        finished = run_process(command, folder, limits, rows, stdin, stdout)
        samples = len(stdin.read_text().splitlines()) - 1
        return replace(finished, seconds=0.05 + 1e-3 * samples)

    monkeypatch.setattr("sinsbench.elsewhere.programs.run_process", clocked)
    source = f"import sys\nrows = len(sys.stdin.readlines()) - 1\nprint({HEADER!r})\n"
    source += "for _ in range(rows // 2 + 1): print('1,0,0,0')"
    outcome = program(write(source), "dual_precession").function(*inputs)
    assert outcome.result["attitude"].shape == (33, 4)
    assert min(outcome.seconds) == pytest.approx(0.064)


def test_names(tmp_path, monkeypatch):
    assert list(numbered(["a", "b", "a", "a"])) == ["a", "b", "a 2", "a 3"]
    monkeypatch.chdir(tmp_path)
    Path("mine.js").touch()
    for command, name in (("node mine.js {input}", "mine.js"), ("./prog x", "prog"), ("/usr/bin/other", "other")):
        assert program(command, "dual_precession").subject.name == name
    assert program("prog", "dual_precession", name="mine").subject.name == "mine"


@pytest.mark.parametrize(
    ("command", "options", "message"),
    [
        ("", {}, "needs a program"),
        ("prog 'x", {}, "No closing quotation"),
        ("prog", {"suffix": "xlsx"}, "admissible are csv, parquet, arrow"),
        ("prog", {"suffix": "parquet"}, r"write \{input\} and \{output\}"),
        ("prog", {"takes": "nonsense"}, "no input convention 'nonsense'"),
    ],
)
def test_usage(command, options, message):
    with pytest.raises(ValueError, match=message) as caught:
        program(command, "dual_precession", **options)
    assert isinstance(caught.value, SubjectError) or "takes" in options


@pytest.fixture
def dataset(tmp_path, monkeypatch):
    """A dataset with one short case, in the working directory."""
    monkeypatch.chdir(tmp_path)
    numbers = {"spin_rate": 1, "precession_ratio": 2, "nutation": 0.1, "spin_rate_dual": 0, "nutation_dual": 0}
    lines = [*(f"{name} = {float(value)}" for name, value in numbers.items()), "initial_velocity = [0.0, 0.0, 0.0]"]
    Path("cases.toml").write_text(
        "\n".join(["[[case]]", 'name = "short"', *lines, 'interval = "0.01"', 'duration = "0.64"'])
    )
    assert run(["generate", "dual_precession", "--cases", "cases.toml", "--out", "data"]) == 0
    return "data/dual_precession/sweep"


def test_the_command_line(write, dataset, capsys):
    capsys.readouterr()
    good, hangs = write(output(*GOOD), "good.py"), write("import time; time.sleep(1000)", "hangs.py")
    arguments = ["score", "panov4", "--command", good, "--command", good, "--command", hangs, "--on", dataset]
    arguments += ["--name", "first", "--timeout", "8", "--json", "rows.json"]
    assert run(arguments) == 1  # one that was stopped
    rows = json.loads(Path("rows.json").read_text(encoding="utf-8"))
    found = {row["subject"]: row["status"] for row in rows if row["interval"] == 0.01}
    assert list(found) == ["panov4", "first", "good.py", "hangs.py"]
    assert found["panov4"] == found["first"] == "ok"
    assert found["hangs.py"] == "timeout"
    assert "stopped after 8 s" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--command", "prog"], "say what to score prog on: --on dual_precession"),
        (
            ["--command", "prog", "--on", "dual_precession", "--name", "a", "--name", "b"],
            "--name b: there are 1 programs",
        ),
        (["--command", "", "--on", "dual_precession"], "needs a program"),
        (["--command", "prog", "--on", "dual_precession", "--format", "xls"], "--format xls: admissible are csv"),
        (["--command", "prog", "--on", "dual_precession", "--timeout", "-1"], "timeout = -1.0: a positive number"),
        (["--command", "prog", "--on", "dual_precession", "--memory", "0"], "memory = 0: a positive number"),
        (["--command", "prog", "--on", "dual_precession", "--takes", "rate"], "there is no input convention 'rate'"),
        (["two_sample", "--samples-per-step", "2"], "--samples-per-step 2 is for programs"),
        (["two_sample", "--format", "arrow"], "--format arrow is for programs"),
    ],
)
def test_wrong_usage_is_one_line(arguments, message, capsys):
    assert run(["score", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
