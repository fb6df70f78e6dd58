"""Poses along a path: a path in space, an orientation along it, and a motion profile that says when.

Without a time stand curves of poses: a straight line with the shortest turn, or a smooth curve through several poses.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.spatial import turn_about
from lwr_dyn.trajectory.motion_profile import MotionProfile, ProfileSample, positive_number
from lwr_dyn.trajectory.path import Path

ORTHONORMAL = 1e-6
"""How far R R^T may be from the identity: the rounding of six printed digits."""
LENGTHS = 1e-9
"""Relative: how far profile and path may differ in length, by rounding of sums."""


@dataclass(frozen=True, slots=True, eq=False)
class RotationSample:
    """Orientation at k lengths s: R (k, 3, 3), rate (k, 3) [rad/m] and its derivative (k, 3) [rad/m^2], base axes."""

    R: Array
    rate: Array
    d_rate: Array


class Orientation(Protocol):
    """A rotation as a function of the length on a path."""

    def at(self, s: Array) -> RotationSample:
        """At lengths s (k,) [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class ConstantOrientation:
    """The same orientation all along: `R` (3, 3)."""

    R: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "R")

    def at(self, s: Array) -> RotationSample:
        """At lengths s (k,) [m]."""
        still = np.zeros((len(s), 3))
        return RotationSample(np.broadcast_to(self.R, (len(s), 3, 3)), still, still)


@dataclass(frozen=True, slots=True, eq=False)
class Slerp:
    """A turn about one axis: R(s) = exp(rate s [axis]) R, `axis` (3,) a unit vector in the base, `rate` [rad/m]."""

    R: Array
    axis: Array
    rate: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "R", "axis")

    def at(self, s: Array) -> RotationSample:
        """At lengths s (k,) [m]."""
        R = turn_about(self.axis, self.rate * s) @ self.R
        rate = np.broadcast_to(self.rate * self.axis, (len(s), 3))
        return RotationSample(R, rate, np.zeros((len(s), 3)))


def constant_orientation(R: ArrayLike, name: str = "R") -> ConstantOrientation:
    """One orientation R (3, 3) for the whole path; raises as `rotation`, under the name given."""
    return ConstantOrientation(rotation(name, R))


def slerp(R_start: ArrayLike, R_end: ArrayLike, length: float) -> Slerp:
    """The shortest turn from one orientation to another over a path of `length` [m].

    Raises
    ------
    ShapeError
        Not (3, 3) matrices.
    OptionError
        Not rotations, length not positive, or half a turn (no shortest way).

    References
    ----------
    Siciliano et al., Robotics, sec. 4.3, orientation by angle and axis.

    >>> from lwr_dyn.model.spatial import rot_z
    >>> slerp(np.eye(3), rot_z(1.0), 2.0).rate
    0.5
    """
    start, end = rotation("R_start", R_start), rotation("R_end", R_end)
    length = positive_number("length", length)
    D = end @ start.T
    twice_sin = np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
    sine = float(np.linalg.norm(twice_sin))
    angle = math.atan2(sine, float(np.trace(D)) - 1.0)
    if angle > math.pi - 1e-6:
        raise OptionError("R_end", "half a turn from R_start", "less than 180 deg; put an orientation in between")
    axis = twice_sin / sine if sine > 0.0 else np.array([0.0, 0.0, 1.0])
    return Slerp(start, axis, angle / length)


def rotation(name: str, value: ArrayLike) -> Array:
    """A rotation matrix (3, 3); raises `ShapeError`, or `OptionError` when it is not orthonormal and right-handed."""
    R = fixed_array(name, value, (3, 3))
    error = float(np.max(np.abs(R @ R.T - np.eye(3))))
    if error > ORTHONORMAL or np.linalg.det(R) < 0.0:
        kind = "left-handed" if error <= ORTHONORMAL else f"R R^T differs from 1 by {error:.2g}"
        raise OptionError(name, kind, "a rotation matrix")
    return R


@dataclass(frozen=True, slots=True, eq=False)
class PoseMotion:
    """A pose over k times: T (k, 4, 4), velocity and acceleration (k, 6) [linear, angular], in the base frame.

    t (k,) [s]; `profile` holds the length travelled and its derivatives; linear rates are those of the frame's origin.
    """

    t: Array
    profile: ProfileSample
    T: Array
    velocity: Array
    acceleration: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "T", "velocity", "acceleration")


@dataclass(frozen=True, slots=True, eq=False)
class TimedPosePath:
    """Path, orientation and profile together, with exact derivatives by the chain rule."""

    path: Path
    orientation: Orientation
    profile: MotionProfile

    @property
    def duration(self) -> float:
        """[s]"""
        return self.profile.duration

    @property
    def length(self) -> float:
        """[m]"""
        return self.path.length

    def poses(self, s: ArrayLike) -> Array:
        """T (k, 4, 4) at lengths s (k,) [m]."""
        where = np.atleast_1d(np.asarray(s, dtype=np.float64))
        return _pose(self.orientation.at(where).R, self.path.at(where).p)

    def at(self, t: ArrayLike) -> PoseMotion:
        """Pose, velocity p' ds and acceleration p' dds + p'' ds^2 at times t (k,) [s]; raises `ShapeError`.

        Before 0 and after `duration` the pose stands still.
        """
        profile = self.profile.at(t)
        place, turn = self.path.at(profile.s), self.orientation.at(profile.s)
        ds, dds = profile.ds[:, None], profile.dds[:, None]
        first = np.hstack([place.dp, turn.rate])
        second = np.hstack([place.ddp, turn.d_rate])
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        return PoseMotion(times, profile, _pose(turn.R, place.p), first * ds, first * dds + second * ds**2)


def timed_pose_path(path: Path, orientation: Orientation, profile: MotionProfile) -> TimedPosePath:
    """A path with its orientation and its profile, of the same length.

    Raises `OptionError`: the profile has another length than the path.
    """
    if abs(profile.length - path.length) > LENGTHS * path.length:
        raise OptionError("profile", f"a length of {profile.length:.9g}", f"the path's length, {path.length:.9g} m")
    return TimedPosePath(path, orientation, profile)


def _pose(R: Array, p: Array) -> Array:
    T = np.zeros((len(p), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, p, 1.0
    return T


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
        return _pose(R, start[:3, 3] + np.outer(u, shift))

    return PoseCurve(poses, float(np.linalg.norm(shift)), float(np.linalg.norm(turn)))


def through(waypoints: Array) -> PoseCurve:
    """A curve without corners through poses (m, 4, 4), m >= 3: cubic splines of place and orientation.

    u is proportional to the chords; a turn of 1 rad counts as a way of 1 m.

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
    steps = np.hypot(chords, np.linalg.norm(turns, axis=1))
    if not (steps > 0.0).all():
        where = int(np.argmin(steps)) + 1
        raise OptionError(f"waypoints {where} and {where + 1}", "the same pose", "waypoints apart from each other")
    u = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    place = make_interp_spline(u, waypoints[:, :3, 3], k=min(3, len(u) - 1))
    orientation = RotationSpline(u, Rotation.from_matrix(waypoints[:, :3, :3]))

    def poses(at: Array) -> Array:
        return _pose(orientation(at).as_matrix(), place(at))

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
