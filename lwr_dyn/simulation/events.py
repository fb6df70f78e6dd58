"""What may end a contact mode within an interval, as functions of time, and the search for the first that comes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.arm_friction import Mask
from lwr_dyn.simulation.contact import ContactMode
from lwr_dyn.simulation.integrators import Integrator, Rates

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
