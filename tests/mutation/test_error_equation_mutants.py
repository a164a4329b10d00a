"""Defects planted one at a time in the error equations must be seen.

Every number of the modules is changed in its turn, every + becomes - and every - becomes +, every minus sign is
dropped. What judges the module are the ideal equations as the paper prints them, and their Jacobian.
"""

from flint import arb

from balls import BITS, agree, agree_alone, near
from equator_truth import GRAVITY, A, U
from mutants import survivors
from sinsref import error_equations
from sinsref.arithmetic import BallArithmetic
from sinsref.quaternion import product, rotate
from sinsref.series import SeriesArithmetic

STATE = ("210", "-40", "330", "7000", "0.7", "1.1")
FORCE = ("3", "-2", "5")
KAPPA, GYROS = ("0.5", "-0.1", "0.7", "0.5"), ("0.01", "-0.02", "0.03")


def printed_rates(ar, spherical):
    """The ideal equations and the rates of the frame, written out."""
    v_n, v_h, v_e, H, phi, _ = (ar.number(x) for x in STATE)
    a_n, a_h, a_e = (ar.number(x) for x in FORCE)
    u, a, g0 = ar.number(U), ar.number(A), ar.number(GRAVITY)
    e2, delta = (ar.number(x) * int(not spherical) for x in ("0.006692", "5.317e-3"))
    s, c = ar.sin_cos(phi)
    alpha = (1 - e2 * s * s).sqrt()
    r1, r2 = (a + H) / alpha, (a + H) * (1 - e2) / alpha**3
    g = g0 * a**2 * (1 + delta * s * s) / (a + H) ** 2
    w_n, w_h, w_e = u * c + v_e / r1, u * s + v_e * (s / c) / r1, -v_n / r2
    rates = [
        a_n + w_e * v_h - (u * s + w_h) * v_e,
        a_h - w_e * v_n + (u * c + w_n) * v_e - g,
        a_e + (u * s + w_h) * v_n - (u * c + w_n) * v_h,
        v_h / alpha,
        v_n / r2,
        v_e / (r1 * c),
    ]
    return rates, [w_n, w_h, w_e]


def error_equations_hold(module):
    with BallArithmetic(BITS) as ar:
        state, force = [ar.number(x) for x in STATE], [ar.number(x) for x in FORCE]
        for spherical in (True, False):
            earth = module.Earth.krasovsky(ar, spherical=spherical)
            rates, frame = printed_rates(ar, spherical)
            if not all(map(agree_alone, module.ideal_rates(ar, earth, state, force), rates)):
                return False
            kappa, gyros = ([ar.number(x) for x in given] for given in (KAPPA, GYROS))
            left = product(kappa, [0, *gyros])
            right = product([0, *frame], kappa)
            expected = [(x - y) / 2 for x, y in zip(left, right, strict=True)]
            if not agree(module.attitude_rate(ar, earth, state, kappa, gyros), expected):
                return False
        required = module.required_force(ar, earth, state, force)
        produced = module.ideal_rates(ar, earth, state, required)[:3]
        if not agree(produced, force):
            return False
        (s, c), (sl, cl) = ar.sin_cos(state[4]), ar.sin_cos(state[5])
        attitude = module.geographic_attitude(ar, state[4], state[5])
        axes = ((c, -s * cl, -s * sl), (s, c * cl, c * sl), (arb(0), -sl, cl))
        for i, axis in enumerate(axes):
            unit = [arb(int(i == j)) for j in range(3)]
            if not near(rotate(attitude, unit), axis) or not near(module.geographic_force(attitude, unit), axis):
                return False
        return jacobian_holds(ar, module, earth, state, force)


def jacobian_holds(ar, module, earth, state, force):
    dual = SeriesArithmetic(ar)
    constant = module.Earth(*(dual.constant(getattr(earth, name)) for name in module.Earth.__dataclass_fields__))
    matrix = module.error_matrix(ar, earth, state, force)
    if [len(row) for row in matrix] != [6] * 6:
        return False
    true, given = [dual.constant(x) for x in state], [dual.constant(x) for x in force]
    for j in range(6):
        displaced = [dual.variable(x, int(i == j)) for i, x in enumerate(state)]
        resolved = module.force_at_displaced_position(dual, true, displaced, given)
        for row, rate in zip(matrix, module.ideal_rates(dual, constant, displaced, resolved), strict=True):
            # Elements are 1e-16 to 10; those that are zero must be so to 1e-40.
            if not abs(row[j] - rate[1]) < 1e-35 * abs(rate[1]) + 1e-40:
                return False
    return True


#: Changes that leave every value right, by function and statement, and why.
EQUIVALENT = {"attitude_rate: at, zero =": "the two scalar parts cancel: kappa o 1 - 1 o kappa"}


def test_every_planted_defect_is_seen():
    assert error_equations_hold(error_equations)
    unseen, planted = survivors(error_equations, error_equations_hold)
    assert [place for place in unseen if not place.startswith(tuple(EQUIVALENT))] == []
    assert planted > 25
