"""The IST path of the LWR 4+ paper: its points as printed, the path they mean, and the timings considered."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.errors import OptionError
from lwr_dyn.papers.schema import Column
from lwr_dyn.trajectory.blends import blended
from lwr_dyn.trajectory.double_s import double_s_in
from lwr_dyn.trajectory.laws import Law, constant_speed, in_sequence, positive, quintic, scaled
from lwr_dyn.trajectory.orientations import Constant, rotation
from lwr_dyn.trajectory.path import Path, path_of
from lwr_dyn.trajectory.poses import TimedPosePath, timed
from lwr_dyn.trajectory.references.arm_angles import ArmAngle
from lwr_dyn.trajectory.references.task_reference import TaskReference, task_reference
from lwr_dyn.trajectory.segments import arc, line

if TYPE_CHECKING:
    from lwr_dyn.model.arm import Arm

POINTS = Column(
    name="path.points",
    values=(
        (-0.05, -0.45, 0.55),
        (-0.05, -0.45, 0.25),
        (-0.05, -0.35, 0.25),
        (-0.05, -0.35, 0.325),
        (-0.05, -0.35, 0.475),
        (-0.05, -0.35, 0.55),
        (-0.05, -0.20, 0.55),
        (-0.05, -0.25, 0.55),
        (-0.05, -0.25, 0.25),
    ),
    unit=("m",) * 9,
    where="lwr4plus, Table V, columns X, Y, Z, rows 1 to 9",
    kind="printed",
    note="in frame 0 (the shoulder); points 4 and 5 are the centres of the semicircles, not points of the path",
)
DURATION = 14.0
"""[s] Printed: 'to be done in 14 s'."""
TOOL = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0))
"""R_07, estimated (the paper gives no orientation): of the six axis directions only the tool along +y of frame 0
keeps the whole path inside the joint limits."""
TIMINGS = ("constant", "quintic", "smooth", "smooth-blended")
LAWS = {
    "constant": "constant speed over the whole path: the speed jumps at both ends, its direction at the corners",
    "quintic": "a quintic from rest to rest on each of the seven segments, in times proportional to their lengths",
    "smooth": "double-S, stops at the three corners, the S passed at speed with its three bends eased",
    "smooth-blended": "double-S, the two right-angled corners blended and passed at speed, a stop where T turns back",
}


@dataclass(frozen=True, slots=True)
class Smoothness:
    """What the smooth timings keep: bounds along the path, and how far from a joint the path is left.

    `acceleration` [m/s^2] and `jerk` [m/s^3] of the length travelled; `ease` [m] at the bends (line into arc, arc
    into arc: passed at speed v unrounded, the acceleration would jump by v^2 / 0.075 m); `blend` [m] at corners,
    for "smooth-blended" only. ease = 0 draws Table V to the letter and has those jumps.
    """

    acceleration: float = 0.5
    jerk: float = 5.0
    ease: float = 0.005
    blend: float = 0.02


def ist_path() -> Path:
    """The letters I, S and T in one stroke: seven segments, 1.37124 m, in frame 0.

    1 -> 2 -> 3 lines, semicircles around 4 (bulging to +y) and 5 (to -y) up to 6, then 7, back to 8, down to 9.

    >>> round(ist_path().length, 5)
    1.37124
    """
    p = dict(enumerate(POINTS.si(), start=1))
    x = np.array([1.0, 0.0, 0.0])
    middle = 2.0 * p[4] - p[3]
    return path_of(
        [
            line(p[1], p[2]),
            line(p[2], p[3]),
            arc(p[3], p[4], x, math.pi),
            arc(middle, p[5], x, -math.pi),
            line(p[6], p[7]),
            line(p[7], p[8]),
            line(p[8], p[9]),
        ]
    )


def timed_ist(
    timing: str = "smooth",
    duration: float = DURATION,
    R_07: ArrayLike | None = None,
    smoothness: Smoothness | None = None,
) -> TimedPosePath:
    """The IST path with one of the timings; which one the authors used is not known.

    Parameters
    ----------
    timing : {"constant", "quintic", "smooth", "smooth-blended"}
        See `LAWS`.
    duration : float
        [s]
    R_07 : (3, 3) array_like, optional
        Orientation of the flange in frame 0, the same all along; `TOOL` if not given.
    smoothness : Smoothness, optional
        Bounds and roundings of the smooth timings.

    Raises
    ------
    ShapeError, OptionError
        An unknown timing, a duration that is not positive or too short for the bounds, R_07 not a rotation.

    >>> timed_ist("constant").law.peaks().speed.__round__(4)
    0.0979
    """
    positive("duration", duration)
    orientation = Constant(rotation("R_07", TOOL if R_07 is None else R_07))
    path, keep = ist_path(), smoothness or Smoothness()
    if timing == "constant":
        return timed(path, orientation, constant_speed(path.length, duration))
    if timing == "quintic":
        return timed(path, orientation, _quintic_per_segment(path, duration))
    if timing not in TIMINGS:
        raise OptionError("timing", repr(timing), ", ".join(TIMINGS))
    path = blended(path, corners=keep.blend if timing == "smooth-blended" else 0.0, bends=keep.ease)
    return timed(path, orientation, double_s_in(path.sections(), duration, keep.acceleration, keep.jerk))


def ist_reference(
    arm: Arm,
    timing: str = "smooth",
    duration: float = DURATION,
    R_07: ArrayLike | None = None,
    arm_angle: float | ArmAngle | None = None,
    smoothness: Smoothness | None = None,
    limits: bool = True,
) -> TaskReference:
    """The IST path as a reference for the joints; its `about` says what is printed, assumed and estimated.

    Parameters
    ----------
    arm : Arm
        A seven-joint S-R-S arm.
    timing, duration, R_07, smoothness
        As `timed_ist`.
    arm_angle, limits
        As `task_reference`; the largest-margin curve if no arm angle is given.

    Raises
    ------
    ShapeError, OptionError
        As `timed_ist`.
    PathLimitError
        The path leaves the reach or the limits of the arm; says when, where, which joint and by how much.
    """
    poses = timed_ist(timing, duration, R_07, smoothness)
    about: dict[str, Any] = {
        "task": "ist",
        "points": {"where": POINTS.where, "kind": POINTS.kind, "note": POINTS.note},
        "duration": {"value": poses.duration, "kind": "printed" if duration == DURATION else "assumed"},
        "timing": {"value": timing, "law": LAWS[timing], "kind": "assumed", "note": "the paper names no timing"},
        "R_07": {
            "value": poses.orientation.at(np.zeros(1)).R[0].tolist(),
            "kind": "estimated" if R_07 is None else "assumed",
            "note": "the paper gives no tool orientation",
        },
    }
    if timing in ("smooth", "smooth-blended"):
        about["smoothness"] = asdict(smoothness or Smoothness()) | {"kind": "assumed"}
    return task_reference(arm, poses, arm_angle, about, limits)


def _quintic_per_segment(path: Path, duration: float) -> Law:
    pace = duration / path.length
    laws = [quintic(segment.length, pace * segment.length) for segment in path.segments]
    return scaled(in_sequence(laws), duration)
