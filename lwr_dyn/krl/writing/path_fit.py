"""Motions of KRL that follow a sampled path within a tolerance: LIN, CIRC and PTP, each as long as it can be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.path_axes import NEAR
from lwr_dyn.krl.motion.pose_paths import PosePath, path_between
from lwr_dyn.krl.writing.sampled_path import SampledPath
from lwr_dyn.trajectory.segments import ArcSegment, LineSegment

KINDS = ("LIN", "CIRC", "PTP", "SPL", "SPTP")
BLOCKS = {"SPL": "SPLINE", "SPTP": "PTP_SPLINE"}
"""Kinds of motion that stand in a block."""
USUAL = ("LIN", "CIRC", "PTP")
"""Those whose path is known: KUKA's curves of SPL and SPTP are not published."""
CLEAR = 2.0 * NEAR
"""[rad] A path in space stays this far from the wrist singularity; nearer to it only PTP is used."""
BRANCH = 1e-6
"""[rad] Axes this near to a branch are on it."""
SHOULDER, ELBOW = 0.01, 10.0
"""[m] from the shoulder singularity; [rad^2/m] a bend of the elbow for each metre that it is short of its reach."""
LONGEST_ARC = np.radians(300.0)


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far a program's path may be from the samples: position [m], orientation [rad]; raises `OptionError`."""

    position: float = 1e-4
    orientation: float = 1e-3

    def __post_init__(self) -> None:
        if not 1e-6 <= self.position <= 1.0:
            raise OptionError("tolerance", f"{1e3 * self.position:g} mm", "from 0.001 to 1000 mm")
        if not 1e-5 <= self.orientation <= 1.0:
            raise OptionError("tolerance", f"{np.degrees(self.orientation):g} deg", "from 0.001 to 57 deg")

    def times(self, share: float) -> tuple[float, float]:
        """A share of both."""
        return share * self.position, share * self.orientation


@dataclass(frozen=True, slots=True, eq=False)
class FittedMotion:
    """A motion, or a block, from sample `first` to `last`; `via` is the sample of CIRC's auxiliary point."""

    kind: str
    first: int
    last: int
    via: int | None = None
    knots: tuple[int, ...] = ()
    """The samples of the points of a block, `last` among them."""

    def path(self, samples: SampledPath) -> PosePath:
        """The path of LIN or CIRC."""
        through = None if self.via is None else samples.T[self.via]
        return path_between(samples.T[self.first], samples.T[self.last], through)


