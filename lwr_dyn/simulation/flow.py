"""The motion over one interval whatever happens in it: stops met, joints held and let go, friction, any torque source.

The state is y = (q, dq, work of the motors, work of friction, memory of the controller).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.model.run import Event
from lwr_dyn.simulation.events import Found, Interval, first_event, followable
from lwr_dyn.simulation.integrators import Integrator, Rates
from lwr_dyn.simulation.plant import Plant
from lwr_dyn.simulation.stops import Mask, constrained, held_joints, impact

Drive = Callable[[float, Array, Array, Array], tuple[Array, Array]]
"""(t, q, dq, memory) -> torque that reaches the joints (n,), derivative of the memory."""

MOST_EVENTS = 50
"""Events within one interval after which no more are looked for in it."""


@dataclass(slots=True, eq=False)
class Flow:
    """Advances a plant; it keeps the journal of events, the work of the stops and which joints are held."""

    plant: Plant
    integrate: Integrator
    stop_work: float = 0.0
    evaluations: int = 0
    events: list[Event] = field(default_factory=list)
    _held: Mask = field(init=False)

    def __post_init__(self) -> None:
        self._held = np.zeros(self.plant.n, dtype=bool)

    def advance(self, drive: Drive, t: float, y: Array, h: float) -> Array:
        """y(t + h), with every event in between."""
        end, n = t + h, self.plant.n
        forced, barred = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)

        def net_torque(t: float, y: Array) -> Array:
            tau, _ = drive(t, y[:n], y[n : 2 * n], y[2 * n + 2 :])
            return tau if self.plant.friction is None else tau - self.plant.friction(y[n : 2 * n])

        for _ in range(MOST_EVENTS):
            y = self._meet_stops(t, y)
            held = self._held_now(t, y, net_torque(t, y), forced, barred)
            interval = Interval(self.integrate, self._rates(drive, held), t, end - t, y)
            after = interval.later(end - t)
            if not followable(after, n, h):
                return after
            found = first_event(self.plant, net_torque, interval, held, forced)
            if found is None:
                return after
            t, y = t + found.after, self._at_event(found, interval.later(found.after))
            barred[:] = False
            barred[found.joint] = not found.side
            forced[found.joint] |= bool(found.side) and found.after == 0.0
        return self.integrate(self._rates(drive, self._held), t, y, end - t)

    def _rates(self, drive: Drive, held: Mask) -> Rates:
        plant, n = self.plant, self.plant.n
        forward, friction = plant.raw.forward_dynamics, plant.friction
        anything_held, none = bool(held.any()), np.zeros(n)

        def rates(t: float, y: Array) -> Array:
            self.evaluations += 1
            q, dq = y[:n], y[n : 2 * n]
            tau, memory_rate = drive(t, q, dq, y[2 * n + 2 :])
            drag = none if friction is None else friction(dq)
            net = tau - drag
            ddq = constrained(plant, q, dq, net, held)[0] if anything_held else forward(q, dq, net)
            return np.concatenate([dq, ddq, (tau @ dq, -(drag @ dq)), memory_rate])

        return rates

    def _at_event(self, found: Found, y: Array) -> Array:
        """The state at an event, the joint that met its stop exactly there."""
        plant, n, joint = self.plant, self.plant.n, found.joint
        y = np.concatenate([np.clip(y[:n], plant.lower, plant.upper), y[n:]])
        if found.side:
            y[joint] = (plant.upper if found.side > 0 else plant.lower)[joint]
            if found.after == 0.0:  # it left by less than a float can show: it has not left
                y[n + joint] = 0.0
        return y

    def _meet_stops(self, t: float, y: Array) -> Array:
        met = meet_stops(self.plant, t, y)
        if met is None:
            return y
        self.stop_work += met.work
        self.events += met.events
        return met.y

    def _held_now(self, t: float, y: Array, tau: Array, forced: Mask, barred: Mask) -> Mask:
        """Which joints rest against a stop from here on; those that no longer do are written down."""
        n = self.plant.n
        resting = held_joints(self.plant, y[:n], y[n : 2 * n], tau)
        held: Mask = ((resting & ~barred) | forced) & (y[n : 2 * n] == 0.0)
        for joint in np.flatnonzero(self._held & ~held):
            self.events.append(Event(t, "release", int(joint)))
        self._held = held
        return held


@dataclass(frozen=True, slots=True, eq=False)
class Met:
    """What an impact left: the state, the work of the stops [J], and its events."""

    y: Array
    work: float
    events: list[Event]


def meet_stops(plant: Plant, t: float, y: Array) -> Met | None:
    """Impacts of joints that stand at a limit with outward speed; None where there is none."""
    n = plant.n
    q, dq = y[:n], y[n : 2 * n]
    if not (plant.at_limit(q) * dq > 0.0).any():
        return None
    hit = impact(plant, q, dq)
    struck = np.flatnonzero(hit.stopped & (dq != 0.0))
    events = [Event(t, "stop", int(joint), float(-hit.work[joint])) for joint in struck]
    return Met(np.concatenate([q, hit.dq, y[2 * n :]]), float(hit.work.sum()), events)
