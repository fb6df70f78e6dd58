"""A timed pose path: a path in space, an orientation along it, and a profile of motion that says when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.errors import OptionError
from lwr_dyn.trajectory.motion_profile import MotionProfile, ProfileSample
from lwr_dyn.trajectory.orientations import Orientation
from lwr_dyn.trajectory.path import Path

LENGTHS = 1e-9
"""How far profile and path may disagree about the length, relative: rounding of sums."""


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
    """The three put together.

    Raises
    ------
    OptionError
        The profile is made for another length than the path's.
    """
    if abs(profile.length - path.length) > LENGTHS * path.length:
        raise OptionError("profile", f"a length of {profile.length:.9g}", f"the path's length, {path.length:.9g} m")
    return TimedPosePath(path, orientation, profile)


def _pose(R: Array, p: Array) -> Array:
    T = np.zeros((len(p), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, p, 1.0
    return T
