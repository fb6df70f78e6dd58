"""One plant fitted, written, loaded and predicted: for the soak line `fitted_models` and the tests of its share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.fitted_files import write_fitted
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.identifiable import SECONDS, MissingMotion
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionIdentification
from lwr_dyn.identification.motion.validation import rms
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import friction_torque
from tests.identification.plants import Motion, Plant, perturbed_plant, random_motion, simulated_log


@dataclass(frozen=True, slots=True, eq=False)
class ModelCase:
    """Of one plant.

    `off`: largest torque between fit and file over the largest torque. RMS of all joints over the noise: `seen`,
    `unseen` (kept from the fit), `fresh` (another motion, by bodies). `promises`: sigma after the motion that was named
    first, over the sigma that it was to bring, both at the noise of the first log: what leaving out folds of the two
    together adds to the noise (a factor of 1.28 on the WAM) no log tells ahead.
    """

    off: float
    physical: bool
    seen: float
    unseen: float
    fresh: float
    promises: Array


def study(
    arm: Arm, paper: Paper | None, seed: int, seconds: float, rate: float, noise: float, folder: Path
) -> ModelCase:
    """A random plant near the arm, one random motion logged with noise and encoders of 1e-5 rad."""
    rng = np.random.default_rng(seed)
    plant = perturbed_plant(TorqueColumns(arm.chain, "directions"), arm, rng)
    log = simulated_log(plant, random_motion(arm, seconds, rng, rate), noise, rng, 1e-5)
    other = simulated_log(plant, random_motion(arm, seconds, rng, rate), noise, rng, 1e-5, "other")
    result = identify_motion([log], arm)
    fit = result.consistent
    assert fit is not None
    fresh = result.validated_on([other])

    def over_noise(values: list[float]) -> float:
        return rms(np.array(values)) / noise

    return ModelCase(
        _off(result, paper, folder), bool(fit.physical.all()), over_noise([v.fitted for v in result.validation]),
        over_noise([v.held_out for v in result.validation]), over_noise([v.consistent or np.nan for v in fresh]),
        _promises(result, plant, log, rate, noise, rng),
    )  # fmt: skip


def _off(result: MotionIdentification, paper: Paper | None, folder: Path) -> float:
    (file,) = write_fitted(folder / "arm.toml", result, paper)
    arm = lwr_dyn.load(file)
    assert result.consistent is not None
    q, dq, ddq = np.random.default_rng(4).uniform(-1.0, 1.0, (3, 6, arm.n))
    predicted = result.columns(q, dq, ddq) @ result.consistent.parameters
    bodies = lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics(q, dq, ddq)
    total = bodies + friction_torque(arm.friction_models(), dq)
    return float(np.abs(total - predicted).max() / np.abs(predicted).max())


def swing_of(motion: MissingMotion, rate: float) -> Motion:
    """The motion that is named, exactly."""
    t = np.arange(0.0, SECONDS, 1.0 / rate)
    q, dq, ddq = np.tile(motion.pose, (len(t), 1)), *np.zeros((2, len(t), len(motion.pose)))
    for j, size, hertz in zip(motion.joints, motion.amplitudes, motion.hertz, strict=True):
        w = 2.0 * np.pi * hertz
        q[:, j - 1] += size * np.sin(w * t)
        dq[:, j - 1], ddq[:, j - 1] = size * w * np.cos(w * t), -size * w**2 * np.sin(w * t)
    return Motion(t, q, dq, ddq)


def _promises(
    result: MotionIdentification, plant: Plant, log: JointLog, rate: float, noise: float, rng: np.random.Generator
) -> Array:
    motions = result.missing_motions()
    if not motions:
        return np.zeros(0)
    motion = motions[0]
    swing = simulated_log(plant, swing_of(motion, rate), noise, rng, 1e-5, "swing")
    both = identify_motion([log, swing], result.arm)
    louder = float(np.mean(both.information.noise / result.information.noise))
    return np.asarray(both.information.sigma[list(motion.parameters)] / np.array(motion.sigma) / louder)
