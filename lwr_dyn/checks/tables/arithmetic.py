"""Formulas as text, evaluated safely: numbers, names, + - * / ^ and some functions, nothing else."""

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Container, Iterator, Mapping

LONGEST = 200
"""Characters of a formula."""
LARGEST_POWER = 20.0
FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt, "hypot": math.hypot, "abs": abs, "exp": math.exp, "log": math.log,
    "sin": math.sin, "cos": math.cos, "tan": math.tan,
    "asin": math.asin, "acos": math.acos, "atan": math.atan, "atan2": math.atan2,
}  # fmt: skip
"""What may be called, angles in radians."""
TAKES_ANGLE = ("sin", "cos", "tan")
GIVES_ANGLE = ("asin", "acos", "atan", "atan2")
_OPERATORS: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_SIGNS = str.maketrans({"\N{MINUS SIGN}": "-", "\N{MULTIPLICATION SIGN}": "*", "\N{MIDDLE DOT}": "*"})


def parsed(text: str, longest: int = LONGEST, functions: Container[str] = FUNCTIONS) -> ast.expr | None:
    """The formula as a syntax tree; None where the text is no formula or is too long.

    >>> value_of(parsed("1/2 x 0.0106 x 0.05^2"), {})
    1.3250000000000002e-05
    >>> parsed("__import__('os')") is None
    True
    """
    bare = re.sub(r"(?<=[\d)\s])[xX](?=[\d(\s])", "*", text.translate(_SIGNS)).replace("^", "**").strip()
    if not bare or len(bare) > longest:
        return None
    try:
        with warnings.catch_warnings():  # "2or 3" makes the parser complain on stderr
            warnings.simplefilter("ignore")
            tree = ast.parse(bare, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    return tree if _known(tree, functions) else None


def _known(node: ast.expr, functions: Container[str]) -> bool:
    """Only what `value_of` can compute."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.BinOp):
        known = isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div | ast.Pow)
        return known and _known(node.left, functions) and _known(node.right, functions)
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.UAdd | ast.USub) and _known(node.operand, functions)
    if isinstance(node, ast.Call):
        named = isinstance(node.func, ast.Name) and node.func.id in functions and not node.keywords
        return named and all(_known(a, functions) for a in node.args)
    return name_of(node) is not None


def name_of(node: ast.expr) -> str | None:
    """The dotted name that a node is, such as "table_iv.b"."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        left = name_of(node.value)
        return None if left is None else f"{left}.{node.attr}"
    return None


def names_in(node: ast.expr) -> Iterator[str]:
    """The names a formula needs, functions left out."""
    name = name_of(node)
    if name is not None:
        yield name
    elif isinstance(node, ast.BinOp):
        yield from (*names_in(node.left), *names_in(node.right))
    elif isinstance(node, ast.UnaryOp):
        yield from names_in(node.operand)
    elif isinstance(node, ast.Call):
        for argument in node.args:
            yield from names_in(argument)


def value_of(node: ast.expr | None, names: Mapping[str, float], degrees: bool = False) -> float:
    """The value of a formula; NaN for a division by zero, the root of a negative number or an unknown name."""
    try:
        value = _value(node, names, degrees)
        return value if isinstance(value, float | int) and math.isfinite(value) else math.nan
    except (ArithmeticError, ValueError, TypeError, RecursionError, KeyError):
        return math.nan


def _value(node: ast.expr | None, names: Mapping[str, float], degrees: bool) -> float:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type] # `_known` let only numbers pass
    if isinstance(node, ast.UnaryOp):
        inner = _value(node.operand, names, degrees)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp):
        left, right = _value(node.left, names, degrees), _value(node.right, names, degrees)
        if isinstance(node.op, ast.Pow):
            return float(left**right) if abs(right) <= LARGEST_POWER else math.nan
        return _OPERATORS[type(node.op)](left, right)
    if isinstance(node, ast.Call):
        return _call(node, names, degrees)
    return names[name_of(node) or ""] if node is not None else math.nan


def _call(node: ast.Call, names: Mapping[str, float], degrees: bool) -> float:
    name = name_of(node.func) or ""
    values = [_value(a, names, degrees) for a in node.args]
    if degrees and name in TAKES_ANGLE:
        values = [math.radians(v) for v in values]
    out = FUNCTIONS[name](*values)
    return math.degrees(out) if degrees and name in GIVES_ANGLE else float(out)
