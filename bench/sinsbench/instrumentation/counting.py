"""Count the floating-point operations of Python functions by running them.

A function's syntax tree is rewritten so that every operator and every call passes through a `_Tracer`, compiled, and
bound to the variables of the original. What it calls is rewritten in turn when it is reached, compiled functions of
numba from their Python source; calls into NumPy and `math` cost what `sinsbench.instrumentation.costs` defines.
Wherever code leaves what can be followed, `UncountableError` says so: no count is ever silently incomplete.
"""

import ast
import builtins
import functools
import inspect
import math
import operator
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

from sinsbench.instrumentation.costs import (
    FREE_ARRAY_METHODS,
    FREE_MATH,
    FREE_NUMPY,
    METHOD_RULES,
    OPERATORS,
    RULES,
    Cost,
    UncountableError,
    power_cost,
    size_of,
    ufunc_cost,
    ufunc_method_cost,
)

__all__ = ["COUNTED_STEPS", "UncountableError", "count_operations", "operations_per_sample"]

COUNTED_STEPS = (3, 4, 5)
"""Numbers of steps at which operations are counted: a start that takes the first few steps drops out."""

_OPERATE, _CALL = "_sinsbench_operate", "_sinsbench_call"
_FILE = "<counted>"
_LOOK_AT_THEIR_CALLER = {"super", "locals", "globals", "vars", "dir"}
_OPERATOR_NAMES: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "sub",
    ast.Mult: "mul",
    ast.Div: "truediv",
    ast.FloorDiv: "floordiv",
    ast.Mod: "mod",
    ast.Pow: "pow",
    ast.MatMult: "matmul",
    ast.BitAnd: "and_",
    ast.BitOr: "or_",
    ast.BitXor: "xor",
    ast.LShift: "lshift",
    ast.RShift: "rshift",
}
_CONSTANT = (ast.BinOp, ast.UnaryOp, ast.Constant, ast.operator, ast.unaryop)
_OPERANDS = (int, float, complex, str, bytes, list, tuple, set, frozenset, dict, range, np.ndarray, np.generic, type)
_NUMBERS = {int, float, np.float64}
_NOT_NUMERICAL = frozenset(sys.stdlib_module_names) - {"cmath", "math", "random", "statistics"}


class _Rewriter(ast.NodeTransformer):
    """Send operators and calls through the tracer, which decides at run time what they cost."""

    def _operated(self, node: ast.operator, left: ast.expr, right: ast.expr, in_place: bool) -> ast.expr:
        kind = ast.Constant(_OPERATOR_NAMES[type(node)])
        return ast.Call(ast.Name(_OPERATE, ast.Load()), [kind, left, right, ast.Constant(in_place)], [])

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        if all(isinstance(x, _CONSTANT) for x in ast.walk(node)):
            return node  # Python works it out once and for all
        self.generic_visit(node)
        return self._operated(node.op, node.left, node.right, in_place=False)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST | list[ast.AST]:
        self.generic_visit(node)
        before: list[ast.AST] = []
        target: Any = node.target
        if isinstance(target, ast.Subscript | ast.Attribute):
            # Owner and index are evaluated once, as the statement does; a slice has no value that a name could hold.
            names = {"value": target.value}
            if isinstance(target, ast.Subscript) and not any(isinstance(x, ast.Slice) for x in ast.walk(target.slice)):
                names["slice"] = target.slice
            for field, value in names.items():
                before.append(ast.Assign([ast.Name(f"_sinsbench_{field}", ast.Store())], value))
                setattr(target, field, ast.Name(f"_sinsbench_{field}", ast.Load()))
        current = ast.parse(ast.unparse(target), mode="eval").body
        return [*before, ast.Assign([target], self._operated(node.op, current, node.value, in_place=True))]

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id in _LOOK_AT_THEIR_CALLER:
            return node
        return ast.Call(ast.Name(_CALL, ast.Load()), [node.func, *node.args], node.keywords)

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        for argument in [*node.posonlyargs, *node.args, *node.kwonlyargs, node.vararg, node.kwarg]:
            if argument is not None:
                argument.annotation = None
        return self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST | None:
        return self.visit(ast.Assign([node.target], node.value)) if node.value is not None else None


