"""The solver "eaik": closed forms of the package EAIK (Ostermeier, Kuelz, Althoff 2025), each result verified.

EAIK mixes least-squares solutions into its lists and does not say which kind of arm it has no closed form for until it
is asked, so a pose is solved by what forward kinematics confirms. Its arm is given by axes and points at q = 0.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.kinematics.branches import joint_ranges, wrap
from lwr_dyn.kinematics.forward import flange_pose, joint_axes
from lwr_dyn.kinematics.numeric import distinct, missed
from lwr_dyn.kinematics.solution import IkSolver, InverseResult, PoseProblem, turned_result
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind

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
    if chain.n != 6 or any(link.kind is not JointKind.REVOLUTE for link in chain.links):
        return None
    try:
        from eaik.IK_HP import HPRobot
    except ImportError:
        raise MissingPackageError("EAIK", "eaik") from None
    axes = joint_axes(chain, np.zeros(6))
    points = np.vstack([np.zeros(3), axes.p, axes.flange[:3, 3]])
    robot = HPRobot(axes.z, np.diff(points, axis=0))
    return EaikArm(robot, axes.flange[:3, :3]) if robot.hasKnownDecomposition() else None


def solve_pose(problem: PoseProblem, geometry: EaikArm) -> InverseResult:
    """The solutions of EAIK that forward kinematics confirms, with all their copies whole turns of joints apart."""
    arm, ranges, pose = problem.arm, joint_ranges(problem.arm), problem.pose.copy()
    pose[:3, :3] = pose[:3, :3] @ geometry.home_rotation.T
    q = np.asarray(geometry.robot.IK(pose).Q, dtype=float).reshape(-1, 6)
    q = q[np.isfinite(q).all(axis=1)]
    q = q[np.abs(flange_pose(arm.chain, q) - problem.pose).max(axis=(1, 2)) <= CONFIRMED]
    if not len(q):
        return missed(problem, arm.chain)
    q = ranges.middle + wrap(q - ranges.middle)
    return turned_result(problem, q[distinct(q, np.ones(6, dtype=bool))], complete=False)


SOLVER = IkSolver(recognise, solve_pose, "a six-joint arm that EAIK has a closed form of")
"""The row "eaik" of the solvers."""
