"""What a motion may use of an arm's positions, speeds and torques, and how near it comes to floor, column and itself.

A link is a capsule: a ball of the link's radius swept from its joint to the next one. Radii are those with which the
arm is drawn (`arms.urdf.geometry.link_radii`), so that any arm has them. Distances have closed-form gradients in q:
the closest points of two capsules are fixed on their links to first order.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Self

import numpy as np

from lwr_dyn.arms.urdf.geometry import floor_height, link_radii, primitives, stand_foot
from lwr_dyn.codegen.kernels.batch import BatchDynamics, batch_dynamics
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.excitation.objectives import FourierBasis
from lwr_dyn.kinematics.forward import JointAxes, joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind, ends_of
from lwr_dyn.model.friction import friction_torque, smooth_friction

KEPT = 0.05
"""[m] Distance beyond the radii, where it is not given."""
_NEAR_SHARE = 0.3
"""Where it is not given, a pair keeps at most this share of the largest distance that it has in drawn poses."""
_LEAST_LENGTH = 1e-6
"""[m] Shorter links are a point."""
_UPRIGHT = 0.9
"""Cosine of the tilt up to which a base stands on the floor."""
_ROWS = 10_000
"""States whose points are in memory at a time."""
_POSES, _MOSTLY = 500, 0.2
"""A pair of capsules that is clear in less than this share of random poses is not one of real shapes."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """What is at least `height` [m] along `normal` (3,) is on the arm's side."""

    name: str
    normal: Array
    height: float


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """What keeps its distance from what: `of(q)` and `with_gradient(q)` give distances less what must be kept [m].

    Points 0 ... n - 1 are the origins of the joints, n the flange (or tool centre point), n + 1 the foot of the column.
    """

    arm: Arm
    kept: float
    """Distance beside the radii [m]."""
    floor: float
    """Height of the floor in the first frame of the chain [m]."""
    planes: tuple[Plane, ...]
    """The floor, and the wall or ceiling that carries a base which is not upright."""
    foot: Array
    capsules: tuple[tuple[int, int], ...]
    """The points at both ends of each."""
    radii: tuple[float, ...]
    pairs: tuple[tuple[int, int], ...]
    """Capsules that are far enough apart along the arm to collide."""
    low: tuple[tuple[int, float, int], ...]
    """Points that may meet a plane, their radius, and which plane."""
    near: Mapping[tuple[int, int], float] = field(default_factory=dict)
    """Pairs that are never far apart -> the smaller distance that they keep [m]."""

    @property
    def names(self) -> tuple[str, ...]:
        """What each distance is between, in order."""
        points = (*self.arm.joint_names, "the flange")
        return (
            *(f"{points[i]} and the {self.planes[plane].name}" for i, _, plane in self.low),
            *(f"{self._capsule(b)} and {self._capsule(a)}" for a, b in self.pairs),
        )

    @property
    def keeps(self) -> Array:
        """What each distance must be, (m,) [m]."""
        return np.array([*(self.kept for _ in self.low), *(self.near.get(pair, self.kept) for pair in self.pairs)])

    def of(self, q: Array) -> Array:
        """(k, m) distances at q (k, n), without what must be kept: below 0 it is too near."""
        parts = [q[i : i + _ROWS] for i in range(0, len(q), _ROWS)]
        return np.concatenate([self._distances(self._points(joint_axes(self.arm.chain, x)))[0] for x in parts])

    def with_gradient(self, q: Array) -> tuple[Array, Array]:
        """The distances (k, m) and their gradients (k, m, n)."""
        axes = joint_axes(self.arm.chain, q)
        points = self._points(axes)
        distances, pulls = self._distances(points)
        return distances, np.einsum("kmpx,kpxj->kmj", pulls, _point_jacobians(axes, points))

    def _points(self, axes: JointAxes) -> Array:
        ends = [axes.flange[..., None, :3, 3], np.broadcast_to(self.foot, (len(axes.p), 1, 3))]
        return np.concatenate([axes.p, *ends], axis=-2)

    def _distances(self, points: Array) -> tuple[Array, Array]:
        """(k, m) and their gradients (k, m, n + 2, 3) in the points."""
        k, count = points.shape[:2]
        values = np.empty((k, len(self.low) + len(self.pairs)))
        pulls = np.zeros((*values.shape, count, 3))
        for column, (i, radius, which) in enumerate(self.low):
            plane = self.planes[which]
            values[:, column] = points[:, i] @ plane.normal - plane.height - radius - self.kept
            pulls[:, column, i] = plane.normal
        for column, (a, b) in enumerate(self.pairs, len(self.low)):
            (p, r), (s, e) = self.capsules[a], self.capsules[b]
            x, y = closest_parts(points[:, p], points[:, r], points[:, s], points[:, e])
            shares = {p: 1.0 - x, r: x, s: y - 1.0, e: -y}
            between = sum(share[:, None] * points[:, i] for i, share in shares.items())
            length = np.linalg.norm(between, axis=1)
            values[:, column] = length - self.radii[a] - self.radii[b] - self.near.get((a, b), self.kept)
            away = between / np.maximum(length, 1e-9)[:, None]
            for i, share in shares.items():
                pulls[:, column, i] += share[:, None] * away
        return values, pulls

    def _capsule(self, i: int) -> str:
        start, end = self.capsules[i]
        return "the column" if end == self.arm.n + 1 else self.arm.chain.links[start].link


