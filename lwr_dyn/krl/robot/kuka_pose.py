"""A pose in a KUKA controller's terms: X, Y, Z in mm, A, B, C in deg, Status and Turn, which select a solution.

    R = Rz(A) Ry(B) Rx(C)

At B = +-90 deg only C -+ A is determined, and A is taken as 0. Status S: bit 0, the wrist centre is behind axis 1
(overhead); bit 1, A3 is at or past the angle at which axis 2, axis 3 and the wrist centre lie in line; bit 2, A5 < 0.
Turn T: bit i - 1 is set where A_i < 0. The angle of bit 1 follows from the arm's geometry. The sign of bit 2 is the one
in published pairs of poses and axes; no page of a manual states it.

KUKA's units for the commands `fk` and `ik`: mm and deg, Status and Turn.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose, joint_axes
from lwr_dyn.kinematics.six_joints.spherical_wrist import require_wrist_arm, wrist_arm_geometry
from lwr_dyn.kinematics.solution_rows import Solution
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import from_rpy, rot_z

DEGENERATE = 1e-12
"""Cosine of B below which A and C turn about one axis."""
ZERO = 1e-12
"""[rad, m] An axis or a distance this near to zero counts as zero: its sign is rounding."""
_AXES = np.array([[0, 0, -1], [0, 1, 0], [0, 1, 0], [-1, 0, 0], [0, 1, 0], [-1, 0, 0]], dtype=float)
"""Directions of A1 to A6 in the base at A = 0, the arm stretched out."""


@dataclass(frozen=True, slots=True)
class KukaPose:
    """X, Y, Z [mm], A, B, C [deg], and where known Status and Turn."""

    x_mm: float
    y_mm: float
    z_mm: float
    a_deg: Annotated[float, "About z, then b about y, then c about x."]
    b_deg: float
    c_deg: float
    s: Annotated[int | None, "Status; null of a pose alone."] = None
    t: Annotated[int | None, "Turn; null of a pose alone."] = None

    def matrix(self) -> Array:
        """The pose as a homogeneous (4, 4) matrix [m]."""
        out = np.eye(4)
        out[:3, :3] = rotation_of_abc((self.a_deg, self.b_deg, self.c_deg))
        out[:3, 3] = np.array([self.x_mm, self.y_mm, self.z_mm]) / 1e3
        return out


def has_kuka_axes(arm: Arm) -> bool:
    """Whether the joints are A1 to A6 with KUKA's zero and directions: only then Status and Turn are defined.

    The robot may hang or stand anywhere, so the axes are compared in its own triad: axis 1, axis 2 and their normal.
    """
    if wrist_arm_geometry(arm.chain) is None:
        return False
    z = joint_axes(arm.chain, np.zeros(arm.n)).z
    return bool(np.abs(z @ _triad(z) - _AXES @ _triad(_AXES)).max() < 1e-9)


def _triad(z: Array) -> Array:
    return np.column_stack([z[0], z[1], np.cross(z[0], z[1])])


def kuka_pose(arm: Arm, q: Array) -> KukaPose:
    """The flange at q (6,) [rad] with Status and Turn; ungated. Raises `OptionError` for another kind of arm."""
    return replace(pose_of_matrix(flange_pose(arm.chain, q)), s=status(arm, q), t=turn(q))


def frame_matrix(values: Sequence[float]) -> Array:
    """The pose (4, 4) [m] of X, Y, Z [mm], A, B, C [deg]."""
    x, y, z, a, b, c = values
    return KukaPose(x, y, z, a, b, c).matrix()


def pose_of_matrix(T: Array) -> KukaPose:
    """X, Y, Z, A, B, C of a pose (4, 4) [m], Status and Turn unknown."""
    x, y, z = (float(v) * 1e3 + 0.0 for v in T[:3, 3])
    return KukaPose(x, y, z, *abc_of_rotation(T[:3, :3]))


def abc_of_rotation(R: Array) -> tuple[float, float, float]:
    """A, B, C [deg] of a rotation (3, 3); A = 0 at B = +-90 deg.

    >>> abc_of_rotation(rotation_of_abc((20.0, 90.0, 0.0)))[:2]
    (0.0, 90.0)
    """
    cos_b = math.hypot(R[0, 0], R[1, 0])
    b = math.atan2(-R[2, 0], cos_b)
    a = 0.0 if cos_b < DEGENERATE else math.atan2(R[1, 0], R[0, 0])
    # Rz(A)^T R = Ry(B) Rx(C), whose second row is (0, cos C, -sin C)
    second_row = rot_z(a)[:, 1] @ R
    c = math.atan2(-second_row[2], second_row[1])
    a_deg, b_deg, c_deg = (math.degrees(x) + 0.0 for x in (a, b, c))
    return a_deg, b_deg, c_deg


def rotation_of_abc(abc_deg: Sequence[float]) -> Array:
    """Rz(A) Ry(B) Rx(C) of A, B, C [deg], (3, 3); raises `ShapeError`."""
    a, b, c = np.radians(fixed_array("A, B, C", list(abc_deg), (3,)))
    return from_rpy((c, b, a))


def rotation_angle(R: Array, S: Array) -> Array:
    """The angle [rad] between rotations (..., 3, 3)."""
    return np.asarray(2.0 * np.arcsin(np.minimum(np.linalg.norm(R - S, axis=(-2, -1)) / np.sqrt(8.0), 1.0)))


def degenerate_abc(abc_deg: Sequence[float]) -> bool:
    """Whether B is +-90 deg: A and C turn about one axis.

    >>> degenerate_abc((10.0, -90.0, 0.0))
    True
    """
    return abs(math.cos(math.radians(abc_deg[1]))) < DEGENERATE


def status(arm: Arm, q: Array) -> int:
    """Status S at q (6,) [rad]; raises `OptionError` for an arm without a spherical wrist."""
    g = require_wrist_arm(arm)
    flange = flange_pose(arm.chain, q)
    wrist = (flange[:3, 3] + flange[:3, :3] @ g.wrist_in_flange - g.origin) @ g.frame
    ahead = g.front * float(math.cos(q[0]) * wrist[0] + math.sin(q[0]) * wrist[1])
    bits = (ahead < -ZERO, q[2] >= g.straight - ZERO, q[4] < -ZERO)
    return sum(1 << i for i, bit in enumerate(bits) if bit)


def turn(q: Array) -> int:
    """Turn T at q (6,) [rad].

    >>> turn(np.radians([0, -90, 90, 0, 0, 0]))
    2
    """
    return sum(1 << i for i, x in enumerate(q) if x < -ZERO)


def with_status_and_turn(
    arm: Arm, solutions: Sequence[Solution], s: int | None = None, t: int | None = None
) -> tuple[Solution, ...]:
    """The solutions that have Status `s` and Turn `t`; None takes any.

    Raises
    ------
    OptionError
        No solution has them; the error lists the pairs that exist.
    """
    pairs = [(status(arm, x.q), turn(x.q)) for x in solutions]
    chosen = tuple(x for x, (S, T) in zip(solutions, pairs, strict=True) if s in (None, S) and t in (None, T))
    if not chosen:
        wanted = ", ".join(f"{name} {value}" for name, value in (("S", s), ("T", t)) if value is not None)
        existing = ", ".join(f"S {S} T {T}" for S, T in sorted(set(pairs))) or "none: the pose has no solution"
        raise OptionError("Status, Turn", f"no solution has {wanted}", existing)
    return chosen


@dataclass(frozen=True, slots=True, kw_only=True)
class FlangeRecord(KukaPose):
    """`KukaUnits.record`."""

    axes_deg: Annotated[dict[str, float], "Axis -> deg."]


@dataclass(frozen=True, slots=True)
class KukaUnits:
    """Poses and solutions of an arm in KUKA's units; Status and Turn need an arm with KUKA's axes."""

    arm: Arm

    def line(self, q: Array) -> str:
        """The flange at q (6,) [rad] as X, Y, Z, A, B, C, S, T in KRL's form."""
        values = asdict(kuka_pose(self.arm, q))
        s, t = values.pop("s"), values.pop("t")
        numbers = (f"{name[0].upper()} {round(value or 0.0, 6) + 0.0:.6f}" for name, value in values.items())
        return ", ".join([*numbers, f"S {s}", f"T {t}"])

    def record(self, q: Array) -> dict[str, Any]:
        """Axes in deg and the flange in KUKA's units."""
        axes = dict(zip(self.arm.joint_names, np.degrees(q).tolist(), strict=True))
        return {"axes_deg": axes} | asdict(kuka_pose(self.arm, q))

    def label(self, q: Array) -> str:
        """Status and Turn at q (6,) [rad]."""
        return f"{status(self.arm, q)}, {turn(q)}"

    def note(self, T: Array) -> str | None:
        """A note on A, B, C of a pose (4, 4) at B = +-90 deg; None elsewhere."""
        abc = abc_of_rotation(T[:3, :3])
        if not degenerate_abc(abc):
            return None
        other = "C - A" if abc[1] > 0 else "C + A"
        return f"B is {abc[1]:+.0f} deg: A and C turn about one axis, only {other} counts; written with A = 0"

    def selected(self, solutions: Sequence[Solution], s: int | None, t: int | None) -> tuple[Solution, ...]:
        """The solutions with Status `s` and Turn `t`; raises `OptionError` for none of them or another kind of arm."""
        if not has_kuka_axes(self.arm):
            fault = f"given for {self.arm.name}"
            raise OptionError("--status, --turn", fault, "only for an arm with KUKA's axes A1 to A6")
        return with_status_and_turn(self.arm, solutions, s, t)


def kuka_units(arm: Arm) -> KukaUnits | None:
    """Poses and solutions of an arm in KUKA's units; None for an arm without KUKA's axes A1 to A6."""
    return KukaUnits(arm) if has_kuka_axes(arm) else None
