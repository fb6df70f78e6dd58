"""How many RK4 steps a sample smooth friction needs: the error of the step, estimated by runs with twice as many.

Away from rest, RK4's error falls with h^4; where a joint turns round, tanh bends within a step or two, and the order
seen is about 3. The difference of two runs is taken as it is: extrapolation would promise more than it keeps.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from lwr_dyn.codegen.rollouts.kernel import rollout_kernel
from lwr_dyn.codegen.rollouts.kernel_task import plan_of, task_of
from lwr_dyn.codegen.rollouts.law_forms import LawForm
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup, check_smooth_friction
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.setup import MOST_SUBSTEPS, STABLE
from lwr_dyn.simulation.substeps import MOST, doubled, power_of_two

ENOUGH = 1e-6
"""[rad or m] Of a joint's position: the error that may be left."""

RUNS = 64
"""That an estimate looks at, evenly over all."""

SAMPLES = 500

Positions = Callable[[int], Array]
"""Substeps -> positions (runs, samples, n) of the same runs at the same samples; NaN for runs that are left out."""


@dataclass(frozen=True, slots=True)
class Steps:
    """Substeps of a sample, and what twice as many change in a joint's position at most [rad or m]."""

    substeps: int
    error: float

    @property
    def are_enough(self) -> bool:
        """Whether the error is below 1e-6."""
        return self.error < ENOUGH


def steps(positions: Positions, substeps: int) -> Steps:
    """Substeps with their error; NaN where no run is left to compare."""
    away = np.abs(positions(substeps) - positions(2 * substeps)).max(axis=(1, 2))
    seen = away[np.isfinite(away)]
    return Steps(substeps, float(seen.max()) if seen.size else np.nan)


def enough_steps(positions: Positions, first: int) -> Steps:
    """The fewest substeps from `first` on whose error is below 1e-6, or the best that were found (see `doubled`)."""
    known = cache(positions)
    return Steps(*doubled(lambda substeps: steps(known, substeps).error, first, ENOUGH))


def chosen_steps(setup: LoopSetup, form: LawForm, given: Mapping[str, Array], count: int) -> Steps:
    """The substeps for a loop with smooth friction, from 1 on, or from where friction comes to rest.

    Parameters
    ----------
    setup, form
        The loop, whose own substeps are not looked at, and the law.
    given : mapping
        As `run_parameters` gives it, for `count` runs.

    Raises
    ------
    OptionError
        Friction needs more than 64 to come to rest.
    """
    rate = check_smooth_friction(with_substeps(setup, MOST_SUBSTEPS), given)
    least = min(power_of_two(rate / setup.loop.rate / STABLE), MOST)
    check_smooth_friction(with_substeps(setup, least), given)
    chosen = evenly(count)
    rows = {name: np.ascontiguousarray(array[chosen]) for name, array in given.items()}
    return enough_steps(lambda k: _positions(with_substeps(setup, k), form, rows, chosen.size), least)


def evenly(count: int) -> Array:
    """Numbers of up to 64 runs of so many.

    >>> evenly(3), evenly(1000)[[0, 1, -1]]
    (array([0, 1, 2]), array([  0,  15, 999]))
    """
    return np.unique(np.linspace(0, count - 1, min(count, RUNS)).astype(int))


def stride_of(samples: int) -> int:
    """Every how many samples positions are compared, so that there are 500 to 999, or all of fewer."""
    return max(1, samples // SAMPLES)


def with_substeps(setup: LoopSetup, substeps: int) -> LoopSetup:
    """The same loop with so many steps of RK4 a sample."""
    return replace(setup, loop=replace(setup.loop, substeps=substeps))


def _positions(setup: LoopSetup, form: LawForm, given: Mapping[str, Array], count: int) -> Array:
    """Positions by a kernel with true readings: an encoder's counts would hide the step's error behind their own."""
    exact = {name: np.zeros_like(given[name]) for name in ("resolution", "noise") if name in given}
    encoder = setup.loop.encoder
    if encoder is not None:
        encoder = replace(encoder, resolution=0.0, noise=0.0)
    own = replace(setup, loop=replace(setup.loop, encoder=encoder))
    rows = {**given, **exact}
    plan = plan_of(own, form, rows)
    kernel = rollout_kernel(plan)
    task = task_of(own, plan, kernel, rows, count, None, (), stride_of(setup.samples), 0)
    record = kernel.run(task).record
    assert record is not None  # a stride was given
    return record[:, :, : setup.plant.n]
