"""What users give for a subject, right and wrong. Every error is one line that says what and where."""

import sys

import pytest

from sinsbench.subjects.loading import SubjectError, resolve


def failure(text):
    with pytest.raises(SubjectError) as caught:
        resolve(text)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.fixture
def write(tmp_path):
    def write(text, name="mine.py"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_file(write):
    path = write('def integrate(a):\n    """Doubles.\n\n    More."""\n    return 2 * a\n')
    before = list(sys.path)
    loaded = resolve(f"{path}:integrate")
    assert loaded.function(21) == 42
    assert loaded.subject.name == f"{path}:integrate"
    assert loaded.subject.summary == "Doubles."
    assert loaded.subject.samples_per_step is None
    assert sys.path == before
    assert "mine" not in sys.modules


def test_samples_per_step_is_an_attribute(write):
    path = write("def f(): ...\nf.samples_per_step = 3\ndef g(): ...\ng.samples_per_step = 'three'\n")
    assert resolve(f"{path}:f").subject.samples_per_step == 3
    assert resolve(f"{path}:g").subject.samples_per_step is None


def test_a_file_imports_its_neighbours_and_defines_dataclasses(write):
    write("VALUE = 7\n", "neighbour_of_mine.py")
    path = write(
        "from dataclasses import dataclass\nfrom neighbour_of_mine import VALUE\n"
        "@dataclass\nclass A:\n    x: 'int' = VALUE\n"
    )
    before = list(sys.path)
    assert resolve(f"{path}:A").function().x == 7
    assert sys.path == before


def test_a_file_named_like_a_library_replaces_nothing(write):
    path = write("def f(): return 1\n", "numpy.py")
    numpy = sys.modules.get("numpy")
    assert resolve(f"{path}:f").function() == 1
    assert sys.modules.get("numpy") is numpy


def test_a_module():
    assert resolve("os.path:join").function("a", "b")
    assert resolve("collections:OrderedDict.fromkeys").function("a")


def test_a_module_of_the_working_directory(write, monkeypatch):
    path = write("def f(): return 5\n", "module_here.py")
    monkeypatch.chdir(path.parent)
    before = list(sys.path)
    assert resolve("module_here:f").function() == 5
    assert sys.path == before
    monkeypatch.delitem(sys.modules, "module_here")


def test_prints_of_a_file_stay_off_standard_output(write, capsys):
    resolve(f"{write('print(1)' + chr(10) + 'def f(): ...')}:f")
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "1\n")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("panov5", "did you mean panov"),
        ("equator_corected", "did you mean equator_corrected"),
        ("zzz", "a subject is a built-in name"),
        ("", "a subject is"),
        ("mine.py", "names a file but no callable"),
        (":f", "there is no subject"),
        ("module:", "there is no subject"),
        ("nowhere/mine.py:f", "there is no file nowhere/mine.py"),
        ("no_such_module_at_all:f", "there is no module 'no_such_module_at_all'"),
        ("os.no_such_part:f", "there is no module 'os.no_such_part'"),
        ("math:no_such_function", "math holds no 'no_such_function'; it holds "),
        ("math:pi", "'pi' in math is float, not a callable"),
    ],
)
def test_bad_names(text, expected):
    assert expected in failure(text)


def test_missing_attribute_lists_what_is_there(write):
    path = write("def integrate(): ...\ndef other(): ...\n_hidden = print\nNUMBER = 3\n")
    assert failure(f"{path}:integrat") == f"{path} holds no 'integrat'; it holds integrate, other"
    assert "it holds no callable" in failure(f"{write('x = 1', 'empty.py')}:f")
    assert "is int, not a callable" in failure(f"{path}:NUMBER")


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("import math\nx = 1 / 0\n", "line 2: ZeroDivisionError: division by zero"),
        ("x = 1\ndef f(:\n", "line 2: SyntaxError: invalid syntax"),
        ("\n\nimport no_such_library\n", "line 3: ModuleNotFoundError: No module named 'no_such_library'"),
        ("def g():\n    raise ValueError('two\\nlines')\n\ng()\n", "line 2: ValueError: two lines"),
        ("import sys\nsys.exit(3)\n", "line 2: SystemExit: 3"),
        ("import json\njson.loads('{')\n", "line 2: JSONDecodeError"),
    ],
)
def test_a_file_that_fails_names_its_line(write, source, expected):
    path = write(source)
    before = set(sys.modules)
    message = failure(f"{path}:f")
    assert message.startswith(f"{path}, {expected}")
    assert not [name for name in set(sys.modules) - before if name.endswith("mine")]


def test_a_file_with_broken_encoding(tmp_path):
    path = tmp_path / "mine.py"
    path.write_bytes(b"x = '\xff'\n")
    assert "SyntaxError" in failure(f"{path}:f")


def test_a_failing_module_names_its_line(write, monkeypatch):
    path = write("x = 1\ny = x.missing\n", "failing_module_here.py")
    monkeypatch.chdir(path.parent)
    message = failure("failing_module_here:f")
    assert "AttributeError" in message
    assert "failing_module_here.py, line 2" in message


def test_a_module_with_a_missing_import_is_not_called_missing(write, monkeypatch):
    path = write("import no_such_library\n", "importing_module_here.py")
    monkeypatch.chdir(path.parent)
    assert "importing_module_here.py, line 1" in failure("importing_module_here:f")


def test_a_syntax_error_in_a_neighbour_names_the_neighbour(write):
    write("x = (\n", "broken_neighbour.py")
    path = write("import broken_neighbour\n")
    assert "broken_neighbour.py, line 1" in failure(f"{path}:f")


def test_a_folder_is_no_file(tmp_path):
    assert "there is no file" in failure(f"{tmp_path}/:f")


def test_a_file_without_suffix(write):
    assert "does not end in .py" in failure(f"{write('x = 1', 'script')}:f")


def test_only_callables_of_the_file_itself_are_listed(write):
    path = write("from math import sin\nfrom pathlib import Path\ndef integrate(): ...\nclass Mine: ...\n")
    assert failure(f"{path}:f").endswith("it holds integrate, Mine")
    assert "no callable of its own" in failure(f"{write('from math import sin', 'imports.py')}:f")


STRANGE = """
class Strange(BaseException):
    def __str__(self):
        raise GeneratorExit
raise Strange
"""


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (STRANGE, "line 5: Strange: its message cannot be had, __str__ raises GeneratorExit"),
        ("raise GeneratorExit('bye')\n", "line 1: GeneratorExit: bye"),
        ("import sys\ndel sys.modules[__name__]\nraise ValueError\n", "line 3: ValueError"),
        ("raise ValueError('half \\ud800 a pair')\n", "line 1: ValueError: half ? a pair"),
        ("raise SyntaxError('half \\ud800', ('a.py', 1, 1, ''))\n", "SyntaxError: half ?"),
    ],
)
def test_whatever_a_file_raises_is_told(write, monkeypatch, source, expected):
    path = write(source, "strange_module_here.py")
    assert expected in failure(f"{path}:f")
    monkeypatch.chdir(path.parent)
    assert expected.partition(": ")[2].partition(":")[0] in failure("strange_module_here:f")


def test_an_interrupt_of_an_import_goes_through(write, monkeypatch):
    path = write("raise KeyboardInterrupt\n", "interrupted_module_here.py")
    before = set(sys.modules)
    with pytest.raises(KeyboardInterrupt):
        resolve(f"{path}:f")
    monkeypatch.chdir(path.parent)
    with pytest.raises(KeyboardInterrupt):
        resolve("interrupted_module_here:f")
    assert not [name for name in set(sys.modules) - before if "interrupted" in name]
