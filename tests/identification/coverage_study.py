"""Many fits of logs with a known truth: how often sigma holds it, and what is left of torques on unseen motions."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import Information, information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.stribeck import stribeck_search
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from tests.identification.plants import Motion, Plant, perturbed_plant, random_motion, rms, simulated_log

NOISE, ENCODER = 0.1, 1e-5
"""[N m], [rad] at 1 kHz"""
SLOWEST = 0.05
"""[rad/s]"""
STRIBECK = 0.05
"""v_s of every joint [rad/s]; the drop is 30 % of Coulomb friction."""
SECONDS = 10.0


def coverage_study(
    arm: Arm, draws: Iterable[int], rule: SampleRule = SampleRule(slowest=SLOWEST)  # noqa: B008
) -> tuple[Array, Array]:  # fmt: skip
    """Fits of one plant and one motion, its noise drawn anew for every seed.

    Misses in standard errors, (draws, b), and chi^2 about the truth over the number of parameters, (draws,).
    """
    rng = np.random.default_rng(1)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng)
    motion, z, chi2 = random_motion(arm, SECONDS, rng, 1000.0), [], []
    tau = plant.torque(motion)
    for seed in draws:
        log = simulated_log(plant, motion, NOISE, np.random.default_rng([seed, 28]), ENCODER, tau=tau)
        fit = information_of(samples_of([log], rule), plant.columns)
        away = fit.values - plant.base
        z.append(away / fit.sigma)
        chi2.append(away @ fit.precision @ away / away.size)
    return np.array(z), np.array(chi2)


def fresh_motions(arm: Arm) -> list[Motion]:
    """Six random motions inside the limits, the same every time."""
    return [random_motion(arm, SECONDS, np.random.default_rng([9, i]), 50.0) for i in range(6)]


def torque_error(plant: Plant, information: Information, motions: Iterable[Motion], slowest: float = 0.0) -> float:
    """RMS over joints and instants, where a joint is faster than `slowest` [rad/s], of what the fit misses [N m]."""
    misses: list[Array] = []
    for motion in motions:
        Y = information.columns(motion.q, motion.dq, motion.ddq)[:, :, information.base.kept]
        misses.append((Y @ information.values - plant.torque(motion))[np.abs(motion.dq) > slowest])
    return rms(np.concatenate(misses))


def predicted_error(information: Information, motions: Iterable[Motion]) -> float:
    """What the covariance of a fit says of that error [N m]: sqrt of the mean of diag(Y C Y^T)."""
    variances = []
    for motion in motions:
        Y = information.columns(motion.q, motion.dq, motion.ddq)[:, :, information.base.kept]
        variances.append(np.einsum("kjb,bc,kjc->kj", Y, information.covariance, Y, optimize=True))
    return float(np.sqrt(np.mean(variances)))


def fresh_errors(arm: Arm, motion: Motion, plants: Iterable[int]) -> Array:
    """Torque errors over the noise (plants, 3), fitted to logs of one motion at 1 kHz.

    Friction without a Stribeck drop, all speeds; with one and without its column, fitted and judged beyond three v_s;
    with one and its column found by search, all speeds.
    """
    fresh, smooth, steep = fresh_motions(arm), TorqueColumns(arm.chain), np.full(arm.n, STRIBECK)
    rows, beyond = [], 3.0 * STRIBECK
    for seed in plants:
        rng = np.random.default_rng([seed, 1])
        one = perturbed_plant(smooth, arm, rng)
        plain = information_of(samples_of([simulated_log(one, motion, NOISE, rng, ENCODER)]), smooth)
        two = perturbed_plant(TorqueColumns(arm.chain, "symmetric", steep), arm, rng)
        log = simulated_log(two, motion, NOISE, rng, ENCODER)
        outside = information_of(samples_of([log], SampleRule(slowest=beyond)), smooth)
        column = stribeck_search(samples_of([log], SampleRule(slowest=0.01)), smooth).information
        rows.append([
            torque_error(one, plain, fresh), torque_error(two, outside, fresh, beyond), torque_error(two, column, fresh)
        ])  # fmt: skip
    return np.array(rows) / NOISE
