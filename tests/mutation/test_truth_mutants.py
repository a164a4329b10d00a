"""Defects planted one at a time in the formulas of truth must be seen.

Every number of the modules is changed in its turn, every + becomes - and every - becomes +, every minus sign is
dropped. What judges a module shares nothing with it: the exponential of the equations' matrix, the integration of
the differential equations, the ideal equations as the paper prints them, the eigenvalue equation.
"""

import ast
import inspect
import sys
from functools import cache
from itertools import pairwise
from types import ModuleType

import pytest
from flint import arb, arb_mat

from sinsref import equator, equator_forced, equator_modes, error_equations, precession
from sinsref.arithmetic import BallArithmetic
from sinsref.exact import ExactNumber
from sinsref.pi_monomials import PiMonomialArithmetic
from sinsref.quaternion import cross, product, rotate
from sinsref.series import SeriesArithmetic
from sinsref.taylor import integrate

BITS = 160
U, A, GRAVITY = "7.29e-5", "6378245", "9.78049"
V_MAX = f"{A}*(sqrt({U}*{U} + {GRAVITY}/{A}) - {U})"
RESONANCE = f"{A}*(sqrt({GRAVITY}/{A}) - {U})"
INITIAL = ("0.01", "-0.02", "0.03", "1", "1e-7", "-2e-7")
TILT = (("1e-6", "-2e-6", "3e-6"), ("5e-6", "4e-6", "-7e-6"), ("2e-6", "6e-6", "-1e-6"))
LONGITUDE = "0.7"


def agree(found, expected, tolerance=1e-30):
    """Whether balls overlap one by one and are close relative to the largest."""
    scale = max(float(abs(x).abs_upper()) for x in expected)
    pairs = list(zip(found, expected, strict=True))
    return all(arb(x).overlaps(y) and abs(arb(x) - y) < tolerance * scale for x, y in pairs)


# The equator: the exponential of the eleven homogeneous equations, written out.


@cache
def constants(v_east, height):
    with BallArithmetic(2 * BITS) as ar:
        u, a, v = ar.number(U), ar.number(A), ar.number(v_east)
        R = a + ar.number(height)
        g = ar.number(GRAVITY) * a * a / (R * R)
        return {
            "R": R, "g": g, "v": v, "turn": u + v / R, "coriolis": 2 * u + v / R,
            "force": g - 2 * u * v - v * v / R, "a24": 2 * g / R - v * v / (R * R),
        }  # fmt: skip


@cache
def equator_exponential(v_east, height, time, tilted):
    """P(t), 6 x 6, and X(t), from the matrix of X, 1, cos th, sin th, cos 2 th, sin 2 th."""
    k = constants(v_east, height)
    with BallArithmetic(2 * BITS) as ar:
        R, force, turn = k["R"], k["force"], k["turn"]
        l = [[ar.number(x) * int(tilted) for x in row] for row in TILT]
        entries = {
            (0, 4): -k["g"], (1, 2): 2 * turn, (1, 3): k["a24"], (2, 1): -k["coriolis"], (2, 5): -force,
            (3, 1): 1, (4, 0): 1 / R, (5, 2): 1 / R, (5, 3): -k["v"] / (R * R),
            (0, 7): force * l[0][1], (0, 8): force * l[0][2],
            (1, 6): force * (l[1][1] + l[2][2]) / 2, (1, 9): force * (l[1][1] - l[2][2]) / 2,
            (1, 10): force * (l[2][1] + l[1][2]) / 2, (2, 6): force * (l[2][1] - l[1][2]) / 2,
            (2, 9): force * (l[2][1] + l[1][2]) / 2, (2, 10): force * (l[2][2] - l[1][1]) / 2,
            (7, 8): -turn, (8, 7): turn, (9, 10): -2 * turn, (10, 9): 2 * turn,
        }  # fmt: skip
        generator = arb_mat(11, 11, [entries.get((i, j), 0) for i in range(11) for j in range(11)])
        th = ar.number(LONGITUDE)
        start = [*(ar.number(x) for x in INITIAL), 1, th.cos(), th.sin(), (2 * th).cos(), (2 * th).sin()]
        exponential = (generator * ar.number(time)).exp()
        state = exponential * arb_mat(11, 1, start)
        matrix = [[exponential[i, j] for j in range(6)] for i in range(6)]
        generator_6 = [[arb(entries.get((i, j), 0)) for j in range(6)] for i in range(6)]
        return generator_6, matrix, [state[i, 0] for i in range(6)]


