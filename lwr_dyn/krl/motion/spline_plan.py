"""Plans SPLINE and PTP_SPLINE blocks whole: the fastest speeds on their path under all bounds, rest to rest.

Bounds: $VEL.CP, $ACC.CP along and across the path, $VEL.ORI1, $ACC.ORI1 about each axis of the base, and speed and
acceleration of each axis ($VEL_AXIS, $ACC_AXIS). A motion of the block keeps its own bounds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import Report
from lwr_dyn.krl.motion.motion_segments import AxisSplineSegment, CartesianSegment, axes_of_poses
from lwr_dyn.krl.motion.path_axes import axes_along
from lwr_dyn.krl.motion.path_speed import PathLimits, fastest_speeds, profile_along, with_fine_ends
from lwr_dyn.krl.motion.pose_paths import STILL
from lwr_dyn.krl.motion.settings import Speeds
from lwr_dyn.krl.motion.spline_path import SplinePiece
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import constant_speed
from lwr_dyn.trajectory.path import Path
from lwr_dyn.trajectory.pose_path import TimedPosePath

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
    s = with_fine_ends(with_points(even, np.sort(marks.ravel())))
    along = TimedPosePath(Path((path.segment,)), path.orientation, constant_speed(whole, whole))
    T = along.poses(s)
    table = axes_along(arm, start, T @ np.linalg.inv(tool), s / whole, report)
    if table is None:
        return None
    fine = np.interp(np.arange(BETWEEN * (len(s) - 1) + 1) / BETWEEN, np.arange(len(s)), s)
    place, turn = path.segment.at(fine), path.orientation.at(fine)
    first, second = np.hstack([place.dp, turn.rate]), np.hstack([place.ddp, turn.d_rate])
    bounds = [speeds[i] for i in np.minimum(np.searchsorted(piece.ends, fine - STILL), len(speeds) - 1)]
    in_space, nodes = _limits_in_space(fine, first, second, bounds), slice(None, None, BETWEEN)
    axes = axes_of_poses(arm, tool, table.branch, T, first[nodes], second[nodes], table.q)
    x = fastest_speeds(_both(_at_nodes(in_space), _axis_limits(s, axes.dq, axes.ddq, bounds[nodes])))
    timed = TimedPosePath(along.path, path.orientation, profile_along("spline", s, x))
    return CartesianSegment(arm, tool, path, timed, table.branch, table.q[np.isin(s, even)], speeds[-1])


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
    s = with_fine_ends(with_points(even, marks))
    bounds = [speeds[i] for i in np.minimum(np.searchsorted(ends, s - STILL), len(speeds) - 1)]
    x = fastest_speeds(_axis_limits(s, curve(s, 1), curve(s, 2), bounds))
    return AxisSplineSegment(arm, curve, profile_along("spline", s, x), speeds[-1]), ends


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