@functools.lru_cache(maxsize=64)
def _syntax(source: str) -> ast.Module:
    return ast.parse(source)


def _definition(code: CodeType, source: str) -> ast.FunctionDef | ast.Lambda:
    """Return the definition of a function in the source of its module."""
    spans = {(first, left, last, right) for first, last, left, right in code.co_positions()}
    for node in ast.walk(_syntax(source)):
        if isinstance(node, ast.FunctionDef) and node.name == code.co_name:
            if min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)]) == code.co_firstlineno:
                return node
        elif isinstance(node, ast.Lambda) and code.co_name == "<lambda>" and node.lineno == code.co_firstlineno:
            body = node.body
            if (body.lineno, body.col_offset, body.end_lineno, body.end_col_offset) in spans:
                return node
    raise UncountableError(f"the source of {code.co_name} is not found")


@functools.lru_cache(maxsize=1024)
def _rewritten(code: CodeType, source: str) -> CodeType:
    """Return the code of a function with every operator and call observed."""
    definition = ast.parse(ast.unparse(_definition(code, source))).body[0]
    if isinstance(definition, ast.Expr):
        definition = ast.Assign([ast.Name("_", ast.Store())], definition.value)
    if isinstance(definition, ast.FunctionDef):
        definition.decorator_list, definition.returns = [], None
        arguments = definition.args
        # Defaults belong to the function, not to its code.
        arguments.kw_defaults = [x and ast.Constant(None) for x in arguments.kw_defaults]
        arguments.defaults = [ast.Constant(None) for _ in arguments.defaults]
    body = _Rewriter().visit(definition)
    # A factory whose parameters are the free variables: they become cells of the function inside.
    names = [*code.co_freevars, _OPERATE, _CALL]
    factory = ast.parse(f"def factory({', '.join(names)}): pass").body[0]
    assert isinstance(factory, ast.FunctionDef)
    factory.body = [body]
    built = compile(ast.fix_missing_locations(ast.Module([factory], [])), _FILE, "exec")
    outer = next(one for one in built.co_consts if isinstance(one, CodeType))
    return next(one for one in outer.co_consts if isinstance(one, CodeType) and one.co_name == code.co_name)


