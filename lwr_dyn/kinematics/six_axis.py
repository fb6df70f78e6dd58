"""Inverse kinematics of one pose of a six-joint arm with spherical wrist: eight branches, whole turns of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.branches import BRANCHES
from lwr_dyn.kinematics.solution import InverseResult, Solution, judged_result, judged_solution
from lwr_dyn.kinematics.spherical_wrist import NEAR_SINGULAR, SINGULARITIES, WristSolutions, closed_form
from lwr_dyn.kinematics.srs import joint_ranges
from lwr_dyn.kinematics.srs_limits import TOUCH
from lwr_dyn.kinematics.wrist_geometry import WristArmGeometry, require_wrist_arm
from lwr_dyn.model.arm import Arm

TURN = 2.0 * np.pi


def branches_of(arm: Arm, T: Array) -> WristSolutions:
    """All branches of poses T (k, 4, 4) as arrays, for many poses at once; ungated, whole turns left to `whole_turns`.

    Raises `OptionError` when the arm is not a six-joint arm with spherical wrist.
    """
    return closed_form(require_wrist_arm(arm), joint_ranges(arm), T)


def solve_pose(arm: Arm, geometry: WristArmGeometry, pose: Array, limits: bool) -> InverseResult:
    """Every solution of one flange pose (4, 4); ungated.

    A branch whose principal values are inside the limits also gives those a whole turn of any joint away that are
    inside too; one that is outside is listed once, as near to the limits as whole turns bring it.
    """
    found = closed_form(geometry, joint_ranges(arm), pose[None])
    if not found.reachable.any():
        return InverseResult("out of reach", (), (), True, distance=float(found.beyond.min()))
    solutions: list[Solution] = []
    for b in np.flatnonzero(found.reachable[0]):
        near = tuple(s for s, x in zip(SINGULARITIES, found.clearance[0, b], strict=True) if x < NEAR_SINGULAR)
        for q in whole_turns(arm, found.q[0, b]):
            solution = judged_solution(arm, q, pose)
            solutions.append(replace(solution, branch=BRANCHES[b].label, singular=near))
    return judged_result(solutions, limits, complete=True, apart=np.asarray)


def whole_turns(arm: Arm, q: Array) -> Iterator[Array]:
    """q (n,) and all positions whole turns of its joints away that are inside the limits; q itself when none is.

    A joint without both limits stays as it is.
    """
    choices = []
    for x, low, up in zip(q, arm.lower, arm.upper, strict=True):
        if not (np.isfinite(low) and np.isfinite(up)):
            choices.append([x])
            continue
        first, last = np.ceil((low - TOUCH - x) / TURN), np.floor((up + TOUCH - x) / TURN)
        choices.append([x + k * TURN for k in np.arange(first, last + 1.0)])
    if not all(choices):
        yield q
    for combination in product(*choices):
        yield np.array(combination)
