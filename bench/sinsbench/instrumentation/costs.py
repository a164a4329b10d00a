"""What calls into NumPy and the standard library cost, in floating-point operations, by definition.

Nothing here looks at how a library computes: a matrix product of shapes (m, k) and (k, n) is m n (k multiplications
and k - 1 additions), whatever multiplies it. Comparisons, signs, absolute values, rounding to whole numbers, copies and
index arithmetic are free. Every elementary function is one operation of its own name.
"""

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

__all__ = [
    "FREE_ARRAY_METHODS",
    "FREE_MATH",
    "FREE_NUMPY",
    "METHOD_RULES",
    "OPERATORS",
    "RULES",
    "Cost",
    "UncountableError",
    "power_cost",
    "size_of",
    "ufunc_cost",
    "ufunc_method_cost",
]

Cost = Mapping[str, float]
"""Operations by kind."""


class UncountableError(BaseException):
    """Code leaves what can be counted; the message says where.

    No `Exception`, so that a subject's own ``except`` clause does not swallow it.
    """


def size_of(value: Any) -> int:
    """Return how many floating-point numbers a value holds; integers, logical values and other objects are none.

    Raises
    ------
    UncountableError
        For complex numbers and arrays of objects, whose operations have no fixed cost.
    """
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind in "cO":
            raise UncountableError(f"values of type {value.dtype} are not counted")
        return value.size if value.dtype.kind == "f" else 0
    if isinstance(value, complex):
        raise UncountableError("values of type complex are not counted")
    return int(isinstance(value, float))


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_UFUNC_KINDS = {
    **dict.fromkeys(("add", "subtract"), "add"),
    **dict.fromkeys(("multiply", "square", "deg2rad", "rad2deg", "degrees", "radians", "ldexp"), "multiply"),
    **dict.fromkeys(("divide", "true_divide", "floor_divide", "remainder", "fmod", "reciprocal"), "divide"),
}
_FREE_UFUNCS = _words(
    """
    negative positive absolute fabs sign copysign maximum minimum fmax fmin floor ceil rint trunc spacing
    nextafter conjugate heaviside
    """
)


def power_cost(exponent: Any, size: int) -> Cost:
    """Return the cost of powers: products by repeated squaring for whole exponents, else one operation ``power``."""
    if not size or np.ndim(exponent) or not (float(exponent).is_integer() or exponent == 0.5):
        return {"power": size}
    if exponent == 0.5:
        return {"sqrt": size}
    whole = abs(int(exponent))
    products = max(whole.bit_length() - 1, 0) + max(whole.bit_count() - 1, 0)
    return {"multiply": products * size, "divide": size if exponent < 0 else 0}


def ufunc_cost(function: np.ufunc, arguments: tuple[Any, ...], keywords: Mapping[str, Any], result: Any) -> Cost:
    """Return the cost of a universal function of NumPy that returned `result`.

    Raises
    ------
    UncountableError
        For one that works on whole vectors or matrices, products apart.
    """
    name = function.__name__
    if name == "matmul":
        return _products(np.shape(arguments[0])[-1], size_of(result))
    if function.signature is not None:
        raise UncountableError(f"numpy.{name} is compiled")
    parts = result if isinstance(result, tuple) else (result,)
    size = max(map(size_of, parts))
    if size and keywords.get("where") is not None:
        size = int(np.count_nonzero(np.broadcast_to(keywords["where"], np.shape(parts[0]))))
    if name in ("power", "float_power"):
        return power_cost(arguments[1], size)
    return {} if name in _FREE_UFUNCS else {_UFUNC_KINDS.get(name, name): size}


