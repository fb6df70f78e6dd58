"""Finding what happens first within an interval: a joint that passes a limit, a held joint that is let go."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from lwr_dyn.arrays import Array
from lwr_dyn.simulation.integrators import Integrator, Rates
from lwr_dyn.simulation.plant import Plant
from lwr_dyn.simulation.stops import Mask, constrained

TURN = 2 * np.pi
"""[rad or m] a step: a joint that makes a whole turn between two samples cannot be followed."""
TIME = 1e-15
"""[s] to which the moment of an event is found."""
PUSH = 1e-12
"""[N m] by which a stop would have to pull before its joint counts as let go."""
HALVINGS = 30
"""How far the search for the first moment off a limit goes back."""


def followable(y: Array, n: int, h: float) -> bool:
    """Whether a state (q, dq, ...) is finite and no joint makes a whole turn in an interval of h [s]."""
    return bool(np.isfinite(y).all() and (np.abs(y[n : 2 * n]) <= TURN / h).all())


@dataclass(frozen=True, slots=True)
class Found:
    """First event of an interval: when after its start [s], which joint, the side of the stop met (0: a release)."""

    after: float
    joint: int
    side: float


@dataclass(frozen=True, slots=True, eq=False)
class Interval:
    """The smooth motion from state y at t over h [s], as if no event came; it can be asked at any moment in between."""

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


def first_event(
    plant: Plant, net_torque: Callable[[float, Array], Array], interval: Interval, held: Mask, forced: Mask
) -> Found | None:
    """The first joint that passes a limit or, held and not `forced`, would be pulled by its stop; None if nothing does.

    A limit that is passed and left again within the interval is not seen.
    """
    n, after = plant.n, interval.later(interval.h)

    def passed(joint: int, side: float) -> Callable[[float], float]:
        limit = (plant.upper if side > 0 else plant.lower)[joint]
        return lambda s: float(side * (interval.later(s)[joint] - limit))

    def pulled(joint: int, side: float) -> Callable[[float], float]:
        def pull(s: float) -> float:
            y = interval.later(s)
            tau = net_torque(interval.t + s, y)
            return float(side * constrained(plant, y[:n], y[n : 2 * n], tau, held)[1][joint]) - PUSH

        return pull

    beyond = np.flatnonzero(plant.beyond(after[:n]) & ~held)
    watched = [(passed(j, side), j, side) for j, side in _sides(plant, after, beyond)]
    watched += [(pulled(j, side), j, 0.0) for j, side in _sides(plant, interval.y, np.flatnonzero(held & ~forced))]
    first = earliest((f, interval.h) for f, _, _ in watched)
    return None if first is None else Found(first.after, *watched[first.index][1:])


@dataclass(frozen=True, slots=True)
class First:
    """Which of several comes first, and when [s]."""

    after: float
    index: int


def earliest(watched: Iterable[tuple[Callable[[float], float], float]]) -> First | None:
    """Of functions f, each positive at its time `until` once what it watches has happened: the first to turn so."""
    first: First | None = None
    for index, (f, latest) in enumerate(watched):
        until = latest if first is None else min(latest, first.after)
        if f(until) > 0.0:
            first = First(crossing(f, until), index)
    return first


def _sides(plant: Plant, y: Array, joints: NDArray[np.intp]) -> list[tuple[int, float]]:
    side = plant.at_limit(y[: plant.n])
    return [(int(j), float(side[j])) for j in joints]


def crossing(f: Callable[[float], float], h: float) -> float:
    """Where f turns positive in [0, h], f(h) > 0; a start that is not negative is left by halving, or is the answer.

    >>> crossing(lambda s: s * s - 0.25, 1.0)
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
