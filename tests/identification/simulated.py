"""Logs with a known truth: ideal cruises in closed form, and how often intervals cover what was simulated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.friction import identify_friction as friction
from lwr_dyn.identification.friction.friction_map import Subtract
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction


def ideal_cruise(
    frictions: Sequence[JointFriction], dq: ArrayLike, arm: Arm | None = None, q0: ArrayLike | None = None,
    duration: float = 2.0, rate: float = 100.0, source: str = "ideal cruise",
) -> JointLog:  # fmt: skip
    """A log of constant velocities: q = q0 + dq t, tau = C dq + g(q) + tau_friction(dq), exact to rounding.

    A joint at 0 stands still and shows no friction; without an arm there is no C dq + g. `duration` [s], `rate` [Hz].
    """
    n, speed = len(frictions), np.asarray(dq, dtype=float)
    start = np.zeros(n) if q0 is None else np.asarray(q0)
    t = np.arange(round(duration * rate) + 1) / rate
    q = start + t[:, None] * speed
    torques = [model.torque(v) if v else 0.0 for model, v in zip(frictions, speed.tolist(), strict=True)]
    tau = np.broadcast_to(np.array(torques), q.shape)
    if arm is not None:
        tau = tau + Recursion.of(arm.require_dynamics()).bias_torque(q, np.broadcast_to(speed, q.shape))
    return JointLog(source, tuple(range(1, n + 1)), t, q, tau)


def interval_coverage(
    logs: Iterable[JointLog], arm: Arm, sensors: LogSensors, draws: Iterable[int], subtract: Subtract = "all"
) -> Array:
    """Which 3-sigma intervals cover the friction of `arm`, (intervals,), over seeded noise on logs without noise."""
    clean, inside = list(logs), []
    for seed in draws:
        noisy = [sensors.through(log, seed * len(clean) + i) for i, log in enumerate(clean)]
        found = friction.identify_friction(noisy, arm, subtract)
        assert not found.faults
        for fit in found.fits:
            misses = fit.estimate.values - true_values(arm, fit.joint, fit.sign, fit.names)
            inside += (np.abs(misses) <= fit.estimate.half_widths).tolist()
    return np.array(inside)


def true_values(arm: Arm, joint: int, sign: int, names: tuple[str, ...]) -> Array:
    """The parameters of that name in the arm's own friction, joint from 1; NaN where it has none."""
    model = arm.friction[joint - 1] if arm.friction else None
    if model is None:
        return np.full(len(names), np.nan)
    direction = model.positive if sign > 0 else model.negative
    return np.array([np.nan if (value := getattr(direction, name)) is None else value for name in names])


def fourier_states(n: int, seconds: float, seed: int, joints: Sequence[int] | None = None) -> tuple[Array, ...]:
    """t, q, dq, ddq at 100 Hz of five harmonics of 0.1 Hz at every one of n joints, or at some (from 0)."""
    rng = np.random.default_rng(seed)
    t, w = np.arange(0.0, seconds, 0.01), 2 * np.pi * 0.1 * np.arange(1, 6)
    size, phase = rng.normal(0.0, 0.25, (5, n)), rng.uniform(0.0, 6.0, (5, n))
    if joints is not None:
        size[:, [j for j in range(n) if j not in joints]] = 0.0
    angle = w[:, None, None] * t[:, None] + phase[:, None, :]
    q = np.einsum("ij,ikj->kj", size, np.sin(angle))
    dq = np.einsum("ij,ikj->kj", size * w[:, None], np.cos(angle))
    return t, q, dq, -np.einsum("ij,ikj->kj", size * w[:, None] ** 2, np.sin(angle))
