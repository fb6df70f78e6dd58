"""KUKA's units for the commands `fk` and `ik`: mm and deg, Status and Turn."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.solution import Solution
from lwr_dyn.krl.robot.kuka_pose import (
    KukaPose,
    abc_of_rotation,
    degenerate_abc,
    has_kuka_axes,
    kuka_pose,
    pose_of_matrix,
    rotation_of_abc,
    status,
    turn,
    with_status_and_turn,
)
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True)
class KukaUnits:
    """Poses and solutions of an arm in KUKA's units; Status and Turn need an arm with KUKA's axes."""

    arm: Arm

    @property
    def has_axes(self) -> bool:
        """Whether the arm has KUKA's axes A1 to A6."""
        return has_kuka_axes(self.arm)

    def line(self, q: Array) -> str:
        """The flange at q (6,) [rad] as X, Y, Z, A, B, C, S, T in KRL's form."""
        values = pose_record(kuka_pose(self.arm, q))
        s, t = values.pop("s"), values.pop("t")
        numbers = (f"{name[0].upper()} {round(value or 0.0, 6) + 0.0:.6f}" for name, value in values.items())
        return ", ".join([*numbers, f"S {s}", f"T {t}"])

    def record(self, q: Array) -> dict[str, Any]:
        """Axes in deg and the flange in KUKA's units."""
        axes = dict(zip(self.arm.joint_names, np.degrees(q).tolist(), strict=True))
        return {"axes_deg": axes} | pose_record(kuka_pose(self.arm, q))

    def pose_record(self, T: Array) -> dict[str, Any]:
        """A pose (4, 4) [m] without Status and Turn."""
        return pose_record(pose_of_matrix(T))

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

    def rotation(self, abc_deg: Sequence[float]) -> Array:
        """The rotation (3, 3) of A, B, C [deg], of any arm; raises `ShapeError`."""
        return rotation_of_abc(abc_deg)

    def selected(self, solutions: Sequence[Solution], s: int | None, t: int | None) -> tuple[Solution, ...]:
        """The solutions with Status `s` and Turn `t`; raises `OptionError` for none of them or another kind of arm."""
        if not self.has_axes:
            fault = f"given for {self.arm.name}"
            raise OptionError("--status, --turn", fault, "only for an arm with KUKA's axes A1 to A6")
        return with_status_and_turn(self.arm, solutions, s, t)


def pose_record(pose: KukaPose) -> dict[str, Any]:
    """The numbers of a pose by name."""
    return {name: getattr(pose, name) for name in KukaPose.__slots__}


def kuka_units(arm: Arm) -> KukaUnits | None:
    """Poses and solutions of an arm in KUKA's units; None for an arm without KUKA's axes A1 to A6."""
    units = KukaUnits(arm)
    return units if units.has_axes else None
