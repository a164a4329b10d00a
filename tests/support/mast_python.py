"""The mast's compiled modules as plain Python, which takes complex numbers too and can be given defects."""

import ast
import cmath
import functools
import importlib
import inspect
import math
import sys
from types import ModuleType

import pytest

__all__ = ["complex_math", "plain", "python_modules"]

MAST = "sinsbench.subjects.mast."
NAMES = (
    "sinsbench.subjects.kernels",
    "sinsbench.subjects.gyroscopic.equations",
    *(MAST + name for name in ("model", "jacobians", "disturbances", "error_state", "steps", "continuous")),
)
DECORATORS = ("compiled", "entry", "inner")


def complex_math() -> ModuleType:
    """`math` whose functions take complex numbers too."""
    module = ModuleType("math")
    vars(module).update(vars(math))
    for name in ("sin", "cos", "sqrt"):
        real, other = getattr(math, name), getattr(cmath, name)
        setattr(module, name, lambda x, f=real, g=other: g(x) if isinstance(x, complex) else f(x))
    return module


def plain(name: str, replaced: dict[str, ModuleType]) -> ModuleType:
    """Run a module's source with decorators that do nothing; its imports see the `replaced` modules."""
    tree = ast.parse(inspect.getsource(importlib.import_module(name)))
    for node in tree.body:
        if getattr(node, "name", "") in DECORATORS:
            node.body = ast.parse("return function").body
        elif getattr(node, "name", "") == "_compiled_rows":
            node.decorator_list = []  # an overload for compiled code, which would be registered a second time
    module = ModuleType(name)
    with pytest.MonkeyPatch.context() as patch:
        for key, value in {**replaced, name: module}.items():
            patch.setitem(sys.modules, key, value)
        exec(compile(ast.fix_missing_locations(tree), name, "exec"), module.__dict__)
    return module


@functools.cache
def python_modules() -> dict[str, ModuleType]:
    """The modules of `NAMES` by their last names, each importing the plain ones before it."""
    modules: dict[str, ModuleType] = {"math": complex_math()}
    for name in NAMES:
        modules[name] = plain(name, modules)
    return {name.rpartition(".")[2]: module for name, module in modules.items()}
