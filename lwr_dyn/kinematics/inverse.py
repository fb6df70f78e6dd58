"""Inverse kinematics of one flange pose: every branch in closed form for arms that allow it, else a numeric search."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array
from lwr_dyn.errors import OptionError
from lwr_dyn.kinematics.branches import BRANCHES
from lwr_dyn.kinematics.numeric import Search, search
from lwr_dyn.kinematics.poses import pose_array
from lwr_dyn.kinematics.six_axis import solve_pose
from lwr_dyn.kinematics.solution import InverseResult, Solution, judged_result, judged_solution
from lwr_dyn.kinematics.srs import ArmTriangle, JointRanges, arm_triangle, closed_form, joint_ranges, wrap
from lwr_dyn.kinematics.srs_best import best_angles
from lwr_dyn.kinematics.srs_geometry import SrsGeometry, srs_geometry
from lwr_dyn.kinematics.srs_limits import arcs_at_level, margin_problem
from lwr_dyn.kinematics.wrist_geometry import wrist_arm_geometry
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind

__all__ = ["ANYTHING", "InverseResult", "Solution", "inverse_kinematics"]

ANYTHING = -2.0 * np.pi
"""[rad] A margin that every joint keeps at every position."""


def inverse_kinematics(
    arm: Arm,
    T: ArrayLike,
    *,
    arm_angle: float | None = None,
    limits: bool = True,
    reference: ArrayLike | None = None,
    starts: int = 64,
    seed: int = 0,
) -> InverseResult:
    """Joint positions whose flange pose is T.

    Parameters
    ----------
    arm : Arm
        An S-R-S arm and a six-joint arm with spherical wrist are solved in closed form, any other by a numeric
        search. Of the six-joint arm every solution a whole turn of a joint away is listed that is inside the limits.
    T : (4, 4) array_like
        Pose of the flange in the base [m].
    arm_angle : float, optional
        [rad], see `srs` for its zero; the one with the largest margin on each branch if not given.
    limits : bool
        False: branches outside the position limits are solutions too.
    reference : (3,) array_like, optional
        Direction the arm angle is counted from; the axis of joint 1 if not given.
    starts, seed : int
        Of the numeric search.

    Returns
    -------
    InverseResult
        Branches that coincide are listed once.

    Raises
    ------
    ShapeError, OptionError
        T is not a pose, the arm angle not finite or given for an arm that has none, starts not positive.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> found = inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, [0.1, 0.5, 0, -1.0, 0, 0.4, 0]))
    >>> found.status, len(found.solutions), found.complete
    ('solved', 8, True)
    """
    pose = pose_array("T", fixed_array("T", T, (4, 4)))
    geometry = srs_geometry(arm.chain)
    if geometry is not None:
        if arm_angle is not None and not math.isfinite(arm_angle):
            raise OptionError("arm_angle", arm_angle, "a finite number of radians")
        return _closed(arm, geometry.with_reference(reference), pose, arm_angle, limits)
    if arm_angle is not None or reference is not None:
        raise OptionError("arm_angle, reference", f"given for {arm.name}", "only for an S-R-S arm")
    wrist_arm = wrist_arm_geometry(arm.chain)
    if wrist_arm is not None:
        return solve_pose(arm, wrist_arm, pose, limits)
    if starts < 1:
        raise OptionError("starts", starts, "an integer >= 1")
    return _numeric(arm, pose, limits, starts, seed)


def _closed(arm: Arm, geometry: SrsGeometry, pose: Array, arm_angle: float | None, limits: bool) -> InverseResult:
    T = np.broadcast_to(pose, (len(BRANCHES), 4, 4))
    triangle, ranges = arm_triangle(geometry, T), joint_ranges(arm)
    if triangle.beyond[0] > 0.0:
        return InverseResult("out of reach", (), (), True, distance=float(triangle.beyond[0]))
    intervals, psi = _arm_angles(geometry, ranges, T, triangle, arm_angle, limits)
    q = closed_form(geometry, ranges, T, psi, np.array(BRANCHES))
    found = [
        replace(judged_solution(arm, row, pose), branch=branch.label, arm_angle=float(angle))
        for row, branch, angle in zip(q, BRANCHES, psi, strict=True)
    ]
    return replace(judged_result(found, limits, complete=True), arm_angle_intervals=intervals)


def _arm_angles(
    geometry: SrsGeometry,
    ranges: JointRanges,
    T: Array,
    triangle: ArmTriangle,
    arm_angle: float | None,
    limits: bool,
) -> tuple[dict[str, tuple[tuple[float, float], ...]], Array]:
    """The intervals of each branch, and the arm angle to take on it."""
    problem = margin_problem(geometry, ranges, T, triangle, np.array(BRANCHES))
    arcs = arcs_at_level(problem, np.full(len(BRANCHES), 0.0 if limits else ANYTHING))
    intervals = {branch.label: arcs.of(b) for b, branch in enumerate(BRANCHES)}
    if arm_angle is not None:
        return intervals, np.full(len(BRANCHES), float(arm_angle))
    return intervals, best_angles(problem).psi


def _numeric(arm: Arm, pose: Array, limits: bool, starts: int, seed: int) -> InverseResult:
    anywhere = np.full(arm.n, np.inf)
    low, high = (arm.lower, arm.upper) if limits else (-anywhere, anywhere)
    inside = search(arm.chain, low, high, pose, starts, seed)
    if len(inside.q):
        return judged_result(
            [judged_solution(arm, q, pose) for q in _within_a_turn(arm, inside)], limits, complete=False
        )
    free = search(arm.chain, -anywhere, anywhere, pose, starts, seed) if limits else inside
    if len(free.q):
        return judged_result([judged_solution(arm, q, pose) for q in _within_a_turn(arm, free)], limits, complete=False)
    return InverseResult("out of reach", (), (), False, distance=free.distance)


def _within_a_turn(arm: Arm, found: Search) -> Array:
    """Revolute joints outside their ranges moved by whole turns towards the middle."""
    ranges = joint_ranges(arm)
    turning = np.array([link.kind is JointKind.REVOLUTE for link in arm.chain.links])
    beyond = np.abs(found.q - ranges.middle) > np.maximum(ranges.half, np.pi)
    return np.where(turning & beyond, ranges.middle + wrap(found.q - ranges.middle), found.q)
