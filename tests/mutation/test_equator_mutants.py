"""Defects planted one at a time in the equator subjects must be seen by a comparison with truth.

Every number, every coefficient of a table, every sum, difference and product of the modules is changed in its
turn.  Truth is the exponential of the equations in ball arithmetic, which shares nothing with the formulas.
"""

import ast
import inspect
import sys
from fractions import Fraction
from functools import cache
from types import ModuleType

import flint
import numpy as np
import pytest

from sinsbench.subjects import equator_formulas, equator_robust, ode45
from sinsbench.subjects.equator_model import EquatorMotion, NotApplicableError

INITIAL = (0.01, -0.02, 0.015, 1.0, 3e-7, 1.57e-7)
NO_FORCING = ((0.0,) * 3,) * 3
LAMBDA = ((1e-5, 7e-5, -5e-5), (2e-5, 3e-5, 4e-5), (-3e-5, 6e-5, -2e-5))
LONGITUDE = 0.7


@cache
def truth(v_east, height, times, initial, misalignment):
    """The state at `times` by the exponential of the eleven homogeneous equations, rounded from 200 bits."""
    with flint.ctx.workprec(200):
        arb = flint.arb
        v, a, u = arb(v_east), arb(6378245), arb("7.29e-5")
        R, l = a + height, [[arb(x) for x in row] for row in misalignment]
        g, transport = arb("9.78049") * a**2 / R**2, v / R
        rate, a_H = u + transport, g - (2 * u + transport) * v
        entries = {
            (0, 4): -g,
            (1, 2): 2 * rate,
            (1, 3): 2 * g / R - transport**2,
            (2, 1): -2 * u - transport,
            (2, 5): -a_H,
            (3, 1): 1,
            (4, 0): 1 / R,
            (5, 2): 1 / R,
            (5, 3): -transport / R,
            (0, 7): a_H * l[0][1],
            (0, 8): a_H * l[0][2],
            (1, 6): a_H * (l[1][1] + l[2][2]) / 2,
            (1, 9): a_H * (l[1][1] - l[2][2]) / 2,
            (1, 10): a_H * (l[2][1] + l[1][2]) / 2,
            (2, 6): a_H * (l[2][1] - l[1][2]) / 2,
            (2, 9): a_H * (l[2][1] + l[1][2]) / 2,
            (2, 10): a_H * (l[2][2] - l[1][1]) / 2,
            (7, 8): -rate,
            (8, 7): rate,
            (9, 10): -2 * rate,
            (10, 9): 2 * rate,
        }
        generator = flint.arb_mat(11, 11, [entries.get((i, j), 0) for i in range(11) for j in range(11)])
        th = arb(LONGITUDE)
        start = [*map(arb, initial), 1, th.cos(), th.sin(), (2 * th).cos(), (2 * th).sin()]
        column = flint.arb_mat(11, 1, start)
        states = [(generator * arb(time)).exp() * column for time in times]
        return np.array([[float(state[i, 0]) for i in range(6)] for state in states])


def agrees(solver, v_east, height, times, tolerance, initial=INITIAL, misalignment=NO_FORCING):
    forced = {} if misalignment is NO_FORCING else {"misalignment": misalignment}
    actual = solver(times, v_east, height, initial, inertial_longitude=LONGITUDE, **forced)
    expected = truth(v_east, height, times, initial, misalignment)
    # Component by component, each against its own largest value of the run.
    return bool((np.abs(actual - expected) <= tolerance * np.abs(expected).max(axis=0)).all())


def refuses(solver, v_east, sentence, misalignment=None):
    try:
        solver((1.0,), v_east, 0.0, INITIAL, misalignment)
    except NotApplicableError as error:
        return sentence in str(error)
    return False


STATIONARY = -7.29e-5 * 6378245.0
V_MAX = 7446.951262516
EARLY, LATE = (0.5, 20.0, 75.0, 80.0, 85.0, 500.0), (1500.0, 3600.0, 7200.0)
PAPER = (0.01, 0.01, 0.01, 1.0, 1.57e-7, 1.57e-7)  # the initial errors (24)
RIGHT_HALF_PLANE = (0.01, -0.01, 0.01, -1.0, -1e-7, 1e-7)  # every phase within pi/2 of zero
NORTH = (0.01, 0.0, 0.0, 0.0, 0.0, 0.0)