def ufunc_method_cost(name: str, method: str, arguments: tuple[Any, ...], result: Any) -> Cost:
    """Return the cost of ``reduce``, ``accumulate`` and ``outer`` of an elementwise function.

    Raises
    ------
    UncountableError
        For other methods.
    """
    if name in _FREE_UFUNCS or not size_of(result):
        return {}
    kind, size = _UFUNC_KINDS.get(name, name), size_of(result)
    if method == "outer":
        return {kind: size}
    given = np.asarray(arguments[0])
    if method == "reduce":
        return {kind: given.size - size}
    if method == "accumulate":
        return {kind: size - size // max(given.shape[arguments[1] if len(arguments) > 1 else 0], 1)}
    raise UncountableError(f"numpy.{name}.{method} is not counted")


def _products(length: int, results: int) -> Cost:
    """Return the cost of scalar products of vectors of some length."""
    return {"multiply": length * results, "add": (length - 1) * results}


def _contraction(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    a, b, size = np.size(arguments[0]), np.size(arguments[1]), size_of(result)
    # Each result sums over k pairs: the sizes are those of m k, k n and m n.
    return _products(math.isqrt(a * b // size), size) if size else {}


def _elementwise(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    return {"multiply": size_of(result)}


def _einsum(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    subscripts, *operands = arguments
    if not isinstance(subscripts, str):
        raise UncountableError("numpy.einsum with lists of axes is not counted")
    sizes: dict[str, int] = {}
    dots: tuple[int, ...] = ()
    for labels, operand in zip(subscripts.replace(" ", "").split("->")[0].split(","), operands, strict=True):
        shape = np.shape(operand)
        before, ellipsis, after = labels.partition("...")
        stop = len(shape) - len(after)
        sizes.update(zip(before, shape, strict=False))
        sizes.update(zip(after, shape[stop:], strict=True))
        dots = np.broadcast_shapes(dots, shape[len(before) : stop] if ellipsis else ())
    terms = math.prod(sizes.values()) * math.prod(dots)
    results = size_of(result)
    return {"multiply": (len(operands) - 1) * terms, "add": terms - results} if results else {}


def _sum(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    size = size_of(result)
    return {"add": np.size(arguments[0]) - size} if size else {}


def _mean(arguments: tuple[Any, ...], keywords: Mapping[str, Any], result: Any) -> Cost:
    return {**_sum(arguments, keywords, result), "divide": size_of(result)}


def _product(arguments: tuple[Any, ...], keywords: Mapping[str, Any], result: Any) -> Cost:
    return {"multiply": _sum(arguments, keywords, result).get("add", 0)}


def _running(kind: str) -> Callable[[tuple[Any, ...], Mapping[str, Any], Any], Cost]:
    def cost(arguments: tuple[Any, ...], keywords: Mapping[str, Any], result: Any) -> Cost:
        size = size_of(result)
        axis = keywords.get("axis", arguments[1] if len(arguments) > 1 else None)
        length = np.size(arguments[0]) if axis is None else np.shape(arguments[0])[axis]
        return {kind: size - size // length} if size else {}

    return cost


def _difference(arguments: tuple[Any, ...], keywords: Mapping[str, Any], result: Any) -> Cost:
    if keywords.get("n", arguments[1] if len(arguments) > 1 else 1) != 1:
        raise UncountableError("numpy.diff of higher differences is not counted")
    return {"add": size_of(result)}


def _cross(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    size = size_of(result)
    return {"multiply": 2 * size, "add": size}


def _norm(arguments: tuple[Any, ...], keywords: Mapping[str, Any], result: Any) -> Cost:
    if len(arguments) > 1 or keywords.get("ord") is not None:
        raise UncountableError("numpy.linalg.norm is counted for the Euclidean norm only")
    given, size = np.size(arguments[0]), size_of(result)
    return {"multiply": given, "add": given - size, "sqrt": size}


def _sinc(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    return dict.fromkeys(("multiply", "sin", "divide"), size_of(result))


def _arange(arguments: tuple[Any, ...], _: Mapping[str, Any], result: Any) -> Cost:
    return dict.fromkeys(("multiply", "add"), size_of(result))


Rule = Callable[[tuple[Any, ...], Mapping[str, Any], Any], Cost]
"""``(arguments, keywords, result)`` to what the call cost."""

RULES: Mapping[int, Rule] = {
    id(function): rule
    for rule, functions in (
        (_contraction, (np.dot, np.inner, np.tensordot, np.vdot, np.outer)),
        (_einsum, (np.einsum,)),
        (_sum, (np.sum, math.fsum)),
        (_mean, (np.mean,)),
        (_product, (np.prod, math.prod)),
        (_running("add"), (np.cumsum,)),
        (_running("multiply"), (np.cumprod,)),
        (_difference, (np.diff,)),
        (_cross, (np.cross,)),
        (_norm, (np.linalg.norm,)),
        (_sinc, (np.sinc,)),
        (_arange, (np.arange,)),
        (_elementwise, (math.ldexp, math.degrees, math.radians)),
    )
    for function in functions
}
"""Cost of functions, by their identity."""

METHOD_RULES: Mapping[str, Rule] = {
    "dot": _contraction,
    "sum": _sum,
    "mean": _mean,
    "prod": _product,
    "cumsum": _running("add"),
    "cumprod": _running("multiply"),
}
"""Cost of methods of arrays; the array is the first of the arguments."""

FREE_ARRAY_METHODS = _words(
    """
    all any argmax argmin argsort astype byteswap choose clip compress conj conjugate copy diagonal fill flatten
    item max min nonzero partition put ravel repeat reshape resize searchsorted setfield setflags sort squeeze
    swapaxes take tobytes tolist transpose view __array_wrap__ __getitem__ __setitem__ __len__
    """
)
"""Methods of arrays that compute nothing."""

FREE_NUMPY = _words(
    """
    all amax amin any argmax argmin argsort array array_equal array_split as_arrays asanyarray asarray
    ascontiguousarray asfortranarray atleast_1d atleast_2d atleast_3d broadcast_arrays broadcast_to can_cast clip
    column_stack common_type compress concatenate copy copyto count_nonzero delete diag diagonal dstack empty
    empty_like expand_dims eye finfo flatnonzero flip fliplr flipud frombuffer fromiter full full_like
    get_array_wrap hsplit hstack identity insert iscomplexobj isrealobj isscalar ix_ max may_share_memory min
    moveaxis ndim nonzero normalize_axis_index normalize_axis_tuple ones ones_like put ravel ravel_multi_index
    repeat reshape result_type roll rollaxis row_stack searchsorted shape shares_memory size sort split squeeze
    stack swapaxes take tile transpose tril triu unique unravel_index vsplit vstack where wrap zeros zeros_like
    """
)
"""Functions of NumPy that compute nothing."""

OPERATORS: Mapping[str, tuple[Callable[[Any, Any], Any], str]] = {
    name: (getattr(operator, name), kind)
    for name, kind in {
        "add": "add",
        "sub": "add",
        "mul": "multiply",
        "truediv": "divide",
        "floordiv": "divide",
        "mod": "divide",
        "pow": "",
        "matmul": "",
        "and_": "",
        "or_": "",
        "xor": "",
        "lshift": "",
        "rshift": "",
    }.items()
}
"""Binary operators: the function, and the kind of operation on floating-point numbers."""

FREE_MATH = _words(
    """
    ceil comb copysign fabs factorial floor frexp gcd isclose isfinite isinf isnan isqrt lcm nextafter perm trunc
    ulp
    """
)
"""Functions of `math` that are no operations on floating-point numbers."""
