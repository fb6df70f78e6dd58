"""Circular arcs in the plane of an arm, counted from axis 1: where they meet, their pieces, their part of a volume."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lwr_dyn.foundation.arrays import Array

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

    def same_circle(self, other: EnvelopeArc) -> bool:
        """Whether both are parts of one circle."""
        return math.dist((*self.centre, self.radius), (*other.centre, other.radius)) < MEET

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
    for angle in [*_on_axis(arc), *(phi for other in others if other != arc for phi in _meetings(arc, other))]:
        first = low + (angle - low) % (2.0 * math.pi)
        cuts.update(np.arange(first, high, 2.0 * math.pi).tolist())
    ends = sorted(cuts)
    return [EnvelopeArc(arc.centre, arc.radius, a, b) for a, b in pairwise(ends) if (b - a) * arc.radius > MEET]


def _on_axis(arc: EnvelopeArc) -> list[float]:
    if abs(arc.centre[0]) > arc.radius:
        return []
    phi = math.acos(-arc.centre[0] / arc.radius)
    return [phi, -phi]


def _meetings(arc: EnvelopeArc, other: EnvelopeArc) -> list[float]:
    """phi on `arc` where its circle meets the circle of `other`; none where both are one circle."""
    dr, dz = other.centre[0] - arc.centre[0], other.centre[1] - arc.centre[1]
    apart = math.hypot(dr, dz)
    if apart < MEET or apart > arc.radius + other.radius + MEET or apart < abs(arc.radius - other.radius) - MEET:
        return []
    cosine = (arc.radius**2 + apart**2 - other.radius**2) / (2.0 * arc.radius * apart)
    half, towards = math.acos(max(-1.0, min(1.0, cosine))), math.atan2(dz, dr)
    return [towards - half, towards + half]
