"""The score tells every planted defect from the right subject, and what it would miss is reported as missed."""

import ast
import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import pytest
import typer

from sinsbench.cli.mutants import mutants as command
from sinsbench.mutants import campaign, runner
from sinsbench.mutants.campaign import SUBJECTS
from sinsbench.mutants.equivalents import EQUIVALENTS, reason_of
from sinsbench.mutants.interpretation import copied
from sinsbench.mutants.judging import Judge
from sinsbench.mutants.page import page
from sinsbench.mutants.runner import Planting, plantings
from sinsbench.mutants.trials import integrator_probes, integrator_trials, score_trial
from sinsbench.subjects.loading import resolve
from sinsbench.subjects.registry import BUILT_IN, EQUATOR_ERRORS
from sinsbench.subjects.rotation_vector_methods import COSINE_SERIES, DUAL_SERIES, SINE_SERIES

FOUND = ("told apart", "equivalent")
PAGE = (Path(__file__).resolve().parents[2] / "docs" / "mutants.md").read_text(encoding="utf-8")


@cache
def planted(name, *kinds):
    (result,) = plantings([resolve(name)], kinds=kinds or runner.KINDS)
    return result.mutants


def blind(loaded, trial):
    """A score that shows the same errors of everything."""
    return [row | dict.fromkeys(trial.scales, 1.0) for row in score_trial(resolve("two_sample"), trial)]


@pytest.mark.parametrize("name", ["two_sample", "panov6", "magnus6"])
def test_no_defect_in_a_coefficient_survives(name):
    mutants = planted(name, "coefficient", "series")
    assert {one.kind for one in mutants} >= {"coefficient"}
    assert [one for one in mutants if one.verdict not in FOUND] == []
    assert sum(one.verdict == "told apart" for one in mutants) > 0.6 * len(mutants)


@pytest.mark.parametrize(("name", "least"), [("one_sample", 200), ("equator_amplitude_phase_printed", 150)])
def test_no_defect_in_a_term_survives(name, least):
    mutants = planted(name, "source", "formula")
    assert [one for one in mutants if one.verdict not in FOUND] == []
    assert sum(one.verdict == "told apart" for one in mutants) >= least


def test_every_number_of_a_method_has_its_defects():
    defects = {one.defect for one in planted("panov6", "coefficient", "series")}
    for index in ("0, 2", "0, 3", "1, 2", "1, 3"):
        for what in (" times 1.001", " sign", " dropped"):
            assert f"pair[{index}]{what}" in defects
    assert {"pair[0, 2] -> [2, 0]", "pair[0, 2] -> [1, 2]", "pair[0, 2] -> [0, 1]"} <= defects
    assert {"triple[0, 1, 3] sign", "triple[3, 0, 2] dropped", "quartic[1, 2, 1, 2] sign"} <= defects


def test_what_subjects_share_is_planted_until_it_is_told_apart():
    first, second = plantings([resolve("two_sample"), resolve("miller3")], kinds=["source"])
    assert first.shown == 0
    assert second.shown == sum(one.verdict == "told apart" for one in first.mutants) > 200
    assert [one.defect for one in second.mutants] == [x.defect for x in first.mutants if x.verdict != "told apart"]


def table_lines(page):
    return [line for line in page.splitlines() if line.startswith("|")]


def test_the_page_has_all_subjects_and_no_survivors():
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table_lines(PAGE)]
    rows = rows[2 : len(SUBJECTS) + 3]
    assert [row[0] for row in rows] == [*SUBJECTS, "all"]
    numbers = [[int(cell.replace(",", "")) for cell in row[1:]] for row in rows]
    assert numbers[-1] == [sum(column) for column in zip(*numbers[:-1], strict=True)]
    for planted_in, told, equivalent, unexplained, survivors, elsewhere in numbers:
        assert planted_in == told + equivalent
        assert (unexplained, survivors) == (0, 0)
        assert told + elsewhere > 0


def test_the_page_is_what_the_command_finds():
    everything = planted("one_sample", "coefficient", "series") + planted("one_sample", "source", "formula")
    made = page([Planting("one_sample", everything)])
    row = next(line for line in table_lines(made) if line.startswith("| one_sample "))
    assert row in PAGE.splitlines()
    assert PAGE.startswith(made[: made.index("\n|")])


def test_the_same_defects_are_judged_the_same_twice():
    (again,) = plantings([resolve("two_sample")], kinds=["coefficient", "series"])
    assert again.mutants == planted("two_sample", "coefficient", "series")


