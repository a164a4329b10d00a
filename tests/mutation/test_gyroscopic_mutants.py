"""Defects planted one at a time in the gyroscopic subjects must be found: each term, coefficient, sign and index.

Their modules run as plain Python; what judges them states the laws in another way.
"""

from functools import cache

import numpy as np

from gyroscopic_laws import LAWS
from gyroscopic_motions import product, turned
from gyroscopic_mutants import plain, unseen
from sinsbench.subjects.gyroscopic import equations, stepping
from sinsbench.subjects.gyroscopic.equations import Constants


def test_every_defect_in_a_right_hand_side_is_found():
    def holds(module, name):
        return all(law(module) for law in sorted(LAWS, key=lambda law: law.__name__ != name))

    found, planted = unseen(equations, holds, left_out=("RightHandSide", "Condition", "Array"))
    assert found == []
    assert planted > 300


# One step at a time


CONSTANTS = Constants(*np.linspace(0.7, 1.4, 8))
STEP, STEPS = 0.4, 3
#: Rotations of less than half a radian a step: the series of the kernels are exact to rounding there.
ROUNDING = 1e-14
#: Sensors and aiding inputs at start, middle and end of each step: no two alike.
RATE, FORCE, AID = np.random.default_rng(7).uniform(0.2, 0.9, (3, STEPS, 3, 3))
START = np.array([*np.full(4, 0.5), 0.6, 0.0, 0.8, 0.0, 0.0, -0.28, 0.96, 0.0, 0.3, -0.4, 0.5])


def field(state, force, aid, constants, rate):
    """Rates of two quaternions and three numbers, each of which depends on all there is."""
    mixed = np.sin(np.arange(1, 4) + state[:3] + 2 * state[4:7] - state[8:11] * force) * aid
    rate[:3], rate[3:6] = constants.tuning * mixed, 0.3 * np.cos(force + aid)
    rate[6:9] = mixed[::-1] - constants.gravity * state[8:11]


def margin(state, aid, constants):
    """Between 0 and 1 during all of the steps, if it is given what it should be."""
    return constants.tuning * aid[0] if state.shape == (11,) and aid.shape == (3,) else -1.0


def turns(q, w, side):
    """2 q' = w o q, or q o w of the vehicle, which turns in its own axes."""
    pure = np.array([0.0, *w])
    return product(q, pure) if side else product(pure, q)


def rates_of(full, k, point):
    rate = np.empty(9)
    field(full[4:], turned(full[:4], FORCE[k, point]), AID[k, point], CONSTANTS, rate)
    return [RATE[k, point], rate[:3], rate[3:6], rate[6:]]


def classical(full, k):
    """Kutta's method on the components, then one of Newton's steps to norm 1."""

    def slope(at, point):
        *turning, numbers = rates_of(at, k, point)
        q = [turns(at[4 * i : 4 * i + 4], w, i == 0) / 2 for i, w in enumerate(turning)]
        return np.concatenate([*q, numbers])

    first = slope(full, 0)
    second = slope(full + STEP / 2 * first, 1)
    third = slope(full + STEP / 2 * second, 1)
    moved = full + STEP / 6 * (first + 2 * second + 2 * third + slope(full + STEP * third, 2))
    for q in np.split(moved[:12], 3):
        q *= (3 - q @ q) / 2
    return moved


def commutator_free(full, k):
    """Celledoni, Marthinsen, Owren 2003, their scheme of order 4, by exponentials."""

    def moved(at, change):
        *turning, numbers = (STEP * x for x in change)
        result = []
        for i, w in enumerate(turning):
            angle = np.linalg.norm(w)
            turn = np.array([np.cos(angle / 2), *(w * np.sin(angle / 2) / angle)])
            q = at[4 * i : 4 * i + 4]
            result.append(product(q, turn) if i == 0 else product(turn, q))
        return np.concatenate([*result, at[12:] + numbers])

    def mix(*terms):
        return [sum(weight * slope[i] for weight, slope in terms) for i in range(4)]

    first = rates_of(full, k, 0)
    middle = moved(full, mix((1 / 2, first)))
    second = rates_of(middle, k, 1)
    third = rates_of(moved(full, mix((1 / 2, second))), k, 1)
    fourth = rates_of(moved(middle, mix((1, third), (-1 / 2, first))), k, 2)
    half = moved(full, mix((1 / 4, first), (1 / 6, second), (1 / 6, third), (-1 / 12, fourth)))
    return moved(half, mix((-1 / 12, first), (1 / 6, second), (1 / 6, third), (1 / 4, fourth)))


def run(module, name, condition=margin, right_hand_side=field, start=START, aid=AID, step=STEP):
    """Number and states of a run of the first steps; NaN where there are none."""
    states = np.full((len(aid) + 1, len(start)), np.nan)
    quaternions = 2 if right_hand_side is field else 0
    given = start.copy()
    sensors = (RATE, FORCE) if right_hand_side is field else (0 * aid, 0 * aid)
    broken = getattr(module, name)(
        right_hand_side, condition, quaternions, given, *sensors, aid, step, CONSTANTS, states
    )
    assert np.array_equal(given, start)
    return broken, states


@cache
def expected(name):
    states = [START]
    for k in range(STEPS):
        states.append({"classical_run": classical, "commutator_free_run": commutator_free}[name](states[-1], k))
    return np.array(states)


def slow(state, force, aid, constants, rate):
    rate[0] = 3e-17


def sums_are_compensated(module):
    """Thirty terms, each below half a unit of the last place of 1."""
    start = np.array([1.0, 0.0, 0.0, 0.0, 1.0])
    _, states = run(module, "classical_run", lambda *_: 0.5, slow, start, np.ones((30, 3, 3)), 1.0)
    return abs(states[-1, 4] - 1 - 9e-16) <= np.finfo(float).eps


def steps_are_right(module, name):
    for driver in ("classical_run", "commutator_free_run"):
        broken, states = run(module, driver)
        if broken != -1 or not np.allclose(states, expected(driver), rtol=0, atol=ROUNDING):
            return False
        for row, (k, point) in {0: (0, 0), 2: (1, 2)}.items():
            aid = AID.copy()
            aid[k, point, 0] = -0.1
            if run(module, driver, aid=aid)[0] != row or not np.isnan(run(module, driver, aid=aid)[1][row + 1 :]).all():
                return False
    state, rate, slope = START.copy(), np.arange(12.0), np.empty(15)
    module.component_slopes(state, rate, 2, slope)
    q = [turns(START[4 * i : 4 * i + 4], rate[3 * i : 3 * i + 3], i == 0) / 2 for i in range(3)]
    return np.allclose(slope, np.concatenate([*q, rate[9:]]), rtol=ROUNDING) and sums_are_compensated(module)


def test_every_defect_in_the_drivers_of_fixed_step_is_found():
    compiled_parts = {"Array", "ELEMENTARY", "FIXED_STEP", "function_pointer", "compiled_run"}
    compiled_parts |= {name for name in vars(stepping) if name.startswith("_")}
    replaced = {equations.__name__: plain(equations)}
    found, planted = unseen(stepping, steps_are_right, compiled_parts, replaced)
    # Work space that is larger than what is used of it.
    assert [place for place in found if not place.startswith("commutator_free_run: size =")] == []
    assert planted > 100
