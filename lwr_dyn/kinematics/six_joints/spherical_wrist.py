"""Closed-form inverse kinematics of six-joint arms with a spherical wrist: eight branches for each pose, in batches.

Pieper's split (1968): the flange pose gives the wrist centre W, W gives q1 to q3, the rest of the rotation q4 to q6.

    h = +-sqrt(r^2 - b^2),  q1 = atan2(W_n, W_e) - atan2(b, h)     r: W's distance from axis 1, b: its lateral offset
    cos(bend) = (|t|^2 - l2^2 - l3^2) / (2 l2 l3)                  t: from axis 2 to W in the arm's plane
    Rz(q4) Ry(q5 + offset) Rz(q6) = basis^T R_3^T R_flange back    q6 from Rz(-q4) times the right side

Singularities: the shoulder (W on axis 1, or at its lateral offset: q1 is not determined), the elbow (stretched or
folded: two branches meet) and the wrist (axes 4 and 6 in line: only q4 +- q6 is determined).

The geometry is read off the axes at q = 0. With a spherical wrist axis 2 is perpendicular to axis 1, axis 3 parallel to
axis 2, and axes 4, 5, 6 meet in the wrist centre W, neighbours among them perpendicular. In the arm's plane at q1 = 0,
e = w2 x w1 (ahead), n = w2 (across) and w1 (along axis 1) are a right-handed triad.

With three parallel axes it is the same, but axis 4 is parallel to axes 2 and 3, and W is where axes 5 and 6 meet.

Shoulder, elbow and wrist may be offset, the flange may be anywhere, and zero and direction of each joint are free.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.kinematics import solution
from lwr_dyn.kinematics.arm_geometry import MEETING, Ball, ball_of, meeting_point, required
from lwr_dyn.kinematics.forward import JointAxes, joint_axes
from lwr_dyn.kinematics.solution import ALIGNED, BRANCHES, REACH_SLACK, JointRanges, elbow_bend, joint_ranges, wrap
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import turn_about

WRIST_ARM = "a six-joint arm with axis 2 perpendicular to 1, 3 parallel to 2, a spherical wrist"


@dataclass(frozen=True, slots=True, eq=False)
class SixJointGeometry:
    """Constants of a six-joint arm with spherical wrist or three parallel axes at q = 0: lengths [m], angles [rad].

    In the arm's plane a point is (along w1, along e); a positive turn about n takes the first towards the second.
    """

    frame: Array
    """(3, 3), columns e, n, w1 in the base."""
    origin: Array
    """(3,) A point of axis 1 in the base [m]."""
    lateral: float
    """Offset of W from the plane of axis 1, along n [m]."""
    shoulder: Array
    """(2,) Axis 2 in the arm's plane, from `origin`."""
    upper: Array
    """(2,) From axis 2 to axis 3."""
    fore: Array
    """(2,) From axis 3 to W; with three parallel axes to axis 4."""
    lever: Array
    """(2,) From the end of `fore` to W: zero with a spherical wrist."""
    elbow_sign: int
    """+1 when axis 3 points as axis 2 does, else -1."""
    front: int
    """+1 when W is on the side of e at q = 0, -1 on the other: ahead of axis 1 in the sense of `Branch`."""
    wrist_in_flange: Array
    home_rotation: Array
    ball: Ball

    @property
    def lengths(self) -> tuple[float, float]:
        """Upper arm and forearm, both in the arm's plane [m]."""
        return float(np.hypot(*self.upper)), float(np.hypot(*self.fore))

    @property
    def straight(self) -> float:
        """q3 at which axis 2, axis 3 and the end of `fore` lie in line, -pi to pi [rad]."""
        (a, b), (c, d) = self.upper, self.fore
        return float(-self.elbow_sign * np.arctan2(a * d - b * c, a * c + b * d))


@lru_cache(maxsize=32)
def wrist_arm_geometry(chain: Chain) -> SixJointGeometry | None:
    """The constants of the arm, or None when the chain is not a six-joint arm with spherical wrist."""
    axes = six_axes(chain)
    return None if axes is None else planar_arm(axes, ball_starts=3)


def six_axes(chain: Chain) -> JointAxes | None:
    """The axes at q = 0, or None when the chain has not six revolute joints."""
    return joint_axes(chain, np.zeros(6)) if chain.n == 6 and chain.turning.all() else None


