r"""Equations of Chelnokov 1991 in the form printed and in others, each put to the test on exact data.

A form is the text of the part in question. What decides on it is a pair of quaternions: what the definitions give, and
what the form gives. Both come in ball arithmetic, from rational data without any symmetry, or from an exact motion. A
form holds if the difference is a narrow ball around zero; it fails if the ball keeps away from zero.

The definitions: the momentum :math:`L\eta_k` changes by the moment :math:`M' + M'' = M + m\,a\times l` (1.6), a
quaternion turns by :math:`2\dot q = q\circ\omega`, rotations are put together by :math:`e = \nu\circ\lambda`,
:math:`\mu = \bar e\circ s`.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache

from sinsbench.claims import gyroscopic_frame_forms as frame
from sinsbench.claims import gyroscopic_precession_forms as precession
from sinsbench.claims.gyroscopic_form_data import Data, Sides
from sinsbench.claims.gyroscopic_states import relative_residual
from sinsbench.claims.quantities import Enclosure, hull
from sinsref.arithmetic import BallArithmetic

BITS = 192
NARROW = Fraction(1, 2**140)
"""Width, relative to the equation, within which a form must vanish: far above what 192 bits leave."""
SEEDS = (1, 2, 3)
"""Seeds of the data: an equation holds for all of them, or it does not hold."""

EQUATIONS: Mapping[str, Callable[[Data], Mapping[str, Sides]]] = {
    "(1.1)": precession.rate_of_the_reference,
    "(1.3)": precession.change_of_momentum,
    "(1.4)": precession.turning_axes,
    "(1.7), text": precession.general_rate,
    "(1.7)": precession.general_rate_as_printed,
    "(1.8)": precession.rate_in_own_axes,
    "(1.9), text": precession.pendulum,
    "(1.12)": precession.momentum,
    "(1.14)": precession.attitude,
    "(2.7)": precession.pendulum_deviation,
    "(2.9), position": frame.position,
    "(2.9), (2.11), heading": frame.heading,
    "(2.11), pitch": frame.pitch,
    "(2.11), roll": frame.roll,
    "(2.12)": precession.compass_change,
    "(2.13)": precession.compass_rate,
    "(2.14)": precession.rotors,
    "(2.15)": precession.compass_speed,
    "(2.15), text": precession.resolved_force,
    "(3.1), momentum": frame.full_momentum,
    "(3.1), weight": frame.full_weight,
    "(3.1), text": frame.frame_turning,
}
"""Equations by place: a function from data to the forms of each."""


@cache
def residuals(equation: str) -> Mapping[str, Enclosure]:
    """Return what each form of an equation leaves, relative to the equation, over all data.

    Parameters
    ----------
    equation : str
        A key of `EQUATIONS`.
    """
    return residuals_of(EQUATIONS[equation])


def residuals_of(forms: Callable[[Data], Mapping[str, Sides]]) -> Mapping[str, Enclosure]:
    """Return what forms leave, relative to the equation, over all data.

    Parameters
    ----------
    forms : callable
        ``forms(data)`` returns the two sides of each form.
    """
    with BallArithmetic(BITS) as balls:
        drawn = [forms(Data(balls, seed)) for seed in SEEDS]
        found = [{text: relative_residual(balls, *sides) for text, sides in row.items()} for row in drawn]
    return {text: hull(*(row[text] for row in found)) for text in found[0]}


def holding(left: Mapping[str, Enclosure]) -> str:
    """Return the form that vanishes, where it is one alone and all others keep away from zero; else ``none``."""
    vanishing = [text for text, value in left.items() if value.upper < NARROW]
    decided = all(value.lower > NARROW for text, value in left.items() if text not in vanishing)
    return vanishing[0] if len(vanishing) == 1 and decided else "none"
