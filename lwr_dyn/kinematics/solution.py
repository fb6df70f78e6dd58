"""What inverse kinematics says of one pose: solutions, those outside the limits, reach told apart from limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from lwr_dyn.arrays import Array, read_only
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.kinematics.srs import wrap
from lwr_dyn.kinematics.srs_limits import TOUCH
from lwr_dyn.model.arm import Arm

Status = Literal["solved", "out of reach", "outside limits"]
SAME = 1e-9
"""[rad] Branches whose joints agree to this are one solution (an aligned ball, a straight elbow)."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """One set of joint positions q (n,) [rad or m] for a pose."""

    q: Array
    branch: str
    """Signs of shoulder, elbow and wrist ("+-+"); empty from the numeric search."""
    arm_angle: float | None
    """[rad]; None for an arm that has none, and from the numeric search."""
    margin: float
    """Smallest distance to a position limit [rad or m], negative outside, infinite when no limit is known."""
    joint: str
    """The joint that has it."""
    inside_limits: bool
    residual: float
    """Largest entry of FK(q) - T [m and dimensionless]."""
    singular: tuple[str, ...] = ()
    """Which of shoulder, elbow, wrist this solution is nearer to than `spherical_wrist.NEAR_SINGULAR`."""


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

    @property
    def singular(self) -> tuple[str, ...]:
        """Singularities at which one of the solutions stands, in order shoulder, elbow, wrist."""
        found = {name for solution in (*self.solutions, *self.outside) for name in solution.singular}
        return tuple(name for name in ("shoulder", "elbow", "wrist") if name in found)


def judged_solution(arm: Arm, q: Array, pose: Array) -> Solution:
    """q (n,) with its margin and residual; branch and arm angle are for the caller to add."""
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


def judged_result(
    found: Sequence[Solution], limits: bool, complete: bool, apart: Callable[[Array], Array] = wrap
) -> InverseResult:
    """Solutions in order, each once, told apart by the limits; `apart` says what a difference of joints comes to."""
    ordered: list[Solution] = []
    for solution in sorted(found, key=lambda s: -s.margin):
        if all(np.abs(apart(solution.q - other.q)).max() > SAME for other in ordered):
            ordered.append(solution)
    if not limits:
        return InverseResult("solved", tuple(ordered), (), complete)
    inside = tuple(s for s in ordered if s.inside_limits)
    outside = tuple(s for s in ordered if not s.inside_limits)
    if inside:
        return InverseResult("solved", inside, outside, complete)
    best = outside[0]
    return InverseResult("outside limits", (), outside, complete, joint=best.joint, excess=-best.margin)


def axis_travel(solution: Solution, q: Array) -> float:
    """How far the axes turn in all from q (n,) to the solution, sum |dq_i| [rad]."""
    return float(np.abs(solution.q - q).sum())


def least_travel(solutions: Sequence[Solution], q: Array) -> Solution:
    """The solution that the axes reach with the least travel in all from q (n,); solutions must not be empty."""
    return min(solutions, key=lambda solution: axis_travel(solution, q))