def planar_arm(axes: JointAxes, ball_starts: int) -> SixJointGeometry | None:
    """Of the arm whose axes from `ball_starts` (0-based: 3, or 4 with three parallel axes) on meet, or None."""
    z, p, flange = axes.z, axes.p, axes.flange
    wrist, ball = meeting_point(z[ball_starts:], p[ball_starts:]), ball_of(z[3:])
    parallel = z[1] @ z[2:ball_starts].T
    if wrist is None or ball is None or abs(z[0] @ z[1]) > MEETING or (1.0 - abs(parallel) > MEETING).any():
        return None
    frame = np.column_stack([np.cross(z[1], z[0]), z[1], z[0]])
    e, n, w1 = frame.T
    plane, end = np.stack([w1, e]), wrist if ball_starts == 3 else p[3]
    upper, fore = plane @ (p[2] - p[1]), plane @ (end - p[2])
    if min(np.hypot(*upper), np.hypot(*fore)) < MEETING:
        return None
    origin = p[0]
    return SixJointGeometry(
        frame=read_only(frame),
        origin=read_only(origin),
        lateral=float(n @ (wrist - origin)),
        shoulder=read_only(plane @ (p[1] - origin)),
        upper=read_only(upper),
        fore=read_only(fore),
        lever=read_only(plane @ (wrist - end)),
        elbow_sign=1 if parallel[0] > 0.0 else -1,
        front=1 if e @ (wrist - origin) >= 0.0 else -1,
        wrist_in_flange=read_only(flange[:3, :3].T @ (wrist - flange[:3, 3])),
        home_rotation=read_only(flange[:3, :3]),
        ball=ball,
    )


def require_wrist_arm(arm: Arm) -> SixJointGeometry:
    """As `wrist_arm_geometry`; raises `OptionError` when the arm is another one."""
    return required(arm, wrist_arm_geometry(arm.chain), WRIST_ARM)


NEAR_SINGULAR = 1e-5
"""[m] (shoulder) and [rad] (elbow, wrist): a solution nearer than this to a singularity is marked with it."""


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


def branch_result(
    problem: solution.PoseProblem, branches: SixJointBranches, q: Array, which: NDArray[np.intp], complete: bool
) -> solution.InverseResult:
    """Solutions q (k, 6) of the branches `which` (k,) of one pose, with their singularities and whole turns."""
    near = branches.clearance[0, which] < NEAR_SINGULAR
    names = [tuple(s for s, x in zip(solution.SINGULARITIES, row, strict=True) if x) for row in near]
    return solution.turned_result(problem, q, complete, [BRANCHES[b].label for b in which], names)


SIGNS = np.array([1.0, -1.0])


def closed_form(g: SixJointGeometry, ranges: JointRanges, T: Array, slack: float = REACH_SLACK) -> SixJointBranches:
    """All branches for flange poses T (k, 4, 4); a branch that is out of reach by less than `slack` [m] has q."""
    shape = (len(T), 2, 2, 2)
    q1, along, out, missing, shoulder = shoulder_angles(g, ranges, T)
    q2, q3, bend, excess = elbow_angles(g, along, out)
    # axes 2 and 3 are parallel: one turn by q2 +- q3
    arm = turned(g.frame[:, 2], q1)[:, :, None] @ turned(g.frame[:, 1], q2 + g.elbow_sign * q3)
    M = ball_rotation(g, T, arm)
    q4, q5, q6, tilt = ball_angles(g, M, _shared(ranges, M))
    q = [q1[..., None, None], q2[..., None], q3[..., None], q4, q5, q6]
    excess = np.maximum(excess, missing[:, None, None])[..., None]
    return SixJointBranches.of(ranges, shape, q, excess, (shoulder, bend[..., None], tilt), slack)


