"""Which friction a run has: the plant's own with true stick, its smooth form, none, or what the caller brings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction, smooth_friction
from lwr_dyn.simulation.dry_friction import DryFriction
from lwr_dyn.simulation.plant import FrictionLaw, Plant
from lwr_dyn.simulation.settings import Settings

FORMS = ("set-valued", "smooth", "none")
FrictionOption = str | Sequence[JointFriction | None] | Callable[[Array], Array] | None
"""See `simulate`; None is the default, "set-valued"."""
SMOOTH_SPEED = 1e-3
"""[rad/s or m/s] of the smooth form: tanh(dq / SMOOTH_SPEED) in place of the sign."""
STABLE = 2.7
"""What rate times step RK4 bears on the negative real axis (2.785)."""
RULE = (
    "a joint at rest stays at rest if its static level holds it; those that it cannot hold resist with Coulomb's level "
    "only, and what remains at rest is judged again"
)


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """Friction of a run: a smooth law or set-valued friction or neither, and its steepest slope (n,) [N m s/rad]."""

    form: str
    law: FrictionLaw | None
    dry: DryFriction | None
    slope: Array

    def about(self) -> dict[str, Any]:
        """Of the friction, as JSON values."""
        told: dict[str, Any] = {"form": self.form}
        if self.form == "smooth":
            told["smooth_speed"] = SMOOTH_SPEED
        if self.dry is not None:
            told["rule"] = RULE
            told |= {name: getattr(self.dry, name).tolist() for name in ("coulomb", "viscous", "lowest", "highest")}
        return told


def chosen_friction(arm: Arm, option: FrictionOption = None) -> Choice:
    """The friction that the option names, of an arm.

    Raises
    ------
    OptionError
        A form of another name.
    ShapeError
        Another number of joints.
    """
    none = np.zeros(arm.n)
    if callable(option):
        return Choice("given", option, None, none)
    if isinstance(option, str) and option not in FORMS:
        raise OptionError("friction", repr(option), f"{', '.join(FORMS)}, one JointFriction a joint, or a function")
    own = option is None or isinstance(option, str)
    models = arm.friction_models() if option is None or isinstance(option, str) else tuple(option)
    if len(models) != arm.n:
        raise ShapeError("friction", f"{len(models)} joints", f"{arm.n}, one a joint, None where there is none")
    if option == "none" or (own and all(model is None for model in models)):
        return Choice("none", None, None, none)
    dry = DryFriction.of(models)
    if option == "smooth":
        return Choice(
            "smooth", smooth_friction(models, SMOOTH_SPEED), None, dry.viscous.max(axis=0) + _step(dry) / SMOOTH_SPEED
        )
    if not (dry.coulomb.any() or dry.lowest.any() or dry.highest.any() or np.ptp(dry.viscous, axis=0).any()):
        coefficients = dry.viscous[0]
        return Choice("viscous", lambda dq: coefficients * dq, None, np.maximum(coefficients, 0.0))
    return Choice("set-valued", None, dry, np.maximum(dry.viscous.max(axis=0), 0.0))


def _step(dry: DryFriction) -> Array:
    return np.asarray((dry.coulomb + dry.fall).max(axis=0))


def check_rate(plant: Plant, choice: Choice, q: Array, settings: Settings) -> float:
    """Fastest rate at which friction brakes [1/s], the largest eigenvalue of B(q)^-1 diag(slope), where a run begins.

    Raises `OptionError` where RK4's step is too long for it: the motion would grow instead of coming to rest.
    """
    if not choice.slope.any():
        return 0.0
    rate = float(np.linalg.eigvals(np.linalg.solve(plant.raw.mass_matrix(q), np.diag(choice.slope))).real.max())
    step = 1.0 / (settings.rate * settings.substeps)
    if settings.method == "rk4" and rate * step > STABLE:
        need = ceil(rate / settings.rate / STABLE)
        other = ", or friction set-valued" if choice.form == "smooth" else ""
        found = f"{choice.form}, brakes at up to {rate:.4g} 1/s, too fast for RK4 steps of {step:.3g} s"
        raise OptionError("friction", found, f"substeps from {need} on, method dop853{other}")
    return rate
