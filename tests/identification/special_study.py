"""Fits of special logs with a known truth: misses over their standard errors, over draws of noise and motions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.elastic_joints import identify_elastic
from lwr_dyn.identification.payload.identify_load import identify_load
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.instrumental import UNFILTERED, instrumental
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion
from tests.identification.elastic_plants import elastic_log, elastic_truth
from tests.identification.logs import test_motor_side as motors
from tests.identification.payload import loaded as payload
from tests.identification.plants import inside, perturbed_plant, random_motion, simulated_log

PER_MOTION = 10
"""Draws of noise on one plant and motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Misses:
    """z (draws, p): misses over standard errors, a row a fit; PER_MOTION rows share plant and motion."""

    z: Array

    @property
    def inside(self) -> float:
        """Share within 3 sigma; 99.73 % for errors that are right."""
        return inside(self.z)

    @property
    def bias(self) -> float:
        """RMS bias in sigma, beyond what the draws of one motion show by chance."""
        means = self.z.reshape(-1, PER_MOTION, self.z.shape[1]).mean(axis=1)
        return float(np.sqrt(max(np.mean(means**2) - np.mean(self.z**2) / PER_MOTION, 0.0)))

    def __str__(self) -> str:
        return f"{self.inside:.2%} within 3 sigma, mean square {np.mean(self.z**2):.2f}, bias {self.bias:.2f} sigma"


def instrumental_misses(motions: Iterable[int], plain: bool = False) -> Misses:
    """LWR, 10 s, 1 kHz, 1e-5 rad, 0.1 N m, no filter; `plain`: least squares on every tenth row of the same."""
    arm, out = payload.ARM, []
    for seed in motions:
        rng = np.random.default_rng(seed)
        plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.2)
        motion = random_motion(arm, 10.0, rng, rate=1000.0)
        tau = plant.torque(motion)
        for _ in range(PER_MOTION):
            log = simulated_log(plant, motion, 0.1, rng, 1e-5, tau=tau)
            if plain:
                found = information_of(samples_of([log], SampleRule(cutoff=None)), plant.columns)
            else:
                samples = samples_of([log], UNFILTERED)
                rows = np.searchsorted(motion.t, samples.t - 1e-6)
                known = Motion(samples.t, motion.q[rows], motion.dq[rows], motion.ddq[rows])
                found = instrumental(samples, plant.columns, known)
            out.append((found.values - plant.base) / found.sigma)
    return Misses(np.array(out))


def motor_misses(motions: Iterable[int]) -> Misses:
    """WAM, 20 s, 1 kHz: motors' encoders 1e-4 rad, shafts 2 mN m, friction and rotors at coupled motors."""
    out = []
    plant = motors.motor_plant()
    for seed in motions:
        rng = np.random.default_rng(seed)
        motion = random_motion(motors.ARM, 20.0, rng, rate=1000.0)
        for _ in range(PER_MOTION):
            log = motors.log_at_joints(motors.motor_log(plant, motion, 0.002, 1e-4, rng), motors.MOTORS)
            found = information_of(samples_of([log], motors.RULE), plant.columns)
            out.append((found.values - plant.base) / found.sigma)
    return Misses(np.array(out))


def load_misses(motions: Iterable[int]) -> Misses:
    """A load of 2.5 kg on the LWR, 10 s, 1 kHz, 1e-5 rad, 0.1 N m, friction fitted beside it."""
    columns, out = TorqueColumns(payload.ARM.chain), []
    for seed in motions:
        rng = np.random.default_rng(seed)
        plant = payload.loaded(perturbed_plant(columns, payload.ARM, rng, 0.0))
        motion = random_motion(payload.ARM, 10.0, rng, rate=1000.0)
        tau = plant.torque(motion)
        for _ in range(PER_MOTION):
            found = identify_load([simulated_log(plant, motion, 0.1, rng, 1e-5, tau=tau)], payload.ARM)
            out.append((found.parameters - payload.TRUTH) / found.sigma)
    return Misses(np.array(out))


def elastic_misses(motions: Iterable[int]) -> tuple[Misses, Array]:
    """LWR, both encoders 1e-5 rad, 0.1 N m, 20 s at 1 kHz; beside z the relative misses of stiffness (draws, n)."""
    arm, out, off = payload.ARM, [], []
    for seed in motions:
        rng = np.random.default_rng(seed)
        plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.2)
        clean = elastic_log(plant, arm.elasticity, random_motion(arm, 20.0, rng, rate=1000.0), 0.0, rng)
        for _ in range(PER_MOTION):
            sizes = {"q": 1e-5, "tau": 0.1, "motor_q": 1e-5}
            noisy = {name: (x := getattr(clean, name)) + rng.normal(0.0, s, x.shape) for name, s in sizes.items()}
            found = identify_elastic([replace(clean, **noisy)], arm)
            out.append((found.values - elastic_truth(plant, arm.elasticity, found.base)) / found.sigma)
            off.append(found.of("stiffness") / arm.elasticity.stiffness - 1.0)
    return Misses(np.array(out)), np.array(off)
