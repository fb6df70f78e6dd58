"""Formulas of the numbers that the LWR-IV exercise prints, by the names that its `results.toml` gives them."""

from typing import Any

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.dynamics.symbolic.link_motion import dh_matrices as matrices_of
from lwr_dyn.dynamics.symbolic.link_motion import vector_route
from lwr_dyn.kinematics.forward import flange_pose, frames
from lwr_dyn.reproduction.case import REPEATED, SHARED, PaperCase, formulas
from lwr_dyn.reproduction.expressions import compared
from lwr_dyn.reproduction.papers import ResultBlock


def dh_matrices(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """A_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)"""
    matrices = matrices_of(case.paper)
    return {f"A{i + 1}": compared(block.printed[f"A{i + 1}"], m) for i, m in enumerate(matrices)}


def last_three(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """A_5 A_6 A_7 (0, 0, 0, 1)^T"""
    point = vector_route(matrices_of(case.paper)[4:], sp.Matrix([0, 0, 0, 1])).value
    return {"p": [row[0] for row in compared([[text] for text in block.printed["p"]], point)]}


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
