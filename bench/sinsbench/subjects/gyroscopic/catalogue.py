"""The gyroscopic systems and the subjects made of them by name: light, for whoever only lists them."""

from collections.abc import Mapping
from typing import NamedTuple

__all__ = ["CATALOGUE", "SUBJECTS", "Entry", "GyroscopicRow"]


class Entry(NamedTuple):
    """What a system is.

    Attributes
    ----------
    name : str
    summary : str
        In one line.
    equations : str
        Equations of Chelnokov 1991, corrected, or where else they are from.
    """

    name: str
    summary: str
    equations: str


_ENTRIES = (
    Entry("gp_paper", "gyropendulum, kappa = 1/sqrt(g R), started at alpha = -kappa v", "(2.6)"),
    Entry("gp_equilibrium", "gyropendulum, kappa = 1/sqrt(g R), started where it rests at constant v and w3", "(2.6)"),
    Entry("gpx", "gyropendulum, H(t) = m l sqrt(g R - v(t)^2), which makes sin alpha = -v/sqrt(g R) exact", "(2.5)"),
    Entry("bg_paper", "bi-gyro vertical, kappa = 1/sqrt(g R), started at alpha = -kappa v", "(2.6) twice"),
    Entry(
        "bg_equilibrium",
        "bi-gyro vertical, kappa = 1/sqrt(g R), started where both rest at constant v and w3",
        "(2.6) twice",
    ),
    Entry("bgx", "bi-gyro vertical, tuned by the angle between its own axes", "(2.5) twice"),
    Entry("bgv", "bi-gyro vertical, kappa = 1/sqrt(g R - v^2) for the speed at the start", "(2.6) twice"),
    Entry("gf", "two-rotor gyroframe, N(E) = -(4 B^2/(m l R)) sin E cos E", "(2.12)-(2.14)"),
    Entry("gf_linear", "two-rotor gyroframe, N(E) linear, right at the start speed", "(2.12)-(2.14)"),
    Entry("ghc", "spatial gyrohorizoncompass, constant radius", "(2.15)"),
    Entry("ghc_radius", "spatial gyrohorizoncompass, R = r(t) put into the printed form", "(2.15)"),
    Entry("ghc_altitude", "spatial gyrohorizoncompass, R = r(t) and h' = a1 - r' h/r", "(2.15) extended"),
    Entry("full", "full equations, n = 1/(m l R), L = m l r^ x v", "(3.1)"),
    Entry("trad", "two-component inertial system in the azimuth-free trihedron", "traditional"),
    Entry("newton", "three-component Newton equation, unaided", "traditional"),
    Entry("gp_moments", "gyropendulum with moments M_eta and spin w*_3 of any law", "(2.1), (2.2)"),
    Entry("gyroscope_general", "gyroscope with its centre of mass anywhere", "(1.8), (1.12)"),
    Entry("gf_moments", "gyroframe with moments M_Y and rate w_Y2 of any law", "(2.12), (2.13)"),
    Entry("deviation", "deviation lambda of the gyro frame from a trihedron Z", "(1.13)"),
    Entry("gp_deviation", "deviation lambda of a gyropendulum from a trihedron Z", "(2.7)"),
)

CATALOGUE: Mapping[str, Entry] = {entry.name: entry for entry in _ENTRIES}
"""The systems by name."""


class GyroscopicRow(NamedTuple):
    """A subject: a system, a method, and what it is fed.

    Attributes
    ----------
    name, summary, source : str
    system, method : str
        Names in `CATALOGUE` and in `sinsbench.subjects.gyroscopic.drivers.METHODS`.
    takes : {"points", "increments"}
    samples_per_step : int
        Intervals between points, or samples of increments, that a step spans.
    order : int
    """

    name: str
    summary: str
    source: str
    system: str
    method: str
    takes: str
    samples_per_step: int
    order: int


_SCORED = ("gp_paper", "gp_equilibrium", "gpx", "bg_paper", "bg_equilibrium", "bgx", "bgv", "gf", "gf_linear", "ghc",
           "ghc_radius", "ghc_altitude", "full", "trad", "newton")  # fmt: skip
"""Systems that ask for no more than a motion tells."""
_COMPARED = ("bgx", "ghc", "full", "trad")
"""Systems that show what another method changes."""
_METHODS = (
    ("", "", "rk4", "points", 2, 4, _SCORED),
    ("_increments", ", from increments", "rk4", "increments", 4, 4, _SCORED),
    ("_lie", ", commutator-free Lie group method", "commutator_free", "points", 2, 4, _COMPARED),
    ("_dop853", ", DOP853", "dop853", "points", 2, 8, _COMPARED),
)


def _rows() -> tuple[GyroscopicRow, ...]:
    return tuple(
        GyroscopicRow(
            name + suffix,
            CATALOGUE[name].summary + addition,
            f"Chelnokov 1991, {CATALOGUE[name].equations}" if CATALOGUE[name].equations[0] == "(" else "traditional",
            name,
            method,
            takes,
            samples,
            order,
        )
        for suffix, addition, method, takes, samples, order, names in _METHODS
        for name in names
    )


SUBJECTS: Mapping[str, GyroscopicRow] = {row.name: row for row in _rows()}
"""The subjects by name."""
