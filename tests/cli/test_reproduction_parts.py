"""The parts of the main job: which stand beside which, and what the process that hands them out has in memory."""

import subprocess
import sys
from collections import Counter

from sinsbench.reproduction.run import _groups, _subjects
from sinsdata.cases import DualPrecessionCase
from sinsdata.tiers import paper_cases


def test_each_case_is_scored_once_and_the_precessions_in_one_part() -> None:
    cases = [case for dataset in ("dual_precession", "equator_errors") for case in paper_cases(dataset)]
    groups = _groups(cases)
    assert Counter(case.name for group in groups for case in group) == Counter(case.name for case in cases)
    assert [isinstance(group[0], DualPrecessionCase) for group in groups] == [True, False, False, False]
    assert [len(group) for group in groups] == [6, 3, 3, 2]
    assert all(len({type(case) for case in group}) == 1 and _subjects(group) for group in groups)
    # Without the precessions no empty group stands in their place.
    others = [case for case in cases if not isinstance(case, DualPrecessionCase)]
    assert [len(group) for group in _groups(others)] == [3, 3, 2]


def test_the_process_that_waits_does_not_load_the_compiler() -> None:
    """A hundred megabytes of the gigabyte that all processes of `sinsbench reproduce` may have together."""
    code = (
        "import sys, sinsbench.reproduction.run, sinsbench.reproduction.summary, sinsdata.tiers;"
        "print([name for name in ('numba', 'scipy', 'altair') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
