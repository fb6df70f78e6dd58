"""The geometry of arms with a closed form of inverse kinematics, read off their axes at q = 0: S-R-S arms.

S-R-S arm (spherical, roll, spherical): axes 1, 2, 3 meet at the shoulder S, axes 5, 6, 7 at the wrist W, neighbours
among them perpendicular; joint 4 is the elbow, whose axis is perpendicular to the plane of S and W.

    R_flange = R_shoulder(q1, q2, q3) Rot(w4, q4) R_wrist(q5, q6, q7) R_home

Shoulder, elbow and wrist may be offset, the flange may be anywhere, and zero and direction of each joint are free.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, read_only
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain

MEETING = 1e-9
"""[m, or sine] Axes this near to each other meet; directions this near to a right angle are perpendicular."""

SRS_ARM = "a seven-joint arm with a spherical shoulder, an elbow and a spherical wrist"

Geometry = TypeVar("Geometry")


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """Three axes through one point, each perpendicular to the next: roll, tilt and roll (a spherical joint).

    Rot(w1, q1) Rot(w2, q2) Rot(w3, q3) = basis Rz(q1) Ry(q2 + offset) Rz(q3) back^T
    """

    basis: Array
    """(3, 3), columns w2 x w1, w2, w1 in the base at q = 0."""
    offset: float
    """Tilt between the two rolls at q = 0 [rad]: w3 is w1 turned by it about w2."""
    back: Array
    """(3, 3) basis turned by `offset` about w2."""


@dataclass(frozen=True, slots=True, eq=False)
class SrsGeometry:
    """Constants of an S-R-S arm in the base at q = 0: lengths [m], angles [rad]."""

    shoulder: Array
    upper: Array
    """(3,) From the shoulder to the elbow point (the foot of S on axis 4)."""
    fore: Array
    """(3,) From the elbow point to the wrist."""
    elbow_axis: Array
    straight: float
    """q4 at which shoulder, elbow and wrist lie in line [rad]."""
    wrist_in_flange: Array
    home_rotation: Array
    first: Ball
    last: Ball
    reference: Array
    """(3,) The unit vector that fixes the zero of the arm angle; by default the axis of joint 1."""

    @property
    def lengths(self) -> tuple[float, float]:
        """Upper arm and forearm [m]."""
        return float(np.linalg.norm(self.upper)), float(np.linalg.norm(self.fore))

    def with_reference(self, reference: ArrayLike | None) -> Self:
        """The same arm with the arm angle counted from another direction of the base; raises as `fixed_array`."""
        if reference is None:
            return self
        direction = fixed_array("reference", reference, (3,))
        length = float(np.linalg.norm(direction))
        if length < MEETING:
            raise OptionError("reference", direction.tolist(), "a direction, not zero")
        return replace(self, reference=read_only(direction / length))


@lru_cache(maxsize=32)
def srs_geometry(chain: Chain) -> SrsGeometry | None:
    """The constants of the arm, or None when the chain is not S-R-S."""
    if chain.n != 7 or not chain.turning.all():
        return None
    axes = joint_axes(chain, np.zeros(7))
    z, p, flange = axes.z, axes.p, axes.flange
    shoulder, wrist = meeting_point(z[:3], p[:3]), meeting_point(z[4:], p[4:])
    first, last = ball_of(z[:3]), ball_of(z[4:])
    if shoulder is None or wrist is None or first is None or last is None:
        return None
    w4 = z[3]
    elbow = p[3] + w4 * (w4 @ (shoulder - p[3]))
    upper, fore = elbow - shoulder, wrist - elbow
    if abs(w4 @ fore) > MEETING or min(np.linalg.norm(upper), np.linalg.norm(fore)) < MEETING:
        return None
    return SrsGeometry(
        shoulder=read_only(shoulder),
        upper=read_only(upper),
        fore=read_only(fore),
        elbow_axis=read_only(w4),
        straight=float(np.arctan2(w4 @ np.cross(fore, upper), fore @ upper)),
        wrist_in_flange=read_only(flange[:3, :3].T @ (wrist - flange[:3, 3])),
        home_rotation=read_only(flange[:3, :3]),
        first=first,
        last=last,
        reference=read_only(z[0]),
    )


def require_srs(arm: Arm, reference: ArrayLike | None = None) -> SrsGeometry:
    """As `srs_geometry`, with another `reference` of the arm angle; raises `OptionError` when the arm is not S-R-S."""
    return required(arm, srs_geometry(arm.chain), SRS_ARM).with_reference(reference)


def required(arm: Arm, geometry: Geometry | None, allowed: str) -> Geometry:
    """The geometry; raises `OptionError` when it is None."""
    if geometry is None:
        raise OptionError("arm", arm.name, allowed)
    return geometry


def meeting_point(z: Array, p: Array, tolerance: float = MEETING) -> Array | None:
    """The point where lines meet to a tolerance [m], or None."""
    across = np.eye(3) - z[:, :, None] * z[:, None, :]
    point = np.linalg.lstsq(across.reshape(-1, 3), np.einsum("nij,nj->ni", across, p).reshape(-1), rcond=None)[0]
    away = np.einsum("nij,nj->ni", across, point - p)
    return point if np.linalg.norm(away, axis=1).max() < tolerance else None


def ball_of(z: Array) -> Ball | None:
    """The ball of three axis directions, or None where neighbours are not perpendicular."""
    w1, w2, w3 = z
    if max(abs(w1 @ w2), abs(w2 @ w3)) > MEETING:
        return None
    basis = np.column_stack([np.cross(w2, w1), w2, w1])
    offset = float(np.arctan2(w2 @ np.cross(w1, w3), w1 @ w3))
    back = np.column_stack([np.cross(w2, w3), w2, w3])
    return Ball(read_only(basis), offset, read_only(back))
