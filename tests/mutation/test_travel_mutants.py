"""Defects planted one at a time in the motions and their errors, and in recorded formulas, must be seen.

What judges the motions are the equations written out; what judges the recurrences is the lazy series.
"""

from balls import BITS, agree_alone
from mutants import Planter, survivors
from sinsref import recorded, travel
from sinsref.arithmetic import BallArithmetic, MpArithmetic
from sinsref.error_equations import (
    Earth,
    error_matrix,
    force_at_displaced_position,
    ideal_rates,
    local_geometry,
    required_force,
)
from sinsref.series import SeriesArithmetic

MOTION = ("210", "-40", "330", "7000", "0.7", "1.1")
LINEAR = ("0.3", "-0.2", "0.5", "70", "1e-3", "2e-3")
BEYOND = ("-0.01", "0.03", "0.02", "5", "3e-4", "-1e-4")
TURN_RATE = "0.011"


def expected_rates(ar, earth, along_geodesic):
    """The 18 rates, written out from the ideal equations and the printed matrix."""
    motion, linear, beyond = ([ar.number(x) for x in given] for given in (MOTION, LINEAR, BEYOND))
    at = local_geometry(ar, earth, motion)
    heading_rate = ar.number(TURN_RATE)
    if along_geodesic:
        heading_rate = heading_rate + (at.up - at.earth_up)
    change = [-(heading_rate * motion[2]), ar.number(0), heading_rate * motion[0]]
    force = required_force(ar, earth, motion, change)
    matrix = error_matrix(ar, earth, motion, force)
    linear_rates = [sum(a * x for a, x in zip(row, linear, strict=True)) for row in matrix]
    computed = [x + y + z for x, y, z in zip(motion, linear, beyond, strict=True)]
    resolved = force_at_displaced_position(ar, motion, computed, force)
    true_rates = ideal_rates(ar, earth, motion, force)
    computed_rates = ideal_rates(ar, earth, computed, resolved)
    rest = [x - y - z for x, y, z in zip(computed_rates, true_rates, linear_rates, strict=True)]
    return [*true_rates, *linear_rates, *rest], force


def travel_holds(module):
    with BallArithmetic(BITS) as ar:
        earth = Earth.krasovsky(ar)
        state = [ar.number(x) for x in (*MOTION, *LINEAR, *BEYOND)]
        for along_geodesic in (False, True):
            expected, force = expected_rates(ar, earth, along_geodesic)
            given = (ar.number(TURN_RATE), *([True] if along_geodesic else []))
            turning = module.Turning(*given)
            found = module.error_field(earth, turning)(ar, state)
            if len(found) != 18 or not found[1].is_zero():
                return False
            pairs = [(x, y) for x, y in zip(found, expected, strict=True) if not x.is_zero()]
            if len(pairs) != 17 or not all(agree_alone(x, y) for x, y in pairs):
                return False
            if not all(map(agree_alone, module.motion_rates(ar, earth, turning, state[:6])[1], force)):
                return False
    return True


def everything(ar, state):
    """A field in which every recorded operation occurs, some of them twice."""
    x, y, z = state
    root, (sine, cosine), (sinh, cosh) = ar.sqrt(x), ar.sin_cos(y * z), ar.sinh_cosh(z)
    product = x * y + y * x - 3 * (sine - cosine / 7) - (2 - root)
    return [product / root + x * x, 1 / cosh - sinh / (x + 2) + (y - 1) * (z + 1), -(ar.exp(-z) * 5) / z + 0 * x]


START, ORDER = ("1.3", "0.4", "-0.7"), 9


def lazy_coefficients(ar):
    series = SeriesArithmetic(ar)
    unknowns = [series.unknown(ar.number(x)) for x in START]
    for unknown, rate in zip(unknowns, everything(series, unknowns), strict=True):
        series.define(unknown, rate)
    return [[unknown[k] for k in range(ORDER + 1)] for unknown in unknowns]


def recurrences_hold(module):
    ar = MpArithmetic(40)
    recorder = module.Recorder(ar)
    if recorder.sign(recorder.variable()):  # it has no value yet
        return False
    field = module.RecordedField(ar, everything, 3)
    state = [ar.number(x) for x in START]
    for _ in range(2):  # a field is expanded again and again
        found = field.coefficients(state, ORDER)
        for row, expected in zip(found, lazy_coefficients(ar), strict=True):
            if not all(abs(x - y) < 1e-33 * (1 + abs(y)) for x, y in zip(row, expected, strict=True)):
                return False
    constants = module.RecordedField(ar, lambda recorder, _: [ar.number(2), 0], 2).coefficients(state[:2], 3)
    return constants == [[state[0], 2, 0, 0], [state[1], 0, 0, 0]]


#: Changes that leave every value right, by function and statement, and why.
_OWN = "a quotient's or root's own series has no coefficient k yet: the slice begins at its last one all the same"
EQUIVALENT = {
    "_convolution: return sum(map(mul, a[first:], b[k - first::-1])) if k >= first else 0: k - first -> ": _OWN,
    "_self_convolution: total = sum(map(mul, a[first:], a[k - first:k // 2:-1])) * 2: k - first -> ": _OWN,
}


def test_every_planted_defect_of_the_motions_is_seen():
    assert travel_holds(travel)
    unseen, planted = survivors(travel, travel_holds)
    assert unseen == []
    assert planted > 15


def test_every_planted_defect_of_the_recurrences_is_seen():
    assert recurrences_hold(recorded)
    unseen, planted = survivors(recorded, recurrences_hold, Planter)
    assert [place for place in unseen if not place.startswith(tuple(EQUIVALENT))] == []
    assert planted > 30
