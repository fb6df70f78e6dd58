"""The IST path of the LWR 4+ paper: its points as printed, the path through them, its timing; and `ist-clear`.

On IST as printed, joint 6 of the LWR 4+ starts 1.2 degrees from its limit. With 3 kg at the flange that a controller
does not know, it comes to rest on its stop, which then takes part in the error that is measured. `ist-clear` is for
comparisons of controllers: the same letters, tool, duration and timings, shifted by `CLEAR_SHIFT`. Every joint then
keeps 50.9 degrees to its limits and uses at most 18 % of its speed (IST: 29 %).

The shift is the one with the largest margin on a grid of 0.1 m over the workspace; `scripts/ist_clear.py` searches it
again. The arm is symmetric about the plane x = 0 of frame 0: the mirror image of the letters does as well.

`ist-clear-twice` has a quintic way back between: what a law that learns has learnt shows in the second pass.
"""

import math
from dataclasses import asdict, dataclass, field, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arms.papers.schema import Column
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, srs_geometry
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Reference, Run, short_repr
from lwr_dyn.trajectory.motion_profile import MotionProfile, positive_number, quintic
from lwr_dyn.trajectory.path import Path, arc, line, path_of
from lwr_dyn.trajectory.pose_path import TimedPosePath, constant_orientation, timed_pose_path
from lwr_dyn.trajectory.references.pose_path_reference import ArmAngle, PosePathReference, pose_path_reference
from lwr_dyn.trajectory.references.references import Duration
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

Timing = Annotated[str, Option(MOTION_PROFILES, "Motion profile along the path.")]

OneAngle = Annotated[float | ArmAngle | None, Option(Quantity.ANGLE, "One arm angle all along, not the safest curve.")]

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
    down, bowls = [line(p[1], p[2]), line(p[2], p[3])], [arc(p[3], p[4], x, math.pi), arc(middle, p[5], x, -math.pi)]
    return path_of([*down, *bowls, *(line(p[k], p[k + 1]) for k in (6, 7, 8))])


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
    timing: Timing = "smooth",
    duration: Duration = DURATION,
    R_07: ArrayLike | None = None,
    arm_angle: OneAngle = None,
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
    timing: Timing = "smooth",
    duration: Duration = DURATION,
    arm_angle: OneAngle = None,
) -> PosePathReference:
    """`ist_reference` far from the limits of the LWR 4+ (see this module); takes its options, raises its errors.

    >>> from lwr_dyn import load
    >>> round(math.degrees(ist_clear_reference(load("lwr4plus")).margin), 1)
    50.9
    """
    return ist_reference(arm, timing, duration, None, arm_angle, shift=CLEAR_SHIFT)


BACK = 3.0
"""[s] From the end to the start."""

Back = Annotated[float, Option(float, "Time of the way back between the passes, s.")]

GRID = 1e-9
"""[s] By which a time may miss a sample."""


@dataclass(frozen=True, slots=True, eq=False)
class Twice:
    """`once` [0, D], a quintic from its end to its start in `back` [s], and `once` again [D + back, 2 D + back].

    The passes join smoothly where `once` begins and ends at rest. Raises `OptionError` unless `back` is above 0.
    """

    once: Reference
    back: float = BACK
    name: str = "Twice"
    _way: MotionProfile = field(init=False, repr=False)
    _ends: tuple[Array, Array] = field(init=False, repr=False)
    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "_way", quintic(1.0, positive_number("back", self.back)))
        ends = self.once.sample(np.array([self.once.duration, 0.0])).q
        object.__setattr__(self, "_ends", (ends[0], ends[1] - ends[0]))

    @property
    def second(self) -> float:
        """When the second pass begins [s]."""
        return self.once.duration + self.back

    @property
    def duration(self) -> float:
        """Of both passes and the way back [s]."""
        return self.second + self.once.duration

    @property
    def about(self) -> dict[str, Any]:
        """As that of the reference, with the way back."""
        about = dict(getattr(self.once, "about", {}))
        return {**about, "task": f"{about.get('task', 'reference')}-twice", "back": self.back, "second": self.second}

    def sample(self, t: Array) -> Motion:
        """The motion at times t (k,) [s].

        >>> from lwr_dyn import load, reference
        >>> arm = load("lwr4plus")
        >>> move = Twice(reference("point-to-point", arm, start=[0] * 7, end=[1] * 7, duration=2.0))
        >>> move.duration, move.sample(np.array([2.0, 3.5, 5.0, 6.0])).q[:, 0].round(9).tolist()
        (7.0, [1.0, 0.5, 0.0, 0.5])
        """
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        end = self.once.duration
        motion = self.once.sample(np.where(times < self.second, np.minimum(times, end), times - self.second))
        way = ((times > end) & (times < self.second))[:, None]
        if not way.any():
            return Motion(times, motion.q, motion.dq, motion.ddq)
        part, (start, shift) = self._way.at(times - end), self._ends
        return Motion(
            times,
            np.where(way, start + np.outer(part.s, shift), motion.q),
            np.where(way, np.outer(part.ds, shift), motion.dq),
            np.where(way, np.outer(part.dds, shift), motion.ddq),
        )


def part_of(run: Run, start: float, end: float | None = None) -> Run:
    """The part of a run from `start` to `end` [s] (its own end if not given) as a run of its own, from t = 0.

    Its audit and its time on stops, which are of the whole run, are left out. Raises `OptionError` for no samples.
    """
    last = float(run.t[-1]) if end is None else end
    rows = np.flatnonzero((run.t >= start - GRID) & (run.t <= last + GRID))
    if rows.size == 0:
        raise OptionError("part of a run", f"{start:g} to {last:g} s", f"times from 0 to {run.t[-1]:g} s")
    part = slice(int(rows[0]), int(rows[-1]) + 1)
    arrays = {name: getattr(run, name)[part] for name in _SAMPLED}
    meta = {key: value for key, value in run.meta.items() if key not in ("audit", "at_stop_s")}
    return replace(
        run, **arrays, t=run.t[part] - run.t[part.start],
        work={name: work[part] - work[part.start] for name, work in run.work.items()},
        signals={name: signal[part] for name, signal in run.signals.items()},
        events=tuple(replace(e, t=e.t - start) for e in run.events if start <= e.t <= last), meta=meta, setup=None,
    )  # fmt: skip


_SAMPLED = ("q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")


def ist_clear_twice(arm: Arm, back: Back = BACK) -> Twice:
    """`ist-clear` twice; raises as `ist_clear_reference`, and `OptionError` unless `back` is above 0."""
    return Twice(ist_clear_reference(arm), back)