@cache
def companion_exponential(p, q, time):
    with BallArithmetic(2 * BITS):
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
            generator, matrix, state = equator_exponential(*case, tilted=True)
            model = module.EquatorModel.at(ar, *map(ExactNumber, case[:2]))
            k = constants(*case[:2])
            own = module.transition(ar, model, ar.number(case[2]))
            for row, expected in zip([*own, *model.matrix(ar)], [*matrix, *generator], strict=True):
                if not agree(row, expected):
                    return False
            if not agree([model.frame_rate, model.schuler_rate**2], [k["turn"], k["g"] / k["R"]]):
                return False
            initial = [ar.number(x) for x in INITIAL]
            plain = module.homogeneous(ar, model, initial, ar.number(case[2]))
            if not agree(plain, equator_exponential(*case, tilted=False)[2]):
                return False
            if not agree(state_of(ar, module, forced, *case, tilted=True), state):
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
        found, expected = state_of(ar, module, forced, *case, tilted=True), equator_exponential(*case, tilted=True)[2]
        # The bound holds what is left and is not idle: with one power of the rate less it would be 1e5 times larger.
        if not all(x.overlaps(y) and x.rad() < 1e-3 * abs(y) for x, y in zip(found, expected, strict=True)):
            return False
    # The series loses exp(2 sqrt(bound) t): the formula of the docstring.
    with BallArithmetic(64) as ar:
        bound = abs(model.p) + abs(model.q).sqrt()
        return guard == int((bound.sqrt() * 2 * 7200 / arb(2).log()).ceil().unique_fmpz()) + 8


DOUBLE_ROOT = (2.0**-19, -(2.0**-40))  # p^2 + 4 q = 0, exactly


def agree_alone(x, y):
    return x.overlaps(y) and abs(x - y) < 1e-30 * abs(y)


def forced_holds(module):
    with BallArithmetic(BITS) as ar:
        for case in (*CASES, (RESONANCE, "0", "900"), ("3644.262041", "0", "1800"), ("-8380", "0", "900")):
            for tilted in (True, False):
                expected = equator_exponential(*case, tilted)[2]
                if not agree(state_of(ar, equator, module, *case, tilted), expected):
                    return False
                # Velocities north and latitude are small beside the height: by themselves.
                found = state_of(ar, equator, module, *case, tilted)
                if not all(agree_alone(found[i], expected[i]) for i in range(6)):
                    return False
        k = constants("600", "10000")
        model = equator.EquatorModel.at(ar, ExactNumber("600"), ExactNumber("10000"))
        sine, cosine = ar.sin_cos(ar.number(LONGITUDE) + k["turn"] * 50)
        (_, l12, l13), (_, l22, l23), (_, l32, l33) = ([ar.number(x) for x in row] for row in TILT)
        expected = [
            l12 * cosine + l13 * sine,
            l22 * cosine**2 + (l32 + l23) * cosine * sine + l33 * sine**2,
            l32 * cosine**2 + (l33 - l22) * cosine * sine - l23 * sine**2,
        ]
        found = tilt(ar, module).force(ar, model, ar.number(50))
        return len(found) == 6 and agree(found, [*(k["force"] * x for x in expected), arb(0), arb(0), arb(0)])


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
            generator, _, state = equator_exponential(v_east, "10000", "1800", tilted=False)
            model = equator.EquatorModel.at(ar, ExactNumber(v_east), ExactNumber("10000"))
            m = module.modes(ar, model)
            matrix = arb_mat([[generator[i][j] for j in (1, 2, 3, 5)] for i in (1, 2, 3, 5)])
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
            k = constants("0", height)
            u = ar.number(U)
            speeds = module.vanishing_force_speeds(ar, ExactNumber(height))
            if list(map(ar.sign, speeds)) != [-1, 1]:
                return False
            for v in speeds:
                residual = k["g"] - 2 * u * v - v * v / k["R"]
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


