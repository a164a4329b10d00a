"""The kernels' own source, rebuilt: every operation rounded to p bits.

The formulas of `sinsbench.subjects.kernels` are not written again. Their syntax tree is rewritten, each
floating-point operation ``a op b`` becoming ``observe(a op b)``, and the result compiled. That emulates a
machine of shorter words.
"""

import ast
import functools
import hashlib
import inspect
from collections.abc import Callable, Collection
from typing import Any, Literal

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from sinsbench.subjects import kernels
from sinsbench.subjects.integrators import Integrator, checked_inputs
from sinsbench.subjects.rotation_vector_methods import (
    SERIES_LIMIT,
    RotationVectorMethod,
    binary64_coefficients,
)

__all__ = ["rebuilt_kernels", "reduced_precision_integrator", "round_mantissa"]

Array = NDArray[np.float64]
Elementary = Literal["closed", "series"]
Rounding = Literal["nearest", "chop"]

_INTEGER_CALLS = {"range", "rows", "len"}
_SERIES_LIMITS = {"closed": 0.0, "series": SERIES_LIMIT}


class _Observe(ast.NodeTransformer):
    """Wrap each floating-point operation in ``observe(operation, *extra)``.

    Each function of `functions` gets the names `extra` as further parameters and hands them on.
    """

    def __init__(self, functions: Collection[str], extra: tuple[str, ...]) -> None:
        self.functions = functions
        self.extra = extra

    def _observed(self, operation: ast.expr) -> ast.expr:
        return ast.Call(ast.Name("observe", ast.Load()), [operation, *self._extra_names()], [])

    def _extra_names(self) -> list[ast.expr]:
        return [ast.Name(name, ast.Load()) for name in self.extra]

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.args.args += [ast.arg(name) for name in self.extra]
        return self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        node.value = self.visit(node.value)  # what stands in the brackets is integer arithmetic
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        return self._observed(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Attribute):  # math.sqrt, math.sin, math.cos
            self.generic_visit(node)
            return self._observed(node)
        if isinstance(node.func, ast.Name) and node.func.id in _INTEGER_CALLS:
            return node
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id in self.functions:
            node.args += self._extra_names()
        return node


def _kernel_tree() -> ast.Module:
    """Syntax tree of the compiled functions of the kernels, decorators taken off."""
    functions: list[ast.stmt] = []
    for node in ast.parse(inspect.getsource(kernels)).body:
        if isinstance(node, ast.FunctionDef) and any(ast.unparse(d) == "compiled" for d in node.decorator_list):
            node.decorator_list = []
            functions.append(node)
    return ast.Module(functions, [])


def _namespace(tree: ast.Module, **names: Any) -> dict[str, Any]:
    namespace = {**vars(kernels), **names}
    code = compile(ast.fix_missing_locations(tree), inspect.getfile(kernels), "exec")
    exec(code, namespace)
    return namespace


def rebuilt_kernels(transform: Callable[[ast.Module], ast.Module] = lambda tree: tree, **names: Any) -> dict[str, Any]:
    """Rebuild the kernels from their source as plain Python functions.

    Parameters
    ----------
    transform : callable
        Takes the syntax tree of the kernel functions and returns the one to build.
    **names
        Further global names of the rebuilt functions.

    Returns
    -------
    dict
        The namespace of the rebuilt functions.
    """
    return _namespace(transform(_kernel_tree()), **names)


Precision = tuple[int, int, int]
"""Bits to drop, what to add to the last of them before, and 1 where ties go to even."""


def _precision(bits: int, rounding: str) -> Precision:
    if not 2 <= bits <= 53:
        raise ValueError(f"bits is {bits}, expected 2 to 53")
    if rounding not in ("nearest", "chop"):
        raise ValueError(f"rounding is {rounding!r}, expected 'nearest' or 'chop'")
    drop = 53 - bits
    return (drop, 0, 0) if rounding == "chop" or drop == 0 else (drop, (1 << (drop - 1)) - 1, 1)


@kernels.compiled
def _rounded(value: float, precision: Precision) -> float:
    """Round a binary64 number to fewer significant bits, without a branch: half of a step is this."""
    drop, half, even = precision
    pattern = np.float64(value).view(np.int64)
    # A carry out of the mantissa raises the exponent, which is what rounding up to a power of two means.
    pattern += half + ((pattern >> drop) & even)
    result: float = np.int64((pattern >> drop) << drop).view(np.float64)
    return result


@kernels.compiled
def _round_all(values: Array, precision: Precision) -> None:
    for i in range(values.size):
        values[i] = _rounded(values[i], precision)


