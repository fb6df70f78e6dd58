"""The path of a reference without its timing: pieces q(s) that can be passed without a stop, and the way back.

A reference that knows its path keeps it apart from its motion profiles s(t). The path is then the same reference with
profiles of constant speed: dq is q'(s) and ddq is q''(s), exactly. A stop is needed where q'(s) jumps: at a corner of a
path in space, and between legs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.trajectory.motion_profile import MotionProfile, concatenate, constant_speed
from lwr_dyn.trajectory.pose_path import timed_pose_path
from lwr_dyn.trajectory.references.joint_moves import JointReference
from lwr_dyn.trajectory.references.pose_path_reference import PosePathReference, pose_path_reference

Curve = Callable[[Array], tuple[Array, Array, Array]]
"""s (k,) -> q, q' and q'' (k, n), exact derivatives of each other."""

KINDS = "a path in space, legs, a move between joint positions, or a CurveReference"


@dataclass(frozen=True, slots=True, eq=False)
class PathPiece:
    """A piece q(s) of a path, s from 0 to `length`, passed without a stop; `breaks` are places where q'' jumps."""

    curve: Curve
    length: float
    breaks: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True, eq=False)
class JointPath:
    """Pieces of a path, and `timed`, which makes a reference of a profile of each."""

    pieces: tuple[PathPiece, ...]
    timed: Callable[[Sequence[MotionProfile]], Reference]


@dataclass(frozen=True, slots=True, eq=False)
class CurveReference:
    """A curve q(s) (n,) with its timing: dq = q' ds, ddq = q'' ds^2 + q' dds, exact.

    Parameters
    ----------
    curve : function
        s (k,) -> q, q', q'' (k, n), for s from 0 to `profile.length`, of any unit; q'(s) must not vanish on a stretch.
    profile : MotionProfile
        When it is where.
    """

    curve: Curve
    profile: MotionProfile
    about: dict[str, Any] = field(default_factory=dict)
    name: ClassVar[str] = "CurveReference"
    """In run files."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.profile.duration

    def sample(self, t: ArrayLike) -> Motion:
        """The motion at times t (k,) [s]; before 0 and after `duration` it stands still; raises `ShapeError`."""
        times = np.atleast_1d(real_array("t", t))
        at = self.profile.at(times)
        q, first, second = self.curve(at.s)
        ds, dds = at.ds[:, None], at.dds[:, None]
        return Motion(times, q, first * ds, second * ds**2 + first * dds)


def path_of_reference(reference: Reference) -> JointPath:
    """The path of a reference, cut where it needs a stop.

    Raises `OptionError`: a reference that does not keep its path apart from its timing, or that only stands still.
    """
    if isinstance(reference, PosePathReference):
        return _pose_path(reference)
    if isinstance(reference, JointReference):
        return _moves(reference)
    if isinstance(reference, CurveReference):
        piece = PathPiece(reference.curve, reference.profile.length)
        return JointPath((piece,), lambda profiles: replace(reference, profile=profiles[0]))
    legs = getattr(reference, "legs", ())
    if legs and all(hasattr(leg, "profile") and hasattr(leg, "at") for leg in legs):
        return _legs(reference, tuple(legs))
    raise OptionError("reference", f"{type(reference).__name__}, whose path is not known apart from its timing", KINDS)


def _legs(reference: Any, legs: tuple[Any, ...]) -> JointPath:
    """Any reference with `legs`: dataclasses that have a `profile` and the motion `at(t)`."""

    def timed(profiles: Sequence[MotionProfile]) -> Any:
        quick = tuple(replace(leg, profile=profile) for leg, profile in zip(legs, profiles, strict=True))
        return replace(reference, legs=quick)

    still = [replace(leg, profile=_unhurried(leg.profile.length)) for leg in legs]
    pieces = tuple(PathPiece(_derivatives(leg.at), leg.profile.length) for leg in still)
    return JointPath(pieces, timed)


def _moves(reference: JointReference) -> JointPath:
    """Straight lines between joint positions; legs in which no joint moves keep their time."""
    steps = np.diff(reference.waypoints, axis=0)
    moving = [k for k, step in enumerate(steps) if step.any()]
    if not moving:
        raise OptionError("reference", "only stands still", "a path that moves")

    def timed(profiles: Sequence[MotionProfile]) -> Reference:
        every = list(reference.profiles)
        for k, profile in zip(moving, profiles, strict=True):
            every[k] = profile
        return replace(reference, profiles=tuple(every))

    pieces = tuple(PathPiece(_straight(reference.waypoints[k], steps[k]), 1.0) for k in moving)
    return JointPath(pieces, timed)


def _pose_path(reference: PosePathReference) -> JointPath:
    path, orientation = reference.poses.path, reference.poses.orientation
    limits = reference.margin >= 0.0

    def with_profile(profile: MotionProfile) -> PosePathReference:
        poses = timed_pose_path(path, orientation, profile)
        made = pose_path_reference(reference.arm, poses, reference.arm_angle, dict(reference.about), limits)
        kept = {key: reference.about[key] for key in ("arm_angle",) if key in reference.about}
        return replace(made, about={**made.about, **kept})

    sample = _derivatives(with_profile(_unhurried(path.length)).sample)
    cuts = np.array([0.0, *(corner.s for corner in path.corners()), path.length])
    pieces = []
    for begin, end in pairwise(cuts):
        inside = path.starts[(path.starts > begin) & (path.starts < end)]
        pieces.append(PathPiece(_shifted(sample, float(begin)), float(end - begin), inside - begin))
    return JointPath(tuple(pieces), lambda profiles: with_profile(joined(profiles, cuts)))


def joined(profiles: Sequence[MotionProfile], cuts: Array) -> MotionProfile:
    """Profiles end to end, each from its cut on without rounding: at a corner, the tangent behind it counts."""
    whole = concatenate(profiles)
    c = whole.coefficients.copy()
    c[np.cumsum([0, *(len(one.coefficients) for one in profiles[:-1])]), 0] = cuts[:-1]
    return replace(whole, coefficients=c, length=float(cuts[-1]))


def _unhurried(length: float) -> MotionProfile:
    """The profile s = t."""
    return constant_speed(length, length)


def _derivatives(sample: Callable[[Array], Motion]) -> Curve:
    def curve(s: Array) -> tuple[Array, Array, Array]:
        motion = sample(s)
        return motion.q, motion.dq, motion.ddq

    return curve


def _shifted(curve: Curve, begin: float) -> Curve:
    return lambda s: curve(s + begin)


def _straight(start: Array, step: Array) -> Curve:
    def curve(s: Array) -> tuple[Array, Array, Array]:
        return start + np.outer(s, step), np.broadcast_to(step, (s.size, step.size)), np.zeros((s.size, step.size))

    return curve
