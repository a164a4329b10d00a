"""Functions that hang, crash, eat memory or flood the disk, in processes of their own. All of it happens."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import psutil
import pytest

from sinsbench.scoring.score import score
from sinsbench.subjects.isolated import isolated_subject
from sinsbench.subjects.isolation import Limits, describe_elsewhere, run_elsewhere
from sinsbench.subjects.loading import SubjectError
from sinsbench.subjects.outcome import OutcomeError
from sinsbench.subjects.processes import LimitsError, Patience, run_process
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

PYTHON = Path(sys.executable)
PATIENCE = 60.0  # s; what is waited for comes within a fraction of a second unless the machine is very busy
TWO_SAMPLE = f"{Path(__file__).resolve().parents[2] / 'examples' / 'two_sample.py'}:two_sample"


@pytest.fixture
def write(tmp_path):
    def write(text, name="mine.py"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The folder for temporary files, in which nothing may be left behind."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    return folder


def called(path, *arguments, **options):
    return run_elsewhere(PYTHON, f"{path}:f", arguments, **options)


def refusal(path, *arguments, **options):
    with pytest.raises(OutcomeError) as caught:
        called(path, *arguments, **options)
    assert "\n" not in str(caught.value)
    return caught.value.status, str(caught.value)


def gone(pid):
    """Whether a process ends; one that is dead but was not fetched by its parent counts as ended."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.01)
    return False


def test_what_goes_and_comes(write, temporary):
    path = write(
        "def f(a, b, *, c):\n  a[0] = 0\n"
        "  return {'attitude': a + b, 'velocity_body': [[c, type(b).__name__ == 'float']], 'x': 'y'}"
    )
    array = np.array([1.0, np.nextafter(2, 3), -0.0])
    made = called(path, array, 0.5, keywords={"c": np.float64(0.1)}, repetitions=2)
    assert sorted(made.result) == ["attitude", "velocity_body"]
    np.testing.assert_array_equal(made.result["attitude"], [0.5, np.nextafter(2, 3) + 0.5, 0.5])
    np.testing.assert_array_equal(made.result["velocity_body"], [[0.1, 1]])
    assert array[0] == 1
    assert len(made.seconds) == 2
    assert made.version == ""
    assert list(temporary.iterdir()) == []


def test_the_version_of_a_distribution_and_that_of_numpy(write):
    path = write("def f(): return 1.0")
    assert called(path, distribution="numpy").version == f"numpy {np.__version__}"
    assert called(path, distribution="typer").version.endswith(f", numpy {np.__version__}")
    assert called(path, distribution="no-such-distribution").version == ""


def test_a_function_of_a_module_of_the_working_directory(write, monkeypatch):
    monkeypatch.chdir(write("def f(x): return 2 * x", "module_here.py").parent)
    assert run_elsewhere(PYTHON, "module_here:f", (21.0,)).result == 42
    assert run_elsewhere(PYTHON, "math:hypot", (3.0, 4.0)).result == 5


def test_neighbours_of_the_worker_are_no_modules(write):
    assert refusal(write("import registry\ndef f(): ..."))[0] == "not installed"


def test_what_a_function_tells_about_itself(write):
    path = write("def f():\n    'One line.\\n\\nMore.'\nf.samples_per_step, f.takes = 3, 'rates'\n")
    told = describe_elsewhere(PYTHON, f"{path}:f")
    assert (told["summary"], told["samples_per_step"], told["takes"], told["state_bytes"]) == (
        "One line.", 3, "rates", None,
    )  # fmt: skip


FAREWELL = "import os, sys\ndef f():\n  print('farewell', file=sys.stderr, flush=True)\n  os.abort()"
DECLINES = "class NotApplicableError(Exception): ...\ndef f(): raise NotApplicableError('no, thanks')"
MUTE = "class E(Exception):\n  def __str__(self): raise KeyError\ndef f(): raise E"


