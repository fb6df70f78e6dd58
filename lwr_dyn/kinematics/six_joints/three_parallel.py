"""Closed-form inverse kinematics of six-joint arms with three parallel axes (2, 3, 4): eight branches for each pose.

Universal Robots' arms are of this kind (Hawkins 2013). W, where axes 5 and 6 meet, has the same offset from the arm's
plane at every pose, which gives q1 as for a spherical wrist. Axes 2, 3, 4 turn as one, so that with axes 5 and 6 they
make a ball; its roll is the sum of their turns, which leaves a planar arm from axis 2 over axis 3 to axis 4.

    Rz(roll) Ry(q5 + offset) Rz(q6) = basis^T R_1^T R_flange back      roll = q4 + s4 (q2 + s3 q3), s = +-1: sense

Singularities: the shoulder and the elbow as with a spherical wrist; the wrist, where axis 6 is parallel to axes 2 to 4:
q2, q3, q4 and q6 move together without moving the flange, and one such set is given.
"""

from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.branches import REACH_SLACK, JointRanges
from lwr_dyn.kinematics.six_joints.six_joint_branches import SixJointBranches
from lwr_dyn.kinematics.six_joints.six_joint_geometry import SixJointGeometry
from lwr_dyn.kinematics.six_joints.snapped_arms import snapped_arm, solve_pose
from lwr_dyn.kinematics.six_joints.spherical_wrist import (
    ball_angles,
    ball_rotation,
    elbow_angles,
    shoulder_angles,
    turned,
)
from lwr_dyn.kinematics.solution import IkSolver

PARALLEL_ARM = "a six-joint arm with axis 2 perpendicular to 1, 3 and 4 parallel to 2, 5 and 6 that meet"


def closed_form(g: SixJointGeometry, ranges: JointRanges, T: Array, slack: float = REACH_SLACK) -> SixJointBranches:
    """All branches for flange poses T (k, 4, 4); a branch that is out of reach by less than `slack` [m] has q."""
    sense = float(np.sign(g.ball.basis[:, 2] @ g.frame[:, 1]))
    q1, along, out, missing, shoulder = shoulder_angles(g, ranges, T)
    free = sense * _reachable_turn(g, along, out)
    roll, q5, q6, tilt = ball_angles(g, ball_rotation(g, T, turned(g.frame[:, 2], q1)), free)
    c, s = np.cos(sense * roll), np.sin(sense * roll)
    a, b = g.lever
    planar = elbow_angles(g, along[..., None] - (a * c - b * s), out[..., None] - (a * s + b * c))
    q2, q3, bend, excess = (np.swapaxes(x, 2, 3) for x in planar)
    roll, q5, q6, tilt = (x[:, :, None] for x in (roll, q5, q6, tilt))
    q = [q1[..., None, None], q2, q3, roll - sense * (q2 + g.elbow_sign * q3), q5, q6]
    excess = np.maximum(excess, missing[:, None, None, None])
    return SixJointBranches.of(ranges, (len(T), 2, 2, 2), q, excess, (shoulder, bend, tilt), slack)


def _reachable_turn(g: SixJointGeometry, along: Array, out: Array) -> Array:
    """Turn of the lever about axis 4 (k, 2) [rad] that brings axis 4 nearest to where the elbow is at a right angle."""
    distance, lever = np.hypot(along, out), float(np.hypot(*g.lever))
    wanted = np.clip(np.hypot(*g.lengths), np.abs(distance - lever), distance + lever)
    twice = np.maximum(2.0 * distance * lever, np.finfo(float).tiny)
    cosine = np.clip((distance**2 + lever**2 - wanted**2) / twice, -1.0, 1.0)
    return np.asarray(np.arctan2(out, along) - np.arctan2(g.lever[1], g.lever[0]) + np.arccos(cosine))


SOLVER = IkSolver(partial(snapped_arm, ball_starts=4), partial(solve_pose, closed_form), PARALLEL_ARM)
"""The row "three-parallel" of the solvers."""
