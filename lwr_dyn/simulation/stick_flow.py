"""The motion over one interval with set-valued friction: joints that start, stop, turn round, meet a stop or leave it.

Same state and same use as `Flow`: y = (q, dq, work of the motors, work of friction, memory of the controller).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.model.run import Event
from lwr_dyn.simulation.box import Sides
from lwr_dyn.simulation.dry_friction import DryFriction
from lwr_dyn.simulation.events import Interval, earliest, followable
from lwr_dyn.simulation.flow import MOST_EVENTS, Drive, meet_stops
from lwr_dyn.simulation.integrators import Integrator, Rates
from lwr_dyn.simulation.plant import Plant
from lwr_dyn.simulation.stick import Regime, regime, settled
from lwr_dyn.simulation.stick_events import Happening, Watch, coming_to_rest, giving_way, passing
from lwr_dyn.simulation.stops import Mask

TIE = 1e-12
"""[s] Joints that would stop within it of each other stop in the same instant."""
NUDGE = 1e-14
"""Share of the largest speed after an impact that counts as none: an impact moves no joint by rounding."""


@dataclass(slots=True, eq=False)
class StickFlow:
    """Advances a plant with set-valued friction; it keeps the journal of events and the sides the joints move to."""

    plant: Plant
    integrate: Integrator
    dry: DryFriction
    stop_work: float = 0.0
    evaluations: int = 0
    events: list[Event] = field(default_factory=list)
    friction: Array = field(init=False)
    """tau_friction (n,) where the last interval began [N m]."""
    now: Regime = field(init=False)
    _begun: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        n = self.plant.n
        self.friction = np.zeros(n)
        self.now = regime(self.plant, self.dry, np.zeros(n), np.zeros(n, dtype=int))

    def advance(self, drive: Drive, t: float, y: Array, h: float) -> Array:
        """y(t + h), with every event in between."""
        end, n = t + h, self.plant.n
        barred = np.zeros(n, dtype=bool)
        y = self.begin(drive, t, y)
        for _ in range(MOST_EVENTS):
            interval = Interval(self.integrate, self._rates(drive), t, end - t, y)
            after = interval.later(end - t)
            if not followable(after, n, h):
                return after
            watched = self._watched(drive, interval, after, barred)
            first = earliest((watch.f, watch.until) for watch in watched)
            if first is None:
                return after
            what = watched[first.index].what
            t, y = t + first.after, self._meet(t + first.after, self._at(what, interval, first.after))
            if first.after > 0.0:
                barred[:] = False
            elif what.kind == "rest":  # it had just given way, by rounding: it may not do so again at the same moment
                barred[what.joint] = True
            given_way = np.zeros(n, dtype=int)
            given_way[what.joint] = what.side * (what.kind == "slip")
            self._settle(t, y, self._torque(drive, t, y), given_way)
        self.events.append(Event(t, "more events than followed"))
        return self.integrate(self._rates(drive), t, y, end - t)

    def begin(self, drive: Drive, t: float, y: Array) -> Array:
        """The state at the start of an interval, impacts done; its regime and its friction torque are kept."""
        n = self.plant.n
        if not np.isfinite(y).all():
            return y
        y = self._meet(t, y)
        q, dq, tau = y[:n], y[n : 2 * n], self._torque(drive, t, y)
        self._settle(t, y, tau, np.zeros(n, dtype=int))
        drag = self.now.law(dq)
        if self.now.anybody_rests:
            push = self._push(q, dq, tau - drag)
            drag = np.where(self.now.resting, np.clip(push, self.dry.lowest, self.dry.highest), drag)
        self.friction = np.asarray(drag)
        return y

    def _torque(self, drive: Drive, t: float, y: Array) -> Array:
        n = self.plant.n
        return drive(t, y[:n], y[n : 2 * n], y[2 * n + 2 :])[0]

    def _push(self, q: Array, dq: Array, net: Array) -> Array:
        self.evaluations += 1
        return self.now.push(q, dq, net, self.now.accelerator()(q, dq, net))

    def _meet(self, t: float, y: Array) -> Array:
        met, n = meet_stops(self.plant, t, y), self.plant.n
        if met is None:
            return y
        self.stop_work += met.work
        self.events += met.events
        dq = met.y[n : 2 * n]
        dq[np.abs(dq) <= NUDGE * np.abs(y[n : 2 * n]).max()] = 0.0
        return met.y

    def _settle(self, t: float, y: Array, tau: Array, given_way: Sides) -> None:
        """The regime from here on; joints that change are written down."""
        n = self.plant.n
        sides = settled(self.plant, self.dry, y[:n], y[n : 2 * n], tau, given_way)
        old, at_stop = self.now.sides, self.plant.at_limit(y[:n]) != 0.0
        if self._begun:
            self.events += [_told(t, int(j), old[j], sides[j], at_stop[j]) for j in np.flatnonzero(sides != old)]
        if not self._begun or at_stop.any() or (sides != old).any():
            self.now = regime(self.plant, self.dry, y[:n], sides)
        self._begun = True

    def _rates(self, drive: Drive) -> Rates:
        n, law, accelerate = self.plant.n, self.now.law, self.now.accelerator()

        def rates(t: float, y: Array) -> Array:
            self.evaluations += 1
            q, dq = y[:n], y[n : 2 * n]
            tau, memory_rate = drive(t, q, dq, y[2 * n + 2 :])
            drag = law(dq)
            return np.concatenate([dq, accelerate(q, dq, tau - drag), (tau @ dq, -(drag @ dq)), memory_rate])

        return rates

    def _watched(self, drive: Drive, interval: Interval, after: Array, barred: Mask) -> list[Watch]:
        now, n, known = self.now, self.plant.n, dict[float, Array]()

        def push(s: float) -> Array:
            if s not in known:
                y = interval.later(s)
                dq = y[n : 2 * n]
                known[s] = self._push(y[:n], dq, self._torque(drive, interval.t + s, y) - now.law(dq))
            return known[s]

        watched = giving_way(now, interval, barred, push) if now.anybody_rests else []
        if not now.everybody_rests:
            watched += passing(now, interval, after) + coming_to_rest(now, interval, after)
        return watched

    def _at(self, what: Happening, interval: Interval, after: float) -> Array:
        """The state at an event, the joint exactly where it stopped, and others that stop in the same instant too."""
        plant, n, sides = self.plant, self.plant.n, self.now.sides
        y = interval.later(after).copy()
        y[:n] = np.clip(y[:n], plant.lower, plant.upper)
        dq = y[n : 2 * n]
        if what.kind == "stop":
            y[what.joint] = (plant.upper if what.side > 0 else plant.lower)[what.joint]
            if after == 0.0:  # it left by less than a float can show: it has not left
                dq[what.joint] = 0.0
        if what.kind == "rest":
            rate = sides * interval.rates(interval.t + after, y)[n : 2 * n]
            dq[(sides != 0) & (rate < 0.0) & (sides * dq <= -TIE * rate)] = 0.0
            dq[what.joint] = 0.0
        return y


def _told(t: float, joint: int, old: int, new: int, at_stop: bool) -> Event:
    """A change of side as an event."""
    if new == 0:
        return Event(t, "stick", joint)
    if old == 0:
        return Event(t, "release" if at_stop else "slip", joint, float(new))
    return Event(t, "reverse", joint, float(new))
