"""Motion profiles by name: how a path in space is travelled in a given time."""

from collections.abc import Callable
from dataclasses import dataclass

from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.trajectory.blends import blended
from lwr_dyn.trajectory.double_s import double_s_in
from lwr_dyn.trajectory.motion_profile import MotionProfile, concatenate, constant_speed, quintic, stretched
from lwr_dyn.trajectory.path import Path


@dataclass(frozen=True, slots=True)
class SmoothTiming:
    """What the smooth profiles keep: bounds along the path, and how far from a joint the path is left.

    `acceleration` [m/s^2] and `jerk` [m/s^3] of the length travelled; `ease` [m] at the bends (line into arc, arc
    into arc: passed at speed v unrounded, the acceleration would jump by v^2 / radius); `blend` [m] at corners,
    for "smooth-blended" only. ease = 0 follows the path exactly and has those jumps.
    """

    acceleration: float = 0.5
    jerk: float = 5.0
    ease: float = 0.005
    blend: float = 0.02


TimedPath = tuple[Path, MotionProfile]
MOTION_PROFILES: Registry[Callable[[Path, float, SmoothTiming], TimedPath]] = Registry(
    "motion_profile",
    {
        "constant": Row(
            "lwr_dyn.trajectory.timings:constant",
            "constant speed over the whole path: the speed jumps at both ends, its direction at corners",
        ),
        "quintic": Row(
            "lwr_dyn.trajectory.timings:quintic_per_segment",
            "a quintic from rest to rest on each segment of the path, in times proportional to their lengths",
        ),
        "smooth": Row(
            "lwr_dyn.trajectory.timings:smooth",
            "double-S, stops at corners, bends (where only the curvature jumps) eased and passed at speed",
            facts={"smoothness": True},
        ),
        "smooth-blended": Row(
            "lwr_dyn.trajectory.timings:smooth_blended",
            "double-S, corners blended and passed at speed, a stop only where the path turns back",
            facts={"smoothness": True},
        ),
    },
)
"""Each row times a path: `factory(path, duration, smoothness)` gives the path, blended or not, and its profile."""


def constant(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """Constant speed over the whole path."""
    return path, constant_speed(path.length, duration)


def quintic_per_segment(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """A quintic from rest to rest on each segment, in times proportional to the lengths."""
    pace = duration / path.length
    profiles = [quintic(segment.length, pace * segment.length) for segment in path.segments]
    return path, stretched(concatenate(profiles), duration)


def smooth(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """Double-S with a stop at each corner; bends are eased and passed at speed."""
    return _double_s(blended(path, bends=smoothness.ease), duration, smoothness)


def smooth_blended(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    """Double-S over bends and corners; a stop only where the path turns back."""
    return _double_s(blended(path, corners=smoothness.blend, bends=smoothness.ease), duration, smoothness)


def _double_s(path: Path, duration: float, smoothness: SmoothTiming) -> TimedPath:
    return path, double_s_in(path.sections(), duration, smoothness.acceleration, smoothness.jerk)
