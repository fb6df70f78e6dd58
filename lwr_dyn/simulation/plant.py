"""The plant: the arm that is simulated, which need not be the one that the controller models."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, UngatedDynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import NotPhysicalError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.feasibility import unphysical_links
from lwr_dyn.simulation.arm_friction import ArmFriction, Mask


@dataclass(frozen=True, slots=True, eq=False)
class Plant:
    """An arm with its dynamics, friction and limits; a limit that is off or unknown is infinite."""

    arm: Arm
    dynamics: Dynamics
    friction: ArmFriction
    lower: Array
    upper: Array
    effort: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.arm.n

    @property
    def ungated(self) -> UngatedDynamics:
        """The engine without the shape gate."""
        return ungated(self.dynamics)

    def at_limit(self, q: Array) -> Array:
        """+1 at or above an upper limit, -1 at or below a lower one, else 0, (n,)."""
        return (q >= self.upper).astype(np.float64) - (q <= self.lower)

    def beyond(self, q: Array) -> Mask:
        """Whether a joint is past a limit, (n,)."""
        return np.asarray((q > self.upper) | (q < self.lower))


def plant_of(
    arm: Arm,
    engine: str | Dynamics,
    friction: ArmFriction | None = None,
    saturate: bool = True,
    position_limits: bool = True,
    allow_unphysical: bool = False,
) -> Plant:
    """The plant of an arm, without friction if none is given.

    Raises
    ------
    MissingDataError, UnknownNameError
        The arm has no inertias; no engine of that name.
    ShapeError
        Dynamics of another number of joints.
    NotPhysicalError
        An inertia that no body can have, unless `allow_unphysical`.
    """
    bad = unphysical_links(arm.require_dynamics())
    dynamics = dynamics_of(arm, engine) if isinstance(engine, str) else engine
    if dynamics.n != arm.n:
        raise ShapeError("engine", f"{dynamics.n} joints", f"{arm.n} joints, as the plant has")
    if bad and not allow_unphysical:
        raise NotPhysicalError(f"{arm.name} ({arm.reading})", bad)
    free = np.full(arm.n, np.inf)
    return Plant(
        arm, dynamics, friction or ArmFriction.function("none", arm.n, None),
        lower=arm.lower if position_limits else -free,
        upper=arm.upper if position_limits else free,
        effort=arm.effort if saturate else free,
    )  # fmt: skip
