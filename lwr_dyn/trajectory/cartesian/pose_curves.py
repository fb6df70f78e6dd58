"""Curves of poses in space: a straight line with the shortest turn, or a smooth curve through several poses.

Waypoints come from a CSV file (`trajectory.csv_rows`), a row each: poses of the tip in the base, its places alone (the
orientation is then free), or joint positions, and perhaps the time at which each is reached.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FaultError, OptionError
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.trajectory.csv_rows import ANGLES, PLACE, read_rows

ALLOWED = "x, y, z and perhaps roll, pitch, yaw; or q1, q2, ...; and perhaps time"

MOST_ROWS = 10_000
"""Waypoints of a file at most."""


class WaypointError(FaultError, ValueError):
    """A waypoint file cannot be used: which `file`, where in it."""

    def __init__(self, file: str, where: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {where}", found, allowed)
        self.file = file


@dataclass(frozen=True, slots=True, eq=False)
class Waypoints:
    """The rows of a file in SI: `poses` (m, 4, 4), `places` (m, 3) or `joints` (m, n); `times` (m,) [s] where given."""

    poses: Array | None = None
    places: Array | None = None
    joints: Array | None = None
    times: Array | None = None

    def tip_poses(self) -> Array:
        """Poses (m, 4, 4) of the tip; places alone with the orientation of the base."""
        if self.poses is not None:
            return self.poses.copy()
        places = np.zeros((0, 3)) if self.places is None else self.places
        poses = np.tile(np.eye(4), (len(places), 1, 1))
        poses[:, :3, 3] = places
        return poses

    def joint_positions(self, n: int, file: str) -> Array:
        """Joint positions (m, n); raises `WaypointError` for another number of joints."""
        joints = np.zeros((0, 0)) if self.joints is None else self.joints
        if joints.shape[1] != n:
            raise WaypointError(file, "columns", f"q1 to q{joints.shape[1]}", f"q1 to q{n}")
        return joints


def read_waypoints(path: str | Path) -> Waypoints:
    """The waypoints of a CSV file.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    WaypointError
        Columns that are missing, unknown, twice or of another unit; a cell that is no finite number; fewer than two
        rows or more than `MOST_ROWS`; times that do not rise.
    """
    rows = read_rows(path, WaypointError, "waypoints", "waypoint", 2, MOST_ROWS)
    columns = rows.numbers(rows.known(ALLOWED))
    times = columns.pop("time", None)
    if times is not None and not (np.diff(times) > 0.0).all():
        row = int(np.argmax(np.diff(times) <= 0.0)) + 2
        found = f"{times[row - 1]:g} s after {times[row - 2]:g} s"
        raise WaypointError(rows.file, f"row {row}, time", found, "rising times")
    return _waypoints(rows.file, columns, times)


def _waypoints(file: str, columns: Mapping[str, Array], times: Array | None) -> Waypoints:
    joints = [f"q{k + 1}" for k in range(len(columns))]
    if set(columns) == set(joints):
        return Waypoints(joints=np.stack([columns[name] for name in joints], axis=1), times=times)
    if set(columns) not in (set(PLACE), {*PLACE, *ANGLES}):
        raise WaypointError(file, "columns", ", ".join(columns) or "time alone", ALLOWED)
    places = Waypoints(places=np.stack([columns[name] for name in PLACE], axis=1), times=times)
    if len(columns) == len(PLACE):
        return places
    poses = places.tip_poses()
    poses[:, :3, :3] = [from_rpy(rpy) for rpy in np.stack([columns[name] for name in ANGLES], axis=1)]
    return Waypoints(poses=poses, times=times)


HALF_TURN = np.pi - 1e-6
"""[rad] From here on the shortest turn has two ways round."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseCurve:
    """Poses T(u) (k, 4, 4) [m] of the tip in the base, for u (k,) from 0 to 1."""

    poses: Callable[[Array], Array]
    length: float
    """Length of the way [m]."""
    turn: float
    """Angle of all turns on the way [rad]."""
    marks: tuple[float, ...] = (0.0, 1.0)
    """u of each of the waypoints on the curve."""


def straight(start: Array, end: Array, name: str = "end") -> PoseCurve:
    """The straight line from pose `start` to pose `end` (4, 4), turning about one axis at a constant share of u.

    Raises
    ------
    OptionError
        Half a turn between the poses: no way round is the shortest. `name` names the end in the message.

    References
    ----------
    Siciliano et al., Robotics, sec. 4.3.3, orientation by angle and axis.

    >>> end = np.eye(4); end[0, 3] = 0.5
    >>> straight(np.eye(4), end).poses(np.array([0.5]))[0, :3, 3]
    array([0.25, 0.  , 0.  ])
    """
    shift = end[:3, 3] - start[:3, 3]
    turn = turn_between(start, end, name)

    def poses(u: Array) -> Array:
        R = Rotation.from_rotvec(np.outer(u, turn)).as_matrix() @ start[:3, :3]
        return _stacked(R, start[:3, 3] + np.outer(u, shift))

    return PoseCurve(poses, float(np.linalg.norm(shift)), float(np.linalg.norm(turn)))


def through(waypoints: Array, scale: float = 1.0) -> PoseCurve:
    """A curve without corners through poses (m, 4, 4), m >= 3: cubic splines of place and orientation.

    u is proportional to the chords; a turn of 1 rad counts as a way of `scale` [m].

    Raises
    ------
    OptionError
        Half a turn between two neighbours, or two that are the same.

    References
    ----------
    Park and Ravani, Smooth invariant interpolation of rotations, ACM Trans. Graphics 16 (1997), by SciPy.
    """
    turns = [turn_between(a, b, f"waypoint {k}") for k, (a, b) in enumerate(pairwise(waypoints), 2)]
    chords = np.linalg.norm(np.diff(waypoints[:, :3, 3], axis=0), axis=1)
    steps = np.hypot(chords, scale * np.linalg.norm(turns, axis=1))
    if not (steps > 0.0).all():
        where = int(np.argmin(steps)) + 1
        raise OptionError(f"waypoints {where} and {where + 1}", "the same pose", "waypoints apart from each other")
    u = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    place = make_interp_spline(u, waypoints[:, :3, 3], k=min(3, len(u) - 1))
    orientation = RotationSpline(u, Rotation.from_matrix(waypoints[:, :3, :3]))

    def poses(at: Array) -> Array:
        return _stacked(orientation(at).as_matrix(), place(at))

    ways, angles = steps_between(poses(np.linspace(0.0, 1.0, 40 * len(u))))
    return PoseCurve(poses, float(ways.sum()), float(angles.sum()), tuple(float(x) for x in u))


def steps_between(poses: Array) -> tuple[Array, Array]:
    """Distances [m] and angles [rad], (k - 1,) each, from each of the poses (k, 4, 4) to the next."""
    relative = np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]
    ways = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    return np.asarray(ways), np.asarray(Rotation.from_matrix(relative).magnitude())


def turn_between(start: Array, end: Array, name: str) -> Array:
    """The rotation vector (3,) [rad], in the base, of the shortest turn; raises `OptionError` for half a turn."""
    turn: Array = Rotation.from_matrix(end[:3, :3] @ start[:3, :3].T).as_rotvec()
    if np.linalg.norm(turn) > HALF_TURN:
        raise OptionError(name, "half a turn from the pose before", "less than 180 deg; put a waypoint in between")
    return turn


def _stacked(R: Array, p: Array) -> Array:
    T = np.zeros((len(p), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, p, 1.0
    return T
