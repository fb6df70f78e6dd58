"""Free swing: no motor drives or brakes the arm, so without friction and stops its energy stays constant."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Run
from lwr_dyn.simulation.setup import prepare
from lwr_dyn.simulation.simulate import run_setup

EQUILIBRIUM = 1e-3
"""[rad/s^2] A pose with less acceleration at rest counts as an equilibrium: centres of mass are printed to 1e-8 m, so
the LWR's upright pose is exact to 1e-4 rad/s^2."""


@dataclass(frozen=True, slots=True)
class SwingCase:
    """The start of a swing: upright q = 0 with this offset [rad] and this speed [rad/s] at every joint."""

    offset: float
    speed: float
    title: str


CASES: Mapping[str, SwingCase] = MappingProxyType(
    {
        "rest": SwingCase(0.0, 0.0, "upright at rest: an equilibrium to the printed digits"),
        "speed": SwingCase(0.0, 0.5, "upright with initial velocities"),
        "offset": SwingCase(1e-3, 0.0, "upright, every joint offset by 1e-3 rad: the equilibrium is unstable"),
    }
)


@dataclass(frozen=True, slots=True, eq=False)
class Standstill:
    """The reference of a swing, which no controller follows: the pose q (n,) [rad or m] for `duration` [s]."""

    q: Array
    duration: float

    def sample(self, t: Array) -> Motion:
        """The pose, without speed or acceleration, at times t (k,) [s]."""
        times = np.atleast_1d(t)
        still = np.zeros((times.size, self.q.size))
        return Motion(times, still + self.q, still, still)


def no_torque(t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
    """The controller without torque, tau = 0."""
    return np.zeros_like(q)


def free_swing(
    arm: Arm,
    case: str = "offset",
    *,
    duration: float = 2.0,
    method: str = "dop853",
    position_limits: bool = False,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    **options: Any,
) -> Run:
    """A free swing from one of `CASES`; `run.meta["note"]` says whether it began at an equilibrium.

    Parameters
    ----------
    arm : Arm
    case : {"rest", "speed", "offset"}
    duration : float
        [s]
    position_limits : bool
        Off by default, so that the energy stays constant; with stops their losses are a channel.
    q0, dq0 : (n,) array_like, optional
        The start [rad or m, per s], in place of the case's own.
    **options
        Further options of `simulate`.

    Raises
    ------
    UnknownNameError
        No such case; otherwise as `simulate`.
    """
    if case not in CASES:
        raise UnknownNameError("swing", case, CASES)
    start = CASES[case]
    pose = joint_array("q0", np.full(arm.n, start.offset) if q0 is None else q0, arm.n)
    speed = np.full(arm.n, start.speed) if dq0 is None else dq0
    stay = Standstill(pose, float(duration))
    setup = prepare(arm, no_torque, stay, q0=pose, dq0=speed, method=method, position_limits=position_limits, **options)
    none = np.zeros(arm.n)
    largest = float(np.abs(setup.plant.dynamics.forward_dynamics(pose, none, none)).max())
    equilibrium = largest <= EQUILIBRIUM and not setup.start[1].any()
    note = {"case": case, "title": start.title, "acceleration_at_rest": largest, "equilibrium": bool(equilibrium)}
    return run_setup(replace(setup, note=note))
