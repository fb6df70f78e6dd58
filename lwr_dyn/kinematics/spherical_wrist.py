"""Closed-form inverse kinematics of six-joint arms with a spherical wrist: eight branches for each pose, in batches.

Pieper's split (1968): the flange pose gives the wrist centre W, W gives q1, q2, q3, the rotation left gives the rest.

    h = +-sqrt(r^2 - b^2),  q1 = atan2(W_n, W_e) - atan2(b, h)     r: W's distance from axis 1, b: its lateral offset
    cos(bend) = (|t|^2 - l2^2 - l3^2) / (2 l2 l3)                  t: from axis 2 to W in the arm's plane
    Rz(q4) Ry(q5 + offset) Rz(q6) = basis^T R_3^T R_flange back    q6 from what q4 leaves over, so that it fits q4

Singular are: the shoulder (W on axis 1, or at its lateral offset: q1 is not determined), the elbow (stretched or
folded: two branches meet) and the wrist (axes 4 and 6 in line: only q4 +- q6 is determined).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.srs import ALIGNED, JointRanges, turn_about, wrap
from lwr_dyn.kinematics.wrist_geometry import WristArmGeometry

REACH_SLACK = 1e-12
"""[m] A stretched arm's wrist, recomputed from its pose, may stand this far out."""
NEAR_SINGULAR = 1e-5
"""[m] (shoulder) and [rad] (elbow, wrist): poses nearer than this to a singularity are named so."""
SINGULARITIES = ("shoulder", "elbow", "wrist")


class Branch(NamedTuple):
    """One of the eight solutions: shoulder +1 with W ahead of axis 1, elbow and wrist the signs of bend and tilt."""

    shoulder: int
    elbow: int
    wrist: int

    @property
    def label(self) -> str:
        """The three signs.

        >>> Branch(1, -1, 1).label
        '+-+'
        """
        return "".join("+" if sign > 0 else "-" for sign in self)


BRANCHES = tuple(Branch(*signs) for signs in product((1, -1), repeat=3))


@dataclass(frozen=True, slots=True, eq=False)
class WristSolutions:
    """For k poses and the eight `BRANCHES`: q, how far out of reach, how far from each singularity."""

    q: Array
    """(k, 8, 6) [rad], each joint within half a turn of the middle of its range; NaN where out of reach."""
    beyond: Array
    """(k, 8) by how much W is out of reach on that branch [m], 0 within."""
    clearance: Array
    """(k, 8, 3) distance to the shoulder singularity [m], the elbow's and the wrist's [rad]."""

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """(k, 8)."""
        within: NDArray[np.bool_] = self.beyond == 0.0
        return within


@dataclass(frozen=True, slots=True, eq=False)
class _Position:
    """q1, q2, q3 on shoulder and elbow branches (k, 2, 2) with what they say of reach and singularities."""

    q: tuple[Array, Array, Array]
    beyond: Array
    shoulder: Array
    elbow: Array


def closed_form(geometry: WristArmGeometry, ranges: JointRanges, T: Array) -> WristSolutions:
    """All branches for flange poses T (k, 4, 4); ungated."""
    position = _position(geometry, ranges, T)
    shape = (len(T), 2, 2, 2)
    q123 = np.stack([np.broadcast_to(q[..., None], shape) for q in position.q], axis=-1)
    q456, tilt = _wrist(geometry, ranges, T, position)
    q = np.concatenate([q123, q456], axis=-1)
    q = ranges.middle + wrap(q - ranges.middle)
    beyond = np.broadcast_to(position.beyond[..., None], shape)
    spread = (np.broadcast_to(x[..., None], shape) for x in (position.shoulder, position.elbow))
    clearance = np.stack([*spread, np.broadcast_to(tilt, shape)], axis=-1)
    q = np.where((beyond > 0.0)[..., None], np.nan, q)
    return WristSolutions(q.reshape(-1, 8, 6), beyond.reshape(-1, 8), clearance.reshape(-1, 8, 3))