def clearance_of(
    arm: Arm, kept: float | None = None, floor: float | None = None, column: float | None = None
) -> Clearance:
    """The distances that an arm must keep.

    Parameters
    ----------
    kept : float, optional
        Distance beyond the radii of links and column [m]; if not given `KEPT`, and less for pairs that are never far
        apart: 0.3 of their largest distance in drawn poses.
    floor : float, optional
        Height in the first frame of the chain [m]; where the arm is drawn to stand if not given.
    column : float, optional
        Radius of the column under the base [m]; the largest that is drawn for the base if not given; 0 for none.

    Raises
    ------
    OptionError
        A distance or radius below 0, a height that is not finite.
    """
    for name, value in (("distance to keep", kept or 0.0), ("column", column or 0.0)):
        if not (math.isfinite(value) and value >= 0.0):
            raise OptionError(name, value, "0 or more, in m")
    if floor is not None and not math.isfinite(floor):
        raise OptionError("floor", floor, "a height in m")
    n, radii = arm.n, link_radii(arm.uninstalled())
    drawn = [shape.radius for shape in primitives(arm) if shape.link == "base"]
    width = max(drawn, default=0.0) if column is None else column
    spans = [*(joint.origin.position for joint in arm.joints()[1:]), arm.flange().position]
    long = [float(np.linalg.norm(span)) for span in spans]
    slides = [link.kind is JointKind.PRISMATIC for link in arm.chain.links]
    limbs = [i for i in range(n) if long[i] > _LEAST_LENGTH or slides[i]]
    capsules = (*([(0, n + 1)] if width > 0.0 else []), *((i, i + 1) for i in limbs))
    sizes = tuple(width if end > n else radii[start] for start, end in capsules)
    ends = [start if end > n else end for start, end in capsules]  # where the arm goes on: of the column at its top
    level = floor_height(arm) if floor is None else floor
    pairs = tuple(
        (a, b)
        for a, b in combinations(range(len(capsules)), 2)
        if sum(long[ends[a] : capsules[b][0]]) > sizes[a] + sizes[b] + KEPT
    )
    planes, (mount, _) = [Plane("floor", np.array([0.0, 0.0, 1.0]), level)], ends_of(arm.installation)
    up = mount.rotation[:, 2]
    if up[2] <= _UPRIGHT:
        planes.append(Plane("wall" if up[2] > -_UPRIGHT else "ceiling", up, float(up @ stand_foot(arm))))
    low = tuple((i + 1, radii[i], plane) for plane in range(len(planes)) for i in limbs)
    every = Clearance(
        arm, KEPT if kept is None else kept, level, tuple(planes), stand_foot(arm), capsules, sizes, pairs, low
    )
    return _of_real_shapes(every, kept is None)


def random_positions(arm: Arm, count: int, rng: np.random.Generator) -> Array:
    """(count, n) positions inside the limits, within +-pi where they are unknown."""
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    return np.asarray(rng.uniform(np.minimum(lower, upper), np.maximum(lower, upper), (count, arm.n)))


