"""How a point is passed: the share of each motion that may be rounded, and the time in which two motions overlap.

The corner begins where the rest of the way is below its distance (C_DIS), its share of half the way (C_PTP), its angle
(C_ORI), or where the motion that slows down is below its share of the programmed speed (C_VEL); never before the middle
of a motion. The overlap of two motions lies in the ramps.
"""

import math

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.motion.motion_segments import AxisSplineSegment, CartesianSegment, MotionSegment, PtpSegment
from lwr_dyn.krl.motion.pose_paths import STILL
from lwr_dyn.krl.motion.settings import Blend, Corner
from lwr_dyn.krl.motion.timeline import Pause, SlowedPart, Timeline, TimelineItem
from lwr_dyn.trajectory.motion_profile import MotionProfile

HALVINGS = 30
SAMPLES = np.linspace(0.0, 1.0, 9)


def append_segment(timeline: Timeline, segment: MotionSegment, blend: Blend | None, tool: Array) -> TimelineItem:
    """Adds the segment; it starts early where a blend allows overlap."""
    before = timeline.items[-1].part if timeline.items else None
    if blend is None or before is None or isinstance(before, Pause | SlowedPart):
        return timeline.add(segment)
    corner = Corner(corner_share(before, blend, tool, True), corner_share(segment, blend, tool, False))
    overlap = min(seconds_within(before, corner.before, True), seconds_within(segment, corner.after, False))
    return timeline.add(segment, overlap if overlap > 1e-9 else 0.0, corner)


def corner_share(segment: MotionSegment, blend: Blend, tool: Array, at_end: bool) -> float:
    """The share of the way, at most a half, at the end (or the beginning) of a segment that the corner may take."""
    if blend.kinds[0] == "C_PTP" and not isinstance(segment, CartesianSegment):
        return 0.5 * min(blend.cptp, 100.0) / 100.0
    kind = next((kind for kind in reversed(blend.kinds) if kind != "C_PTP"), "C_DIS")
    share = 0.5
    if kind == "C_VEL":
        slow = min(blend.cvel, 100.0) / 100.0 * segment.bounds.speed
        share = slow**2 / (2.0 * segment.bounds.ramp * segment.profile.length)
    elif kind == "C_ORI" and isinstance(segment, CartesianSegment):
        share = blend.cori / max(segment.path.angle, STILL)
    elif isinstance(segment, CartesianSegment):
        # on an arc the chord is shorter than the way: this is on the safe side
        share = blend.cdis / max(segment.path.length, STILL)
    else:
        share = _share_near(segment, tool, blend.cdis, at_end)
    return min(share, 0.5)


def seconds_within(segment: MotionSegment, share: float, at_end: bool) -> float:
    """The time [s], within the ramp, in which the last (or the first) `share` of the way is travelled."""
    profile = segment.profile
    knots, pieces = profile.knots, profile.coefficients
    ramp = float(knots[-1] - knots[-2]) if at_end else float(knots[1])
    if len(pieces) > 3:
        return _seconds_in_ramp(profile, share, at_end)
    travelled = pieces[0, 2] * ramp**2 / profile.length
    return ramp * math.sqrt(min(1.0, max(share, 0.0) / travelled))


def _seconds_in_ramp(profile: MotionProfile, share: float, at_end: bool) -> float:
    """The same for a spline, whose ramp has many pieces: as long as the speed grows from rest."""
    knots = profile.knots
    sample = profile.at(knots)
    s, t = (profile.length - sample.s[::-1], knots[-1] - knots[::-1]) if at_end else (sample.s, knots)
    v = sample.ds[::-1] if at_end else sample.ds
    falls = np.flatnonzero(np.diff(v) <= 0.0)
    last = int(falls[0]) if len(falls) else len(v) - 1
    # from rest the way grows with the square of the time
    return float(np.interp(math.sqrt(max(share, 0.0) * profile.length), np.sqrt(s[: last + 1]), t[: last + 1]))


def _share_near(segment: PtpSegment | AxisSplineSegment, tool: Array, distance: float, at_end: bool) -> float:
    """The share of a motion of the axes, up to a half, in which the tool centre point is within `distance` [m]."""
    low, high = 0.0, 0.5
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        share = middle * SAMPLES
        q = segment.axes_at(1.0 - share if at_end else share)
        p = (flange_pose(segment.arm.chain, q) @ tool)[:, :3, 3]
        inside = float(np.max(np.linalg.norm(p - p[0], axis=1))) <= distance
        low, high = (middle, high) if inside else (low, middle)
    return low