@pytest.mark.parametrize(
    ("source", "status", "message"),
    [
        ("def f(): raise ValueError('two\\nlines')", "error", "ValueError: two lines (mine.py, line 1)"),
        ("def f(): raise SystemExit(3)", "error", "SystemExit: 3 (mine.py, line 1)"),
        ("import os\ndef f(): os._exit(3)", "error", "exit status 3"),
        ("import os\ndef f(): os._exit(0)", "crashed", "left the process without an answer"),
        (FAREWELL, "crashed", "killed by SIGABRT: farewell"),
        ("import ctypes\ndef f(): ctypes.string_at(0)", "crashed", "killed by SIGSEGV"),
        ("import os, signal\ndef f(): os.kill(os.getpid(), signal.SIGKILL)", "out of memory", "killed by SIGKILL"),
        ("def f(): return [bytes(10**7) for _ in range(1000)]", "out of memory", "MemoryError (mine.py, line 1)"),
        ("import no_such_library", "not installed", "ModuleNotFoundError: No module named 'no_such_library'"),
        ("def g(): ...", "error", "has no attribute 'f'"),
        ("f = 3", "error", "'f' in"),
        ("def f(): return 'text'", "wrong shape", "not an array of real numbers: its elements are <U4"),
        ("def f(): return {'attitude': object()}", "wrong shape", "attitude is not an array of real numbers"),
        (DECLINES, "not applicable", "no, thanks"),
        (MUTE, "error", "__str__ raises KeyError"),
    ],
)
def test_what_goes_wrong_is_a_status_and_a_line(write, temporary, source, status, message):
    found = refusal(write(source), limits=Limits(memory=300_000_000))
    assert found[0] == status
    assert message in found[1]
    assert list(temporary.iterdir()) == []


def test_a_keyword_that_a_function_does_not_take(write):
    assert refusal(write("def f(x): return x"), 1.0, keywords={"y": 2.0}) == ("not applicable", "takes no y")


@pytest.mark.parametrize(
    "source",
    [
        "import time\ntime.sleep(1000)",
        "def f():\n  while True: pass",
        "import signal, time\nfor number in (2, 15): signal.signal(number, signal.SIG_IGN)\ntime.sleep(1000)",
    ],
    ids=["asleep", "busy", "ignores signals"],
)
def test_a_hang_ends_at_the_deadline(write, temporary, source):
    assert refusal(write(source), limits=Limits(timeout=0.5)) == ("timeout", "stopped after 0.5 s")
    assert list(temporary.iterdir()) == []


CHILD = """
import subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"])
open({note!r}, "w").write(str(child.pid))
{then}
"""


def test_children_of_one_that_hangs_are_killed_too(write, tmp_path):
    note = tmp_path / "pid"
    path = write(CHILD.format(note=str(note), then="time.sleep(1000)"))
    for timeout in (1, 4, 16, 64):  # until the machine is fast enough to start the child in time
        assert refusal(path, limits=Limits(timeout=timeout))[0] == "timeout"
        if note.exists() and note.read_text():
            break
    assert gone(int(note.read_text()))


def test_children_of_one_that_has_answered_are_killed_too(write, tmp_path):
    note = tmp_path / "pid"
    path = write(CHILD.format(note=str(note), then="def f(): return 1.0"))
    assert called(path).result == 1
    assert gone(int(note.read_text()))


def test_what_was_left_running_in_a_thread_is_not_waited_for(write):
    path = write(
        "import threading, time\ndef f(): threading.Thread(target=time.sleep, args=(1000,)).start(); return 1.0"
    )
    assert called(path, limits=Limits(timeout=PATIENCE), repetitions=0).result == 1


def test_a_flood_of_output_ends_at_the_limit(write, temporary):
    path = write("def f():\n  while True: print('x' * 100_000)")
    status, message = refusal(path, limits=Limits(output=1_000_000))
    assert status == "error"
    assert "File too large" in message
    assert list(temporary.iterdir()) == []


def test_a_program_inherits_no_ignored_signal(tmp_path):
    # Python ignores the signals for a closed pipe and for a file too large; the programs it starts must not.
    for name in ("PIPE", "XFSZ"):
        status = run_process(["sh", "-c", f"kill -{name} $$"], tmp_path, Limits()).status
        assert status == -signal.Signals[f"SIG{name}"]


def test_an_interrupt_kills_the_child(write, tmp_path):
    note = tmp_path / "pid"
    path = write(f"import os, time\nopen({str(note)!r}, 'w').write(str(os.getpid()))\ntime.sleep(1000)")
    script = (
        "from pathlib import Path; import sys; from sinsbench.subjects.isolation import run_elsewhere; "
        f"run_elsewhere(Path(sys.executable), {f'{path}:f'!r}, ())"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    parent = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.PIPE, env=environment)
    end = time.monotonic() + PATIENCE
    while not (note.exists() and note.read_text()):
        assert time.monotonic() < end
        time.sleep(0.01)
    parent.send_signal(signal.SIGINT)
    _, error = parent.communicate(timeout=PATIENCE)
    assert b"KeyboardInterrupt" in error
    assert gone(int(note.read_text()))
    assert not list(tmp_path.glob("sinsbench-*"))


