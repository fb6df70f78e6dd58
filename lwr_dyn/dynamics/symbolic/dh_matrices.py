"""A DH table in symbols: the matrices A_i, and a position by two routes with the operations of each.

One route multiplies all matrices, then the vector; the other multiplies matrices into the vector from the tip inward.
Both give the same expression, with very different numbers of operations.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.assembly import require_plain_dh
from lwr_dyn.arms.papers.schema import Column, Paper
from lwr_dyn.model.dh import Convention, JointKind
from lwr_dyn.model.spatial import SNAP


@dataclass(frozen=True, slots=True)
class SymbolicRoute:
    """An expression and the scalar operations that it took (terms with 0, factors of +-1 cost nothing)."""

    value: sp.Matrix
    multiplications: int
    additions: int


def dh_matrices(paper: Paper) -> tuple[sp.Matrix, ...]:
    """A_1 ... A_n of a paper's DH table: joint variables q1 ... qn, non-zero lengths as the paper names them."""
    require_plain_dh(paper, "DH matrices")
    out = []
    for i in range(paper.n):
        q = sp.Symbol(f"q{i + 1}")
        theta = _angle(paper.columns.get("dh.theta_offset"), i)
        a, d = (_length(paper.columns[f"dh.{x}"], x, i) for x in ("a", "d"))
        alpha = _angle(paper.columns["dh.alpha"], i)
        sign = int(paper.columns["dh.sign"].values[i]) if "dh.sign" in paper.columns else 1
        if paper.kinds[i] is JointKind.REVOLUTE:
            theta = sign * q + theta
        else:
            d = sign * q + d
        out.append(_dh_matrix(paper.convention, theta, d, a, alpha))
    return tuple(out)


def length_letters(paper: Paper) -> dict[str, tuple[sp.Expr, ...]]:
    """The letters that `dh_matrices` uses for the columns a and d, one per row, 0 where the length is 0."""
    columns = {x: paper.columns[f"dh.{x}"] for x in ("a", "d")}
    return {x: tuple(_length(column, x, i) for i in range(paper.n)) for x, column in columns.items()}


def length_values(paper: Paper) -> dict[str, float]:
    """The numbers of those letters [m]."""
    letters = length_letters(paper)
    pairs = [pair for x in letters for pair in zip(letters[x], paper.columns[f"dh.{x}"].si(), strict=True)]
    return {letter.name: float(value) for letter, value in pairs if letter != 0}


def exact_angle(radians: float) -> sp.Expr:
    """A constant angle [rad]: exactly a multiple of 90 deg where it is one to rounding, else its decimal text.

    >>> exact_angle(np.pi / 2), exact_angle(0.3)
    (pi/2, 3/10)
    """
    quarter = round(radians / (np.pi / 2))
    if abs(radians - quarter * (np.pi / 2)) <= SNAP * max(1, abs(quarter)):
        return quarter * sp.pi / 2
    return sp.Rational(repr(float(radians)))


def full_product(matrices: Sequence[sp.Matrix], point: sp.Matrix) -> SymbolicRoute:
    """(A_1 A_2 ... A_n) p: matrix times matrix, then the vector."""
    product, times, plus = matrices[0], 0, 0
    for matrix in matrices[1:]:
        product, more_times, more_plus = _counted(product, matrix)
        times, plus = times + more_times, plus + more_plus
    value, more_times, more_plus = _counted(product, point)
    return SymbolicRoute(value, times + more_times, plus + more_plus)


def vector_route(matrices: Sequence[sp.Matrix], point: sp.Matrix) -> SymbolicRoute:
    """A_1 (A_2 (... (A_n p))): matrix times vector from the tip inward."""
    value, times, plus = point, 0, 0
    for matrix in reversed(matrices):
        value, more_times, more_plus = _counted(matrix, value)
        times, plus = times + more_times, plus + more_plus
    return SymbolicRoute(value, times, plus)


def _counted(left: sp.Matrix, right: sp.Matrix) -> tuple[sp.Matrix, int, int]:
    """A product with the operations it takes when zeros and ones are known."""
    times = plus = 0
    out = sp.zeros(left.rows, right.cols)
    for r in range(left.rows):
        for c in range(right.cols):
            pairs = [(left[r, k], right[k, c]) for k in range(left.cols)]
            pairs = [(x, y) for x, y in pairs if x != 0 and y != 0]
            times += sum(1 for x, y in pairs if abs(x) != 1 and abs(y) != 1)
            plus += max(len(pairs) - 1, 0)
            out[r, c] = sum((x * y for x, y in pairs), sp.Integer(0))
    return out, times, plus


def _dh_matrix(convention: Convention, theta: sp.Expr, d: sp.Expr, a: sp.Expr, alpha: sp.Expr) -> sp.Matrix:
    """Siciliano eq. 2.52, or Craig eq. 3.6."""
    c, s, ca, sa = sp.cos(theta), sp.sin(theta), sp.cos(alpha), sp.sin(alpha)
    if convention is Convention.STANDARD:
        return sp.Matrix([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    return sp.Matrix([[c, -s, 0, a], [s * ca, c * ca, -sa, -d * sa], [s * sa, c * sa, ca, d * ca], [0, 0, 0, 1]])


def dh_matrices_text(paper: Paper) -> str:
    """The matrices A_1 ... A_n and the position of the last frame's origin, by both routes, as text."""
    matrices, origin = dh_matrices(paper), sp.Matrix([0, 0, 0, 1])
    lines = [f"A{i} =\n{sp.pretty(matrix, use_unicode=False)}" for i, matrix in enumerate(matrices, start=1)]
    by_vectors = vector_route(matrices, origin)
    for name, route in (("full product", full_product(matrices, origin)), ("vector route", by_vectors)):
        cost = f"{route.multiplications} products, {route.additions} sums"
        lines.append(f"origin of frame {len(matrices)} by {name}: {cost}")
    for axis, expression in zip("xyz", by_vectors.value, strict=False):
        lines.append(f"  {axis} = {sp.factor_terms(sp.expand(expression))}")
    return "\n".join(lines)


def _angle(column: Column | None, i: int) -> sp.Expr:
    """A constant angle, exact in degrees."""
    if column is None:
        return sp.Integer(0)
    value = sp.nsimplify(column.values[i], rational=True)
    return value * sp.pi / 180 if column.unit[i] == "deg" else value


def _length(column: Column, letter: str, i: int) -> sp.Expr:
    """A symbol for a length that is not zero."""
    if column.values[i] == 0.0:
        return sp.Integer(0)
    return sp.Symbol(column.symbols[i] if column.symbols and column.symbols[i] else f"{letter}{i + 1}")
