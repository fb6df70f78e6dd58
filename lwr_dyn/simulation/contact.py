"""Joints at rest and joints that move: impacts at position stops, and which joints stick, slip, or leave a stop.

A joint that meets its limit stops there without bounce. With J the rows of the joints at a limit, the impact is the
boxed problem of `boxed_lcp` on their speeds: an impulse f that resists outward motion without bound and inward motion
not at all,

    dq+ = dq - B^-1 J^T f,   f = 0 or dq+ = 0     (inelastic: no joint leaves with a gain)

For one joint it is dq+ = dq - B^-1 J^T (J B^-1 J^T)^-1 J dq.

Where static friction exceeds Coulomb's several answers may be right, and this rule decides: a joint at rest stays at
rest if it can. First every joint at rest is held by its static level. Those that it cannot hold slip, and resist with
Coulomb's level only. What remains at rest is judged again, until no other joint slips. Where static friction equals
Coulomb's there is one answer, and this is it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.arm_friction import FrictionTorque, Mask
from lwr_dyn.simulation.boxed_lcp import Sides, boxed_lcp
from lwr_dyn.simulation.integrators import Accelerate
from lwr_dyn.simulation.plant import Plant


@dataclass(frozen=True, slots=True, eq=False)
class ImpactResult:
    """Speeds after an impact (n,), which joints were stopped (n,), the work of their stops (n,) [J]: none positive."""

    dq: Array
    stopped: Mask
    work: Array


def impact(plant: Plant, q: Array, dq: Array) -> ImpactResult:
    """What the stops do to joints that reach their limits with outward speed.

    The work is impulse . (dq- + dq+) / 2, not the energy that was lost: so the audit can compare the two.
    """
    side = plant.at_limit(q)
    at = np.flatnonzero(side)
    B_inv = np.linalg.inv(plant.ungated.mass_matrix(q))
    low, high = stop_bounds(side[at], np.zeros(at.size), np.zeros(at.size))
    impulse = np.zeros(plant.n)
    impulse[at] = -boxed_lcp(B_inv[np.ix_(at, at)], dq[at], low, high).force
    after = dq + B_inv @ impulse
    stopped = impulse != 0.0
    after[stopped] = 0.0
    return ImpactResult(after, stopped, impulse * (dq + after) / 2)


def stop_bounds(side: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Bounds of the resistance with stops: no bound below at a lower limit (side -1), above at an upper one (+1)."""
    return np.where(side < 0, -np.inf, low), np.where(side > 0, np.inf, high)


@dataclass(frozen=True, slots=True, eq=False)
class ContactMode:
    """Which joints rest and to which sides the others move; it holds until a joint starts, stops or turns round.

    `lowest`, `highest` (n,) [N m] bound what can resist a joint at rest; infinite at a stop, and for moving joints.
    `friction_low`, `friction_high` (n,) are the bounds of what friction alone can hold; 0 for moving joints.
    """

    plant: Plant
    sides: Sides
    at_rest: Mask
    friction: FrictionTorque | None
    lowest: Array
    highest: Array
    friction_low: Array
    friction_high: Array
    any_at_rest: bool
    all_at_rest: bool

    def friction_torque(self, dq: Array) -> Array:
        """tau_friction of the moving joints, (n,) [N m]."""
        return np.zeros(self.plant.n) if self.friction is None else self.friction(dq)

    def accelerator(self) -> Accelerate:
        """The function that gives the accelerations, exactly 0 for joints at rest."""
        ungated = self.plant.ungated
        if not self.any_at_rest:
            forward: Accelerate = ungated.forward_dynamics
            return forward
        if self.all_at_rest:
            still = np.zeros(self.plant.n)
            return lambda q, dq, net: still
        moving = (~self.at_rest).astype(np.float64)
        keep, fill = np.outer(moving, moving), np.diag(1.0 - moving)
        mass, bias = ungated.mass_matrix, ungated.bias_torque

        def accelerate(q: Array, dq: Array, net: Array) -> Array:
            B, rest = mass(q) * keep + fill, (net - bias(q, dq)) * moving
            _, ddq, fault = dposv(B, rest)
            return np.asarray(ddq if fault == 0 else np.linalg.solve(B, rest))

        return accelerate

    def holding_torque(self, q: Array, dq: Array, net: Array, ddq: Array) -> Array:
        """What has to resist joints at rest so that they stay there, (n,) [N m]; 0 for moving joints."""
        ungated = self.plant.ungated
        needed = net - ungated.bias_torque(q, dq) - ungated.mass_matrix(q) @ ddq
        return np.asarray(np.where(self.at_rest, needed, 0.0))

    def friction_part(self, holding: Array) -> Array:
        """The part of a holding torque that friction gives, (n,) [N m]; the rest comes from the stop."""
        return np.asarray(np.minimum(np.maximum(holding, self.friction_low), self.friction_high))


def contact_mode(plant: Plant, q: Array, sides: Sides) -> ContactMode:
    """The mode in which joints move to these sides (n,); 0 is rest for a joint that can rest."""
    limit, friction = plant.at_limit(q), plant.friction
    at_rest = (sides == 0) & _can_rest(plant, limit)
    low, high = stop_bounds(limit, friction.lowest, friction.highest)
    return ContactMode(
        plant, sides, at_rest, friction.torque(sides, at_rest),
        lowest=np.where(at_rest, low, -np.inf), highest=np.where(at_rest, high, np.inf),
        friction_low=np.where(at_rest, friction.lowest, 0.0), friction_high=np.where(at_rest, friction.highest, 0.0),
        any_at_rest=bool(at_rest.any()), all_at_rest=bool(at_rest.all()),
    )  # fmt: skip


def _can_rest(plant: Plant, limit: Array) -> Mask:
    """Joints that friction or a stop can hold; the others pass zero speed like any other."""
    return np.asarray(plant.friction.directional | (limit != 0.0))


def resolve_stick_slip(plant: Plant, q: Array, dq: Array, tau: Array, guess: Sides) -> Sides:
    """Which way each joint moves from here on (n,): by its speed, and joints without speed by the rule above.

    `guess` (n,) decides on the border between rest and motion; a joint with a side in it resists with Coulomb's level.
    """
    sides, limit, friction = np.sign(dq).astype(int), plant.at_limit(q), plant.friction
    candidates = (dq == 0.0) & _can_rest(plant, limit)
    at = np.flatnonzero(candidates)
    if not at.size:
        return sides
    B_inv = np.linalg.inv(plant.ungated.mass_matrix(q))
    torque = friction.torque(sides, candidates)
    net = tau if torque is None else tau - torque(dq)
    free = B_inv @ (net - plant.ungated.bias_torque(q, dq))
    M, slips, start = B_inv[np.ix_(at, at)], guess[at] != 0, guess[at]
    while True:
        low = np.where(slips, friction.lowest_slip[at], friction.lowest[at])
        high = np.where(slips, friction.highest_slip[at], friction.highest[at])
        start = boxed_lcp(M, free[at], *stop_bounds(limit[at], low, high), start).sides
        others = (start != 0) & ~slips
        if not others.any():
            break
        slips |= others
    sides[at] = start
    return sides
