"""The tasks `line` and `waypoints`: from the command's options to a reference for the joints of any arm.

The tip follows the line from one joint position to the next, without a random restart inside it. Where it cannot,
`PathStopError` says where and why. Durations are the shortest that keep `speed`, `turn_speed` and the joints' speed
limits; accelerations and torques are not bounded.
"""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.trajectory.cartesian import legs
from lwr_dyn.trajectory.motion_files import read_waypoints
from lwr_dyn.trajectory.motion_profile import positive_number
from lwr_dyn.trajectory.pose_path import straight
from lwr_dyn.trajectory.references.position_limits import largest_violation
from lwr_dyn.trajectory.references.references import Start, StartIfGiven

SPEED = 0.25
"""[m/s] The reduced speed of ISO 10218-1 for a person near the arm."""
TURN_SPEED = 0.5 * np.pi
"""[rad/s]"""

Speed = Annotated[float, Option(float, "Largest speed of the tip, m/s.")]
TurnSpeed = Annotated[float, Option(Quantity.ANGLE, "Largest speed at which the tip turns, deg/s.")]


def line_reference(
    arm: Arm,
    *,
    start: Start,
    to_xyz: Annotated[ArrayLike, Option(Quantity.POINT, "Where the line ends, m in the base.")],
    to_rpy: Annotated[
        ArrayLike | None, Option(Quantity.ANGLES, "Roll, pitch, yaw of the tip at the end, deg; kept if not given.")
    ] = None,
    free_orientation: Annotated[
        bool, Option(bool, "Only the place of the tip is on the line; it may turn.", unless="to_rpy")
    ] = False,
    speed: Speed = SPEED,
    turn_speed: TurnSpeed = TURN_SPEED,
    duration: Annotated[float | None, Option(float, "Duration, s; the shortest if not given.")] = None,
) -> legs.LegsReference:
    """A straight line of the tip from joint positions `start` (n,) [rad or m] to a place and orientation in the base.

    Parameters
    ----------
    arm : Arm
    start : (n,) array_like
        [rad or m], inside the limits.
    to_xyz : (3,) array_like
        [m]
    to_rpy : (3,) array_like, optional
        [rad] R = Rz(yaw) Ry(pitch) Rx(roll); the orientation at the start if not given.
    free_orientation : bool
    speed, turn_speed : float
        [m/s], [rad/s]
    duration : float, optional
        [s]

    Raises
    ------
    ShapeError, OptionError
        Wrong shapes, a start outside the limits, a line without way and turn, half a turn, a duration too short for a
        joint's speed.
    PathStopError
        The arm cannot follow the line: where, and whether for a limit, a singular position or its reach.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> line_reference(arm, start=[0, 0.5, 0, -1.5, 0, 0.8, 0], to_xyz=[-0.3, 0.2, 0.3]).duration.__round__(2)
    2.89
    """
    q = _start(arm, start)
    begin = flange_pose(arm.chain, q)
    end = begin.copy()
    end[:3, 3] = fixed_array("to_xyz", to_xyz, (3,))
    if to_rpy is not None:
        end[:3, :3] = from_rpy(fixed_array("to_rpy", to_rpy, (3,)))
    curve = straight(begin, end, "to_rpy")
    if curve.length == 0.0 and curve.turn == 0.0:
        raise OptionError("to_xyz", "where the tip starts", "another place or orientation")
    wanted = None if duration is None else positive_number("duration", duration)
    pace = _pace(speed, turn_speed, not free_orientation)
    about = {"task": "line", "end": end.tolist()}
    return legs.follow_legs(arm, q, [legs.PoseLeg(curve, wanted, "the line")], pace, about)


def waypoints_reference(
    arm: Arm,
    *,
    waypoints: Annotated[
        str, Option(str, "CSV: x, y, z, roll, pitch, yaw or q1, q2, ...; perhaps time; SI or x [mm].")
    ],
    start: StartIfGiven = None,
    through: Annotated[bool, Option(bool, "Pass the waypoints on one smooth curve, without stops.")] = False,
    speed: Speed = SPEED,
    turn_speed: TurnSpeed = TURN_SPEED,
) -> legs.LegsReference:
    """Lines through the waypoints of a file, with a stop at each, or one smooth curve through all of them.

    Parameters
    ----------
    arm : Arm
    waypoints : str
        Path of a file as `trajectory.motion_files` describes it. Without angles the orientation is free.
    start : (n,) array_like, optional
        [rad or m] The first leg then leads from there to the first waypoint. If not given, the motion begins at the
        first waypoint, in the joint positions with the largest margin from which the whole file can be followed.
    through : bool
    speed, turn_speed : float
        [m/s], [rad/s]; of a file without times.

    Raises
    ------
    FileAccessError, WaypointError
        The file cannot be read, or is not what it should be.
    ShapeError, OptionError
        As `line_reference`.
    PathStopError
        As `line_reference`; without a start, of the attempt that came furthest.
    """
    points = read_waypoints(waypoints)
    if through and points.times is not None:
        raise OptionError("through", f"with the column time of {waypoints}", "a file without times, or stops")
    q = None if start is None else _start(arm, start)
    about = {"task": "waypoints", "file": str(waypoints), "stops": not through}
    if points.joints is not None:
        return legs.LegsReference(legs.joint_legs(arm, str(waypoints), points, q, through), about)
    pace = _pace(speed, turn_speed, points.poses is not None)
    return legs.follow_waypoints(arm, points, q, through, pace, about)


def _pace(speed: float, turn_speed: float, turning: bool) -> legs.Pace:
    return legs.Pace(positive_number("speed", speed), positive_number("turn_speed", turn_speed), turning)


def _start(arm: Arm, start: ArrayLike) -> Array:
    q = fixed_array("start", start, (arm.n,))
    outside = largest_violation(arm, q[None])
    if outside is not None:
        raise OptionError("start", outside.fault, outside.allowed)
    return q
