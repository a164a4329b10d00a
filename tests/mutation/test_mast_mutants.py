"""Defects planted one at a time in F, H, their derivatives, F_1 and Theta of the mast must be seen.

Signs are exchanged and dropped, constants and indices changed, squares lost, matrices transposed. What judges are the
equations written out with matrices, complex steps and the definitions of the noise's gains: no filter runs.
"""

import ast
import copy
import inspect
from types import ModuleType

import numpy as np
import pytest

from mast_equations import NAMES, disagreements, expected
from mast_python import DECORATORS, MAST, python_modules
from mutants import STUMBLES, Planter
from sinsbench.subjects.mast import disturbances, jacobians, model

#: What resolves a vector in other axes, and its transpose.
TRANSPOSES = {
    "resolved": "back", "back": "resolved", "to_local": "from_local", "from_local": "to_local",
    "resolved_columns": "back_columns", "back_columns": "resolved_columns",
}  # fmt: skip
HELPERS = {*DECORATORS, "_compiled", "index", "plain_matrix"}


class MastPlanter(Planter):
    """Also transposes matrices, loses squares, and puts 1 in place of 0."""

    def changed(self, value):
        return 1.0 if value == 0.0 and type(value) is float else super().changed(value)

    def visit_Call(self, node):
        self.generic_visit(node)
        other = TRANSPOSES.get(getattr(node.func, "id", ""))
        return self.plant(node, ast.Call(ast.Name(other, ast.Load()), node.args, [])) if other else node

    def visit_BinOp(self, node):
        result = super().visit_BinOp(node)
        if isinstance(node.op, ast.Mult) and ast.dump(node.left) == ast.dump(node.right):
            return self.plant(result, node.left)
        return result


#: Change that leaves every value right: what is then added is zero.
EQUIVALENT = "state_derivative: terms.gravity_x != 0.0 or terms.gravity_y != 0.0: 0.0 -> 1.0"


def survivors_of(original: ModuleType, plain: ModuleType, disagrees) -> tuple[list[str], int]:
    """Defects of the functions of a module that nothing disagrees with, and how many were planted."""
    unseen, planted = [], 0
    for node in ast.parse(inspect.getsource(original)).body:
        if not isinstance(node, ast.FunctionDef) or node.name in HELPERS:
            continue
        node.decorator_list = []
        listing = MastPlanter()
        listing.visit(copy.deepcopy(node))
        kept = vars(plain)[node.name]
        for target, place in enumerate(listing.places):
            mutant = MastPlanter(target).visit(copy.deepcopy(node))
            exec(compile(ast.fix_missing_locations(ast.Module([mutant], [])), "mutant", "exec"), vars(plain))
            try:
                seen = disagrees()
            except STUMBLES:
                seen = True
            if not seen:
                unseen.append(place)
        vars(plain)[node.name] = kept
        planted += listing.count
    return unseen, planted


@pytest.fixture(scope="module")
def references():
    return {name: expected(name) for name in NAMES}


@pytest.mark.parametrize(("original", "least"), [(model, 170), (jacobians, 400), (disturbances, 80)])
def test_every_planted_defect_is_seen(original, least, references):
    modules = python_modules.__wrapped__()
    last = original.__name__.removeprefix(MAST)

    def disagrees():
        with np.errstate(all="ignore"):
            return any(disagreements(name, references[name], modules, (last,)) for name in NAMES)

    assert not disagrees()
    unseen, planted = survivors_of(original, modules[last], disagrees)
    assert [place for place in unseen if place != EQUIVALENT] == []
    assert planted > least
