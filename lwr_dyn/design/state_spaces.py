"""The linear loop as state spaces of python-control, so that a user goes on with the library they know."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from lwr_dyn.foundation.errors import MissingPackageError, OptionError

if TYPE_CHECKING:
    from control import StateSpace


@dataclass(frozen=True, slots=True, eq=False)
class LoopStateSpaces:
    """Discrete state spaces (dt = the sample) of a loop at one pose; inputs and outputs are named by joint.

    - `plant`: torques [N m] -> positions and speeds [rad, rad/s] that the controller reads, without delay;
    - `open_loop`: L, from the torques that leave the controller to what it makes of them; `feedback(L, I)` closes it;
    - `sensitivity`: S = (I + L)^-1, from a torque added to the controller's to their sum.

    The delay is in `open_loop` and `sensitivity` as states, a chain of samples. `control.stability_margins` is not for
    these loops: of several inputs it takes the determinant or one entry, and its discrete gain margins are off.
    """

    plant: StateSpace
    open_loop: StateSpace
    sensitivity: StateSpace


def state_spaces(loop: RestingLoop, sampling: Sampling, joints: tuple[str, ...]) -> LoopStateSpaces:
    """The state spaces of a loop of one pose.

    Raises
    ------
    MissingPackageError
        python-control is not installed (extra `design`).
    OptionError
        A loop of several poses.
    """
    try:
        import control
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or "control", "design") from None
    if len(loop.plant.A) != 1:
        raise OptionError("loop", f"{len(loop.plant.A)} poses", "one pose: loop.at(np.array([i]))")
    T, n = 1.0 / sampling.rate, loop.plant.n
    Ad, Bd = loop.plant.held(T)
    A, B, C = (part[0] for part in loop.open_loop(sampling))
    torques = [f"tau_{name}" for name in joints]
    reads = np.vstack([loop.plant.position, loop.plant.velocity])
    named: Any = {"inputs": torques, "outputs": [f"{word}_{name}" for word in ("q", "dq") for name in joints]}
    back = {"inputs": torques, "outputs": [f"back_{name}" for name in joints]}
    total = {"inputs": torques, "outputs": [f"sum_{name}" for name in joints]}
    return LoopStateSpaces(
        control.ss(Ad[0], Bd[0], reads, np.zeros((2 * n, n)), T, name="plant", **named),
        control.ss(A, B, -C, np.zeros((n, n)), T, name="open_loop", **back),
        control.ss(A + B @ C, B, C, np.eye(n), T, name="sensitivity", **total),
    )
