"""The LWR-IV exercise recomputed: the seven matrices, the wrist centre by both routes, the tool point."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.assembly import arm_from_paper, dh_rows
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.symbolic import link_motion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Note
from lwr_dyn.kinematics.forward import flange_pose, frames
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.case import REPEATED, SHARED, PaperCase, formulas
from lwr_dyn.reproduction.compare import compared
from lwr_dyn.reproduction.paper_study import Pictures, Progress, Reproduction, study_document
from lwr_dyn.reproduction.papers import ResultBlock, printed_tables
from lwr_dyn.reproduction.report.content import Still


def dh_matrices(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """A_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)"""
    matrices = link_motion.dh_matrices(case.paper)
    return {f"A{i + 1}": compared(block.printed[f"A{i + 1}"], m.tolist()) for i, m in enumerate(matrices)}


def last_three(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """A_5 A_6 A_7 (0, 0, 0, 1)^T"""
    point = link_motion.vector_route(link_motion.dh_matrices(case.paper)[4:], sp.Matrix([0, 0, 0, 1])).value
    return {"p": [row[0] for row in compared([[text] for text in block.printed["p"]], point.tolist())]}


def joints_by_group(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Joints whose axes meet in one point: from the first on, from the last back, and what is left between"""
    rows = dh_rows(case.paper)
    shoulder = 1 + next(i for i, row in enumerate(rows[1:], start=1) if row.d != 0.0 or row.a != 0.0)
    wrist = len(rows) - max(i for i, row in enumerate(rows) if row.d != 0.0)
    return {"joints": [len(rows), shoulder, len(rows) - shoulder - wrist, wrist]}


def tool_point(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """T_07(q) (0, 0.05, 0.1, 1)^T [m]"""
    T = flange_pose(case.arm.chain, np.radians(block.printed["q_deg"]))
    return {"position": T[:3, :3] @ np.array(block.printed["point"]) + T[:3, 3]}


def wrist_centre(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Origin of frame 6 [m]"""
    return {"position": frames(case.arm.chain, block.printed["q"])[5, :3, 3]}


FORMULAS = (
    SHARED
    | formulas(dh_matrices, last_three, tool_point, wrist_centre)
    | formulas(joints_by_group, basis=REPEATED)  # counts
)
"""The numbers that the exercise prints, by the names that its `results.toml` gives them."""


@dataclass(frozen=True, slots=True, eq=False)
class Exercise:
    """What came out: A_i with whether each is the printed one, both routes to the wrist, the tool point [m]."""

    matrices: tuple[sp.Matrix, ...]
    identical: tuple[bool, ...]
    wrist_full: link_motion.SymbolicRoute
    wrist_short: link_motion.SymbolicRoute
    routes_agree: bool
    q_deg: tuple[float, ...]
    tool_in_flange: tuple[float, ...]
    tool: Array

    @property
    def holds(self) -> bool:
        """All matrices are the printed ones and both routes give one wrist."""
        return all(self.identical) and self.routes_agree


def exercise() -> Exercise:
    """Solve the exercise from its own table."""
    paper, printed = open_paper("lwr4", "printed"), printed_tables("lwr4")
    matrices = link_motion.dh_matrices(paper)
    names = {str(s): s for m in matrices for s in m.free_symbols}
    tables = [
        sp.Matrix([[sp.sympify(x, names) for x in row] for row in printed["matrices"][f"A{i + 1}"]]) for i in range(7)
    ]
    full = link_motion.full_product(matrices, sp.Matrix([0, 0, 0, 1]))
    short = link_motion.vector_route(matrices[:4], sp.Matrix([0, 0, names["M"], 1]))
    tool = printed["tool"]
    pose = flange_pose(arm_from_paper(paper).chain, np.radians(tool["q_deg"]))
    return Exercise(
        matrices=matrices,
        identical=tuple(bool(m == t) for m, t in zip(matrices, tables, strict=True)),
        wrist_full=full,
        wrist_short=short,
        routes_agree=bool(sp.expand(full.value - short.value) == sp.zeros(4, 1)),
        q_deg=tuple(tool["q_deg"]),
        tool_in_flange=tuple(tool["point"]),
        tool=pose[:3, :3] @ np.array(tool["point"]) + pose[:3, 3],
    )


def run(_: Path, arm: Arm, __: Progress) -> Reproduction:
    """Solve the exercise."""
    e = exercise()
    routes = {
        name: {"value": [str(x) for x in route.value], "products": route.multiplications, "sums": route.additions}
        for name, route in (("full_product", e.wrist_full), ("vector_route", e.wrist_short))
    }
    matrices = {f"A{i + 1}": str(m.tolist()) for i, m in enumerate(e.matrices)}
    found = study_document(
        Note(_text(e)), matrices=matrices, identical_to_printed=list(e.identical), wrist=routes,
        routes_agree=e.routes_agree, tool=e.tool,
    )  # fmt: skip
    place = ", ".join(f"{x + 0.0:.2f}" for x in e.tool)
    stills = (
        Still("Assignment of D-H frames, q = 0", arm, np.zeros(arm.n)),
        Still("tool position", arm, np.radians(e.q_deg), f"the tool point stands at ({place}) m in frame 0"),
    )
    return Reproduction(e.holds, found, pictures=Pictures(stills=stills))


def _text(e: Exercise) -> str:
    found = {True: "identical to", False: "DIFFERS from"}
    lines = [f"A{i}: {found[same]} the printed matrix" for i, same in enumerate(e.identical, 1)]
    full, short = e.wrist_full, e.wrist_short
    lines.append(f"wrist by A1...A7 (0,0,0,1): {full.multiplications} products, {full.additions} sums")
    lines.append(f"wrist by A1..A4 (0,0,M,1):  {short.multiplications} products, {short.additions} sums")
    lines.append(f"both routes give one expression: {e.routes_agree}")
    lines += [f"  p_W,{axis} = {x}" for axis, x in zip("xyz", short.value, strict=False)]
    tool = " ".join(f"{round(x, 12) + 0.0:g}" for x in e.tool)
    lines.append(f"tool point {e.tool_in_flange} at q = {e.q_deg} deg: {tool} m")
    return "\n".join(lines)