def _of_real_shapes(every: Clearance, less_for_near: bool) -> Clearance:
    """Without distances that no motion changes, and without pairs whose capsules meet in most poses.

    Those are links whose shape is not that of a capsule from joint to joint. With `less_for_near`, pairs that are never
    far apart keep less.
    """
    values = every.of(random_positions(every.arm, _POSES, np.random.default_rng(0)))
    moves = np.ptp(values, axis=0) > _LEAST_LENGTH
    real = np.mean(values + every.kept > 0.0, axis=0) > _MOSTLY
    count = len(every.low)
    low = tuple(x for x, keep in zip(every.low, moves[:count], strict=True) if keep)
    pairs = tuple(x for x, keep in zip(every.pairs, (moves & real)[count:], strict=True) if keep)
    widest = dict(zip(every.pairs, (values.max(axis=0) + every.kept)[count:], strict=True))
    least = {pair: max(_NEAR_SHARE * widest[pair], 0.0) for pair in pairs if less_for_near}
    near = {pair: keep for pair, keep in least.items() if keep < every.kept}
    return replace(every, low=low, pairs=pairs, near=near)


def closest_parts(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array]:
    """Where segments a-b and c-d, (k, 3) each, are nearest to each other: shares of their lengths, (k,) each.

    References
    ----------
    Ericson, Real-Time Collision Detection (2005), section 5.1.9.

    >>> x = np.eye(3)[:1]
    >>> closest_parts(0 * x, x, 0.25 * x + [[0, 0, 1]], 0.25 * x + [[0, 0, 3]])
    (array([0.25]), array([0.]))
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (np.einsum("kx,kx->k", x, y) for x, y in ((u, u), (v, v), (u, v)))
    uw, vw = np.einsum("kx,kx->k", u, w), np.einsum("kx,kx->k", v, w)
    small, one = _LEAST_LENGTH**2, np.ones(len(u))
    across = uu * vv - uv**2
    share = (uv * vw - uw * vv) / np.where(across > 0.0, across, one)
    x = np.where(across > 1e-12 * uu * vv, np.clip(share, 0.0, 1.0), 0.0)
    y = np.where(vv > small, np.clip((uv * x + vw) / np.maximum(vv, small), 0.0, 1.0), 0.0)
    x = np.where(uu > small, np.clip((uv * y - uw) / np.maximum(uu, small), 0.0, 1.0), 0.0)
    return x, y


def _point_jacobians(axes: JointAxes, points: Array) -> Array:
    """d point / d q, (k, n + 2, 3, n): a joint moves the origins of those after it and the flange, not the foot."""
    n = axes.p.shape[1]
    turning = np.array(axes.revolute)[:, None]
    lever = points[:, :, None, :] - axes.p[:, None, :, :]
    motion = np.where(turning, np.cross(axes.z[:, None, :, :], lever), axes.z[:, None, :, :])
    moved = np.arange(n + 2)[:, None] > np.arange(n)
    moved[n + 1] = False
    return np.asarray(np.swapaxes(motion * moved[:, :, None], -1, -2))


MARGIN = 0.1
"""[rad] Kept from the position limits of a turning joint."""
SLIDING_MARGIN = 0.05
"""Share of its travel that a sliding joint keeps from its limits."""
SPEED_SHARE, TORQUE_SHARE = 0.9, 0.8
"""Of the limits, which a motion may use."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionLimits:
    """lower <= q <= upper, |dq| <= speed, |tau| <= torque, (n,) each [SI]; torque is infinite where it is unknown."""

    lower: Array
    upper: Array
    speed: Array
    torque: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "lower", "upper", "speed", "torque")

    @classmethod
    def of(
        cls, arm: Arm, margin: float = MARGIN, speed_share: float = SPEED_SHARE, torque_share: float = TORQUE_SHARE,
        unknown_speed: float | None = None,
    ) -> Self:  # fmt: skip
        """The limits of an arm.

        Parameters
        ----------
        margin : float
            [rad] Kept from position limits; sliding joints keep `SLIDING_MARGIN` of their travel. A turning joint
            without limits may use +-pi.
        speed_share, torque_share : float
            Of the arm's limits, above 0, at most 1.
        unknown_speed : float, optional
            [rad/s or m/s] Speed limit of joints whose own is unknown.

        Raises
        ------
        OptionError
            A number out of its range, margins that leave nothing, a sliding joint without position limits, a joint
            without speed limit when `unknown_speed` is not given.
        """
        for name, share in (("speed share", speed_share), ("torque share", torque_share)):
            if not 0.0 < share <= 1.0:
                raise OptionError(name, share, "above 0, at most 1")
        if not (math.isfinite(margin) and margin >= 0.0):
            raise OptionError("margin", margin, "0 or more, in rad")
        slides = np.array([link.kind is JointKind.PRISMATIC for link in arm.chain.links])
        lower, upper = (np.where(np.isinf(x) & ~slides, s * np.pi, x) for x, s in ((arm.lower, -1), (arm.upper, 1)))
        travel = upper - lower
        kept = np.where(slides, SLIDING_MARGIN * travel, margin)
        for j, name in enumerate(arm.joint_names):
            if not (np.isfinite(travel[j]) and travel[j] > 2.0 * kept[j]):
                more = f"more than twice the margin of {_in_words(kept[j], slides[j])}"
                found = " to ".join(_in_words(x[j], slides[j]) for x in (lower, upper))
                raise OptionError(f"travel of {name}", "unknown" if math.isinf(travel[j]) else found, more)
        speed = np.where(np.isinf(arm.velocity), np.nan if unknown_speed is None else unknown_speed, arm.velocity)
        for j, name in enumerate(arm.joint_names):
            if not (math.isfinite(speed[j]) and speed[j] > 0.0):
                needed = "a limit for it, rad/s or m/s: unknown_speed (--joint-speed)"
                raise OptionError(f"speed limit of {name}", "unknown", needed)
        return cls(lower + kept, upper - kept, speed_share * speed, torque_share * arm.effort)

    def fitted(self, X: Array, basis: FourierBasis, fill: bool = False) -> Array:
        """Coordinates (b, n) whose motion is inside position and speed limits at the instants of the basis.

        A joint that is outside moves less about its centre, and its centre is shifted; `fill` also lets it move more.
        """
        out = X.copy()
        out[0] = 0.0
        q, dq = basis.position @ out, basis.speed @ out
        room = np.minimum(self.speed / np.abs(dq).max(axis=0), (self.upper - self.lower) / np.ptp(q, axis=0))
        share = room if fill else np.minimum(1.0, room)
        out *= share
        out[0] = np.clip(X[0], self.lower - share * q.min(axis=0), self.upper - share * q.max(axis=0))
        return out


