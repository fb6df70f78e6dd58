"""The Denavit-Hartenberg table of any serial arm, in either convention, computed from its joint axes.

    standard  T_base,flange = base  prod_i [Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i)]  flange
    modified  T_base,flange = base  prod_i [Tx(a_i) Rx(alpha_i) Rz(theta_i) Tz(d_i)]  flange

n rows have 4 n numbers; the frames of base and flange need more, so two constant poses may remain. All joint positions
read as before: a zero of the arm is a zero of the table. A constant pose between two joints is two motions along z
with a common normal between them:

    K = S(theta, d) N(a, alpha, beta) S(theta', d'),   S = Rz(theta) Tz(d),   N = Tx(a) Rx(alpha) Ry(beta)

The z axes before and after are two joint axes. S commutes with the motion of either kind of joint about its own axis,
so the S at both ends of a joint merge into one row. beta is 0 unless the axes are almost parallel (Hayati and Mirmirani
1985): their common normal is then so far away that rounding would show.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain, ChainLink, Convention, DHRow, JointKind, link_frames
from lwr_dyn.model.spatial import Pose, rot_x, rot_y, rot_z

PARALLEL = 1e-14
"""Sine of the angle below which two axes are parallel: the angle moves a point 1 m away by 1e-14 m."""
COINCIDENT = 1e-14
"""[m] Distance below which two parallel axes are one line, and two axes meet."""
FAR = 100.0
"""[m] A common normal farther than this along an axis takes beta: a rounding of 1e-16 there is 1e-14 m."""


@dataclass(frozen=True, slots=True)
class Screw:
    """A turn about z by `theta` [rad] and a shift along it by `d` [m]."""

    theta: float = 0.0
    d: float = 0.0

    def __add__(self, other: "Screw") -> "Screw":
        """Both; the turn in (-pi, pi]."""
        return Screw(_turn(self.theta + other.theta), self.d + other.d)

    def pose(self) -> Pose:
        """Rz(theta) Tz(d)."""
        return Pose(rot_z(self.theta), np.array([0.0, 0.0, self.d]))


@dataclass(frozen=True, slots=True)
class Normal:
    """The step from one axis to the next: `a` [m] along x, then `alpha` about x and `beta` about y [rad]."""

    a: float = 0.0
    alpha: float = 0.0
    beta: float = 0.0

    def pose(self) -> Pose:
        """Tx(a) Rx(alpha) Ry(beta)."""
        return Pose(rot_x(self.alpha) @ rot_y(self.beta), np.array([self.a, 0.0, 0.0]))


def decomposed(pose: Pose, carried: Screw | None = None, keep_left: bool = False) -> tuple[Screw, Normal, Screw]:
    """The three parts of a pose.

    `carried` is what the row has from the pose before: of the two directions of the normal, the one that leaves the row
    the smaller theta is taken; between parallel axes the row's d becomes 0. The free turn and shift between parallel
    axes, or of one line, stand right of the normal, with `keep_left` left of it.
    """
    carried = Screw() if carried is None else carried
    r, p = pose.rotation, pose.position
    sine = math.hypot(r[0, 2], r[1, 2])
    if sine <= PARALLEL:
        return _parallel(pose, carried, keep_left)
    x = np.array([-r[1, 2], r[0, 2], 0.0]) / sine  # z cross z'
    theta = math.atan2(x[1], x[0])
    along = np.array([x[1], -x[0], 0.0])  # unit vector of z' in the plane across z
    after = float(along @ p) / sine
    d = float(p[2]) - after * float(r[2, 2])
    if max(abs(d), abs(after)) > FAR:
        return _almost_parallel(pose, carried)
    a = float(x @ p)
    a = 0.0 if abs(a) <= COINCIDENT else a
    theta, sign = _nearer(theta, carried)
    left, normal = Screw(theta, d), Normal(sign * a, sign * math.atan2(sine, r[2, 2]))
    return left, normal, Screw(_rest_of_turn(pose, left, normal), after)


def _parallel(pose: Pose, carried: Screw, keep_left: bool) -> tuple[Screw, Normal, Screw]:
    """The whole shift along z stands on one side."""
    p, flip = pose.position, pose.rotation[2, 2] < 0.0
    a, alpha = math.hypot(p[0], p[1]), math.pi if flip else 0.0
    d = float(p[2]) if keep_left else -carried.d
    after = (float(p[2]) - d) * (-1.0 if flip else 1.0)
    if a <= COINCIDENT:
        theta = _angle_of(pose.rotation) if keep_left and not flip else 0.0
        left, normal = Screw(theta, d), Normal(0.0, alpha)
    else:
        theta, sign = _nearer(math.atan2(p[1], p[0]), carried)
        left, normal = Screw(theta, d), Normal(sign * a, alpha)
    return left, normal, Screw(_rest_of_turn(pose, left, normal), after)


def _almost_parallel(pose: Pose, carried: Screw) -> tuple[Screw, Normal, Screw]:
    """The normal lies in the plane across the first axis: x points to where the second axis crosses it."""
    z, p = pose.rotation[:, 2], pose.position + np.array([0.0, 0.0, carried.d])
    after = float(p[2] / z[2])
    cross = p - after * z
    a = math.hypot(cross[0], cross[1])
    theta, sign = (0.0, 1.0) if a <= COINCIDENT else _nearer(math.atan2(cross[1], cross[0]), carried)
    z = rot_z(-theta) @ z
    left = Screw(theta, -carried.d)
    normal = Normal(0.0 if a <= COINCIDENT else sign * a, math.atan2(-z[1], z[2]), math.asin(z[0]))
    return left, normal, Screw(_rest_of_turn(pose, left, normal), after)


def _nearer(theta: float, carried: Screw) -> tuple[float, float]:
    """The direction of the normal, x or -x, that turns the row less, and its sign."""
    whole = abs(_turn(theta + carried.theta))
    return (theta, 1.0) if whole <= math.pi / 2 + 1e-9 else (_turn(theta + math.pi), -1.0)


def _rest_of_turn(pose: Pose, left: Screw, normal: Normal) -> float:
    """The turn about the second axis that the first two parts leave [rad]."""
    return _angle_of((left.pose() @ normal.pose()).rotation.T @ pose.rotation)


def _angle_of(rotation: Array) -> float:
    return math.atan2(rotation[1, 0], rotation[0, 0])


def _turn(angle: float) -> float:
    """An angle in (-pi, pi]."""
    rest = math.remainder(angle, 2.0 * math.pi)
    return math.pi if rest == -math.pi else rest


STATES = 200
"""Random states over which a residual is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class DHTable:
    """Rows, the poses that rows cannot carry, and each link's DH frame in its URDF frame."""

    convention: Convention
    kinds: tuple[JointKind, ...]
    rows: tuple[DHRow, ...]
    base: Pose
    """DH frame 0 in the base."""
    flange: Pose
    """The flange in DH frame n."""
    frames: tuple[Pose, ...]

    def chain(self, arm: Arm) -> Chain:
        """The arm in DH frames, bodies included."""
        links = []
        for k, (link, row, body, frame) in enumerate(
            zip(arm.chain.links, self.rows, arm.bodies(), self.frames, strict=True)
        ):
            before, after = row.fixed_poses(self.convention)
            before = self.base @ before if k == 0 else before
            seen = None if body is None else body.seen_from(frame.inverse())
            links.append(ChainLink(link.joint, link.link, link.kind, before, after, seen, link.rotor))
        return replace(arm.chain, links=tuple(links), flange=self.flange)

    def without_beta(self) -> "DHTable":
        """The four parameters alone."""
        return replace(self, rows=tuple(replace(row, beta=0.0) for row in self.rows))


