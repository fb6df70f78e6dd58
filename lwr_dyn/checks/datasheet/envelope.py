"""Working envelope of the wrist centre of a six-joint arm: its section, reach and volume in closed form.

In the plane of the arm the wrist centre is shoulder + Rot(q2) (upper + Rot(q3) fore), q2 and q3 within their limits.
The outline consists of circular arcs: joint 3 at a limit or the elbow straight (about the shoulder), joint 2 at a limit
(about the elbow). All arcs are cut where they meet; a piece belongs to the outline when only one side of it can be
reached. The section with r >= 0, revolved about axis 1, has the volume

    V = range_1 / (2 pi) * pi * sum over the outline of  integral r^2 dz        (Green, Pappus)

in closed form on each arc. Lengths [m]; r is counted from axis 1, positive ahead; z along it, from the base upward.

Bent back overhead the wrist centre also reaches r < 0, behind axis 1. The KR 30 HA's data sheet does not count that;
here it is a number of its own, from the outline of what is reached on either side, folded onto r >= 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.kinematics.six_joints.spherical_wrist import SixJointGeometry, require_wrist_arm
from lwr_dyn.model.arm import Arm

MEET = 1e-9
"""[m] Circles this near to each other touch; pieces shorter than this are points."""


@dataclass(frozen=True, slots=True)
class EnvelopeArc:
    """Points (r, z) = centre + radius (cos phi, sin phi) [m], phi from `start` to `end` [rad] in either direction."""

    centre: tuple[float, float]
    radius: float
    start: float
    end: float

    def point(self, phi: float) -> tuple[float, float]:
        """(r, z) at phi."""
        return self.centre[0] + self.radius * math.cos(phi), self.centre[1] + self.radius * math.sin(phi)

    def points(self, count: int = 61) -> Array:
        """`count` points along it, (count, 2), for drawing."""
        phi = np.linspace(self.start, self.end, count)
        return np.array(self.centre) + self.radius * np.column_stack([np.cos(phi), np.sin(phi)])

    def mirrored(self) -> EnvelopeArc:
        """The arc on the other side of axis 1, (-r, z)."""
        return EnvelopeArc((-self.centre[0], self.centre[1]), self.radius, math.pi - self.start, math.pi - self.end)

    def farthest(self) -> float:
        """Largest r on it [m]."""
        low, high = min(self.start, self.end), max(self.start, self.end)
        ahead = low + (-low) % (2.0 * math.pi)
        ends = (self.point(self.start)[0], self.point(self.end)[0])
        return max(*ends, self.centre[0] + self.radius if ahead <= high else -math.inf)

    def moment(self) -> float:
        """integral r^2 dz along it [m^3], with r = c + R cos(phi), dz = R cos(phi) dphi."""
        return self._moment_to(self.end) - self._moment_to(self.start)

    def _moment_to(self, phi: float) -> float:
        c, R, s = self.centre[0], self.radius, math.sin(phi)
        return R * (c**2 * s + c * R * (phi + s * math.cos(phi)) + R**2 * (s - s**3 / 3.0))


def pieces(arc: EnvelopeArc, others: Sequence[EnvelopeArc]) -> list[EnvelopeArc]:
    """The arc cut where it meets the circles of the others and the axis r = 0."""
    low, high = min(arc.start, arc.end), max(arc.start, arc.end)
    cuts = {low, high}
    on_axis = math.acos(-arc.centre[0] / arc.radius) if abs(arc.centre[0]) <= arc.radius else None
    at_axis = [] if on_axis is None else [on_axis, -on_axis]
    for angle in [*at_axis, *(phi for other in others if other != arc for phi in _meetings(arc, other))]:
        first = low + (angle - low) % (2.0 * math.pi)
        cuts.update(np.arange(first, high, 2.0 * math.pi).tolist())
    ends = sorted(cuts)
    return [EnvelopeArc(arc.centre, arc.radius, a, b) for a, b in pairwise(ends) if (b - a) * arc.radius > MEET]


def _meetings(arc: EnvelopeArc, other: EnvelopeArc) -> list[float]:
    """phi on `arc` where its circle meets the circle of `other`; none where both are one circle."""
    dr, dz = other.centre[0] - arc.centre[0], other.centre[1] - arc.centre[1]
    apart = math.hypot(dr, dz)
    if apart < MEET or apart > arc.radius + other.radius + MEET or apart < abs(arc.radius - other.radius) - MEET:
        return []
    cosine = (arc.radius**2 + apart**2 - other.radius**2) / (2.0 * arc.radius * apart)
    half, towards = math.acos(max(-1.0, min(1.0, cosine))), math.atan2(dz, dr)
    return [towards - half, towards + half]


BESIDE = 1e-7
"""[m] Distance from a piece of arc at which its two sides are tested."""
AHEAD, BEHIND = 1.0, -1.0
"""Sides of axis 1: r >= 0 and r < 0."""


@dataclass(frozen=True, slots=True)
class Envelope:
    """The section ahead of axis 1 (r >= 0) as arcs with the reachable side on their left, its reach and volume."""

    outline: tuple[EnvelopeArc, ...]
    reach: float
    """Largest distance of the wrist centre from axis 1 in that section [m]."""
    volume: float
    """Of that section, revolved [m^3]; what is reached overhead only, behind axis 1, is not in it."""
    reach_behind: float
    """Largest distance from axis 1 with the arm bent back overhead, r < 0 [m]; 0 where it reaches no such point."""
    volume_with_overhead: float
    """Of all that is reached, on either side of axis 1 [m^3]."""

    @property
    def overhead(self) -> str:
        """What `reach` and `volume` leave out, in words."""
        more = self.volume_with_overhead - self.volume
        behind = f"bent back overhead (r < 0) it reaches {1e3 * self.reach_behind:.2f} mm behind axis 1"
        return f"{behind} and {more:.4f} m^3 more, {self.volume_with_overhead:.4f} m^3 in all"

    def record(self) -> dict[str, float | str]:
        """Its numbers for JSON, with what they count."""
        return {
            "section": SECTION, "reach": self.reach, "volume": self.volume,
            "reach_behind": self.reach_behind, "volume_with_overhead": self.volume_with_overhead,
        }  # fmt: skip


SECTION = "ahead of axis 1 (r >= 0)"
"""What `reach` and `volume` of an envelope count, in words."""


def working_envelope(arm: Arm) -> Envelope:
    """The envelope of the wrist centre inside the position limits.

    Exact, but for the volume with what is reached overhead of an arm whose wrist runs beside the plane of axis 1 and
    whose joint 1 makes less than a turn: there the two sides overlap a little more or less than is counted. Raises
    `OptionError` for an arm without six joints and a spherical wrist, `MissingDataError` where a limit of joints 1 to 3
    is not known.

    >>> import lwr_dyn
    >>> envelope = working_envelope(lwr_dyn.load("kr30ha"))
    >>> round(envelope.reach, 4), round(envelope.volume, 3), round(envelope.volume_with_overhead, 3)
    (2.0327, 27.243, 28.342)
    """
    section = _Section.of(arm)
    outline, behind, either = (section.outline(sides) for sides in ((AHEAD,), (BEHIND,), (AHEAD, BEHIND)))
    moments = [sum(arc.moment() for arc in arcs) for arcs in (outline, behind, either)]
    both = moments[0] + moments[1] - moments[2]  # reached from ahead and from behind
    share = min(float(arm.upper[0] - arm.lower[0]) / (2.0 * math.pi), 1.0)
    # a point behind is reached half a turn of joint 1 away from the same point ahead
    volume_of_all = math.pi * (share * (moments[2] - both) + min(2.0 * share, 1.0) * both)
    lateral = section.geometry.lateral
    reach, reach_behind = (
        max((math.hypot(arc.farthest(), lateral) for arc in arcs), default=without)
        for arcs, without in ((outline, math.nan), (behind, 0.0))
    )
    return Envelope(outline, reach, share * math.pi * moments[0], reach_behind, volume_of_all)


@dataclass(frozen=True, slots=True, eq=False)
class _Section:
    """Joints 2 and 3 with their limits, and the position of the arm's plane in (r, z)."""

    geometry: SixJointGeometry
    lower: Array
    upper: Array
    up: float
    """+1 when axis 1 points up the base's z, else -1."""
    height: float
    """z of the geometry's origin."""

    @classmethod
    def of(cls, arm: Arm) -> _Section:
        geometry = require_wrist_arm(arm)
        if not np.isfinite([arm.lower[:3], arm.upper[:3]]).all():
            raise MissingDataError(arm.name, "limits of joints 1 to 3", "the working envelope")
        w1 = geometry.frame[:, 2]
        up = 1.0 if w1[int(np.argmax(np.abs(w1)))] > 0.0 else -1.0
        return cls(geometry, arm.lower[1:3], arm.upper[1:3], up, up * float(w1 @ geometry.origin))

    def outline(self, sides: tuple[float, ...]) -> tuple[EnvelopeArc, ...]:
        """The outline of what is reached on these sides of axis 1, folded onto r >= 0; each piece once."""
        arcs = [arc if side > 0.0 else arc.mirrored() for side in sides for arc in self.arcs()]
        found: list[EnvelopeArc] = []
        for arc in arcs:
            for part in pieces(arc, arcs):
                piece = self.facing_in(part, sides)
                if piece is not None and not any(_same_place(piece, other) for other in found):
                    found.append(piece)
        return tuple(found)

    def arcs(self) -> tuple[EnvelopeArc, ...]:
        """All arcs of which the outline can consist."""
        g, (low2, low3), (up2, up3) = self.geometry, self.lower, self.upper
        straight = [g.straight + k * math.pi for k in range(-3, 4)]
        arcs = []
        for q3 in [low3, up3, *(x for x in straight if low3 < x < up3)]:
            arm = g.upper + _turned(g.fore, g.elbow_sign * q3)
            arcs.append(self._arc(g.shoulder, arm, low2, up2))
        for q2 in (low2, up2):
            elbow, fore = g.shoulder + _turned(g.upper, q2), _turned(g.fore, q2)
            arcs.append(self._arc(elbow, fore, g.elbow_sign * low3, g.elbow_sign * up3))
        return tuple(arcs)

    def _arc(self, centre: Array, spoke: Array, first: float, last: float) -> EnvelopeArc:
        """The arc of the tip of `spoke` (along, out) that turns about `centre` from `first` to `last` [rad]."""
        r, z = float(self.geometry.front * centre[1]), float(self.up * centre[0] + self.height)
        sr, sz = self.geometry.front * spoke[1], self.up * spoke[0]
        # a turn takes `along` towards `out`: in (r, z) that is clockwise unless one of the two axes is reversed
        way = -1.0 if self.up * self.geometry.front > 0.0 else 1.0
        start = math.atan2(sz, sr)
        return EnvelopeArc((r, z), math.hypot(sr, sz), start + way * float(first), start + way * float(last))

    def reachable(self, r: float, z: float) -> bool:
        """Whether some q2, q3 within the limits bring the wrist centre to (r, z)."""
        g = self.geometry
        along, out = self.up * (z - self.height) - g.shoulder[0], g.front * r - g.shoulder[1]
        first, second = g.lengths
        cosine = (along**2 + out**2 - first**2 - second**2) / (2.0 * first * second)
        if abs(cosine) > 1.0:
            return False
        for bend in (math.acos(cosine), -math.acos(cosine)):
            q3 = g.straight + g.elbow_sign * bend
            reach = g.upper + _turned(g.fore, g.elbow_sign * q3)
            q2 = math.atan2(out, along) - math.atan2(reach[1], reach[0])
            if _within(q2, self.lower[0], self.upper[0]) and _within(q3, self.lower[1], self.upper[1]):
                return True
        return False

    def facing_in(self, arc: EnvelopeArc, sides: tuple[float, ...]) -> EnvelopeArc | None:
        """The piece with the reachable side on its left; None when it is not on the outline of the section r >= 0."""
        phi = (arc.start + arc.end) / 2.0
        if arc.point(phi)[0] < 0.0:
            return None
        inner, outer = (
            EnvelopeArc(arc.centre, arc.radius + side * BESIDE, arc.start, arc.end).point(phi) for side in (-1.0, 1.0)
        )
        inside, outside = (any(self.reachable(side * r, z) for side in sides) for r, z in (inner, outer))
        if inside == outside:
            return None
        forward = (arc.end > arc.start) == inside
        return arc if forward else EnvelopeArc(arc.centre, arc.radius, arc.end, arc.start)


def _turned(v: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])


def _within(angle: float, low: float, up: float) -> bool:
    """Whether the angle, or one whole turns away, lies between the limits."""
    return low + (angle - low) % (2.0 * math.pi) <= up


def _same_place(arc: EnvelopeArc, other: EnvelopeArc) -> bool:
    """Whether two pieces of one circle are the same; both are cut where an end lies, as another arc begins there."""
    middle, there = ((each.start + each.end) / 2.0 for each in (arc, other))
    same_circle = math.dist((*arc.centre, arc.radius), (*other.centre, other.radius)) < MEET
    return same_circle and math.dist(arc.point(middle), other.point(there)) < BESIDE