def _in_words(x: float, slides: bool) -> str:
    return f"{x:.3g} m" if slides else f"{math.degrees(x):.4g} deg ({x:.3g} rad)"


STEP, WIDTH = 1e-4, 0.05
"""[rad/s or m/s] Step of the differences of friction by speed, and the speed that smooths its sign in the search."""


@dataclass(frozen=True, slots=True, eq=False)
class TorqueUse:
    """Torques of an arm against `limit` (n,) [N m or N], infinite where it is unknown."""

    arm: Arm
    limit: Array
    dynamics: BatchDynamics

    @classmethod
    def of(cls, arm: Arm, limit: Array) -> "TorqueUse":
        """Raises `MissingDataError`, `MissingPackageError`."""
        arm.require_dynamics()
        return cls(arm, limit, batch_dynamics(arm))

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """(k, n) [N m or N], with the friction that the arm's file gives, none where it gives none."""
        return np.asarray(self.dynamics.inverse_dynamics(q, dq, ddq)) + friction_torque(self.arm.friction_models(), dq)

    def share(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Largest share of its limit that each joint uses, (n,); 0 where the limit is unknown."""
        return np.asarray(np.abs(self.torque(q, dq, ddq)).max(axis=0) / self.limit)

    def room(self, basis: FourierBasis, X: Array) -> Array:
        """1 - |tau| / limit at the instants of a motion, (2, k, j), of both signs and of the joints with a limit."""
        q, dq, ddq = basis.position @ X, basis.speed @ X, basis.acceleration @ X
        tau = self.dynamics.inverse_dynamics(q, dq, ddq) + smooth_friction(self.arm.friction_models(), WIDTH)(dq)
        share = (tau / self.limit)[:, np.isfinite(self.limit)]
        return np.stack([1.0 - share, 1.0 + share])

    def room_gradient(self, basis: FourierBasis, X: Array) -> Array:
        """Its derivative by the coordinates, (2 k j, b n)."""
        q, dq, ddq = basis.position @ X, basis.speed @ X, basis.acceleration @ X
        by = self.dynamics.inverse_dynamics_derivatives(q, dq, ddq)
        friction = smooth_friction(self.arm.friction_models(), WIDTH)
        slope = (friction(dq + STEP) - friction(dq - STEP)) / (2.0 * STEP)
        by_dq = np.asarray(by.by_dq) + slope[:, :, None] * np.eye(self.arm.n)
        known = np.isfinite(self.limit)
        parts = ((by.by_q, basis.position), (by_dq, basis.speed), (by.by_ddq, basis.acceleration))
        rows = sum(np.einsum("kij,kc->kicj", D / self.limit[:, None], P)[:, known] for D, P in parts)
        flat = np.asarray(rows).reshape(-1, X.size)
        return np.vstack([-flat, flat])