# Regular precession: the differential equations, integrated.


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
        interval = ar.number(END) - ar.number(START)
        if not all(map(near, module.increments(ar, motion, ar.number(END), interval), (state[10:13], state[13:16]))):
            return False
        at_end = module.angular_rate_and_specific_force(ar, motion, ar.number(END))
        return all(map(near, at_end, rate_and_force(ar, ar.number(END))))


def near(found, expected):
    """As far as the Taylor integration reaches: 0.9^45/45! is 1e-58, and balls of 160 bits."""
    return all(abs(x - y) < 1e-35 * (1 + abs(y)) for x, y in zip(found, expected, strict=True))


# The error equations: the ideal equations as printed, and their Jacobian.

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


# Planting.


class Planter(ast.NodeTransformer):
    """Plants the defect number `target`, and says where; counts the places when `target` is None."""

    def __init__(self, target=None):
        self.target, self.count, self.place, self.function, self.statement = target, 0, "", "", None

    def plant(self, node, replacement):
        self.count += 1
        if self.count - 1 != self.target:
            return node
        self.place = (
            f"{self.function}: {ast.unparse(self.statement)}: {ast.unparse(node)} -> {ast.unparse(replacement)}"
        )
        return ast.copy_location(replacement, node)

    def visit(self, node):
        """Remember the statement, or the head of the compound statement, that a defect is in."""
        if isinstance(node, ast.stmt):
            self.statement = getattr(node, "test", node)
        return super().visit(node)

    def visit_Constant(self, node):
        if type(node.value) is int:
            return self.plant(node, ast.Constant(node.value + 1))
        if type(node.value) is float:
            return self.plant(node, ast.Constant(node.value * 1.5))
        return node

    def visit_BinOp(self, node):
        self.generic_visit(node)
        for found, other in ((ast.Add, ast.Sub), (ast.Sub, ast.Add)):
            if isinstance(node.op, found):
                return self.plant(node, ast.BinOp(node.left, other(), node.right))
        return node

    def visit_UnaryOp(self, node):
        self.generic_visit(node)
        return self.plant(node, node.operand) if isinstance(node.op, ast.USub) else node

    def visit_FunctionDef(self, node):
        self.function, outer = node.name, self.function
        node.body = [self.visit(statement) for statement in node.body]
        self.function = outer
        return node

    def visit_AnnAssign(self, node):
        return node  # fields of dataclasses


def source(module):
    return ast.parse(inspect.getsource(module))


def load(tree, original, replaced=None):
    """Run a changed module under a name of its own; its imports see the `replaced` modules."""
    name = f"mutant_of_{original.__name__.rpartition('.')[2]}"
    module = ModuleType(name)
    names = {name: module, **(replaced or {})}
    kept = {key: sys.modules.get(key) for key in names}
    sys.modules.update(names)
    try:
        exec(compile(ast.fix_missing_locations(tree), name, "exec"), module.__dict__)
    finally:
        for key, value in kept.items():
            if value is None:
                del sys.modules[key]
            else:
                sys.modules[key] = value
    return module


def survivors(original, holds):
    counter = Planter()
    counter.visit(source(original))
    unseen = []
    for target in range(counter.count):
        planter = Planter(target)
        mutant = planter.visit(source(original))
        try:
            seen = not holds(load(mutant, original))
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
            seen = True
        if not seen:
            unseen.append(planter.place)
    return unseen, counter.count


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
    "attitude_rate: at, zero =": "the two scalar parts cancel: kappa o 1 - 1 o kappa",
}

CHECKS = {
    precession: precession_holds,
    equator: equator_holds,
    equator_forced: forced_holds,
    equator_modes: modes_hold,
    error_equations: error_equations_hold,
}


@pytest.mark.parametrize("module", CHECKS, ids=lambda module: module.__name__)
def test_every_planted_defect_is_seen(module):
    holds = CHECKS[module]
    assert holds(module)
    unseen, planted = survivors(module, holds)
    assert planted > 25
    assert [place for place in unseen if not place.startswith(tuple(EQUIVALENT))] == []
