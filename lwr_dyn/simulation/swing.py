"""Torque-free swing: nothing drives or brakes the arm, so its energy must stand still."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, read_only
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.errors import UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Run
from lwr_dyn.simulation.simulate import simulate

REST = 1e-3
"""[rad/s^2]: an arm that would accelerate less when let go stands at an equilibrium, as far as its data can tell:
centres of mass are printed to 1e-8 m, so the LWR's upright pose holds to 1e-4 rad/s^2."""
OFFSET = 1e-3
"""[rad] at every joint, the third case."""
SPEED = 0.5
"""[rad/s] at every joint, the second case."""


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """A reference that stands still at q (n,) [rad or m]."""

    q: Array
    duration: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", read_only(self.q))

    def sample(self, t: Array) -> Motion:
        """The same pose at all times."""
        still = np.zeros((t.size, self.q.size))
        return Motion(t, still + self.q, still, still)


@dataclass(frozen=True, slots=True)
class SwingCase:
    """How a swing begins: upright q = 0 with this offset [rad] and this speed [rad/s] at every joint."""

    offset: float
    speed: float
    title: str


CASES: Mapping[str, SwingCase] = MappingProxyType(
    {
        "rest": SwingCase(0.0, 0.0, "upright at rest: an equilibrium to the printed digits"),
        "speed": SwingCase(0.0, SPEED, "upright with initial velocities"),
        "offset": SwingCase(OFFSET, 0.0, "upright, every joint offset by 1e-3 rad: the equilibrium is unstable"),
    }
)


def no_torque(t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
    """The controller that does nothing, tau = 0."""
    return np.zeros_like(q)


def acceleration_at_rest(arm: Arm, q: ArrayLike, engine: str = "pinocchio") -> float:
    """Largest acceleration of a joint when the arm is let go at q, |B^-1 g| [rad/s^2]: 0 at an equilibrium."""
    pose = joint_array("q", q, arm.n)
    still = np.zeros(arm.n)
    return float(np.abs(dynamics_of(arm, engine).forward_dynamics(pose, still, still)).max())


def swing(
    arm: Arm,
    case: str = "offset",
    *,
    duration: float = 2.0,
    rate: float = 1000.0,
    method: str = "dop853",
    position_limits: bool = False,
    engine: str = "pinocchio",
    **options: Any,
) -> Run:
    """A torque-free swing from one of `CASES`; `run.meta["note"]` says whether it began at an equilibrium.

    Parameters
    ----------
    arm : Arm
    case : {"rest", "speed", "offset"}
    duration, rate : float
        [s], samples a second [Hz].
    position_limits : bool
        Off by default: the energy of a free swing stands still; with stops their losses are a channel.
    **options
        Further options of `simulate`; q0 and dq0 replace the case's own start.

    Raises
    ------
    UnknownNameError
        No such case; otherwise as `simulate`.
    """
    if case not in CASES:
        raise UnknownNameError("swing", case, CASES)
    begin = CASES[case]
    q0 = joint_array("q0", options.pop("q0", np.full(arm.n, begin.offset)), arm.n)
    dq0 = joint_array("dq0", options.pop("dq0", np.full(arm.n, begin.speed)), arm.n)
    pull = acceleration_at_rest(arm, q0, engine)
    note = {
        "case": case, "title": begin.title, "acceleration_at_rest": pull,
        "equilibrium": pull <= REST and not dq0.any(),
    }  # fmt: skip
    return simulate(
        arm, no_torque, Rest(q0, duration), q0=q0, dq0=dq0, rate=rate, method=method, engine=engine,
        position_limits=position_limits, meta=note, **options,
    )  # fmt: skip