def formulas_hold(module):
    # 1e-9 is far above the rounding of the formulas at these motions and far below any planted defect.
    for solver in (module.corrected, module.general_solution, module.amplitude_phase):
        for misalignment in (NO_FORCING, LAMBDA):
            if not agrees(solver, 600.0, 1e4, LATE, 1e-9, misalignment=misalignment):
                return False
    for initial in (RIGHT_HALF_PLANE, NORTH):
        if not agrees(module.amplitude_phase_printed, 10.0, 0.0, LATE, 1e-9, initial):
            return False
    # The opposite errors have the same tangents: the principal value leaves dv_N and dphi as they were.
    opposite = [-error for error in RIGHT_HALF_PLANE]
    turned = module.amplitude_phase_printed(LATE, 10.0, 0.0, opposite)[:, [0, 4]]
    exact = truth(10.0, 0.0, LATE, RIGHT_HALF_PLANE, NO_FORCING)[:, [0, 4]]
    if not np.allclose(turned, exact, rtol=1e-9, atol=0):
        return False
    # The printed matrix lacks half of the oscillation of dv_H, and nothing else.
    modes = module.modal_constants(600.0, 1e4)
    *_, C5, C6 = module.integration_constants(modes, INITIAL)
    angle = modes.mu * np.array(LATE)
    missing = modes.mu * (C5 * np.sin(angle) - C6 * np.cos(angle)) / 2
    difference = module.printed(LATE, 600.0, 1e4, INITIAL) - truth(600.0, 1e4, LATE, INITIAL, NO_FORCING)
    return (
        np.allclose(difference[:, 1], missing, rtol=1e-6, atol=0)
        and refuses(module.corrected, STATIONARY, "omega_N")
        and refuses(module.corrected, weightless_speed(), "divide by a_H")
        and refuses(module.corrected, resonant_speed(), "resonance", LAMBDA)
        and refuses(module.corrected, 8000.0, "complex")
        and refuses(module.corrected, 7700.0, "not real")
        and refuses(module.printed, 600.0, "prints no response", LAMBDA)
    )


@cache
def exact_zero(near, quantity):
    """The speed nearest to `near`, at H = 0, at which `quantity` of the motion is zero in float64."""
    speeds = near + np.arange(-400, 401) * np.spacing(near)
    zeros = [v for v in speeds if quantity(EquatorMotion.at(v, 0.0)) == 0]
    return float(min(zeros, key=lambda v: abs(v - near)))


def weightless(motion):
    return motion.specific_force


def resonance(motion):
    return motion.schuler_rate**2 - motion.inertial_rate**2


def weightless_speed():
    rate = np.sqrt(7.29e-5**2 + 9.78049 / 6378245.0)
    return exact_zero(6378245.0 * (rate - 7.29e-5), weightless)


def resonant_speed():
    return exact_zero(6378245.0 * (np.sqrt(9.78049 / 6378245.0) - 7.29e-5), resonance)


def robust_holds(module):
    # Tighter than the exponential (3e-13 at 600 m/s), so that using it without need is seen.
    for misalignment in (NO_FORCING, LAMBDA):
        if not agrees(module.robust, 600.0, 1e4, LATE, 3e-14, misalignment=misalignment):
            return False
    # Elements as small as t^3 must keep their digits, or the series was not used in time.
    for column in range(6):
        unit = tuple(np.eye(6)[column])
        exact = truth(600.0, 1e4, EARLY, unit, NO_FORCING)
        matrix = module.transition_matrix(EARLY, 600.0, 1e4)[:, :, column]
        if not np.allclose(matrix, exact, rtol=2e-15, atol=0):
            return False
    cases = [(v, 1e3, 1e-11) for v in (7433.27647, -8363.224591, 7700.0, -8380.0, 2 * STATIONARY, STATIONARY)]
    cases += [(v, 0.0, 1e-11) for v in (V_MAX - 1e-6, weightless_speed(), 7941.571244, 8000.0, 12000.0)]
    cases += [(v, 0.0, 1e-11) for v in (STATIONARY, 3644.262041, -4574.210162)]
    # Far enough from the poles of the particular solution to evaluate it, too near to keep its digits.
    cases += [(3644.272, 0.0, 5e-13)]
    # a_24 + 2 omega_N v/R = omega_N^2 + 2 g/R - u^2 vanishes only above 46,000 km, where motion is slow.
    radius = 7e7
    rate = np.sqrt(7.29e-5**2 - 2 * 9.78049 * 6378245.0**2 / radius**3)
    for speed in ((rate - 7.29e-5) * radius, (rate - 7.29e-5) * radius * (1 + 1e-6)):
        place = (speed, radius - 6378245.0)
        if not agrees(module.robust, *place, (20000.0, 86400.0), 1e-12, misalignment=LAMBDA):
            return False
    return all(
        agrees(module.robust, v_east, height, times, tolerance, misalignment=misalignment)
        for v_east, height, tolerance in cases
        for misalignment in (NO_FORCING, LAMBDA)
        for times in (EARLY[:3], LATE)
    )


def ode45_holds(module):
    matrix = EquatorMotion.at(600.0, 1e4).matrix()
    for relative, steps in ((1e-3, 14), (1e-6, 59)):
        if module.ode45(lambda _, y: matrix @ y, (0.0, 7200.0), PAPER, relative, 1e-6).steps != steps:
            return False
    instants = np.linspace(0.0, 7200.0, 50)
    result = module.ode45(lambda _, y: matrix @ y, instants, PAPER, 1e-6, 1e-9)
    expected = truth(600.0, 1e4, tuple(instants), PAPER, NO_FORCING)
    return bool((np.abs(result.state - expected) <= 1e-5 * np.abs(expected).max(axis=0)).all())


