"""Defects planted one at a time in the source of a module, and those among them that a check does not see."""

import ast
import inspect
import sys
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
import pytest

#: A mutant that stumbles over its own defect is seen by that.
STUMBLES = (ArithmeticError, AttributeError, LookupError, NameError, RuntimeError, TypeError, ValueError)


class Planter(ast.NodeTransformer):
    """Plants the defect number `target`; without a target plants nothing, and lists them all in `places`.

    A minus sign is dropped, an operator becomes its counterpart in `operators`, a constant becomes what `changed`
    makes of it. Annotations, signatures and decorators are left alone. A place is named by its function and its
    statement, or the head of its compound statement, so that a list of places outlives changes elsewhere.
    """

    operators: ClassVar[dict[type[ast.operator], type[ast.operator]]] = {ast.Add: ast.Sub, ast.Sub: ast.Add}

    def __init__(self, target: int | None = None) -> None:
        self.target, self.count = target, 0
        self.places: list[str] = []
        self.function, self.statement = "", ast.AST()

    def changed(self, value: Any) -> Any:
        """What stands for the constant `value` in a mutant; None leaves it alone."""
        if type(value) is int:
            return value + 1
        return value * 1.5 if type(value) is float else None

    def plant(self, node: ast.expr, replacement: ast.expr) -> ast.expr:
        number, self.count = self.count, self.count + 1
        if self.target is None:
            self.places.append(": ".join((self.function, ast.unparse(self.statement), ast.unparse(node))))
            self.places[-1] += f" -> {ast.unparse(replacement)}"
        return ast.copy_location(replacement, node) if number == self.target else node

    def visit(self, node: ast.AST) -> Any:
        if isinstance(node, ast.stmt):
            self.statement = getattr(node, "test", getattr(node, "iter", node))
        return super().visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        value = self.changed(node.value)
        return node if value is None else self.plant(node, ast.Constant(value))

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        other = self.operators.get(type(node.op))
        return self.plant(node, ast.BinOp(node.left, other(), node.right)) if other else node

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        self.generic_visit(node)
        return self.plant(node, node.operand) if isinstance(node.op, ast.USub) else node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        node.value = self.visit(node.value) if node.value else None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.stmt:
        outer, self.function = self.function, node.name
        node.body = [self.visit(statement) for statement in node.body]
        self.function = outer
        return node


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
