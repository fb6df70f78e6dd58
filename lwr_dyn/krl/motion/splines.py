"""SPLINE and PTP_SPLINE blocks, planned whole: their path, and the fastest speeds on it under all bounds, rest to rest.

A run of SPL is a curve through its points, with their distance as the parameter: cubic, with continuous second
derivatives, and free at the ends of the block; beside a SLIN or SCIRC it takes that one's direction and curvature, and
is then of degree 5. Where a SLIN or SCIRC changes direction by more than `CORNER` the arm has to stop. The orientation
is a cubic curve of quaternions Q through all points, with U = Q / |Q|, w = 2 U' U*, dw = 2 U'' U*. KUKA's own curve is
not published: this one is assumed.

Bounds: $VEL.CP, $ACC.CP along and across the path, $VEL.ORI1, $ACC.ORI1 about each axis of the base, and speed and
acceleration of each axis ($VEL_AXIS, $ACC_AXIS). A motion of the block keeps its own bounds.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.spatial.transform import Rotation

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError, Report
from lwr_dyn.krl.motion import pose_paths
from lwr_dyn.krl.motion.motion_segments import AxisSplineSegment, CartesianSegment, axes_of_poses
from lwr_dyn.krl.motion.pose_paths import STILL, PathLimits, PosePath, Speeds, path_between
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import constant_speed
from lwr_dyn.trajectory.path import SHORTEST, Path, PathSample, Segment
from lwr_dyn.trajectory.pose_path import RotationSample, Slerp, TimedPosePath, slerp

OPPOSITE = 0.1
"""Cosine of half the turn from one point to the next (168 deg): beyond, either way is nearly as short."""


@dataclass(frozen=True, slots=True, eq=False)
class QuaternionCurve:
    """A cubic curve through quaternions (x, y, z, w)."""

    curve: CubicSpline

    def at(self, s: Array) -> RotationSample:
        """At s (k,)."""
        Q, dQ, ddQ = (np.asarray(self.curve(s, i), dtype=np.float64) for i in range(3))
        n = np.linalg.norm(Q, axis=1)[:, None]
        U = Q / n
        along = _dot(U, dQ)
        dU = (dQ - U * along) / n
        change = ddQ - dU * along - U * (_dot(dU, dQ) + _dot(U, ddQ))
        ddU = change / n - dU * along / n
        R = np.asarray(Rotation.from_quat(U).as_matrix(), dtype=np.float64)
        return RotationSample(R, 2.0 * _vector_of_product(dU, U), 2.0 * _vector_of_product(ddU, U))


def orientation_through(s: Array, R: Array) -> Slerp | QuaternionCurve:
    """The orientation through rotations R (k, 3, 3) at s (k,); raises `ExecutionError` for nearly half a turn."""
    hint = "put a point in between: either way is as short"
    if len(s) == 2:
        try:
            return slerp(R[0], R[1], float(s[1]))
        except OptionError:
            raise ExecutionError("half-turn", "the orientation turns by 180 deg", hint) from None
    Q = np.asarray(Rotation.from_matrix(R).as_quat(), dtype=np.float64)
    for i in range(1, len(Q)):
        cosine = float(Q[i] @ Q[i - 1])
        if abs(cosine) < OPPOSITE:
            raise ExecutionError("half-turn", "the orientation turns by nearly 180 deg", hint)
        if cosine < 0.0:
            Q[i] = -Q[i]
    return QuaternionCurve(CubicSpline(s, Q, bc_type="natural"))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1, keepdims=True))


def _vector_of_product(a: Array, b: Array) -> Array:
    """The vector part (k, 3) of a b* for quaternions (k, 4)."""
    u, v = a[:, :3], b[:, :3]
    return np.asarray(b[:, 3:] * u - a[:, 3:] * v - np.cross(u, v))


CORNER = math.radians(1.0)
"""[rad]"""


@dataclass(frozen=True, slots=True, eq=False)
class SplinePoint:
    """A motion of a block: SPL, LIN or CIRC to a pose (4, 4) [m]; of CIRC the auxiliary pose and CA [rad]."""

    kind: str
    pose: Array
    through: Array | None = None
    angle: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PointCurve:
    """A curve through points; `curve` is a spline of scipy with its first two derivatives."""

    curve: tuple[Any, Any, Any]
    length: float
    """Of the parameter [m]: the sum of the distances."""

    def at(self, s: Array) -> PathSample:
        """Position and its derivatives at s (k,)."""
        return PathSample(*(np.asarray(f(s), dtype=np.float64) for f in self.curve))


@dataclass(frozen=True, slots=True, eq=False)
class SplinePiece:
    """A part of the path from stop to stop: poses along s, the s at which its motions end, and their indices."""

    path: PosePath
    ends: Array
    motions: tuple[int, ...]


def spline_pieces(start: Array, points: Sequence[SplinePoint]) -> Iterator[SplinePiece]:
    """The path from the pose `start` (4, 4) through all points, split where the arm stops.

    A point where the arm already stands is left out.
    """
    poses = [start, *(x.pose for x in points)]
    moved = [k for k, x in enumerate(points) if x.kind == "CIRC" or not path_between(poses[k], x.pose).is_still]
    lines = [_simple(poses[k], points[k]) for k in moved]
    begin = 0
    for i in range(1, len(moved) + 1):
        if i == len(moved) or _stops(lines[i - 1], lines[i]):
            part = moved[begin:i]
            yield _piece([poses[part[0]], *(poses[k + 1] for k in part)], lines[begin:i], part)
            begin = i


def _simple(start: Array, x: SplinePoint) -> Segment | None:
    """The line or arc of a motion; None for SPL, unless it only turns."""
    length = float(np.linalg.norm(x.pose[:3, 3] - start[:3, 3]))
    if x.kind == "SPL" and length >= SHORTEST:
        return None
    return path_between(start, x.pose, x.through, x.angle).segment


def _direction(line: Segment, at_end: bool) -> Array:
    return np.asarray(line.at(np.array([line.length if at_end else 0.0])).dp[0])


def _stops(before: Segment | None, after: Segment | None) -> bool:
    if before is None or after is None:
        # a curve takes the direction of a line or arc beside it, but there is none of a turn in place
        other = before or after
        return other is not None and float(np.linalg.norm(_direction(other, True))) < 0.5
    a, b = _direction(before, True), _direction(after, False)
    return float(a @ b) < math.cos(CORNER)


def _piece(poses: Sequence[Array], lines: Sequence[Segment | None], motions: Sequence[int]) -> SplinePiece:
    segments: list[Segment] = []
    ends: list[float] = []
    k = 0
    while k < len(lines):
        line, last, begin = lines[k], k, (ends[-1] if ends else 0.0)
        if line is not None:
            segments.append(line)
            ends.append(begin + line.length)
        else:
            while last + 1 < len(lines) and lines[last + 1] is None:
                last += 1
            points = np.array([pose[:3, 3] for pose in poses[k : last + 2]])
            before, after = (lines[k - 1] if k else None), (lines[last + 1] if last + 1 < len(lines) else None)
            knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
            segments.append(_curve(knots, points, before, after))
            ends += [begin + float(s) for s in knots[1:]]
        k = last + 1
    whole = Path(tuple(segments))
    marks = np.concatenate([[0.0], ends])
    orientation = orientation_through(marks, np.array([pose[:3, :3] for pose in poses]))
    s = np.linspace(0.0, whole.length, 40 * len(lines) + 1)
    length = float(np.trapezoid(np.linalg.norm(whole.at(s).dp, axis=1), s))
    angle = float(np.trapezoid(np.linalg.norm(orientation.at(s).rate, axis=1), s))
    return SplinePiece(PosePath(whole, orientation, length, angle), np.array(ends), tuple(motions))


def _curve(knots: Array, points: Array, before: Segment | None, after: Segment | None) -> PointCurve:
    """The curve through points (k, 3) at `knots` (k,)."""
    free = [(2, np.zeros(3))]
    degree, ends = 3, (free, free)
    if before is not None or after is not None:
        degree, free = 5, [(2, np.zeros(3)), (3, np.zeros(3))]
        ends = (_end(before, True) or free, _end(after, False) or free)
    bounds: Any = ends
    curve = make_interp_spline(knots, points, k=degree, bc_type=bounds)
    return PointCurve((curve, curve.derivative(1), curve.derivative(2)), float(knots[-1]))


def _end(line: Segment | None, at_end: bool) -> list[tuple[int, Array]] | None:
    if line is None:
        return None
    place = line.at(np.array([line.length if at_end else 0.0]))
    return [(1, place.dp[0]), (2, place.ddp[0])]


STEP_M, STEP_RAD = 0.001, math.radians(0.5)
"""[m], [rad] Distance of the nodes, between `FEWEST` and `MOST` steps."""
FEWEST, MOST = 200, 3000
PER_MOTION = 10
"""Steps at least on each motion of a block."""
BETWEEN = 4
"""Places from node to node at which the bend of the path is looked at."""


def spline_segment(
    arm: Arm, start: Array, tool: Array, piece: SplinePiece, speeds: Sequence[Speeds], report: Report
) -> CartesianSegment | None:
    """A piece of a block from axes `start` (n,), `speeds` of each of its motions; None with a reported fault."""
    path, whole = piece.path, piece.path.segment.length
    steps = int(np.clip(path.length / STEP_M + path.angle / STEP_RAD, FEWEST, MOST))
    even = np.linspace(0.0, whole, steps + 1)
    # a curve bends most at its points, and between near ones it changes quickly
    per_motion = max(1, min(PER_MOTION, MOST // len(piece.ends)))
    marks = np.linspace(np.append(0.0, piece.ends[:-1]), piece.ends, per_motion + 1)[1:]
    s = pose_paths.with_fine_ends(with_points(even, np.sort(marks.ravel())))
    along = TimedPosePath(Path((path.segment,)), path.orientation, constant_speed(whole, whole))
    T = along.poses(s)
    table = pose_paths.axes_along(arm, start, T @ np.linalg.inv(tool), s / whole, report)
    if table is None:
        return None
    branch, q = table
    fine = np.interp(np.arange(BETWEEN * (len(s) - 1) + 1) / BETWEEN, np.arange(len(s)), s)
    place, turn = path.segment.at(fine), path.orientation.at(fine)
    first, second = np.hstack([place.dp, turn.rate]), np.hstack([place.ddp, turn.d_rate])
    bounds = [speeds[i] for i in np.minimum(np.searchsorted(piece.ends, fine - STILL), len(speeds) - 1)]
    in_space, nodes = _limits_in_space(fine, first, second, bounds), slice(None, None, BETWEEN)
    axes = axes_of_poses(arm, tool, branch, T, first[nodes], second[nodes], q)
    x = pose_paths.fastest_speeds(_both(_at_nodes(in_space), _axis_limits(s, axes.dq, axes.ddq, bounds[nodes])))
    timed = TimedPosePath(along.path, path.orientation, pose_paths.profile_along(s, x))
    return CartesianSegment(arm, tool, path, timed, branch, q[np.isin(s, even)], speeds[-1])


def axis_spline_segment(arm: Arm, points: Array, speeds: Sequence[Speeds]) -> tuple[AxisSplineSegment, Array] | None:
    """PTP_SPLINE through axes `points` (k + 1, n), and the parameter (k,) at which its motions end.

    The parameter is the time of each motion at its set speed. None where nothing moves.
    """
    ways = np.abs(np.diff(points, axis=0))
    steps = np.array([np.max(way / x.axis) for way, x in zip(ways, speeds, strict=True)])
    moved = np.concatenate([[True], steps > STILL])
    ends = np.cumsum(steps)
    if not moved[1:].any():
        return None
    marks = np.concatenate([[0.0], ends])[moved]
    curve = CubicSpline(marks, points[moved], bc_type="natural")
    even = np.linspace(0.0, float(ends[-1]), int(np.clip(60 * len(steps), FEWEST, MOST)) + 1)
    s = pose_paths.with_fine_ends(with_points(even, marks))
    bounds = [speeds[i] for i in np.minimum(np.searchsorted(ends, s - STILL), len(speeds) - 1)]
    x = pose_paths.fastest_speeds(_axis_limits(s, curve(s, 1), curve(s, 2), bounds))
    return AxisSplineSegment(arm, curve, pose_paths.profile_along(s, x), speeds[-1]), ends


def with_points(even: Array, points: Array) -> Array:
    """Even nodes (k,) and, where none of them is near, the points."""
    far = np.abs(even[np.argmin(np.abs(even - points[:, None]), axis=1)] - points) > 0.05 * even[1]
    return np.sort(np.concatenate([even, points[far]]))


def _axis_limits(s: Array, first: Array, second: Array, bounds: Sequence[Speeds]) -> PathLimits:
    speed, ramp = np.array([b.axis for b in bounds]), np.array([b.axis_ramp for b in bounds])
    fastest = np.min((speed / np.maximum(np.abs(first), 1e-12)) ** 2, axis=1)
    return PathLimits(s, fastest, first, second, ramp)


def _limits_in_space(s: Array, first: Array, second: Array, bounds: Sequence[Speeds]) -> PathLimits:
    """Bounds of the path (rates of position and turn (k, 6) along s)."""
    cp, cp_ramp, ori, ori_ramp = np.array([(b.cp, b.cp_ramp, b.ori, b.ori_ramp) for b in bounds]).T
    dp, ddp, turn, d_turn = first[:, :3], second[:, :3], first[:, 3:], second[:, 3:]
    rate = np.maximum(np.linalg.norm(dp, axis=1), 1e-12)
    along = np.sum(dp * ddp, axis=1) / rate
    across = np.sqrt(np.maximum(np.sum(ddp**2, axis=1) - along**2, 0.0))
    fastest = np.minimum((cp / rate) ** 2, cp_ramp / np.maximum(across, 1e-12))
    fastest = np.minimum(fastest, (ori / np.maximum(np.linalg.norm(turn, axis=1), 1e-12)) ** 2)
    most = np.hstack([cp_ramp[:, None], np.tile(ori_ramp[:, None], (1, 3))])
    return PathLimits(s, fastest, np.hstack([rate[:, None], turn]), np.hstack([along[:, None], d_turn]), most)


def _at_nodes(fine: PathLimits) -> PathLimits:
    """Bounds at every `BETWEEN`-th node; x, which goes straight from node to node, keeps those between them too."""
    steps = np.lib.stride_tricks.sliding_window_view(fine.fastest, BETWEEN + 1)[::BETWEEN].min(axis=1)
    fastest = np.minimum(np.append(steps, np.inf), np.append(np.inf, steps))
    return PathLimits(fine.s[::BETWEEN], fastest, *(x[::BETWEEN] for x in (fine.first, fine.second, fine.most)))


def _both(a: PathLimits, b: PathLimits) -> PathLimits:
    wide = (np.hstack([getattr(a, name), getattr(b, name)]) for name in ("first", "second", "most"))
    return PathLimits(a.s, np.minimum(a.fastest, b.fastest), *wide)
