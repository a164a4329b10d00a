"""Defects planted one at a time in a syntax tree."""

import ast
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, ClassVar

__all__ = ["Planter", "TermPlanter"]

FACTOR = 1.001
"""What a term is multiplied by: the smallest of the defects."""


class Planter(ast.NodeTransformer):
    """Plants the defect number `target`; without a target plants nothing, and lists them all in `places`.

    A minus sign is dropped, an operator becomes its counterpart in `operators`, a constant becomes what `changed`
    makes of it. Annotations, signatures and decorators are left alone. A place is named by its function and its
    statement, or the head of its compound statement, so that a list of places outlives changes elsewhere.

    Parameters
    ----------
    target : int, optional
        Number of the defect to plant, from 0 in the order of `places`.
    """

    operators: ClassVar[dict[type[ast.operator], type[ast.operator]]] = {ast.Add: ast.Sub, ast.Sub: ast.Add}

    def __init__(self, target: int | None = None) -> None:
        self.target, self.count = target, 0
        self.places: list[str] = []
        self.function, self.statement = "", ast.AST()

    def changed(self, value: Any) -> Any:
        """Return what stands for the constant `value` in a mutant; None leaves it alone."""
        if type(value) is int:
            return value + 1
        return value * 1.5 if type(value) is float else None

    def plant(self, node: ast.expr, *replacements: ast.expr) -> ast.expr:
        """Return what stands for `node`, each replacement being a defect of its own."""
        result = node
        for replacement in replacements:
            if self.target is None:
                self.places.append(": ".join((self.function, ast.unparse(self.statement), ast.unparse(node))))
                self.places[-1] += f" -> {ast.unparse(replacement)}"
            elif self.count == self.target:
                result = ast.copy_location(replacement, node)
            self.count += 1
        return result

    def visit(self, node: ast.AST) -> Any:
        """Visit a node; a statement becomes the one that places are named after."""
        if isinstance(node, ast.stmt):
            self.statement = getattr(node, "test", getattr(node, "iter", node))
        return super().visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        """Plant another constant."""
        value = self.changed(node.value)
        return node if value is None else self.plant(node, ast.Constant(value))

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Plant another operator."""
        self.generic_visit(node)
        other = self.operators.get(type(node.op))
        return self.plant(node, ast.BinOp(node.left, other(), node.right)) if other else node

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        """Drop a minus sign."""
        self.generic_visit(node)
        return self.plant(node, node.operand) if isinstance(node.op, ast.USub) else node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        """Leave annotations alone."""
        node.value = self.visit(node.value) if node.value else None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.stmt:
        """Leave signatures, decorators and annotations alone."""
        outer, self.function = self.function, node.name
        node.body = [self.visit(statement) for statement in node.body]
        self.function = outer
        return node


#: Factors that tables call by their names, each with one of another kind.
_FACTORS = ("beta3", "mu", "nu", "alpha33", "alpha35", "alpha63")
_NAMES: Mapping[str, str] = {"odd": "even", "even": "odd"} | dict(
    zip(_FACTORS, (*_FACTORS[1:], _FACTORS[0]), strict=True)
)


class TermPlanter(Planter):
    """Plants defects in the terms of formulas.

    A sum has its sign exchanged or loses a term, a product grows by a thousandth, factors of different kind and
    operands of a vector product change places, a constant grows by a thousandth, an index moves to its neighbour,
    a minus sign is lost. Messages and documentation are left alone.

    Parameters
    ----------
    target : int, optional
        Number of the defect to plant, from 0 in the order of `places`.
    recording : bool, default False
        Wrap each place that could hold a defect in ``__seen__(first, last, expression)`` with the numbers of its
        defects, so that those are known that a run passes through.
    """

    #: Functions that are sums in all but name, and those whose arguments commute.
    sums: ClassVar[frozenset[str]] = frozenset({"add", "plus"})
    commutative: ClassVar[frozenset[str]] = frozenset({"add", "plus", "dot", "max", "min", "maximum", "hypot"})

    def __init__(self, target: int | None = None, recording: bool = False) -> None:
        super().__init__(target)
        self.recording = recording

    def changed(self, value: Any) -> Any:
        """Return the neighbour of an index, a float that is a thousandth larger, 1 in place of 0.0."""
        if type(value) is int:
            return abs(value - 1)
        if type(value) is float:
            return value * FACTOR or 1.0
        if not isinstance(value, str) or value in _NAMES:
            return _NAMES.get(value)
        try:
            return str(Fraction(value) * Fraction(1001, 1000) or Fraction(1, 1000))
        except (ValueError, ZeroDivisionError):  # a word
            return None

    def plant(self, node: ast.expr, *replacements: ast.expr) -> ast.expr:
        """Return what stands for `node`; wrapped where passages are recorded."""
        if not self.recording:
            return super().plant(node, *replacements)
        first, self.count = self.count, self.count + len(replacements)
        numbers = [ast.Constant(first), ast.Constant(self.count)]
        return ast.copy_location(ast.Call(ast.Name("__seen__", ast.Load()), [*numbers, node], []), node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Exchange the sign of a sum or drop a term; let a product grow."""
        left_is_sum = _is_sum(node.left)
        left_is_product = _is_product(node.left)
        self.generic_visit(node)
        if isinstance(node.op, ast.Add | ast.Sub):
            minus = isinstance(node.op, ast.Sub)
            replacements: list[ast.expr] = [
                ast.BinOp(node.left, ast.Add() if minus else ast.Sub(), node.right),
                node.left,
            ]
            if not left_is_sum:  # of a + b + c, the left operand of the last sum is no single term
                replacements.append(ast.UnaryOp(ast.USub(), node.right) if minus else node.right)
            return self.plant(node, *replacements)
        if isinstance(node.op, ast.Mult | ast.Div | ast.MatMult) and not left_is_product:
            # Once a product: a factor of a * b * c is one of all of it.
            return self.plant(node, ast.BinOp(ast.Constant(FACTOR), ast.Mult(), node))
        return node

    def visit_Tuple(self, node: ast.Tuple) -> ast.expr:
        """Name places of a table after the row that they stand in."""
        outer = self.statement
        if not self.function and not isinstance(outer, ast.Call):
            self.statement = node
        self.generic_visit(node)
        self.statement = outer
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Drop a term of a sum that is a call; exchange the first two arguments of a function."""
        outer = self.statement
        if not self.function:  # a row of a table, after which its places are named
            self.statement = node
        self.generic_visit(node)
        self.statement = outer
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if len(node.args) < 2 or any(isinstance(x, ast.Starred) for x in node.args) or not name:
            return node
        if name in self.sums:
            return self.plant(node, node.args[0], node.args[1])
        if name in self.commutative or name == "range":
            return node
        first, second, *others = node.args
        if ast.dump(first) == ast.dump(second):
            return node
        return self.plant(node, ast.Call(node.func, [second, first, *others], node.keywords))

    def visit_Raise(self, node: ast.Raise) -> ast.stmt:
        """Leave messages alone."""
        return node

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.expr:
        """Leave messages alone."""
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.expr:
        """Leave the signature alone."""
        node.body = self.visit(node.body)
        return node


def _is_sum(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub)


def _is_product(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div | ast.MatMult)
