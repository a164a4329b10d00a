"""Plants the defects of a subject one after the other and has each judged."""

import ast
import contextlib
import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from sinsbench.mutants.constants import PARAMETERS, Change, changes_of, observed
from sinsbench.mutants.equivalents import reason_of
from sinsbench.mutants.interpretation import Place, copied, is_compiled
from sinsbench.mutants.judging import Judge, Score
from sinsbench.mutants.planting import TermPlanter
from sinsbench.mutants.replicas import Replica
from sinsbench.mutants.trials import (
    PROBED_STEPS,
    formula_probes,
    formula_trials,
    integrator_probes,
    integrator_trials,
    score_trial,
)
from sinsbench.scoring.running import RunError, checked_integrator_output, run
from sinsbench.subjects.loading import LoadedSubject
from sinsbench.subjects.registry import DUAL_PRECESSION, EQUATOR_ERRORS

__all__ = ["KINDS", "Kind", "Mutant", "Planting", "Verdict", "plantings"]

Kind: TypeAlias = Literal["coefficient", "series", "source", "formula"]
KINDS: tuple[Kind, ...] = ("coefficient", "series", "source", "formula")
"""Coefficients; power series; terms of compiled kernels, or of a user's source; terms and tables of formulas."""

Verdict: TypeAlias = Literal["told apart", "equivalent", "unexplained", "survivor"]

#: What checks arguments and makes a solver of a function: no formula of it reaches a result.
_CONTRACT = frozenset({"checked_time", "_checked", "solver"})
#: Bytes of attitude, velocity and as many carried rounding errors.
_LEAST_CARRYING = 2 * 8 * (4 + 3)


@dataclass(frozen=True)
class Mutant:
    """A defect and what became of it.

    Attributes
    ----------
    subject : str
    kind : {"coefficient", "series", "source", "formula"}
    defect : str
        Where it was planted, and what stands for what.
    verdict : {"told apart", "equivalent", "unexplained", "survivor"}
        Seen by the score; no difference beyond rounding, for a reason that is known; for none that is known; a
        difference that the score does not see.
    told_by : str
        The case whose score saw it.
    reason : str
        Why it makes no difference.
    """

    subject: str
    kind: str
    defect: str
    verdict: Verdict
    told_by: str = ""
    reason: str = ""


@dataclass(frozen=True)
class Planting:
    """The defects of a subject and what became of them.

    Attributes
    ----------
    subject : str
    mutants : tuple of Mutant
        In the order of the source.
    shown : int
        Number of further defects, in terms that it shares with earlier subjects: the score told them apart there.
    """

    subject: str
    mutants: tuple[Mutant, ...]
    shown: int = 0


def plantings(
    subjects: Sequence[LoadedSubject],
    dataset: str = DUAL_PRECESSION,
    kinds: Sequence[str] = KINDS,
    score: Score = score_trial,
    report: Callable[[int, int, str], None] = lambda done, total, what: None,
) -> list[Planting]:
    """Plant the defects of subjects one after the other and judge each.

    Parameters
    ----------
    subjects : sequence of LoadedSubject
        Built-in subjects, or users' whose source is Python.
    dataset : str
        Dataset whose contract a user's subject obeys; built-in ones obey their own.
    kinds : sequence of str
        Kinds of defects to plant, of `KINDS`.
    score : callable
        Scores a subject on a trial.
    report : callable
        ``report(done, total, what)``.

    Returns
    -------
    list of Planting
        One a subject. Where several pass through a term of the same source, its defects are planted in the first, and
        in the next as long as none has told them apart: indices have more values there. Those that are equivalent for
        a reason are then tried on random inputs first, and on the cases of the score if these show a difference.

    Raises
    ------
    SubjectError
        If a subject has no Python source.
    """
    told: dict[tuple[Place, int], bool] = {}  # whether a defect of a term was told apart, if it has been planted
    result = []
    for loaded in subjects:
        name = loaded.subject.name
        judge = _judge(loaded, loaded.subject.dataset or dataset, score)
        planted: dict[Any, _Defect] = {}
        if loaded.subject.dataset == DUAL_PRECESSION and {"coefficient", "series"} & set(kinds):
            planted |= enumerate(_defects_of_constants(judge))
        if {"source", "formula"} & set(kinds):
            planted |= _defects_of_source(judge, loaded)
        wanted = {key: defect for key, defect in planted.items() if defect.kind in kinds}
        mutants = []
        for number, (key, defect) in enumerate(wanted.items()):
            if told.get(key):
                continue
            report(number, len(wanted), name)
            known = key in told and reason_of(name, defect.what) != ""
            mutants.append(_judged(loaded, defect, again=known))
            if isinstance(key, tuple):
                told[key] = mutants[-1].verdict == "told apart"
        result.append(Planting(name, tuple(mutants), len(wanted) - len(mutants)))
    return result


@dataclass(frozen=True)
class _Defect:
    kind: str
    what: str
    verdict: Callable[[bool], tuple[str | None, bool]]
    """Plants it, and is told whether it made no difference in another subject, for a reason that holds in this one;
    returns the case whose score tells it apart, and whether it changes results on random inputs."""


def _judged(loaded: LoadedSubject, defect: _Defect, again: bool) -> Mutant:
    told_by, differs = defect.verdict(again)
    verdict: Verdict = "told apart"
    reason = ""
    if told_by is None:
        reason = "" if differs else reason_of(loaded.subject.name, defect.what)
        verdict = "survivor" if differs else "equivalent" if reason else "unexplained"
    return Mutant(loaded.subject.name, defect.kind, defect.what, verdict, told_by or "", reason)


