"""Defects planted one at a time in the source of a module, and those among them that a check does not see."""

import ast
import inspect
import sys
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from sinsbench.mutants.planting import Planter

__all__ = ["STUMBLES", "Planter", "is_seen", "load", "mutated", "source", "survivors"]

#: A mutant that stumbles over its own defect is seen by that.
STUMBLES = (ArithmeticError, AttributeError, LookupError, NameError, RuntimeError, TypeError, ValueError)


def source(module: ModuleType) -> ast.Module:
    return ast.parse(inspect.getsource(module))


def mutated(module: ModuleType, planter: Planter, chosen: Callable[[str], bool] = lambda name: True) -> ast.Module:
    """Syntax tree of the module with what `planter` plants.

    `chosen` is asked for the name that a statement of the module assigns, '' for other statements.
    """
    tree = source(module)
    for position, statement in enumerate(tree.body):
        target = statement.targets[0] if isinstance(statement, ast.Assign) else None
        if chosen(target.id if isinstance(target, ast.Name) else ""):
            tree.body[position] = planter.visit(statement)
    return tree


def load(tree: ast.Module, original: ModuleType, replaced: dict[str, ModuleType] | None = None) -> ModuleType:
    """Run a changed module under a name of its own; its imports see the `replaced` modules."""
    name = f"mutant_of_{original.__name__.rpartition('.')[2]}"
    module = ModuleType(name)
    with pytest.MonkeyPatch.context() as patch:
        for key, value in {name: module, **(replaced or {})}.items():
            patch.setitem(sys.modules, key, value)  # dataclasses look their module up while it loads
        exec(compile(ast.fix_missing_locations(tree), name, "exec"), module.__dict__)
    return module


def is_seen(build: Callable[[], Any], holds: Callable[[Any], bool]) -> bool:
    """Whether `holds` is false of the mutant that `build` makes, or cannot be worked out."""
    try:
        with np.errstate(all="ignore"):
            return not holds(build())
    except STUMBLES:
        return True


def survivors(
    original: ModuleType,
    holds: Callable[[ModuleType], bool],
    planter: type[Planter] = Planter,
    chosen: Callable[[str], bool] = lambda name: True,
) -> tuple[list[str], int]:
    """Places of the defects in the `chosen` statements that `holds` does not see, and how many were planted."""
    listing = planter()
    mutated(original, listing, chosen)

    def mutant(target: int) -> ModuleType:
        return load(mutated(original, planter(target), chosen), original)

    places = enumerate(listing.places)
    return [place for target, place in places if not is_seen(partial(mutant, target), holds)], listing.count
