"""The numbers of an arm in the texts of its closed form, by their names there."""

from typing import Any

import numpy as np

from lwr_dyn.kinematics.arm_geometry import SrsGeometry
from lwr_dyn.kinematics.six_joints.spherical_wrist import NEAR_SINGULAR, SixJointGeometry
from lwr_dyn.kinematics.solution import MOST_COPIES, REACH_SLACK, SAME, TURN, joint_ranges
from lwr_dyn.kinematics.solution_rows import TOUCH
from lwr_dyn.kinematics.srs_margins import CERTAIN, TIE, UNLIMITED
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import ORTHONORMAL

DOUBT = 1e-13
"""[rad] A copy nearer than this to the line between inside and outside is judged in the order that NumPy's form has."""

SEARCHED = {"GRID": 48, "ZOOMS": 13, "POINTS": 13, "HALF_POINTS": 6.0, "ROUNDS": 20}
"""Of the search for the best arm angle, as in `srs_margins.best_angles`."""

ROW = 16
"""Arm angles whose margins are worked out side by side: the 13 of a zoom, a third of the grid, half of 29 pieces."""

MOST_INTERVALS = 16
"""On one branch: each of 24 crossings ends at most one interval, each of 4 alignments at most two."""


def numbers_of_srs(arm: Arm, g: SrsGeometry) -> dict[str, Any]:
    """Of an S-R-S arm."""
    ranges, offsets = joint_ranges(arm), np.array([g.first.offset, 0.0, 0.0, 0.0, g.last.offset])
    centre = ranges.middle + np.array([0.0, offsets[0], 0.0, 0.0, 0.0, offsets[4], 0.0])
    return _of_joints(arm, REACH_SLACK) | {
        "MOST": MOST_INTERVALS, "ROW": ROW, "OFFSETS": offsets,
        "CENTRE_COSINE": np.cos(centre), "CENTRE_SINE": np.sin(centre),
        "LENGTHS": np.array(g.lengths), "SHOULDER": g.shoulder, "UPPER": g.upper, "FORE": g.fore,
        "ELBOW_AXIS": g.elbow_axis, "STRAIGHT": g.straight, "WRIST_IN_FLANGE": g.wrist_in_flange,
        "HOME_BACK": g.home_rotation.T @ g.last.back, "FIRST_TURNED": g.first.basis.T, "FIRST_BACK": g.first.back,
        "FIRST_BASIS": g.first.basis, "FIRST_FRONT": g.first.back.T, "LAST_BASIS": g.last.basis,
        "REFERENCE": g.reference, "SPARE": np.eye(3)[int(np.argmin(np.abs(g.reference)))],
        "AXIS_Y": np.array([0.0, 1.0, 0.0]), "AXIS_Z": np.array([0.0, 0.0, 1.0]),
    }  # fmt: skip


def numbers_of_six_joints(arm: Arm, g: SixJointGeometry, slack: float) -> dict[str, Any]:
    """Of six joints with a spherical wrist or three parallel axes; excess up to `slack` [m] over the reach is none."""
    return _of_joints(arm, slack) | {
        "LENGTHS": np.array(g.lengths), "FRAME_TURNED": g.frame.T, "BALL_TURNED": g.ball.basis.T @ g.frame,
        "ORIGIN": g.origin, "LATERAL": g.lateral, "SHOULDER": g.shoulder,
        "LEAN": float(np.arctan2(g.upper[1], g.upper[0])),
        "ELBOW_SIGN": float(g.elbow_sign), "FRONT": float(g.front), "STRAIGHT": g.straight,
        "WRIST_IN_FLANGE": g.wrist_in_flange, "HOME_BACK": g.home_rotation.T @ g.ball.back,
        "OFFSET": g.ball.offset, "LEVER": g.lever,
        "SENSE": float(np.sign(g.ball.basis[:, 2] @ g.frame[:, 1])),
    }  # fmt: skip


def numbers_of_solutions(arm: Arm, is_checked: bool) -> dict[str, Any]:
    """Further ones, of the text that judges branches: frames, limits, and places in its result (whole numbers).

    With `is_checked` the residuals are found before the result is given, as it may depend on them.
    """
    chain, ahead, frames = arm.chain, np.eye(4), []
    for link in chain.links:
        frames.append(ahead @ link.before.matrix())
        ahead = link.after.matrix()
    frames.append(ahead @ chain.flange.matrix())
    allowed = np.stack([arm.lower - TOUCH, arm.upper + TOUCH], axis=1)
    return {
        "FRAMES": np.array([frame[:3] for frame in frames]), "LOW": arm.lower, "UP": arm.upper, "ALLOWED": allowed,
        "LIMITED": (np.isfinite(arm.lower) & np.isfinite(arm.upper)) * 1.0, "LARGEST": float(np.finfo(float).max),
        "IS_CHECKED": int(is_checked), "CERTAIN_TURN": 0.5 - DOUBT / TURN, "ORTHONORMAL": ORTHONORMAL,
        "SAME": 2.0 * SAME, "MOST_COPIES": float(MOST_COPIES),
        "NEAR_SINGULAR": NEAR_SINGULAR, "TIE": TIE, "CERTAIN": CERTAIN, **SEARCHED, **places(arm.n),
    }  # fmt: skip


def places(n: int) -> dict[str, int]:
    """Where in the result of `solutions` things stand, for n joints: q of the branches first."""
    rows = {"RESIDUAL": 8, "SINGULAR": 8, "COPIES": 8, "FIRST": 8 * n, "MANY": 8 * n, "TARGET": 12}
    single = ("LEAST", "WORST", "INSIDE", "OUTSIDE", "LEFT_OUT", "MARGIN", "JOINT", "SPECIAL")
    more = {"ARM_ANGLE": 8, "COUNTS": 8, "PAIRS": 256, "POSE": 16} if n == 7 else {}
    at, found = 8 * n, {}
    for name, size in (rows | more | dict.fromkeys(single, 1)).items():
        found[name], at = at, at + size
    return found | {"SIZE": at}


def _of_joints(arm: Arm, slack: float) -> dict[str, Any]:
    ranges = joint_ranges(arm)
    return {
        "JOINTS": arm.n, "UNLIMITED": UNLIMITED, "REACH_SLACK": slack, "MIDDLE": ranges.middle,
        "HALF": np.minimum(ranges.half, UNLIMITED), "NOWHERE": np.zeros(3),
    }  # fmt: skip
