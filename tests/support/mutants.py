"""Defects planted one at a time in the source of a module, and those among them that a check does not see."""

import __future__

import ast
import copy
import inspect
import sys
from collections.abc import Callable, Sequence
from functools import partial
from types import CodeType, ModuleType
from typing import Any

import numpy as np
import pytest

from sinsbench.mutants.planting import Planter

__all__ = ["STUMBLES", "Planter", "is_seen", "load", "source", "survivors"]

#: A mutant that stumbles over its own defect is seen by that.
STUMBLES = (ArithmeticError, AttributeError, LookupError, NameError, RuntimeError, TypeError, ValueError)


def source(module: ModuleType) -> ast.Module:
    return ast.parse(inspect.getsource(module))


def compiled(statement: ast.stmt, original: ModuleType) -> CodeType:
    """Code of one statement of a module, under the ``from __future__`` imports of the module."""
    names = [name for name in __future__.all_feature_names if vars(original).get(name) is getattr(__future__, name)]
    flags = sum(getattr(__future__, name).compiler_flag for name in names)
    tree = ast.fix_missing_locations(ast.Module([statement], []))
    return compile(tree, original.__name__, "exec", flags, dont_inherit=True)


def run(codes: Sequence[CodeType], original: ModuleType, replaced: dict[str, ModuleType] | None = None) -> ModuleType:
    """Run the statements of a changed module under a name of its own; its imports see the `replaced` modules."""
    name = f"mutant_of_{original.__name__.rpartition('.')[2]}"
    module = ModuleType(name)
    with pytest.MonkeyPatch.context() as patch:
        for key, value in {name: module, **(replaced or {})}.items():
            patch.setitem(sys.modules, key, value)  # dataclasses look their module up while it loads
        for code in codes:
            exec(code, module.__dict__)
    return module


def load(tree: ast.Module, original: ModuleType, replaced: dict[str, ModuleType] | None = None) -> ModuleType:
    """Run a whole tree; see `run`."""
    return run([compiled(statement, original) for statement in tree.body], original, replaced)


def is_seen(build: Callable[[], Any], holds: Callable[[Any], bool]) -> bool:
    """Whether `holds` is false of the mutant that `build` makes, or cannot be worked out."""
    try:
        with np.errstate(all="ignore"):
            return not holds(build())
    except STUMBLES:
        return True


def assigned(statement: ast.stmt) -> str:
    """The name that a statement assigns, '' for other statements."""
    target = statement.targets[0] if isinstance(statement, ast.Assign) else None
    return target.id if isinstance(target, ast.Name) else ""


def survivors(
    original: ModuleType,
    holds: Callable[[ModuleType], bool],
    planter: type[Planter] = Planter,
    chosen: Callable[[str], bool] = lambda name: True,
) -> tuple[list[str], int]:
    """Places of the defects in the `chosen` statements that `holds` does not see, and how many were planted.

    `chosen` is asked for the name that a statement of the module assigns, '' for other statements. Only the statement
    with the defect is compiled for each of them.
    """
    body = source(original).body
    codes = [compiled(statement, original) for statement in body]
    unseen, planted = [], 0

    def mutant(position: int, target: int) -> ModuleType:
        changed = planter(target).visit(copy.deepcopy(body[position]))
        return run([*codes[:position], compiled(changed, original), *codes[position + 1 :]], original)

    for position, statement in enumerate(body):
        if chosen(assigned(statement)):
            listing = planter()
            listing.visit(copy.deepcopy(statement))
            planted += listing.count
            places = enumerate(listing.places)
            unseen += [place for target, place in places if not is_seen(partial(mutant, position, target), holds)]
    return unseen, planted
