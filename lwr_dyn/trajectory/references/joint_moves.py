"""Moves in joint space: point to point by quintics, LSPB moves of all joints together, and standing still."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays, joint_array, real_array
from lwr_dyn.foundation.errors import OptionError, PathLimitError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, short_repr
from lwr_dyn.trajectory.motion_profile import MotionProfile, lspb, positive_number, quintic
from lwr_dyn.trajectory.references.position_limits import largest_violation
from lwr_dyn.trajectory.references.references import Duration, End, Start


@dataclass(frozen=True, slots=True, eq=False)
class JointReference:
    """A move through `waypoints` (m + 1, n) [rad or m]; `profiles[i]` goes from 0 to 1 between waypoint i and i + 1."""

    waypoints: Array
    profiles: tuple[MotionProfile, ...]
    about: Mapping[str, Any] = field(default_factory=dict)
    """What is to be said of it in run files."""
    name: ClassVar[str] = "JointReference"
    """In run files."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "waypoints")

    @property
    def duration(self) -> float:
        """[s]"""
        return float(sum(profile.duration for profile in self.profiles))

    def sample(self, t: Array) -> Motion:
        """The motion at times t (k,) [s]; before 0 and after `duration` it stands still.

        >>> from lwr_dyn import load
        >>> move = point_to_point(load("lwr4plus"), [[0] * 7, [1] * 7], [2.0])
        >>> move.sample(np.array([1.0])).q[0, 0]
        np.float64(0.5)
        """
        times = np.atleast_1d(real_array("t", t))
        q = np.broadcast_to(self.waypoints[0], (len(times), self.waypoints.shape[1])).copy()
        dq, ddq, begin = np.zeros_like(q), np.zeros_like(q), 0.0
        for profile, step in zip(self.profiles, np.diff(self.waypoints, axis=0), strict=True):
            part = profile.at(times - begin)
            q += np.outer(part.s, step)
            dq += np.outer(part.ds, step)
            ddq += np.outer(part.dds, step)
            begin += profile.duration
        return Motion(times, q, dq, ddq)


def point_to_point(arm: Arm, waypoints: ArrayLike, durations: Sequence[float]) -> JointReference:
    """A move through joint positions, each leg a quintic from rest to rest in its own time.

    Parameters
    ----------
    arm : Arm
    waypoints : (m + 1, n) array_like
        [rad or m], at least two.
    durations : sequence of float
        [s], one per leg.

    Raises
    ------
    ShapeError
        Waypoints of the wrong shape, or not finite.
    OptionError
        Fewer than two waypoints, another number of durations than legs, or one that is not positive.
    PathLimitError
        A waypoint outside the position limits.
    """
    points = joint_array("waypoints", waypoints, arm.n)
    if points.ndim != 2 or len(points) < 2:
        raise OptionError("waypoints", f"shape {points.shape}", f"(m, {arm.n}) with at least two rows")
    if len(durations) != len(points) - 1:
        raise OptionError("durations", f"{len(durations)} of them", f"{len(points) - 1}, one per leg")
    profiles = tuple(quintic(1.0, positive_number("durations", d)) for d in durations)
    return _inside_limits(arm, JointReference(points, profiles), [f"waypoint {i}" for i in range(len(points))])


def one_move(arm: Arm, *, start: Start, end: End, duration: Duration = 2.0) -> JointReference:
    """`point_to_point` with a single leg from `start` to `end` (n,) [rad or m]."""
    ends = [fixed_array(name, q, (arm.n,)) for name, q in (("start", start), ("end", end))]
    return point_to_point(arm, np.stack(ends), [duration])


def hold(arm: Arm, q: Start, duration: Duration = 2.0) -> JointReference:
    """Standing still at q (n,) [rad or m] for `duration` [s].

    Raises `ShapeError`, `OptionError`, `PathLimitError`: as `point_to_point`.
    """
    point = joint_array("q", q, arm.n)
    if point.ndim != 1:
        raise OptionError("q", f"shape {point.shape}", f"({arm.n},)")
    return point_to_point(arm, np.stack([point, point]), [duration])


def lspb_move(
    arm: Arm,
    start: Start,
    end: End,
    *,
    duration: Duration = 7.0,
    blend: Annotated[float, Option(float, "Time of each of the two blends, s.")] = 1.0,
) -> JointReference:
    """A move from `start` to `end` with one LSPB profile for all joints, so that they move along a straight line.

    Parameters
    ----------
    arm : Arm
    start, end : (n,) array_like
        [rad or m]
    duration, blend : float
        t_f and t_c [s], by default those of the WAM paper.

    Returns
    -------
    JointReference
        q, dq, ddq are exact.

    Raises
    ------
    ShapeError
        Positions of the wrong shape, or not finite.
    OptionError
        A profile that does not exist, with the feasible range.
    PathLimitError
        Start or end outside the position limits.

    >>> from lwr_dyn import load
    >>> move = lspb_move(load("wam7"), [0, -2, 0, 1.6, 0, 0, 0], [0.5, -2, 0, 1.6, 0, 0, 0], duration=7.0, blend=1.0)
    >>> move.sample(np.array([3.5])).dq[0, :2].round(5)
    array([0.08333, 0.     ])
    """
    points = np.stack([fixed_array(name, q, (arm.n,)) for name, q in (("start", start), ("end", end))])
    return _inside_limits(arm, JointReference(points, (lspb(1.0, duration, blend),)), ("start", "end"))


def _inside_limits(arm: Arm, move: JointReference, names: Sequence[str]) -> JointReference:
    """The move itself; raises `PathLimitError` for a waypoint outside, since profiles are monotonic in between."""
    violation = largest_violation(arm, move.waypoints)
    if violation is None:
        return move
    row, joint, fault, allowed, excess = violation
    t = float(sum(profile.duration for profile in move.profiles[:row]))
    raise PathLimitError(t, names[row], fault, allowed, joint, excess)
