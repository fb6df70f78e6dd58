"""Inverse dynamics, the paper's centralised controller: the model cancels the arm's dynamics, unit masses remain."""

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.gains import OMEGA_N, XI, DampingRatio, NaturalFrequency, second_order_gains
from lwr_dyn.control.linear_feedback import LinearFeedback
from lwr_dyn.control.protocol import positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm


class InverseDynamics:
    """tau = B(q) y + n(q, dq), y = Kp (q_ref - q) + Kd (dq_ref - dq) + ddq_ref, n = C dq + g.

    B y + n is one run of the Newton-Euler recursion with y for the acceleration.

    Parameters
    ----------
    dynamics : Dynamics
        The controller's model.
    Kp, Kd : float or (n,) array_like
        omega_n^2 and 2 xi omega_n of the error equation [1/s^2], [1/s].
    feedforward : bool
        False leaves ddq_ref out, as the paper does ("it was decided to define ddq_d = 0").
    gravity : bool
        False leaves g out of n: under this hypothesis Table VIII of the paper is reproduced.

    Raises
    ------
    ShapeError, OptionError
        Gains of the wrong length, or not positive.

    References
    ----------
    LWR 4+ paper, "Centralized inverse dynamics controller"; Siciliano et al., eqs. 8.56 to 8.60.
    """

    __slots__ = ("Kd", "Kp", "_dynamics", "_gravity", "_torque", "feedforward", "gravity")

    name = "inverse-dynamics"

    def __init__(
        self, dynamics: Dynamics, Kp: ArrayLike, Kd: ArrayLike, feedforward: bool = True, gravity: bool = True
    ) -> None:
        self.Kp = positive_gains("Kp", Kp, dynamics.n)
        self.Kd = positive_gains("Kd", Kd, dynamics.n)
        self.feedforward, self.gravity = feedforward, gravity
        self._dynamics, raw = dynamics, ungated(dynamics)
        self._torque: Callable[[Array, Array, Array], Array] = raw.inverse_dynamics
        self._gravity: Callable[[Array], Array] | None = None if gravity else raw.gravity_vector

    @property
    def label(self) -> str:
        """The controller and its variant."""
        forward = "with feed-forward" if self.feedforward else "without feed-forward (ddq_ref := 0)"
        return f"inverse dynamics {forward}{'' if self.gravity else ', without g'}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        switches = {"feedforward": self.feedforward, "gravity": self.gravity}
        return {"Kp": self.Kp.tolist(), "Kd": self.Kd.tolist()} | switches

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        y = self.Kp * (q_ref - q) + self.Kd * (dq_ref - dq)
        if self.feedforward:
            y += ddq_ref
        tau = self._torque(q, dq, y)
        return tau if self._gravity is None else tau - self._gravity(q)

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: B Kp and B Kd.

        The change of B with q, times the steady error that an unknown load leaves, is left out.
        """
        B = self._dynamics.mass_matrix(q)
        return LinearFeedback(B * self.Kp, B * self.Kd, gravity=self._dynamics if self.gravity else None)


def tuned_inverse_dynamics(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    xi: DampingRatio = XI,
    feedforward: Annotated[bool, Option(bool, "Without ddq_ref, as the paper has it.")] = True,
    gravity: Annotated[bool, Option(bool, "Without g in n.")] = True,
) -> InverseDynamics:
    """Inverse dynamics with omega_n^2 and 2 xi omega_n for gains; raises `OptionError` when they are not positive."""
    unit = second_order_gains(np.ones(arm.n), omega_n, xi)
    return InverseDynamics(dynamics, unit.Kp, unit.Kd, feedforward, gravity)
