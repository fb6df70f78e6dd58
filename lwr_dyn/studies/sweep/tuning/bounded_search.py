"""A search for gains: differential evolution of SciPy, a whole generation at once, under one bound.

Differential evolution is taken because it only compares candidates (a quantile over runs has kinks, a loop that turns
unstable is a cliff), because a generation is one call, which rollouts want, and because it is in SciPy: `cma` would be
one more package, and pays from some ten gains on. All candidates meet the same runs (common random numbers), so that a
difference between two of them is one of gains; the price is that the search fits its runs, so gains are judged on other
ones (`gain_verdict`).

The bound is kept by order, without a penalty to choose: of two candidates that keep it the one with the smaller aim is
better, one that keeps it is better than one that does not, and of two that do not the one that misses it by less
(K. Deb, Comput. Methods Appl. Mech. Eng. 186, 2000).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution
from scipy.stats import qmc

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.progress import Report

MISSED = 1e12
"""Cost from which on candidates miss the bound; an aim is far below."""
MOST_MISSED = 1e6
"""By how much a candidate misses it at most."""
NO_NUMBER = 1e30
"""Cost of a candidate with runs that have no number."""
MUTATION, CROSSOVER = (0.5, 1.0), 0.9
"""Dithered scale of differences, and the share of numbers that a child takes from them: SciPy's default for the first;
high for the second, as gains act together."""

Judge = Callable[[Array], tuple[Array, Array]]
"""Points (k, d) of the unit cube -> aim (k,) and use (k,), inf where a candidate has none."""
Mask = NDArray[np.bool_]


@dataclass(slots=True, eq=False)
class SearchTrace:
    """All candidates that were looked at: points (k, d) of the unit cube, aim (k,), and use (k,), which is bounded."""

    judge: Judge
    points: Array
    aim: Array = field(default_factory=lambda: np.zeros(0))
    use: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def empty(cls, judge: Judge, dimensions: int) -> "SearchTrace":
        """Nothing was looked at yet."""
        return cls(judge, np.zeros((0, dimensions)))

    def look(self, points: Array) -> tuple[Array, Array]:
        """Aim and use of points (k, d), which are kept."""
        aim, use = self.judge(points)
        self.points = np.concatenate([self.points, points])
        self.aim, self.use = np.concatenate([self.aim, aim]), np.concatenate([self.use, use])
        return aim, use

    def best(self, bound: float) -> int:
        """The candidate that is best under a bound on use; the first of equals."""
        return int(np.argmin(costs(self.aim, self.use, bound)))

    @property
    def front(self) -> NDArray[np.int64]:
        """The Pareto front: the candidates than which none is better in one and no worse in the other; by use."""
        kept: list[int] = []
        for i in np.lexsort((self.aim, self.use)):
            if np.isfinite([self.aim[i], self.use[i]]).all() and (not kept or self.aim[i] < self.aim[kept[-1]]):
                kept.append(int(i))
        return np.array(kept, dtype=np.int64)


def costs(aim: Array, use: Array, bound: float) -> Array:
    """One number a candidate (k,), smaller for the better; candidates that miss the bound come behind all others.

    >>> order = np.argsort(costs(np.array([3.0, 1.0, 2.0, np.inf]), np.array([0.5, 0.9, 0.7, 0.1]), 0.8))
    >>> order.tolist()
    [2, 0, 1, 3]
    """
    inside = np.where(np.isfinite(aim), aim, NO_NUMBER)
    if not np.isfinite(bound):
        return inside
    missing = np.minimum(np.where(np.isnan(use), np.inf, use) - bound, MOST_MISSED)
    return np.where(missing > 0.0, MISSED * (1.0 + missing), inside)


def search(
    trace: SearchTrace,
    start: Sequence[Array],
    bound: float,
    *,
    population: int,
    generations: int,
    seed: int,
    report: Report = lambda _: None,
) -> int:
    """Differential evolution from `start` (points, each (d,)) and a Latin hypercube, under `bound` on the use.

    Every candidate goes into `trace`; the number of the best one there is returned, which an earlier search may have
    found. The same for a seed.

    Parameters
    ----------
    trace : SearchTrace
    start : sequence of (d,) arrays
        Candidates of the first generation, at most `population`.
    bound : float
        inf for none.
    population, generations : int
        Candidates of a generation, and generations after the first; it ends before when all candidates agree to 1 %.
    seed : int

    Raises as the judge.
    """
    d = trace.points.shape[1]
    rng = np.random.default_rng(seed)
    cube = qmc.LatinHypercube(d, seed=rng).random(population)
    cube[: len(start)] = np.reshape(start, (len(start), d))
    done = 0

    def cost(x: Any, /) -> Any:  # the stubs know of one candidate at a time only
        nonlocal done
        aim, use = trace.look(np.ascontiguousarray(x.T))
        done += 1
        report(min(done / (generations + 1), 1.0))
        return costs(aim, use, bound)

    try:
        differential_evolution(
            cost, Bounds(np.zeros(d), np.ones(d)), init=cube, maxiter=generations, mutation=MUTATION,
            recombination=CROSSOVER, seed=rng, polish=False, updating="deferred", vectorized=True,
        )  # fmt: skip
    except RuntimeError as fault:  # SciPy makes one of every ValueError
        if isinstance(fault.__cause__, LwrDynError):
            raise fault.__cause__ from None
        raise
    return trace.best(bound)
