"""Logs that did not come from a robot: ideal cruises in closed form, and what sensors add to any log.

Simulated runs become logs by `lwr_dyn.identification.logs.log_of_run`; so the circle simulate, log, identify closes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import joint_array
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.errors import OptionError
from lwr_dyn.identification.logs import JointLog
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction.models import JointFriction


@dataclass(frozen=True, slots=True)
class LogSensors:
    """What is between the arm and its log.

    Parameters
    ----------
    torque_noise : float or tuple of float
        Standard deviation of the torque transducers [N m or N], one for all joints or one each.
    resolution : float
        One count of the encoders at the joint [rad or m]; 0 for no rounding.
    position_noise : float
        Standard deviation before rounding [rad or m].

    Raises
    ------
    OptionError
        A negative or non-finite number.
    """

    torque_noise: float | tuple[float, ...] = 0.0
    resolution: float = 0.0
    position_noise: float = 0.0

    def __post_init__(self) -> None:
        noise = self.torque_noise if isinstance(self.torque_noise, tuple) else (self.torque_noise,)
        named = [("torque noise", x) for x in noise]
        for name, value in (*named, ("resolution", self.resolution), ("position noise", self.position_noise)):
            if not (isfinite(value) and value >= 0.0):
                raise OptionError(f"log {name}", value, "a number >= 0")

    def through(self, log: JointLog, seed: int) -> JointLog:
        """The log as these sensors write it; the same seed gives the same noise. A velocity is not measured."""
        rng = np.random.default_rng(seed)
        tau = log.tau + rng.normal(size=log.tau.shape) * np.asarray(self.torque_noise)
        q = log.q + rng.normal(size=log.q.shape) * self.position_noise
        if self.resolution > 0.0:
            q = np.round(q / self.resolution) * self.resolution
        return replace(log, q=q, tau=tau, dq=None)


def ideal_cruise(
    frictions: Sequence[JointFriction], dq: ArrayLike, arm: Arm | None = None, q0: ArrayLike | None = None,
    duration: float = 2.0, rate: float = 100.0, source: str = "ideal cruise",
) -> JointLog:  # fmt: skip
    """A log of constant velocities: q = q0 + dq t, tau = C dq + g(q) + tau_friction(dq), exact to rounding.

    Parameters
    ----------
    frictions : sequence of n JointFriction
    dq : (n,) array_like
        Velocities [rad/s or m/s]; a joint at 0 stands still and shows no friction.
    arm : Arm, optional
        Whose C dq + g is in the torques; none of it without.
    q0 : (n,) array_like, optional
        Start; zeros if not given.
    duration : float
        [s]
    rate : float
        Rows a second [Hz].

    Raises
    ------
    ShapeError
        Velocities or start of another length.
    OptionError
        A duration or rate that is not above 0.
    """
    n = len(frictions)
    speed = joint_array("dq", dq, n)
    start = joint_array("q0", np.zeros(n) if q0 is None else q0, n)
    for name, value in (("duration", duration), ("rate", rate)):
        if not (isfinite(value) and value > 0.0):
            raise OptionError(name, value, "a number above 0")
    t = np.arange(round(duration * rate) + 1) / rate
    q = start + t[:, None] * speed
    friction = [model.torque(v) if v else 0.0 for model, v in zip(frictions, speed.tolist(), strict=True)]
    tau = np.broadcast_to(np.array(friction), q.shape)
    if arm is not None:
        tau = tau + Recursion.of(arm.require_dynamics()).bias_torque(q, np.broadcast_to(speed, q.shape))
    return JointLog(source, tuple(range(1, n + 1)), t, q, tau)
