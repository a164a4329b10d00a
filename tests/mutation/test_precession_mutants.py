"""Defects planted one at a time in the truth of regular precession must be seen.

Every number of the modules is changed in its turn, every + becomes - and every - becomes +, every minus sign is
dropped. What judges the module is the integration of the differential equations.
"""

from functools import cache
from itertools import pairwise

from flint import arb

from balls import BITS, near
from mutants import survivors
from sinsref import precession
from sinsref.arithmetic import BallArithmetic
from sinsref.exact import ExactNumber
from sinsref.quaternion import cross, product, rotate
from sinsref.taylor import integrate


def motion_of(module, attitude, velocity=("20", "35", "40")):
    exact = [ExactNumber(x) for x in ("2", "1/3", "0.4", "3", "-5")]
    given = None if attitude is None else tuple(map(ExactNumber, attitude))
    return module.DualPrecession(*exact, given, tuple(map(ExactNumber, velocity)))


def rate_and_force(ar, t):
    """Equations (4.1) and (4.3) with the parameters of `motion_of`."""
    nu, eps, th, nu0, th0 = (ar.number(x) for x in ("2", "1/3", "0.4", "3", "-5"))
    (s, c), (sn, cn) = ar.sin_cos(th), ar.sin_cos(nu * t)
    swing, drift = eps * (nu * th0 * c + nu0 * s), eps * nu * nu0 * s * t
    return (
        [eps * nu * s * sn, eps * nu * s * cn, nu * (eps * c + 1)],
        [swing * sn + drift * cn, swing * cn - drift * sn, nu0 * (eps * c + 1) - eps * nu * th0 * s],
    )


ATTITUDES = (None, ("0", "0", "1", "0"), ("1", "0", "0", "0"), ("0.5", "0.5", "-0.1", "0.7"))
START, END = "1/4", "3/4"


@cache
def integrated_precession(attitude):
    """State at START and END: attitude, inertial and body velocity, integrals of rate and force since START."""

    def field(ar, t, y):
        rate, force = rate_and_force(ar, t)
        turn = product(y[:4], [ar.number(0), *rate])
        body = [x - z for x, z in zip(force, cross(rate, y[7:10]), strict=True)]
        return [*(x / 2 for x in turn), *rotate(y[:4], force), *body, *rate, *force]

    with BallArithmetic(2 * BITS) as ar:
        sine, cosine = ar.sin_cos(ar.number("0.2"))
        given = [cosine, sine, 0, 0] if attitude is None else [ar.number(x) for x in attitude]
        norm = sum((x * x for x in given), arb(0)).sqrt()
        unit = [x / norm for x in given]
        velocity = [ar.number(x) for x in ("20", "35", "40")]
        inverse = [unit[0], *(-x for x in unit[1:])]
        state = [*unit, *velocity, *rotate(inverse, velocity)]
        times, states = [ar.number(x) for x in ("0", START, END)], []
        for before, after in pairwise(times):
            state = integrate(ar, field, [*state[:10], *[arb(0)] * 6], before, after, steps=2, order=45)
            states.append(state)
        return states


def precession_holds(module):
    with BallArithmetic(BITS) as ar:
        for attitude in ATTITUDES:
            motion = motion_of(module, attitude)
            for time, state in zip((START, END), integrated_precession(attitude), strict=True):
                found = module.solution(ar, motion, ar.number(time))
                parts = (state[:4], state[4:7], state[7:10])
                if not all(map(near, found, parts)):
                    return False
        start, end = ar.number(START), ar.number(END)
        before, after = integrated_precession(ATTITUDES[-1])
        integrals = after[10:13], after[13:16]
        back = [before[0], *(-x for x in before[1:4])]
        gain = [x - y for x, y in zip(after[4:7], before[4:7], strict=True)]
        forth = product(back, after[:4])
        resolved = rotate(back, gain), rotate([after[0], *(-x for x in after[1:4])], gain)
        means = [[x / (end - start) for x in integral] for integral in integrals]
        return all(
            all(map(near, found, expected))
            for found, expected in (
                (module.increments(ar, motion, end, end - start), integrals),
                (module.mean_rates(ar, motion, end, end - start), means),
                (module.accumulated(ar, motion, start), (before[10:13], before[13:16])),
                (module.resolved_increments(ar, motion, end, end - start), resolved),
                ((module.body_rotation(ar, motion.principal(ar), end, end - start),), (forth,)),
                (module.angular_rate_and_specific_force(ar, motion, end), rate_and_force(ar, end)),
            )
        )


def test_every_planted_defect_is_seen():
    assert precession_holds(precession)
    unseen, planted = survivors(precession, precession_holds)
    assert unseen == []
    assert planted > 25
