"""Proofs of the errata in the KR 30 HA report's dynamic analysis: expressions, and the planar model beside the arm."""

from collections.abc import Iterable
from functools import cache, partial

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.symbolic.arm_equations import equations_of_motion
from lwr_dyn.reproduction.case import PaperData
from lwr_dyn.reproduction.expressions import same
from lwr_dyn.reproduction.kr30ha.planar_dynamics import (
    FIRST_TWO,
    Comparison,
    comparisons,
    counterparts,
    finished,
    planar_equations,
)
from lwr_dyn.reproduction.ledger import Proof, Prove


@cache
def _comparisons() -> tuple[Comparison, ...]:
    return comparisons(planar_equations())


def named_erratum(_: PaperData, erratum: str) -> Proof:
    """Every expression with this erratum: printed less right is the sum of its errata, and is not without this one."""
    touched = [c for c in _comparisons() if erratum in c.added]
    with_it = [_explained(c, c.added) for c in touched]
    without = [_explained(c, [e for e in c.added if e != erratum]) for c in touched]
    names = ", ".join(c.name for c in touched)
    return Proof(
        f"printed = right + the errors named in {names}; leave this one out and they differ",
        bool(touched) and all(with_it) and not any(without),
        {c.name: f"adds {'; '.join(map(str, c.added[erratum]))}" for c in touched},
    )


def _explained(c: Comparison, errata: Iterable[str]) -> bool:
    rest = c.printed - c.right
    for erratum in errata:
        rest -= c.added[erratum]
    return all(same(str(entry), "0") for entry in rest)


def planar_model(_: PaperData) -> Proof:
    """Every entry of B, C and g of the planar model, done right, beside those of the arm's first two joints."""
    paper = open_paper("kr30ha")
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
    lagrangian = next(c for c in _comparisons() if c.name == "L").printed[0]
    torques = finished(lagrangian)
    off = [not same(str(a), str(b)) for a, b in zip(torques, planar.tau, strict=True)]
    return Proof(
        "the derivatives can be carried out; no such line is printed, and they would not be the right equations",
        all(off) and all(not same(str(row), "0") for row in torques),
        {"terms of tau_1": len(torques[0].expand().args), "terms of tau_2": len(torques[1].expand().args)},
    )


def lagrangian_label(_: PaperData) -> Proof:
    """L as printed less K_TOTAL as printed."""
    printed = {c.name: c.printed[0] for c in _comparisons() if c.printed.shape == (1, 1)}
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
