"""Inverse kinematics of one flange pose: every branch in closed form for an S-R-S arm, a numeric search for others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arm import Arm
from lwr_dyn.arrays import Array, fixed_array, read_only
from lwr_dyn.dh import JointKind
from lwr_dyn.errors import OptionError
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.kinematics.numeric import Search, search
from lwr_dyn.kinematics.poses import pose_array
from lwr_dyn.kinematics.srs import (
    BRANCHES,
    ArmTriangle,
    JointRanges,
    arm_triangle,
    closed_form,
    joint_ranges,
    wrap,
)
from lwr_dyn.kinematics.srs_best import best_angles
from lwr_dyn.kinematics.srs_geometry import SrsGeometry, srs_geometry
from lwr_dyn.kinematics.srs_limits import TOUCH, arcs_at_level, margin_problem

Status = Literal["solved", "out of reach", "outside limits"]
ANYTHING = -2.0 * np.pi
"""[rad] A margin that every joint keeps at every position."""
SAME = 1e-9
"""[rad] Branches whose joints agree to this are one solution (an aligned ball, a straight elbow)."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """One set of joint positions q (n,) [rad or m] for a pose."""

    q: Array
    branch: str
    """Signs of shoulder, elbow and wrist ("+-+"); empty from the numeric search."""
    arm_angle: float | None
    """[rad]; None from the numeric search."""
    margin: float
    """Smallest distance to a position limit [rad or m], negative outside, infinite when no limit is known."""
    joint: str
    """The joint that has it."""
    inside_limits: bool
    residual: float
    """Largest entry of FK(q) - T [m and dimensionless]."""


@dataclass(frozen=True, slots=True, eq=False)
class InverseResult:
    """What there is to say about one pose; `solutions` with the largest margin first."""

    status: Status
    solutions: tuple[Solution, ...]
    """Those asked for: inside the limits, or all with limits=False."""
    outside: tuple[Solution, ...]
    """Those outside the limits, least outside first (empty with limits=False)."""
    complete: bool
    """True: these are all branches, and a status other than "solved" is proven. False: a numeric search."""
    joint: str | None = None
    """Outside limits: the joint that cannot be kept inside, at the best branch and arm angle."""
    excess: float | None = None
    """By how much it is outside [rad or m]."""
    distance: float | None = None
    """Out of reach: by how much [m] (numeric: the position error left)."""
    arm_angle_intervals: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    """Branch -> intervals of the arm angle [rad] inside the limits; ends beyond pi wrap round."""


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
        An S-R-S arm is solved in closed form, any other by a numeric search.
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
        replace(_solution(arm, row, pose), branch=branch.label, arm_angle=float(angle))
        for row, branch, angle in zip(q, BRANCHES, psi, strict=True)
    ]
    return replace(_judged(found, limits, complete=True), arm_angle_intervals=intervals)


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


def _solution(arm: Arm, q: Array, pose: Array) -> Solution:
    room = np.minimum(arm.upper - q, q - arm.lower)
    tightest = int(np.argmin(room))
    return Solution(
        q=read_only(q),
        branch="",
        arm_angle=None,
        margin=float(room[tightest]),
        joint=arm.joint_names[tightest],
        inside_limits=bool(room[tightest] >= -TOUCH),
        residual=float(np.abs(forward_kinematics(arm.chain, q) - pose).max()),
    )


def _judged(found: list[Solution], limits: bool, complete: bool) -> InverseResult:
    """Solutions in order, each once, told apart by the limits."""
    ordered: list[Solution] = []
    for solution in sorted(found, key=lambda s: -s.margin):
        if all(np.abs(wrap(solution.q - other.q)).max() > SAME for other in ordered):
            ordered.append(solution)
    if not limits:
        return InverseResult("solved", tuple(ordered), (), complete)
    inside = tuple(s for s in ordered if s.inside_limits)
    outside = tuple(s for s in ordered if not s.inside_limits)
    if inside:
        return InverseResult("solved", inside, outside, complete)
    best = outside[0]
    return InverseResult("outside limits", (), outside, complete, joint=best.joint, excess=-best.margin)


def _numeric(arm: Arm, pose: Array, limits: bool, starts: int, seed: int) -> InverseResult:
    anywhere = np.full(arm.n, np.inf)
    low, high = (arm.lower, arm.upper) if limits else (-anywhere, anywhere)
    inside = search(arm.chain, low, high, pose, starts, seed)
    if len(inside.q):
        return _judged([_solution(arm, q, pose) for q in _within_a_turn(arm, inside)], limits, complete=False)
    free = search(arm.chain, -anywhere, anywhere, pose, starts, seed) if limits else inside
    if len(free.q):
        return _judged([_solution(arm, q, pose) for q in _within_a_turn(arm, free)], limits, complete=False)
    return InverseResult("out of reach", (), (), False, distance=free.distance)


def _within_a_turn(arm: Arm, found: Search) -> Array:
    """Revolute joints outside their ranges moved by whole turns towards the middle."""
    ranges = joint_ranges(arm)
    turning = np.array([link.kind is JointKind.REVOLUTE for link in arm.chain.links])
    beyond = np.abs(found.q - ranges.middle) > np.maximum(ranges.half, np.pi)
    return np.where(turning & beyond, ranges.middle + wrap(found.q - ranges.middle), found.q)
