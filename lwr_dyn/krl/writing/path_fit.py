"""Motions of KRL that follow a sampled path within a tolerance, each as long as it can be; and how far a run is off.

Each sample is compared with the nearest place that the program passes in the motion written for it or in the motions
beside it, and each place of the program with the nearest place between the samples. Near is meant in position and
orientation together, each by its tolerance; times are not compared.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.motion_segments import tool_pose
from lwr_dyn.krl.motion.pose_paths import NEAR, PosePath, path_between
from lwr_dyn.krl.robot.kuka_pose import rotation_angle
from lwr_dyn.krl.running.program_run import ProgramRun
from lwr_dyn.krl.writing.sampled_path import SampledPath
from lwr_dyn.trajectory.path import ArcSegment, LineSegment

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
    reach = _reach(samples, tolerance[0], only_ptp)

    def farthest(kind: str, first: int) -> int:
        """The last sample that a motion of this kind from sample `first` can reach; `first` if none."""
        stop = min((k for k in samples.pauses if k > first), default=len(samples.q) - 1)
        most = stop if kind == "PTP" else min(stop, int(reach[first]))
        return _farthest(partial(_FOLLOWS[kind], samples, tolerance, first), first, most, 2 if kind == "CIRC" else 1)

    motions = []
    at, end = 0, len(samples.q) - 1
    while at < end:
        last, order = max(((farthest(kind, at), -KINDS.index(kind)) for kind in kinds), default=(at, 0))
        kind = KINDS[-order]
        if last == at:
            kind, last = "PTP", farthest("PTP", at)
        motions.append(FittedMotion(kind, at, last, (at + last) // 2 if kind == "CIRC" else None))
        at = last
    return tuple(motions)


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
    return bool(within(tool_pose(samples.arm, on_line, samples.tool), samples.T[first : last + 1], tolerance).all())


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


def within(T: Array, wanted: Array, tolerance: tuple[float, float]) -> Array:
    """Whether poses (k, 4, 4) are within a tolerance [m, rad] of those wanted, (k,)."""
    away = np.linalg.norm(T[:, :3, 3] - wanted[:, :3, 3], axis=1)
    return np.asarray((away <= tolerance[0]) & (rotation_angle(T[:, :3, :3], wanted[:, :3, :3]) <= tolerance[1]))


def _in_order(share: Array, slack: float) -> bool:
    """Whether a path is not run back by more than a share of it."""
    return bool((np.maximum.accumulate(share) - share).max() <= slack)


FEWEST, MOST = 16, 20_000
"""Places of a motion."""
EVEN = 3000
CORNERS = 4
"""Nearest corners of a line whose pieces are tried: where a path comes back to a place, more than one piece begins."""
FINEST = 0.02
"""Share of the tolerance by which the program's path bends between two places at most."""


@dataclass(frozen=True, slots=True)
class PathDeviation:
    """The largest distance [m] and angle [rad] between a program's path and the samples."""

    position: float
    orientation: float

    def holds(self, tolerance: Tolerance) -> bool:
        """Whether both are within the tolerance."""
        return self.position <= tolerance.position and self.orientation <= tolerance.orientation


def path_deviation(
    samples: SampledPath, motions: Sequence[FittedMotion], run: ProgramRun, tolerance: Tolerance
) -> PathDeviation:
    """Compares a run of the written program with its samples."""
    moved = [x for x in run.executed[1:] if x.kind != "WAIT"]
    weight = tolerance.position / tolerance.orientation
    worst = np.zeros(2)
    ends = np.cumsum([len(motion.knots) or 1 for motion in motions])
    spans = [(moved[b - (len(m.knots) or 1)].begin, moved[b - 1].end) for m, b in zip(motions, ends, strict=True)]
    places = [_program_places(samples, run, begin, end, FINEST * tolerance.position) for begin, end in spans]
    written = [samples.T[m.first : m.last + 1] for m in motions]
    for i in range(len(motions)):
        around = slice(max(i - 1, 0), i + 2)
        worst = np.maximum(worst, _farthest_place(written[i], np.concatenate(places[around]), weight))
        worst = np.maximum(worst, _farthest_place(places[i], np.concatenate(written[around]), weight))
    return PathDeviation(float(worst[0]), float(worst[1]))


def _program_places(samples: SampledPath, run: ProgramRun, begin: float, end: float, finest: float) -> Array:
    """Poses (k, 4, 4) [m] between two times, so near to each other that the path bends less than `finest` [m]."""
    count = FEWEST
    while True:
        T = tool_pose(samples.arm, run.timeline.sample(np.linspace(begin, end, count + 1)).q, samples.tool)
        bend = float(np.linalg.norm(np.diff(T[:, :3, 3], 2, axis=0), axis=1).max()) / 8.0
        if bend <= finest or count >= MOST:
            return T
        count = int(min(MOST, np.ceil(1.1 * count * np.sqrt(bend / finest))))


def _farthest_place(T: Array, others: Array, weight: float) -> Array:
    """The largest distance [m] and angle [rad] of poses (k, 4, 4) from the path between others (m, 4, 4)."""
    points, line = _embedded(T, weight), _even(_embedded(others, weight))
    nearest = cKDTree(line).query(points, min(CORNERS, len(line)))[1]
    best = np.full((len(points), 3), np.inf)
    for first in np.vstack([nearest.T - 1, nearest.T]):
        a = np.clip(first, 0, len(line) - 2)
        way = line[a + 1] - line[a]
        u = np.clip(np.sum((points - line[a]) * way, axis=1) / np.maximum(np.sum(way * way, axis=1), 1e-300), 0.0, 1.0)
        miss = points - line[a] - u[:, None] * way
        # |R - S| = sqrt(2) angle for a small angle
        away, turned = np.linalg.norm(miss[:, :3], axis=1), np.linalg.norm(miss[:, 3:], axis=1) / weight
        parts = np.stack([np.linalg.norm(miss, axis=1), away, turned], axis=1)
        best = np.where((parts[:, 0] < best[:, 0])[:, None], parts, best)
    return np.asarray(best[:, 1:].max(axis=0))


def _even(line: Array) -> Array:
    """The same line with `EVEN` corners more at even steps, so that the nearest corner is beside the nearest piece."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.unique(np.concatenate([along, np.linspace(0.0, along[-1], EVEN)]))
    return np.stack([np.interp(at, along, column) for column in line.T], axis=1)


def _embedded(T: Array, weight: float) -> Array:
    """Poses as points (k, 12) whose distances are those of positions [m] and, weighed, of orientations."""
    return np.hstack([T[:, :3, 3], weight / np.sqrt(2.0) * T[:, :3, :3].reshape(-1, 9)])
