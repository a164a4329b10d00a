"""Rounding, measured: the same formulas with the result of every operation moved by a rounding or so at random.

Source: the method of random arithmetic of Vignes 1993, "A stochastic arithmetic for reliable scientific computation",
Math. Comput. Simul. 35, 233-261.
"""

import ast
import itertools
from typing import Any

import numpy as np

__all__ = ["Perturbation"]

_ELEMENTARY = frozenset(
    {"sqrt", "sin", "cos", "exp", "sinh", "cosh", "sinc", "arctan2", "hypot", "dot", "cross", "sum"}
)
_PERIOD = 9973  # a prime: no step of an algorithm meets the same numbers again and again
_ULP = float(np.finfo(np.float64).eps)


class Perturbation(ast.NodeTransformer):
    """Makes each arithmetic operation of a statement ``__rounded__(operation)``, and is that function.

    The result of an operation stays as it is or moves by a unit in the last place up or down; integers, and what
    is no number, stay.
    """

    def __init__(self) -> None:
        self.seed(0)

    def seed(self, seed: int) -> None:
        """Begin the sequence of random numbers with this number."""
        self._arrays = np.random.default_rng(seed)
        self._factors = itertools.cycle((1.0 + _ULP * self._arrays.integers(-1, 2, _PERIOD)).tolist())

    def __call__(self, value: Any) -> Any:
        """Return the result of an operation, moved."""
        if isinstance(value, float):
            return value * next(self._factors)
        if isinstance(value, np.ndarray) and value.dtype == np.float64:
            return value * (1.0 + _ULP * self._arrays.integers(-1, 2, value.shape))
        return value

    def _observed(self, node: ast.expr) -> ast.expr:
        return ast.copy_location(ast.Call(ast.Name("__rounded__", ast.Load()), [node], []), node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Move the result of an operator."""
        self.generic_visit(node)
        return self._observed(node)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Move the result of an elementary function."""
        self.generic_visit(node)
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        return self._observed(node) if name in _ELEMENTARY else node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.stmt:
        """Leave signatures and annotations alone."""
        node.body = [self.visit(statement) for statement in node.body]
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        """Leave annotations alone."""
        node.value = self.visit(node.value) if node.value else None
        return node
