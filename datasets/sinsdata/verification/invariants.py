"""What the rows of a dataset owe each other: relations between stored pairs, whatever computed them."""

from __future__ import annotations

from collections.abc import Mapping

from sinsdata.verification import equator_invariants, gyroscopic_invariants, mast_invariants, precession_invariants
from sinsdata.verification.residuals import Invariant

#: Dataset -> relations between tables with rows per epoch or sample.
INVARIANTS: Mapping[str, tuple[Invariant, ...]] = {
    "dual_precession": precession_invariants.INVARIANTS,
    "equator_errors": equator_invariants.INVARIANTS,
    "error_equations": equator_invariants.GENERAL_INVARIANTS,
    "gyro_systems": gyroscopic_invariants.INVARIANTS,
    "mast_antenna": mast_invariants.INVARIANTS,
}
#: Dataset -> relations between the columns of tables with a row per case.
CASE_INVARIANTS: Mapping[str, tuple[Invariant, ...]] = {"equator_errors": equator_invariants.CASE_INVARIANTS}
