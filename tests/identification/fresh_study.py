"""Torques that a fit predicts on motions it has not seen, against those of the plant without noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import Information, information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.stribeck import stribeck_search
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from tests.identification.plants import Motion, Plant, perturbed_plant, random_motion, simulated_log

NOISE, ENCODER = 0.1, 1e-5
"""[N m], [rad] at 1 kHz"""
STRIBECK = 0.05
"""v_s of every joint [rad/s]; the drop is 30 % of Coulomb friction."""
FRESH, SECONDS = 6, 10.0


def fresh_motions(arm: Arm, count: int = FRESH) -> list[Motion]:
    """Random motions inside the limits, the same every time."""
    return [random_motion(arm, SECONDS, np.random.default_rng([9, i]), 50.0) for i in range(count)]


def torque_error(plant: Plant, information: Information, motions: Iterable[Motion], slowest: float = 0.0) -> float:
    """RMS over joints and instants, where a joint is faster than `slowest` [rad/s], of what the fit misses [N m]."""
    misses: list[Array] = []
    for motion in motions:
        Y = information.columns(motion.q, motion.dq, motion.ddq)[:, :, information.base.kept]
        misses.append((Y @ information.values - plant.torque(motion))[np.abs(motion.dq) > slowest])
    return float(np.sqrt(np.mean(np.square(np.concatenate(misses)))))


def predicted_error(information: Information, motions: Iterable[Motion]) -> float:
    """What the covariance of a fit says of that error [N m]: sqrt of the mean of diag(Y C Y^T)."""
    variances = []
    for motion in motions:
        Y = information.columns(motion.q, motion.dq, motion.ddq)[:, :, information.base.kept]
        variances.append(np.einsum("kjb,bc,kjc->kj", Y, information.covariance, Y, optimize=True))
    return float(np.sqrt(np.mean(variances)))


@dataclass(frozen=True, slots=True, eq=False)
class FreshErrors:
    """Torque errors over the noise, medians over plants."""

    plain: float
    """Friction without a Stribeck drop, all speeds."""
    worst: float
    """The largest of those over the plants."""
    outside: float
    """With a drop, no Stribeck column, fitted and judged beyond three v_s."""
    column: float
    """With a drop and the column found by search, all speeds."""


def fresh_errors(arm: Arm, motion: Motion, plants: Iterable[int]) -> FreshErrors:
    """Of plants by seed, fitted to logs of one motion at 1 kHz."""
    fresh, smooth, steep = fresh_motions(arm), TorqueColumns(arm.chain), np.full(arm.n, STRIBECK)
    rows = []
    for seed in plants:
        rng = np.random.default_rng([seed, 1])
        one = perturbed_plant(smooth, arm, rng)
        plain = information_of(samples_of([simulated_log(one, motion, NOISE, rng, ENCODER)]), smooth)
        two = perturbed_plant(TorqueColumns(arm.chain, "symmetric", steep), arm, rng)
        log = simulated_log(two, motion, NOISE, rng, ENCODER)
        beyond = 3.0 * STRIBECK
        outside = information_of(samples_of([log], SampleRule(slowest=beyond)), smooth)
        column = stribeck_search(samples_of([log], SampleRule(slowest=0.01)), smooth).information
        rows.append([
            torque_error(one, plain, fresh), torque_error(two, outside, fresh, beyond), torque_error(two, column, fresh)
        ])  # fmt: skip
    table = np.array(rows) / NOISE
    medians = np.median(table, axis=0).tolist()
    return FreshErrors(medians[0], float(table[:, 0].max()), medians[1], medians[2])
