"""Consistent against plain least squares over random plants: what each misses on motions that no log has."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.consistent import consistent_fit
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from tests.identification.plants import COULOMB, VISCOUS, Motion, perturbed_plant, random_motion, rms, simulated_samples

LEVELS = (0.1, 0.2, 0.3)
"""How far plants are from their table, in turn."""
FRESH, FRESH_SECONDS, FRESH_RATE = 6, 10.0, 20.0
SLOWEST = 0.05
"""[rad/s], in the log only"""


class Case(NamedTuple):
    """One plant: torque errors of both fits on fresh motions, and whether every link can be a body."""

    gain: float
    """Error of least squares over that of the consistent fit."""
    physical: bool
    seconds: float
    """Processor time of the consistent fit, with its search for the weight."""
    tensor: float
    """The scale of tensors that was found."""


def table_of(arm: Arm, columns: TorqueColumns, friction: bool) -> Array:
    """The arm's table (p,), with the friction about which plants are drawn or with none."""
    table = columns.own(arm)
    for j in range(arm.n if friction else 0):
        table[columns.of_joint(j)][1:3] = COULOMB[j], VISCOUS[j]
    return table


def cases(seconds: float, noise: float, seeds: range, series: float | None = None, friction: bool = True) -> list[Case]:
    """Random logs of the LWR 4+ (exact states, noisy torques at 100 Hz), a plant a seed.

    A log is a whole series of five harmonics, or `seconds` cut out of one of `series` seconds. The table has friction
    (plants' is 30 % off it) or none.
    """
    arm = lwr_dyn.load("lwr4plus", "physical")
    columns = TorqueColumns(arm.chain)
    base, table = columns.base(), table_of(arm, columns, friction)
    rng = np.random.default_rng(7)
    fresh = [random_motion(arm, FRESH_SECONDS, rng, FRESH_RATE) for _ in range(FRESH)]
    W = np.concatenate([columns(m.q, m.dq, m.ddq)[:, :, base.kept].reshape(-1, base.count) for m in fresh])
    found = []
    for seed in seeds:
        rng = np.random.default_rng([seed, round(10 * seconds)])
        plant = perturbed_plant(columns, arm, rng, LEVELS[seed % len(LEVELS)])
        motion = random_motion(arm, series or seconds, rng)
        if series is not None:
            motion = _cut(motion, seconds, rng)
        information = information_of(simulated_samples(plant, motion, noise, rng, SLOWEST), columns)
        start = time.process_time()
        fit = consistent_fit(information, table)
        spent = time.process_time() - start
        plain, near = (rms(W @ (values - plant.base)) for values in (information.values, base.of(fit.parameters)))
        found.append(Case(plain / near, bool(fit.physical.all()), spent, fit.scales.tensor))
    return found


def _cut(motion: Motion, seconds: float, rng: np.random.Generator) -> Motion:
    rows = round(seconds / (motion.t[1] - motion.t[0])) + 1
    first = int(rng.integers(0, len(motion.t) - rows + 1))
    part = slice(first, first + rows)
    return Motion(motion.t[part] - motion.t[first], motion.q[part], motion.dq[part], motion.ddq[part])


def summary(found: list[Case]) -> tuple[float, float, Array]:
    """Median gain, share of plants in which the consistent fit is worse, scales of tensors."""
    gains = np.array([case.gain for case in found])
    return float(np.median(gains)), float(np.mean(gains < 1.0)), np.array([case.tensor for case in found])
