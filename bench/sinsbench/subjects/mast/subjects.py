"""The estimators as callables: ``subjects.mekf_nu_az(inputs, start)``, one for each name of `catalogue.SUBJECTS`."""

from dataclasses import dataclass

from sinsbench.subjects.mast.catalogue import SUBJECTS, MastRow
from sinsbench.subjects.mast.continuous import continuous_filter
from sinsbench.subjects.mast.contract import MastInputs, MastStart, Result
from sinsbench.subjects.mast.discrete import discrete_filter
from sinsbench.subjects.mast.relinearised import relinearised_filter
from sinsbench.subjects.mast.steps import Options
from sinsbench.subjects.mast.terms import VARIANTS

_DISCRETE = {"discrete": discrete_filter, "relinearised": relinearised_filter}


@dataclass(frozen=True)
class MastSubject:
    """An estimator that can be scored.

    Parameters
    ----------
    row : MastRow
    """

    row: MastRow

    def __call__(self, inputs: MastInputs, start: MastStart) -> Result:
        """Estimate, as `sinsbench.subjects.mast.contract` says.

        Raises
        ------
        ValueError
            If inputs or start are malformed.
        OutcomeError
            If the step is beyond the stability bound, or the estimator broke down on its way.
        """
        terms = VARIANTS[self.row.variant].terms
        if self.row.filter == "continuous":
            return continuous_filter(inputs, start, bool(self.row.options.get("missing_term")), terms)
        return _DISCRETE[self.row.filter](inputs, start, Options(**self.row.options), terms)


def __getattr__(name: str) -> MastSubject:
    row = SUBJECTS.get(name)
    if row is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return MastSubject(row)


def __dir__() -> list[str]:
    return sorted(SUBJECTS)