def shoulder_angles(g: SixJointGeometry, ranges: JointRanges, T: Array) -> tuple[Array, Array, Array, Array, Array]:
    """q1 (k, 2), W along axis 1 (k, 1) and out from axis 2 (k, 2) [m], what W lacks (k,) [m], and its clearance."""
    wrist = (T[:, :3, 3] + T[:, :3, :3] @ g.wrist_in_flange - g.origin) @ g.frame
    e, n, height = wrist.T
    radius, b = np.hypot(e, n), abs(g.lateral)
    h = g.front * SIGNS * np.sqrt(np.maximum(radius - b, 0.0) * (radius + b))[:, None]
    q1 = np.arctan2(n, e)[:, None] - np.arctan2(g.lateral, h)
    # on axis 1 every q1 is a solution: the middle of its range, for both branches
    q1 = np.where((radius < ALIGNED)[:, None], ranges.middle[0], q1)
    clearance = np.maximum(radius - b, 0.0)[:, None, None, None]
    return q1, height[:, None] - g.shoulder[0], h - g.shoulder[1], np.maximum(b - radius, 0.0), clearance


def elbow_angles(g: SixJointGeometry, along: Array, out: Array) -> tuple[Array, Array, Array, Array]:
    """q2, q3 (..., 2) for the end of `fore` at (along, out) of axis 2, clearance [rad] and excess [m]."""
    first, second = g.lengths
    bend, excess = elbow_bend((first, second), np.hypot(along, out))
    turn = SIGNS * bend[..., None]
    q3 = g.straight + g.elbow_sign * turn
    # at q3 = 0 the forearm is `straight` away from the upper arm, so bent it is at the upper arm's angle + turn
    lean = np.arctan2(g.upper[1], g.upper[0])
    reach = np.arctan2(second * np.sin(turn), first + second * np.cos(turn))
    q2 = np.arctan2(out, along)[..., None] - lean - reach
    return q2, q3, np.minimum(bend, np.pi - bend)[..., None], excess[..., None]


def turned(axis: Array, angle: Array) -> Array:
    """Rotations (..., 3, 3) about one axis by angles (...)."""
    return turn_about(axis, angle.reshape(-1)).reshape(*angle.shape, 3, 3)


def ball_rotation(g: SixJointGeometry, T: Array, arm: Array) -> Array:
    """Rz(q4) Ry(q5 + offset) Rz(q6), (k, ..., 3, 3), behind a rotation `arm` (k, ..., 3, 3) of the axes before."""
    target = T[:, :3, :3] @ (g.home_rotation.T @ g.ball.back)
    return np.asarray(np.swapaxes(arm @ g.ball.basis, -1, -2) @ target.reshape(-1, *(1,) * (arm.ndim - 3), 3, 3))


def ball_angles(g: SixJointGeometry, M: Array, aligned_q4: Array) -> tuple[Array, Array, Array, Array]:
    """q4, q5, q6 (..., 2) of M (..., 3, 3), with `aligned_q4` (...) where it is free, and its clearance [rad]."""
    M, free = M[..., None, :, :], aligned_q4[..., None]
    sine = np.hypot(M[..., 0, 2], M[..., 1, 2])
    q5 = np.arctan2(SIGNS * sine, M[..., 2, 2]) - g.ball.offset
    q4 = np.where(sine < ALIGNED, free, np.arctan2(SIGNS * M[..., 1, 2], SIGNS * M[..., 0, 2]))
    c, s = np.cos(q4), np.sin(q4)
    q6 = np.arctan2(c * M[..., 1, 0] - s * M[..., 0, 0], c * M[..., 1, 1] - s * M[..., 0, 1])
    return q4, q5, q6, np.arctan2(sine, np.abs(M[..., 2, 2]))


def _shared(ranges: JointRanges, M: Array) -> Array:
    """q4 of an aligned wrist: the middle of its range, moved only by what q6 cannot take inside its own range."""
    middle, half = ranges.middle[[3, 5]], ranges.half[[3, 5]]
    direction = np.where(M[..., 2, 2] > 0.0, 1.0, -1.0)
    total = np.arctan2(M[..., 1, 0], M[..., 1, 1])
    # q6 = total - direction q4, for M = Rz(q4) Rz(q6) and Rz(q4) Ry(pi) Rz(q6) alike, up to rounding
    q6 = wrap(total - direction * middle[0] - middle[1])
    excess = np.sign(q6) * np.maximum(np.abs(q6) - half[1], 0.0)
    return np.asarray(middle[0] + direction * excess)


def all_branches(arm: Arm, T: Array) -> SixJointBranches:
    """All branches of poses T (k, 4, 4) as arrays, for many poses at once; ungated, without `whole_turns`.

    Raises `OptionError` when the arm is not a six-joint arm with spherical wrist.
    """
    return closed_form(require_wrist_arm(arm), joint_ranges(arm), T)
