"""Modules as lists of statements in plain Python: without a compiler to machine code, and with loops that end."""

import __future__

import ast
import functools
import importlib
import inspect
import pickle
from collections.abc import Callable, Iterator, Mapping
from types import CodeType
from typing import Any, NamedTuple, TypeGuard

__all__ = ["PACKAGE", "Interpreter", "Place", "Source", "Transform", "copied", "is_compiled", "plain_source"]

PACKAGE = "sinsbench.subjects"
#: Decorators that make machine code, and what registers with the compiler.
_COMPILERS = frozenset({"njit", "jit", "vectorize", "guvectorize"})
_REGISTRATIONS = frozenset({"overload", "overload_method", "register_jitable"})


class Place(NamedTuple):
    """A top-level statement: the name of its module, and its position there."""

    module: str
    position: int


Transform = Callable[[Place, ast.stmt], ast.stmt]


def _undecorated(*arguments: Any, **options: Any) -> Any:
    """Stand for a decorator that compiles, with options or without: the function stays as it is."""
    return arguments[0] if len(arguments) == 1 and callable(arguments[0]) and not options else lambda function: function


def _unregistered(*arguments: Any, **options: Any) -> Any:
    return lambda function: function


class Interpreter:
    """Stands for numba: what would make machine code leaves the function as it is, all else is numba's."""

    def __getattr__(self, name: str) -> Any:
        if name in _COMPILERS:
            return _undecorated
        if name in _REGISTRATIONS:
            return _unregistered
        return self if name == "extending" else getattr(importlib.import_module("numba"), name)


class _Interpreted(ast.NodeTransformer):
    """Makes a statement ready to be interpreted.

    Takes numba out. Counts the turns of loops without an end of their own, and the calls of functions but those of
    kernels, of which there are many and whose loops end. In kernels elements of arrays become numbers of Python's
    own, which it computes with several times faster.

    Parameters
    ----------
    kernels : bool
        Whether the module is one of kernels.
    """

    def __init__(self, kernels: bool) -> None:
        self.kernels, self.inside = kernels, False

    def visit_Import(self, node: ast.Import) -> ast.AST:
        if [alias.name for alias in node.names] != ["numba"]:
            return node
        return self._bound(node, {node.names[0].asname or "numba": ast.Name("__numba__", ast.Load())})

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST:
        if node.module not in ("numba", "numba.extending"):
            return node
        numba = ast.Name("__numba__", ast.Load())
        return self._bound(
            node, {alias.asname or alias.name: ast.Attribute(numba, alias.name, ast.Load()) for alias in node.names}
        )

    def _bound(self, place: ast.AST, values: Mapping[str, ast.expr]) -> ast.AST:
        targets = ast.Tuple([ast.Name(name, ast.Store()) for name in values], ast.Store())
        return ast.copy_location(ast.Assign([targets], ast.Tuple([*values.values()], ast.Load())), place)

    def visit_While(self, node: ast.While) -> ast.AST:
        self.generic_visit(node)
        node.body.insert(0, _tick(node))
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        outer, self.inside = self.inside, True
        node.body = [self.visit(statement) for statement in node.body]
        self.inside = outer
        if not self.kernels:
            node.body.insert(0, _tick(node))
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        is_element = isinstance(node.slice, ast.Tuple) and isinstance(node.ctx, ast.Load)
        if not (self.kernels and self.inside and is_element):
            return node
        return ast.copy_location(ast.Call(ast.Name("float", ast.Load()), [node], []), node)


def is_compiled(node: ast.stmt) -> TypeGuard[ast.FunctionDef]:
    """Whether a statement is the definition of a function that numba compiles, in a module of this package."""
    return isinstance(node, ast.FunctionDef) and any(ast.unparse(x) == "compiled" for x in node.decorator_list)


def _tick(place: ast.AST) -> ast.stmt:
    return ast.copy_location(ast.Expr(ast.Call(ast.Name("__tick__", ast.Load()), [], [])), place)


class Source:
    """A module as a list of statements, which nobody may change, and their codes."""

    def __init__(self, name: str, transform: Transform | None = None) -> None:
        self.original = importlib.import_module(name)
        self.kernels = name.startswith(PACKAGE) and name.endswith("kernels")
        body = ast.parse(inspect.getsource(self.original)).body
        # A copy of an exception would not be caught by those who know the original.
        self.exceptions = {
            node.name: getattr(self.original, node.name)
            for node in body
            if isinstance(node, ast.ClassDef) and issubclass(getattr(self.original, node.name), BaseException)
        }
        self.plain: list[ast.stmt] = [
            ast.copy_location(ast.Pass(), node)
            if isinstance(node, ast.ClassDef) and node.name in self.exceptions
            else node
            for node in body
        ]
        future = any(isinstance(node, ast.ImportFrom) and node.module == "__future__" for node in body)
        self._flags = __future__.annotations.compiler_flag if future else 0
        self.codes = [
            self.code(transform(Place(name, position), copied(node)) if transform else copied(node))
            for position, node in enumerate(self.plain)
        ]

    def code(self, node: ast.stmt) -> CodeType:
        """Compile a statement, which changes on the way."""
        tree = ast.fix_missing_locations(ast.Module([_Interpreted(self.kernels).visit(node)], []))
        file = f"<copy of {self.original.__name__}>"
        code: CodeType = compile(tree, file, "exec", flags=self._flags, dont_inherit=True)
        return code

    def imported(self) -> Iterator[str]:
        """Names of the modules of the package that are imported, anywhere in the module."""
        for node in ast.walk(ast.Module(self.plain, [])):
            if isinstance(node, ast.ImportFrom) and node.module == PACKAGE:
                yield from (f"{PACKAGE}.{alias.name}" for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{PACKAGE}."):
                yield str(node.module)


plain_source = functools.cache(Source)


def copied(node: ast.stmt) -> ast.stmt:
    """Return a deep copy, several times faster than `copy.deepcopy` makes one."""
    result: ast.stmt = pickle.loads(pickle.dumps(node, pickle.HIGHEST_PROTOCOL))
    return result