@dataclass(frozen=True, slots=True)
class Residual:
    """Largest difference of the flange's pose from the arm's own over random states."""

    metres: float
    radians: float


def dh_table(arm: Arm, convention: Convention) -> DHTable:
    """The table of an arm.

    z_i is a joint axis in the arm's own direction, x_i the common normal of two neighbours; of its two directions the
    one that leaves the smaller theta. Parallel axes: the normal through the frame before it, so their d is 0; axes that
    meet: a is 0. Almost parallel ones take `beta` as well.

    >>> import lwr_dyn
    >>> [row.d for row in dh_table(lwr_dyn.load("lwr4plus"), Convention.STANDARD).rows]
    [0.0, 0.0, 0.4, 0.0, 0.39, 0.0, 0.078]
    """
    gaps = [joint.origin for joint in arm.joints()] + [arm.flange()]
    made = _standard(gaps) if convention is Convention.STANDARD else _modified(gaps)
    kinds = tuple(link.kind for link in arm.chain.links)
    rows, base, flange, frames = made
    return DHTable(convention, kinds, tuple(rows), base, flange, tuple(frames))


Parts = tuple[list[DHRow], Pose, Pose, list[Pose]]


def _standard(gaps: list[Pose]) -> Parts:
    """Row i is the end of the gap before joint i, then the start and the normal of the gap after it."""
    base, carried = (Pose.identity(), _as_screw(gaps[0])) if _is_screw(gaps[0]) else (gaps[0], Screw())
    rows, frames = [], []
    for gap in gaps[1:]:
        left, normal, right = decomposed(gap, carried, keep_left=gap is gaps[-1])
        rows.append(_row(carried + left, normal))
        frames.append(left.pose() @ normal.pose())
        carried = right
    return rows, base, _cleaned(carried.pose()), frames


