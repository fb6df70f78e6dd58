"""Friction with its jump at rest smoothed by a tanh, for integrators that need a smooth right-hand side.

It cannot hold a joint at rest: under a load F below break-away the joint creeps at about width F/F_c. Set-valued
friction (`lwr_dyn.simulation`) holds it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError
from lwr_dyn.model.friction.models import FRICTIONLESS, JointFriction


def smooth_friction(models: Sequence[JointFriction | None], width: float = 1e-3) -> Callable[[Array], Array]:
    """The function tau_friction(dq) with tanh(dq / width) in place of sign(dq), (..., n) -> (..., n) [N m or N].

    tau = offset + level(|dq|) tanh(dq / width) + viscous dq, level and viscous those of the direction of dq. It is
    continuous, with a kink at 0 where the directions differ; at 0 it is the offset. Ungated, for loops.

    Parameters
    ----------
    models : sequence of JointFriction or None
        One per joint.
    width : float
        Speed at which friction reaches 76 % of its level [rad/s or m/s], above 0.

    Raises
    ------
    OptionError
        A width that is not a number above 0.

    >>> from lwr_dyn.model.friction.models import symmetric
    >>> friction = smooth_friction([symmetric(2.0, 0.5)], width=1e-3)
    >>> friction(np.array([0.0])).item(), friction(np.array([-1.0])).item()
    (0.0, -2.5)
    """
    if not (np.isfinite(width) and width > 0.0):
        raise OptionError("width", width, "a speed above 0")
    joints = [m or FRICTIONLESS for m in models]
    offset = np.array([m.offset for m in joints])
    both = [[m.positive for m in joints], [m.negative for m in joints]]
    coulomb, viscous = (
        np.array([[getattr(d, name) for d in side] for side in both]) for name in ("coulomb", "viscous")
    )
    drop = np.array([[d.holding - d.coulomb if d.stribeck_velocity else 0.0 for d in side] for side in both])
    scale = np.array([[d.stribeck_velocity or 1.0 for d in side] for side in both])
    has_stribeck = bool(drop.any())

    def torque(dq: Array) -> Array:
        forward = dq > 0.0
        level = np.where(forward, coulomb[0], coulomb[1])
        if has_stribeck:
            x = dq / np.where(forward, scale[0], scale[1])
            level = level + np.where(forward, drop[0], drop[1]) * np.exp(-np.square(x))
        return np.asarray(offset + level * np.tanh(dq / width) + np.where(forward, viscous[0], viscous[1]) * dq)

    return torque
