"""Printed expressions compared by value: both sides at the same arbitrary values of their symbols.

Two expressions of sines, products and sums that agree at two random points to 1e-9 agree everywhere: the chance of
another case is negligible. Only arithmetic is evaluated, never code.
"""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache

import sympy as sp

from lwr_dyn.checks.tables import arithmetic
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.reproduction.case import ComparedExpression

SAME = 1e-9
LONGEST = 100_000
"""Characters of an expression: matrix entries are long."""
FUNCTIONS = ("cos", "sin", "sqrt")


@lru_cache(maxsize=4096)
def value_of(text: str, draw: int) -> float:
    """An expression at one draw of its symbols' values; C1 and S1 are cosine and sine of q1.

    Raises
    ------
    OptionError
        Anything but numbers, symbols, + - * / **, cos, sin and sqrt, or an expression without a value.

    >>> round(value_of("cos(q1)**2 + S1**2", 0), 12)
    1.0
    """
    tree = arithmetic.parsed(text, LONGEST, FUNCTIONS)
    names = list(arithmetic.names_in(tree)) if tree else []
    value = arithmetic.value_of(tree, {name: _letter(name, draw) for name in names})
    if math.isnan(value) or any("." in name for name in names):
        raise OptionError("expression", repr(text), "numbers, letters, + - * / **, cos, sin, sqrt: -a1*C1 or cos(q1)")
    return value


def _letter(name: str, draw: int) -> float:
    """The value of a symbol: arbitrary, but always the same one; pi is itself, C3 and S3 belong to q3."""
    if name == "pi":
        return math.pi
    if name[0] in "CS" and name[1:].isdigit():
        angle = _letter(f"q{name[1:]}", draw)
        return math.cos(angle) if name[0] == "C" else math.sin(angle)
    seed = sum((k + 3) * ord(c) for k, c in enumerate(name)) + 101 * draw
    return 0.5 + (seed * 0.6180339887498949) % 1.0


def same(printed: str, ours: str) -> bool:
    """Both expressions have one value at two draws of their symbols."""
    return all(abs(value_of(printed, k) - value_of(ours, k)) <= SAME for k in (0, 1))


def compared(printed: Iterable[Sequence[str]], ours: sp.Matrix) -> list[list[ComparedExpression]]:
    """A printed matrix of expressions beside ours, entry by entry."""
    texts = [[str(ours[r, c]) for c in range(ours.cols)] for r in range(ours.rows)]
    rows = zip(printed, texts, strict=True)
    return [[ComparedExpression(t, same(p, t)) for p, t in zip(row, text, strict=True)] for row, text in rows]
