"""Moves in joint space: from point to point by quintics with a stop at each, and standing still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, read_only, real_array
from lwr_dyn.errors import OptionError, PathLimitError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from lwr_dyn.trajectory.laws import Law, positive, quintic
from lwr_dyn.trajectory.references.limits import worst_outside
from lwr_dyn.trajectory.references.tasks import Duration, End, Start


@dataclass(frozen=True, slots=True, eq=False)
class JointReference:
    """A move through `waypoints` (m + 1, n) [rad or m]; `laws[i]` goes from 0 to 1 between waypoint i and i + 1."""

    waypoints: Array
    laws: tuple[Law, ...]
    name: ClassVar[str] = "JointReference"

    def __post_init__(self) -> None:
        object.__setattr__(self, "waypoints", read_only(self.waypoints))

    @property
    def duration(self) -> float:
        """[s]"""
        return float(sum(law.duration for law in self.laws))

    def sample(self, t: Array) -> Motion:
        """The motion at times t (k,) [s]; before 0 and after `duration` it stands still.

        >>> from lwr_dyn.front import load
        >>> move = point_to_point(load("lwr4plus"), [[0] * 7, [1] * 7], [2.0])
        >>> move.sample(np.array([1.0])).q[0, 0]
        np.float64(0.5)
        """
        times = np.atleast_1d(real_array("t", t))
        q = np.broadcast_to(self.waypoints[0], (len(times), self.waypoints.shape[1])).copy()
        dq, ddq, begin = np.zeros_like(q), np.zeros_like(q), 0.0
        for law, step in zip(self.laws, np.diff(self.waypoints, axis=0), strict=True):
            part = law.at(times - begin)
            q += np.outer(part.s, step)
            dq += np.outer(part.ds, step)
            ddq += np.outer(part.dds, step)
            begin += law.duration
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
    laws = tuple(quintic(1.0, positive("durations", d)) for d in durations)
    times = np.concatenate([[0.0], np.cumsum([law.duration for law in laws])])
    _check(arm, times, points)
    return JointReference(points, laws)


def one_move(arm: Arm, *, start: Start, end: End, duration: Duration = 2.0) -> JointReference:
    """`point_to_point` of a single leg from `start` to `end` (n,) [rad or m]."""
    ends = [joint_array(name, q, arm.n) for name, q in (("start", start), ("end", end))]
    return point_to_point(arm, np.stack(ends), [duration])


def hold(arm: Arm, q: Start, duration: Duration = 2.0) -> JointReference:
    """Standing still at q (n,) [rad or m] for `duration` [s].

    Raises
    ------
    ShapeError, OptionError, PathLimitError
        As `point_to_point`.
    """
    point = joint_array("q", q, arm.n)
    if point.ndim != 1:
        raise OptionError("q", f"shape {point.shape}", f"({arm.n},)")
    return point_to_point(arm, np.stack([point, point]), [duration])


def _check(arm: Arm, times: Array, points: Array) -> None:
    """A quintic runs monotonically between its ends, so the waypoints are the extremes of the move."""
    fault = worst_outside(arm, points)
    if fault is not None:
        i, joint, said, allowed, excess = fault
        raise PathLimitError(float(times[i]), f"waypoint {i}", said, allowed, joint, excess)
