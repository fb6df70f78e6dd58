"""The IST path of the LWR 4+ paper: its points as printed, the path through them, its timing; and `ist-clear`.

On IST as printed, joint 6 of the LWR 4+ starts 1.2 degrees from its limit. With 3 kg at the flange that a controller
does not know, it comes to rest on its stop, which then takes part in the error that is measured. `ist-clear` is for
comparisons of controllers: the same letters, tool, duration and timings, shifted by `CLEAR_SHIFT`. Every joint then
keeps 50.9 degrees to its limits and uses at most 18 % of its speed (IST: 29 %).

The shift is the one with the largest margin on a grid of 0.1 m over the workspace; `scripts/ist_clear.py` searches it
again. The arm is symmetric about the plane x = 0 of frame 0: the mirror image of the letters does as well.
"""

import math
from dataclasses import asdict
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arms.papers.schema import Column
from lwr_dyn.foundation.arrays import fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, srs_geometry
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import positive_number
from lwr_dyn.trajectory.path import Path, path_of
from lwr_dyn.trajectory.pose_path import TimedPosePath, constant_orientation, timed_pose_path
from lwr_dyn.trajectory.references.arm_angles import ArmAngle
from lwr_dyn.trajectory.references.pose_path_reference import PosePathReference, pose_path_reference
from lwr_dyn.trajectory.references.tasks import Duration
from lwr_dyn.trajectory.segments import arc, line
from lwr_dyn.trajectory.timings import MOTION_PROFILES, SmoothTiming

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
NO_SHIFT = (0.0, 0.0, 0.0)
CLEAR_SHIFT = (0.7, 0.6, -0.3)
"""[m] in frame 0, of `ist-clear`."""


def ist_path(shift: ArrayLike = NO_SHIFT) -> Path:
    """The letters I, S and T in one stroke: seven segments, 1.37124 m, in frame 0, moved by `shift` (3,) [m].

    1 -> 2 -> 3 lines, semicircles around 4 (bulging to +y) and 5 (to -y) up to 6, then 7, back to 8, down to 9.

    >>> round(ist_path().length, 5)
    1.37124
    """
    p = dict(enumerate(POINTS.si() + fixed_array("shift", shift, (3,)), start=1))
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
    smoothness: SmoothTiming | None = None,
    shift: ArrayLike = NO_SHIFT,
) -> TimedPosePath:
    """The IST path with one of the timings; the paper does not say which one it used.

    Parameters
    ----------
    timing : {"constant", "quintic", "smooth", "smooth-blended"}
        See `MOTION_PROFILES`.
    duration : float
        [s]
    R_07 : (3, 3) array_like, optional
        Orientation of the flange in frame 0, the same all along; `TOOL` if not given.
    smoothness : SmoothTiming, optional
        Bounds and roundings of the smooth timings.
    shift : (3,) array_like
        [m] Moves the letters in frame 0.

    Raises
    ------
    UnknownNameError
        An unknown timing.
    ShapeError, OptionError
        A duration that is not positive or too short for the bounds, R_07 not a rotation, a shift that is not finite.

    >>> timed_ist("constant").profile.peaks().speed.__round__(4)
    0.0979
    """
    positive_number("duration", duration)
    orientation = constant_orientation(TOOL if R_07 is None else R_07, "R_07")
    path, profile = MOTION_PROFILES.load(timing)(ist_path(shift), duration, smoothness or SmoothTiming())
    return timed_pose_path(path, orientation, profile)


def ist_reference(
    arm: Arm,
    timing: Annotated[str, Option(MOTION_PROFILES, "Motion profile along the path.")] = "smooth",
    duration: Duration = DURATION,
    R_07: ArrayLike | None = None,
    arm_angle: Annotated[
        float | ArmAngle | None, Option(Quantity.ANGLE, "One arm angle all along, not the safest curve.")
    ] = None,
    smoothness: SmoothTiming | None = None,
    limits: bool = True,
    shift: Annotated[ArrayLike, Option(Quantity.POINT, "Moves the letters, m in frame 0.")] = NO_SHIFT,
) -> PosePathReference:
    """The IST path as a reference for the joints; its `about` says what is printed, assumed and estimated.

    Parameters
    ----------
    arm : Arm
        A seven-joint S-R-S arm.
    timing, duration, R_07, smoothness, shift
        As `timed_ist`.
    arm_angle, limits
        As `pose_path_reference`; the largest-margin curve if no arm angle is given.

    Raises
    ------
    UnknownNameError, ShapeError, OptionError
        As `timed_ist`; an arm that is not S-R-S.
    PathLimitError
        The path leaves the reach or the limits of the arm; says when, where, which joint and by how much.
    """
    if srs_geometry(arm.chain) is None:
        raise OptionError(
            f"task {_task(shift)}, robot", arm.name, f"{SRS_ARM}; other arms have other tasks, as point-to-point"
        )
    poses = timed_ist(timing, duration, R_07, smoothness, shift)
    about: dict[str, Any] = {
        "task": _task(shift),
        "points": {"where": POINTS.where, "kind": POINTS.kind, "note": POINTS.note},
        "duration": {"value": poses.duration, "kind": "printed" if duration == DURATION else "assumed"},
        "timing": {
            "value": timing,
            "law": MOTION_PROFILES[timing].about,
            "kind": "assumed",
            "note": "the paper names no timing",
        },
        "R_07": {
            "value": poses.orientation.at(np.zeros(1)).R[0].tolist(),
            "kind": "estimated" if R_07 is None else "assumed",
            "note": "the paper gives no tool orientation",
        },
    }
    if about["task"] != "ist":
        shifted = {"value": np.asarray(shift, dtype=float).tolist(), "kind": "assumed"}
        about["shift"] = shifted | {"note": "[m] in frame 0; the paper's letters are not shifted"}
    if "smoothness" in MOTION_PROFILES[timing].facts:
        about["smoothness"] = asdict(smoothness or SmoothTiming()) | {"kind": "assumed"}
    return pose_path_reference(arm, poses, arm_angle, about, limits)


def _task(shift: ArrayLike) -> str:
    if not np.any(shift):
        return "ist"
    return "ist-clear" if np.array_equal(shift, CLEAR_SHIFT) else "ist, moved"


def ist_clear_reference(
    arm: Arm,
    timing: Annotated[str, Option(MOTION_PROFILES, "Motion profile along the path.")] = "smooth",
    duration: Duration = DURATION,
    arm_angle: Annotated[
        float | ArmAngle | None, Option(Quantity.ANGLE, "One arm angle all along, not the safest curve.")
    ] = None,
) -> PosePathReference:
    """`ist_reference` far from the limits of the LWR 4+ (see this module); takes its options, raises its errors.

    >>> from lwr_dyn import load
    >>> round(math.degrees(ist_clear_reference(load("lwr4plus")).margin), 1)
    50.9
    """
    return ist_reference(arm, timing, duration, None, arm_angle, shift=CLEAR_SHIFT)
