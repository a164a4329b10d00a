"""The page of defects: all that is planted in the built-in subjects, and what the score sees of it.

``python -m sinsbench.mutants.page > docs/mutants.md`` writes it anew.
"""

from collections.abc import Sequence

from sinsbench.cli.output import markdown_table
from sinsbench.mutants.campaign import campaign
from sinsbench.mutants.runner import Planting
from sinsbench.mutants.tables import counts, reasons

__all__ = ["page"]

_INTRODUCTION = """\
# Defects planted in the methods

Would the scores notice if a method were wrong? `sinsbench mutants` plants a defect in each coefficient and each term of
each built-in integrator and solver, one at a time, and has the score judge it. `python -m sinsbench.mutants.page`
writes this page anew, in four minutes on two cores; a test plants the defects of one subject again and compares the
rows. The gyroscopic systems have their defects planted by the tests (`tests/mutation`).

* **Coefficients and power series.** Each number is multiplied by 1.001, loses its sign, or becomes zero. Samples of a
  product change places or move to the neighbour; numbers of a matrix change places with the next. Numbers that no step
  reads are left alone.
* **Terms** of compiled kernels and of formulas. A sum has its sign exchanged or loses a term, a product grows by a
  thousandth, operands of a vector product change places, a constant grows by a thousandth, an index moves to its
  neighbour, a minus sign is lost. What no case passes through, and what checks arguments, is left alone.
* **Told apart** is a defect if the score of a case shows other errors than the right subject, by more than ten times
  what rounding does. That is measured: the right subject runs again, four times, with the result of every operation
  moved by up to a unit in the last place at random. The cases are of one or two steps of 0.6 to 7.3 rad, on coning
  and general precession, with large and with little force; 200 steps that hardly turn, for the rounding of sums;
  flights at speeds where formulas divide by what is nearly zero, and flights on which the control of a step has to
  work.
* **Survivors** are those that no score tells apart, though results on random inputs change by more than rounding.
* **Equivalent** are those that change nothing there either, for a reason that is known and stands below; where none is
  known they are unexplained. Survivors, and unexplained ones in built-in subjects, make the exit status 1.

A term that several subjects share is planted in the first, and in the next only if it has not been told apart yet.
`sinsbench mutants NAME` plants in one subject, also in yours: `sinsbench mutants examples/two_sample.py:two_sample`.
"""


def page(planted: Sequence[Planting]) -> str:
    """Return the page in Markdown.

    Parameters
    ----------
    planted : sequence of Planting
        What `sinsbench.mutants.campaign.campaign` returned.
    """
    equivalent = reasons([mutant for one in planted for mutant in one.mutants])
    tables = [markdown_table(counts(planted)), *([markdown_table(equivalent)] if equivalent else [])]
    return "\n".join([_INTRODUCTION, "\n\n## Defects that make no difference\n\n".join(tables), ""])


if __name__ == "__main__":
    print(page(campaign()), end="")
