"""Joint impedance: every joint a spring and a damper about its reference, the arm's own inertia is kept.

    tau = B(q) ddq_ref + C(q, dq) dq_ref + g(q) + K (q_ref - q) + D(q) (dq_ref - dq)

D(q) = 2 xi Q S Q^T from B = Q Q^T, K = Q S^2 Q^T (`damping_design`): every mode of the arm in this pose is damped by
xi, also where B changes from pose to pose, and no gain of one joint spoils that of another.

Stability, in continuous time, rigid, with the exact model: with e = q_ref - q the storage V = (de^T B de + e^T K e) /
2 has dV/dt = -de^T D de + de^T (-tau_external), so the map from the outer torque to the speed of the error is passive,
also along a moving reference, and without outer torque e goes to 0. With a wrong model g is off and e settles at K^-1
(g - g_model); D stays positive definite. Any passive environment then keeps the loop stable.

What takes this away: sampling (a held spring feeds in about T K dq^2 / 2 of power; 2 xi S T must stay below about 2,
see `lwr-dyn margins`), delay and encoder filters (the same, T grown by them), torque limits (no spring beyond them),
elastic joints (the statement then holds for the motor side alone).

Sources: Paden, Panja, Int. J. Control 47 (1988) (PD+); Hogan, J. Dyn. Sys. Meas. Control 107 (1985) (impedance);
Albu-Schaeffer, Ott, Hirzinger, IJRR 26 (2007) (damping design). SI units.
"""

from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.gains import OMEGA_N, XI, DampingRatio, worst_case_gains
from lwr_dyn.control.laws.damping_design import modes, no_torque_known
from lwr_dyn.control.laws.moving_equilibrium import carried_torque
from lwr_dyn.control.linear_feedback import LinearFeedback, diagonal
from lwr_dyn.control.protocol import positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm

Feedforward = Annotated[bool, Option(bool, "Without B ddq_ref + C dq_ref.")]


class JointImpedance:
    """The law of this module.

    Parameters
    ----------
    dynamics : Dynamics
        The controller's model.
    stiffness : float or (n,) array_like
        K [N m/rad; N/m for a sliding joint].
    xi : float
        Damping ratio of every mode.
    feedforward : bool
        False leaves B ddq_ref + C dq_ref out.

    Raises
    ------
    ShapeError, OptionError
        A stiffness of the wrong length, or a number that is not above 0.
    """

    __slots__ = ("_carried", "_dynamics", "_mass", "_root", "feedforward", "stiffness", "xi")

    name = "joint-impedance"

    def __init__(self, dynamics: Dynamics, stiffness: ArrayLike, xi: float = XI, feedforward: bool = True) -> None:
        self.stiffness = positive_gains("stiffness", stiffness, dynamics.n)
        self.xi = float(positive_gains("xi", xi, 1)[0])
        self.feedforward, self._dynamics = feedforward, dynamics
        self._mass = ungated(dynamics).mass_matrix
        self._carried = carried_torque(dynamics, feedforward)
        self._root = np.sqrt(self.stiffness)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        return f"joint impedance{'' if self.feedforward else ' without feed-forward'}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        return {"stiffness": self.stiffness.tolist(), "xi": self.xi, "feedforward": self.feedforward}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        found = modes(self._mass(q), np.diag(self._root))
        if found is None:
            return no_torque_known(q.size)
        root, joint, _, task = found
        damped = task.dot(self._root * (dq_ref - dq))
        tau = self._carried(q, dq, dq_ref, ddq_ref) + self.stiffness * (q_ref - q)
        tau += root.dot(joint.dot((2.0 * self.xi) * damped))
        return tau

    def damping(self, q: Array) -> Array:
        """D(q) (n, n) [N m s/rad] at one pose q (n,)."""
        found = modes(self._mass(q), np.diag(self._root))
        if found is None:
            return np.full((q.size, q.size), np.nan)
        root, joint, frequency, _ = found
        half = root @ (joint * np.sqrt(2.0 * self.xi * frequency))
        return np.asarray(half @ half.T)

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: K and D(q)."""
        damping = np.array([self.damping(pose) for pose in q])
        return LinearFeedback(diagonal(self.stiffness, len(q)), damping, gravity=self._dynamics)


def tuned_joint_impedance(
    arm: Arm,
    dynamics: Dynamics,
    *,
    stiffness: Annotated[float | None, Option(float, "Stiffness: N m/rad of the joints, N/m of the tip.")] = None,
    omega_n: Annotated[float, Option(float, "Natural frequency, rad/s.", unless="stiffness")] = OMEGA_N,
    xi: DampingRatio = XI,
    feedforward: Feedforward = True,
    inertia: ArrayLike | None = None,
) -> JointImpedance:
    """Joint impedance with one stiffness for all joints, or as `worst_case_gains` gives it (`inertia` as there).

    Raises
    ------
    OptionError, MissingDataError
        A number that is not above 0; no limits to search the worst-case inertia in.
    """
    K = worst_case_gains(arm, omega_n, xi, inertia).Kp if stiffness is None else stiffness
    return JointImpedance(dynamics, K, xi, feedforward)
