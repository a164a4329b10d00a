"""Defects planted one at a time in the truth of the errors along the equator must be seen.

Every number of the modules is changed in its turn, every + becomes - and every - becomes +, every minus sign is
dropped. What judges a module shares nothing with it: the exponential of the equations' matrix, and the eigenvalue
equation.
"""

from functools import cache

import pytest
from flint import arb, arb_mat

import equator_truth
from balls import BITS, agree, agree_alone
from equator_truth import NO_MISALIGNMENT, RESONANCE, V_MAX, A, U, leading_block
from mutants import load, source, survivors
from sinsref import equator, equator_forced, equator_modes
from sinsref.arithmetic import BallArithmetic
from sinsref.exact import ExactNumber
from sinsref.pi_monomials import PiMonomialArithmetic

INITIAL = ("0.01", "-0.02", "0.03", "1", "1e-7", "-2e-7")
TILT = (("1e-6", "-2e-6", "3e-6"), ("5e-6", "4e-6", "-7e-6"), ("2e-6", "6e-6", "-1e-6"))
LONGITUDE = "0.7"


def exact_state(v_east, height, time, tilted):
    return equator_truth.state(v_east, height, time, INITIAL, TILT if tilted else NO_MISALIGNMENT, LONGITUDE)


@cache
def companion_exponential(p, q, time):
    with BallArithmetic(equator_truth.BITS):
        companion = arb_mat([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [q, 0, -p, 0]])
        exponential = (companion * time).exp()
        return [exponential[0, k] for k in range(4)]


class Hasty(BallArithmetic):
    """Balls that let a series stop early: its bound of the remainder must then hold what is left."""

    @property
    def resolution(self):
        return 1.0


def tilt(ar, module):
    return module.Misalignment([[ar.number(x) for x in row] for row in TILT], ar.number(LONGITUDE))


def state_of(ar, module, forced, v_east, height, time, tilted):
    model = module.EquatorModel.at(ar, ExactNumber(v_east), ExactNumber(height))
    start = [ar.number(x) for x in INITIAL]
    return forced.solution(ar, model, start, tilt(ar, forced) if tilted else None, ar.number(time))


CASES = (("600", "10000", "1800"), ("8000", "0", "900"), (V_MAX, "0", "900"), ("7700", "1000", "900"))


def equator_holds(module):
    forced = load(source(equator_forced), equator_forced, {"sinsref.equator": module})
    with BallArithmetic(BITS) as ar:
        for case in CASES:
            generator = equator_truth.generator(*case[:2])
            matrix = equator_truth.exponential(*case)
            expected_rows = [*leading_block(matrix), *leading_block(generator)]
            model = module.EquatorModel.at(ar, *map(ExactNumber, case[:2]))
            k = equator_truth.constants(*case[:2])
            own = module.transition(ar, model, ar.number(case[2]))
            for row, expected in zip([*own, *model.matrix(ar)], expected_rows, strict=True):
                if not agree(row, expected):
                    return False
            if not agree([model.frame_rate, model.schuler_rate**2], [k.turn, k.g / k.R]):
                return False
            initial = [ar.number(x) for x in INITIAL]
            plain = module.homogeneous(ar, model, initial, ar.number(case[2]))
            if not agree(plain, exact_state(*case, tilted=False)):
                return False
            if not agree(state_of(ar, module, forced, *case, tilted=True), exact_state(*case, tilted=True)):
                return False
        for p, q in (
            (2e-6, 2e-12),
            (-2e-6, 1e-12),
            (2e-6, -4e-13),
            (2e-6, -4e-12),
            (-2e-6, -4e-12),
            (0.0, 0.0),
            DOUBLE_ROOT,
        ):
            for time in (1e-3, 900):
                expected = companion_exponential(p, q, time)
                for function in (module.coupled_functions, module.series_functions):
                    if not all(map(agree_alone, function(ar, arb(p), arb(q), arb(time)), expected)):
                        return False
        guard = module.guard_bits(ar, model, ar.number(7200))
    with Hasty(BITS) as ar:
        for p, q, time in ((2e-6, 2e-12, 900), (-2e-6, -4e-12, 900), (0.0, -4e-12, 2000), (2e-6, 1e-13, 40)):
            expected = companion_exponential(p, q, time)
            found = module.series_functions(ar, arb(p), arb(q), arb(time))
            if not all(x.overlaps(y) and x.rad() < 1e-4 * abs(y) for x, y in zip(found, expected, strict=True)):
                return False
        case = ("600", "10000", "1800")
        found, expected = state_of(ar, module, forced, *case, tilted=True), exact_state(*case, tilted=True)
        # The bound holds what is left and is not idle: with one power of the rate less it would be 1e5 times larger.
        if not all(x.overlaps(y) and x.rad() < 1e-3 * abs(y) for x, y in zip(found, expected, strict=True)):
            return False
    # The series loses exp(2 sqrt(bound) t): the formula of the docstring.
    with BallArithmetic(64) as ar:
        bound = abs(model.p) + abs(model.q).sqrt()
        return guard == int((bound.sqrt() * 2 * 7200 / arb(2).log()).ceil().unique_fmpz()) + 8


