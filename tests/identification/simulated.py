"""Logs with a known truth: ideal cruises in closed form, and how often intervals cover what was simulated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import OptionError
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
    Raises `ShapeError` for velocities or a start of another length, `OptionError` for a duration not above 0.
    """
    n = len(frictions)
    speed = joint_array("dq", dq, n)
    start = joint_array("q0", np.zeros(n) if q0 is None else q0, n)
    if not (isfinite(duration) and duration > 0.0):
        raise OptionError("duration", duration, "a number above 0")
    t = np.arange(round(duration * rate) + 1) / rate
    q = start + t[:, None] * speed
    torques = [model.torque(v) if v else 0.0 for model, v in zip(frictions, speed.tolist(), strict=True)]
    tau = np.broadcast_to(np.array(torques), q.shape)
    if arm is not None:
        tau = tau + Recursion.of(arm.require_dynamics()).bias_torque(q, np.broadcast_to(speed, q.shape))
    return JointLog(source, tuple(range(1, n + 1)), t, q, tau)


@dataclass(frozen=True, slots=True)
class Coverage:
    """How many of the 3-sigma intervals hold the truth, pooled over parameters and noise draws."""

    inside: int
    intervals: int

    @property
    def share(self) -> float:
        """Of the intervals that hold it."""
        return self.inside / self.intervals


def interval_coverage(
    logs: Iterable[JointLog], arm: Arm, sensors: LogSensors, draws: Iterable[int], subtract: Subtract = "all",
    options: friction.FitOptions = friction.DEFAULT_FIT,
) -> Coverage:  # fmt: skip
    """The share of 3-sigma intervals that cover the friction of `arm`, over seeded noise draws on logs without noise.

    Raises what `identify_friction` raises, and its first fault.
    """
    clean = list(logs)
    inside = intervals = 0
    for seed in draws:
        noisy = [sensors.through(log, seed * len(clean) + i) for i, log in enumerate(clean)]
        found = friction.identify_friction(noisy, arm, subtract, options)
        if found.faults:
            raise found.faults[0]
        for fit in found.fits:
            misses = fit.estimate.values - true_values(arm, fit.joint, fit.sign, fit.names)
            inside += int(np.sum(np.abs(misses) <= fit.estimate.half_widths))
            intervals += misses.size
    return Coverage(inside, intervals)


def true_values(arm: Arm, joint: int, sign: int, names: tuple[str, ...]) -> Array:
    """The parameters of that name in the arm's own friction, joint from 1; NaN where it has none."""
    model = arm.friction[joint - 1] if arm.friction else None
    if model is None:
        return np.full(len(names), np.nan)
    direction = model.positive if sign > 0 else model.negative
    return np.array([np.nan if (value := getattr(direction, name)) is None else value for name in names])
