"""What distinguishes the mast's equations as printed from the corrected ones: coefficients, as data.

Equation numbers are those of Sokolov, Pogorelov, Reshetnikova 2024.
"""

from collections.abc import Mapping
from typing import NamedTuple

__all__ = ["CORRECTED", "VARIANTS", "Terms", "Variant"]


class Terms(NamedTuple):
    """Coefficients of the model; the defaults are the corrected equations.

    A coefficient that selects between two forms is 0 or 1.

    Attributes
    ----------
    transport : float
        Factor of (2 Omega_S + omega_S) x V in (3.5): -1, printed +1.
    upward_square : float
        1 for Omega^2 r cos^2(latitude) in the upward component of g_S, 0 for the printed first power of the cosine.
    mast_gravity_square : float
        1 for Omega^2 in the northward component of g_Q, 0 for the printed Omega.
    mast_x, mast_y : float
        Factors of Delta_Y/R and Delta_X/R in the rates of w_X and w_Y, (3.13).
    length_inverted : float
        1 for the 1/R of (3.13), 0 for the R of (3.14).
    turn_x, turn_y : float
        Factors of k w_Y and k w_X in the rates of w_X and w_Y.
    gravity_x, gravity_y : float
        Factors of g_QY/R and g_QX/R there. Gravity is in the specific force f1 already: 0.
    relative : float
        1 if w_X, w_Y are rates relative to the vehicle, as in the paper, 0 if they are absolute.
    earth_turn : float
        1 if k is twice the Earth's rate, as in the paper, 0 if k = u_Z, the vehicle's rate about the mast.
    whole_earth_rate : float
        1 if that is the whole Earth rate, as in (3.14), 0 if its component along the mast, as in (3.13).
    earth_rate_again : float
        1 if the Earth's rate is added to what gyroscope 2 measures, as in (3.15); absolute rates hold it already: 0.
    range_square : float
        1 if all three differences are squared in the range, 0 if the second is not, as printed.
    """

    transport: float = -1.0
    upward_square: float = 1.0
    mast_gravity_square: float = 1.0
    mast_x: float = -1.0
    mast_y: float = 1.0
    length_inverted: float = 1.0
    turn_x: float = 1.0
    turn_y: float = -1.0
    gravity_x: float = 0.0
    gravity_y: float = 0.0
    relative: float = 0.0
    earth_turn: float = 0.0
    whole_earth_rate: float = 0.0
    earth_rate_again: float = 0.0
    range_square: float = 1.0


CORRECTED = Terms()


class Variant(NamedTuple):
    """A form of the equations.

    Attributes
    ----------
    name, summary : str
    terms : Terms
    """

    name: str
    summary: str
    terms: Terms


_GRAVITY_TWICE = {"gravity_x": -1.0, "gravity_y": 1.0}
_PAPER_RATES = {"relative": 1.0, "earth_turn": 1.0}
_REPAIRED = Terms(**_GRAVITY_TWICE, **_PAPER_RATES, earth_rate_again=1.0)
_MISPRINTS = {"transport": 1.0, "upward_square": 0.0, "mast_gravity_square": 0.0, "range_square": 0.0}
_PRINTED = _REPAIRED._replace(**_MISPRINTS, mast_y=-1.0, length_inverted=0.0, turn_y=1.0, whole_earth_rate=1.0)

VARIANTS: Mapping[str, Variant] = {
    variant.name: variant
    for variant in (
        Variant("corrected", "corrected equations", CORRECTED),
        Variant("repaired", "signs repaired, physical faults kept", _REPAIRED),
        Variant(
            "printed",
            "exactly as (3.14) to (3.17) print them",
            _PRINTED,
        ),
        Variant(
            "printed_313",
            "as printed, with the rates of the mast from (3.13) instead of (3.14)",
            _REPAIRED._replace(**_MISPRINTS, mast_y=-1.0, turn_x=-1.0, turn_y=1.0, gravity_y=-1.0),
        ),
        Variant("printed_root", "as printed, with the root of the range repaired", _PRINTED._replace(range_square=1.0)),
        Variant("gravity_twice", "gravity counted twice in the mast's equations", Terms(**_GRAVITY_TWICE)),
        Variant("earth_rate_twice", "Earth rate counted twice in gyroscope 2", Terms(earth_rate_again=1.0)),
        Variant("vehicle_turn_ignored", "mast's Coriolis term with the Earth's rate alone", Terms(**_PAPER_RATES)),
        Variant("transport_sign", "wrong sign of (2 Omega + omega) x V", Terms(transport=1.0)),
        Variant("upward_cosine", "first power of the cosine in the centrifugal term", Terms(upward_square=0.0)),
        Variant("mast_sign", "wrong sign of Delta_X in (3.13)", Terms(mast_y=-1.0)),
        Variant("mast_length", "R in place of 1/R", Terms(length_inverted=0.0)),
        Variant("turn_sign", "wrong sign of the mast's Coriolis term", Terms(turn_y=1.0)),
        Variant("range_root", "a difference that is not squared under the root of the range", Terms(range_square=0.0)),
    )
}
"""The forms of the equations by name."""
