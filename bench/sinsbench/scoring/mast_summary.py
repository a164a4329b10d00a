"""Scores of estimators over the seeds of one scenario: medians of errors, and the consistency that one run cannot tell.

A family are cases whose names end in ``_`` and a whole number: seed_1000, seed_1001, ...
"""

import re
from collections.abc import Mapping, Sequence
from statistics import mean, median
from typing import Any

from sinsbench.scoring.mast import NEES_TIMES
from sinsbench.scoring.mast_errors import BLOCKS, QUANTITIES
from sinsbench.scoring.rows import Field, plain_row

__all__ = ["CONFIDENCE", "SUMMARY_FIELDS", "family_of", "nees_band", "summary"]

CONFIDENCE = 0.95
"""Probability with which the mean over runs of a consistent estimator lies in its band."""

_MEMBER = re.compile(r"(.+)_\d+")
_MEDIANS = ("mu", "nu", "antenna", "mast", "position", "velocity")
_WINDOWS = ("50_200", "200_500", "500_1000", "late")

SUMMARY_FIELDS = (
    Field("subject", "", "name of the subject"),
    Field("family", "", "what the names of the cases begin with"),
    Field("cases", "", "number of runs with a score"),
    Field("failed", "", "number of runs without one"),
    *(
        Field(f"{name}_{size}_{window}", QUANTITIES[name][0], f"median over the runs of {name}_{size}_{window}")
        for name in _MEDIANS
        for window in _WINDOWS
        for size in ("rms", "max")
    ),
    *(
        Field(f"nees_{block}_{when}s", "", f"mean over the runs of nees_{block}_{when}s")
        for block in BLOCKS
        for when in NEES_TIMES
    ),
    *(
        Field(f"nees_{block}_{end}", "", f"{end} end of the band of these means")
        for block in BLOCKS
        for end in ("low", "high")
    ),
    Field("nis_ratio", "", "mean over the runs of nis_ratio"),
)


def family_of(case: str) -> str | None:
    """Return the name of the family that a case is one of, None where it is of none."""
    matched = _MEMBER.fullmatch(case)
    return matched[1] if matched else None


def nees_band(freedom: int, runs: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the band of the mean over runs of a chi-square variable: that of freedom * runs, divided by the runs.

    Parameters
    ----------
    freedom, runs : int
    confidence : float

    Returns
    -------
    low, high : float

    Raises
    ------
    ValueError
        If a number is not positive or the confidence not between 0 and 1.

    Notes
    -----
    Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and Navigation* (2001), section 5.4.2.
    """
    from scipy.stats import chi2

    if freedom < 1 or runs < 1 or not 0 < confidence < 1:
        raise ValueError(f"{freedom} degrees of freedom, {runs} runs, confidence {confidence}: no band")
    tail = (1 - confidence) / 2
    low, high = (float(chi2.ppf(x, freedom * runs)) / runs for x in (tail, 1 - tail))
    return low, high


def summary(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Summarise scores over families of two cases at least.

    Parameters
    ----------
    rows : sequence of mapping
        Scores (`sinsbench.scoring.mast.FIELDS`).

    Returns
    -------
    list of dict
        Rows with the fields `SUMMARY_FIELDS`, one for each subject and family.
    """
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in rows:
        # A case that a subject does not claim to bear, or that a file does not hold, is no run and no failure.
        if row["status"] != "not applicable" and (family := family_of(row["case"])):
            groups.setdefault((row["subject"], family), []).append(row)
    return [_summarised(*key, members) for key, members in groups.items() if len(members) > 1]


def _summarised(subject: str, family: str, members: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    scored = [row for row in members if row["status"] == "ok"]
    told: dict[str, Any] = {
        "subject": subject,
        "family": family,
        "cases": len(scored),
        "failed": len(members) - len(scored),
    }
    for field in SUMMARY_FIELDS:
        values = [row[field.name] for row in scored if row.get(field.name) is not None]
        # A mean over fewer runs than the others has another band, a median of survivors another meaning.
        if field.name not in told and values and len(values) == len(scored):
            told[field.name] = (mean if field.name.startswith(("nees", "nis")) else median)(values)
    for block, places in BLOCKS.items():
        if any(f"nees_{block}_{when}s" in told for when in NEES_TIMES):
            told[f"nees_{block}_low"], told[f"nees_{block}_high"] = nees_band(len(places), len(scored))
    return plain_row(SUMMARY_FIELDS, told)
