"""The Denavit-Hartenberg table of any serial arm, in either convention, computed from its joint axes.

    standard  T_base,flange = base  prod_i [Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i)]  flange
    modified  T_base,flange = base  prod_i [Tx(a_i) Rx(alpha_i) Rz(theta_i) Tz(d_i)]  flange

n rows have 4 n numbers; the frames of base and flange need more, so two constant poses may remain. All joint positions
read as before: a zero of the arm is a zero of the table.
"""

from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.arms.export.screws import COINCIDENT, PARALLEL, Normal, Screw, decomposed
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain, ChainLink, link_frames
from lwr_dyn.model.dh import Convention, DHRow, JointKind
from lwr_dyn.model.spatial import Pose

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
