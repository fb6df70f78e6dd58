"""Arms that differ from their tables, motions that excite them, and what they log: with a known truth.

plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, level=0.2)
motion = random_motion(arm, 10.0, rng)  # rest at both ends, inside the limits
samples = simulated_samples(plant, motion, noise=0.05, rng=rng)  # exact states, noisy torques
log = simulated_log(plant, random_motion(arm, 10.0, rng, rate=1000.0), 0.05, rng, encoder=1e-5)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm, null_space

from lwr_dyn.dynamics.regressor import INERTIAL, body_parameters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.samples import Samples, exact_samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain, with_payload
from lwr_dyn.model.inertial_parameters import inertial_parameters, pseudo_inertias
from lwr_dyn.model.run import Motion

VISCOUS, COULOMB = (14.0, 14.0, 7.0, 10.0, 5.0, 2.5, 2.0), (11.0, 11.0, 8.0, 9.0, 9.0, 3.5, 3.0)
OFFSET = (0.5, -0.4, 0.3, 0.2, -0.1, 0.1, 0.05)
"""Friction [N m s/rad, N m, N m] of a plant whose arm has none, repeated for longer arms."""
FRICTION_SPREAD, OFFSET_SPREAD = 0.3, 0.3
"""Of a plant's friction about that: log-normal share, and N m."""
HARMONICS = 5
SPEED_SHARE = 0.9
MARGIN = 0.1
"""[rad or m] kept to the position limits."""


@dataclass(frozen=True, slots=True, eq=False)
class Plant:
    """The truth: its columns and its parameters (p,)."""

    columns: TorqueColumns
    parameters: Array

    @property
    def base(self) -> Array:
        """Its base values (b,)."""
        return self.columns.base().of(self.parameters)

    def torque(self, motion: Motion) -> Array:
        """Noise-free torques (k, n)."""
        return torques(self.columns, self.parameters, motion)


def congruent(link: Array, rng: np.random.Generator, level: float = 0.1) -> Array:
    """Ten parameters with P moved to L exp(S) L^T, S symmetric and random: a body stays one, a point mass as it is."""
    P, S = pseudo_inertias(link), rng.normal(0.0, level / np.sqrt(2.0), (4, 4))
    if np.linalg.eigvalsh(P)[0] <= 0.0:
        return link
    L = np.linalg.cholesky(P)
    return inertial_parameters(L @ expm((S + S.T) / np.sqrt(2.0)) @ L.T)


def perturbed_plant(columns: TorqueColumns, arm: Arm, rng: np.random.Generator, level: float = 0.2) -> Plant:
    """The arm with every link's pseudo-inertia moved by a random congruence, rotors and friction too."""
    out = columns.own(arm).copy()
    for i in range(arm.n):
        part = slice(len(INERTIAL) * i, len(INERTIAL) * (i + 1))
        out[part] = congruent(out[part], rng, level)
    frictionless = not any(arm.friction_models())
    for i, joint in enumerate(columns.joints):
        values = out[columns.of_joint(i)]  # a view
        values[0] *= np.exp(level * rng.normal())
        for k, name in enumerate(joint.names):
            spread = np.exp(FRICTION_SPREAD * rng.normal())
            default = {"coulomb": COULOMB, "viscous": VISCOUS}.get(name.rstrip("+-"))
            if name == "offset":
                values[k] += OFFSET[i % 7] * frictionless + OFFSET_SPREAD * rng.normal()
            elif name.startswith("stribeck"):
                values[k] = 0.3 * values[1] * spread
            elif default is not None:
                values[k] = (default[i % 7] if frictionless else values[k]) * spread
    return Plant(columns, out)


def random_motion(
    arm: Arm, duration: float, rng: np.random.Generator, rate: float = 100.0, share: float = SPEED_SHARE
) -> Motion:
    """A random Fourier series of five harmonics of 1/duration at every joint, at rest at both ends.

    Joints use up to `share` of their speed (2 rad/s where unknown) and stay `MARGIN` inside their limits.
    """
    t = np.arange(round(duration * rate) + 1) / rate
    w = 2.0 * np.pi / duration * np.arange(1, HARMONICS + 1)
    C, S = np.cos(np.outer(t, w)), np.sin(np.outer(t, w))
    P, V, A = np.hstack([S / w, -C / w]), np.hstack([C, S]), np.hstack([-S * w, C * w])
    rest = np.zeros((2, 2 * HARMONICS))
    rest[0, :HARMONICS], rest[1, HARMONICS:] = 1.0, w
    Z = null_space(rest)
    X = Z @ (Z.T @ rng.normal(size=(2 * HARMONICS, arm.n)))
    limits = ((arm.lower, -3.0), (arm.upper, 3.0), (arm.velocity, 2.0))
    lower, upper, fastest = (np.where(np.isfinite(x), x, unknown) for x, unknown in limits)
    q, dq = P @ X, V @ X
    span, room = q.max(axis=0) - q.min(axis=0), upper - lower - 2 * MARGIN
    fit = np.minimum(share * fastest / np.abs(dq).max(axis=0), room / span) * rng.uniform(0.6, 1.0, arm.n)
    q, dq, ddq = q * fit, dq * fit, (A @ X) * fit
    low, high = lower + MARGIN - q.min(axis=0), upper - MARGIN - q.max(axis=0)
    middle = low + (high - low) * rng.uniform(size=arm.n)
    return Motion(t, q + middle, dq, ddq)


def torques(columns: TorqueColumns, parameters: Array, motion: Motion) -> Array:
    """Y pi along a motion, (k, n), in blocks."""
    blocks = [slice(i, i + 512) for i in range(0, len(motion.t), 512)]
    return np.concatenate([columns(motion.q[b], motion.dq[b], motion.ddq[b]) @ parameters for b in blocks])


def simulated_samples(
    plant: Plant, motion: Motion, noise: float | Array, rng: np.random.Generator, slowest: float = 0.0
) -> Samples:
    """Exact states with noisy torques [N m]."""
    tau = plant.torque(motion)
    return exact_samples(motion.t, motion.q, motion.dq, motion.ddq, tau + rng.normal(size=tau.shape) * noise, slowest)


def simulated_log(
    plant: Plant, motion: Motion, noise: float | Array, rng: np.random.Generator, encoder: float = 0.0,
    source: str = "simulated", tau: Array | None = None,
) -> JointLog:  # fmt: skip
    """What the plant logs: positions with white encoder noise [rad], torques with white noise [N m].

    `tau` (k, n) are its torques without noise where they are known, so that many draws need them once.
    """
    exact = plant.torque(motion) if tau is None else tau
    q = motion.q + rng.normal(size=motion.q.shape) * encoder
    joints = tuple(range(1, motion.q.shape[1] + 1))
    return JointLog(source, joints, motion.t, q, exact + rng.normal(size=exact.shape) * noise)


def of_load(chain: Chain, mass: float, com: ArrayLike, tensor: Array | None = None) -> Array:
    """What a load at the flange adds to the ten parameters of the last link, through the chain itself."""
    bodies = [x.links[-1].body for x in (with_payload(chain, mass, com, tensor), chain)]
    full, own = (body_parameters(body) for body in bodies if body is not None)
    return np.asarray(full - own)


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def inside(z: Array) -> float:
    """The share of misses in standard errors that an interval of 3 sigma holds."""
    return float(np.mean(np.abs(z) <= 3.0))
