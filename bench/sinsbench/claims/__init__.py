"""Numbers printed in the papers, recomputed, each with a verdict.

`evaluate` judges every claim of a paper; `load_claims` reads them; the findings behind those that do not reproduce are
in `sinsbench.claims.stories`.
"""

from sinsbench.claims.evaluate import evaluate
from sinsbench.claims.model import PAPERS, Claim, ClaimFileError, ClaimResult, load_claims

__all__ = ["PAPERS", "Claim", "ClaimFileError", "ClaimResult", "evaluate", "load_claims"]
