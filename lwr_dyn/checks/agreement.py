"""The two roads against each other: URDF and Pinocchio against DH frames and the recursion."""

from __future__ import annotations

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.checks.laws import EXACT, coriolis_floor, relative, torque_floor
from lwr_dyn.checks.states import States
from lwr_dyn.checks.verdict import Verdict
from lwr_dyn.dynamics.gate import Gated
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import Convention
from lwr_dyn.papers.assembly import dh_rows
from lwr_dyn.papers.schema import Paper

METRES = 1e-12
"""Poses [m and entries of R]: the arm is about a metre long, each of its products rounds at 1e-16."""


def roads_agree(road_a: Dynamics, road_b: Gated[Recursion], states: States) -> list[Verdict]:
    """B, C, g, inverse and forward dynamics of both roads over the same states."""
    q, dq, ddq = states.q, states.dq, states.ddq
    tau = road_b.inverse_dynamics(q, dq, ddq)
    pairs = {
        "B": (road_a.mass_matrix(q), road_b.mass_matrix(q), 0.0),
        "C": (road_a.coriolis_matrix(q, dq), road_b.coriolis_matrix(q, dq), coriolis_floor(road_b.ungated, states)),
        "g": (road_a.gravity_vector(q), road_b.gravity_vector(q), torque_floor(road_b.ungated, states)),
        "inverse dynamics": (road_a.inverse_dynamics(q, dq, ddq), tau, 0.0),
    }
    rows = [Verdict(f"{name}: road A - road B", relative(*pair), EXACT, "relative") for name, pair in pairs.items()]
    residual = relative(road_b.inverse_dynamics(q, dq, road_a.forward_dynamics(q, dq, tau)), tau)
    return [*rows, Verdict("forward dynamics: road B of road A's ddq gives tau", residual, EXACT, "relative")]


def frames_agree(arm: Arm, urdf_flange: Array, states: States) -> Verdict:
    """Flange pose through the URDF frames against the product of the native matrices."""
    native = forward_kinematics(arm.chain, states.q)
    return Verdict("FK(URDF) - FK(DH)", float(np.abs(urdf_flange - native).max()), METRES, "m")


def tabulated_frames(paper: Paper) -> list[Verdict]:
    """r_{i-1,i} as a paper tabulates it against its DH rows: (a, d sin alpha, d cos alpha) in frame i."""
    if "frames.origin" not in paper.columns or paper.convention is not Convention.STANDARD:
        return []
    rows = dh_rows(paper)
    origins = np.array(
        [after.rotation.T @ after.position for _, after in (r.fixed_poses(paper.convention) for r in rows)]
    )
    deviation = float(np.abs(origins - paper.columns["frames.origin"].si()).max())
    return [Verdict("r_{i-1,i} as tabulated - DH rows", deviation, METRES, "m")]
