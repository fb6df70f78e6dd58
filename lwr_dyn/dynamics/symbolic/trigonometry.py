"""Normal form of trigonometric expressions, in which equal expressions are identical, and a short form to read.

In normal form sin(q_i)^2 is replaced by 1 - cos(q_i)^2 and products are expanded. Monomials in cosines and sines, at
most linear in each sine, are linearly independent functions, so an expression is zero exactly when its form is 0.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import sympy as sp
from sympy.simplify.fu import TR8

FACTORED = 12
"""Longest sum [terms] that is factored."""


def normal_form(expression: Any, angles: Sequence[sp.Symbol]) -> Any:
    """An expression, or each entry of a matrix, as a polynomial in cos and sin of `angles`.

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


def readable(expression: Any, rates: Sequence[sp.Symbol], weights: Iterable[sp.Symbol]) -> Any:
    """The same expression sorted for reading: first by products of `rates`, then by the linear `weights`.

    Rates are joint speeds and accelerations, weights masses and moments; each factor is written in its shortest form.

    >>> m, a, q, dq = sp.symbols("m a q dq")
    >>> readable(m * dq**2 * (a**2 * sp.cos(q) ** 2 + 2 * a * sp.cos(q) + 1), [dq], [m])
    dq**2*m*(a*cos(q) + 1)**2
    """
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda entry: readable(entry, rates, weights))
    return sp.Add(*terms_of(expression, rates, weights))


def terms_of(expression: sp.Expr, rates: Sequence[sp.Symbol], weights: Iterable[sp.Symbol]) -> list[sp.Expr]:
    """The terms of `readable`: one per product of rates, each with its whole coefficient."""
    moving = [s for s in rates if expression.has(s)]
    if not moving:
        return [_by_weight(expression, tuple(weights))]
    polynomial = sp.Poly(expression, *moving)
    products = [(sp.Mul(*map(sp.Pow, moving, powers)), c) for powers, c in polynomial.terms()]
    return [sp.Mul(product, _by_weight(c, tuple(weights))) for product, c in products]


@lru_cache(maxsize=4096)
def _by_weight(expression: sp.Expr, weights: tuple[sp.Symbol, ...]) -> sp.Expr:
    symbols = [s for s in weights if expression.has(s)]
    parts = sp.collect(sp.expand(expression), symbols, evaluate=False)
    terms = [sp.Mul(symbol, _shortest(factor)) for symbol, factor in parts.items()]
    together = _shortest(expression)
    return min([sp.Add(*terms), together], key=_length)


@lru_cache(maxsize=4096)
def _shortest(expression: sp.Expr) -> sp.Expr:
    if expression.is_Add and expression.could_extract_minus_sign():
        return sp.Mul(-1, _shortest(-expression))  # B_12 and C_21 of opposite signs share the work
    forms = [expression]
    if expression.has(sp.sin, sp.cos):
        in_sines = expression.replace(lambda e: e.is_Pow and e.base.func is sp.cos, _cosines_as_sines)
        forms += [sp.expand(in_sines), sp.expand(TR8(expression))]
    candidates = [f for form in forms for f in (form, _factored(form))]
    return min((_gathered(e) for e in candidates), key=_length)


def _factored(expression: sp.Expr) -> sp.Expr:
    """The expression factored if it is short: a long sum in many symbols can take minutes and rarely has a factor."""
    return sp.factor(expression) if len(sp.Add.make_args(expression)) <= FACTORED else expression


def _cosines_as_sines(power: sp.Expr) -> sp.Expr:
    """cos(q)^k with sin(q)^2 for every pair."""
    angle, pairs, one = power.base.args[0], power.exp // 2, power.exp % 2
    return (1 - sp.sin(angle) ** 2) ** pairs * sp.cos(angle) ** one


def _gathered(expression: sp.Expr) -> sp.Expr:
    """The expression with the terms of one sine or cosine collected: a cos(q) + b cos(q) = (a + b) cos(q)."""

    def gather(*terms: sp.Expr) -> sp.Expr:
        whole = sp.Add(*terms)
        waves = sorted(whole.atoms(sp.sin, sp.cos), key=str)
        return min([whole, sp.collect(whole, waves, _factored)], key=_length)

    return expression.replace(sp.Add, gather)


def _length(expression: sp.Expr) -> tuple[int, int]:
    return sp.count_ops(expression), len(str(expression))
