"""The functions that recompute what the KR 30 HA report prints, by the names its `results.toml` gives them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from lwr_dyn.kinematics.envelope import working_envelope
from lwr_dyn.model.chain import link_frames
from lwr_dyn.papers.assembly import dh_rows
from lwr_dyn.papers.reader import paper_of_tables
from lwr_dyn.reproduction.case import ComparedExpression, PaperCase, PaperFormula
from lwr_dyn.reproduction.expressions import compared, same
from lwr_dyn.reproduction.kr30ha.derived import DERIVED
from lwr_dyn.reproduction.kr30ha.planar_dynamics import comparisons
from lwr_dyn.reproduction.kr30ha.planar_model import planar_equations
from lwr_dyn.reproduction.kr30ha.points import simplified_solution, wrist_centre_mm
from lwr_dyn.reproduction.quantities import SHARED
from lwr_dyn.reproduction.results import ResultBlock
from lwr_dyn.symbolic.dh_matrices import dh_matrices

IN_MM = np.array([[1, 1, 1, 1e3]] * 3 + [[1, 1, 1, 1]])
"""Factors that bring a homogeneous matrix from m to mm."""


def axes(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Joints of the arm, all of them driven"""
    return {"count": [case.n, case.n]}


def link_lengths(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """d_1, a_1, a_2 + a_3 and d_4 of Table 3 [mm], as the report takes them"""
    rows = dh_rows(case.geometry)
    lengths = {"d1": rows[0].d, "d2": rows[0].a, "a2": rows[1].a + rows[2].a, "a3": rows[3].d}
    return {name: [1e3 * value] for name, value in lengths.items()}


def coordinates(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Table 1 [mm]"""
    columns = dict.fromkeys(cell.column for cell in block.cells)
    return {name: block.printed[f"point_{name[-1]}"] for name in columns}


def wrist_at_mastering(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Wrist centre at the mastering position of Appendix A [mm]"""
    found = wrist_centre_mm(case.arm, np.array(case.arm.mastering))
    return {"text": found, "table_4": found}


def simplified_point(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """The report's D, theta_1, theta_3, alpha, phi and theta_2 = alpha +- phi from Table 4"""
    return _simplified(case, block)


def _simplified(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    found = simplified_solution(block.printed, case.block("geometry").printed)
    out: dict[str, Any] = {name: [found[name]] for name in ("theta_1", "D", "theta_3", "alpha", "phi")}
    return out | {"theta_2": [found["theta_2 (first)"], found["theta_2 (second)"]]}


def table_5(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """theta_1, theta_2, theta_3 by the report's own formulas; theta_2 the elbow-up one"""
    out = {}
    for name in ("point_1", "point_2", "home"):
        found = _simplified(case, case.block(name))
        out[name] = [found["theta_1"][0], found["theta_2"][0 if name == "home" else 1], found["theta_3"][0]]
    return out


def symbolic_matrices(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Equation (1) with Table 2, theta_i = theta_i* + offset_i"""
    dh = {name: column for name, column in case.tables["dh"].items() if name != "sign"}
    found = dh_matrices(paper_of_tables({**case.bare, "dh": dh}, case.file, errata_read=()))
    return {f"A{i + 1}": compared(block.printed[f"A{i + 1}"], m) for i, m in enumerate(found)}


def numeric_matrices(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Equation (1) with Table 2 at the mastering position of Appendix A, lengths in mm"""
    chain, q = case.arm.chain, case.arm.mastering
    links = zip(chain.links, q, strict=True)
    return {f"T{i + 1}": (IN_MM * link.pose(x).matrix()).tolist() for i, (link, x) in enumerate(links)}


def composite_matrices(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """T_1^0 ... T_k^{k-1} at the mastering position of Appendix A, lengths in mm"""
    found = list(link_frames(case.arm.chain, np.array(case.arm.mastering)))
    return {f"T0{k}": (IN_MM * found[k - 1]).tolist() for k in range(2, 7)}


def flange_at_mastering(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Flange [mm] with KUKA's axes at mastering; at A = 0 where the printed pose is read as that one"""
    q = np.zeros(case.n) if "mastering-transform" in case.applied else np.array(case.arm.mastering)
    if not {"kuka-signs", "table2-offset"} <= case.applied:
        return {"position": [None, None, None]}  # the joint coordinates are not KUKA's axes
    return {"position": 1e3 * list(link_frames(case.arm.chain, q))[-1][:3, 3]}


def envelope(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Largest distance of the wrist centre from axis 1, and pi times the moment of its section"""
    found = working_envelope(case.arm)
    return {"reach": [1e3 * found.reach], "volume": [found.volume]}


def expressions(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """The right expression of the report's own planar model, with what the errata applied take away"""
    return {"printed": [_expression(name, case.applied) for name in dict.fromkeys(c.row for c in block.cells)]}


@cache
def _expression(name: str, applied: frozenset[str]) -> ComparedExpression:
    comparison = next(c for c in _comparisons() if c.name == name)
    rest = comparison.printed - comparison.right
    for matrix in (m for erratum, m in comparison.slips.items() if erratum in applied):
        rest -= matrix
    return ComparedExpression("; ".join(map(str, comparison.right)), all(same(str(entry), "0") for entry in rest))


@cache
def _comparisons() -> Any:
    return comparisons(planar_equations())


def caption_numbers(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Number of the caption that is meant"""
    return {"number": [1 + block.printed[kind].index(title) for kind, title in block.printed["meant"]]}


_QUICK = (
    axes, link_lengths, coordinates, wrist_at_mastering, simplified_point, table_5, symbolic_matrices,
    numeric_matrices, composite_matrices, flange_at_mastering, envelope, caption_numbers,
)  # fmt: skip
FORMULAS: dict[str, PaperFormula] = (
    SHARED
    | DERIVED
    | {function.__name__: PaperFormula(function) for function in _QUICK}
    | {"expressions": PaperFormula(expressions, slow=True)}
)
