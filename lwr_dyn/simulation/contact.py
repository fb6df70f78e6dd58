"""Joints at rest and joints that move: impacts at stops, which joints stick, slip or leave a stop, and what ends that.

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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg.lapack import dposv
from scipy.optimize import brentq, minimize_scalar

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.arm_friction import FrictionTorque, Mask, Sides, boxed_lcp
from lwr_dyn.simulation.integrators import Accelerate, Integrator, Rates
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


ACTIVE_FRICTION = "friction feeds energy in"
"""Kind of the event that warns of it; the motion goes on smoothly."""

TURN = 2 * np.pi
"""[rad or m] a step: a joint that makes a whole turn between two samples cannot be followed."""

TIME = 1e-15
"""Tolerance of the time of an event [s]."""

HOLDING = 1e-12
"""[N m] by which a holding torque must pass its bound before the joint starts to slip or leaves its stop."""

HALVINGS = 30
"""How often `first_root` halves the interval to leave a start that is not negative."""


def followable(y: Array, n: int, h: float) -> bool:
    """Whether a state (q, dq, ...) is finite and no joint makes a whole turn in an interval of h [s]."""
    return bool(np.isfinite(y).all() and (np.abs(y[n : 2 * n]) <= TURN / h).all())


@dataclass(frozen=True, slots=True, eq=False)
class Interval:
    """The smooth motion from state y at t over h [s], as if no event came."""

    integrate: Integrator
    rates: Rates
    t: float
    h: float
    y: Array
    _known: dict[float, Array] = field(default_factory=dict)

    def later(self, s: float) -> Array:
        """The state s [s] after the start."""
        if s == 0.0:
            return self.y
        if s not in self._known:
            self._known[s] = self.integrate(self.rates, self.t, self.y, s)
        return self._known[s]


@dataclass(frozen=True, slots=True)
class EventFunction:
    """Joint `joint` starts to slip to `side` ("slip"), reaches its stop ("stop"), or sticks ("stick", side 0).

    `value`, of the time since the start [s], is positive at `until` if the event has come by then.
    """

    kind: str
    joint: int
    side: int
    value: Callable[[float], float]
    until: float


@dataclass(frozen=True, slots=True)
class Crossing:
    """The first of several events, and when it comes after the start [s]."""

    after: float
    event: EventFunction


def earliest(events: Sequence[EventFunction]) -> Crossing | None:
    """The event that comes first; None when none has come."""
    first: Crossing | None = None
    for event in events:
        until = event.until if first is None else min(event.until, first.after)
        if event.value(until) > 0.0:
            first = Crossing(first_root(event.value, until), event)
    return first


def first_root(f: Callable[[float], float], h: float) -> float:
    """Where f turns positive in [0, h], given f(h) > 0; 0 where f(0) >= 0 and halving h meets no negative value.

    >>> first_root(lambda s: s * s - 0.25, 1.0)
    0.5
    """
    low = 0.0
    if f(0.0) >= 0.0:
        low = h
        for _ in range(HALVINGS):
            low /= 2
            if f(low) < 0.0:
                break
        else:
            return 0.0
    return float(brentq(f, low, h, xtol=TIME, rtol=4 * np.finfo(float).eps))


def possible_events(
    mode: ContactMode, interval: Interval, after: Array, barred: Mask, holding: Callable[[float], Array]
) -> list[EventFunction]:
    """What may end the mode within the interval, at whose end the state is `after`.

    `holding` (n,) is the holding torque at a time since the start; `barred` (n,) joints do not start to slip.
    """
    events = _slip_events(mode, interval, barred, holding) if mode.any_at_rest else []
    if mode.all_at_rest:
        return events
    return events + _limit_events(mode, interval, after) + _stick_events(mode, interval, after)


def _limit_events(mode: ContactMode, interval: Interval, after: Array) -> list[EventFunction]:
    """Joints beyond a position limit at the end of the interval."""
    plant, out = mode.plant, []
    for j in np.flatnonzero(plant.beyond(after[: plant.n]) & ~mode.at_rest):
        side = 1 if after[j] > plant.upper[j] else -1
        limit = float((plant.upper if side > 0 else plant.lower)[j])
        out.append(EventFunction("stop", int(j), side, _excess(interval, int(j), side, limit), interval.h))
    return out


def _stick_events(mode: ContactMode, interval: Interval, after: Array) -> list[EventFunction]:
    """Joints whose speed is against their side at the end of the interval, or may have been so within it.

    The latter are braked so much at first that their speed might pass zero, yet move on at the end.
    """
    n, sides, h, directional = mode.plant.n, mode.sides, interval.h, mode.plant.friction.directional
    if not directional.any():
        return []
    speed, at_end = sides * interval.y[n : 2 * n], sides * after[n : 2 * n]
    out = []
    for j in np.flatnonzero(directional & (sides != 0) & (at_end < 0.0)):
        out.append(EventFunction("stick", int(j), 0, _excess(interval, n + int(j), -int(sides[j])), h))
    braked = speed + h * sides * interval.rates(interval.t, interval.y)[n : 2 * n] < 0.0
    for j in np.flatnonzero(directional & (speed > 0.0) & braked & (at_end > 0.0)):
        value = _excess(interval, n + int(j), -int(sides[j]))
        slowest = minimize_scalar(lambda s, value=value: -value(s), bounds=(0.0, h), method="bounded").x
        out.append(EventFunction("stick", int(j), 0, value, float(slowest)))
    return out


def _slip_events(
    mode: ContactMode, interval: Interval, barred: Mask, holding: Callable[[float], Array]
) -> list[EventFunction]:
    """Joints at rest that need more than can resist them at the end; an excess that comes and goes is not seen."""
    last = holding(interval.h)
    high, low = last > mode.highest + HOLDING, last < mode.lowest - HOLDING
    out = []
    for j in np.flatnonzero(mode.at_rest & ~barred & (high | low)):
        side = 1 if high[j] else -1
        bound = float(mode.highest[j] if side > 0 else mode.lowest[j])

        def excess(s: float, j: int = int(j), side: int = side, bound: float = bound) -> float:
            return float(side * (holding(s)[j] - bound)) - HOLDING

        out.append(EventFunction("slip", int(j), side, excess, interval.h))
    return out


def _excess(interval: Interval, index: int, side: int, limit: float = 0.0) -> Callable[[float], float]:
    """How far entry `index` of the state is beyond a limit."""
    return lambda s: float(side * (interval.later(s)[index] - limit))