class Reordered(ast.NodeTransformer):
    """(a + b) + c becomes (c + b) + a."""

    def visit_Return(self, node):
        total = node.value
        total.left.left, total.right = total.right, total.left.left
        return node


def test_a_sum_in_another_order_is_the_same():
    judge = Judge(resolve("panov6"), integrator_trials(4, carries=False), integrator_probes(4), score_trial)
    place = next(place for place, node in judge.right.statements.items() if getattr(node, "name", "") == "dot")
    changed = Reordered().visit(copied(judge.right.statements[place]))
    assert ast.unparse(changed) != ast.unparse(judge.right.statements[place])
    with judge.replica.exchanged(place, changed) as function:
        runs = [(judge.right.function()(*probe), function(*probe)) for probe, _ in integrator_probes(4)]
        assert any((before[name] != after[name]).any() for before, after in runs for name in before)  # by rounding
        assert judge.told_apart(function) is None
        assert not judge.differs(function)


def test_what_no_reason_is_known_for_is_reported(monkeypatch):
    monkeypatch.setattr(runner, "reason_of", lambda subject, defect: "")
    (result,) = plantings([resolve("two_sample")], kinds=["series"])
    mutants = result.mutants
    assert {one.verdict for one in mutants} == {"told apart", "unexplained"}
    assert "cosine[7] times 1.001" in {one.defect for one in mutants if one.verdict == "unexplained"}


def test_a_blind_score_lets_defects_survive(monkeypatch, capsys):
    blinded = plantings([resolve("two_sample")], kinds=["coefficient"], score=blind)
    assert [one for one in blinded[0].mutants if one.verdict != "survivor"] == []
    monkeypatch.setattr(campaign, "campaign", lambda *arguments: blinded)
    with pytest.raises(typer.Exit) as left:
        command(["two_sample"], kind=["coefficient"])
    assert left.value.exit_code == 1
    assert "survivors: results change" in capsys.readouterr().out


USERS = '''
import numpy as np


def product(a, b):
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def two_sample(angle, velocity, interval, attitude0, velocity0):
    """Attitude by rotation vectors of two samples."""
    attitude = [np.asarray(attitude0)]
    for first, second in zip(angle[::2], angle[1::2]):
        phi = first + second + 2 / 3 * np.cross(first, second)
        half = np.linalg.norm(phi) / 2
        attitude.append(product(attitude[-1], np.concatenate([[np.cos(half)], phi * np.sinc(half / np.pi) / 2])))
    unused = 7 * interval
    return np.array(attitude)
'''


def test_defects_are_planted_in_a_users_source(tmp_path):
    (tmp_path / "mine.py").write_text(USERS)
    mutants = planted(f"{tmp_path}/mine.py:two_sample")
    unseen = [one.defect for one in mutants if one.verdict != "told apart"]
    assert len(mutants) > 40
    assert all("unused" in defect for defect in unseen)
    assert len(unseen) == 2
    assert any("2 / 3 * np.cross(first, second)" in one.defect for one in mutants if one.verdict == "told apart")


ROUNDING = next(x.reason for x in EQUIVALENTS if "cosine" in x.defects)


@pytest.mark.parametrize(("series", "name"), [(COSINE_SERIES, "cosine"), (SINE_SERIES, "sine"), (DUAL_SERIES, "dual")])
def test_terms_said_to_be_below_rounding_are(series, name):
    excused = 0
    for term, number in enumerate(series):
        for what, change in (("times 1.001", Fraction(1, 1000)), ("sign", Fraction(2)), ("dropped", Fraction(1))):
            if reason_of("panov6", f"{name}[{term}] {what}") == ROUNDING:
                excused += 1
                # Of what is of the size of one; the series serve up to an angle of 1 rad, where every power is 1.
                assert abs(number) * change < 10 * Fraction(1, 2**52)
    assert 0 < excused < len(series)


def test_reasons_are_given_for_subjects_that_there_are():
    for one in EQUIVALENTS:
        assert any(re.fullmatch(one.subjects, name) for name in BUILT_IN), one.subjects


def test_reasons_do_not_excuse_coefficients():
    assert reason_of("panov6", "pair[0, 2] sign") == ""
    assert reason_of("taylor5", "odd[0, 0] sign") == ""
    assert reason_of("panov6", "kernels.rotation_vector: phi = increment_sum(p, c): nothing") == ""


def test_a_program_has_no_source_to_plant_in():
    loaded = resolve("expm")
    with pytest.raises(ValueError, match="Python source"):
        plantings([replace(loaded, subject=replace(loaded.subject, dataset=None), function=len)], EQUATOR_ERRORS)
