"""The KR 30 HA report's dynamic analysis, expression by expression: printed, right, and each erratum between them.

The right expressions are those of the report's own planar model: two links in one vertical plane, joints parallel,
masses half-way. printed = right + what the named errata add, or `Comparison.explained` is false. How the model differs
from the arm is another question, see `counterparts`.

The equations of an arm's joints, derived with letters, against Pinocchio on the reduced model: `symbolic_verdicts`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.assembly import arm_from_paper, dh_rows
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.arm.model_laws import ACCELERATION, SPEED, Verdict
from lwr_dyn.dynamics.pinocchio_engine import pinocchio_dynamics
from lwr_dyn.dynamics.symbolic import arm_equations
from lwr_dyn.dynamics.symbolic.arm_equations import EquationsOfMotion, equations_of_motion
from lwr_dyn.dynamics.symbolic.equation_forms import compile_equations
from lwr_dyn.dynamics.symbolic.link_motion import SymbolicBody, Variables, length_letters, link_of_matrix, normal_form
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain
from lwr_dyn.reproduction.case import PaperData, Proof, Prove
from lwr_dyn.reproduction.compare import same
from lwr_dyn.reproduction.papers import printed_tables

FIRST_TWO = ("A1", "A2")

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
    return arm_equations.euler_lagrange(links, ALONG_X)


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


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """A printed expression (or vector), the right one, and the errata that make up the difference."""

    name: str
    where: str
    printed: sp.Matrix
    right: sp.Matrix
    added: Mapping[str, sp.Matrix]
    """Erratum -> what it adds to the right expression."""

    @property
    def difference(self) -> sp.Matrix:
        """Printed - right, in normal form."""
        return normal_form(self.printed - self.right, sp.symbols("q1 q2"))

    @property
    def agrees(self) -> bool:
        """The printed expression is right."""
        return bool(self.difference.is_zero_matrix)

    @property
    def explained(self) -> bool:
        """The errata add up to the whole difference; without a difference there are none."""
        rest = normal_form(self.difference - sum(self.added.values(), 0 * self.right), sp.symbols("q1 q2"))
        return bool(rest.is_zero_matrix) and self.agrees == (not self.added)

    def follows_with(self, errata: Collection[str]) -> bool:
        """The printed expression is the right one and what these errata add."""
        rest = self.printed - self.right
        for matrix in (m for erratum, m in self.added.items() if erratum in errata):
            rest -= matrix
        return all(same(str(entry), "0") for entry in rest)

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        words = {"name": self.name, "where": self.where, "agrees": self.agrees, "errata": list(self.added)}
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

    general: arm_equations.ArmEquations
    """The first two joints of the arm with all ten letters a link."""
    symmetric: arm_equations.ArmEquations
    """The same without what mirror symmetry makes zero."""
    planar: EquationsOfMotion
    comparisons: tuple[Comparison, ...]
    printed_torques: sp.Matrix
    """The report's Lagrangian carried to the end, (2, 1)."""
    counterparts: tuple[Counterpart, ...]

    @property
    def holds(self) -> bool:
        """Every printed expression is right, or its errata add up to the difference."""
        return all(c.explained for c in self.comparisons)


def motion_report() -> MotionReport:
    """Derive the equations of the first two joints, and compare what the report prints."""
    paper = open_paper("kr30ha", "kuka")
    arm = arm_from_paper(paper)
    general, symmetric = (equations_of_motion(arm, FIRST_TWO, None, paper, zeros) for zeros in (False, True))
    planar = planar_equations()
    compared = comparisons(planar)
    lagrangian = next(c for c in compared if c.name == "L").printed[0]
    return MotionReport(general, symmetric, planar, compared, finished(lagrangian), counterparts(symmetric.equations))


def comparisons(planar: EquationsOfMotion) -> tuple[Comparison, ...]:
    """Every printed expression of the dynamic analysis against the planar model done right."""
    rights = _right_expressions(planar)
    out = []
    for row in printed_tables("kr30ha", "motion")["expression"]:
        right = rights[row.get("of", row["name"])]
        if row.get("point_masses"):
            right = right.subs({"I1": 0, "I2": 0})
        added = {erratum["erratum"]: _read(erratum["adds"], rights) for erratum in row["errors"]}
        out.append(Comparison(row["name"], row["where"], _read(row["printed"], rights), right, added))
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


SYMBOLIC = 1e-10
"""[kg m^2, N m s, N m] Largest difference allowed, of numbers up to some hundreds."""
QUANTITIES = {"mass_matrix": 1, "coriolis_matrix": 2, "gravity_vector": 1, "inverse_dynamics": 3}
"""Function -> the number of its arguments."""


