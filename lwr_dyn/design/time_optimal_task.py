"""The task `least-time`: the path of another task in the least time, as `lwr-dyn simulate` and `compare` take it."""

from dataclasses import replace
from typing import Annotated, Any

from numpy.typing import ArrayLike

from lwr_dyn.design.time_optimal import EFFORT_SHARE, RATE, SPEED_SHARE, least_time
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option, Quantity, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.references.tasks import REFERENCES
from lwr_dyn.trajectory.timings import MOTION_PROFILES

NAME = "least-time"
BLENDED = "smooth-blended"


def least_time_reference(
    arm: Arm,
    *,
    along: Annotated[str, Option(str, "Task whose path is followed: ist, line, waypoints, ...")] = "ist",
    effort_share: Annotated[float, Option(float, "Share of the torque limits for the motion itself.")] = EFFORT_SHARE,
    speed_share: Annotated[float, Option(float, "Share of the speed limits for the motion itself.")] = SPEED_SHARE,
    acceleration: Annotated[
        float | None, Option(Quantity.ANGLE, "Largest acceleration of each joint, deg/s^2; not bounded if not given.")
    ] = None,
    switch_rate: Annotated[float, Option(float, "Acceleration jumps at samples only, this many a second.")] = RATE,
    timing: Annotated[
        str | None, Option(MOTION_PROFILES, "Rounds the path; smooth-blended if not given, smooth stops at corners.")
    ] = None,
    shift: Annotated[ArrayLike | None, Option(Quantity.POINT, "Moves the letters, m in frame 0.")] = None,
    start: Annotated[
        ArrayLike | None, Option(Quantity.JOINT_POSITIONS, "Where the joints start (m for sliding).", "from-deg")
    ] = None,
    end: Annotated[
        ArrayLike | None, Option(Quantity.JOINT_POSITIONS, "Where the joints end (m for sliding).", "to-deg")
    ] = None,
    to_xyz: Annotated[ArrayLike | None, Option(Quantity.POINT, "Where the line ends, m in the base.")] = None,
    to_rpy: Annotated[
        ArrayLike | None, Option(Quantity.ANGLES, "Roll, pitch, yaw of the tip at the end, deg; kept if not given.")
    ] = None,
    waypoints: Annotated[str | None, Option(str, "CSV of waypoints; its times do not matter.")] = None,
    through: Annotated[bool, Option(bool, "Pass the waypoints on one smooth curve, without stops.")] = False,
) -> Reference:
    """The path of the task `along` in the least time; see `lwr_dyn.design.time_optimal.least_time`.

    Parameters
    ----------
    arm : Arm
    along : str
        A name of `REFERENCES`.
    effort_share, speed_share, acceleration
        As `least_time`; [rad/s^2].
    switch_rate : float
        [Hz] `rate` of `least_time`.
    timing, shift, start, end, to_xyz, to_rpy, waypoints, through
        Options of that task. Corners are blended where the task has a timing and none is given.

    Raises
    ------
    UnknownNameError, OptionError, ShapeError, PathLimitError
        As the task.
    OptionError, MissingDataError, MissingPackageError
        As `least_time`; this task itself as `along`.
    """
    if along == NAME:
        raise OptionError("along", repr(along), "another task")
    given: dict[str, Any] = {
        "timing": timing, "shift": shift, "start": start, "end": end, "to_xyz": to_xyz, "to_rpy": to_rpy,
        "waypoints": waypoints, "through": through or None,
    }  # fmt: skip
    if timing is None and "timing" in options_of(REFERENCES.load(along)):
        given["timing"] = BLENDED
    slow = REFERENCES.make(along, arm, **{name: value for name, value in given.items() if value is not None})
    quick: Any = least_time(
        arm, slow, effort_share=effort_share, speed_share=speed_share, acceleration=acceleration, rate=switch_rate
    )
    if hasattr(quick, "about"):
        quick = replace(quick, about={**quick.about, "task": f"{quick.about.get('task', along)} in the least time"})
    out: Reference = quick
    return out
