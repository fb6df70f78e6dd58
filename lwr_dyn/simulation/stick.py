"""Which joints stick and which slip, and how the arm accelerates with the former at rest.

The rule where static friction exceeds Coulomb's, since several answers may then be right: a joint at rest stays at rest
if it can. First every joint at rest is held by its static level; those that even this cannot hold give way and from
then on resist with Coulomb's level only; what remains at rest is judged again, until nobody else gives way. Where
static friction equals Coulomb's there is one answer, and this is it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from lwr_dyn.arrays import Array
from lwr_dyn.simulation.box import Sides, between_bounds
from lwr_dyn.simulation.dry_friction import DryFriction, SlipLaw
from lwr_dyn.simulation.plant import Plant
from lwr_dyn.simulation.stops import Mask


@dataclass(frozen=True, slots=True, eq=False)
class Regime:
    """What holds as long as no joint starts, stops or turns round: the sides the joints move to, and what follows."""

    plant: Plant
    sides: Sides
    law: SlipLaw
    resting: Mask
    highest: Array
    """Most that can resist a joint at rest, (n,) [N m]; infinite at a stop, and for joints that move."""
    lowest: Array
    anybody_rests: bool
    everybody_rests: bool

    def accelerator(self) -> Callable[[Array, Array, Array], Array]:
        """(q, dq, tau - friction of the moving joints) -> ddq (n,), exactly 0 for joints at rest."""
        raw = self.plant.raw
        if not self.anybody_rests:
            forward: Callable[[Array, Array, Array], Array] = raw.forward_dynamics
            return forward
        if self.everybody_rests:
            still = np.zeros(self.plant.n)
            return lambda q, dq, net: still
        free = (~self.resting).astype(np.float64)
        keep, fill = np.outer(free, free), np.diag(1.0 - free)
        mass, bias = raw.mass_matrix, raw.bias_torque

        def accelerate(q: Array, dq: Array, net: Array) -> Array:
            B, rest = mass(q) * keep + fill, (net - bias(q, dq)) * free
            _, ddq, fault = dposv(B, rest)
            return np.asarray(ddq if fault == 0 else np.linalg.solve(B, rest))

        return accelerate

    def push(self, q: Array, dq: Array, net: Array, ddq: Array) -> Array:
        """What has to resist joints at rest so that they stay there, (n,) [N m]; 0 for joints that move."""
        raw = self.plant.raw
        needed = net - raw.bias_torque(q, dq) - raw.mass_matrix(q) @ ddq
        return np.asarray(np.where(self.resting, needed, 0.0))


def regime(plant: Plant, dry: DryFriction, q: Array, sides: Sides) -> Regime:
    """The regime in which joints move to these sides (n,), 0 for those at rest."""
    resting = sides == 0
    low, high = _bounds(plant.at_limit(q), dry.lowest, dry.highest)
    return Regime(
        plant, sides, dry.slip(sides), resting, np.where(resting, high, np.inf), np.where(resting, low, -np.inf),
        anybody_rests=bool(resting.any()), everybody_rests=bool(resting.all()),
    )  # fmt: skip


def settled(plant: Plant, dry: DryFriction, q: Array, dq: Array, tau: Array, given_way: Sides) -> Sides:
    """Which way each joint moves from here on (n,): by its speed, and joints without speed by the rule above.

    `given_way` (n,) names joints at rest of which it is known that they just gave way, and to which side.
    """
    sides = np.sign(dq).astype(int)
    at = np.flatnonzero(sides == 0)
    if not at.size:
        return sides
    B_inv = np.linalg.inv(plant.raw.mass_matrix(q))
    free = B_inv @ (tau - dry.slip(sides)(dq) - plant.raw.bias_torque(q, dq))
    M, weak, start, limit = B_inv[np.ix_(at, at)], given_way[at] != 0, given_way[at], plant.at_limit(q)[at]
    while True:
        low, high = (
            np.where(weak, slip, hold)
            for slip, hold in ((dry.lowest_slip[at], dry.lowest[at]), (dry.highest_slip[at], dry.highest[at]))
        )
        low, high = _bounds(limit, low, high)
        start = between_bounds(M, free[at], low, high, start).sides
        others = (start != 0) & ~weak
        if not others.any():
            break
        weak |= others
    sides[at] = start
    return sides


def _bounds(limit: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """A stop resists without bound: below at a lower limit (-1), above at an upper one (+1)."""
    return np.where(limit < 0, -np.inf, low), np.where(limit > 0, np.inf, high)
