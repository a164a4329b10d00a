"""Exactly given numbers: what a case file says, kept free of rounding until an arithmetic evaluates it.

A float means the binary64 it is; a string means what it says. The grammar of strings is small and safe:
decimal numbers, ``pi``, ``+ - * /``, parentheses, and ``sqrt``, ``sin``, ``cos`` of such expressions.
"""

from __future__ import annotations

import ast
import math
import re
import warnings
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from sinsref.arithmetic import Arithmetic, Number

GRAMMAR = "decimal numbers, pi, + - * /, parentheses, sqrt(), sin(), cos()"
_MAXIMUM_LENGTH = 200
#: A plain decimal. Three digits of exponent: a thousand times as many would fill the memory with one integer.
_DECIMAL = re.compile(r"-?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
#: The longest plain decimal that is read: the expansion of a binary64 has up to 767 digits.
_MAXIMUM_DIGITS = 800
_FUNCTIONS = ("sqrt", "sin", "cos")
_OPERATORS: dict[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


class ExpressionError(ValueError):
    """A text is not a number of the small grammar, or has no finite value."""


class ExactNumber:
    """A real number given exactly.

    Parameters
    ----------
    value : int, float, str, Fraction or ExactNumber
        A float stands for the binary64 it is. A string is an expression of the grammar in the module's
        docstring.

    Raises
    ------
    ExpressionError
        If the text is outside the grammar, or the value is not finite.

    Examples
    --------
    >>> ExactNumber("pi/18").text
    'pi/18'
    >>> ExactNumber("1/3 + 1/6").fraction
    Fraction(1, 2)
    >>> ExactNumber(0.1).text
    '0.1000000000000000055511151231257827021181583404541015625'
    """

    __slots__ = ("_tree", "text")

    def __init__(self, value: Exact) -> None:
        if isinstance(value, ExactNumber):
            self.text: str = value.text
            self._tree: Any = value._tree
            return
        if isinstance(value, str):
            self.text = value.strip()
            self._tree = parsed(self.text)
            self._check()
            return
        if isinstance(value, float):
            if not math.isfinite(value):
                raise ExpressionError(f"{value} is not a finite number")
            # The decimal expansion of a binary64 is finite: the text alone says exactly which number is
            # meant.
            self.text = str(int(value)) if value.is_integer() and abs(value) < 1e15 else str(Decimal(value))
            self._tree = Fraction(value)
            return
        self.text = str(value)
        self._tree = Fraction(value)

    def _check(self) -> None:
        from sinsref.pi_monomials import PiMonomialArithmetic

        # In the arithmetic that knows exact zeros: 1/sin(pi) is as inadmissible as 1/0, and a root of a
        # negative number or a quotient whose denominator may be zero is a ball without bounds.
        try:
            with PiMonomialArithmetic(256) as arithmetic:
                finite = math.isfinite(float(self.evaluate(arithmetic)))
        except (ZeroDivisionError, OverflowError):
            finite = False
        if not finite:
            raise ExpressionError(f"{self.text!r} has no finite real value")

    def evaluate(self, arithmetic: Arithmetic) -> Number:
        """Return the value as a number of `arithmetic`."""
        return evaluated(self._tree, arithmetic)

    @property
    def fraction(self) -> Fraction | None:
        """The value as a fraction, or None where it is not known to be rational."""
        from sinsref.pi_monomials import PiMonomial, PiMonomialArithmetic

        with PiMonomialArithmetic(64) as arithmetic:
            value = self.evaluate(arithmetic)
        return value.coefficient if isinstance(value, PiMonomial) and value.power == 0 else None

    def __float__(self) -> float:
        """Return the nearest binary64."""
        if isinstance(self._tree, Fraction):
            return float(self._tree)
        from sinsref.rounding import nearest_float

        return nearest_float(self.evaluate)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ExactNumber) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __repr__(self) -> str:
        return f"ExactNumber({self.text!r})"


#: What may be given for an exact number.
Exact: TypeAlias = int | float | str | Fraction | ExactNumber


def parsed(text: str, variable: str | None = None) -> Any:
    """Return the syntax tree of an expression: fractions, names, and tuples of an operator and its operands.

    Parameters
    ----------
    text : str
    variable : str, optional
        A name that the grammar admits besides.

    Raises
    ------
    ExpressionError
        If the text is outside the grammar.
    """
    if len(text) <= _MAXIMUM_DIGITS and _DECIMAL.fullmatch(text):
        return Fraction(text)
    if not text or len(text) > _MAXIMUM_LENGTH:
        raise ExpressionError(f"an expression has 1 to {_MAXIMUM_LENGTH} characters, not {len(text)}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)  # what is odd is refused below, in our own words
            body = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"cannot read {text!r}; admissible: {GRAMMAR}") from None
    return _reduce(body, text, variable)


def _reduce(node: ast.expr, text: str, variable: str | None) -> Any:
    """Reduce a syntax tree to nested tuples; numbers become fractions of their decimal text, never floats."""
    match node:
        case ast.Constant() if _DECIMAL.fullmatch(ast.get_source_segment(text, node) or ""):
            return Fraction(ast.get_source_segment(text, node) or "")
        case ast.Name(id=name) if name in ("pi", variable):
            return name
        case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
            operand = _reduce(node.operand, text, variable)
            return ("-", Fraction(0), operand) if isinstance(node.op, ast.USub) else operand
        case ast.BinOp() if symbol := _OPERATORS.get(type(node.op)):
            return (symbol, _reduce(node.left, text, variable), _reduce(node.right, text, variable))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _FUNCTIONS:
            return (name, _reduce(argument, text, variable))
    piece = ast.get_source_segment(text, node) or text
    raise ExpressionError(f"{piece!r} in {text!r} is outside the grammar; admissible: {GRAMMAR}")


def evaluated(tree: Any, arithmetic: Arithmetic, variable: Number = None) -> Number:
    """Return the value of a syntax tree (`parsed`) in an arithmetic, where the variable has a given value."""
    if isinstance(tree, Fraction):
        return arithmetic.number(tree)
    if isinstance(tree, str):
        return arithmetic.pi if tree == "pi" else variable
    operator, *operands = tree
    values = [evaluated(operand, arithmetic, variable) for operand in operands]
    match operator:
        case "+":
            return values[0] + values[1]
        case "-":
            return values[0] - values[1]
        case "*":
            return values[0] * values[1]
        case "/":
            return values[0] / values[1]
        case "sqrt":
            return arithmetic.sqrt(values[0])
        case "sin":
            return arithmetic.sin_cos(values[0])[0]
        case _:
            return arithmetic.sin_cos(values[0])[1]
