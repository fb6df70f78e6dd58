"""How many RK4 steps a sample a run needs: as many that twice as many change its tip by less than 1e-6 m.

A run with twice the steps takes twice the time, so first a bound is looked at: at intervals of the run, what one
interval with twice the steps changes, as if it were the same in all of them and nothing brought the arm back. Only
where this bound is 1e-6 m or more, runs with more steps are made and compared.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import ceil, log2

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import flange_pose, jacobian
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.audit import Intervals, uneventful
from lwr_dyn.simulation.integrators import Integrator, rk4
from lwr_dyn.simulation.setup import STABLE, Setup

ENOUGH = 1e-6
"""[m] Of the tip."""

MOST = 64
"""Steps that are chosen at most."""

INTERVALS, SAMPLES = 100, 1000
"""Of a run, evenly spread, that the bound and the comparison look at."""

SPARE = 1.5
"""Factor on the steps that friction needs where a run begins, since the mass matrix changes."""


def power_of_two(need: float) -> int:
    """The least power of two from `need` on, 1 at least.

    >>> power_of_two(0.3), power_of_two(2.0), power_of_two(2.1)
    (1, 2, 4)
    """
    return int(2 ** ceil(log2(max(need, 1.0))))


def doubled(change: Callable[[int], float], first: int, enough: float) -> tuple[int, float]:
    """The fewest substeps (`first`, twice, four times, ... up to 64) that twice as many change by less than `enough`.

    Doubling ends before, where it no longer halves the change: a loop that amplifies differences is not computed better
    by smaller steps.

    Parameters
    ----------
    change : callable
        Substeps -> what twice as many change.
    first : int
        Where the search begins.
    """
    substeps, found = first, change(first)
    while found >= enough and substeps < MOST:
        finer = change(2 * substeps)
        if finer > found / 2:
            break
        substeps, found = 2 * substeps, finer
    return substeps, found


@dataclass(frozen=True, slots=True, eq=False)
class SteppedRun:
    """A run, its steps a sample, and what twice as many change at the tip [m]: an upper bound where `is_bound`."""

    run: Run
    substeps: int
    change: float
    is_bound: bool

    @property
    def words(self) -> str:
        """What was chosen and why; empty where one step is enough by its bound."""
        if self.is_bound and self.substeps == 1:
            return ""
        if self.is_bound:
            least = f"twice as many change the tip by {self.change:.1g} m at most"
            return f"substeps: {self.substeps}, chosen for this run: its friction needs them; {least}"
        enough = "" if self.change < ENOUGH else ", and more steps do not leave less"
        changed = f"twice as many change the tip by {self.change:.1g} m"
        return f"substeps: {self.substeps}, chosen for this run: {changed}{enough}"


def applies(setup: Setup) -> bool:
    """Whether steps can be chosen: RK4, sampled, rigid joints."""
    loop = setup.loop
    return loop.method == "rk4" and not loop.continuous and setup.elasticity is None and loop.loop in (None, "rigid")


def friction_substeps(setup: Setup) -> int:
    """Steps a sample, a power of two, with which RK4 follows the friction of a setup; 1 without.

    Raises `OptionError` where it would need more than 64.
    """
    need = SPARE * setup.friction_rate / setup.loop.rate / STABLE
    if need > MOST:
        found = f"brakes at up to {setup.friction_rate:.4g} 1/s, which needs {ceil(need)} RK4 steps a sample"
        raise OptionError("friction", found, f"substeps from {ceil(need)} on, a higher rate, method dop853")
    return power_of_two(need)


def with_substeps(setup: Setup, substeps: int) -> Setup:
    """The same setup with so many steps of RK4 a sample."""
    return replace(setup, loop=replace(setup.loop, substeps=substeps))


def enough_steps(run: Run, again: Callable[[int], Run]) -> SteppedRun:
    """The run, or one with more steps until twice as many change its tip by less than 1e-6 m (see `doubled`).

    Parameters
    ----------
    run : Run
        As `run_setup` gives it, with its setup.
    again : callable
        Substeps -> the same run with so many.
    """
    substeps = run.setup.loop.substeps
    bound = change_bound(run)
    if bound < ENOUGH:  # not where it is NaN
        return SteppedRun(run, substeps, bound, True)
    made = cache(lambda steps: run if steps == substeps else again(steps))
    chosen, change = doubled(lambda steps: tip_change(made(steps), made(2 * steps)), substeps, ENOUGH)
    return SteppedRun(made(chosen), chosen, change, False)


def change_bound(run: Run) -> float:
    """What twice the steps change at the tip at most [m], as if all intervals were as the worst one that is looked at.

    Not a number where an interval cannot be followed; infinite where all have events.
    """
    plain = uneventful(run, False)
    if not plain.size:
        return np.inf
    rows = plain[np.unique(np.linspace(0, plain.size - 1, min(INTERVALS, plain.size)).astype(int))]
    steps = run.setup.loop.substeps
    try:
        judge = Intervals(run, rows, run.setup.plant.dynamics)
        with np.errstate(over="ignore", invalid="ignore"):
            position, speed = np.abs(_ends(judge, rk4(steps)) - _ends(judge, rk4(2 * steps)))
    except (ShapeError, np.linalg.LinAlgError):
        return np.nan
    lever = np.linalg.norm(jacobian(run.setup.plant.arm.chain, run.q[rows])[:, :3], axis=1)
    each = (lever * (position + float(run.t[-1]) * speed)).sum(axis=-1)
    return float(each.max() * (run.t.size - 1))


def tip_change(run: Run, other: Run) -> float:
    """The largest distance of the tips of two runs of one arm at the same samples [m]."""
    rows = np.unique(np.linspace(0, run.t.size - 1, min(SAMPLES, run.t.size)).astype(int))
    ours, theirs = (flange_pose(run.setup.plant.arm.chain, one.q[rows])[:, :3, 3] for one in (run, other))
    return float(np.linalg.norm(ours - theirs, axis=-1).max())


def _ends(judge: Intervals, method: Integrator) -> Array:
    """The states (2, k, n) after the intervals by a method."""
    shape = (2, *judge.q.shape)

    def rates(s: float, y: Array) -> Array:
        x, v = y.reshape(shape)
        return np.concatenate([judge.h * v, judge.h * judge.motion(x, v, s)[0]]).ravel()

    return np.asarray(method(rates, 0.0, np.concatenate([judge.q, judge.dq]).ravel(), 1.0)).reshape(shape)
