"""Friction that is assumed: Coulomb's, as a share of the torque limits."""

from dataclasses import replace

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction, symmetric


def coulomb_friction(arm: Arm, share: float) -> tuple[JointFriction, ...]:
    """Coulomb friction of each joint as a share of its torque limit; raises `OptionError` where one is unknown."""
    if not np.isfinite(arm.effort).all():
        known = f"{arm.name} has no friction of its own, and joints without a torque limit"
        raise OptionError("plant friction", known, "an arm with one of them")
    return tuple(symmetric(share * limit, 0.0) for limit in arm.effort.tolist())


def arm_with_friction(arm: Arm, share: float) -> Arm:
    """The arm with `coulomb_friction` as if its file gave it; raises `OptionError` for an arm that has its own."""
    if any(arm.friction_models()):
        raise OptionError("friction", "a share of the torque limits", f"none: {arm.name} has friction of its own")
    if not (np.isfinite(share) and share > 0.0):
        raise OptionError("friction", share, "a share of the torque limits above 0, as 0.01")
    return replace(arm, friction=coulomb_friction(arm, share))
