"""What may end a regime of sticking and slipping joints within an interval, as functions that turn positive then."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from lwr_dyn.arrays import Array
from lwr_dyn.simulation.events import PUSH, Interval
from lwr_dyn.simulation.stick import Regime
from lwr_dyn.simulation.stops import Mask


@dataclass(frozen=True, slots=True)
class Happening:
    """Joint `joint` gives way ("slip") or meets its stop ("stop") at `side`, or comes to rest ("rest", side 0)."""

    kind: str
    joint: int
    side: int


@dataclass(frozen=True, slots=True)
class Watch:
    """A happening; its function of the time since the start [s] is positive at `until` if it has come by then."""

    f: Callable[[float], float]
    until: float
    what: Happening


def passing(now: Regime, interval: Interval, after: Array) -> list[Watch]:
    """Joints beyond a position limit at the end of the interval."""
    plant = now.plant
    n, out = plant.n, []
    for j in np.flatnonzero(plant.beyond(after[:n]) & ~now.resting):
        side = 1 if after[j] > plant.upper[j] else -1
        limit = float((plant.upper if side > 0 else plant.lower)[j])
        out.append(Watch(_beyond(interval, int(j), side, limit), interval.h, Happening("stop", int(j), side)))
    return out


def coming_to_rest(now: Regime, interval: Interval, after: Array) -> list[Watch]:
    """Joints whose speed is against their side at the end of the interval, or was so within it.

    The latter were braked so much at first that their speed might pass zero, yet move on at the end.
    """
    n, sides, h = now.plant.n, now.sides, interval.h
    speed, at_end = sides * interval.y[n : 2 * n], sides * after[n : 2 * n]
    out = []
    for j in np.flatnonzero((sides != 0) & (at_end < 0.0)):
        f = _beyond(interval, n + int(j), -int(sides[j]), 0.0)
        out.append(Watch(f, h, Happening("rest", int(j), 0)))
    braked = speed + h * sides * interval.rates(interval.t, interval.y)[n : 2 * n] < 0.0
    for j in np.flatnonzero((speed > 0.0) & braked & (at_end > 0.0)):
        f = _beyond(interval, n + int(j), -int(sides[j]), 0.0)
        slowest = minimize_scalar(lambda s, f=f: -f(s), bounds=(0.0, h), method="bounded").x
        out.append(Watch(f, float(slowest), Happening("rest", int(j), 0)))
    return out


def giving_way(now: Regime, interval: Interval, barred: Mask, push: Callable[[float], Array]) -> list[Watch]:
    """Joints at rest that would need more than can resist them at the end of the interval; `barred` ones excepted.

    `push` (n,) is what has to resist them at a time since the start. An excess that comes and goes is not seen.
    """
    last = push(interval.h)
    high, low = last > now.highest + PUSH, last < now.lowest - PUSH
    out = []
    for j in np.flatnonzero(now.resting & ~barred & (high | low)):
        side = 1 if high[j] else -1
        bound = float(now.highest[j] if side > 0 else now.lowest[j])

        def excess(s: float, j: int = int(j), side: int = side, bound: float = bound) -> float:
            return float(side * (push(s)[j] - bound)) - PUSH

        out.append(Watch(excess, interval.h, Happening("slip", int(j), side)))
    return out


def _beyond(interval: Interval, index: int, side: int, limit: float) -> Callable[[float], float]:
    """How far entry `index` of the state is beyond a limit."""
    return lambda s: float(side * (interval.later(s)[index] - limit))
