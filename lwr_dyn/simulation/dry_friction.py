"""Set-valued friction of a whole arm as arrays: smooth while each joint keeps its direction, an interval at rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array, read_only
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction
from lwr_dyn.simulation.box import Sides

SlipLaw = Callable[[Array], Array]
"""tau_friction(dq) of joints that keep their directions, smooth through dq = 0, so that a trial step may pass it."""


@dataclass(frozen=True, slots=True, eq=False)
class DryFriction:
    """Coulomb, static and viscous friction of n joints; arrays (2, n) hold the positive and the negative direction.

    `lowest`, `highest` (n,) bound what friction can hold at rest; `lowest_slip`, `highest_slip` (n,) are its values at
    vanishing speed, which are smaller where static friction falls to Coulomb's at the first motion.
    """

    coulomb: Array
    viscous: Array
    fall: Array
    """(static - coulomb) where it falls with speed (Stribeck), else 0 [N m]."""
    sharpness: Array
    """1 / stribeck_velocity^2, or 0."""
    offset: Array
    lowest: Array
    highest: Array
    lowest_slip: Array
    highest_slip: Array

    @classmethod
    def of(cls, joints: Sequence[JointFriction | None]) -> DryFriction:
        """From the friction of each joint; None has none."""
        each = [joint or FRICTIONLESS for joint in joints]
        both = [[joint.positive for joint in each], [joint.negative for joint in each]]
        coulomb, viscous, fall, sharpness, hold = (
            np.array([[number(d) for d in row] for row in both])
            for number in (_coulomb, _viscous, _fall, _sharpness, _holding)
        )
        offset = np.array([joint.offset for joint in each])
        bounds = (offset - hold[1], offset + hold[0], offset - (coulomb + fall)[1], offset + (coulomb + fall)[0])
        return cls(*(read_only(a) for a in (coulomb, viscous, fall, sharpness, offset, *bounds)))

    def slip(self, sides: Sides) -> SlipLaw:
        """The law of joints that move to these sides (n,), +1 or -1; joints with 0 have no friction in it."""
        moving = sides != 0
        way = np.where(sides < 0, 1, 0)

        def picked(table: Array) -> Array:
            return np.where(moving, np.take_along_axis(table, way[None], axis=0)[0], 0.0)

        level = sides * picked(self.coulomb) + np.where(moving, self.offset, 0.0)
        slope, fall, sharpness = picked(self.viscous), sides * picked(self.fall), -picked(self.sharpness)
        if not fall.any():
            return lambda dq: level + slope * dq
        return lambda dq: level + slope * dq + fall * np.exp(sharpness * dq * dq)


def _coulomb(d: Direction) -> float:
    return d.coulomb


def _viscous(d: Direction) -> float:
    return d.viscous


def _holding(d: Direction) -> float:
    return d.holding


def _fall(d: Direction) -> float:
    return 0.0 if d.stribeck_velocity is None else d.holding - d.coulomb


def _sharpness(d: Direction) -> float:
    return 0.0 if d.stribeck_velocity is None else d.stribeck_velocity**-2
