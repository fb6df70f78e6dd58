"""Cartesian impedance: the tip is a spring and a damper in space about its reference, the rest of the arm another one.

    tau = B ddq_ref + C dq_ref + g + J^T (K e + D (v_ref - J dq)) + N B (w^2 (q_ref - q) + d (dq_ref - dq))
    e = (p_ref - p, log3(R_ref R^T)),   K = diag(k_x, k_y, k_z, k_r, k_r, k_r),   N = 1 - J^T Jbar^T

in axes of the base, at the arm's flange, or at the tool point of an arm with a tool. The pose p_ref, R_ref and its
speed v_ref are those of the joint reference. D = 2 xi Q S Q^T from Lambda = Q Q^T, K = Q S^2 Q^T (`damping_design`). N
is the dynamically consistent projector: J B^-1 N = 0, so the posture spring (w, d) accelerates the tip in no pose.
Settled, the arm answers a force f at the tip with K e = -f exactly, at any deflection. An arm with six joints has N =
0.

Turning: one stiffness k_r about all axes. Then k_r log3(R_ref R^T) is the gradient of k_r angle^2 / 2; it holds below
half a turn, where log3 jumps.

Singular poses: J^T, Q and N are formed without an inverse, so the torque stays bounded. J_bar exists up to the
singular pose, and N keeps the posture spring out of all six directions of the tip there too, also out of the one that
the arm cannot move in. That direction has no stiffness at the pose itself (J^T f = 0: the joints do not feel such a
force), and a mode slower than `SLOWEST` is damped as one of that frequency, so that it does not coast. Damping shifts
no equilibrium. An inner singularity (wrist, shoulder) keeps the stiffness up to there. At the stretched elbow the
workspace ends: outward no law gives the stiffness.

Stability, in continuous time, rigid, with the exact model, constant reference, w = 0: V = dq^T B dq / 2 + e^T K e / 2
has dV/dt = -dq^T (J^T D J + d N B) dq + v^T f, both matrices positive semidefinite: passive from outer force to speed
of the tip. The posture spring w is projected and no gradient: in a closed motion of the joints it can give energy, d
takes it out again, and nothing is proven with it. Along a moving reference the feed-forward is exact on it and V is
not monotone beside it.

What takes this away: sampling (a held torque takes about omega T / 4 off the damping ratio of a mode of omega rad/s),
delay, encoder filters, torque limits, elastic joints. Dry friction tau_c at rest holds the tip off by up to |Jbar^T
tau_c| / K: a law without friction compensation gives its stiffness only up to that force.

Sources: Khatib, IEEE J. Robotics and Automation 3 (1987) (Jbar, N); Albu-Schaeffer, Ott, Frese, Hirzinger, ICRA 2003
(damping design); Ott, "Cartesian impedance control of redundant and flexible-joint robots", Springer 2008; Paden,
Panja, Int. J. Control 47 (1988) (PD+). SI units.
"""

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.gains import XI, DampingRatio
from lwr_dyn.control.laws.damping_design import Modes, modes, no_torque_known
from lwr_dyn.control.laws.joint_impedance import Feedforward
from lwr_dyn.control.laws.moving_equilibrium import carried_torque
from lwr_dyn.control.linear_feedback import LinearFeedback
from lwr_dyn.control.protocol import positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm

TRANSLATION, ROTATION = 2000.0, 200.0
"""[N/m], [N m/rad]"""
POSTURE = 15.0
"""[rad/s] Natural frequency of the posture spring."""
SLOWEST = 0.1
"""[rad/s] Modes of the tip below it are damped as if they had it."""
TASK = 6
"""Directions of the tip."""