def round_mantissa(values: ArrayLike, bits: int, rounding: Rounding = "nearest") -> Array:
    """Round numbers to a shorter mantissa.

    Parameters
    ----------
    values : array_like
        Finite binary64 numbers.
    bits : int
        Significant bits to keep, 2 to 53.
    rounding : {"nearest", "chop"}
        To nearest, ties to even, or towards zero.

    Returns
    -------
    ndarray
        The rounded numbers, same shape.

    Raises
    ------
    ValueError
        If `bits` or `rounding` is not admissible.
    """
    result = np.array(values, dtype=np.float64, order="C")
    _round_all(result.reshape(-1), _precision(bits, rounding))
    return result


@functools.cache
def _reduced_precision_kernels() -> dict[str, Any]:
    """Build the kernels with every operation rounded; the precision is an argument at run time."""
    tree = _kernel_tree()
    names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    tree = _Observe(names, ("precision",)).visit(tree)
    # Machine code on disk is found again by function name: put into the name what the code depends on. Only
    # the two functions that Python calls are kept there, so that no part of them can be an outdated one.
    source = ast.dump(tree) + inspect.getsource(inspect.unwrap(_rounded))
    digest = hashlib.sha256(source.encode()).hexdigest()[:16]
    entries = {name: f"{name}_{digest}" for name in ("integrate", "body_velocity")}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            decorator = "compiled" if node.name in entries else "in_memory"
            node.decorator_list = [ast.Name(decorator, ast.Load())]
            node.name = entries.get(node.name, node.name)
    namespace = _namespace(tree, observe=_rounded, in_memory=njit(error_model="numpy"))
    return {name: namespace[entry] for name, entry in entries.items()}


def reduced_precision_integrator(
    method: RotationVectorMethod,
    bits: int,
    rounding: Rounding = "nearest",
    *,
    elementary: Elementary = "closed",
) -> Integrator:
    """Make an integrator that computes as a machine with a mantissa of `bits` bits would.

    The inputs, the coefficients and the result of every operation, square root, sine and cosine are rounded.
    An operation is done in binary64 first; the double rounding this means differs from a single one with a
    probability of about 2^(bits - 53) an operation.

    Parameters
    ----------
    method : RotationVectorMethod
        The method.
    bits : int
        Significant bits, 2 to 53. With 53 the results are those of the built-in integrator.
    rounding : {"nearest", "chop"}
        To nearest, ties to even, or towards zero.
    elementary : {"closed", "series"}
        The closed forms of Lebedev, Panov 1989, eq. (1.12), or power series for small rotations.

    Returns
    -------
    callable
        ``f(angle, velocity, interval, attitude0, velocity0)``, the contract of
        `sinsbench.subjects.integrators.panov6`.

    Raises
    ------
    ValueError
        If `bits` or `rounding` is not admissible.
    """
    precision = _precision(bits, rounding)
    samples = method.samples_per_step
    exact = binary64_coefficients(method, series_limit=_SERIES_LIMITS[elementary])

    def shortened(numbers: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(round_mantissa(numbers, bits, rounding).tolist())

    coefficients = exact._replace(
        pair=shortened(exact.pair),
        triple=shortened(exact.triple),
        quartic=shortened(exact.quartic),
        cosine=shortened(exact.cosine),
        sine=shortened(exact.sine),
        dual=shortened(exact.dual),
    )

    def integrate(
        angle: ArrayLike, velocity: ArrayLike, interval: float, attitude0: ArrayLike, velocity0: ArrayLike
    ) -> dict[str, Array]:
        inputs = checked_inputs(samples, angle, velocity, interval, attitude0, velocity0)
        p, b, q, w = (round_mantissa(array, bits, rounding) for array in inputs)
        built = _reduced_precision_kernels()
        steps = p.shape[0] // samples
        attitude, inertial, body = (np.empty((steps + 1, columns)) for columns in (4, 3, 3))
        initial = tuple(q.tolist()), tuple(w.tolist())
        state = (*initial, built["body_velocity"](*initial, precision))
        attitude[0], inertial[0], body[0] = state
        like = ((0.0, 0.0, 0.0),) * samples
        built["integrate"](state, p, b, like, coefficients, attitude[1:], inertial[1:], body[1:], precision)
        return {"attitude": attitude, "velocity_inertial": inertial, "velocity_body": body}

    integrate.__name__ = integrate.__qualname__ = f"{method.name}_{bits}bits_{rounding}"
    return integrate