def _position(g: WristArmGeometry, ranges: JointRanges, T: Array) -> _Position:
    wrist = (T[:, :3, 3] + T[:, :3, :3] @ g.wrist_in_flange - g.origin) @ g.frame
    e, n, height = wrist.T
    radius, b = np.hypot(e, n), abs(g.lateral)
    ahead = np.sqrt(np.maximum(radius - b, 0.0) * (radius + b))
    missing = np.maximum(b - radius, 0.0)
    signs = np.array([1.0, -1.0])
    h = g.front * signs * ahead[:, None]
    q1 = np.arctan2(n, e)[:, None] - np.arctan2(g.lateral, h)
    # on axis 1 any q1 serves: the middle of its range, for both branches
    q1 = np.where((radius < ALIGNED)[:, None], ranges.middle[0], q1)
    along, out = height[:, None] - g.shoulder[0], h - g.shoulder[1]
    first, second = g.lengths
    distance = np.hypot(along, out)
    longest, shortest = first + second, abs(first - second)
    short, long = np.maximum(longest - distance, 0.0), np.maximum(distance - shortest, 0.0)
    bend = 2.0 * np.arctan2(np.sqrt(short * (longest + distance)), np.sqrt(long * (distance + shortest)))
    turn = signs * bend[..., None]
    q3 = g.straight + g.elbow_sign * turn
    # the forearm at zero lies `straight` away from the upper arm, so bent it lies at upper's angle + turn
    lean = np.arctan2(g.upper[1], g.upper[0])
    reach = np.arctan2(second * np.sin(turn), first + second * np.cos(turn))
    q2 = np.arctan2(out, along)[..., None] - lean - reach
    beyond = np.maximum(np.maximum(distance - longest, shortest - distance), missing[:, None])
    shape = q2.shape
    return _Position(
        (np.broadcast_to(q1[..., None], shape), q2, q3),
        np.broadcast_to(np.where(beyond > REACH_SLACK, beyond, 0.0)[..., None], shape),
        np.broadcast_to(np.maximum(radius - b, 0.0)[:, None, None], shape),
        np.broadcast_to(np.minimum(bend, np.pi - bend)[..., None], shape),
    )


def _wrist(g: WristArmGeometry, ranges: JointRanges, T: Array, position: _Position) -> tuple[Array, Array]:
    """q4, q5, q6 (k, 2, 2, 2, 3), and how far the tilt is from aligned (k, 2, 2, 1) [rad]."""
    q1, q2, q3 = (q.reshape(-1) for q in position.q)
    _, n, w1 = g.frame.T
    # axes 2 and 3 are parallel: one turn by q2 +- q3
    arm = turn_about(w1, q1) @ turn_about(n, q2 + g.elbow_sign * q3)
    target = T[:, :3, :3] @ (g.home_rotation.T @ g.ball.back)
    left = np.swapaxes(arm @ g.ball.basis, -1, -2).reshape(*position.beyond.shape, 3, 3)
    M = (left @ target[:, None, None])[..., None, :, :]
    sign = np.array([1.0, -1.0])
    sine = np.hypot(M[..., 0, 2], M[..., 1, 2])
    tilt = np.arctan2(sign * sine, M[..., 2, 2])
    q4 = np.arctan2(sign * M[..., 1, 2], sign * M[..., 0, 2])
    aligned = sine < ALIGNED
    q4 = np.where(aligned, _shared(ranges, M), q4)
    c, s = np.cos(q4), np.sin(q4)
    q6 = np.arctan2(c * M[..., 1, 0] - s * M[..., 0, 0], c * M[..., 1, 1] - s * M[..., 0, 1])
    q5 = tilt - g.ball.offset
    away = np.arctan2(sine, np.abs(M[..., 2, 2]))
    return np.stack([q4, np.broadcast_to(q5, q4.shape), q6], axis=-1), away


def _shared(ranges: JointRanges, M: Array) -> Array:
    """q4 of an aligned wrist: the middle of its range, and beyond that only what q6 cannot take within its own."""
    middle, half = ranges.middle[[3, 5]], ranges.half[[3, 5]]
    direction = np.where(M[..., 2, 2] > 0.0, 1.0, -1.0)
    total = np.arctan2(M[..., 1, 0], M[..., 1, 1])
    # q6 = total - direction q4, for M = Rz(q4) Rz(q6) and Rz(q4) Ry(pi) Rz(q6) alike, up to rounding
    q6 = wrap(total - direction * middle[0] - middle[1])
    excess = np.sign(q6) * np.maximum(np.abs(q6) - half[1], 0.0)
    return np.asarray(middle[0] + direction * excess)
