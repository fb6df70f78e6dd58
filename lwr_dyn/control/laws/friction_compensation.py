"""Friction compensation for any law, and hand guiding, which carries a share of the friction.

Compensation adds the torque that friction takes to what the law asks for:

    tau = law + tau_f(dq_ref)    on the reference velocity ("LAW+friction"), or
    tau = law + tau_f(dq)        on the measured velocity ("LAW+friction-measured"),

with tau_f(v) = offset + F_c(v) tanh(v / width) + F_v v, F_c and F_v [N m, N m s/rad] those of the direction of v.

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

Hand guiding
------------
The arm carries its own weight and a share of its friction, and a hand moves it.

    tau = g(q) + share tau_friction(dq) - d B(q) dq

tau_friction is the friction of the arm's file with tanh(dq / width) in place of the sign, on the measured speed: a
reference does not exist here. d is a rate: left alone, every motion fades as exp(-d t).

Stability, in continuous time, rigid: with exact g and B, V = dq^T B dq / 2 has dV/dt = -d dq^T B dq - dq^T
(tau_friction_true - share tau_friction) + dq^T tau_hand. With share at most 1 and friction that is not overestimated
the middle term takes energy out: passive from the hand's torque to the speed of the joints. With share = 1 Coulomb
friction inside the width is compensated only in part, so a touch of `width` speed is needed to feel it fall;
overestimated friction hunts. A payload or tool that the model does not know sinks at the speed that d, B and the
friction left allow.

What takes this away: noise of the measured speed times level / width (take a share below 1, a wider width), sampling
and delay (d T must stay well below 2, and so must share level T / (width B_ii)), torque limits.

Sources: Siciliano et al., Robotics, section 8.5 (gravity compensation); Armstrong-Helouvry, Dupont, Canudas de Wit,
Automatica 30 (1994) (compensation of friction). SI units.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import Annotated, Any

import numpy as np

from lwr_dyn.control.gains import LinearFeedback, diagonal
from lwr_dyn.control.protocol import Controller, Wrapped, describe, layers_of, positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction, smooth_friction, symmetric


def coulomb_friction(arm: Arm, share: float) -> tuple[JointFriction, ...]:
    """Coulomb friction of each joint as a share of its torque limit; raises `OptionError` where one is unknown."""
    if not np.isfinite(arm.effort).all():
        known = f"{arm.name} has no friction of its own, and joints without a torque limit"
        raise OptionError("plant friction", known, "an arm with one of them")
    return tuple(symmetric(share * limit, 0.0) for limit in arm.effort.tolist())


def arm_with_friction(arm: Arm, share: float) -> Arm:
    """The arm with `coulomb_friction` as if its file gave it; raises `OptionError` for an arm that has its own."""
    if arm.has_friction:
        raise OptionError("friction", "a share of the torque limits", f"none: {arm.name} has friction of its own")
    if not (np.isfinite(share) and share > 0.0):
        raise OptionError("friction", share, "a share of the torque limits above 0, as 0.01")
    return replace(arm, friction=coulomb_friction(arm, share))


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
        slope = slope_at_rest(self.torque, len(self.models), self.width)
        return replace(law, velocity=law.velocity - diagonal(slope, len(q)))


def slope_at_rest(friction: Callable[[Array], Array], n: int, width: float) -> Array:
    """Slope (n,) of a smooth friction of n joints over the speed, at rest, by a central difference."""
    v = np.full(n, SLOPE_STEP * width)
    return np.asarray((friction(v) - friction(-v)) / (2 * v))


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

    Raises `MissingDataError`: the arm's friction is unknown and none is given; `ShapeError`: another number of joints;
    `OptionError`: a controller whose friction is compensated already: twice is too much.
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


FADING, SHARE, GUIDING_WIDTH = 1.0, 0.8, 0.02
"""[1/s], 1, [rad/s or m/s]"""


class HandGuiding:
    """The law of this module.

    Parameters
    ----------
    arm : Arm
        As the controller knows it, for its friction.
    dynamics : Dynamics
        The controller's model.
    fading : float
        d [1/s].
    share : float, optional
        Of the friction of the arm's file, 0 to 1; `SHARE` if not given, where the file has friction.
    width : float
        Speed at which the compensation reaches 76 % of its level [rad/s or m/s].

    Raises
    ------
    OptionError
        A fading or width that is not above 0, a share outside 0 to 1.
    MissingDataError
        A share of the friction of an arm whose file has none.
    """

    __slots__ = ("_dynamics", "_friction", "_torque", "fading", "share", "width")

    name = "hand-guiding"
    follows_reference = False

    def __init__(
        self,
        arm: Arm,
        dynamics: Dynamics,
        fading: float = FADING,
        share: float | None = None,
        width: float = GUIDING_WIDTH,
    ) -> None:
        models = arm.friction_models()
        known = any(model is not None for model in models)
        self.fading, self.width = (float(positive_gains(*one, 1)[0]) for one in (("fading", fading), ("width", width)))
        wanted = SHARE * known if share is None else share
        if not (np.isfinite(wanted) and 0.0 <= wanted <= 1.0):
            raise OptionError("share", share, "a number from 0 to 1")
        if wanted > 0.0 and not known:
            raise MissingDataError(arm.name, "friction", "hand-guiding with a share of it")
        self.share, self._dynamics = float(wanted), dynamics
        self._torque = ungated(dynamics).inverse_dynamics
        self._friction = smooth_friction(models, self.width)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        share = f"{self.share:.0%} of the friction compensated" if self.share else "friction not compensated"
        return f"hand guiding, {share}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        return {"fading": self.fading, "share": self.share, "width": self.width}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]; the reference is not looked at."""
        tau: Array = self._torque(q, np.zeros_like(dq), -self.fading * dq)
        return tau + self.share * self._friction(dq) if self.share else tau

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: no spring, and d B less the slope of the compensation at rest."""
        slope = np.diag(self.share * slope_at_rest(self._friction, q.shape[-1], self.width))
        B = self._dynamics.mass_matrix(q)
        return LinearFeedback(np.zeros_like(B), self.fading * B - slope, gravity=self._dynamics)


def tuned_hand_guiding(
    arm: Arm,
    dynamics: Dynamics,
    *,
    fading: Annotated[float, Option(float, "Rate at which a motion left alone fades, 1/s.")] = FADING,
    share: Annotated[float | None, Option(float, "Share of the friction that is compensated, 0 to 1.")] = None,
    width: Annotated[float, Option(float, "Speed at which the compensation sets in, rad/s.")] = GUIDING_WIDTH,
) -> HandGuiding:
    """Hand guiding; raises as `HandGuiding`."""
    return HandGuiding(arm, dynamics, fading, share, width)
