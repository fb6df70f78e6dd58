"""The eight branches of six-joint arms with a closed form, and the solutions of one pose made of them.

An arm whose numbers are rounded or calibrated is solved on the nearest exact geometry, and each branch is polished on
the arm itself (Levenberg-Marquardt). Nothing proves that no branch is missing then.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics import numeric
from lwr_dyn.kinematics.branches import BRANCHES, JointRanges, joint_ranges, wrap
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.kinematics.numeric import SOLVED, polished
from lwr_dyn.kinematics.six_joint_geometry import SixJointGeometry
from lwr_dyn.kinematics.solution import InverseResult, PoseProblem, turned_result
from lwr_dyn.model.spatial import turn_about

NEAR_SINGULAR = 1e-5
"""[m] (shoulder) and [rad] (elbow, wrist): a solution nearer than this to a singularity is marked with it."""
SINGULARITIES = ("shoulder", "elbow", "wrist")
ROUNDED = 1e-8
"""[m] An arm with axes as exact as `MEETING` may be out of reach by this much of a pose that it reaches."""
UNSURE = 0.05
"""[m, rad] Nearer than this to a singularity or to its reach, a snapped arm may have other branches than the exact."""


@dataclass(frozen=True, slots=True, eq=False)
class SixJointBranches:
    """For k poses and the eight `BRANCHES`: q, excess over the reach, distances from the singularities."""

    q: Array
    """(k, 8, 6) [rad], each joint within half a turn of the middle of its range; NaN where out of reach."""
    reach_excess: Array
    """(k, 8) by how much W is out of reach on that branch [m], 0 within."""
    clearance: Array
    """(k, 8, 3) distance to the shoulder singularity [m], the elbow's and the wrist's [rad]."""

    @classmethod
    def of(
        cls,
        ranges: JointRanges,
        shape: tuple[int, ...],
        q: Sequence[Array],
        excess: Array,
        clearance: Sequence[Array],
        slack: float,
    ) -> Self:
        """From joints, excess and clearances that broadcast to `shape` (k, 2, 2, 2); excess up to `slack` is none."""
        stacked = np.stack([np.broadcast_to(x, shape) for x in q], axis=-1).reshape(-1, 8, 6)
        away = np.stack([np.broadcast_to(x, shape) for x in clearance], axis=-1).reshape(-1, 8, 3)
        missing = np.broadcast_to(np.where(excess > slack, excess, 0.0), shape).reshape(-1, 8)
        stacked = ranges.middle + wrap(stacked - ranges.middle)
        return cls(np.where((missing > 0.0)[..., None], np.nan, stacked), missing, away)

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """(k, 8)."""
        within: NDArray[np.bool_] = self.reach_excess == 0.0
        return within


ClosedForm = Callable[[SixJointGeometry, JointRanges, Array, float], SixJointBranches]


def solve_pose(closed_form: ClosedForm, problem: PoseProblem, geometry: SixJointGeometry) -> InverseResult:
    """Every solution of one flange pose with all its copies of `whole_turns`; ungated."""
    arm, ranges = problem.arm, joint_ranges(problem.arm)
    branches = closed_form(geometry, ranges, problem.pose[None], ROUNDED)
    near = branches.clearance[0] < NEAR_SINGULAR
    found = branches
    if geometry.snapped and (np.maximum(branches.clearance, branches.reach_excess[..., None]) < UNSURE).any():
        found = closed_form(geometry, ranges, problem.pose @ _NEARBY, ROUNDED)
    q, which = found.q[found.reachable], np.nonzero(found.reachable)[1]
    if len(q) and np.abs(forward_kinematics(arm.chain, q) - problem.pose).max() > SOLVED:
        q, kept = polished(arm.chain, problem.pose, q)
        q, which = ranges.middle + wrap(q[kept] - ranges.middle), which[kept]
    if not len(q) and geometry.snapped and branches.reach_excess.min() < UNSURE:
        return numeric.solve_pose(problem, arm.chain)
    if not len(q):
        return InverseResult("out of reach", (), (), not geometry.snapped, distance=float(branches.reach_excess.min()))
    names = [tuple(s for s, x in zip(SINGULARITIES, near[b], strict=True) if x) for b in which]
    return turned_result(problem, q, not geometry.snapped, [BRANCHES[b].label for b in which], names)


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
