"""Whether the score tells a mutant from the subject that it is a mutant of."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sinsbench.mutants.perturbation import Perturbation
from sinsbench.mutants.replicas import Replica
from sinsbench.mutants.trials import Probe, Row, Trial
from sinsbench.scoring.running import RunError, run
from sinsbench.subjects.loading import LoadedSubject

__all__ = ["Judge", "Score"]

Array = NDArray[np.float64]
Function: TypeAlias = Callable[..., Any]
Score: TypeAlias = Callable[[LoadedSubject, Trial], Sequence[Row]]

DRAWS = 4
"""How often the right subject is run with perturbed operations."""
MARGIN = 10.0
"""A difference counts from this multiple of the largest that the draws show.

Rounding errors of a mutant that computes the same in another order are of the size of those drawn, but not the same;
four draws show a quarter of what is possible at the least, but by a coincidence of one in thousands.
"""
_QUATERNION = 4
_ULP = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class _Figures:
    """What a run shows: words that must be the same, numbers that may differ by rounding."""

    words: tuple[Any, ...]
    numbers: Mapping[Any, Array]

    def apart(self, other: "_Figures", bounds: Mapping[Any, float]) -> bool:
        """Whether another run shows something else."""
        if self.words != other.words or self.numbers.keys() != other.numbers.keys():
            return True
        with np.errstate(all="ignore"):
            return any(
                x.shape != other.numbers[key].shape
                # Not "greater": what is no number differs.
                or not bool((np.abs(x - other.numbers[key]) <= bounds[key]).all())
                for key, x in self.numbers.items()
            )


class Judge:
    """Compares mutants of a subject with the subject.

    Two runs of the same formulas differ by rounding, and how much depends on the formulas: on cancellation, on the
    number of steps, on what compensated sums take back. It is therefore measured. The right subject is run with the
    result of every operation moved by up to a unit in the last place at random (`Perturbation`), `DRAWS` times; what
    differs from the unperturbed run by more than `MARGIN` times the largest deviation of these, or of a unit in the
    last place of the result whose error it is, differs by more than rounding. Compared are all errors; orders follow
    from these, so that two subjects whose errors agree have the same.

    Parameters
    ----------
    loaded : LoadedSubject
        The right subject.
    trials : sequence of Trial
    probes : sequence of Probe
    score : callable
        Scores a subject on a trial.

    Attributes
    ----------
    loaded : LoadedSubject
    right : Replica
        The right subject.
    replica : Replica
        Another copy of it, to plant defects in.
    """

    def __init__(self, loaded: LoadedSubject, trials: Sequence[Trial], probes: Sequence[Probe], score: Score) -> None:
        self.right, self.replica = Replica(loaded), Replica(loaded)
        self.loaded, self._score = loaded, score
        self.trials, self.probes = trials, probes
        self._perturbation = Perturbation()
        self._perturbed = Replica(
            loaded, lambda _, statement: self._perturbation.visit(statement), __rounded__=self._perturbation
        )
        self._turns = 0
        self._references: dict[int, tuple[_Figures, dict[Any, float]]] = {}

    def _figures_of_trial(self, function: Function, trial: Trial) -> tuple[_Figures, dict[Any, float]]:
        # Scored as what runs elsewhere, whose operations need no counting; no theory predicts the errors of a mutant.
        subject = replace(self.loaded.subject, paper="")
        rows = self._score(LoadedSubject(subject, function, elsewhere=True), trial)
        words, numbers, sizes = [], {}, {}
        for row in rows:
            words += [row["interval"], row["status"], row["message"], row["samples_per_step"]]
            for field, size in trial.scales.items():
                if row[field] is not None:
                    numbers[row["interval"], field] = np.array(row[field])
                    sizes[row["interval"], field] = size
        return _Figures(tuple(words), numbers), sizes

    def _figures_of_probe(self, function: Function, probe: Probe) -> tuple[_Figures, dict[Any, float]]:
        arguments, keywords = probe
        try:
            result = run(function, arguments, repetitions=0, keywords=keywords).result
        except RunError as error:
            return _Figures((error.status, str(error)), {}), {}
        given = result if isinstance(result, Mapping) else {"": result}
        numbers = {}
        for name, value in given.items():
            array = np.atleast_2d(np.asarray(value, np.float64))
            if array.shape[1] == _QUATERNION:  # of the two that are the same rotation, one
                largest = np.abs(array).argmax(axis=1)[:, None]
                array = array * np.sign(np.take_along_axis(array, largest, axis=1))
            # Columns of a solution have different units.
            for column, x in enumerate(array.T):
                numbers[name, column] = x
        return _Figures((), numbers), {key: float(np.abs(x).max(initial=0.0)) for key, x in numbers.items()}

    def _figures(self, function: Function, number: int) -> tuple[_Figures, dict[Any, float]]:
        if number < len(self.trials):
            return self._figures_of_trial(function, self.trials[number])
        return self._figures_of_probe(function, self.probes[number - len(self.trials)])

    def run_all(self, function: Function) -> None:
        """Run a subject on all probes, and on all trials but those for terms alone, which go the way of the others."""
        for number in range(len(self.trials) + len(self.probes)):
            if number >= len(self.trials) or not self.trials[number].terms_only:
                self._figures(function, number)

    def _reference(self, number: int) -> tuple[_Figures, dict[Any, float]]:
        """Return what the right subject shows, and how large differences may be."""
        if number not in self._references:
            right, sizes = self._figures(self.right.function(), number)
            turns = self.right.turns
            spread = {key: _ULP * size for key, size in sizes.items()}
            for draw in range(DRAWS):
                self._perturbation.seed(draw)
                moved = self._figures(self._perturbed.function(), number)[0].numbers
                for key in spread.keys() & moved.keys():
                    if moved[key].shape == right.numbers[key].shape:
                        deviation = np.abs(moved[key] - right.numbers[key])
                        spread[key] = max(spread[key], float(deviation.max(initial=0.0)))
            self._references[number] = right, {key: MARGIN * x for key, x in spread.items()}
            self._turns = max(self._turns, turns)
            self.replica.limit(self._turns)
        return self._references[number]

    def _apart(self, function: Function, number: int) -> bool:
        right, bounds = self._reference(number)
        return right.apart(self._figures(function, number)[0], bounds)

    def told_apart(self, function: Function, terms: bool = True) -> str | None:
        """Return the name of the first case whose score tells a mutant from the right subject; None if none does.

        Parameters
        ----------
        function : callable
        terms : bool, default True
            Use also the cases that are for defects in terms alone.
        """
        for number, trial in enumerate(self.trials):
            if (terms or not trial.terms_only) and self._apart(function, number):
                return trial.case.name
        return None

    def differs(self, function: Function) -> bool:
        """Whether the results of a mutant differ on random inputs by more than rounding."""
        first = len(self.trials)
        return any(self._apart(function, number) for number in range(first, first + len(self.probes)))
