"""The KR 30 HA report's planar model, done right: two links in one vertical plane, joints parallel, masses half-way."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from lwr_dyn.symbolic.lagrangian import EquationsOfMotion, euler_lagrange
from lwr_dyn.symbolic.link_motion import SymbolicBody, Variables, link_of_matrix
from lwr_dyn.symbolic.trigonometry import normal_form

L1, L2, G0 = sp.symbols("l1 l2 g0")
ALONG_X = sp.Matrix([-G0, 0, 0])
"""Gravity of the model: the printed heights l cos(theta) are x of the frame in which the printed v_1 is a speed."""


def planar_equations() -> EquationsOfMotion:
    """The right equations of the report's own model: joints about z, links l1 and l2 along x, I_i about the centre."""
    links = []
    for i, length in enumerate((L1, L2), start=1):
        q = sp.Symbol(f"q{i}")
        c, s = sp.cos(q), sp.sin(q)
        pose = sp.Matrix([[c, -s, 0, length * c], [s, c, 0, length * s], [0, 0, 1, 0], [0, 0, 0, 1]])
        tensor = sp.diag(0, 0, sp.Symbol(f"I{i}"))
        body = SymbolicBody(sp.Symbol(f"m{i}"), sp.Matrix([-length / 2, 0, 0]), tensor)
        links.append(link_of_matrix(i, pose, q, body))
    return euler_lagrange(links, ALONG_X)


def finished(lagrangian: sp.Expr) -> sp.Matrix:
    """d/dt dL/d(dq_i) - dL/dq_i of a Lagrangian in q1, q2, carried out: (2, 1)."""
    x = Variables.of(sp.symbols("q1 q2"))
    rows = [x.derivative(lagrangian.diff(dq)) - lagrangian.diff(q) for q, dq in zip(x.q, x.dq, strict=True)]
    return normal_form(sp.Matrix(rows), x.q)


@dataclass(frozen=True, slots=True, eq=False)
class Counterpart:
    """One quantity of the planar model beside the arm's, after l1/2 -> a1 + c1x, l2/2 -> a2 + c2x, I -> I1yy, I2zz."""

    name: str
    planar: sp.Expr
    arm: sp.Expr
    why: str
    """Why they differ; empty where they are the same."""


WHY = {
    "B_11": "square axes: link 2 goes round axis 1 at a1 + (a2 + c2x) cos(q2), and its tensor tilts",
    "B_12": "square axes do not couple: only what is off the plane of symmetry would",
    "B_22": "",
    "C_11": "follows from B_11",
    "C_12": "follows from B_11 and B_12",
    "C_21": "follows from B_11",
    "C_22": "",
    "g_1": "axis 1 is vertical: no weight turns it",
    "g_2": "the elevation of link 2 is -q2 alone, counted from the horizontal",
    "omega_2.omega_2": "the speeds of square axes add as squares, those of parallel ones as numbers",
}
"""What makes a quantity of the planar model another one than the arm's."""


def counterparts(arm: EquationsOfMotion) -> tuple[Counterpart, ...]:
    """Every entry of B, C, g of the (right) planar model against those of the arm's first two joints."""
    planar = planar_equations()
    a1, a2, c1x, c2x, I1yy, I2zz = sp.symbols("a1 a2 c1x c2x I1yy I2zz")
    letters = {L1: 2 * (a1 + c1x), L2: 2 * (a2 + c2x), sp.Symbol("I1"): I1yy, sp.Symbol("I2"): I2zz}
    out = []
    for name, (model, real) in _pairs(planar, arm).items():
        ours, theirs = (normal_form(e, arm.variables.q) for e in (real, model.subs(letters, simultaneous=True)))
        out.append(Counterpart(name, model, real, "" if ours == theirs else WHY[name]))
    return tuple(out)


def _pairs(planar: EquationsOfMotion, arm: EquationsOfMotion) -> dict[str, tuple[sp.Expr, sp.Expr]]:
    cells = [(i, j) for i in range(2) for j in range(2)]
    pairs = {f"B_{i + 1}{j + 1}": (planar.B[i, j], arm.B[i, j]) for i, j in cells if i <= j}
    pairs |= {f"C_{i + 1}{j + 1}": (planar.C[i, j], arm.C[i, j]) for i, j in cells}
    pairs |= {f"g_{i + 1}": (planar.g[i], arm.g[i]) for i in range(2)}
    spins = [normal_form(e.motions[1].omega.dot(e.motions[1].omega), e.variables.q) for e in (planar, arm)]
    return pairs | {"omega_2.omega_2": (spins[0], spins[1])}
