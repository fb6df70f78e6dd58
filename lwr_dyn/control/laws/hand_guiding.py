"""Hand guiding: the arm carries its own weight and a share of its friction, and a hand moves it.

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

from typing import Annotated, Any

import numpy as np

from lwr_dyn.control.linear_feedback import LinearFeedback
from lwr_dyn.control.protocol import positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import smooth_friction

FADING, SHARE, WIDTH = 1.0, 0.8, 0.02
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

    def __init__(
        self, arm: Arm, dynamics: Dynamics, fading: float = FADING, share: float | None = None, width: float = WIDTH
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
        return f"hand guiding, {f'{self.share:.0%} of the friction' if self.share else 'friction'} {self._ending}"

    @property
    def _ending(self) -> str:
        return "compensated" if self.share else "not compensated"

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
        step = 1e-3 * self.width
        ahead, behind = (self._friction(np.full(q.shape[-1], side * step)) for side in (1.0, -1.0))
        slope = np.diag(self.share * (ahead - behind) / (2.0 * step))
        B = self._dynamics.mass_matrix(q)
        return LinearFeedback(np.zeros_like(B), self.fading * B - slope, gravity=self._dynamics)


def tuned_hand_guiding(
    arm: Arm,
    dynamics: Dynamics,
    *,
    fading: Annotated[float, Option(float, "Rate at which a motion left alone fades, 1/s.")] = FADING,
    share: Annotated[float | None, Option(float, "Share of the friction that is compensated, 0 to 1.")] = None,
    width: Annotated[float, Option(float, "Speed at which the compensation sets in, rad/s.")] = WIDTH,
) -> HandGuiding:
    """Hand guiding; raises as `HandGuiding`."""
    return HandGuiding(arm, dynamics, fading, share, width)
