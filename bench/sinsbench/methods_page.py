"""The page of methods: what theory says of each built-in integrator, and what is measured beside it.

``python -m sinsbench.methods_page > docs/methods.md`` writes it anew.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from sinsbench.scoring.score import score
from sinsbench.subjects.registry import BUILT_IN, DUAL_PRECESSION, subjects_of
from sinsdata.cases import DualPrecessionCase
from sinsdata.tiers import paper_cases
from sinsref.exact import ExactNumber

__all__ = ["MethodRow", "method_rows", "narrow_cone", "page"]

#: Sampling intervals on the narrow cone, in units of 0.05 s: wide ones, as the orders 8 and 10 soon reach the floor.
_NARROW_FACTORS = tuple(map(Fraction, ("5/2", "2", "5/4", "1", "1/2", "1/4")))
_MOTIONS = ("coning", "general")

_HEADINGS = (
    *("method", "samples a step", "order: theory", "coning", "general"),
    *("order of the drift: theory", "coning", "general", "narrow cone: theory", "measured"),
    *("drift, deg/h: coning", "general", "operations a sample", "state, B", "source"),
)

_INTRODUCTION = """\
# The methods

The built-in integrators: what theory says of each, and what the scores measure. `python -m sinsbench.methods_page`
writes this page anew, a test computes some of its rows again.

* **Motions.** *Coning* and *general* precession are the cases `variant2_coning` and `variant2_general`: a cone of 10
  deg half-angle, 1 Hz, and a precession with half the rate of the spin, for 100 s. The *narrow cone* is that of
  `variant2_coning` with a half-angle of 0.01 deg, sampled every 0.125 s to 0.0125 s.
* **Order** is that of the largest attitude error over the run, fitted to sampling intervals from 0.02 s to 0.625
  ms. Where rounding hides it on most of them, coarser ones are added; orders 10 and 12 are fitted there, where a
  step is a good part of a turn, and come out as much as 1.1 below the theory. Where theory says 3, the term of
  order 3 is periodic: it does not grow, and may be small beside the drift of order 4 that 100 s have added up, so
  that the fitted order is 3 to 4.
* **Order of the drift** is that of the secular part. It is higher where the leading error of each step is periodic: in
  asymmetric formulas, which remember samples or pair each sample with the last one only.
* **Narrow cone.** Coefficients optimised for coning annul the drift to the square of the half-angle alone, and on
  coning alone. So their order 6, 8 or 10 is seen on a narrow cone. On 10 deg what is left over, of the fourth power
  of the half-angle and of order 4, takes over as the interval shrinks, and the fitted order is about 4; where the
  two parts cancel at some interval it is even less. On general precession nothing of it is left.
* **Drift** is the secular one, at 100 samples a second.
* **Operations** are counted, not timed; **state** is what is carried from one step to the next.

A dash stands for methods that are not optimised for coning, and where rounding leaves fewer than three intervals.
"""


@dataclass(frozen=True)
class MethodRow:
    """A method of the page.

    Attributes
    ----------
    name : str
    scores : dict
        Row at the case's own sampling interval for ``coning``, ``general`` and ``narrow``, with the fields of
        `sinsbench.scoring.rows`.
    """

    name: str
    scores: dict[str, dict[str, Any]]

    def cells(self) -> Iterator[str]:
        """Yield the cells of the page."""
        subject = BUILT_IN[self.name]
        drift = subject.order_drift or subject.order
        coning = self.scores["coning"]
        yield from (f"`{self.name}`", str(subject.samples_per_step))
        for theory, field in ((subject.order, "observed_order"), (drift, "secular_observed_order")):
            yield str(theory)
            yield from (_number(self.scores[motion][field], ".2f") for motion in _MOTIONS)
        narrow = self.scores["narrow"]["secular_observed_order"] if subject.order_coning else None
        yield from (_number(subject.order_coning, "d"), _number(narrow, ".2f"))
        yield from (_number(self.scores[motion]["secular_drift_deg_per_h"], ".3e") for motion in _MOTIONS)
        yield from (_number(coning["flops_per_sample"], ".1f"), _number(coning["state_bytes"], "d"), subject.source)


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def narrow_cone() -> DualPrecessionCase:
    """Return coning of 1 Hz with a half-angle of 0.01 deg, for 120 s."""
    return replace(
        _paper_case("coning"),
        name="narrow_cone",
        nutation=ExactNumber("pi/18000"),
        interval=ExactNumber("0.05"),
        duration=ExactNumber("120"),
    )


def _paper_case(motion: str) -> DualPrecessionCase:
    name = f"variant2_{motion}"
    found = next(case for case in paper_cases(DUAL_PRECESSION) if case.name == name)
    if not isinstance(found, DualPrecessionCase):
        raise TypeError(f"{name} is no motion")
    return found


def method_rows(names: Sequence[str] | None = None) -> tuple[MethodRow, ...]:
    """Score methods on the three motions of the page.

    Parameters
    ----------
    names : sequence of str, optional
        Built-in integrators; all of them by default.
    """
    chosen = [subject.name for subject in subjects_of(DUAL_PRECESSION)] if names is None else list(names)
    cases = {motion: _paper_case(motion) for motion in _MOTIONS}
    scored = score(chosen, tuple(cases.values()), repetitions=0)
    scored += score(chosen, (narrow_cone(),), factors=_NARROW_FACTORS, repetitions=0)
    own = {
        (row["subject"], row["case"]): row
        for case in (*cases.values(), narrow_cone())
        for row in scored
        if row["case"] == case.name and row["interval"] == float(case.interval)
    }
    places = {motion: case.name for motion, case in cases.items()} | {"narrow": narrow_cone().name}
    return tuple(MethodRow(name, {place: own[name, case] for place, case in places.items()}) for name in chosen)


def page(rows: Sequence[MethodRow]) -> str:
    """Return the page in Markdown."""
    lines = [_HEADINGS, ("---",) * len(_HEADINGS), *(tuple(row.cells()) for row in rows)]
    return _INTRODUCTION + "\n" + "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


if __name__ == "__main__":
    print(page(method_rows()), end="")
