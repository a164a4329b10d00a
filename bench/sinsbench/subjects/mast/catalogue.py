"""The estimators of the mast's antenna by name: light, for whoever only lists them."""

from collections.abc import Mapping
from typing import NamedTuple

from sinsbench.subjects.mast.terms import VARIANTS

__all__ = ["FAULTS", "SUBJECTS", "MastRow"]


class MastRow(NamedTuple):
    """An estimator: a filter, how it works, and the equations that it believes in.

    Attributes
    ----------
    name, summary, source : str
    filter : {"continuous", "discrete", "relinearised"}
    options : mapping of str to float
        Of `sinsbench.subjects.mast.steps.Options`, or ``missing_term`` of the continuous filter.
    variant : str
        Name in `sinsbench.subjects.mast.terms.VARIANTS`.
    """

    name: str
    summary: str
    source: str
    filter: str
    options: Mapping[str, float]
    variant: str = "corrected"


_PAPER = "Sokolov, Pogorelov, Reshetnikova 2024, (3.18)"
_MULTIPLICATIVE = "multiplicative extended Kalman filter, after Lefferts, Markley, Shuster 1982"
_BELL = "iterated Kalman smoother, Bell 1994"
_ETA, _NU = {"composite": 0.0, "constraint": 0.0}, {"composite": 1.0, "constraint": 0.0}

FAULTS = (
    "gravity_twice",
    "earth_rate_twice",
    "vehicle_turn_ignored",
    "transport_sign",
    "upward_cosine",
    "mast_sign",
    "mast_length",
    "turn_sign",
    "range_root",
)
"""Variants with one fault each."""

_ROWS = (
    MastRow("cekf", "continuous filter of the paper, corrected", _PAPER, "continuous", {}),
    MastRow(
        "cekf_complete",
        "the same, with the derivative of the noise coupling that the paper leaves out",
        _PAPER,
        "continuous",
        {"missing_term": 1.0},
    ),
    *(
        MastRow(f"cekf_{name}", f"continuous filter, {VARIANTS[name].summary}", _PAPER, "continuous", {}, name)
        for name in ("printed", "printed_313", "printed_root", "repaired")
    ),
    MastRow("mekf_eta", "discrete filter, errors of eta and lambda", _MULTIPLICATIVE, "discrete", _ETA),
    MastRow("mekf_nu", "discrete filter, errors of nu = lambda o eta and lambda", _MULTIPLICATIVE, "discrete", _NU),
    MastRow(
        "mekf_eta_az",
        "errors of eta and lambda; with the mast's constant length as a measurement",
        _MULTIPLICATIVE,
        "discrete",
        _ETA | {"constraint": 1.0},
    ),
    MastRow(
        "mekf_nu_az",
        "errors of nu and lambda; with the mast's constant length as a measurement",
        _MULTIPLICATIVE,
        "discrete",
        {},
    ),
    MastRow(
        "relinearised_az",
        "mekf_nu_az, gone over again from the start while it learns, that length in full weight",
        _BELL,
        "relinearised",
        {"inflation": 0.0},
    ),
    *(
        MastRow(f"mekf_nu_az_{name}", f"mekf_nu_az, {VARIANTS[name].summary}", _MULTIPLICATIVE, "discrete", {}, name)
        for name in FAULTS
    ),
)

SUBJECTS: Mapping[str, MastRow] = {row.name: row for row in _ROWS}
"""The estimators by name."""
