"""Strata of the tiers ``standard`` and ``short``: classes of cases, each with a stated rule and a stated number.

A case is a pure function of dataset, stratum and index: its pseudo-random numbers are hashes of these names
(`sinsdata.tiers.strata.declaration`), so every machine makes the same exact cases, in any order.
"""

from __future__ import annotations

from collections.abc import Mapping

from sinsdata.tiers.strata.declaration import SEED, Draw, Stratum
from sinsdata.tiers.strata.equator import EQUATOR_STRATA
from sinsdata.tiers.strata.precession import PRECESSION_STRATA

__all__ = ["SEED", "STRATA", "Draw", "Stratum"]

#: The strata of each dataset that has them, in the order of its tables.
STRATA: Mapping[str, tuple[Stratum, ...]] = {
    "equator_errors": EQUATOR_STRATA,
    "dual_precession": PRECESSION_STRATA,
}