def fitted_motions(
    samples: SampledPath,
    tolerance: tuple[float, float],
    kinds: tuple[str, ...] = USUAL,
    only_ptp: Sequence[tuple[int, int]] = (),
) -> tuple[FittedMotion, ...]:
    """The samples from first to last as motions, each the kind that reaches farthest within the tolerance.

    The tolerance is [m] and [rad]. Where a path in space would be singular it is PTP, whatever the kinds, and so it is
    between the samples of `only_ptp`.
    """
    fit = _Fit(samples, tolerance, _reach(samples, tolerance[0], only_ptp))
    motions = []
    at, end = 0, len(samples.q) - 1
    while at < end:
        best = max(((fit.farthest(kind, at), -KINDS.index(kind)) for kind in kinds), default=(at, 0))
        kind = KINDS[-best[1]]
        last = best[0]
        if last == at:
            kind, last = "PTP", fit.farthest("PTP", at)
        motions.append(FittedMotion(kind, at, last, (at + last) // 2 if kind == "CIRC" else None))
        at = last
    return tuple(motions)


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """How far a motion of one kind follows the samples; `reach` is where a path in space from each ends at most."""

    samples: SampledPath
    tolerance: tuple[float, float]
    reach: Array

    def farthest(self, kind: str, first: int) -> int:
        """The last sample that a motion of this kind from sample `first` can reach; `first` if none."""
        stop = min((k for k in self.samples.pauses if k > first), default=len(self.samples.q) - 1)
        most = stop if kind == "PTP" else min(stop, int(self.reach[first]))
        follows = partial(_FOLLOWS[kind], self.samples, self.tolerance, first)
        return _farthest(follows, first, most, 2 if kind == "CIRC" else 1)


def _reach(samples: SampledPath, tolerance: float, only_ptp: Sequence[tuple[int, int]]) -> Array:
    """For each sample the last one (k,) that a path in space gets to: one branch, clear of singularities."""
    q, rows = samples.q, np.arange(len(samples.q))
    branches = all_branches(samples.arm, samples.T @ np.linalg.inv(samples.tool))
    away = np.abs((branches.q - q[:, None] + np.pi) % (2.0 * np.pi) - np.pi).max(axis=-1)
    away = np.where(np.isnan(away), np.inf, away)
    branch = np.argmin(away, axis=1)
    # a chord of a path that touches the reach would leave it
    clear = (tolerance + SHOULDER, np.sqrt(ELBOW * tolerance) + CLEAR, CLEAR)
    regular = (branches.clearance[rows, branch] > clear).all(axis=1) & (away[rows, branch] < BRANCH)
    goes_on = regular[1:] & regular[:-1] & (branch[1:] == branch[:-1])
    for first, last in only_ptp:
        goes_on[first:last] = False
    ends = np.append(np.where(goes_on, len(q) - 1, rows[:-1]), len(q) - 1)
    return np.asarray(np.minimum.accumulate(ends[::-1])[::-1])


def _farthest(follows: Callable[[int], bool], first: int, most: int, least: int) -> int:
    """By steps that double as long as they follow, then halving."""
    good, step = first, least
    while good < most and follows(min(first + step, most)):
        good, step = min(first + step, most), 2 * step
    bad = min(first + step, most + 1)
    while bad - good > 1 and good > first:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if follows(middle) else (good, middle)
    return good


def _ptp_follows(samples: SampledPath, tolerance: tuple[float, float], first: int, last: int) -> bool:
    q = samples.q[first : last + 1]
    way = q[-1] - q[0]
    u = (q - q[0]) @ way / max(float(way @ way), 1e-300)
    if last > first + 1 and not _in_order(u, 1e-3):
        return False
    on_line = q[0] + np.clip(u, 0.0, 1.0)[:, None] * way
    T = flange_pose(samples.arm.chain, on_line) @ samples.tool
    return bool(within(T, samples.T[first : last + 1], tolerance).all())


def _path_follows(
    through_middle: bool, samples: SampledPath, tolerance: tuple[float, float], first: int, last: int
) -> bool:
    motion = FittedMotion("LIN", first, last, (first + last) // 2 if through_middle else None)
    try:
        path = motion.path(samples)
    except ExecutionError:
        return False
    if path.is_still or (isinstance(path.segment, ArcSegment) and path.length > LONGEST_ARC * path.segment.radius):
        return False
    T = samples.T[first : last + 1]
    s = places(path, T)
    slack = tolerance[0] / path.segment.length if path.length > tolerance[0] else 1e-3
    if not _in_order(s / path.segment.length, slack):
        return False
    return bool(within(poses_at(path, s), T, tolerance).all())


_FOLLOWS: dict[str, Callable[[SampledPath, tuple[float, float], int, int], bool]] = {
    "LIN": partial(_path_follows, False),
    "CIRC": partial(_path_follows, True),
    "PTP": _ptp_follows,
}


def places(path: PosePath, T: Array) -> Array:
    """The lengths (k,) [m] on the path that are nearest to poses T (k, 4, 4)."""
    segment = path.segment
    if isinstance(segment, ArcSegment):
        out = T[:, :3, 3] - segment.centre
        angle = np.arctan2(out @ segment.y, out @ segment.x) % (2.0 * np.pi)
        whole = segment.length / segment.radius
        angle = np.where(angle > 0.5 * whole + np.pi, 0.0, angle)
        return np.asarray(np.clip(angle, 0.0, whole) * segment.radius)
    assert isinstance(segment, LineSegment)
    if path.length > 1e-6:
        return np.asarray(np.clip((T[:, :3, 3] - segment.start) @ segment.direction, 0.0, segment.length))
    turned = rotation_angle(T[:, :3, :3], path.orientation.at(np.zeros(1)).R)
    return np.asarray(np.clip(turned / max(path.angle, 1e-12), 0.0, 1.0) * segment.length)


def poses_at(path: PosePath, s: Array) -> Array:
    """T (k, 4, 4) [m] at lengths s (k,) [m]."""
    T = np.tile(np.eye(4), (len(s), 1, 1))
    T[:, :3, 3], T[:, :3, :3] = path.segment.at(s).p, path.orientation.at(s).R
    return T


def rotation_angle(R: Array, S: Array) -> Array:
    """The angle [rad] between rotations (..., 3, 3)."""
    return np.asarray(2.0 * np.arcsin(np.minimum(np.linalg.norm(R - S, axis=(-2, -1)) / np.sqrt(8.0), 1.0)))


def within(T: Array, wanted: Array, tolerance: tuple[float, float]) -> Array:
    """Whether poses (k, 4, 4) are within a tolerance [m, rad] of those wanted, (k,)."""
    away = np.linalg.norm(T[:, :3, 3] - wanted[:, :3, 3], axis=1)
    return np.asarray((away <= tolerance[0]) & (rotation_angle(T[:, :3, :3], wanted[:, :3, :3]) <= tolerance[1]))


def _in_order(share: Array, slack: float) -> bool:
    """Whether a path is not run back by more than a share of it."""
    return bool((np.maximum.accumulate(share) - share).max() <= slack)
