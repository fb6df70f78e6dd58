"""`JointElasticity`: the spring and the damper between the motor side and the link side of every gear."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.foundation.errors import MissingDataError, OptionError

DAMPING_TIME = 1e-3
"""[s] Damping over stiffness where neither a file nor a caller gives it."""


@dataclass(frozen=True, slots=True, eq=False)
class JointElasticity:
    """The torque of gear i is K_i (theta_i - q_i) + D_i (dtheta_i - dq_i), theta the motor's angle seen at the joint.

    Raises
    ------
    OptionError
        A stiffness that is not above 0, a damping below 0.
    ShapeError
        Not one number a joint.
    """

    stiffness: Array  # K (n,) [N m/rad]
    damping: Array  # D (n,) [N m s/rad]
    source: str = "given by the caller"

    def __post_init__(self) -> None:
        n = np.size(self.stiffness)
        freeze_arrays(self, "stiffness", "damping")
        for name, least in (("stiffness", "above 0"), ("damping", "of at least 0")):
            values = fixed_array(f"joint {name}", getattr(self, name), (n,))
            bad = values <= 0.0 if name == "stiffness" else values < 0.0
            if bad.any():
                joint = int(np.argmax(bad))
                raise OptionError(f"{name} of joint {joint + 1}", f"{values[joint]:g}", f"numbers {least}")

    def of_joints(self, joints: list[int]) -> JointElasticity:
        """That of some joints (0-based)."""
        return JointElasticity(self.stiffness[joints], self.damping[joints], self.source)


def chosen_elasticity(arm: Any, option: JointElasticity | str | float | None) -> JointElasticity | None:
    """What the option `elasticity` of `simulate` names; None for rigid joints.

    A number is the largest stiffness [N m/rad]: the proportions of the joints, and damping over stiffness, are those of
    the arm's file, or all joints equal with `DAMPING_TIME`. Raises `OptionError`, and `MissingDataError` where the file
    gives none.
    """
    if option is None:
        return None
    if isinstance(option, JointElasticity):
        fixed_array("joint stiffness", option.stiffness, (arm.n,))
        return option
    own: JointElasticity | None = arm.elasticity
    if option == "file":
        if own is None:
            raise MissingDataError(arm.name, "joint stiffness", "elastic joints")
        return own
    if isinstance(option, bool | str) or not (isfinite(option) and option > 0.0):
        raise OptionError("stiffness", repr(option), '"file", a number above 0 in N m/rad, or a JointElasticity')
    if own is None:
        return JointElasticity(np.full(arm.n, option), np.full(arm.n, DAMPING_TIME * option))
    factor = option / own.stiffness.max()
    return JointElasticity(factor * own.stiffness, factor * own.damping, f"{own.source}, times {factor:g}")
