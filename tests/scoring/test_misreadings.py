"""Attitudes in another convention are recognised, whatever else is wrong is not taken for one."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from sinsbench.scoring.integrators import ladder, score_integrator
from sinsbench.subjects.integrators import panov4
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import Subject
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

CONJUGATE = np.array([1, -1, -1, -1])
NEEDED = "needed are scalar first, body to inertial"


@pytest.fixture(scope="module")
def rungs():
    case = next(case for case in paper_cases("dual_precession") if case.name == "variant1_general")
    short = replace(case, duration=ExactNumber("4"))
    return short, ladder(short, [Fraction(1, 2**k) for k in range(3)])


def message(rungs, wrong):
    def subject(angle, velocity, interval, attitude0, velocity0):
        return wrong(panov4, angle, velocity, interval, attitude0, velocity0)

    rows = score_integrator(LoadedSubject(Subject("mine", None, "mine", ""), subject), *rungs, repetitions=0)
    assert {row["status"] for row in rows} == {"ok"}
    (said,) = {(row["message"] or "").split(" (")[0] for row in rows}
    assert said == "" or rows[0]["message"].endswith(NEEDED) or "the error does not shrink" in said
    return said


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda q: q, ""),
        (lambda q: -q, ""),
        (lambda q: np.roll(q, -1, axis=1), "the quaternions look scalar last"),
        (lambda q: q * CONJUGATE, "the quaternions look inertial to body"),
        (lambda q: np.roll(q * CONJUGATE, -1, axis=1), "the quaternions look scalar last and inertial to body"),
        (lambda q: q[:, [0, 2, 1, 3]], "the error does not shrink with the interval: are units"),
    ],
)
def test_conventions_of_the_result(rungs, wrong, said):
    found = message(rungs, lambda method, *arguments: wrong(method(*arguments)["attitude"]))
    assert found.startswith(said)
    assert bool(found) == bool(said)


def test_degrees_taken_for_radians(rungs):
    said = message(rungs, lambda method, angle, *rest: method(np.degrees(angle), *rest)["attitude"])
    assert said.startswith("the error does not shrink with the interval")


def test_a_method_of_low_order_is_not_suspected(rungs):
    """Its errors are large, but they shrink."""

    def first_order(method, angle, velocity, interval, attitude0, velocity0):
        return method(angle * (1 + interval), velocity, interval, attitude0, velocity0)["attitude"]

    assert message(rungs, first_order) == ""
