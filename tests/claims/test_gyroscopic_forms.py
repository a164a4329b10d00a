"""Equations and states of Chelnokov 1991 in ball arithmetic: what holds, what fails, and that a defect is found."""

from collections.abc import Callable, Mapping
from fractions import Fraction

import pytest
from flint import arb

from sinsbench.claims.gyroscopic_form_data import AS_PRINTED, Data, Sides
from sinsbench.claims.gyroscopic_forms import BITS, EQUATIONS, NARROW, holding, residuals, residuals_of
from sinsbench.claims.gyroscopic_runs import horizontal
from sinsbench.claims.gyroscopic_states import STATES, Instant, relative_residual, residual_of_state
from sinsbench.claims.quantities import Enclosure
from sinsref.arithmetic import BallArithmetic

RIGHT = {
    "(1.1)": "omega0, omega*",
    "(1.3)": "L'",
    "(1.4)": "2 e'",
    "(1.7), text": "L",
    "(1.9), text": "-l eta_k",
    "(1.12)": "eta_k . M",
    "(1.14)": "2 s'",
    "(2.7)": "(H omega0_Z + m l a_Z + H')",
    "(2.11), roll": "mu0^2 + mu3^2",
    "(2.12)": "H'",
    "(2.13)": "m l a_Y2 - M_Y1",
    "(2.14)": "omega_Y2",
    "(2.15)": "h'",
    "(2.15), text": "conj e o s o a_xi o conj s o e",
    "(3.1), momentum": "z0'^2 + z1'^2 + z2'^2 + z3'^2",
    "(3.1), weight": "(a_Y'2 i1 - a_Y'1 i2)",
    "(3.1), text": "omega_Y3 y3",
}
SPHERE = ("T1", "T2", "T3", "T4", "T5")
SOLUTIONS = {
    "law with varying momentum": SPHERE,
    "rest": ("T1", "T2"),
    "self-tuned pair": SPHERE,
    "compass": SPHERE,
    "compass with r(t) and r'(t)": (*SPHERE, "T3_altitude"),
    "two-rotor frame": SPHERE,
    "full equations": SPHERE,
}
OTHERS = {
    "law of the paper": SPHERE,
    "rest": ("T3", "T4"),
    "law with varying momentum": ("T3_altitude",),
    "self-tuned pair": ("T3_altitude",),
    "compass": ("T3_altitude",),
    "compass with r(t)": ("T3_altitude",),
    "two-rotor frame": ("T3_altitude",),
    "two-rotor frame, linear spring": SPHERE,
    "full equations": ("T3_altitude",),
    "full equations, 1e-6 rad/s about the vertical": SPHERE,
}
NOTHING = Fraction(1, 10**45)
"""What 192 bits leave of a state at the near-stop, where w3 is divided by 0.05 m/s, is 3e-49."""


@pytest.mark.parametrize("place", EQUATIONS)
def test_one_form_holds_and_every_other_fails(place: str) -> None:
    left = residuals(place)
    assert holding(left) == RIGHT.get(place, AS_PRINTED)
    # Of data of the size of 1 a wrong term is not smaller than a few hundredths of an equation.
    assert all(value.lower > Fraction(1, 50) for text, value in left.items() if text != holding(left))


def _spoilt(forms: Callable[[Data], Mapping[str, Sides]]) -> Callable[[Data], Mapping[str, Sides]]:
    """Return forms of which each gives a component that is wrong by a part in 1e20."""

    def spoilt(data: Data) -> Mapping[str, Sides]:
        return {
            text: (known, [x * (1 + arb("1e-20")) if k == place else x for k, x in enumerate(given)])
            for text, (known, given) in forms(data).items()
            for place in [max(range(4), key=lambda k: abs(float(given[k])))]
        }

    return spoilt


@pytest.mark.parametrize("place", EQUATIONS)
def test_a_form_with_a_defect_fails(place: str) -> None:
    assert holding(residuals_of(_spoilt(EQUATIONS[place]))) == "none"


def test_forms_that_all_hold_decide_nothing() -> None:
    nothing, little, much = (Enclosure.exact(x) for x in (0, NARROW, "0.5"))
    assert holding({"a": nothing, "b": much}) == "a"
    assert holding({"a": nothing, "b": nothing}) == "none"
    assert holding({"a": much, "b": much}) == "none"
    assert holding({"a": nothing, "b": little}) == "none"


@pytest.mark.parametrize(("state", "motion"), [(state, motion) for state in SOLUTIONS for motion in SOLUTIONS[state]])
def test_what_is_a_solution(state: str, motion: str) -> None:
    assert residual_of_state(state, motion).upper < NOTHING


@pytest.mark.parametrize(("state", "motion"), [(state, motion) for state in OTHERS for motion in OTHERS[state]])
def test_what_is_none(state: str, motion: str) -> None:
    # The climb of T3 at varying altitude is zero at its start; somewhere at least the equation must be violated.
    assert residual_of_state(state, motion).upper > Fraction(1, 10**6)


def test_every_state_is_tested() -> None:
    assert set(SOLUTIONS) | set(OTHERS) == set(STATES)


@pytest.mark.parametrize("state", SOLUTIONS)
def test_an_equation_with_a_defect_has_another_solution(state: str) -> None:
    with BallArithmetic(BITS) as balls:
        known, given = STATES[state](Instant(balls, "T2", 1799))
        for place, x in enumerate(given):
            spoilt = [*given[:place], x * (1 + arb("1e-20")) + arb("1e-25"), *given[place + 1 :]]
            assert relative_residual(balls, known, spoilt).lower > NOTHING


def test_residuals_by_hand() -> None:
    with BallArithmetic(64) as balls:
        value = relative_residual(balls, [arb(3), arb(4)], [arb(3), arb(4) + arb(0, 1e-15)])
        assert value.lower == 0
        assert Fraction(1e-15) / 5 <= value.upper < Fraction(1e-15) / 5 * Fraction("1.001")
        exact = relative_residual(balls, [arb(3), arb(4)], [arb(6), arb(8)])
        assert exact.lower <= 1 <= exact.upper


def test_the_angle_of_a_tilted_vertical() -> None:
    with BallArithmetic(128) as balls:
        sine, cosine = balls.sin_cos(balls.number("1e-3"))
        tilted = horizontal([sine * balls.number("0.6"), -sine * balls.number("0.8"), cosine])
        assert tilted.lower <= Fraction("1e-3") <= tilted.upper
        assert tilted.upper - tilted.lower < Fraction(1, 10**30)
        upright = horizontal([arb(0, 1e-20), arb(0, 1e-20), arb(1)])
        assert upright.lower == 0
        assert upright.upper < Fraction(2, 10**20)