def _modified(gaps: list[Pose]) -> Parts:
    """Row i is the normal of the gap before joint i, its end, and the start of the gap after it."""
    first, normal, carried = decomposed(gaps[0])
    rows, frames = [], []
    for gap in gaps[1:-1]:
        left, following, right = decomposed(gap, carried)
        rows.append(_row(carried + left, normal))
        frames.append(left.pose())
        normal, carried = following, right
    last, flange = (_as_screw(gaps[-1]), Pose.identity()) if _is_screw(gaps[-1]) else (Screw(), gaps[-1])
    rows.append(_row(carried + last, normal))
    frames.append(last.pose())
    return rows, _cleaned(first.pose()), flange, frames


def _row(screw: Screw, normal: Normal) -> DHRow:
    a, alpha, beta = normal.a + 0.0, normal.alpha + 0.0, normal.beta + 0.0  # no negative zeros
    return DHRow(alpha, a, screw.d + 0.0, screw.theta + 0.0, beta=beta)


def _is_screw(pose: Pose) -> bool:
    """Whether the pose turns about z and shifts along z only."""
    r, p = pose.rotation, pose.position
    return bool(np.hypot(*p[:2]) <= COINCIDENT and np.hypot(*r[:2, 2]) <= PARALLEL and r[2, 2] > 0.0)


def _as_screw(pose: Pose) -> Screw:
    return Screw(float(np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])), float(pose.position[2]))


def _cleaned(pose: Pose) -> Pose:
    """The identity where nothing but rounding is left."""
    rounding = max(float(np.abs(pose.matrix() - np.eye(4)).max()), 0.0)
    return Pose.identity() if rounding <= COINCIDENT else pose


def residual(table: DHTable, arm: Arm, states: int = STATES) -> Residual:
    """The flange's pose by the table against the arm's, over random joint positions in +-pi [rad, m]."""
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (states, arm.n))
    *_, ours = link_frames(arm.chain, q)
    *_, theirs = link_frames(table.chain(arm), q)
    turn = np.swapaxes(ours[..., :3, :3], -1, -2) @ theirs[..., :3, :3]
    skew = turn - np.swapaxes(turn, -1, -2)
    sine = 0.5 * np.linalg.norm([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=0)
    angle = np.arctan2(sine, 0.5 * (np.trace(turn, axis1=-2, axis2=-1) - 1.0))
    return Residual(float(np.linalg.norm(ours[..., :3, 3] - theirs[..., :3, 3], axis=-1).max()), float(angle.max()))
