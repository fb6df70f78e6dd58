"""Many fits of logs with a known truth: how often intervals of 3 sigma hold it, and whether a parameter leans."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from tests.identification.plants import Motion, Plant, perturbed_plant, random_motion, simulated_log

ENCODER = 1e-5
"""White noise of the positions [rad], at 1 kHz."""
NOISE = 0.1
"""Of the torques [N m]."""
SECONDS, RATE = 10.0, 1000.0
MOTION_SEED = 1
SLOWEST = 0.05
"""[rad/s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """Misses in standard errors, (draws, b), and chi^2 about the truth over the number of parameters, (draws,)."""

    misses: Array
    chi2: Array

    @property
    def share(self) -> float:
        """Of all intervals of 3 sigma, how many hold the truth."""
        return float(np.mean(np.abs(self.misses) <= 3.0))

    @property
    def bias(self) -> Array:
        """Mean miss of every parameter [sigma], (b,); its own noise is 1 / sqrt(draws)."""
        return np.asarray(self.misses.mean(axis=0))


def coverage_study(
    arm: Arm, draws: Iterable[int], rule: SampleRule | None = None, encoder: float = ENCODER, noise: float = NOISE
) -> Coverage:
    """Fits of one plant and one motion, its noise drawn anew for every seed: standard deviations [rad, N m].

    Without a rule samples are at 20 Hz, every 10 ms, above `SLOWEST`.
    """
    plant, motion = case(arm)
    tau = plant.torque(motion)
    chosen = rule or SampleRule(slowest=SLOWEST)
    fits = []
    for seed in draws:
        log = simulated_log(plant, motion, noise, np.random.default_rng([seed, 28]), encoder, tau=tau)
        fits.append(information_of(samples_of([log], chosen), plant.columns))
    away = np.array([fit.values - plant.base for fit in fits])
    chi2 = np.array([a @ fit.precision @ a for a, fit in zip(away, fits, strict=True)]) / away.shape[1]
    return Coverage(away / np.array([fit.sigma for fit in fits]), chi2)


def case(arm: Arm) -> tuple[Plant, Motion]:
    """The plant and its motion."""
    rng = np.random.default_rng(MOTION_SEED)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng)
    return plant, random_motion(arm, SECONDS, rng, RATE)
