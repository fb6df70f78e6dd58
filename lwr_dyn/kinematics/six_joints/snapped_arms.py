"""Further six-joint arms: rounded or calibrated numbers, three parallel axes, and what the package EAIK solves.

Of numbers that are rounded or calibrated axes and points are snapped to the exact geometry, which is solved in closed
form; from each branch a search on the arm itself starts (Levenberg-Marquardt). Nothing proves then that no branch is
missing. Near a singularity the arm may have other branches than the exact one, so there the search starts from the
branches of poses all around as well.

With three parallel axes (2, 3, 4) a closed form has eight branches for each pose (Universal Robots; Hawkins 2013). W,
where axes 5 and 6 meet, has the same offset from the arm's plane at every pose, which gives q1 as for a spherical
wrist. Axes 2, 3, 4 turn as one, so that with axes 5 and 6 they make a ball; its roll is the sum of their turns, which
leaves a planar arm from axis 2 over axis 3 to axis 4.

    Rz(roll) Ry(q5 + offset) Rz(q6) = basis^T R_1^T R_flange back      roll = q4 + s4 (q2 + s3 q3), s = +-1: sense

Singularities: the shoulder and the elbow as with a spherical wrist; the wrist, where axis 6 is parallel to axes 2 to 4:
q2, q3, q4 and q6 move together without moving the flange, and one such set is given.

EAIK (Ostermeier, Kuelz, Althoff 2025) mixes least-squares solutions into its lists and does not say which kind of arm
it has no closed form for until it is asked, so a pose is solved by what forward kinematics confirms. Its arm is given
by axes and points at q = 0.
"""

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.kinematics import inverse, solution
from lwr_dyn.kinematics.arm_geometry import meeting_point
from lwr_dyn.kinematics.forward import JointAxes, flange_pose, joint_axes
from lwr_dyn.kinematics.inverse import distinct, missed
from lwr_dyn.kinematics.six_joints import spherical_wrist as wrist
from lwr_dyn.kinematics.six_joints.spherical_wrist import ClosedForm, SixJointBranches, SixJointGeometry
from lwr_dyn.kinematics.solution import JointRanges, joint_ranges, wrap
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
    axes = wrist.six_axes(chain)
    if axes is None:
        return None
    itself, near = wrist.planar_arm(axes, ball_starts), _snapped(axes, ball_starts)
    if itself is not None:
        return SnappedArm(itself, 0.0)
    nearest, missed = wrist.planar_arm(near, ball_starts), np.cross(axes.z, near.p - axes.p)
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


def solve_snapped(
    closed_form: ClosedForm, problem: solution.PoseProblem, snapped: SnappedArm
) -> solution.InverseResult:
    """Every solution of one flange pose with all its copies of `whole_turns`; ungated."""
    arm, ranges, geometry = problem.arm, joint_ranges(problem.arm), snapped.geometry
    branches = closed_form(geometry, ranges, problem.pose[None], ROUNDED)
    found = branches
    if snapped.off and (np.maximum(branches.clearance, branches.reach_excess[..., None]) < snapped.unsure).any():
        found = closed_form(geometry, ranges, problem.pose @ _NEARBY, ROUNDED)
    q, which = found.q[found.reachable], np.nonzero(found.reachable)[1]
    if len(q) and np.abs(flange_pose(arm.chain, q) - problem.pose).max() > inverse.SOLVED:
        q, kept = _polished(problem, q)
        q, which = ranges.middle + wrap(q - ranges.middle), which[kept]
    if len(q):
        return wrist.branch_result(problem, branches, q, which, complete=not snapped.off)
    if snapped.off and branches.reach_excess.min() < snapped.unsure.max():
        return inverse.solve_pose(problem, arm.chain)
    return solution.InverseResult("out of reach", (), (), not snapped.off, distance=float(branches.reach_excess.min()))


