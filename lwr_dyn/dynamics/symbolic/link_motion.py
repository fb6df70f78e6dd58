"""Motion in symbols: DH matrices, velocities and accelerations of the links, and one normal form of expressions.

From the matrices T_{i-1,i}(q_i), frame by frame:

omega_i = R^T omega_{i-1} + axis_i dq_i
v_i     = R^T (v_{i-1} + omega_{i-1} x p + dp/dq_i dq_i)        v_Ci = v_i + omega_i x c_i
domega_i = d(omega_i)/dt        a_Ci = d(v_Ci)/dt + omega_i x v_Ci

In normal form equal trigonometric expressions are identical: sin(q_i)^2 is replaced by 1 - cos(q_i)^2 and products are
expanded. Monomials in cosines and sines, at most linear in each sine, are linearly independent functions, so an
expression is zero exactly when its form is 0.

A position of a DH table goes by two routes, with the operations of each. One route multiplies all matrices, then the
vector; the other multiplies matrices into the vector from the tip inward. Both give the same expression, with very
different numbers of operations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
from sympy.simplify.fu import TR8

from lwr_dyn.arms.papers.assembly import require_plain_dh
from lwr_dyn.arms.papers.schema import Column, Paper
from lwr_dyn.model.chain import Convention, JointKind
from lwr_dyn.model.spatial import SNAP

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
    return min([sp.Add(*terms), together], key=_written_length)


@lru_cache(maxsize=4096)
def _shortest(expression: sp.Expr) -> sp.Expr:
    if expression.is_Add and expression.could_extract_minus_sign():
        return sp.Mul(-1, _shortest(-expression))  # B_12 and C_21 of opposite signs share the work
    forms = [expression]
    if expression.has(sp.sin, sp.cos):
        in_sines = expression.replace(lambda e: e.is_Pow and e.base.func is sp.cos, _cosines_as_sines)
        forms += [sp.expand(in_sines), sp.expand(TR8(expression))]
    candidates = [f for form in forms for f in (form, _factored(form))]
    return min((_gathered(e) for e in candidates), key=_written_length)


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
        return min([whole, sp.collect(whole, waves, _factored)], key=_written_length)

    return expression.replace(sp.Add, gather)


def _written_length(expression: sp.Expr) -> tuple[int, int]:
    return sp.count_ops(expression), len(str(expression))


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
        a, d = (_length_symbol(paper.columns[f"dh.{x}"], x, i) for x in ("a", "d"))
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
    return {x: tuple(_length_symbol(column, x, i) for i in range(paper.n)) for x, column in columns.items()}


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


def _length_symbol(column: Column, letter: str, i: int) -> sp.Expr:
    """A symbol for a length that is not zero."""
    if column.values[i] == 0.0:
        return sp.Integer(0)
    return sp.Symbol(column.symbols[i] if column.symbols and column.symbols[i] else f"{letter}{i + 1}")


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicBody:
    """A rigid body in its link's frame: mass, com (3, 1), inertia_com (3, 3) about the centre of mass."""

    mass: sp.Expr
    com: sp.Matrix
    inertia_com: sp.Matrix


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicLink:
    """Link `number` of its arm (from 1): T_{i-1,i}(q_i), body and rotor; `joint` is None for a fixed link.

    `axis` (3, 1) is the axis of a turning joint in the link's own frame; zero for a sliding joint.
    """

    number: int
    pose: sp.Matrix
    joint: sp.Symbol | None
    axis: sp.Matrix
    body: SymbolicBody | None = None
    armature: sp.Expr = sp.S.Zero


@dataclass(frozen=True, slots=True, eq=False)
class Variables:
    """Joint variables with their derivatives as plain symbols: q1, dq1, ddq1."""

    q: tuple[sp.Symbol, ...]
    dq: tuple[sp.Symbol, ...]
    ddq: tuple[sp.Symbol, ...]

    @classmethod
    def of(cls, q: Sequence[sp.Symbol]) -> Variables:
        """The derivatives of q named after it."""
        dq, ddq = (tuple(sp.Symbol(f"{d}{x.name}") for x in q) for d in ("d", "dd"))
        return cls(tuple(q), dq, ddq)

    def derivative(self, expression: Any) -> Any:
        """d/dt of an expression or matrix in q and dq.

        >>> x = Variables.of([sp.Symbol("q")])
        >>> x.derivative(x.q[0] ** 2 * x.dq[0])
        ddq*q**2 + 2*dq**2*q
        """
        both = (*zip(self.q, self.dq, strict=True), *zip(self.dq, self.ddq, strict=True))
        zero = expression * 0
        return sum((sp.diff(expression, x) * rate for x, rate in both), zero)


@dataclass(frozen=True, slots=True, eq=False)
class LinkMotion:
    """A link in motion, vectors (3, 1) in its own frame; `pose` (4, 4) is that frame in the base.

    `velocity` and `acceleration` are those of the centre of mass (of the frame's origin where there is no body).
    """

    number: int
    pose: sp.Matrix
    com: sp.Matrix
    omega: sp.Matrix
    domega: sp.Matrix
    velocity: sp.Matrix
    acceleration: sp.Matrix

    def position_in_base(self) -> sp.Matrix:
        """The centre of mass in the base frame, (3, 1)."""
        return self.pose[:3, :3] * self.com + self.pose[:3, 3]

    def in_base(self, vector: sp.Matrix, q: Sequence[sp.Symbol]) -> sp.Matrix:
        """A vector of this record in base axes, in normal form."""
        return normal_form(self.pose[:3, :3] * vector, q)


def link_of_matrix(
    number: int, pose: sp.Matrix, joint: sp.Symbol, body: SymbolicBody | None = None, armature: Any = sp.S.Zero
) -> SymbolicLink:
    """A link from its matrix alone: the axis is read from the skew matrix R^T dR/dq."""
    R = pose[:3, :3]
    turn = normal_form(R.T * R.diff(joint), [joint])
    return SymbolicLink(number, pose, joint, sp.Matrix([turn[2, 1], turn[0, 2], turn[1, 0]]), body, armature)


def link_motions(links: Sequence[SymbolicLink], variables: Variables) -> tuple[LinkMotion, ...]:
    """The motion of every link, from the base outward (Siciliano eqs. 3.25, 3.26, 7.99, 7.100 in symbols)."""
    q = variables.q
    rates = dict(zip(q, variables.dq, strict=True))
    pose, omega, v = sp.eye(4), sp.zeros(3, 1), sp.zeros(3, 1)
    out = []
    for link in links:
        R, p = link.pose[:3, :3], link.pose[:3, 3]
        v, omega = v + omega.cross(p), R.T * omega
        if link.joint is not None:
            v, omega = v + p.diff(link.joint) * rates[link.joint], omega + link.axis * rates[link.joint]
        v, omega = normal_form(R.T * v, q), normal_form(omega, q)
        pose = normal_form(pose * link.pose, q)
        com = sp.zeros(3, 1) if link.body is None else link.body.com
        velocity = normal_form(v + omega.cross(com), q)
        acceleration = normal_form(variables.derivative(velocity) + omega.cross(velocity), q)
        domega = normal_form(variables.derivative(omega), q)
        out.append(LinkMotion(link.number, pose, com, omega, domega, velocity, acceleration))
    return tuple(out)
