"""Closed-form inverse kinematics of six-joint arms with a spherical wrist: eight branches for each pose, in batches.

Pieper's split (1968): the flange pose gives the wrist centre W, W gives q1 to q3, the rest of the rotation q4 to q6.

    h = +-sqrt(r^2 - b^2),  q1 = atan2(W_n, W_e) - atan2(b, h)     r: W's distance from axis 1, b: its lateral offset
    cos(bend) = (|t|^2 - l2^2 - l3^2) / (2 l2 l3)                  t: from axis 2 to W in the arm's plane
    Rz(q4) Ry(q5 + offset) Rz(q6) = basis^T R_3^T R_flange back    q6 from Rz(-q4) times the right side

Singularities: the shoulder (W on axis 1, or at its lateral offset: q1 is not determined), the elbow (stretched or
folded: two branches meet) and the wrist (axes 4 and 6 in line: only q4 +- q6 is determined).
"""

from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.branches import ALIGNED, REACH_SLACK, JointRanges, elbow_bend, joint_ranges, wrap
from lwr_dyn.kinematics.six_joints.six_joint_branches import SixJointBranches, solve_pose
from lwr_dyn.kinematics.six_joints.six_joint_geometry import (
    WRIST_ARM,
    SixJointGeometry,
    require_wrist_arm,
    wrist_arm_geometry,
)
from lwr_dyn.kinematics.solution import IkSolver
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import turn_about

SIGNS = np.array([1.0, -1.0])


def closed_form(g: SixJointGeometry, ranges: JointRanges, T: Array, slack: float = REACH_SLACK) -> SixJointBranches:
    """All branches for flange poses T (k, 4, 4); a branch that is out of reach by less than `slack` [m] has q."""
    shape = (len(T), 2, 2, 2)
    q1, along, out, missing, shoulder = shoulder_angles(g, ranges, T)
    q2, q3, bend, excess = elbow_angles(g, along, out)
    # axes 2 and 3 are parallel: one turn by q2 +- q3
    arm = turned(g.frame[:, 2], q1)[:, :, None] @ turned(g.frame[:, 1], q2 + g.elbow_sign * q3)
    M = ball_rotation(g, T, arm)
    q4, q5, q6, tilt = ball_angles(g, M, _shared(ranges, M))
    q = [q1[..., None, None], q2[..., None], q3[..., None], q4, q5, q6]
    excess = np.maximum(excess, missing[:, None, None])[..., None]
    return SixJointBranches.of(ranges, shape, q, excess, (shoulder, bend[..., None], tilt), slack)


def shoulder_angles(g: SixJointGeometry, ranges: JointRanges, T: Array) -> tuple[Array, Array, Array, Array, Array]:
    """q1 (k, 2), W along axis 1 (k, 1) and out from axis 2 (k, 2) [m], what W lacks (k,) [m], and its clearance."""
    wrist = (T[:, :3, 3] + T[:, :3, :3] @ g.wrist_in_flange - g.origin) @ g.frame
    e, n, height = wrist.T
    radius, b = np.hypot(e, n), abs(g.lateral)
    h = g.front * SIGNS * np.sqrt(np.maximum(radius - b, 0.0) * (radius + b))[:, None]
    q1 = np.arctan2(n, e)[:, None] - np.arctan2(g.lateral, h)
    # on axis 1 every q1 is a solution: the middle of its range, for both branches
    q1 = np.where((radius < ALIGNED)[:, None], ranges.middle[0], q1)
    clearance = np.maximum(radius - b, 0.0)[:, None, None, None]
    return q1, height[:, None] - g.shoulder[0], h - g.shoulder[1], np.maximum(b - radius, 0.0), clearance


def elbow_angles(g: SixJointGeometry, along: Array, out: Array) -> tuple[Array, Array, Array, Array]:
    """q2, q3 (..., 2) for the end of `fore` at (along, out) of axis 2, clearance [rad] and excess [m]."""
    first, second = g.lengths
    bend, excess = elbow_bend((first, second), np.hypot(along, out))
    turn = SIGNS * bend[..., None]
    q3 = g.straight + g.elbow_sign * turn
    # at q3 = 0 the forearm is `straight` away from the upper arm, so bent it is at the upper arm's angle + turn
    lean = np.arctan2(g.upper[1], g.upper[0])
    reach = np.arctan2(second * np.sin(turn), first + second * np.cos(turn))
    q2 = np.arctan2(out, along)[..., None] - lean - reach
    return q2, q3, np.minimum(bend, np.pi - bend)[..., None], excess[..., None]


def turned(axis: Array, angle: Array) -> Array:
    """Rotations (..., 3, 3) about one axis by angles (...)."""
    return turn_about(axis, angle.reshape(-1)).reshape(*angle.shape, 3, 3)


def ball_rotation(g: SixJointGeometry, T: Array, arm: Array) -> Array:
    """Rz(q4) Ry(q5 + offset) Rz(q6), (k, ..., 3, 3), behind a rotation `arm` (k, ..., 3, 3) of the axes before."""
    target = T[:, :3, :3] @ (g.home_rotation.T @ g.ball.back)
    return np.asarray(np.swapaxes(arm @ g.ball.basis, -1, -2) @ target.reshape(-1, *(1,) * (arm.ndim - 3), 3, 3))


def ball_angles(g: SixJointGeometry, M: Array, aligned_q4: Array) -> tuple[Array, Array, Array, Array]:
    """q4, q5, q6 (..., 2) of M (..., 3, 3), with `aligned_q4` (...) where it is free, and its clearance [rad]."""
    M, free = M[..., None, :, :], aligned_q4[..., None]
    sine = np.hypot(M[..., 0, 2], M[..., 1, 2])
    q5 = np.arctan2(SIGNS * sine, M[..., 2, 2]) - g.ball.offset
    q4 = np.where(sine < ALIGNED, free, np.arctan2(SIGNS * M[..., 1, 2], SIGNS * M[..., 0, 2]))
    c, s = np.cos(q4), np.sin(q4)
    q6 = np.arctan2(c * M[..., 1, 0] - s * M[..., 0, 0], c * M[..., 1, 1] - s * M[..., 0, 1])
    return q4, q5, q6, np.arctan2(sine, np.abs(M[..., 2, 2]))


def _shared(ranges: JointRanges, M: Array) -> Array:
    """q4 of an aligned wrist: the middle of its range, moved only by what q6 cannot take inside its own range."""
    middle, half = ranges.middle[[3, 5]], ranges.half[[3, 5]]
    direction = np.where(M[..., 2, 2] > 0.0, 1.0, -1.0)
    total = np.arctan2(M[..., 1, 0], M[..., 1, 1])
    # q6 = total - direction q4, for M = Rz(q4) Rz(q6) and Rz(q4) Ry(pi) Rz(q6) alike, up to rounding
    q6 = wrap(total - direction * middle[0] - middle[1])
    excess = np.sign(q6) * np.maximum(np.abs(q6) - half[1], 0.0)
    return np.asarray(middle[0] + direction * excess)


def all_branches(arm: Arm, T: Array) -> SixJointBranches:
    """All branches of poses T (k, 4, 4) as arrays, for many poses at once; ungated, without `whole_turns`.

    Raises `OptionError` when the arm is not a six-joint arm with spherical wrist.
    """
    return closed_form(require_wrist_arm(arm), joint_ranges(arm), T)


SOLVER = IkSolver(wrist_arm_geometry, partial(solve_pose, closed_form), WRIST_ARM)
"""The row "spherical-wrist" of the solvers."""
