"""The usual step of a sampled run, in which nothing happens: written for speed, and refused where something does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.simulation.events import TURN
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.integrators import held_rk4
from lwr_dyn.simulation.log import Log
from lwr_dyn.simulation.stick_flow import StickFlow
from lwr_dyn.simulation.stick_step import StickStep

Quick = Callable[[int, Array, Array, Array], bool]
"""(k, state at sample k, torque held, state after it) -> whether the step meets nothing and is good."""


def quick_step(flow: Flow | StickFlow, log: Log, h: float, substeps: int) -> Quick:
    """The step of `h` [s] in RK4 substeps for a plant without friction or with set-valued friction."""
    return _sticking(flow, log, h, substeps) if isinstance(flow, StickFlow) else _smooth(flow, h, substeps)


def _smooth(flow: Flow, h: float, substeps: int) -> Quick:
    """Steps without friction.

    One comparison of the new state with its bounds finds a limit that is passed, a speed that cannot be followed and
    a NaN.
    """
    plant, n = flow.plant, flow.plant.n
    step, more = held_rk4(plant.raw.forward_dynamics, n, h / substeps), range(substeps - 1)
    cap = np.full(n, TURN / h)
    ceiling, floor = np.array([plant.upper, cap]), np.array([plant.lower, -cap])
    inside = np.zeros((2, 2, n), dtype=bool)
    below, above = inside
    all_inside = np.ones_like(inside).tobytes()
    less_equal, greater_equal = np.less_equal, np.greater_equal

    def quick(k: int, now: Array, applied: Array, after: Array) -> bool:
        step(now, applied, after)
        for _ in more:
            step(after, applied, after)
        flow.evaluations += 4 * substeps
        less_equal(after, ceiling, out=below)
        greater_equal(after, floor, out=above)
        return inside.tobytes() == all_inside

    return quick


def _sticking(flow: StickFlow, log: Log, h: float, substeps: int) -> Quick:
    """Steps with set-valued friction in which nobody starts or stops."""
    step = StickStep(flow, h, substeps)
    friction, work = log.friction, log.friction_work

    def quick(k: int, now: Array, applied: Array, after: Array) -> bool:
        if not step.take(now, applied, after):
            return False
        work[k + 1] = step.work
        if friction is not None:
            friction[k] = step.friction
        return True

    return quick
