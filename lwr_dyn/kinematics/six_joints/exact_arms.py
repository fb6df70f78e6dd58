"""Which six-joint arms have a closed form that is theirs as it stands, with its text, numbers and batch form."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_six_joints
from lwr_dyn.kinematics.six_joints import snapped_arms, spherical_wrist
from lwr_dyn.kinematics.six_joints.spherical_wrist import SixJointBranches
from lwr_dyn.kinematics.solution import REACH_SLACK, joint_ranges
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True, eq=False)
class SixJointForm:
    """The closed form of one arm."""

    texts: tuple[str, ...]
    """Names for `texts.closed_form_text`."""
    numbers: dict[str, Any]
    branches: Callable[[Array], SixJointBranches]
    """All branches for flange poses T (k, 4, 4), in NumPy."""


def six_joint_form(arm: Arm) -> SixJointForm | None:
    """Of an arm with a spherical wrist or three parallel axes; None for another, also for one that is nearly so."""
    ranges, geometry = joint_ranges(arm), spherical_wrist.wrist_arm_geometry(arm.chain)
    if geometry is not None:
        kind, form, slack = "spherical_wrist", spherical_wrist.closed_form, REACH_SLACK
    else:
        snapped = snapped_arms.snapped_arm(arm.chain, 4)
        if snapped is None or snapped.off:
            return None
        kind, form, slack = "three_parallel", snapped_arms.three_parallel_closed_form, snapped_arms.ROUNDED
        geometry = snapped.geometry
    numbers = numbers_of_six_joints(arm, geometry, slack)
    return SixJointForm(("shared", "six_joints", kind), numbers, partial(form, geometry, ranges, slack=slack))
