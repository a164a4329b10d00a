"""What is made of strangers' code: results, warnings, prints, failures, times."""

import time
import warnings

import numpy as np
import pytest

from sinsbench.scoring.running import RunError, checked_integrator_output, checked_states, run
from sinsbench.subjects.equator_model import NotApplicableError


def test_the_first_call_is_not_timed():
    calls = []

    def function():
        calls.append(time.perf_counter())
        if len(calls) == 1:
            time.sleep(0.2)
        return len(calls)

    timed = run(function, ())
    assert (timed.result, len(calls)) == (1, 4)
    assert timed.least < 0.1


def test_a_warm_subject_is_timed_at_once():
    calls = []
    timed = run(lambda: calls.append(time.sleep(0.02)), (), repetitions=3, warm=True, budget=0.01)
    assert len(calls) == 1
    assert timed.least >= 0.02


def test_no_repetitions_no_time():
    calls = []
    assert np.isnan(run(lambda: calls.append(1), (), repetitions=0).least)
    assert len(calls) == 1


def test_a_subject_may_write_into_its_arguments():
    given = np.arange(3.0)

    def function(x):
        x += 1
        return x

    assert run(function, (given,)).result.tolist() == [1, 2, 3]
    assert given.tolist() == [0, 1, 2]


def test_warnings_and_prints_do_no_harm(capsys):
    def function():
        warnings.warn("beware", stacklevel=1)
        print("hello")
        return np.float64(1) / np.float64(0)

    assert run(function, (), 0).result == np.inf
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("error", [ValueError("two\nlines"), SystemExit(3), RecursionError(), AssertionError()])
def test_whatever_is_raised_becomes_one_line(error):
    def function():
        raise error

    with pytest.raises(RunError) as caught:
        run(function, ())
    assert caught.value.status == "error"
    assert str(caught.value).startswith(type(error).__name__)
    assert "test_running.py, line" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_wrong_signature_is_an_error():
    with pytest.raises(RunError, match="positional argument"):
        run(lambda a: a, ())


def test_an_interrupt_goes_through():
    def function():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(function, ())


def test_declining_a_case():
    def function():
        raise NotApplicableError("no such mode")

    with pytest.raises(RunError, match="no such mode") as caught:
        run(function, ())
    assert caught.value.status == "not applicable"


def quaternions(m):
    return np.tile([1.0, 0, 0, 0], (m, 1))


@pytest.mark.parametrize(("rows", "step"), [(13, 1), (5, 3), (4, 4), (2, 12)])
def test_samples_per_step_follow_from_the_rows(rows, step):
    output = checked_integrator_output(quaternions(rows).tolist(), 12)
    assert output.samples_per_step == step
    assert output.velocity_inertial is None
    assert output.attitude.shape == (rows, 4)


def test_any_of_the_three_results():
    output = checked_integrator_output({"velocity_body": np.zeros((5, 3), np.float32), "attitude": None, "more": 1}, 12)
    assert (output.attitude, output.velocity_inertial) == (None, None)
    assert output.velocity_body.dtype == np.float64


@pytest.mark.parametrize(
    ("result", "status", "words"),
    [
        (quaternions(5).T, "wrong shape", "(4, 5)"),
        (quaternions(5).T, "wrong shape", "transposed?"),
        ({"attitude": quaternions(5).T, "velocity_body": np.zeros((3, 5))}, "wrong shape", "transposed?"),
        (quaternions(5) * 1e308, "not finite", "range of float64, first in row 0"),
        (quaternions(5) * 1e-320, "not finite", "range of float64, first in row 0"),
        (quaternions(5) * np.longdouble("1e4000"), "not finite", "first in row 0"),
        (quaternions(12), "wrong shape", "initial row missing"),
        (quaternions(14), "wrong shape", "(14, 4)"),
        (quaternions(1), "wrong shape", "(1, 4)"),
        (np.zeros((0, 4)), "wrong shape", "(0, 4)"),
        (np.zeros((5, 3)), "wrong shape", "(5, 3)"),
        ({"attitude": quaternions(5), "velocity_body": np.zeros((4, 3))}, "wrong shape", "attitude 5, velocity_body 4"),
        (None, "wrong shape", "none of"),
        ({}, "wrong shape", "none of"),
        (3.0, "wrong shape", "()"),
        ("text", "wrong shape", "not an array of real numbers"),
        ([[1, 2], [3]], "wrong shape", "not an array of real numbers"),
        (quaternions(5) * 1j, "wrong shape", "not an array of real numbers"),
        (np.where(np.arange(5)[:, None] == 3, np.nan, quaternions(5)), "not finite", "first in row 3"),
        (np.where(np.arange(5)[:, None] == 2, np.inf, quaternions(5)), "not finite", "first in row 2"),
        (np.where(np.arange(5)[:, None] == 2, 0.0, quaternions(5)), "error", "zero, no rotation, in row 2"),
    ],
)
def test_bad_results(result, status, words):
    with pytest.raises(RunError) as caught:
        checked_integrator_output(result, 12)
    assert caught.value.status == status
    assert words in str(caught.value)


def test_states():
    assert checked_states(np.zeros((4, 6)), 4).shape == (4, 6)
    for bad, status in ((np.zeros((6, 4)), "wrong shape"), (np.full((4, 6), np.nan), "not finite")):
        with pytest.raises(RunError) as caught:
            checked_states(bad, 4)
        assert caught.value.status == status


class UnprintableError(Exception):
    def __str__(self):
        raise RuntimeError("no words")


class UnprintableNotApplicableError(UnprintableError, NotApplicableError):
    pass


class OutsiderError(BaseException):
    pass


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (UnprintableError(), "error", "UnprintableError: its message cannot be had, __str__ raises RuntimeError ("),
        (UnprintableNotApplicableError(), "not applicable", "__str__ raises RuntimeError"),
        (OutsiderError("far out"), "error", "OutsiderError: far out ("),
        (GeneratorExit(), "error", "GeneratorExit"),
        (ValueError("half \ud800 a pair"), "error", "ValueError: half ? a pair ("),
    ],
)
def test_no_exception_ends_the_run(error, status, words):
    def function():
        raise error

    with pytest.raises(RunError) as caught:
        run(function, ())
    assert caught.value.status == status
    assert words in str(caught.value)
    assert str(caught.value).encode()


def test_arguments_by_name_are_copied_too():
    given = np.arange(3.0)

    def function(*, x):
        x += 1
        return x

    assert run(function, (), keywords={"x": given}).result.tolist() == [1, 2, 3]
    assert given.tolist() == [0, 1, 2]


def test_an_object_that_raises_when_asked_for_its_numbers_is_a_row() -> None:
    class Tensor:
        def __array__(self, dtype=None, copy=None):
            raise RuntimeError("requires grad")

    with pytest.raises(RunError, match="requires grad") as caught:
        checked_integrator_output(Tensor(), 4)
    assert caught.value.status == "wrong shape"
