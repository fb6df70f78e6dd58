"""The plant: the arm that is simulated, which need not be the one that the controller models."""

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, UngatedDynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import NotPhysicalError, OptionError, RatingWarning, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import with_bodies, with_payload
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


def arm_with_payload(arm: Arm, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia_com: Any = None) -> Arm:
    """The arm with a payload fixed to its flange: mass [kg], com (3,) [m] and inertia in the flange frame.

    Give it to the plant alone and the payload is unknown to the controller; build the controller's dynamics on it
    too and it is known. Raises `OptionError` for a negative mass, `ShapeError` for other shapes; warns with
    `RatingWarning` of a mass over the rated payload.
    """
    rated = arm.ratings.payload
    if rated is not None and mass > rated:
        warnings.warn(
            f"{arm.name}: a payload of {mass:g} kg is over the rated {rated:g} kg", RatingWarning, stacklevel=2
        )
    return arm.with_chain(with_payload(arm.chain, mass, com, inertia_com))


def arm_with_scaled_inertia(arm: Arm, factor: float) -> Arm:
    """The arm with every mass and inertia multiplied by `factor`; raises `OptionError` unless it is above 0."""
    if not (np.isfinite(factor) and factor > 0.0):
        raise OptionError("mass factor", factor, "a number above 0")
    bodies = [
        replace(b, mass=factor * b.mass, inertia_com=factor * b.inertia_com)
        for b in arm.require_dynamics().bodies or ()
    ]
    return replace(arm, chain=with_bodies(arm.chain, bodies))