class Planter(ast.NodeTransformer):
    """Plants the defect number `target` and says where, or counts the places when `target` is None.

    Integers grow by 1, other numbers by 1 %, fractions in strings by 1/100; factors named in a table become
    another constant; + and -, * and / change places; a minus sign is dropped.  Annotations and signatures are
    left alone, as are assignments to the names in `exempt`.
    """

    OPERATORS = ((ast.Add, ast.Sub), (ast.Sub, ast.Add), (ast.Mult, ast.Div), (ast.Div, ast.Mult))
    NAMES = ("beta3", "mu", "nu", "alpha33", "alpha35", "alpha63")

    def __init__(self, target=None, exempt=()):
        self.target, self.exempt = target, exempt
        self.count, self.place = 0, ""

    def plant(self, node, replacement):
        self.count += 1
        if self.count - 1 != self.target:
            return node
        self.place = f"line {node.lineno}: {ast.unparse(node)} -> {ast.unparse(replacement)}"
        return ast.copy_location(replacement, node)

    def visit_Constant(self, node):
        value = node.value
        if isinstance(value, bool) or value is None:
            return node
        if isinstance(value, int):
            return self.plant(node, ast.Constant(value + 1))
        if isinstance(value, float):
            return self.plant(node, ast.Constant(value * 1.01 if value else 1.0))
        if value in self.NAMES:
            other = self.NAMES[(self.NAMES.index(value) + 1) % len(self.NAMES)]
            return self.plant(node, ast.Constant(other))
        if value in ("odd", "even"):
            return self.plant(node, ast.Constant("even" if value == "odd" else "odd"))
        try:
            fraction = Fraction(value)
        except ValueError:
            return node
        return self.plant(node, ast.Constant(str(fraction + Fraction(1, 100))))

    def visit_BinOp(self, node):
        self.generic_visit(node)
        for found, other in self.OPERATORS:
            if isinstance(node.op, found):
                return self.plant(node, ast.BinOp(node.left, other(), node.right))
        return node

    def visit_UnaryOp(self, node):
        self.generic_visit(node)
        return self.plant(node, node.operand) if isinstance(node.op, ast.USub) else node

    def visit_Assign(self, node):
        if isinstance(node.targets[0], ast.Name) and node.targets[0].id in self.exempt:
            return node
        return self.generic_visit(node)

    def visit_AnnAssign(self, node):
        node.value = self.visit(node.value) if node.value else None
        return node

    def visit_FunctionDef(self, node):
        node.body = [self.visit(statement) for statement in node.body]
        return node


def source(module):
    return ast.parse(inspect.getsource(module))


def load(tree, original):
    """Run a changed module under a name of its own, which dataclasses look up while it loads."""
    name = f"mutant_of_{original.__name__.rpartition('.')[2]}"
    module = ModuleType(name)
    sys.modules[name] = module
    try:
        exec(compile(ast.fix_missing_locations(tree), name, "exec"), module.__dict__)
    finally:
        del sys.modules[name]
    return module


def survivors(original, holds, exempt=(), tables=()):
    """Places of the defects that `holds` does not see, and how many were planted.

    With `tables`, only the assignments to these names are changed.
    """

    def tree():
        module = source(original)
        return [s for s in module.body if getattr(getattr(s, "targets", [None])[0], "id", "") in tables], module

    def visit(planter):
        chosen, module = tree()
        for part in chosen if tables else [module]:
            planter.visit(part)
        return module

    counter = Planter(exempt=exempt)
    visit(counter)
    unseen = []
    for target in range(counter.count):
        planter = Planter(target, exempt)
        mutant = visit(planter)
        try:
            with np.errstate(all="ignore"):
                seen = not holds(load(mutant, original))
        except (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError):
            seen = True
        if not seen:
            unseen.append(planter.place)
    return unseen, counter.count


# Where the robust form hands over to the series or to the exponential both are accurate to the tolerances of
# `robust_holds`, so that a threshold 1 % off, or one more term of the series, changes no digit that counts.
EQUIVALENT = ("DOUBLE_ROOT", "SERIES_LIMIT", "SERIES_TERMS", "CANCELLATION")


@pytest.mark.parametrize(
    ("module", "holds", "selection", "least"),
    [
        (equator_formulas, formulas_hold, {}, 400),
        (equator_robust, robust_holds, {"exempt": EQUIVALENT}, 200),
        (ode45, ode45_holds, {"tables": ("STAGES", "EMBEDDED", "INTERPOLANT")}, 56),
    ],
    ids=["formulas", "robust", "ode45"],
)
def test_every_planted_defect_is_seen(module, holds, selection, least):
    assert holds(load(source(module), module))
    unseen, planted = survivors(module, holds, **selection)
    assert unseen == []
    assert planted >= least


def test_equivalents_are_equivalent():
    unseen, planted = survivors(equator_robust, robust_holds, tables=EQUIVALENT)
    assert len(unseen) == planted == len(EQUIVALENT)
