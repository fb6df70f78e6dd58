"""The paper's experiment on the simulated arm: out and back at constant velocity, one log for every speed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array
from lwr_dyn.control.protocol import Controller
from lwr_dyn.identification.friction import USUAL, FrictionIdentification, How, identify_friction
from lwr_dyn.identification.generator import LogSensors
from lwr_dyn.identification.logs import JointLog, log_of_run
from lwr_dyn.identification.torque_model import Subtract
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.lspb_move import lspb_move
from lwr_dyn.trajectory.references.point_to_point import JointReference


def cruise_and_back(arm: Arm, start: ArrayLike, stroke: ArrayLike, speed: float, blend: float = 1.0) -> JointReference:
    """An LSPB move of `stroke` from `start` and the same way back.

    Parameters
    ----------
    arm : Arm
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
    return JointReference(np.array([q0, q0 + step, q0]), (out.laws[0], out.laws[0]))


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
    how: How = USUAL,
) -> Coverage:  # fmt: skip
    """The share of 3-sigma intervals that cover the friction of `arm`, over seeded noise draws on one simulated set.

    Parameters
    ----------
    logs : iterable of JointLog
        As the arm did it, without noise; every draw puts its own noise on them.
    arm : Arm
        Whose `friction` is the truth.
    sensors : LogSensors
    draws : iterable of int
        Seeds.
    subtract, how
        As `identify_friction` takes them.

    Raises
    ------
    LwrDynError
        What `identify_friction` raises, and its first fault.
    """
    clean = list(logs)
    inside = intervals = 0
    for seed in draws:
        noisy = [sensors.through(log, seed * len(clean) + i) for i, log in enumerate(clean)]
        found = identify_friction(noisy, arm, subtract, how)
        if found.faults:
            raise found.faults[0]
        misses, widths = _against(found, arm)
        inside += int(np.sum(np.abs(misses) <= widths))
        intervals += misses.size
    return Coverage(inside, intervals)


def _against(found: FrictionIdentification, arm: Arm) -> tuple[Array, Array]:
    """Estimate less truth, and the half-widths of the intervals, of all parameters in a row."""
    misses = [fit.estimate.values - true_values(arm, fit.joint, fit.sign, fit.names) for fit in found.fits]
    return np.concatenate(misses), np.concatenate([fit.estimate.half_widths for fit in found.fits])


def true_values(arm: Arm, joint: int, sign: int, names: tuple[str, ...]) -> Array:
    """The parameters of that name in the arm's own friction, joint from 1; NaN where it has none."""
    model = arm.friction[joint - 1] if arm.friction else None
    if model is None:
        return np.full(len(names), np.nan)
    direction = model.positive if sign > 0 else model.negative
    return np.array([np.nan if (value := getattr(direction, name)) is None else value for name in names])
