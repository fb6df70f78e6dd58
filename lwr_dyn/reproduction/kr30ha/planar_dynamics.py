"""The KR 30 HA report's dynamic analysis, expression by expression: printed, right, and every slip between them named.

The right expressions are those of the report's own planar model, derived here; what that model has to do with the arm
is another question (`kr30ha_planar.counterparts`). printed = right + the sum of the named slips, or a verdict says no.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import open_paper
from lwr_dyn.reproduction.kr30ha.planar_model import Counterpart, counterparts, finished, planar_equations
from lwr_dyn.reproduction.results import printed_tables
from lwr_dyn.symbolic.arm_equations import ArmEquations, equations_of_motion
from lwr_dyn.symbolic.lagrangian import EquationsOfMotion
from lwr_dyn.symbolic.trigonometry import normal_form

FIRST_TWO = ("A1", "A2")


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """A printed expression (or vector), the right one, and the errata that make up the difference."""

    name: str
    where: str
    printed: sp.Matrix
    right: sp.Matrix
    slips: Mapping[str, sp.Matrix]
    """Erratum -> what it adds to the right expression."""

    @property
    def difference(self) -> sp.Matrix:
        """Printed - right, in normal form."""
        return normal_form(self.printed - self.right, sp.symbols("q1 q2"))

    @property
    def agrees(self) -> bool:
        """Nothing is wrong with it."""
        return bool(self.difference.is_zero_matrix)

    @property
    def explained(self) -> bool:
        """The named slips make up the whole difference, and there are none where there is none."""
        rest = normal_form(self.difference - sum(self.slips.values(), 0 * self.right), sp.symbols("q1 q2"))
        return bool(rest.is_zero_matrix) and self.agrees == (not self.slips)

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        words = {"name": self.name, "where": self.where, "agrees": self.agrees, "errata": list(self.slips)}
        return words | {"explained": self.explained, "difference": [str(x) for x in self.difference]}

    def terms(self) -> list[tuple[str, sp.Expr, sp.Expr]]:
        """Term by term: the product of speeds, its coefficient as printed and right; scalars only."""
        rates = sp.symbols("dq1 dq2")
        pair = [sp.Poly(normal_form(e[0], sp.symbols("q1 q2")), *rates).as_dict() for e in (self.printed, self.right)]
        powers = sorted({*pair[0], *pair[1]}, reverse=True)
        return [(str(rates[0] ** i * rates[1] ** j), *(p.get((i, j), sp.S.Zero) for p in pair)) for i, j in powers]


@dataclass(frozen=True, slots=True, eq=False)
class MotionReport:
    """Everything about the report's equations of motion."""

    general: ArmEquations
    """The first two joints of the arm with all ten letters a link."""
    symmetric: ArmEquations
    """The same without what mirror symmetry makes zero."""
    planar: EquationsOfMotion
    comparisons: tuple[Comparison, ...]
    printed_torques: sp.Matrix
    """The report's Lagrangian carried to the end, (2, 1)."""
    counterparts: tuple[Counterpart, ...]

    @property
    def holds(self) -> bool:
        """Every printed expression is right, or its slips are named and make up all of the difference."""
        return all(c.explained for c in self.comparisons)


def motion_report() -> MotionReport:
    """Derive the equations of the first two joints, and compare what the report prints."""
    paper = open_paper("kr30ha")
    arm = arm_from_paper(paper)
    general, symmetric = (equations_of_motion(arm, FIRST_TWO, None, paper, zeros) for zeros in (False, True))
    planar = planar_equations()
    found = comparisons(planar)
    lagrangian = next(c for c in found if c.name == "L").printed[0]
    return MotionReport(general, symmetric, planar, found, finished(lagrangian), counterparts(symmetric.equations))


def comparisons(planar: EquationsOfMotion) -> tuple[Comparison, ...]:
    """Every printed expression of the dynamic analysis against the planar model done right."""
    rights = _right_expressions(planar)
    out = []
    for row in printed_tables("kr30ha", "motion")["expression"]:
        right = rights[row.get("of", row["name"])]
        if row.get("point_masses"):
            right = right.subs({"I1": 0, "I2": 0})
        slips = {slip["erratum"]: _read(slip["adds"], rights) for slip in row["slips"]}
        out.append(Comparison(row["name"], row["where"], _read(row["printed"], rights), right, slips))
    return tuple(out)


def _right_expressions(planar: EquationsOfMotion) -> dict[str, sp.Matrix]:
    x = planar.variables
    v = [m.in_base(m.velocity, x.q) for m in planar.motions]
    shares = {f"v_2, share of {dq}": v[1].diff(dq) for dq in x.dq}
    scalars = {f"K_{i}": K for i, K in planar.kinetic_of_links.items()}
    scalars |= {f"P_{i}": U for i, U in planar.potential_of_links.items()}
    scalars |= {"K_TOTAL": planar.kinetic, "L": planar.lagrangian}
    return {"v_1": v[0], **shares, **{name: sp.Matrix([e]) for name, e in scalars.items()}}


def _read(text: Any, rights: Mapping[str, sp.Matrix]) -> sp.Matrix:
    """An expression of the data file; K_1 and K_2 stand for the right ones, I1 and the like are letters."""
    letters = {name: sp.Symbol(name) for name in ("I1", "I2", "m1", "m2", "l1", "l2", "g0")}
    known = letters | {name: rights[name][0] for name in ("K_1", "K_2")}
    return sp.Matrix([sp.sympify(x, known) for x in (text if isinstance(text, list) else [text])])
