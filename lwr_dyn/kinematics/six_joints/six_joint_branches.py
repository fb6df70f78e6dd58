"""The eight branches of six-joint arms with a closed form, and the solutions of one pose made of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.branches import BRANCHES, REACH_SLACK, JointRanges, joint_ranges, wrap
from lwr_dyn.kinematics.six_joints.six_joint_geometry import SixJointGeometry
from lwr_dyn.kinematics.solution import InverseResult, PoseProblem, turned_result

NEAR_SINGULAR = 1e-5
"""[m] (shoulder) and [rad] (elbow, wrist): a solution nearer than this to a singularity is marked with it."""
SINGULARITIES = ("shoulder", "elbow", "wrist")


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
    branches = closed_form(geometry, joint_ranges(problem.arm), problem.pose[None], REACH_SLACK)
    which = np.flatnonzero(branches.reachable[0])
    if not len(which):
        return InverseResult("out of reach", (), (), True, distance=float(branches.reach_excess.min()))
    return branch_result(problem, branches, branches.q[0, which], which, complete=True)


def branch_result(
    problem: PoseProblem, branches: SixJointBranches, q: Array, which: NDArray[np.intp], complete: bool
) -> InverseResult:
    """Solutions q (k, 6) of the branches `which` (k,) of one pose, with their singularities and whole turns."""
    near = branches.clearance[0, which] < NEAR_SINGULAR
    names = [tuple(s for s, x in zip(SINGULARITIES, row, strict=True) if x) for row in near]
    return turned_result(problem, q, complete, [BRANCHES[b].label for b in which], names)