def _polished(problem: solution.PoseProblem, q: Array) -> tuple[Array, NDArray[np.intp]]:
    """The distinct solutions (m, 6) that starts q (k, 6) lead to, without limits, and the start of each (m,)."""
    anywhere = np.full(6, np.inf)
    ends, residual = inverse.descend(problem.arm.chain, -anywhere, anywhere, problem.pose, q, NEARLY)
    good = np.flatnonzero(residual <= inverse.SOLVED)
    kept = good[inverse.distinct(ends[good], np.ones(6, dtype=bool))]
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

ROUNDED_WRIST_SOLVER = solution.IkSolver(
    partial(snapped_arm, ball_starts=3), partial(solve_snapped, wrist.closed_form), f"nearly {wrist.WRIST_ARM}"
)
"""The row "rounded-wrist" of the solvers."""

PARALLEL_ARM = "a six-joint arm with axis 2 perpendicular to 1, 3 and 4 parallel to 2, 5 and 6 that meet"


def three_parallel_closed_form(
    g: SixJointGeometry, ranges: JointRanges, T: Array, slack: float = solution.REACH_SLACK
) -> SixJointBranches:
    """All branches for flange poses T (k, 4, 4); a branch that is out of reach by less than `slack` [m] has q."""
    sense = float(np.sign(g.ball.basis[:, 2] @ g.frame[:, 1]))
    q1, along, out, missing, shoulder = wrist.shoulder_angles(g, ranges, T)
    free = sense * _reachable_turn(g, along, out)
    roll, q5, q6, tilt = wrist.ball_angles(g, wrist.ball_rotation(g, T, wrist.turned(g.frame[:, 2], q1)), free)
    c, s = np.cos(sense * roll), np.sin(sense * roll)
    a, b = g.lever
    planar = wrist.elbow_angles(g, along[..., None] - (a * c - b * s), out[..., None] - (a * s + b * c))
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


CONFIRMED = 1e-9
"""Largest entry of FK(q) - T of a solution [m and dimensionless]."""


@dataclass(frozen=True, slots=True, eq=False)
class EaikArm:
    """EAIK's robot, whose flange has the orientation of the base at q = 0."""

    robot: Any
    home_rotation: Array
    """(3, 3) Of our flange at q = 0."""


def recognise(chain: Chain) -> EaikArm | None:
    """EAIK's robot of the chain, or None for an arm that it has no closed form of."""
    if chain.n != 6 or not chain.turning.all():
        return None
    try:
        from eaik.IK_HP import HPRobot
    except ImportError:
        raise MissingPackageError("EAIK", "eaik") from None
    axes = joint_axes(chain, np.zeros(6))
    points = np.vstack([np.zeros(3), axes.p, axes.flange[:3, 3]])
    robot = HPRobot(axes.z, np.diff(points, axis=0))
    return EaikArm(robot, axes.flange[:3, :3]) if robot.hasKnownDecomposition() else None


def solve_by_eaik(problem: solution.PoseProblem, geometry: EaikArm) -> solution.InverseResult:
    """The solutions of EAIK that forward kinematics confirms, with all their copies whole turns of joints apart."""
    arm, ranges, pose = problem.arm, joint_ranges(problem.arm), problem.pose.copy()
    pose[:3, :3] = pose[:3, :3] @ geometry.home_rotation.T
    q = np.asarray(geometry.robot.IK(pose).Q, dtype=float).reshape(-1, 6)
    q = q[np.isfinite(q).all(axis=1)]
    q = q[np.abs(flange_pose(arm.chain, q) - problem.pose).max(axis=(1, 2)) <= CONFIRMED]
    if not len(q):
        return missed(problem, arm.chain)
    q = ranges.middle + wrap(q - ranges.middle)
    return solution.turned_result(problem, q[distinct(q, np.ones(6, dtype=bool))], complete=False)


EAIK_SOLVER = solution.IkSolver(recognise, solve_by_eaik, "a six-joint arm that EAIK has a closed form of")
"""The row "eaik" of the solvers."""