def symbolic_verdicts(
    arm: Arm,
    paper: Paper,
    joints: Sequence[str],
    held: Mapping[str, float] | None = None,
    count: int = 100,
    seed: int = 20240607,
) -> tuple[Verdict, ...]:
    """B, C, g and tau from Euler-Lagrange less Pinocchio's, the largest over `count` random arms and states.

    Lengths, masses, centres of mass, tensors, joint states and the size of gravity are random each time; the arm has no
    rotors, and the equations are derived once. Raises as `equations_of_motion`.
    """
    bare = replace(arm, chain=replace(arm.chain, links=tuple(replace(x, rotor=None) for x in arm.chain.links)))
    derived = equations_of_motion(bare, joints, held, paper)
    compiled, rng = compile_equations(derived.equations), np.random.default_rng(seed)
    moving = [arm.joint_names.index(name) for name in joints]
    fixed = {arm.joint_names.index(name): value for name, value in (held or {}).items()}
    worst = dict.fromkeys(QUANTITIES, 0.0)
    for _ in range(count):
        chain, lengths = _random_chain(bare.chain, paper, rng)
        symbolic = compiled.at(arm_equations.symbol_values(chain) | lengths)
        engine = pinocchio_dynamics(arm_equations.reduced_arm(replace(bare, chain=chain), moving, fixed))
        q = rng.uniform(-np.pi, np.pi, len(moving))
        state = (q, rng.uniform(-SPEED, SPEED, q.size), rng.uniform(-ACCELERATION, ACCELERATION, q.size))
        for name, takes in QUANTITIES.items():
            difference = getattr(symbolic, name)(*state[:takes]) - getattr(engine, name)(*state[:takes])
            worst[name] = max(worst[name], float(np.abs(difference).max()))
    head = f"{', '.join(joints)}: Euler-Lagrange - Pinocchio, {count} random arms and states"
    residual = sum(1 for entry in derived.equations.residual() if entry != 0)
    return (
        *(Verdict(f"{head}: {name}", value, SYMBOLIC, "SI") for name, value in worst.items()),
        Verdict(f"{', '.join(joints)}: tau of L - (B ddq + C dq + g), entries not 0", float(residual), 0.0, ""),
    )


def _random_chain(chain: Chain, paper: Paper, rng: np.random.Generator) -> tuple[Chain, dict[str, float]]:
    """The same joints with other lengths [m], bodies of five points each and gravity; the lengths by their letters."""
    letters = length_letters(paper)
    names = sorted({x.name for column in letters.values() for x in column if x != 0})
    lengths = {name: float(rng.uniform(0.1, 1.0)) for name in names}
    links = []
    for i, (row, link) in enumerate(zip(dh_rows(paper), chain.links, strict=True)):
        a, d = (0.0 if letters[x][i] == 0 else lengths[letters[x][i].name] for x in ("a", "d"))
        before, after = replace(row, a=a, d=d).fixed_poses(paper.convention)
        points: Array = rng.uniform(-0.5, 0.5, (5, 3))
        masses = [Body(float(m), p, np.zeros((3, 3))) for m, p in zip(rng.uniform(0.5, 5.0, 5), points, strict=True)]
        links.append(replace(link, before=before, after=after, body=sum(masses, Body.massless())))
    gravity = chain.gravity / np.linalg.norm(chain.gravity) * rng.uniform(1.0, 20.0)
    return Chain(tuple(links), chain.flange, gravity), lengths


@cache
def own_comparisons() -> tuple[Comparison, ...]:
    """`comparisons` of the report's own planar model."""
    return comparisons(planar_equations())


def named_erratum(_: PaperData, erratum: str) -> Proof:
    """Every expression with this erratum: printed less right is the sum of its errata, and is not without this one."""
    touched = [c for c in own_comparisons() if erratum in c.added]
    with_it = [c.follows_with(c.added) for c in touched]
    without = [c.follows_with({*c.added} - {erratum}) for c in touched]
    names = ", ".join(c.name for c in touched)
    return Proof(
        f"printed = right + the errors named in {names}; leave this one out and they differ",
        bool(touched) and all(with_it) and not any(without),
        {c.name: f"adds {'; '.join(map(str, c.added[erratum]))}" for c in touched},
    )


def planar_model(_: PaperData) -> Proof:
    """Every entry of B, C and g of the planar model, done right, beside those of the arm's first two joints."""
    paper = open_paper("kr30ha", "kuka")
    arm = equations_of_motion(arm_from_paper(paper), FIRST_TWO, None, paper, True).equations
    pairs = counterparts(arm)
    equal = [c.name for c in pairs if not c.why]
    weight = next(c for c in pairs if c.name == "g_1")
    return Proof(
        "of B, C and g the planar model has only B_22 and C_22 of the arm; its axis 1 carries weight, not the arm's",
        equal == ["B_22", "C_22"] and weight.arm == 0 and weight.planar != 0,
        {"the same": ", ".join(equal), "other": ", ".join(c.name for c in pairs if c.why)},
    )


def unfinished(_: PaperData) -> Proof:
    """The report's own Lagrangian carried to the end, against the right one of its model."""
    planar = planar_equations()
    lagrangian = next(c for c in own_comparisons() if c.name == "L").printed[0]
    torques = finished(lagrangian)
    off = [not same(str(a), str(b)) for a, b in zip(torques, planar.tau, strict=True)]
    return Proof(
        "the derivatives can be carried out; no such line is printed, and they would not be the right equations",
        all(off) and all(not same(str(row), "0") for row in torques),
        {"terms of tau_1": len(torques[0].expand().args), "terms of tau_2": len(torques[1].expand().args)},
    )


def lagrangian_label(_: PaperData) -> Proof:
    """L as printed less K_TOTAL as printed."""
    printed = {c.name: c.printed[0] for c in own_comparisons() if c.printed.shape == (1, 1)}
    rest = printed["L"] - printed["K_TOTAL"]
    potential = -(printed["P_1"] + printed["P_2"])
    return Proof("the expression printed as L = K_TOTAL is K_TOTAL - P_1 - P_2",
                 same(str(rest), str(potential)) and not same(str(rest), "0"), {"L - K_TOTAL": str(rest)})  # fmt: skip


_NAMED = ("k-total-half", "k1-half", "inertia-point-mass", "v2-sign", "product-term", "v2-product", "k1-rate")

MOTION: dict[str, Prove] = {
    **{erratum: partial(named_erratum, erratum=erratum) for erratum in _NAMED},
    "planar-model": planar_model,
    "unfinished": unfinished,
    "lagrangian-label": lagrangian_label,
}