DOUBLE_ROOT = (2.0**-19, -(2.0**-40))  # p^2 + 4 q = 0, exactly


def forced_holds(module):
    with BallArithmetic(BITS) as ar:
        for case in (*CASES, (RESONANCE, "0", "900"), ("3644.262041", "0", "1800"), ("-8380", "0", "900")):
            for tilted in (True, False):
                expected = exact_state(*case, tilted)
                if not agree(state_of(ar, equator, module, *case, tilted), expected):
                    return False
                # Velocities north and latitude are small beside the height: by themselves.
                found = state_of(ar, equator, module, *case, tilted)
                if not all(agree_alone(found[i], expected[i]) for i in range(6)):
                    return False
        k = equator_truth.constants("600", "10000")
        model = equator.EquatorModel.at(ar, ExactNumber("600"), ExactNumber("10000"))
        sine, cosine = ar.sin_cos(ar.number(LONGITUDE) + k.turn * 50)
        (_, l12, l13), (_, l22, l23), (_, l32, l33) = ([ar.number(x) for x in row] for row in TILT)
        expected = [
            l12 * cosine + l13 * sine,
            l22 * cosine**2 + (l32 + l23) * cosine * sine + l33 * sine**2,
            l32 * cosine**2 + (l33 - l22) * cosine * sine - l23 * sine**2,
        ]
        found = tilt(ar, module).force(ar, model, ar.number(50))
        return len(found) == 6 and agree(found, [*(k.force * x for x in expected), arb(0), arb(0), arb(0)])


# Modes: the eigenvalue equation, and the state as the sum of the modes.


def refused(call):
    try:
        call()
    except ValueError as error:  # a mutant raises a class of its own
        return "modes at this speed" in str(error) or "multiple of pi/2" in str(error)
    return False


