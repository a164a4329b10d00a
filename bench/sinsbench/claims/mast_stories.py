"""Under which assumptions the figures of Sokolov, Pogorelov, Reshetnikova 2024 hold, as a table."""

from math import isfinite
from typing import Any

from sinsbench.claims.mast_runs import run, settled

__all__ = ["SETTINGS", "assumptions"]

SETTINGS = (
    ("cekf", "N1_G1"),
    *(("mekf_nu_az", case) for case in ("N1_G1", "N4_G1", "N4_G2", "N4_G3")),
)
"""Estimators and cases that are compared."""
LIMITS = {"mu": 1e-4, "eta": 2.5e-5, "lambda": 2e-5}
"""Limits of the errors of a quaternion's numbers that the paper prints."""
LARGEST = {"eta": 200.0, "lambda": 50.0}
"""Times from which on it says that they are kept, s; for mu that is 50 s."""


def assumptions() -> tuple[str, tuple[dict[str, Any], ...]]:
    """Return what each estimator reaches on each case: a sentence, and rows.

    Returns
    -------
    sentence : str
    rows : tuple of dict
        A row an estimator and case: how long it ran, s; from when on the errors of the numbers of mu stay below 1e-4,
        s, None if they do not; largest errors of those of eta from 200 s and of lambda from 50 s on; largest errors of
        longitude and latitude from 200 s on, rad.
    """
    rows = []
    for estimator, case in SETTINGS:
        found = run(estimator, case)
        when = settled(found.time, found.components("mu"), LIMITS["mu"])
        row: dict[str, Any] = {"estimator": estimator, "case": case, "duration_s": float(found.time[-1])}
        row["mu_below_1e-4_from_s"] = when if isfinite(when) else None
        row |= {f"{name}_max": float(found.components(name)[found.time >= t].max()) for name, t in LARGEST.items()}
        row |= {
            f"{name}_max_rad": float(found.errors[name][found.time >= 200].max()) for name in ("longitude", "latitude")
        }
        rows.append(row)
    by_name = {(row["estimator"], row["case"]): row for row in rows}
    paper, best = by_name["cekf", "N1_G1"], by_name["mekf_nu_az", "N4_G1"]
    sentence = (
        f"With one satellite the paper's filter keeps eta and lambda to {paper['eta_max']:.1e} and "
        f"{paper['lambda_max']:.1e}, a hundred times the limits; with the mast's constant length as a measurement they "
        f"come to {best['eta_max']:.1e} and {best['lambda_max']:.1e}, if the initial twist is known. With four "
        f"satellites longitude and latitude hold, and mu below 1e-4 from {best['mu_below_1e-4_from_s']:.0f} s on."
    )
    return sentence, tuple(rows)
