"""Closed-form inverse kinematics of six-joint arms with a spherical wrist: eight branches for each pose, in batches.

Pieper's split (1968): the flange pose gives the wrist centre W, W gives q1 to q3, the rest of the rotation q4 to q6.

    h = +-sqrt(r^2 - b^2),  q1 = atan2(W_n, W_e) - atan2(b, h)     r: W's distance from axis 1, b: its lateral offset
    cos(bend) = (|t|^2 - l2^2 - l3^2) / (2 l2 l3)                  t: from axis 2 to W in the arm's plane
    Rz(q4) Ry(q5 + offset) Rz(q6) = basis^T R_3^T R_flange back    q6 from Rz(-q4) times the right side

Singularities: the shoulder (W on axis 1, or at its lateral offset: q1 is not determined), the elbow (stretched or
folded: two branches meet) and the wrist (axes 4 and 6 in line: only q4 +- q6 is determined).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.arm_geometry import WRIST_ARM, WristArmGeometry, require_wrist_arm, wrist_arm_geometry
from lwr_dyn.kinematics.branches import (
    ALIGNED,
    BRANCHES,
    REACH_SLACK,
    JointRanges,
    elbow_bend,
    joint_ranges,
    whole_turns,
    wrap,
)
from lwr_dyn.kinematics.solution import IkSolver, InverseResult, PoseProblem, make_solution, ranked_result
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import turn_about

NEAR_SINGULAR = 1e-5
"""[m] (shoulder) and [rad] (elbow, wrist): a solution nearer than this to a singularity is marked with it."""
SINGULARITIES = ("shoulder", "elbow", "wrist")


@dataclass(frozen=True, slots=True, eq=False)
class WristSolutions:
    """For k poses and the eight `BRANCHES`: q, excess over the reach, distances from the singularities."""

    q: Array
    """(k, 8, 6) [rad], each joint within half a turn of the middle of its range; NaN where out of reach."""
    reach_excess: Array
    """(k, 8) by how much W is out of reach on that branch [m], 0 within."""
    clearance: Array
    """(k, 8, 3) distance to the shoulder singularity [m], the elbow's and the wrist's [rad]."""

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """(k, 8)."""
        within: NDArray[np.bool_] = self.reach_excess == 0.0
        return within


@dataclass(frozen=True, slots=True, eq=False)
class _Position:
    """q1, q2, q3 on shoulder and elbow branches (k, 2, 2) with their reach and their distances from singularities."""

    q: tuple[Array, Array, Array]
    reach_excess: Array
    shoulder: Array
    elbow: Array


def closed_form(geometry: WristArmGeometry, ranges: JointRanges, T: Array) -> WristSolutions:
    """All branches for flange poses T (k, 4, 4); ungated."""
    position = _position(geometry, ranges, T)
    shape = (len(T), 2, 2, 2)
    q123 = np.stack([np.broadcast_to(q[..., None], shape) for q in position.q], axis=-1)
    q456, tilt = _wrist(geometry, ranges, T, position)
    q = np.concatenate([q123, q456], axis=-1)
    q = ranges.middle + wrap(q - ranges.middle)
    reach_excess = np.broadcast_to(position.reach_excess[..., None], shape)
    spread = (np.broadcast_to(x[..., None], shape) for x in (position.shoulder, position.elbow))
    clearance = np.stack([*spread, np.broadcast_to(tilt, shape)], axis=-1)
    q = np.where((reach_excess > 0.0)[..., None], np.nan, q)
    return WristSolutions(q.reshape(-1, 8, 6), reach_excess.reshape(-1, 8), clearance.reshape(-1, 8, 3))


def _position(g: WristArmGeometry, ranges: JointRanges, T: Array) -> _Position:
    wrist = (T[:, :3, 3] + T[:, :3, :3] @ g.wrist_in_flange - g.origin) @ g.frame
    e, n, height = wrist.T
    radius, b = np.hypot(e, n), abs(g.lateral)
    ahead = np.sqrt(np.maximum(radius - b, 0.0) * (radius + b))
    missing = np.maximum(b - radius, 0.0)
    signs = np.array([1.0, -1.0])
    h = g.front * signs * ahead[:, None]
    q1 = np.arctan2(n, e)[:, None] - np.arctan2(g.lateral, h)
    # on axis 1 every q1 is a solution: the middle of its range, for both branches
    q1 = np.where((radius < ALIGNED)[:, None], ranges.middle[0], q1)
    along, out = height[:, None] - g.shoulder[0], h - g.shoulder[1]
    first, second = g.lengths
    bend, excess = elbow_bend((first, second), np.hypot(along, out))
    turn = signs * bend[..., None]
    q3 = g.straight + g.elbow_sign * turn
    # at q3 = 0 the forearm is `straight` away from the upper arm, so bent it is at the upper arm's angle + turn
    lean = np.arctan2(g.upper[1], g.upper[0])
    reach = np.arctan2(second * np.sin(turn), first + second * np.cos(turn))
    q2 = np.arctan2(out, along)[..., None] - lean - reach
    excess = np.maximum(excess, missing[:, None])
    shape = q2.shape
    return _Position(
        (np.broadcast_to(q1[..., None], shape), q2, q3),
        np.broadcast_to(np.where(excess > REACH_SLACK, excess, 0.0)[..., None], shape),
        np.broadcast_to(np.maximum(radius - b, 0.0)[:, None, None], shape),
        np.broadcast_to(np.minimum(bend, np.pi - bend)[..., None], shape),
    )


def _wrist(g: WristArmGeometry, ranges: JointRanges, T: Array, position: _Position) -> tuple[Array, Array]:
    """q4, q5, q6 (k, 2, 2, 2, 3), and the tilt's angle from aligned (k, 2, 2, 1) [rad]."""
    q1, q2, q3 = (q.reshape(-1) for q in position.q)
    _, n, w1 = g.frame.T
    # axes 2 and 3 are parallel: one turn by q2 +- q3
    arm = turn_about(w1, q1) @ turn_about(n, q2 + g.elbow_sign * q3)
    target = T[:, :3, :3] @ (g.home_rotation.T @ g.ball.back)
    left = np.swapaxes(arm @ g.ball.basis, -1, -2).reshape(*position.reach_excess.shape, 3, 3)
    M = (left @ target[:, None, None])[..., None, :, :]
    sign = np.array([1.0, -1.0])
    sine = np.hypot(M[..., 0, 2], M[..., 1, 2])
    tilt = np.arctan2(sign * sine, M[..., 2, 2])
    q4 = np.arctan2(sign * M[..., 1, 2], sign * M[..., 0, 2])
    aligned = sine < ALIGNED
    q4 = np.where(aligned, _shared(ranges, M), q4)
    c, s = np.cos(q4), np.sin(q4)
    q6 = np.arctan2(c * M[..., 1, 0] - s * M[..., 0, 0], c * M[..., 1, 1] - s * M[..., 0, 1])
    q5 = tilt - g.ball.offset
    away = np.arctan2(sine, np.abs(M[..., 2, 2]))
    return np.stack([q4, np.broadcast_to(q5, q4.shape), q6], axis=-1), away


