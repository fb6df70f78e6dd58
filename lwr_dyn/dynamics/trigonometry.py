"""One form for each trigonometric expression, so that equal expressions are equal text, and a short form to read.

sin(q_i)^2 is 1 - cos(q_i)^2 everywhere and products are multiplied out: polynomials in the cosines and sines of the
angles, at most linear in each sine, are independent functions, so an expression is zero exactly when its form is 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import sympy as sp


def normal_form(expression: Any, angles: Sequence[sp.Symbol]) -> Any:
    """An expression, or each entry of a matrix, as the one polynomial it is in cos and sin of `angles`.

    >>> q = sp.Symbol("q")
    >>> normal_form(sp.sin(q) ** 2 + sp.cos(q) ** 2, [q])
    1
    >>> normal_form(sp.cos(2 * q), [q])
    2*cos(q)**2 - 1
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda entry: normal_form(entry, angles))
    present = [q for q in angles if expression.has(q)]
    flat = sp.expand(sp.expand_trig(expression))
    if not present:
        return flat
    letters = {q: (sp.Dummy("s"), sp.Dummy("c")) for q in present}
    known = {f(q): letter for q, pair in letters.items() for f, letter in zip((sp.sin, sp.cos), pair, strict=True)}
    polynomial = sp.Poly(flat.xreplace(known), *(x for pair in letters.values() for x in pair))
    total = sp.Integer(0)
    for powers, coefficient in polynomial.terms():
        term = coefficient
        for i, q in enumerate(present):
            of_sine, of_cosine = powers[2 * i], powers[2 * i + 1]
            term *= sp.sin(q) ** (of_sine % 2) * sp.cos(q) ** of_cosine * (1 - sp.cos(q) ** 2) ** (of_sine // 2)
        total += term
    return sp.expand(total)


def readable(expression: Any, linear_in: Iterable[sp.Symbol]) -> Any:
    """The same expression sorted by symbols it is linear in (masses, moments), each factor as short as it gets.

    >>> m, a, q = sp.symbols("m a q")
    >>> readable(m * a**2 * sp.cos(q) ** 2 + 2 * m * a * sp.cos(q) + m, [m])
    m*(a*cos(q) + 1)**2
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda entry: readable(entry, linear_in))
    symbols = [s for s in linear_in if expression.has(s)]
    parts = sp.collect(sp.expand(expression), symbols, evaluate=False)
    return sum((symbol * _shortest(factor) for symbol, factor in parts.items()), sp.Integer(0))


def _shortest(expression: Any) -> Any:
    candidates = [expression, sp.factor(expression)]
    if expression.has(sp.sin, sp.cos):
        folded = sp.trigsimp(expression)
        candidates += [folded, sp.factor(folded)]
    return min(candidates, key=lambda e: (sp.count_ops(e), len(str(e))))
