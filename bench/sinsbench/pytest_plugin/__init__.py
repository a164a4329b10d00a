"""Plugin for pytest: cases of certified truth as fixtures, and scores as assertions, in anyone's test suite.

It is installed with the package (entry point ``pytest11``). What the fixtures need is imported when a test asks for it:
a run that uses neither pays for this module alone. PYTEST_DONT_REWRITE: it holds no assertion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from sinsbench.pytest_plugin.cases import SuppliedCase
    from sinsbench.pytest_plugin.scores import Scores

__all__ = ["sins_case", "sins_score"]


@pytest.fixture(scope="session")
def sins_case() -> Callable[..., SuppliedCase]:
    """Return ``sins_case(dataset, case, takes=None)``: the inputs and the truth of a case.

    See `sinsbench.pytest_plugin.cases.supplied_case`.
    """
    from sinsbench.pytest_plugin.cases import supplied_case

    return supplied_case


@pytest.fixture
def sins_score(request: pytest.FixtureRequest) -> Callable[..., Scores]:
    """Return ``sins_score(case, answer, *conditions, name=None)``: the scores of a function, or of what it returned.

    Where the test uses the fixture ``benchmark`` of pytest-benchmark, the scores land in its ``extra_info``, in a list
    ``sins_scores``. See `sinsbench.pytest_plugin.scores.scores_of`.
    """
    from sinsbench.pytest_plugin.scores import scores_of

    def score(case: SuppliedCase, answer: Any, *conditions: str, name: str | None = None) -> Scores:
        __tracebackhide__ = True  # the test that asked is the place to look at
        scores = scores_of(case, answer, name=name)
        if "benchmark" in request.fixturenames:
            info = request.getfixturevalue("benchmark").extra_info
            known: Mapping[str, Any] = {field: value for field, value in scores.items() if value is not None}
            info.setdefault("sins_scores", []).append(known)
        return scores.require(*conditions)

    return score
