"""Friction compensation for any law: the torque that friction takes is added to what the law asks for.

    tau = law + tau_f(dq_ref)    on the reference velocity ("LAW+friction"), or
    tau = law + tau_f(dq)        on the measured velocity ("LAW+friction-measured"),

with tau_f(v) = offset + F_c(v) tanh(v / width) + F_v v, F_c and F_v [N m, N m s/rad] those of the direction of v.

Stability
---------
On the reference velocity it is a feed-forward: a function of time, bounded, so a stable loop stays stable for any error
of the friction model, whatever sampling or delay; what a wrong model costs is an error of the motion. Where the torque
is at its limit it takes a share of what is left for feedback. It adds nothing where the reference rests.

On the measured velocity it is feedback that takes damping away: d tau_f/dv = F_c / width + F_v at rest. In continuous
time, with friction of the plant at least as large, what is left is passive; compensation above the true friction feeds
energy in at small speeds and the joint hunts. A delay or a sample and hold acts late where the speed turns round, and
noise of the speed beyond `width` is turned into torque of the full Coulomb level. No proof covers these; the linear
form at rest (no friction in the plant) has the negative damping in it and is unstable for small widths.

Source: Olsson, Astrom, Canudas de Wit, Gafvert, Lischinsky, "Friction models and friction compensation", European
Journal of Control 4 (1998), section 5.
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from lwr_dyn.control.laws.wrapped import Wrapped, layers_of
from lwr_dyn.control.linear_feedback import LinearFeedback, diagonal
from lwr_dyn.control.protocol import Controller, describe
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction, smooth_friction

WIDTH = 1e-3
"""[rad/s or m/s] Speed at which the compensation reaches 76 % of Coulomb's level."""
SLOPE_STEP = 1e-3
"""Of the width: the step of the differences that give the slope at rest, to 3e-7 of it."""
Models = Sequence[JointFriction | None]


class FrictionCompensation(Wrapped):
    """A controller with friction compensated; see this module for the law and its stability.

    Parameters
    ----------
    inner : Controller
    models : sequence of JointFriction or None
        One a joint; None has none.
    width : float
        Of the tanh [rad/s or m/s], above 0.
    measured : bool
        On the measured velocity, not on that of the reference.

    Raises
    ------
    OptionError
        A width that is not above 0.
    """

    def __init__(self, inner: Controller, models: Models, width: float = WIDTH, measured: bool = False) -> None:
        super().__init__(inner)
        self.models, self.width, self.measured = tuple(models), width, measured
        self.torque = smooth_friction(self.models, width)
        if measured and hasattr(inner, "linear_feedback"):
            self.linear_feedback = self._linear_feedback

    @property
    def word(self) -> str:  # type: ignore[override]
        """As in the name of the controller."""
        return "friction-measured" if self.measured else "friction"

    @property
    def label_word(self) -> str:  # type: ignore[override]
        """What friction is computed from."""
        return f"friction of {'dq' if self.measured else 'dq_ref'} added"

    @property
    def own_parameters(self) -> dict[str, Any]:
        """Width and friction of each joint."""
        joints = [None if model is None else asdict(model) for model in self.models]
        return {"friction": {"measured": self.measured, "width": self.width, "joints": joints}}

    def added(self, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """The friction of the speed that was chosen, (n,) [N m]."""
        return self.torque(dq if self.measured else dq_ref)

    def _linear_feedback(self, q: Array) -> LinearFeedback:
        """The inner controller's with the slope of friction at rest taken off its damping; see `Linearised`."""
        law: LinearFeedback = self.inner.linear_feedback(q)  # type: ignore[attr-defined]
        h = SLOPE_STEP * self.width
        v = np.full(len(self.models), h)
        slope = (self.torque(v) - self.torque(-v)) / (2 * h)
        return replace(law, velocity=law.velocity - diagonal(slope, len(q)))


def with_friction(
    controller: Controller,
    arm: Arm,
    dynamics: Dynamics,
    *,
    friction: Models | None = None,
    friction_width: float = WIDTH,
    friction_measured: bool = False,
) -> FrictionCompensation:
    """A controller with the friction of the arm, or with `friction` (one a joint) in its place.

    Raises
    ------
    MissingDataError
        The arm's friction is unknown and none is given.
    ShapeError
        Another number of joints.
    OptionError
        A controller whose friction is compensated already: twice is too much.
    """
    for layer in layers_of(controller):
        adapts = getattr(layer, "friction_gains", None) is not None
        if adapts or isinstance(layer, FrictionCompensation):
            word = "adapted friction, and friction" if adapts else "friction"
            raise OptionError(
                "controller", f"{describe(controller)['name']} with {word} again", "friction compensated once"
            )
    models = arm.friction_models() if friction is None else tuple(friction)
    if len(models) != arm.n:
        raise ShapeError("friction", f"{len(models)} joints", f"{arm.n}, one a joint, None where there is none")
    if not any(models):
        raise MissingDataError(arm.name, "friction of its joints", "its compensation (identify it, or give it)")
    return FrictionCompensation(controller, models, friction_width, friction_measured)


def with_measured_friction(
    controller: Controller,
    arm: Arm,
    dynamics: Dynamics,
    *,
    friction: Models | None = None,
    friction_width: float = WIDTH,
) -> FrictionCompensation:
    """`with_friction` on the measured velocity; raises as it."""
    return with_friction(
        controller, arm, dynamics, friction=friction, friction_width=friction_width, friction_measured=True
    )
