"""Logs of simulated arms: constant-velocity runs out and back, and the noise and rounding of sensors.

With them the circle closes: simulate, log, identify, compare with the friction that was simulated.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.logs.joint_log import JointLog, log_of_run
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.joint_moves import JointReference, lspb_move


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
        """The log as these sensors write it; the same seed gives the same noise. A velocity is not measured.

        Motor positions, where the log has them, are those of gears' other sides, read at the joint too.
        """
        rng = np.random.default_rng(seed)
        tau = log.tau + rng.normal(size=log.tau.shape) * np.asarray(self.torque_noise)
        q = self._encoder(log.q, rng)
        theta = None if log.motor_q is None else self._encoder(log.motor_q, rng)
        return replace(log, q=q, tau=tau, dq=None, motor_q=theta)

    def _encoder(self, angle: Array, rng: np.random.Generator) -> Array:
        noisy = angle + rng.normal(size=angle.shape) * self.position_noise
        return np.asarray(np.round(noisy / self.resolution) * self.resolution if self.resolution > 0.0 else noisy)


def cruise_and_back(arm: Arm, start: ArrayLike, stroke: ArrayLike, speed: float, blend: float = 1.0) -> JointReference:
    """An LSPB move of `stroke` from `start` and the same way back.

    Parameters
    ----------
    start, stroke : (n,) array_like
        [rad or m]; joints with a stroke of 0 stand still.
    speed : float
        Of the joint with the longest stroke, the others in proportion [rad/s or m/s].
    blend : float
        Time to reach it [s]; the paper's t_c = 1 s.

    Raises
    ------
    ShapeError, OptionError, PathLimitError
        As `lspb_move`.
    """
    q0, step = (fixed_array(name, x, (arm.n,)) for name, x in (("start", start), ("stroke", stroke)))
    longest = float(np.abs(step).max())
    out = lspb_move(arm, q0, q0 + step, duration=longest / speed + blend, blend=blend)
    return JointReference(np.array([q0, q0 + step, q0]), (out.profiles[0], out.profiles[0]))


def cruise_logs(
    arm: Arm, controller: Controller, start: ArrayLike, stroke: ArrayLike, speeds: Iterable[float],
    blend: float = 1.0, rate: float = 100.0, **options: Any,
) -> Iterator[JointLog]:  # fmt: skip
    """One log a speed from the simulated closed loop, at `rate` [Hz] and without sensors in between.

    Parameters
    ----------
    arm, controller
        As `simulate` takes them.
    start, stroke, blend
        As `cruise_and_back` takes them.
    speeds : iterable of float
        [rad/s or m/s]
    rate : float
        Rows a second [Hz]; the paper's logs have 100.
    **options
        Of `simulate`, such as `friction`.

    Raises
    ------
    LwrDynError
        What `cruise_and_back` and `simulate` raise.
    """
    for speed in speeds:
        run = simulate(arm, controller, cruise_and_back(arm, start, stroke, speed, blend), **options)
        yield log_of_run(run, rate, f"{arm.name} at {speed:g} rad/s")