def _shared(ranges: JointRanges, M: Array) -> Array:
    """q4 of an aligned wrist: the middle of its range, moved only by what q6 cannot take inside its own range."""
    middle, half = ranges.middle[[3, 5]], ranges.half[[3, 5]]
    direction = np.where(M[..., 2, 2] > 0.0, 1.0, -1.0)
    total = np.arctan2(M[..., 1, 0], M[..., 1, 1])
    # q6 = total - direction q4, for M = Rz(q4) Rz(q6) and Rz(q4) Ry(pi) Rz(q6) alike, up to rounding
    q6 = wrap(total - direction * middle[0] - middle[1])
    excess = np.sign(q6) * np.maximum(np.abs(q6) - half[1], 0.0)
    return np.asarray(middle[0] + direction * excess)


def all_branches(arm: Arm, T: Array) -> WristSolutions:
    """All branches of poses T (k, 4, 4) as arrays, for many poses at once; ungated, without `whole_turns`.

    Raises `OptionError` when the arm is not a six-joint arm with spherical wrist.
    """
    return closed_form(require_wrist_arm(arm), joint_ranges(arm), T)


def solve_pose(problem: PoseProblem, geometry: WristArmGeometry) -> InverseResult:
    """Every solution of one flange pose; ungated.

    A branch gives all its copies of `whole_turns`.
    """
    arm = problem.arm
    branches = closed_form(geometry, joint_ranges(arm), problem.pose[None])
    if not branches.reachable.any():
        return InverseResult("out of reach", (), (), True, distance=float(branches.reach_excess.min()))
    solutions, left_out = [], 0
    for b in np.flatnonzero(branches.reachable[0]):
        near = tuple(s for s, x in zip(SINGULARITIES, branches.clearance[0, b], strict=True) if x < NEAR_SINGULAR)
        copies = whole_turns(arm, branches.q[0, b])
        left_out += copies.left_out
        for q in copies.q:
            solutions.append(replace(make_solution(problem, q), branch=BRANCHES[b].label, singular=near))
    return ranked_result(problem, solutions, complete=True, turns_left_out=left_out)


SOLVER = IkSolver(wrist_arm_geometry, solve_pose, WRIST_ARM)
"""The row "spherical-wrist" of the solvers."""