#: Solvers that go step by step, and how, see `formula_trials`: flights of hours take some of them seconds.
_STEPPING = {"rk45": "library", "dop853": "library", "radau": "library", "lsoda": "library", "ode45": "controlled"}


def _judge(loaded: LoadedSubject, dataset: str, score: Score) -> Judge:
    if dataset == EQUATOR_ERRORS:
        way = _STEPPING.get(loaded.subject.name.partition("_")[0], "closed form")
        return Judge(loaded, formula_trials(way), formula_probes(way), score)
    samples = loaded.subject.samples_per_step or _samples_per_step(loaded)
    carries = (loaded.subject.state_bytes or _LEAST_CARRYING) >= _LEAST_CARRYING
    return Judge(loaded, integrator_trials(samples, carries), integrator_probes(samples), score)


def _samples_per_step(loaded: LoadedSubject) -> int:
    """Find out how many samples a step of a user's subject consumes, by a run on a number that 1 to 10 divide."""
    (angle, velocity, *others), _ = integrator_probes(2520 // PROBED_STEPS)[0]
    result = run(loaded.function, (angle, velocity, *others), repetitions=0).result
    return checked_integrator_output(result, len(angle)).samples_per_step


def _verdict(judge: Judge, function: Callable[..., Any], again: bool, terms: bool = True) -> tuple[str | None, bool]:
    # Cases are spared what makes no difference in another subject, for a known reason, nor on random inputs here.
    if again and not judge.differs(function):
        return None, False
    told_by = judge.told_apart(function, terms)
    return told_by, told_by is None and judge.differs(function)


def _defects_of_constants(judge: Judge) -> Iterator[_Defect]:
    seen: dict[str, Any] = {}
    given: dict[str, Any] = {}
    with judge.right.intercepted(PARAMETERS, lambda name, value: seen.setdefault(name, observed(value))):
        judge.run_all(judge.right.function())
    # Kernels are given what they are made of: nothing but that need be exchanged, and compiled ones serve as they are.
    replica = Replica(judge.loaded, compiled=True)
    with replica.intercepted(PARAMETERS, given.setdefault):
        run(replica.function(), judge.probes[0][0], repetitions=0)
    if any(_verdict(judge, replica.function(), again=False, terms=False)):
        raise RuntimeError(f"{judge.loaded.subject.name} does not compute compiled what it computes interpreted")

    def judged(parameter: str, change: Change, again: bool) -> tuple[str | None, bool]:
        with replica.intercepted({parameter}, lambda _, __: change.value):
            return _verdict(judge, replica.function(), again, terms=False)

    for parameter, value in given.items():
        for change in changes_of(value, seen[parameter]):
            yield _Defect(change.kind, change.what, functools.partial(judged, parameter, change))


class _Recorder:
    """Finds out which places of which statements a subject passes through."""

    def __init__(self, places: Sequence[Place]) -> None:
        self._places, self._count = set(places), 0
        self._first: dict[Place, int] = {}
        self._seen: set[int] = set()

    def transform(self, place: Place, statement: ast.stmt) -> ast.stmt:
        if place not in self._places:
            return statement
        planter = TermPlanter(recording=True)
        planter.count = self._first[place] = self._count
        changed: ast.stmt = planter.visit(statement)
        self._count = planter.count
        return changed

    def __call__(self, first: int, end: int, value: Any) -> Any:
        self._seen.update(range(first, end))
        return value

    def passed(self, place: Place, number: int) -> bool:
        return self._first[place] + number in self._seen


def _planted_statements(replica: Replica, loaded: LoadedSubject) -> list[Place]:
    statements = replica.statements
    if loaded.subject.dataset == DUAL_PRECESSION:
        return [place for place, node in statements.items() if is_compiled(node)]
    reached = replica.reachable()
    return [
        place
        for place, node in statements.items()
        if place in reached
        and isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign)
        and getattr(node, "name", "") not in _CONTRACT
    ]


def _defects_of_source(judge: Judge, loaded: LoadedSubject) -> dict[tuple[Place, int], _Defect]:
    """Return the defects of the terms that the subject passes through, by statement and number in it."""
    places = _planted_statements(judge.right, loaded)
    recorder = _Recorder(places)
    judge.run_all(Replica(loaded, recorder.transform, __seen__=recorder).function())
    kind = "formula" if loaded.subject.dataset == EQUATOR_ERRORS else "source"

    def verdict(place: Place, number: int, again: bool) -> tuple[str | None, bool]:
        changed = TermPlanter(number).visit(copied(judge.right.statements[place]))
        with contextlib.ExitStack() as stack:
            try:
                load = functools.partial(stack.enter_context, judge.replica.exchanged(place, changed))
                function = run(load, (), repetitions=0).result
            except RunError:  # what fails to load nobody overlooks
                return "loading", True
            return _verdict(judge, function, again)

    found = {}
    for place in places:
        listing = TermPlanter()
        listing.visit(judge.right.statements[place])  # which changes nothing, without a target
        module = place.module.rpartition(".")[2]
        for number, what in enumerate(listing.places):
            if recorder.passed(place, number):
                before = listing.places[:number].count(what)
                again = f" ({before + 1})" if before else ""
                found[place, number] = _Defect(
                    kind, f"{module}.{what}{again}", functools.partial(verdict, place, number)
                )
    return found