def modes_hold(module):
    with BallArithmetic(BITS) as ar:
        time = ar.number(1800)
        for v_east in ("600", "-3000"):
            generator = equator_truth.generator(v_east, "10000")
            state = exact_state(v_east, "10000", "1800", tilted=False)
            model = equator.EquatorModel.at(ar, ExactNumber(v_east), ExactNumber("10000"))
            m = module.modes(ar, model)
            matrix = arb_mat([[generator[i, j] for j in (1, 2, 3, 5)] for i in (1, 2, 3, 5)])
            vectors = [(s * m.beta3, [s * m.beta3, m.alpha3_growing, 1, s * m.alpha6]) for s in (1, -1)]
            if not all(agree((matrix * arb_mat(4, 1, x)).entries(), [rate * y for y in x]) for rate, x in vectors):
                return False
            real, imaginary = [0, m.alpha3_swinging, 1, 0], [m.mu, 0, 0, m.nu]
            if not agree((matrix * arb_mat(4, 1, real)).entries(), [-m.mu * x for x in imaginary]):
                return False
            if not agree((matrix * arb_mat(4, 1, imaginary)).entries(), [m.mu * x for x in real]):
                return False
            if not agree([m.rho1, m.rho2], [m.beta3**2, -(m.mu**2)]) or not agree([m.omega], [model.schuler_rate]):
                return False
            initial = [ar.number(x) for x in INITIAL]
            _, _, c3, c4, *_ = module.constants_of_integration(ar, model, m, initial)
            up, down = (m.beta3 * time).exp() * c3, (-m.beta3 * time).exp() * c4
            parts = module.oscillations(ar, model, m, initial)
            rates = (m.omega, m.mu, m.mu, m.mu, m.omega, m.mu)
            steady = (0, m.beta3 * (up - down), m.alpha3_growing * (up + down), up + down, 0, m.alpha6 * (up - down))
            for part, rate, rest, x in zip(parts, rates, steady, state, strict=True):
                sine, cosine = ar.sin_cos(rate * time)
                if not agree_alone(part.amplitude * (sine * part.cosine + cosine * part.sine) + rest, x):
                    return False
                if not agree([part.sine**2 + part.cosine**2], [arb(1)]):
                    return False
            if not refused(lambda part=parts[1]: part.signed(ar)):
                return False
        for height in ("0", "1000000"):
            k = equator_truth.constants("0", height)
            u = ar.number(U)
            speeds = module.vanishing_force_speeds(ar, ExactNumber(height))
            if list(map(ar.sign, speeds)) != [-1, 1]:
                return False
            for v in speeds:
                residual = k.g - 2 * u * v - v * v / k.R
                if not residual.contains(0) or residual.rad() > 1e-30:
                    return False
    with PiMonomialArithmetic(BITS) as ar:
        model = equator.EquatorModel.at(ar, ExactNumber("600"), ExactNumber("0"))
        m = module.modes(ar, model)
        expected = {  # which component oscillates, with which phase, for one initial error at a time
            4: ["0", "", "", "", "pi/2", ""], 0: ["pi/2", "", "", "", "0", ""],
        }  # fmt: skip
        for place in (4, 0):
            start = [ar.number(int(i == place)) for i in range(6)]
            parts = module.oscillations(ar, model, m, start)
            if [part.signed(ar)[1] if part else "" for part in parts] != expected[place]:
                return False
            signs = [ar.sign(part.signed(ar)[0]) for part in parts if part]
            if signs != ([-1, 1] if place == 4 else [1, 1]):
                return False
        # Both boundaries of the domain, and speeds of two oscillations.
        for v_east in (f"-{U}*{A}", "7700", "-8380", V_MAX):
            wrong = equator.EquatorModel.at(ar, ExactNumber(v_east), ExactNumber("0"))
            if not refused(lambda wrong=wrong: module.modes(ar, wrong)):
                return False
    return True


#: Changes that leave every value right, by function and statement, and why.
EQUIVALENT = {
    # A threshold between two forms that are both valid there; signs are -1, 0 and 1, and never 0 there.
    "coupled_functions: scale =": "which form is used, not its value",
    "coupled_functions: apart =": "which form is used, not its value",
    "coupled_functions: ar.sign(abs(discriminant) - apart) > 0: 0 ->": "the series instead: valid everywhere",
    "coupled_functions: ar.sign(discriminant) < 0:": "a sign below 1 is -1: it is not 0 there",
    "coupled_functions: ar.sign(abs(q) - apart) > 0: 0 ->": "the series instead: valid everywhere",
    # More terms, or fewer with a remainder that the bound still holds.
    "series_functions: size, n = (1.0, 0): 1.0 ->": "when the series stops",
    "series_functions: enough =": "when the series stops",
    "series_functions: n < 3 or size > enough or 4 * reach > (2 * n) ** 2:": "when the series stops",
    "series_functions: size *=": "when the series stops",
    "series_functions: size > 1e+300:": "when the series gives up",
    "series_functions: base = ar.number(max(bound, 1e-300)): 1e-300 ->": "stands for zero",
}

CHECKS = {equator: equator_holds, equator_forced: forced_holds, equator_modes: modes_hold}


@pytest.mark.parametrize("module", CHECKS, ids=lambda module: module.__name__)
def test_every_planted_defect_is_seen(module):
    holds = CHECKS[module]
    assert holds(module)
    unseen, planted = survivors(module, holds)
    assert [place for place in unseen if not place.startswith(tuple(EQUIVALENT))] == []
    assert planted > 25
