"""All branches of six-joint arms whose numbers are rounded or calibrated: the nearest exact arm, polished.

Axes and points are snapped to the exact geometry, which is solved in closed form; from each branch a search on the arm
itself starts (Levenberg-Marquardt). Nothing proves then that no branch is missing. Near a singularity the arm may have
other branches than the exact one, so there the search starts from the branches of poses all around as well.
"""

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics import numeric
from lwr_dyn.kinematics.arm_geometry import meeting_point
from lwr_dyn.kinematics.branches import joint_ranges, wrap
from lwr_dyn.kinematics.forward import JointAxes, flange_pose
from lwr_dyn.kinematics.six_joints.six_joint_branches import ClosedForm, branch_result
from lwr_dyn.kinematics.six_joints.six_joint_geometry import WRIST_ARM, SixJointGeometry, planar_arm, six_axes
from lwr_dyn.kinematics.six_joints.spherical_wrist import closed_form
from lwr_dyn.kinematics.solution import IkSolver, InverseResult, PoseProblem
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import turn_about

SNAP = 3e-3
"""[m, or sine] Axes this near to meeting, to parallel or to a right angle are snapped to it."""
ROUNDED = 1e-8
"""[m] An arm with axes as exact as `MEETING` may be out of reach by this much of a pose that it reaches."""
LINEAR, FOLD = 20.0, 3.0
"""An arm that is `off` [m, rad] from the exact one may have other branches nearer than `LINEAR` off to its reach and
to singularities of shoulder and wrist, and nearer than `FOLD` sqrt(off) to a stretched elbow."""
NEARLY = 1e-9
"""Damping of starts near a solution: full steps."""


@dataclass(frozen=True, slots=True, eq=False)
class SnappedArm:
    """The nearest arm with a closed form."""

    geometry: SixJointGeometry
    off: float
    """How far directions and meeting axes of the arm itself are from it [rad, m]; 0 to `MEETING`."""

    @property
    def unsure(self) -> Array:
        """(3,) Clearances of `SixJointBranches` below which the arm itself may have other branches [m, rad, rad]."""
        return np.array([LINEAR * self.off, FOLD * np.sqrt(self.off), LINEAR * self.off])


@lru_cache(maxsize=32)
def snapped_arm(chain: Chain, ball_starts: int) -> SnappedArm | None:
    """Of the arm whose axes from `ball_starts` (0-based) on meet, or nearly; None when it is not near to one."""
    axes = six_axes(chain)
    if axes is None:
        return None
    itself, near = planar_arm(axes, ball_starts), _snapped(axes, ball_starts)
    if itself is not None:
        return SnappedArm(itself, 0.0)
    nearest, missed = planar_arm(near, ball_starts), np.cross(axes.z, near.p - axes.p)
    return None if nearest is None else SnappedArm(nearest, float(np.abs([near.z - axes.z, missed]).max()))


def _snapped(axes: JointAxes, ball_starts: int) -> JointAxes:
    """The same axes; neighbours nearer than `SNAP` to parallel, to a right angle or to their common point are there."""
    z, p = axes.z.copy(), axes.p.copy()
    for i in range(1, 6):
        cosine = z[i - 1] @ z[i]
        if np.linalg.norm(np.cross(z[i - 1], z[i])) < SNAP:
            z[i] = np.copysign(1.0, cosine) * z[i - 1]
        elif abs(cosine) < SNAP:
            z[i] = (z[i] - cosine * z[i - 1]) / np.sqrt(1.0 - cosine**2)
    meeting = meeting_point(z[ball_starts:], p[ball_starts:], SNAP)
    if meeting is not None:
        p[ball_starts:] = meeting
    return replace(axes, z=z, p=p)


def solve_pose(closed_form: ClosedForm, problem: PoseProblem, snapped: SnappedArm) -> InverseResult:
    """Every solution of one flange pose with all its copies of `whole_turns`; ungated."""
    arm, ranges, geometry = problem.arm, joint_ranges(problem.arm), snapped.geometry
    branches = closed_form(geometry, ranges, problem.pose[None], ROUNDED)
    found = branches
    if snapped.off and (np.maximum(branches.clearance, branches.reach_excess[..., None]) < snapped.unsure).any():
        found = closed_form(geometry, ranges, problem.pose @ _NEARBY, ROUNDED)
    q, which = found.q[found.reachable], np.nonzero(found.reachable)[1]
    if len(q) and np.abs(flange_pose(arm.chain, q) - problem.pose).max() > numeric.SOLVED:
        q, kept = _polished(problem, q)
        q, which = ranges.middle + wrap(q - ranges.middle), which[kept]
    if len(q):
        return branch_result(problem, branches, q, which, complete=not snapped.off)
    if snapped.off and branches.reach_excess.min() < snapped.unsure.max():
        return numeric.solve_pose(problem, arm.chain)
    return InverseResult("out of reach", (), (), not snapped.off, distance=float(branches.reach_excess.min()))


def _polished(problem: PoseProblem, q: Array) -> tuple[Array, NDArray[np.intp]]:
    """The distinct solutions (m, 6) that starts q (k, 6) lead to, without limits, and the start of each (m,)."""
    anywhere = np.full(6, np.inf)
    ends, residual = numeric.descend(problem.arm.chain, -anywhere, anywhere, problem.pose, q, NEARLY)
    good = np.flatnonzero(residual <= numeric.SOLVED)
    kept = good[numeric.distinct(ends[good], np.ones(6, dtype=bool))]
    return ends[kept], kept


def _nearby() -> Array:
    """Poses (25, 4, 4) in the flange frame: itself, and 10 mm along and 20 mrad about the corners of an icosahedron."""
    golden, poses = (1.0 + 5.0**0.5) / 2.0, np.tile(np.eye(4), (25, 1, 1))
    corners = [np.roll([0.0, a, b * golden], turn) for turn, a, b in product(range(3), (-1.0, 1.0), (-1.0, 1.0))]
    directions = np.array(corners) / np.hypot(1.0, golden)
    poses[1:13, :3, 3] = 0.01 * directions
    for pose, direction in zip(poses[13:], directions, strict=True):
        pose[:3, :3] = turn_about(direction, np.array([0.02]))[0]
    return poses


_NEARBY = _nearby()
"""Where a snapped arm is nearly singular its branches start from these poses too: some may be out of reach, or meet."""

SOLVER = IkSolver(partial(snapped_arm, ball_starts=3), partial(solve_pose, closed_form), f"nearly {WRIST_ARM}")
"""The row "rounded-wrist" of the solvers."""
