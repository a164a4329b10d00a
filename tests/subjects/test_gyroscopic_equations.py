"""The compiled right-hand sides of gyroscopic systems against the laws of mechanics."""

import pytest

from gyroscopic_laws import LAWS
from sinsbench.subjects.gyroscopic import equations
from sinsbench.subjects.gyroscopic.systems import SYSTEMS


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_the_equations_are_the_laws_of_mechanics(law):
    assert law(equations)


def test_every_right_hand_side_has_its_law():
    assert {system.right_hand_side for system in SYSTEMS.values()} <= {law.__name__ for law in LAWS}
