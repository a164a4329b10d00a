"""How the numbers of Loginov, Tkachenko, Chelnokov 2013 are recomputed: in balls, from the corrected formulas.

Cases are those of the tier ``paper`` of the dataset ``equator_errors``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from sinsbench.claims import discrepancy as check
from sinsbench.claims.quantities import Enclosure, Quantity
from sinsdata.cases import EquatorCase
from sinsdata.tiers import paper_cases
from sinsref.equator import EquatorModel, homogeneous
from sinsref.equator_modes import modes, oscillations, vanishing_force_speeds
from sinsref.exact import ExactNumber
from sinsref.pi_monomials import PiMonomialArithmetic

COMPONENTS = {
    "dv_north": "m/s",
    "dv_up": "m/s",
    "dv_east": "m/s",
    "d_height": "m",
    "d_latitude": "rad",
    "d_longitude": "rad",
}
"""The six errors, in the order of the state, with their units."""

_BITS = 256


@dataclass(frozen=True)
class _Solution:
    """What the tables of the paper give of one case."""

    radius: Fraction
    rates: Mapping[str, Enclosure]
    periods: Mapping[str, Enclosure]
    errors: Mapping[str, Enclosure]
    amplitudes: Mapping[str, Enclosure]
    phases: Mapping[str, str]


def _case(name: str) -> EquatorCase:
    cases = {case.name: case for case in paper_cases("equator_errors") if isinstance(case, EquatorCase)}
    return cases[name]


@cache
def _solution(name: str) -> _Solution:
    case = _case(name)
    with PiMonomialArithmetic(_BITS) as ar:
        model = EquatorModel.at(ar, case.v_east, case.height)
        constants = modes(ar, model)
        initial = [ar.number(x) for x in case.initial_errors]
        errors = homogeneous(ar, model, initial, ar.number(case.duration))
        swings = dict(zip(COMPONENTS, oscillations(ar, model, constants, initial), strict=True))
        # The phases of (24) are no multiples of a right angle, and the paper gives none.
        printable = {} if name.endswith("check") else {k: s.signed(ar) for k, s in swings.items() if s is not None}
        rates = {name: getattr(constants, name) for name in ("beta3", "omega", "mu")}
        return _Solution(
            radius=Enclosure.of(model.radius).middle,
            rates={key: Enclosure.of(rate) for key, rate in rates.items()},
            periods={key: Enclosure.of(ar.pi * 2 / rates[key]) for key in ("omega", "mu")},
            errors={key: Enclosure.of(x) for key, x in zip(COMPONENTS, errors, strict=True)},
            amplitudes={key: Enclosure.of(amplitude) for key, (amplitude, _) in printable.items()},
            phases={key: phase for key, (_, phase) in printable.items()},
        )


def modal_rate(*, case: str, mode: str) -> Quantity:
    """Rate of a mode, (17): ``beta3``, ``omega`` or ``mu``, 1/s."""
    return Quantity(_solution(case).rates[mode], "1/s")


def modal_period(*, case: str, mode: str) -> Quantity:
    """Period 2 pi over the rate of the oscillation ``omega`` or ``mu``, s."""
    return Quantity(_solution(case).periods[mode], "s")


def orbit_radius(*, case: str) -> Quantity:
    """Radius R = a + H of the circle that the object follows, m."""
    return Quantity(Enclosure.exact(_solution(case).radius), "m")


def schuler_period(*, radius: str, gravity: str) -> Quantity:
    """Schuler's period 2 pi sqrt(radius/gravity), s, for a radius in m and a gravity in m/s^2."""
    with PiMonomialArithmetic(_BITS) as ar:
        return Quantity(Enclosure.of(ar.pi * 2 * ar.sqrt(ar.number(radius) / ar.number(gravity))), "s")


def largest_speed(*, height: str) -> Quantity:
    """Eastward speed at which the roots cease to be two real and two imaginary ones, m/s: a_H vanishes there."""
    with PiMonomialArithmetic(_BITS) as ar:
        return Quantity(Enclosure.of(vanishing_force_speeds(ar, ExactNumber(height))[1]), "m/s")


def initial_error(*, case: str, component: str) -> Quantity:
    """Return the initial error of a component, exactly as (24) and Table 1 give it in SI units."""
    place = list(COMPONENTS).index(component)
    value = _case(case).initial_errors[place].fraction
    if value is None:
        raise ValueError(f"the initial error {component} of {case} is not rational")
    return Quantity(Enclosure.exact(value), COMPONENTS[component], _solution(case).radius)


def final_error(*, case: str, component: str) -> Quantity:
    """Error of a component at the end of the case, (20); zero only where it is exactly zero."""
    solution = _solution(case)
    return Quantity(solution.errors[component], COMPONENTS[component], solution.radius)


def amplitude(*, case: str, component: str) -> Quantity:
    """Amplitude of the oscillation of a component, (19), with the sign that belongs to a phase of 0 or pi/2."""
    solution = _solution(case)
    return Quantity(solution.amplitudes[component], COMPONENTS[component], solution.radius)


def phase(*, case: str, component: str) -> Quantity:
    """Return the initial phase of the oscillation of a component, (19): ``0`` or ``pi/2``."""
    return Quantity(_solution(case).phases[component], "rad")


def discrepancy_component() -> Quantity:
    """Component in which the printed solution (22) is farthest from the certified one under (24)."""
    symbols = ("dv_N", "dv_H", "dv_E", "dH", "dphi", "dlambda")
    errors = np.abs(check.errors_of("equator_printed")).max(axis=0)
    return Quantity(symbols[int(errors.argmax())], "")


def discrepancy_size() -> Quantity:
    """Largest error of dv_H by the printed (22) over the two hours of (24), m/s."""
    return Quantity(Enclosure.exact(float(np.abs(check.errors_of("equator_printed")[:, check.UP]).max())), "m/s")


def discrepancy_instant() -> Quantity:
    """Instant of that largest error, s, on the grid of the case."""
    place = int(np.abs(check.errors_of("equator_printed")[:, check.UP]).argmax())
    return Quantity(Enclosure.exact(float(check.truth().time[place])), "s")


def discrepancy_at(*, time: str) -> Quantity:
    """Size of the error of dv_H by the printed (22) at an instant, s, of the grid of the case, m/s."""
    place = int(np.searchsorted(check.truth().time, float(time)))
    return Quantity(Enclosure.exact(float(abs(check.errors_of("equator_printed")[place, check.UP]))), "m/s")


def orders_below(*, solver: str, end: str) -> Quantity:
    """Orders of magnitude by which a numerical solution leaves the printed (22) closer in the other five components.

    Parameters
    ----------
    solver : str
        Subject of `sinsbench.subjects` that stands for the numerical solution.
    end : {"least", "most"}
        Of the five.
    """
    orders = check.orders_below_upward_velocity(check.errors_of(solver) - check.errors_of("equator_printed"))
    if orders is None:
        raise ValueError(f"{solver} differs from the printed formulas in no other component")
    return Quantity(Enclosure.exact(orders[end == "most"]), "orders")


RECIPES: Mapping[str, Callable[..., Quantity]] = {
    recipe.__name__: recipe
    for recipe in (
        modal_rate,
        modal_period,
        orbit_radius,
        schuler_period,
        largest_speed,
        initial_error,
        final_error,
        amplitude,
        phase,
        discrepancy_component,
        discrepancy_size,
        discrepancy_instant,
        discrepancy_at,
        orders_below,
    )
}
"""The recipes by name."""
