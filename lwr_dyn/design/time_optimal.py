"""The least time in which an arm can follow a path: `least_time`, by toppra, with a share of the torque kept back.

The path stays what it is; only its motion profile changes. s(t) is made of parabolas, so q, dq and ddq are exact
derivatives of each other. toppra keeps the limits at the points of a grid; they are measured between the points too,
and where one is passed, the timing is found again with that limit lowered by what it was passed.

Torques are those of the arm's own rigid model with its rotors and its friction. What is left out: the jerk is not
bounded (dds jumps between intervals: elastic joints ring), and the torque that feedback needs is only kept as a share.
The task `least-time` is the path of another task, as `lwr-dyn simulate` and `compare` take it.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.design import time_optimal_speeds as speeds
from lwr_dyn.design.path_pieces import JointPath, PathPiece, path_of_reference
from lwr_dyn.design.time_optimal_speeds import JointBounds, Rows, Uses, friction_band
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, arm_argument, real_array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.foundation.registry import Option, Quantity, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.motion_profile import MotionProfile, positive_number
from lwr_dyn.trajectory.references.references import REFERENCES, StartIfGiven
from lwr_dyn.trajectory.timings import MOTION_PROFILES

INTERVALS = 1000
"""Of the grid of each piece: with 200 the limits are passed by up to 10 times as much before they are lowered."""

EFFORT_SHARE, SPEED_SHARE, RATE = 0.9, 0.95, 1000.0

TRIALS, LOCAL = 16, 10
"""How often the limits are lowered at most by what they were passed; the first times only where that was."""

SPARE = 1e-4
"""By how much more than it was passed a limit is lowered, times the square of the number of the trial."""

REPLACED = ("duration", "smoothness", "timing")
"""What a reference says of its own timing."""

RULES = 0.98
"""Of a limit: from here on it rules."""


@dataclass(frozen=True, slots=True, eq=False)
class PieceTiming:
    """The timing of one piece: its profile, what it uses of the limits, and how often it was found anew."""

    profile: MotionProfile
    uses: Uses
    trials: int


def least_time(
    arm: Arm,
    reference: Reference,
    *,
    effort_share: float = EFFORT_SHARE,
    speed_share: float = SPEED_SHARE,
    acceleration: ArrayLike | None = None,
    rate: float | None = RATE,
    intervals: int = INTERVALS,
) -> Reference:
    """The reference along the same path in the least time, from rest to rest; it stops where the path has a corner.

    Parameters
    ----------
    arm : Arm
        With limits of torque, or with `acceleration`.
    reference : Reference
        A path in space (`ist`), legs (`line`, `waypoints`), a move between joint positions, or a `CurveReference`, a
        curve q(s) of one's own. Its timing does not matter.
    effort_share, speed_share : float
        Shares of the arm's limits that the motion itself may use, above 0 up to 1. The rest of the torque is kept for
        feedback.
    acceleration : float or (n,) array_like, optional
        [rad/s^2 or m/s^2] Bound of the joints' accelerations.
    rate : float, optional
        [Hz] Samples a second of the controller: dds then only jumps at samples, and a torque that is held from one to
        the next fits it; each piece takes a whole number of samples. None lets dds jump anywhere.
    intervals : int
        Of the grid of each piece, 20 to 20 000.

    Returns
    -------
    Reference
        Of the same kind; `about["timing"]` says what it keeps and which limits rule for how long, where the reference
        has an `about`.

    Raises
    ------
    OptionError, ShapeError
        A share or bound outside what is allowed; a path that is not known apart from its timing; torques that are too
        small to hold the arm on the path.
    MissingDataError
        No masses, or no limit of torque for a joint and no `acceleration`.
    MissingPackageError
        toppra is not installed.
    """
    bounds = _bounds(arm_argument(arm), effort_share, speed_share, acceleration)
    if not (isinstance(intervals, int) and 20 <= intervals <= 20_000):
        raise OptionError("intervals", intervals, "a whole number from 20 to 20000")
    if rate is not None:
        positive_number("rate", rate)
    path, dynamics = path_of_reference(reference), dynamics_of(arm)
    pieces = [_timed(arm, piece, dynamics, bounds, intervals, rate) for piece in path.pieces]
    quick = path.timed([piece.profile for piece in pieces])
    about = _about(arm, pieces, path, effort_share, speed_share, acceleration)
    given: Any = quick
    if hasattr(quick, "about"):
        kept = {key: value for key, value in given.about.items() if key not in REPLACED}
        given = replace(given, about={**kept, "timing": about})
    out: Reference = given
    return out


def _bounds(arm: Arm, effort_share: float, speed_share: float, acceleration: ArrayLike | None) -> JointBounds:
    for name, share in (("effort_share", effort_share), ("speed_share", speed_share)):
        if not (isinstance(share, float | int) and 0.0 < share <= 1.0):
            raise OptionError(name, share, "a share above 0, at most 1")
    most = np.full(arm.n, np.inf) if acceleration is None else real_array("acceleration", acceleration)
    if most.shape not in ((), (arm.n,)):
        raise ShapeError("acceleration", f"shape {most.shape}", f"one number, or ({arm.n},)")
    if not (most > 0.0).all():
        raise OptionError("acceleration", float(most.min()), "a number above 0")
    most = np.broadcast_to(most, (arm.n,))
    free = [name for name, tau, a in zip(arm.joint_names, arm.effort, most, strict=True) if np.isinf(min(tau, a))]
    if free:
        raise MissingDataError(arm.name, f"limit of torque of {', '.join(free)}", "the least time, or an acceleration")
    return JointBounds(effort_share * arm.effort, speed_share * arm.velocity, most, arm.friction_models())


def _timed(
    arm: Arm, piece: PathPiece, dynamics: Dynamics, bounds: JointBounds, intervals: int, rate: float | None
) -> PieceTiming:
    s = np.union1d(np.linspace(0.0, piece.length, intervals + 1), piece.breaks)
    s = s[np.concatenate([[True], np.diff(s) > 1e-6 * piece.length])]
    s[-1] = piece.length
    lowered = np.ones((3, s.size - 1, arm.n))
    rows = speeds.rows_of_intervals(piece, dynamics, bounds, s)
    for trial in range(1, TRIALS + 1):
        squares = speeds.fastest_squares(s, speeds.linear_limits(*rows, bounds, s, lowered))
        if squares is None or not (squares[1:-1] > 0.0).all():
            raise OptionError("path", _why_not(arm, rows[0], bounds, s), "a path that the limits allow to follow")
        profile = speeds.profile_of_squares(s, squares)
        if rate is not None:
            profile = speeds.on_samples(profile, rate)
        found = speeds.uses(piece, dynamics, bounds, profile)
        most = found.peaks().max()
        if most <= 1.0:
            return PieceTiming(profile, found, trial)
        peaks = found.peaks_on(s) if trial < LOCAL else found.peaks()[:, None]
        lowered /= np.where(peaks > 1.0, peaks * (1.0 + SPARE * trial**2), 1.0)
    raise OptionError("path", f"its limits are passed by {most - 1.0:.2g} between points", "more intervals")


def _why_not(arm: Arm, rows: Rows, bounds: JointBounds, s: Array) -> str:
    """Why no timing was found: a joint whose torque does not hold the arm, where there is one."""
    need = (np.abs(rows.c) + friction_band(bounds)[1]) / bounds.effort
    row, joint = np.unravel_index(int(np.argmax(need)), need.shape)
    if need[row, joint] <= 1.0:
        return "no timing was found"
    share = f"{need[row, joint]:.3g} times the torque that it may use"
    return f"{arm.joint_names[joint]} needs {share}, only to stand still, at {s[row] / s[-1]:.0%} of the way"


def _about(
    arm: Arm, pieces: list[PieceTiming], path: JointPath, effort: float, speed: float, acceleration: ArrayLike | None
) -> dict[str, Any]:
    """What the timing keeps, as JSON values."""
    seconds = np.concatenate([piece.uses.seconds for piece in pieces])
    most = np.concatenate([piece.uses.shares.max(axis=2) for piece in pieces], axis=1)  # (3, k)
    ruled = [float(seconds[kind >= RULES].sum() / seconds.sum()) for kind in most]
    free = float(seconds[(most < RULES).all(axis=0)].sum() / seconds.sum())
    bound = None if acceleration is None else np.asarray(acceleration, dtype=float).tolist()
    return {
        "value": "least time", "kind": "computed", "duration": sum(piece.profile.duration for piece in pieces),
        "pieces": len(path.pieces), "effort_share": effort, "speed_share": speed, "acceleration": bound,
        "use": dict(zip(speeds.KINDS, most.max(axis=1).tolist(), strict=True)),
        "ruled_by": dict(zip(speeds.KINDS, ruled, strict=True)), "ruled_by_none": free,
        "note": "shares are of the limits that it may use; the jerk is not bounded",
    }  # fmt: skip


NAME = "least-time"

BLENDED = "smooth-blended"


def least_time_reference(
    arm: Arm,
    *,
    along: Annotated[str, Option(str, "Task whose path is followed: ist, line, waypoints, ...")] = "ist",
    effort_share: Annotated[
        float, Option(float, "Share of the torque limits for the motion itself.", "torque-share")
    ] = EFFORT_SHARE,
    speed_share: Annotated[float, Option(float, "Share of the speed limits for the motion itself.")] = SPEED_SHARE,
    acceleration: Annotated[
        float | None, Option(Quantity.ANGLE, "Largest acceleration of each joint, deg/s^2; not bounded if not given.")
    ] = None,
    switch_rate: Annotated[float, Option(float, "Acceleration jumps at samples only, this many a second.")] = RATE,
    timing: Annotated[
        str | None, Option(MOTION_PROFILES, "Rounds the path; smooth-blended if not given, smooth stops at corners.")
    ] = None,
    shift: Annotated[ArrayLike | None, Option(Quantity.POINT, "Moves the letters, m in frame 0.")] = None,
    start: StartIfGiven = None,
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