class CartesianImpedance:
    """The law of this module.

    Parameters
    ----------
    arm : Arm
        As the controller knows it; its flange, or tool point, is the tip.
    dynamics : Dynamics
        The controller's model.
    stiffness : float or (3,) array_like
        k_x, k_y, k_z [N/m] along the axes of the base.
    rotation : float
        k_r [N m/rad].
    xi : float
        Damping ratio of every mode of the tip.
    posture : float
        w [rad/s] of the joints that the tip leaves free; 0 for none, which is the passive law.
    posture_damping : float, optional
        d [1/s]; 2 w if not given, or 2 `POSTURE` where w is 0.
    feedforward : bool
        False leaves B ddq_ref + C dq_ref out.

    Raises
    ------
    OptionError
        A number that is not above 0 (`posture`: below 0).
    ShapeError
        A stiffness of another shape.
    MissingDataError
        An arm with fewer than six joints.
    """

    name = "cartesian-impedance"

    def __init__(
        self,
        arm: Arm,
        dynamics: Dynamics,
        stiffness: ArrayLike = TRANSLATION,
        rotation: float = ROTATION,
        xi: float = XI,
        posture: float = POSTURE,
        posture_damping: float | None = None,
        feedforward: bool = True,
    ) -> None:
        from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian, rotation_vector  # a heavy library

        if arm.n < TASK:
            raise MissingDataError(
                arm.name, f"six joints or more (it has {arm.n})", "cartesian-impedance, to hold a pose"
            )
        if not (np.isfinite(posture) and posture >= 0.0):
            raise OptionError("posture", posture, "a number, at least 0")
        turning = positive_gains("rotation", rotation, 1)
        self.stiffness = np.concatenate([positive_gains("stiffness", stiffness, 3), np.repeat(turning, 3)])
        self.xi, self.posture = float(positive_gains("xi", xi, 1)[0]), float(posture)
        damping = 2.0 * (self.posture or POSTURE) if posture_damping is None else posture_damping
        self.posture_damping = float(positive_gains("posture_damping", damping, 1)[0])
        self.feedforward, self._dynamics, self._mass = feedforward, dynamics, ungated(dynamics).mass_matrix
        self._tip: Callable[[Array], tuple[Array, Array]] = flange_and_jacobian(arm)
        self._turn: Callable[[Array], Array] = rotation_vector
        self._carried, self._root = carried_torque(dynamics, feedforward), np.sqrt(self.stiffness)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        left_out = [] if self.feedforward else ["feed-forward"]
        left_out += [] if self.posture else ["posture spring"]
        return f"Cartesian impedance{' without ' if left_out else ''}{' and '.join(left_out)}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        posture = {"posture": self.posture, "posture_damping": self.posture_damping}
        return {"stiffness": self.stiffness.tolist(), "xi": self.xi, **posture, "feedforward": self.feedforward}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        error, late = q_ref - q, dq_ref - dq
        T_ref, J_ref = self._tip(q_ref)
        speed_ref = J_ref.dot(dq_ref)  # before the next call of _tip
        T, J = self._tip(q)
        found = modes(self._mass(q), (self._root[:, None] * J).T)
        if found is None:
            return no_torque_known(q.size)
        root, joint, frequency, task = found
        off = self.offset(T_ref, T)
        along = task.dot(self._root * (speed_ref - J.dot(dq)))
        pull = root.T.dot(self.posture**2 * error + self.posture_damping * late)
        inside = (2.0 * self.xi) * along - joint.T.dot(pull)
        if frequency[-1] < SLOWEST:
            inside += self._extra(frequency) * joint.T.dot(root.T.dot(late))
        tau: Array = self._carried(q, dq, dq_ref, ddq_ref) + J.T.dot(self.stiffness * off)
        tau += root.dot(pull + joint.dot(inside))
        return tau

    def offset(self, T_ref: Array, T: Array) -> Array:
        """e (6,) [m, rad] from poses (4, 4): the way and the turn from T to T_ref, in axes of the base."""
        e = np.empty(TASK)
        e[:3] = T_ref[:3, 3] - T[:3, 3]
        e[3:] = self._turn(T_ref[:3, :3].dot(T[:3, :3].T))
        return e

    def _extra(self, frequency: Array) -> Array:
        """What the damping of modes slower than `SLOWEST` is raised by [1/s]."""
        return 2.0 * self.xi * np.maximum(SLOWEST - frequency, 0.0)

    def at(self, q: Array) -> tuple[Modes, Array] | None:
        """The modes at one pose q (n,) and J (6, n); None where the model's B is not positive definite."""
        J = self._tip(q)[1].copy()
        found = modes(self._mass(q), (self._root[:, None] * J).T)
        return None if found is None else (found, J)

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: J^T K J + w^2 N B and J^T D J + d N B."""
        position, velocity = np.full((2, len(q), q.shape[-1], q.shape[-1]), np.nan)
        for k, pose in enumerate(q):
            found = self.at(pose)
            if found is None:
                continue
            (root, joint, frequency, _), J = found
            free = root @ (np.eye(pose.size) - joint @ joint.T) @ root.T
            damped = 2.0 * self.xi * frequency + self._extra(frequency)
            position[k] = J.T @ (self.stiffness[:, None] * J) + self.posture**2 * free
            velocity[k] = root @ (joint * damped) @ (root @ joint).T + self.posture_damping * free
        return LinearFeedback(position, velocity, gravity=self._dynamics)


def tuned_cartesian_impedance(
    arm: Arm,
    dynamics: Dynamics,
    *,
    stiffness: Annotated[float, Option(float, "Stiffness: N m/rad of the joints, N/m of the tip.")] = TRANSLATION,
    rotation: Annotated[float, Option(float, "Stiffness of the tip's turn, N m/rad.")] = ROTATION,
    xi: DampingRatio = XI,
    posture: Annotated[float, Option(float, "Natural frequency of the posture spring, rad/s; 0: none.")] = POSTURE,
    feedforward: Feedforward = True,
) -> CartesianImpedance:
    """Cartesian impedance; raises as `CartesianImpedance`."""
    return CartesianImpedance(arm, dynamics, stiffness, rotation, xi, posture, feedforward=feedforward)
