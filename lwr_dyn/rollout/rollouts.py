"""`rollouts`: many runs of one closed loop at once, with parameters of their own, reduced to metrics on the way."""

from collections.abc import Mapping, Sequence
from typing import Any

from lwr_dyn.control.protocol import Controller
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.rollout.result import Rollouts
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.sensors import Encoder

MOST_DELAY = 8
"""[samples] Longest delay of the kernel."""


def rollouts(
    arm: Arm,
    controller: Controller | str,
    reference: Reference | Sequence[Reference],
    *,
    runs: int | None = None,
    parameters: Mapping[str, Any] | None = None,
    rate: float = 1000.0,
    substeps: int = 1,
    plant: Arm | None = None,
    friction: str = "none",
    friction_width: float = SMOOTH_SPEED,
    saturate: bool = True,
    position_limits: bool = True,
    delay: int = 0,
    encoder: Encoder | None = None,
    seed: int = 0,
    duration: float | None = None,
    tolerance: float | None = None,
    quantiles: Sequence[float] = (),
    record: int = 0,
    threads: int = 1,
    hand_over: bool = True,
    first_run: int = 0,
) -> Rollouts:
    """Runs of a closed loop by a kernel; not there yet."""
    raise NotImplementedError