def test_limits():
    assert Limits().seconds(1000) == 61
    assert Limits(timeout=5).seconds(10**6) == 5
    assert Limits(memory=10**30).memory_bytes() == sys.maxsize
    for wrong in ({"timeout": 0}, {"timeout": float("nan")}, {"timeout": float("inf")}, {"memory": -1}, {"output": 0}):
        with pytest.raises(LimitsError, match="a positive number is needed"):
            Limits(**wrong)


def test_no_program_and_no_permission(tmp_path):
    (tmp_path / "text").write_text("text")
    for word, status in (("no-such-program-at-all", "not installed"), (str(tmp_path / "text"), "error")):
        with pytest.raises(OutcomeError) as caught:
            run_process([word], tmp_path, Limits())
        assert caught.value.status == status


def test_a_growing_input_is_not_waited_for_twice():
    patience, tried = Patience(), []

    def attempt(rows, status):
        def fails():
            tried.append(rows)
            raise OutcomeError(status, "no")

        with pytest.raises(OutcomeError) as caught:
            patience.wait(rows, fails)
        return caught.value.status, str(caught.value)

    assert attempt(10, "error") == ("error", "no")
    assert attempt(20, "timeout") == ("timeout", "no")
    assert attempt(40, "error") == ("timeout", "not run: with 20 rows it was no")
    assert attempt(80, "error")[0] == "timeout"
    assert attempt(10, "error") == ("error", "no")  # another case begins
    assert tried == [10, 20, 10]


def test_a_callable_that_is_never_loaded_here(write):
    path = write("import sys\nsys.modules['planted_by_mine'] = sys\ndef f(a): return a\nf.samples_per_step = 2\n")
    loaded = isolated_subject(f"{path}:f")
    assert loaded.elsewhere
    assert (loaded.subject.samples_per_step, loaded.subject.takes) == (2, None)
    np.testing.assert_array_equal(loaded.function(np.arange(3.0)).result, [0, 1, 2])
    assert "planted_by_mine" not in sys.modules


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("nonsense", "is no callable"),
        ("nowhere/mine.py:f", "there is no file nowhere/mine.py"),
        ("no_such_module_at_all:f", "No module named 'no_such_module_at_all'"),
        ("math:no_such_function", "no_such_function"),
    ],
)
def test_slips_of_the_user_are_told_at_once(text, expected):
    with pytest.raises(SubjectError, match=expected):
        isolated_subject(text)


HOSTILE = {
    "dies": ("import os\nos.abort()", "crashed", Limits()),
    "hangs": ("import time\ndef f(*inputs): time.sleep(1000)", "timeout", Limits(timeout=1.0)),
    "eats": ("def f(*inputs): return [bytes(10**7) for _ in range(1000)]", "out of memory", Limits(memory=300_000_000)),
    "lies": (
        "import numpy as np\ndef f(angle, *rest): return np.full((len(angle) + 1, 4), np.nan)",
        "not finite",
        Limits(),
    ),
}


@pytest.fixture(scope="module")
def short():
    case = next(case for case in paper_cases("dual_precession") if case.name == "variant2_general")
    return replace(case, duration=ExactNumber("0.64"))


def test_in_one_run_the_others_are_scored_all_the_same(write, short):
    hostile = {
        f"{write(source, f'{name}.py')}:f": (status, limits) for name, (source, status, limits) in HOSTILE.items()
    }
    subjects = [isolated_subject(place, limits) for place, (_, limits) in hostile.items()]
    found: dict[str, set[str]] = {}
    for row in score(
        [*subjects, isolated_subject(TWO_SAMPLE), "panov4"], [short], factors=(Fraction(1), Fraction(1, 2))
    ):
        found.setdefault(row["subject"], set()).add(row["status"])
    expected = {place: {status} for place, (status, _) in hostile.items()}
    assert found == expected | {TWO_SAMPLE: {"ok"}, "panov4": {"ok"}}
