"""The plant with elastic joints: 2n coordinates, friction on the motors' side, position stops on the links' side."""

import warnings
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from lwr_dyn.dynamics.engines import ENGINES
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import MissingDataError, OptionError, RatingWarning
from lwr_dyn.simulation.arm_friction import FORMS, ArmFriction
from lwr_dyn.simulation.elastic.dynamics import ElasticDynamics
from lwr_dyn.simulation.elastic.full_model import FullElasticDynamics
from lwr_dyn.simulation.plant import Plant
from lwr_dyn.simulation.setup import Setup

SLOWEST = 5.0
"""[rad/s] A rotor so light that a sampled law on the motors' side cannot even be this fast is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class ElasticPlant(Plant):
    """As `Plant`, of 2n coordinates (q, theta)."""

    model: ElasticDynamics

    @property
    def n(self) -> int:
        """Number of coordinates, twice that of the joints."""
        return 2 * self.arm.n


def elastic_plant(setup: Setup) -> ElasticPlant:
    """The plant of a setup with `elasticity`: of the full model where the engine has rotors "full", else reduced.

    Raises
    ------
    MissingDataError
        A joint without a rotor.
    OptionError
        A rotor too light to be driven by a sampled law on its own side, an engine of no registered name.
    """
    plant, elasticity = setup.plant, setup.elasticity
    assert elasticity is not None
    if setup.engine not in ENGINES.names:
        raise OptionError("engine", f"{setup.engine} with elastic joints", ", ".join(ENGINES.names))
    full = getattr(plant.ungated, "rotors", "armature") == "full"
    links = "pinocchio" if full else setup.engine  # the recursion is written to be read, not to be fast
    model = (FullElasticDynamics if full else ElasticDynamics)(plant.arm, elasticity, links)
    _check_rotors(setup, model)
    free = np.full(plant.arm.n, np.inf)
    return ElasticPlant(
        plant.arm, model, motor_friction(plant.friction, plant.arm.n),  # type: ignore[arg-type] # it has what loops use
        np.concatenate([plant.lower, -free]), np.concatenate([plant.upper, free]),
        np.concatenate([free, plant.effort]), model,
    )  # fmt: skip


def fastest_on_motors(rate: float, rotor: Array, B: Array) -> Array:
    """B_m / (B_ii T) (..., n) [rad/s] at `rate` = 1/T [Hz], for rotors (n,) [kg m^2] and mass matrices B (..., n, n).

    A law on the motors' side that is tuned to more shakes the rotor; less than `SLOWEST` is refused.
    """
    return np.asarray(rate * rotor / np.diagonal(B, axis1=-2, axis2=-1))


def _check_rotors(setup: Setup, model: ElasticDynamics) -> None:
    """A law on the motors' side, tuned to omega_n on the rigid inertia B_ii, damps the rotor alone with 2 omega_n B_ii.

    Held for T it lets the rotor swing up where T 2 omega_n B_ii > 2 B_m: faster than B_m / (B_ii T) nothing works.
    """
    arm, rate = setup.plant.arm, setup.options.rate
    bare = np.flatnonzero(model.rotor <= 0.0)
    if bare.size:
        raise MissingDataError(arm.name, f"rotor inertia of {arm.joint_names[bare[0]]}", "elastic joints")
    B = setup.plant.ungated.mass_matrix(setup.start[0])
    rigid, fastest = np.diagonal(B), fastest_on_motors(rate, model.rotor, B)
    j = int(np.argmin(fastest))
    if fastest[j] >= SLOWEST or setup.options.allow_unphysical:
        return
    fault = (
        f"rotor of {model.rotor[j]:.2g} kg m^2 before {rigid[j]:.3g} kg m^2, too light for elastic joints: held for "
        f"{1 / rate:.2g} s, damping on the motors' side shakes it from {fastest[j]:.2g} rad/s on"
    )
    need = ceil(SLOWEST * rigid[j] / model.rotor[j])
    if setup.encoders == "link":
        warnings.warn(f"{arm.joint_names[j]}: {fault}", RatingWarning, stacklevel=2)
        return
    allowed = f"a reading with heavier rotors, a rate from {need} Hz on (steps of {1 / need:.2g} s), or "
    raise OptionError(f"{arm.joint_names[j]} ({arm.reading})", fault, f"{allowed}allow_unphysical")


def motor_friction(friction: ArmFriction, n: int) -> ArmFriction:
    """The friction of n joints on the motors' side of 2n coordinates."""
    if friction.form == "none":
        return ArmFriction.function("none", 2 * n, None)
    slope = np.concatenate([np.zeros(n), friction.slope])
    smooth = friction.smooth
    if smooth is not None:
        still = np.zeros(n)
        return ArmFriction.function(
            friction.form, 2 * n, lambda dx: np.concatenate([still, smooth(dx[n:])]), read_only(slope)
        )
    assert friction.form == FORMS[0]
    names = ("coulomb", "viscous", "stribeck_drop", "sharpness", "offset", "lowest", "highest", "lowest_slip")
    wide: dict[str, Any] = {name: _on_motors(getattr(friction, name)) for name in (*names, "highest_slip", "slope")}
    return replace(friction, **wide)


def _on_motors(table: Array) -> Array:
    return read_only(np.concatenate([np.zeros_like(table), table], axis=-1))
