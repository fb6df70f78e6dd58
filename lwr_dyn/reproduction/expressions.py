"""Printed expressions compared by value: both sides at the same arbitrary values of their letters.

Two expressions of sines, products and sums that agree at points drawn at random agree everywhere, but for chance: at
two points to 1e-9 that is none. Nothing is ever executed but arithmetic.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache

import sympy as sp

from lwr_dyn.errors import OptionError
from lwr_dyn.reproduction.case import ComparedExpression

SAME = 1e-9
_OPERATORS: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}  # fmt: skip
_FUNCTIONS: dict[str, Callable[[float], float]] = {"cos": math.cos, "sin": math.sin, "sqrt": math.sqrt}


@lru_cache(maxsize=4096)
def value_of(text: str, draw: int) -> float:
    """An expression at the values of its letters of one draw; C1 and S1 are cosine and sine of q1.

    Raises
    ------
    OptionError
        Anything but numbers, letters, + - * / **, cos, sin and sqrt.

    >>> round(value_of("cos(q1)**2 + S1**2", 0), 12)
    1.0
    """
    try:
        return _value(ast.parse(text, mode="eval").body, draw)
    except SyntaxError:
        raise OptionError("expression", repr(text), "an expression such as -a1*C1 or cos(q1)") from None


def _value(node: ast.expr, draw: int) -> float:
    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return _letter(name, draw)
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            return -_value(inner, draw)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_value(left, draw), _value(right, draw))
        case ast.Call(func=ast.Name(id=name), args=[inner], keywords=[]) if name in _FUNCTIONS:
            return _FUNCTIONS[name](_value(inner, draw))
    raise OptionError("expression", ast.unparse(node), "numbers, letters, + - * / **, cos, sin, sqrt")


def _letter(name: str, draw: int) -> float:
    """The value of a letter: any, but always the same one; pi is itself, C3 and S3 belong to q3."""
    if name == "pi":
        return math.pi
    if name[0] in "CS" and name[1:].isdigit():
        angle = _letter(f"q{name[1:]}", draw)
        return math.cos(angle) if name[0] == "C" else math.sin(angle)
    seed = sum((k + 3) * ord(c) for k, c in enumerate(name)) + 101 * draw
    return 0.5 + (seed * 0.6180339887498949) % 1.0


def same(printed: str, ours: str) -> bool:
    """Both expressions have one value at two draws of their letters."""
    return all(abs(value_of(printed, k) - value_of(ours, k)) <= SAME for k in (0, 1))


def compared(printed: Iterable[Sequence[str]], ours: sp.Matrix) -> list[list[ComparedExpression]]:
    """A printed matrix of expressions beside ours, entry by entry."""
    texts = [[str(ours[r, c]) for c in range(ours.cols)] for r in range(ours.rows)]
    rows = zip(printed, texts, strict=True)
    return [[ComparedExpression(t, same(p, t)) for p, t in zip(row, text, strict=True)] for row, text in rows]