class _Tracer:
    """Runs functions and counts; see the module's description."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._known: dict[FunctionType, FunctionType] = {}

    def _count(self, cost: Cost) -> None:
        for kind, number in cost.items():
            self.counts[kind] += int(number)

    def operate(self, name: str, left: Any, right: Any, in_place: bool) -> Any:
        """Return the result of a binary operator."""
        function, kind = OPERATORS[name]
        if kind and type(left) in _NUMBERS and type(right) in _NUMBERS:  # most operators, so without ado
            result = function(left, right)
            self.counts[kind] += type(result) is not int
            return result
        for owner, other, method in ((left, right, f"__{name}__"), (right, left, f"__r{name}__")):
            own = getattr(type(owner), method, None)
            if isinstance(own, FunctionType) and (result := self.call(own, owner, other)) is not NotImplemented:
                return result
        for operand in (left, right):
            if not isinstance(operand, _OPERANDS):
                raise UncountableError(f"operators of {type(operand).__module__}.{type(operand).__name__}")
        if in_place:
            function = getattr(operator, f"i{name.removesuffix('_')}")
        length = np.shape(left)[-1] if name == "matmul" else 0
        result = function(left, right)
        size = size_of(result)
        if name == "pow":
            self._count(power_cost(right, size))
        elif name == "matmul":
            self._count({"multiply": length * size, "add": (length - 1) * size})
        elif kind:
            self._count({kind: size})
        return result

    def call(self, function: Any, /, *arguments: Any, **keywords: Any) -> Any:
        """Return the result of a call."""
        if type(function) is FunctionType and function in self._known:
            return self._known[function](*arguments, **keywords)
        if isinstance(function, functools.partial):
            if function.func == self.call:
                return function(*arguments, **keywords)
            return self.call(function.func, *function.args, *arguments, **{**function.keywords, **keywords})
        if isinstance(function, MethodType):
            return self.call(function.__func__, function.__self__, *arguments, **keywords)
        if isinstance(getattr(function, "py_func", None), FunctionType):  # compiled by numba, from this source
            return self.call(function.py_func, *arguments, **keywords)
        rule = RULES.get(id(function))
        if rule is not None:
            result = function(*arguments, **keywords)
            self._count(rule(arguments, keywords, result))
            return result
        if isinstance(function, np.ufunc):
            result = function(*arguments, **keywords)
            self._count(ufunc_cost(function, arguments, keywords, result))
            return result
        if isinstance(function, FunctionType):
            return self._python(function, *arguments, **keywords)
        if isinstance(function, type):
            return self._construct(function, *arguments, **keywords)
        if isinstance(function, BuiltinFunctionType):
            return self._builtin(function, *arguments, **keywords)
        return self._other(function, *arguments, **keywords)

    def _python(self, function: FunctionType, /, *arguments: Any, **keywords: Any) -> Any:
        root = (function.__module__ or "").partition(".")[0]
        if function.__code__.co_filename == _FILE:
            return function(*arguments, **keywords)
        if root == "numpy" and function.__name__ in FREE_NUMPY:
            return function(*arguments, **keywords)
        if root in _NOT_NUMERICAL:
            return function(*map(self._followed, arguments), **keywords)
        return self._traced(function)(*arguments, **keywords)

    def _traced(self, function: FunctionType) -> FunctionType:
        """Return the function with every operator and call observed, bound to the same variables."""
        if function in self._known:
            return self._known[function]
        try:
            source = "".join(inspect.findsource(function)[0])
        except (OSError, TypeError):
            raise UncountableError(f"the source of {function.__qualname__} is not found") from None
        code = _rewritten(function.__code__, source)
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
        cells |= {_OPERATE: CellType(self.operate), _CALL: CellType(self.call)}
        closure = tuple(cells[name] for name in code.co_freevars)
        traced = FunctionType(code, function.__globals__, function.__name__, function.__defaults__, closure)
        traced.__kwdefaults__ = function.__kwdefaults__
        self._known[function] = traced
        return traced

    def _construct(self, kind: type, /, *arguments: Any, **keywords: Any) -> Any:
        root = kind.__module__.partition(".")[0]
        if root in _NOT_NUMERICAL | {"builtins", "numpy"}:
            return kind(*map(self._followed, arguments), **keywords)
        if not (getattr(sys.modules.get(kind.__module__), "__file__", None) or ".py").endswith(".py"):
            raise UncountableError(f"{kind.__module__}.{kind.__name__} is compiled")
        start = inspect.getattr_static(kind, "__init__")
        # Of a class that Python itself completed, such as a data class, there is no source, and nothing to count.
        written = isinstance(start, FunctionType) and not start.__code__.co_filename.startswith("<")
        if not written or isinstance(inspect.getattr_static(kind, "__new__"), staticmethod):
            return kind(*arguments, **keywords)
        made: Any = object.__new__(kind)
        self.call(start, made, *arguments, **keywords)
        return made

    def _builtin(self, function: BuiltinFunctionType, /, *arguments: Any, **keywords: Any) -> Any:
        owner, name = function.__self__, function.__name__
        if isinstance(owner, np.ufunc):
            result = function(*arguments, **keywords)
            self._count(ufunc_method_cost(owner.__name__, name, arguments, result))
            return result
        if isinstance(owner, np.ndarray | np.generic):
            result = function(*arguments, **keywords)
            if name in METHOD_RULES:
                self._count(METHOD_RULES[name]((owner, *arguments), keywords, result))
            elif name not in FREE_ARRAY_METHODS:
                raise UncountableError(f"the method {name} of arrays is not counted")
            return result
        if owner is math or owner is operator or owner is builtins:
            return self._standard(function, name, *arguments, **keywords)
        place = owner if isinstance(owner, type) else type(owner)
        root = (getattr(function, "__module__", None) or place.__module__).partition(".")[0]
        if root == "numpy" and name in FREE_NUMPY:
            return function(*arguments, **keywords)
        if root in _NOT_NUMERICAL | {"builtins"}:  # the methods of lists, dictionaries, generators, ...
            return function(*map(self._followed, arguments), **keywords)
        raise UncountableError(f"{root or type(owner).__name__}.{name} is compiled")

    def _standard(self, function: Callable[..., Any], name: str, /, *arguments: Any, **keywords: Any) -> Any:
        """Call a function of `builtins`, `operator` or `math`."""
        if name in ("eval", "exec", "compile"):
            raise UncountableError(f"{name} is not followed")
        if function is builtins.sum:
            return functools.reduce(lambda x, y: self.operate("add", x, y, False), arguments[0], *arguments[1:] or (0,))
        plain = f"{name}_" if f"{name}_" in OPERATORS else name
        if function in (builtins.pow, math.pow) or (function.__module__ == "_operator" and plain in OPERATORS):
            return self.operate(plain, arguments[0], arguments[1], False)
        result = function(*map(self._followed, arguments), **{k: self._followed(x) for k, x in keywords.items()})
        if function.__module__ == "math" and name not in FREE_MATH:
            self._count({name: 1})
        return result

    def _other(self, function: Any, /, *arguments: Any, **keywords: Any) -> Any:
        kind, name = type(function), getattr(function, "__name__", type(function).__name__)
        root = (getattr(function, "__module__", None) or "").partition(".")[0]
        if kind is functools._lru_cache_wrapper:  # what is kept costs nothing the second time
            return function(*arguments, **keywords)
        if root == "numpy" and name in FREE_NUMPY:
            return function(*arguments, **keywords)
        written_in_python = getattr(function, "_implementation", None)  # of NumPy's functions that dispatch
        if root == "numpy" and isinstance(written_in_python, FunctionType):
            return self.call(written_in_python, *arguments, **keywords)
        if isinstance(vars(kind).get("__call__"), FunctionType):
            return self.call(kind.__call__, function, *arguments, **keywords)
        if root in _NOT_NUMERICAL or kind.__module__ == "builtins":
            return function(*map(self._followed, arguments), **keywords)
        raise UncountableError(f"{root or kind.__module__}.{name} is compiled")

    def _followed(self, value: Any) -> Any:
        """Return a function that another one is going to call, followed by the tracer; anything else as it is."""
        if isinstance(value, FunctionType | MethodType | np.ufunc) or hasattr(value, "py_func"):
            return functools.partial(self.call, value)
        return value


def count_operations(function: Callable[..., Any], *arguments: Any, **keywords: Any) -> dict[str, int]:
    """Count the floating-point operations of one call, by running it.

    Parameters
    ----------
    function : callable
        Written in Python, or compiled from Python by numba.
    *arguments, **keywords
        What it is called with.

    Returns
    -------
    dict of str to int
        Operations by kind: ``add`` (with subtractions), ``multiply``, ``divide``, ``sqrt``, and every elementary
        function under its own name. Changes of sign, absolute values and comparisons are free.

    Raises
    ------
    UncountableError
        Where code is reached that has no Python source and no defined cost.
    Exception
        Whatever the function raises.
    """
    tracer = _Tracer()
    tracer.call(function, *arguments, **keywords)
    return {kind: number for kind, number in sorted(tracer.counts.items()) if number}


def _totals(
    function: Callable[..., Any], arguments: Callable[[int], tuple[Any, ...]], samples: tuple[int, ...]
) -> Iterator[int]:
    for n in samples:
        yield sum(count_operations(function, *arguments(n)).values())


def operations_per_sample(
    function: Callable[..., Any], arguments: Callable[[int], tuple[Any, ...]], samples_per_step: int
) -> tuple[float | None, str]:
    """Count the floating-point operations that each further sample costs an integrator.

    What is done once for all samples, such as checks of the initial values, drops out of the differences.

    Parameters
    ----------
    function : callable
    arguments : callable
        ``arguments(n)`` returns what the integrator is called with for n samples.
    samples_per_step : int

    Returns
    -------
    operations : float or None
        None where they cannot be counted.
    note : str
        Why they cannot; empty otherwise.
    """
    step = samples_per_step
    try:
        first, second, third = _totals(function, arguments, tuple(steps * step for steps in COUNTED_STEPS))
    except UncountableError as error:
        return None, str(error)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a stranger's code may raise anything
        return None, f"counting raises {type(error).__name__}"
    if second - first != third - second:
        return None, f"a step costs now {second - first}, now {third - second} operations"
    return (second - first) / step, ""
